/* mpi_migrate.c - particles that leave the box of a process come to the process that owns their cell, with all their
   fields bit for bit, by direct messages and by DMSwarmMigrate alike: near and far, over several boxes, through
   periodic faces, all into one box and out again. What each process must hold is known beforehand, since every process
   can compute where every particle is. Runs on any number of processes: mpiexec -n 6 mpi_migrate */
#include "kernels/cell.h"
#include "parallel/exchange.h"
#include "unit.h"
#include "unit_particles.h"

#define ROUNDS 10

/* A scene: shape of the grid, method, and the fields that particles have. */
typedef struct {
  int       dim;
  PetscInt  cells[3], n; /* particles */
  PetscBool periodic[3];
  MPMBasis  basis;
  MPMNeeds  needs;
} Case;

static MPMKind kinds[UNIT_KINDS];
static long    moved, migrations, far; /* particles that changed process, in how many steps; over 2 boxes */

static double Fraction(PetscInt64 id, int round, int what)
{
  return (double)(UnitMix((uint64_t)id, (uint64_t)round, (uint64_t)what + 99) >> 11) * 0x1p-53;
}

/* Where particle id is after a round; every process finds the same. The particles of a round go to no other place (0),
   to cells nearby (1), anywhere (2), all to one corner (3), to the cells at the faces (4). */
static void Position(const MPMGrid *g, PetscInt64 id, int round, PetscReal x[])
{
  static const int order[] = {2, 1, 0, 2, 3, 2, 4, 1, 3, 3, 4}; /* of rounds 0, 1, ... */

  for (PetscInt d = 0; d < g->dim; d++) {
    const PetscReal u = Fraction(id, round, (int)d), length = g->upper[d] - g->lower[d];

    switch (order[round]) {
    case 0: /* where it was */
      Position(g, id, round - 1, x);
      return;
    case 1: { /* up to two cells away, between the walls */
      PetscReal before[3];

      Position(g, id, round - 1, before);
      x[d] = before[d] + (4 * u - 2) * g->h[d];
      if (g->periodic[d] && x[d] < g->lower[d]) x[d] += length;
      if (g->periodic[d] && x[d] >= g->upper[d]) x[d] -= length;
      break;
    }
    case 3: /* one of two opposite corners */
      x[d] = (round % 2 ? g->lower[d] : g->upper[d] - g->h[d]) + u * g->h[d];
      break;
    case 4: /* near the faces */
      x[d] = (u < 0.5 ? g->lower[d] : g->upper[d] - 1.5 * g->h[d]) + (u < 0.5 ? u : u - 0.5) * 3 * g->h[d];
      break;
    default:
      x[d] = g->lower[d] + u * length;
    }
    x[d] = PetscMax(g->lower[d], PetscMin(x[d], g->upper[d]));
    if (g->periodic[d] && x[d] >= g->upper[d]) x[d] = g->lower[d];
  }
}

/* The cell of the patch where the particle is after a round, or MPM_ELSEWHERE. */
static PetscInt CellOf(const MPMCore *core, PetscInt64 id, int round)
{
  const MPMPatch *patch = &core->exchange.patch;
  PetscReal       x[3], xi[3];
  PetscInt        base[3] = {0}, at[3] = {0};

  Position(&core->grid, id, round, x);
  CHECK(MPMLocate((int)core->grid.dim, core->basis, &core->grid, 0, x, kinds[0].l, xi, base));
  for (PetscInt d = 0; d < core->grid.dim; d++) {
    at[d] = base[d] - patch->own_lo[d];
    if (at[d] < 0 || at[d] >= patch->own_n[d]) return MPM_ELSEWHERE;
  }
  return MPMTileCell((int)core->grid.dim, &patch->tiles, at);
}

