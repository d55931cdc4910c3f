/* unit_partition.c - how the grid is cut: the histogram sums what was counted; a partition covers every node once, with
   cuts at edges of tiles; its heaviest part of each axis is as light as that of the best of all cuts, and its process
   grid as cheap as the best of all; the costs are those of the boxes counted one by one; the largest number of processes
   is that of a search through all; and a migration costs the messages that it has. */
#include "cost/cost.h"
#include "kernels/tile_index.h"
#include "parallel/partition.h"
#include "unit.h"

#define MAX_BINS  4000
#define MAX_PARTS 64

static MPMGrid      grid;
static MPMBasis     basis;
static MPMHistogram h;
static PetscInt     bins[3], edge;   /* of the test's own count */
static PetscInt64   count[MAX_BINS]; /* particles of each bin */

static void MakeGrid(int dim, const PetscInt most[3], PetscInt least)
{
  basis = (MPMBasis)UnitInt(MPM_NUM_BASES);
  memset(&grid, 0, sizeof grid);
  grid.dim = dim;
  for (int d = 0; d < 3; d++) {
    grid.cells[d]      = d < dim ? least + UnitInt((int)(most[d] - least + 1)) : 0;
    grid.h[d]          = 1;
    grid.upper[d]      = (PetscReal)grid.cells[d];
    grid.periodic[d]   = d < dim && UnitInt(3) == 0 ? PETSC_TRUE : PETSC_FALSE;
    grid.wall_basis[d] = grid.periodic[d] ? MPM_WALL_BASIS_NONE : MPM_WALL_BASIS_EXTRAP;
  }
  MPMGridSetNodes(&grid, basis);
  edge = MPMTileEdge(basis);
  for (int d = 0; d < 3; d++) bins[d] = PetscMax(1, grid.nodes[d] / edge);
}

static PetscInt Bin(PetscInt i, PetscInt j, PetscInt k)
{
  return (k * bins[1] + j) * bins[0] + i;
}

/* Particles of bins [lo, hi), and bins with particles, one by one. */
static PetscInt64 Sum(const PetscInt lo[3], const PetscInt hi[3], PetscInt64 *occupied)
{
  PetscInt64 sum = 0;

  *occupied = 0;
  for (PetscInt k = lo[2]; k < hi[2]; k++)
    for (PetscInt j = lo[1]; j < hi[1]; j++)
      for (PetscInt i = lo[0]; i < hi[0]; i++) {
        sum += count[Bin(i, j, k)];
        *occupied += count[Bin(i, j, k)] > 0;
      }
  return sum;
}

