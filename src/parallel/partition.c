/* partition.c - how the grid is cut into boxes, one for each process.

   Bodies fill a part of the grid, so with equal boxes some processes have nothing to do: two disks on 32 processes cost
   3.9 times the mean. Here every process grid px x py x pz (strips included) is tried. Each axis is cut at edges of
   tiles so that the largest cost of a part is as small as it can be, and the process grid with the shortest predicted
   step is taken. The input is a histogram of the particles over the nodes, which the first process has; it sends its
   choice to the others. docs/model.md has the model. */
#include "kernels/tile_index.h"
#include "parallel/partition.h"

#define MPM_MAX_BINS      ((PetscInt)1 << 21)
#define MPM_TAG_HISTOGRAM 3 /* differs from the tags of spatial.h */

/* Sets the size of bins: that of a tile, or a multiple of it if there would be too many. A bin covers `coarse` nodes
   along each axis; the last one also covers the remainder. */
static void LayOut(const MPMGrid *grid, MPMBasis basis, MPMHistogram *h)
{
  PetscReal bins = PETSC_MAX_REAL;

  h->dim     = grid->dim;
  h->stencil = MPMBasisNodes(basis);
  for (h->coarse = MPMTileEdge(basis); bins > MPM_MAX_BINS; h->coarse *= 2) {
    bins = 1;
    for (PetscInt d = 0; d < 3; d++) {
      h->nodes[d] = grid->nodes[d];
      h->n[d]     = PetscMax(1, h->nodes[d] / h->coarse);
      bins *= h->n[d];
    }
    if (bins <= MPM_MAX_BINS) break;
  }
}

/* The place of bin (i, j, k) in the tables. */
static PetscInt Index(const MPMHistogram *h, PetscInt i, PetscInt j, PetscInt k)
{
  return (k * (h->n[1] + 1) + j) * (h->n[0] + 1) + i;
}

static PetscInt Entries(const MPMHistogram *h)
{
  return Index(h, h->n[0], h->n[1], h->n[2]) + 1;
}

/* Makes an empty histogram, to which the processes of comm add particles. Not collective. */
PetscErrorCode MPMHistogramCreate(const MPMGrid *grid, MPMBasis basis, MPI_Comm comm, MPMHistogram *h)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(h, sizeof *h));
  LayOut(grid, basis, h);
  h->comm = comm;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(Entries(h), &h->table));
  PetscCall(PetscCalloc1(Entries(h), &h->occupied));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the arrays of a histogram. Not collective. */