/* Writes position and all other fields of the particles here, as they are after a round. */
static PetscErrorCode Write(MPMCore *core, int round)
{
  MPMParticles *particles = &core->particles;
  PetscInt64   *id;
  MPMView       view;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(particles->n, &id));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id) | MPM_BIT(x), &view));
  for (PetscInt p = 0; p < view.n; p++) {
    id[p] = view.id[p];
    Position(&core->grid, id[p], round, view.x + p * core->grid.dim);
  }
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id) | MPM_BIT(x), &view));
  PetscCall(UnitRows(particles, id, round, MPM_SCRATCH, PETSC_FALSE));
  PetscCall(PetscFree(id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A run of the case: its particles, those that lie in the box of this process, before the first round. */
static PetscErrorCode Create(const Case *c, PetscBool direct, MPMCore *core)
{
  MPMHistogram h;
  PetscInt64   first;
  uint64_t     ids = 0;
  PetscInt     n   = 0;
  PetscMPIInt  size, rank;
  MPMView      view;

  PetscFunctionBeginUser;
  memset(core, 0, sizeof *core);
  core->comm            = PETSC_COMM_WORLD;
  core->print.comm      = PETSC_COMM_WORLD;
  core->exchange.type   = &MPMExchange_spatial;
  core->exchange.data   = MPI_COMM_NULL;
  core->exchange.direct = direct;
  core->basis           = c->basis;
  core->needs           = c->needs;
  core->params.kinds    = kinds;
  core->params.nkinds   = UNIT_KINDS;
  core->grid.dim        = c->dim;
  for (int d = 0; d < 3; d++) {
    core->grid.cells[d]      = d < c->dim ? c->cells[d] : 0;
    core->grid.h[d]          = 0.25;
    core->grid.lower[d]      = -1;
    core->grid.upper[d]      = -1 + 0.25 * (PetscReal)core->grid.cells[d];
    core->grid.periodic[d]   = d < c->dim ? c->periodic[d] : PETSC_FALSE;
    core->grid.wall_basis[d] = core->grid.periodic[d] ? MPM_WALL_BASIS_NONE : MPM_WALL_BASIS_EXTRAP;
  }
  MPMGridSetNodes(&core->grid, core->basis);
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  CHECK_EQ(MPMPartitionLargest(&core->grid, core->basis, size), size);
  PetscCall(MPMTimersCreate(&core->timers));
  PetscCall(MPMParticlesLayout(&core->particles, c->dim, &core->needs));
  PetscCall(MPMHistogramCreate(&core->grid, core->basis, core->comm, &h));
  for (first = rank; first < c->n; first += size) { /* each process counts some */
    PetscReal x[3], xi[3];
    PetscInt  base[3] = {0};

    Position(&core->grid, first, 0, x);
    CHECK(MPMLocate(c->dim, core->basis, &core->grid, 0, x, kinds[0].l, xi, base));
    for (int d = 0; d < c->dim; d++) base[d] += core->grid.layers[d];
    PetscCall(MPMHistogramAdd(&h, base, 1));
  }
  PetscCall(MPMHistogramFinish(&h));
  if (!rank) CHECK_EQ(h.table[(h.n[0] + 1) * (h.n[1] + 1) * (h.n[2] + 1) - 1], c->n); /* all have come */
  core->exchange.partition.costs = (MPMCosts){.particle = 1, .node = 0.1, .ghost = 0.1, .neighbour = 1};
  PetscCall(core->exchange.type->setup(core, &h));
  PetscCall(MPMHistogramDestroy(&h));
  PetscCall(MPMParticlesCreate(&core->particles, core->exchange.data));
  for (PetscInt64 id = 0; id < c->n; id++) n += CellOf(core, id, 0) >= 0;
  PetscCall(MPMParticlesSetSize(&core->particles, n));
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id), &view));
  n = 0;
  for (PetscInt64 id = 0; id < c->n; id++) {
    ids += MPMParticleHash(id);
    if (CellOf(core, id, 0) >= 0) view.id[n++] = id;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id), &view));
  core->particles.total = c->n;
  core->particles.ids   = (PetscInt64)ids;
  PetscCall(Write(core, 0));
  PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(core->exchange.type->finish(core));
  PetscCall(MPMParticlesDestroy(&core->particles));
  PetscCall(MPMTimersDestroy(&core->timers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves the particles here to where they are after the round, as a step does, up to its reduction and the settling. */
static PetscErrorCode Move(MPMCore *core, int round)
{
  MPMParticles *particles = &core->particles;
  PetscInt      longest   = 0; /* way, in boxes */
  MPMView       view;

  PetscFunctionBeginUser;
  MPMStatusReset(&core->status);
  PetscCall(Write(core, round));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  particles->nmovers = 0;
  for (PetscInt q = 0; q < view.n; q++) {
    const PetscInt p = particles->order[q], cell = CellOf(core, view.id[p], round);

    if (cell == view.cell[p]) continue;
    view.cell[p]                            = cell;
    particles->movers[particles->nmovers++] = cell < 0 ? MPM_FLAGGED(q) : q;
    core->status.moved++;
    core->status.left += cell < 0;
  }
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  PetscCall(core->exchange.type->reduce(core, &core->status));
  for (PetscInt d = 0; d < core->grid.dim; d++) { /* through a periodic face, if that is the shorter way */
    const PetscInt p = core->exchange.partition.p[d];

    longest = PetscMax(longest, core->grid.periodic[d] ? p / 2 : p - 1);
  }
  CHECK_LE(core->status.hops, longest);
  PetscCall(core->exchange.type->settle(core, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* This process holds the particles whose cells it owns and no others; in the order of (cell, id), with all fields that
   travel. */
static PetscErrorCode CheckHome(MPMCore *core, const Case *c, int round)
{
  MPMParticles *particles = &core->particles;
  PetscInt64   *id;
  PetscInt      n = 0, all;
  int          *seen;
  MPMView       view;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(c->n, &seen));
  PetscCall(PetscMalloc1(particles->n, &id));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell), &view));
  for (PetscInt64 k = 0; k < c->n; k++) n += CellOf(core, k, round) >= 0;
  CHECK_EQ(view.n, n);
  for (PetscInt q = 0; q < view.n; q++) {
    const PetscInt p = particles->order[q];
    PetscInt64     k;
    PetscReal      x[3] = {0};

    CHECK(p >= 0 && p < view.n);
    if (p < 0 || p >= view.n) continue;
    k = view.id[p];
    CHECK(k >= 0 && k < c->n);
    if (k < 0 || k >= c->n) continue;
    CHECK_EQ(seen[k], 0); /* none is here twice */
    seen[k] = 1;
    CHECK_EQ(view.cell[p], CellOf(core, k, round));
    Position(&core->grid, k, round, x);
    CHECK_SAME(view.x + p * c->dim, x, (size_t)c->dim * sizeof(PetscReal));
    if (q) {
      const PetscInt before = particles->order[q - 1];

      CHECK(view.cell[before] < view.cell[p] || (view.cell[before] == view.cell[p] && view.id[before] < view.id[p]));
    }
  }
  for (PetscInt p = 0; p < view.n; p++) id[p] = view.id[p];
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell), &view));
  PetscCall(UnitRows(particles, id, round, MPM_SWARM, PETSC_TRUE));
  PetscCallMPI(MPI_Allreduce(&n, &all, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  CHECK_EQ(all, c->n); /* every particle has one owner */
  PetscCall(PetscFree(seen));
  PetscCall(PetscFree(id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Both ways: the same particles in the same order, with the same bits. */
static PetscErrorCode CheckSame(MPMCore *a, MPMCore *b)
{
  PetscInt64 digest[2];

  PetscFunctionBeginUser;
  CHECK_EQ(a->particles.n, b->particles.n);
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt bytes = a->particles.bytes[f];
    void          *one, *two;

    if (!a->particles.present[f] || MPMFields[f].home == MPM_SCRATCH) continue;
    PetscCall(MPMParticlesGetField(&a->particles, f, &one));
    PetscCall(MPMParticlesGetField(&b->particles, f, &two));
    for (PetscInt q = 0; q < PetscMin(a->particles.n, b->particles.n); q++)
      CHECK_SAME((char *)one + a->particles.order[q] * bytes, (char *)two + b->particles.order[q] * bytes,
                 (size_t)bytes);
    PetscCall(MPMParticlesRestoreField(&a->particles, f));
    PetscCall(MPMParticlesRestoreField(&b->particles, f));
  }
  CHECK(a->status.left == b->status.left && a->status.hops == b->status.hops && a->status.moved == b->status.moved);
  PetscCall(MPMParticlesDigest(&a->particles, PETSC_COMM_WORLD, &digest[0]));
  PetscCall(MPMParticlesDigest(&b->particles, PETSC_COMM_WORLD, &digest[1]));
  CHECK_EQ(digest[0], digest[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(const Case *c, PetscMPIInt rank)
{
  static MPMCore core[2]; /* by DMSwarmMigrate, by direct messages */
  char           what[128];

  PetscFunctionBeginUser;
  (void)snprintf(what, sizeof what, "process %d, %d-D, %dx%dx%d cells, periodic %d%d%d, basis %d, %d particles", rank,
                 c->dim, (int)c->cells[0], (int)c->cells[1], (int)c->cells[2], (int)c->periodic[0], (int)c->periodic[1],
                 (int)c->periodic[2], (int)c->basis, (int)c->n);
  for (int direct = 0; direct < 2; direct++) {
    UnitContext("%s, %s, start", what, direct ? "direct" : "swarm");
    PetscCall(Create(c, direct ? PETSC_TRUE : PETSC_FALSE, &core[direct]));
    PetscCall(CheckHome(&core[direct], c, 0));
  }
  for (int round = 1; round <= ROUNDS; round++) {
    for (int direct = 0; direct < 2; direct++) {
      UnitContext("%s, %s, round %d", what, direct ? "direct" : "swarm", round);
      PetscCall(Move(&core[direct], round));
      PetscCall(CheckHome(&core[direct], c, round));
    }
    UnitContext("%s, both ways, round %d", what, round);
    PetscCall(CheckSame(&core[0], &core[1]));
    moved += (long)core[1].status.left;
    migrations += core[1].status.left > 0;
    far += core[1].status.hops > 1;
  }
  for (int direct = 0; direct < 2; direct++) PetscCall(Destroy(&core[direct]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscMPIInt rank, size;

  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  for (int k = 0; k < UNIT_KINDS; k++) kinds[k] = (MPMKind){.m = 1, .V0 = 1, .l = {0.25, 0.25, 0.25}};
  for (int dim = 1; dim <= 3; dim++)
    for (int shape = 0; shape < 6; shape++) { /* long and thin grids are cut into rows of boxes: several to go */
      Case c = {.dim = dim, .basis = (MPMBasis)(shape % MPM_NUM_BASES), .n = shape == 5 ? 3 : 200 + 100 * dim};

      for (int d = 0; d < 3; d++) {
        c.cells[d]    = shape % dim == d ? 40 : dim == 2 || shape % 2 ? 14 : 9;
        c.periodic[d] = shape >> d & 1 ? PETSC_TRUE : PETSC_FALSE;
      }
      c.needs = UnitNeeds();
      if (c.basis == MPM_BASIS_gimp) c.needs.stretched = PETSC_FALSE; /* half-widths are read there: no random bits */
      PetscCall(Run(&c, rank));
    }
  UnitContext("process %d, what was tested", rank);
  if (size > 1) {
    CHECK_GE(moved, 10000);
    CHECK_GE(migrations, 100);
    if (size > 4) CHECK_GE(far, 20);
    if (!rank)
      printf("%ld particles changed process in %ld steps, %ld of these over 2 boxes or more\n", moved, migrations, far);
  }
  PetscCall(PetscFinalize());
  return UnitEnd();
}