/* A histogram of n particles that lie in a part of the grid, and the test's own. */
static PetscErrorCode MakeHistogram(int n)
{
  PetscInt lo[3] = {0}, len[3] = {1, 1, 1};

  PetscFunctionBeginUser;
  memset(count, 0, sizeof count);
  PetscCall(MPMHistogramCreate(&grid, basis, PETSC_COMM_SELF, &h));
  for (int d = 0; d < grid.dim; d++) {
    const PetscInt most = grid.nodes[d] - (grid.periodic[d] ? 0 : MPMBasisNodes(basis) - 1);

    lo[d]  = UnitInt((int)most);
    len[d] = 1 + UnitInt((int)(most - lo[d]));
  }
  for (int k = 0; k < n; k++) {
    const PetscInt base[3] = {lo[0] + UnitInt((int)len[0]), lo[1] + UnitInt((int)len[1]), lo[2] + UnitInt((int)len[2])};
    const PetscInt64 many  = UnitInt(10) ? 1 + UnitInt(8) : (PetscInt64)5000000000;
    PetscInt         at[3];

    for (int d = 0; d < 3; d++) at[d] = PetscMin(base[d] / edge, bins[d] - 1);
    count[Bin(at[0], at[1], at[2])] += n < 50 ? 1 : many;
    PetscCall(MPMHistogramAdd(&h, base, n < 50 ? 1 : many));
  }
  PetscCall(MPMHistogramFinish(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The tables hold the sums below each bin. */
static void CheckHistogram(void)
{
  const PetscInt zero[3] = {0};

  for (int d = 0; d < 3; d++) CHECK(h.n[d] == bins[d] && h.nodes[d] == grid.nodes[d]);
  CHECK_EQ(h.coarse, edge);
  CHECK_EQ(h.stencil, MPMBasisNodes(basis));
  for (PetscInt k = 0; k <= bins[2]; k++)
    for (PetscInt j = 0; j <= bins[1]; j++)
      for (PetscInt i = 0; i <= bins[0]; i++) {
        const PetscInt hi[3] = {i, j, k}, at = (k * (bins[1] + 1) + j) * (bins[0] + 1) + i;
        PetscInt64     occupied, sum         = Sum(zero, hi, &occupied);

        CHECK_EQ(h.table[at], sum);
        CHECK_EQ(h.occupied[at], occupied);
      }
}

/* ---- Boxes of a partition */

static PetscReal Volume(void)
{
  return PetscPowReal((PetscReal)edge, (PetscReal)grid.dim);
}

/* The bins of box ijk. */
static void Box(const MPMPartition *part, const PetscInt ijk[3], PetscInt lo[3], PetscInt hi[3])
{
  for (int d = 0; d < 3; d++) {
    PetscInt at = 0;

    for (PetscInt r = 0; r < ijk[d]; r++) at += part->l[d][r];
    lo[d] = at / edge;
    hi[d] = ijk[d] == part->p[d] - 1 ? bins[d] : (at + part->l[d][ijk[d]]) / edge;
  }
}

/* Every node in one part of each axis, cut at edges of tiles. */
static void CheckCover(const MPMPartition *part, PetscInt size)
{
  CHECK_EQ(part->p[0] * part->p[1] * part->p[2], size);
  for (int d = 0; d < 3; d++) {
    PetscInt at = 0;

    CHECK(part->p[d] >= 1 && (d < grid.dim || part->p[d] == 1));
    for (PetscInt r = 0; r < part->p[d]; r++) {
      CHECK(part->l[d][r] > 0);
      CHECK_EQ(at % edge, 0);
      at += part->l[d][r];
      if (size > 1) CHECK(part->l[d][r] >= PetscMin(edge, grid.nodes[d]));
    }
    CHECK_EQ(at, grid.nodes[d]);
  }
}

/* Largest cost of a box that this one number of MPMCosts makes, all boxes counted one by one; and the imbalance. */
static void CheckCost(const MPMPartition *chosen)
{
  MPMPartition part      = *chosen;
  PetscReal    particles = 0, nodes = 0, ghosts = 0, neighbours = 0;
  PetscInt64   all = 0;

  for (PetscInt b = 0; b < part.p[0] * part.p[1] * part.p[2]; b++) {
    const PetscInt ijk[3] = {b % part.p[0], b / part.p[0] % part.p[1], b / (part.p[0] * part.p[1])};
    PetscInt       lo[3], hi[3];
    PetscInt64     occupied, with, n;
    int            beside = -1; /* itself */

    Box(&part, ijk, lo, hi);
    n = Sum(lo, hi, &occupied);
    all += n;
    particles = PetscMax(particles, (PetscReal)n);
    nodes     = PetscMax(nodes, Volume() * (PetscReal)occupied);
    for (int o = 0; o < 27; o++) {
      const PetscInt to[3] = {ijk[0] + o % 3 - 1, ijk[1] + o / 3 % 3 - 1, ijk[2] + o / 9 - 1};

      beside += to[0] >= 0 && to[0] < part.p[0] && to[1] >= 0 && to[1] < part.p[1] && to[2] >= 0 && to[2] < part.p[2];
    }
    neighbours = PetscMax(neighbours, 0.5 * beside);
    for (int d = 0; d < grid.dim; d++) lo[d] = PetscMax(0, lo[d] - 1);
    (void)Sum(lo, hi, &with);
    ghosts = PetscMax(ghosts, Volume() * (PetscReal)(with - occupied) * (MPMBasisNodes(basis) - 1) / (PetscReal)edge);
  }
  for (int k = 0; k < 5; k++) {
    const PetscReal expected[] = {particles, nodes, ghosts, neighbours, 1};

    part.costs = (MPMCosts){.particle = k == 0, .node = k == 1, .ghost = k == 2, .neighbour = k == 3, .fixed = k == 4};
    CHECK_NEAR(MPMPartitionCost(&h, &part), expected[k], 1e-14 * (1 + expected[k]));
    if (all)
      CHECK_NEAR(part.imbalance, particles * (part.p[0] * part.p[1] * part.p[2]) / (PetscReal)all, 1e-12);
    else
      CHECK_EQ(part.imbalance, 1);
  }
}

/* ---- All cuts of an axis, and all process grids */

/* The weight of bins from .. to-1 of axis d; costs NULL: the bins. */
static PetscReal Weigh(int d, PetscInt from, PetscInt to, const MPMCosts *costs)
{
  PetscInt   lo[3] = {0}, hi[3] = {bins[0], bins[1], bins[2]};
  PetscInt64 occupied, n;

  if (!costs) return (PetscReal)(to - from);
  lo[d] = from;
  hi[d] = to;
  n     = Sum(lo, hi, &occupied);
  return costs->particle * (PetscReal)n + costs->node * Volume() * (PetscReal)occupied;
}

/* The least that the heaviest of p parts of axis d can weigh: dynamic programming over all cuts. */
static PetscReal Lightest(int d, PetscInt p, const MPMCosts *costs)
{
  static PetscReal least[MAX_PARTS + 1][MAX_BINS];

  for (PetscInt r = 0; r <= p; r++)
    for (PetscInt n = 0; n <= bins[d]; n++) least[r][n] = r || n ? PETSC_MAX_REAL : 0;
  for (PetscInt r = 1; r <= p; r++)
    for (PetscInt n = r; n <= bins[d]; n++)
      for (PetscInt m = r - 1; m < n; m++)
        if (least[r - 1][m] < PETSC_MAX_REAL)
          least[r][n] = PetscMin(least[r][n], PetscMax(least[r - 1][m], Weigh(d, m, n, costs)));
  return least[p][bins[d]];
}

/* What the heaviest part of axis d weighs. */
static PetscReal Heaviest(const MPMPartition *part, int d, const MPMCosts *costs)
{
  PetscReal heaviest = 0;

  for (PetscInt r = 0; r < part->p[d]; r++) {
    PetscInt ijk[3] = {0}, lo[3], hi[3];

    ijk[d] = r;
    Box(part, ijk, lo, hi);
    heaviest = PetscMax(heaviest, Weigh(d, lo[d], hi[d], costs));
  }
  return heaviest;
}

/* Cuts axis d of `part` in every way from part r on, bins from `at` on. Of those cuts whose heaviest part is the
   lightest, the dearest step is left in *dearest. After the last axis the step is priced. */
static void AllCuts(MPMPartition *part, int d, PetscInt r, PetscInt at, const PetscReal lightest[3], PetscReal *dearest)
{
  if (d == 3) {
    *dearest = PetscMax(*dearest, MPMPartitionCost(&h, part));
    return;
  }
  for (PetscInt to = at + 1; to <= bins[d] - (part->p[d] - 1 - r); to++) {
    if (r == part->p[d] - 1) to = bins[d];
    if (Weigh(d, at, to, &part->costs) > lightest[d] * (1 + 1e-9)) return;
    part->l[d][r] = (to == bins[d] ? grid.nodes[d] : to * edge) - at * edge;
    if (r == part->p[d] - 1)
      AllCuts(part, d + 1, 0, 0, lightest, dearest);
    else
      AllCuts(part, d, r + 1, to, lightest, dearest);
  }
}

/* Does the process grid fit? */
static int Fits(PetscInt px, PetscInt py, PetscInt pz)
{
  return px <= bins[0] && py <= bins[1] && pz <= bins[2];
}

static PetscReal Surface(const PetscInt p[3])
{
  PetscReal s = 0;

  for (int d = 0; d < grid.dim; d++) {
    PetscReal area = (PetscReal)(p[d] - 1);

    for (int e = 0; e < grid.dim; e++) area *= e == d ? 1 : (PetscReal)grid.nodes[e];
    s += area;
  }
  return s;
}

/* A partition for `size` processes against all process grids, with all cuts of each where `all`. */
static PetscErrorCode CheckChosen(PetscInt size, MPMBalance balance, int all)
{
  PetscInt       l[3][MAX_PARTS], grids = 0;
  MPMPartition   part  = {.costs = {.fixed     = UnitReal(0, 1),
                                    .particle  = UnitReal(0.1, 1),
                                    .ghost     = UnitReal(0, 0.1),
                                    .node      = UnitReal(0.01, 0.1),
                                    .neighbour = UnitReal(0, 0.1)}};
  MPMPartition   trial = {.l = {l[0], l[1], l[2]}, .costs = part.costs};
  PetscReal      best = PETSC_MAX_REAL, compact = PETSC_MAX_REAL;
  PetscErrorCode code;

  PetscFunctionBeginUser;
  for (PetscInt pz = 1; pz <= size; pz++)
    for (PetscInt py = 1; py * pz <= size; py++) {
      const PetscInt px      = size / (py * pz);
      PetscReal      dearest = 0, lightest[3];
      const PetscInt p[3]    = {px, py, pz};

      if (px * py * pz != size || !Fits(px, py, pz)) continue;
      grids++;
      compact = PetscMin(compact, Surface(p));
      for (int d = 0; d < 3 && all; d++) {
        trial.p[d]  = p[d];
        lightest[d] = Lightest(d, p[d], &part.costs);
      }
      if (all) AllCuts(&trial, 0, 0, 0, lightest, &dearest);
      if (all) best = PetscMin(best, dearest);
    }
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = MPMPartitionChoose(&h, (PetscMPIInt)size, balance, &part);
  PetscCall(PetscPopErrorHandler());
  CHECK_EQ(code, grids ? PETSC_SUCCESS : PETSC_ERR_ARG_SIZ);
  if (code) {
    PetscCall(MPMPartitionDestroy(&part));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  CheckCover(&part, size);
  CheckCost(&part);
  for (int d = 0; d < 3; d++) {
    const MPMCosts *costs = balance == MPM_BALANCE_none ? NULL : &part.costs;
    const PetscReal least = Lightest(d, part.p[d], costs);

    CHECK_NEAR(Heaviest(&part, d, costs), least, 1e-9 * least); /* found by bisection */
  }
  if (balance == MPM_BALANCE_none)
    CHECK_EQ(Surface(part.p), compact);
  else if (all) /* cuts across x and y count up to 5 % dearer than they are */
    CHECK_LE(part.predicted, 1.05 * best * (1 + 1e-9));
  {
    const PetscReal imbalance = part.imbalance;

    CHECK_EQ(MPMPartitionCost(&h, &part), part.predicted);
    CHECK_EQ(part.imbalance, imbalance);
  }
  PetscCall(MPMPartitionShare(&part, PETSC_COMM_SELF));
  CheckCover(&part, size);
  PetscCall(MPMPartitionDestroy(&part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest number of processes up to `size` by a search through all process grids. */
static PetscInt Largest(PetscInt size)
{
  for (PetscInt n = size; n > 1; n--)
    for (PetscInt pz = 1; pz <= n; pz++)
      for (PetscInt py = 1; py <= n; py++)
        for (PetscInt px = 1; px <= n; px++)
          if (px * py * pz == n && Fits(px, py, pz)) return n;
  return 1;
}

static PetscErrorCode Whole(void)
{
  MPMPartition part = {.p = {0}};

  PetscFunctionBeginUser;
  PetscCall(MPMPartitionWhole(&grid, &part));
  CheckCover(&part, 1);
  for (int d = 0; d < 3; d++) CHECK(part.p[d] == 1 && part.l[d][0] == grid.nodes[d]);
  CHECK_EQ(part.imbalance, 1);
  PetscCall(MPMPartitionDestroy(&part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Context(const char *what, int n)
{
  UnitContext("%s, basis %d, %dx%dx%d nodes, %d", what, (int)basis, (int)grid.nodes[0], (int)grid.nodes[1],
              (int)grid.nodes[2], n);
}

/* A grid of more bins than there is memory for has larger ones, of whole tiles. */
static PetscErrorCode Coarse(void)
{
  const PetscInt  base[3] = {999, 500, 3};
  PetscInt64      all     = 0;
  MPMPartition    part    = {.costs = {.particle = 1}};
  static MPMGrid  large   = {.dim = 3, .cells = {999, 799, 801}, .h = {1, 1, 1}};
  const PetscInt *n       = h.n;

  PetscFunctionBeginUser;
  grid  = large;
  basis = MPM_BASIS_linear;
  edge  = MPMTileEdge(basis);
  MPMGridSetNodes(&grid, basis);
  Context("coarse bins", 0);
  PetscCall(MPMHistogramCreate(&grid, basis, PETSC_COMM_SELF, &h));
  CHECK(h.coarse > edge && h.coarse % edge == 0 && (h.coarse & (h.coarse - 1)) == 0);
  CHECK_LE((PetscReal)n[0] * (PetscReal)n[1] * (PetscReal)n[2], 1 << 21);
  for (int d = 0; d < 3; d++) CHECK_EQ(n[d], grid.nodes[d] / h.coarse);
  for (int k = 0; k < 1000; k++) {
    const PetscInt at[3] = {base[0] - UnitInt(900), base[1] - UnitInt(300), base[2] + UnitInt(700)};

    PetscCall(MPMHistogramAdd(&h, at, 3));
    all += 3;
  }
  PetscCall(MPMHistogramFinish(&h));
  CHECK_EQ(h.table[(n[0] + 1) * (n[1] + 1) * (n[2] + 1) - 1], all);
  PetscCall(MPMPartitionChoose(&h, 12, MPM_BALANCE_start, &part));
  CheckCover(&part, 12);
  for (int d = 0; d < 3; d++)
    for (PetscInt r = 0; r < part.p[d] - 1; r++) CHECK_EQ(part.l[d][r] % h.coarse, 0);
  CHECK(part.imbalance >= 1 && part.imbalance < 1.3);
  PetscCall(MPMPartitionDestroy(&part));
  PetscCall(MPMHistogramDestroy(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A call of DMSwarmMigrate has 14 collectives, each with a stage for each doubling of the processes, and 5 numbers of 4 B
   of each process, 3 on more than 1024; direct migration has messages along each axis. */
static void Migration(void)
{
  const MPMModel m = {.reduction = 1e-3, .wire = 1e-6, .message = 2e-3, .post = 1e-4};

  UnitContext("migration");
  CHECK_NEAR(MPMModelMigrationMessages(&m, PETSC_FALSE, 2, 4), 14 * 2e-3 + 5 * 4 * 4e-6, 1e-12);
  CHECK_NEAR(MPMModelMigrationMessages(&m, PETSC_FALSE, 2, 2048), 14 * 11e-3 + 3 * 4 * 2048e-6, 1e-12);
  for (int p = 4; p < 4096; p *= 8) CHECK_NEAR(MPMModelMigrationMessages(&m, PETSC_TRUE, 2, p), 2 * 2.1e-3, 1e-12);
}

int main(int argc, char **argv)
{
  static const PetscInt small[3][3] = {{60, 0, 0}, {24, 20, 0}, {14, 10, 12}},
                        large[3][3] = {{400, 0, 0}, {90, 70, 0}, {40, 24, 30}};

  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  Migration();
  for (int dim = 1; dim <= 3; dim++)
    for (int round = 0; round < 120; round++) {
      MakeGrid(dim, small[dim - 1], 4);
      Context("histogram, round", round);
      PetscCall(MakeHistogram(round % 4 == 0 ? 0 : round % 4 == 1 ? UnitInt(40) : 300));
      CheckHistogram();
      PetscCall(Whole());
      for (PetscInt size = 1; size <= 8; size++) {
        Context("small, processes", (int)size);
        PetscCall(CheckChosen(size, MPM_BALANCE_start, bins[0] <= 9 && bins[1] <= 9 && bins[2] <= 9 && round % 4));
        PetscCall(CheckChosen(size, MPM_BALANCE_none, 0));
        CHECK_EQ(MPMPartitionLargest(&grid, basis, size), Largest(size));
      }
      PetscCall(MPMHistogramDestroy(&h));
    }
  for (int dim = 1; dim <= 3; dim++)
    for (int round = 0; round < 8; round++) {
      MakeGrid(dim, large[dim - 1], 20);
      PetscCall(MakeHistogram(2000));
      CheckHistogram();
      for (int k = 0; k < 4; k++) {
        const PetscInt size = 1 + UnitInt(MAX_PARTS);

        Context("large, processes", (int)size);
        PetscCall(CheckChosen(size, k % 2 ? MPM_BALANCE_start : MPM_BALANCE_auto, 0));
        CHECK_EQ(MPMPartitionLargest(&grid, basis, size), Largest(size));
      }
      PetscCall(MPMHistogramDestroy(&h));
    }
  PetscCall(Coarse());
  PetscCall(PetscFinalize());
  return UnitEnd();
}