PetscErrorCode MPMHistogramDestroy(MPMHistogram *h)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(h->table));
  PetscCall(PetscFree(h->occupied));
  PetscCall(PetscFree(h->list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt64 *Entry(const MPMHistogram *h, PetscInt64 *table, PetscInt i, PetscInt j, PetscInt k)
{
  return table + Index(h, i, j, k);
}

/* Makes the list large enough for n items. */
static PetscErrorCode Room(MPMHistogram *h, PetscInt n)
{
  PetscInt64 *more;

  PetscFunctionBeginUser;
  if (n <= h->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  h->capacity = PetscMax(n, h->capacity + h->capacity / 2 + 64);
  PetscCall(PetscMalloc1(2 * h->capacity, &more));
  PetscCall(PetscArraycpy(more, h->list, 2 * h->listed));
  PetscCall(PetscFree(h->list));
  h->list = more;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts particles whose stencils start at node `base` [dim] (from 0, layers included). Particles that follow each
   other are mostly in the same bin, so a list has far fewer items than there are particles. Not collective; to be
   called before MPMHistogramFinish. */
PetscErrorCode MPMHistogramAdd(MPMHistogram *h, const PetscInt base[], PetscInt64 particles)
{
  PetscInt b[3] = {0}, entry;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < h->dim; d++) b[d] = PetscMin(base[d] / h->coarse, h->n[d] - 1);
  entry = Index(h, b[0] + 1, b[1] + 1, b[2] + 1);
  if (h->table)
    h->table[entry] += particles;
  else if (h->listed && h->list[2 * h->listed - 2] == entry)
    h->list[2 * h->listed - 1] += particles;
  else {
    PetscCall(Room(h, h->listed + 1));
    h->list[2 * h->listed]       = entry;
    h->list[2 * h->listed++ + 1] = particles;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Turns the numbers in the bins into the summed-area table. */
static void Accumulate(const MPMHistogram *h, PetscInt64 *table)
{
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt k = d == 2; k <= h->n[2]; k++)
      for (PetscInt j = d == 1; j <= h->n[1]; j++)
        for (PetscInt i = d == 0; i <= h->n[0]; i++)
          *Entry(h, table, i, j, k) += *Entry(h, table, i - (d == 0), j - (d == 1), k - (d == 2));
}

/* Adds up what all processes have counted, and turns it into summed-area tables on the first process. Collective on the
   histogram's comm. */
PetscErrorCode MPMHistogramFinish(MPMHistogram *h)
{
  PetscMPIInt size, rank, n;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(h->comm, &size));
  PetscCallMPI(MPI_Comm_rank(h->comm, &rank));
  if (rank) {
    PetscCall(PetscMPIIntCast(2 * h->listed, &n));
    PetscCallMPI(MPI_Send(h->list, n, MPIU_INT64, 0, MPM_TAG_HISTOGRAM, h->comm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscMPIInt r = 1; r < size; r++) { /* one after the other: all lists together may be long */
    MPI_Status status;

    PetscCallMPI(MPI_Probe(r, MPM_TAG_HISTOGRAM, h->comm, &status));
    PetscCallMPI(MPI_Get_count(&status, MPIU_INT64, &n));
    PetscCall(Room(h, n / 2));
    PetscCallMPI(MPI_Recv(h->list, n, MPIU_INT64, r, MPM_TAG_HISTOGRAM, h->comm, MPI_STATUS_IGNORE));
    for (PetscMPIInt k = 0; k < n; k += 2) h->table[h->list[k]] += h->list[k + 1];
  }
  for (PetscInt i = 0; i < Entries(h); i++) h->occupied[i] = h->table[i] > 0;
  Accumulate(h, h->table);
  Accumulate(h, h->occupied);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the sum of a table (particles, or bins with particles) over the box of bins [lo, hi). */
static PetscInt64 Count(const MPMHistogram *h, PetscInt64 *table, const PetscInt lo[3], const PetscInt hi[3])
{
  PetscInt64 sum = 0;

  for (int corner = 0; corner < 8; corner++) {
    const PetscInt i = corner & 1 ? lo[0] : hi[0], j = corner & 2 ? lo[1] : hi[1], k = corner & 4 ? lo[2] : hi[2];

    sum += ((corner ^ (corner >> 1) ^ (corner >> 2)) & 1 ? -1 : 1) * *Entry(h, table, i, j, k);
  }
  return sum;
}

/* Is there a bin for every process on each axis? */
static PetscBool Fits(const MPMHistogram *h, const PetscInt p[3])
{
  for (PetscInt d = 0; d < 3; d++)
    if (p[d] > h->n[d]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns the number of nodes that the particles of a box of bins touch: those of the bins with particles. */
static PetscReal Nodes(const MPMHistogram *h, const PetscInt lo[3], const PetscInt hi[3])
{
  return PetscPowReal((PetscReal)h->coarse, (PetscReal)h->dim) * (PetscReal)Count(h, h->occupied, lo, hi);
}

/* Returns the weight of a box of bins, in which the parts of an axis are made equal: the cost of its particles and
   nodes in s, or, if costs is NULL, its number of bins along axis d. */
static PetscReal Weight(const MPMHistogram *h, PetscInt d, const MPMCosts *costs, const PetscInt lo[3],
                        const PetscInt hi[3])
{
  return costs ? costs->particle * (PetscReal)Count(h, h->table, lo, hi) + costs->node * Nodes(h, lo, hi)
               : hi[d] - lo[d];
}

/* Fills the parts of axis d from below, each with as many bins as weigh at most `most`, and writes their widths in
   nodes to part->l[d]. Returns whether all bins have a place. */
static PetscBool FillParts(const MPMHistogram *h, PetscInt d, const MPMCosts *costs, PetscReal most, MPMPartition *part)
{
  const PetscInt p     = part->p[d];
  PetscInt       lo[3] = {0, 0, 0}, hi[3] = {h->n[0], h->n[1], h->n[2]};

  for (PetscInt r = 0; r < p; r++) {
    const PetscInt last = h->n[d] - (p - 1 - r); /* the parts above need a bin each */

    hi[d] = lo[d] + 1;
    if (Weight(h, d, costs, lo, hi) > most) return PETSC_FALSE;
    while (hi[d]++ < last && Weight(h, d, costs, lo, hi) <= most) continue;
    hi[d]--;
    part->l[d][r] = (r == p - 1 ? h->nodes[d] : hi[d] * h->coarse) - lo[d] * h->coarse;
    lo[d]         = hi[d];
  }
  return lo[d] == h->n[d];
}

/* Cuts axis d into p[d] parts so that the largest weight of a part is as small as it can be; bisection finds it. */
static void CutAxis(const MPMHistogram *h, PetscInt d, PetscBool weighted, MPMPartition *part)
{
  const MPMCosts *costs = weighted ? &part->costs : NULL;
  const PetscInt  lo[3] = {0, 0, 0};
  PetscReal       above = Weight(h, d, costs, lo, h->n), below = 0;

  for (int k = 0; k < 40; k++) {
    const PetscReal middle = 0.5 * (below + above);

    if (FillParts(h, d, costs, middle, part))
      above = middle;
    else
      below = middle;
  }
  (void)FillParts(h, d, costs, above, part);
}

/* Sets what of a share crosses its cuts in a step in which the fastest particle moves by `moved` cells. At the cuts
   lies a layer of `layer` cells, one cell deep, with per_cell particles in each. They lie in a = per_cell^(1/dim) rows,
   and a row crosses a cut as a whole, in one step out of 1/(a moved). All processes wait for a process that sends a
   row, so a step takes as long if one row crosses as if one crosses every cut of the axis. crossing is that of this
   process alone. */
void MPMShareCross(PetscInt dim, PetscReal layer, PetscReal per_cell, PetscReal moved, MPMShare *s)
{
  const PetscReal rows = PetscPowReal(per_cell, 1 / (PetscReal)dim);

  s->crossing = layer * per_cell * moved;
  s->row      = rows > 0 ? layer * per_cell / rows : 0;
  s->waits    = 1 - PetscPowReal(1 - PetscMin(1, rows * moved), s->cuts / PetscMax(1, s->axes));
}

/* Returns the predicted seconds of a step, those of the slowest process, and sets part->worst to its share, and
   part->imbalance. Of the migration, only the leavers depend on the cuts. Their cost is half way between that of
   particles which cross one by one and that of rows for which all processes wait (MPMShareCross), since it is unknown
   how long particles will stay in rows. Not collective: only the process that has the tables calls it. */
PetscReal MPMPartitionCost(const MPMHistogram *h, MPMPartition *part)
{
  const MPMCosts *c     = &part->costs;
  PetscReal       worst = PETSC_MIN_REAL;
  PetscInt64      most  = 0, all;
  PetscInt        lo[3], hi[3], zero[3] = {0}, at[3];

  all = Count(h, h->table, zero, h->n);
  for (PetscInt k = at[2] = 0; k < part->p[2]; at[2] += part->l[2][k++])
    for (PetscInt j = at[1] = 0; j < part->p[1]; at[1] += part->l[1][j++])
      for (PetscInt i = at[0] = 0; i < part->p[0]; at[0] += part->l[0][i++]) {
        const PetscInt ijk[3] = {i, j, k};
        MPMShare       s      = {0};
        PetscInt       around = 1;
        PetscReal      t;

        for (PetscInt d = 0; d < 3; d++) {
          const PetscInt to = at[d] + part->l[d][ijk[d]];

          lo[d] = at[d] / h->coarse;
          hi[d] = ijk[d] == part->p[d] - 1 ? h->n[d] : to / h->coarse;
          around *= 1 + (ijk[d] > 0) + (ijk[d] < part->p[d] - 1);
        }
        for (PetscInt d = 0; d < 3; d++) {
          s.axes += part->p[d] > 1;
          s.cuts += (PetscReal)(part->p[d] - 1);
        }
        s.neighbours = 0.5 * (PetscReal)(around - 1);
        s.particles  = (PetscReal)Count(h, h->table, lo, hi);
        s.nodes      = Nodes(h, lo, hi);
        for (PetscInt d = 0; d < h->dim; d++) lo[d] = PetscMax(0, lo[d] - 1);
        s.ghosts = (Nodes(h, lo, hi) - s.nodes) * (PetscReal)(h->stencil - 1) / (PetscReal)h->coarse;
        most     = PetscMax(most, (PetscInt64)s.particles);
        MPMShareCross(h->dim, s.ghosts / (PetscReal)(h->stencil - 1), s.particles / PetscMax(1, s.nodes), c->moved, &s);
        t = c->fixed + c->particle * s.particles + c->ghost * s.ghosts + c->node * s.nodes +
            c->neighbour * s.neighbours + c->leaver * 0.5 * (s.crossing + s.row * s.waits);
        if (t <= worst) continue;
        worst       = t;
        part->worst = s;
      }
  part->imbalance = all ? (PetscReal)most * (part->p[0] * part->p[1] * part->p[2]) / (PetscReal)all : 1;
  return worst;
}

/* Sets the partition of a grid that is not cut: one box. Not collective. */
PetscErrorCode MPMPartitionWhole(const MPMGrid *grid, MPMPartition *part)
{
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    part->p[d] = 1;
    PetscCall(PetscMalloc1(1, &part->l[d]));
    part->l[d][0] = grid->nodes[d];
  }
  part->imbalance = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the partition that the first process of comm has chosen to all others. Collective on comm. */
PetscErrorCode MPMPartitionShare(MPMPartition *part, MPI_Comm comm)
{
  PetscInt *l[3] = {part->l[0], part->l[1], part->l[2]};

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(part, (PetscMPIInt)sizeof *part, MPI_BYTE, 0, comm));
  for (PetscInt d = 0; d < 3; d++) {
    part->l[d] = l[d];
    if (!l[d]) PetscCall(PetscMalloc1(part->p[d], &part->l[d]));
    PetscCallMPI(MPI_Bcast(part->l[d], (PetscMPIInt)part->p[d], MPIU_INT, 0, comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the widths of the parts. Not collective. */
PetscErrorCode MPMPartitionDestroy(MPMPartition *part)
{
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(part->l[d]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the area of all cuts of a process grid in nodes: the most compact boxes have the smallest. */
static PetscReal Surface(const MPMHistogram *h, const PetscInt p[3])
{
  PetscReal s = 0;

  for (PetscInt d = 0; d < h->dim; d++) {
    PetscReal area = p[d] - 1;
    for (PetscInt e = 0; e < h->dim; e++) area *= e == d ? 1 : h->nodes[e];
    s += area;
  }
  return s;
}

/* Returns the factor by which cuts across x, and across y, lengthen a step beyond the model: particles are sorted along
   x first and along z last, so the tiles at such a cut, whose sums are kept, have short runs of particles. On two
   processes a cut across x made the step 3 % (linear, 2-D) to 9 % (quadratic, 3-D) longer than one across the last
   axis; the factor is smaller than that, so that the balance of particles is not given up for it. */
static PetscReal Across(const PetscInt p[3])
{
  return 1 + 0.04 * (1 - 1 / (PetscReal)p[0]) + 0.01 * (1 - 1 / (PetscReal)p[1]);
}

/* Chooses the partition for `size` processes: for MPM_BALANCE_none the most compact process grid, with equal parts;
   else the one with the shortest predicted step, times the factor for cuts across x and y. Fails with PETSC_ERR_ARG_SIZ
   if none fits (callers ask MPMPartitionLargest first). Not collective: only the process that has the histogram's
   tables calls it. */
PetscErrorCode MPMPartitionChoose(const MPMHistogram *h, PetscMPIInt size, MPMBalance balance, MPMPartition *best)
{
  MPMPartition trial  = {.costs = best->costs};
  PetscReal    lowest = PETSC_MAX_REAL;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    PetscCall(PetscMalloc1(size, &trial.l[d]));
    PetscCall(PetscMalloc1(size, &best->l[d]));
  }
  for (trial.p[2] = 1; trial.p[2] <= size; trial.p[2]++)
    for (trial.p[1] = 1; trial.p[1] * trial.p[2] <= size; trial.p[1]++) {
      PetscReal cost;

      trial.p[0] = size / (trial.p[1] * trial.p[2]);
      if (trial.p[0] * trial.p[1] * trial.p[2] != size || !Fits(h, trial.p)) continue;
      for (PetscInt d = 0; d < 3; d++) CutAxis(h, d, !(balance == MPM_BALANCE_none), &trial);
      trial.predicted = MPMPartitionCost(h, &trial);
      cost            = balance == MPM_BALANCE_none ? Surface(h, trial.p) : trial.predicted * Across(trial.p);
      if (cost >= lowest) continue;
      lowest          = cost;
      best->predicted = trial.predicted;
      best->imbalance = trial.imbalance;
      best->worst     = trial.worst;
      for (PetscInt d = 0; d < 3; d++) {
        best->p[d] = trial.p[d];
        PetscCall(PetscArraycpy(best->l[d], trial.l[d], trial.p[d]));
      }
    }
  PetscCall(MPMPartitionDestroy(&trial));
  PetscCheck(lowest < PETSC_MAX_REAL, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ,
             "no process grid of %d fits %" PetscInt_FMT "x%" PetscInt_FMT "x%" PetscInt_FMT " nodes", size,
             h->nodes[0], h->nodes[1], h->nodes[2]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the largest number of boxes, up to `size`, into which the grid can be cut. Not collective. */
PetscInt MPMPartitionLargest(const MPMGrid *grid, MPMBasis basis, PetscInt size)
{
  MPMHistogram h;
  PetscInt     p[3];

  LayOut(grid, basis, &h);
  for (; size > 1; size--)
    for (p[2] = 1; p[2] <= PetscMin(size, h.n[2]); p[2]++)
      for (p[1] = 1; p[1] <= h.n[1] && p[1] * p[2] <= size; p[1]++) {
        p[0] = size / (p[1] * p[2]);
        if (p[0] * p[1] * p[2] == size && Fits(&h, p)) return size;
      }
  return 1;
}
