/* unit_order.c - the order of particles: what merging movers into the order before gives is what a sort from nothing
   gives, in 1 to 3 dimensions, for particles that change their cell, leave the patch, come from others and take the
   places of those that left; with empty cells and rows. The storage is put in order without a field getting lost or
   going to another particle, and MPMParticlesLeavers lists those that left and no others. The fields stay where they are
   in memory while three times as many particles come as ever came at once, and there are as many places as are counted
   after many have left. */
#if defined(__linux__)
#include <malloc.h>
#else
#define malloc_usable_size(rows) INFINITY /* not known */
#endif
#include "kernels/cell.h"
#include "particles/box.h"
#include "unit.h"
#include "unit_particles.h"

#define MOST      600 /* particles */
#define MAX_CELLS 20000
#define SCENES    150 /* patches of each dimension */
#define STEPS     25  /* of each */

typedef struct {
  PetscInt64 id;
  PetscInt   cell;
} Particle;

static Particle stored[2 * MOST]; /* [n] what the storage has to hold, place by place */
static PetscInt n, ncells, nown, own[MAX_CELLS];
static long     merges, sorts, reorders, turned, migrations; /* that were seen; turned: the first is not in row 0 */

static MPMGrid      grid;
static MPMPatch     patch;
static MPMParticles particles;
static MPMKind      kinds[UNIT_KINDS];

/* A grid of random size and a box of it, cut at edges of tiles, that is the patch. */
static PetscErrorCode MakePatch(int dim)
{
  static const PetscInt most[3] = {90, 24, 12};
  const MPMBasis        basis   = (MPMBasis)UnitInt(MPM_NUM_BASES);
  const PetscInt        edge = MPMTileEdge(basis), reach = MPMBasisNodes(basis) - 1;

  PetscFunctionBeginUser;
  memset(&grid, 0, sizeof grid);
  memset(&patch, 0, sizeof patch);
  grid.dim = dim;
  for (int d = 0; d < 3; d++) {
    grid.cells[d]      = d < dim ? 4 + UnitInt((int)most[dim - 1] - 4) : 0;
    grid.lower[d]      = UnitReal(-1, 1);
    grid.h[d]          = d < dim ? UnitReal(0.1, 1) : 1;
    grid.upper[d]      = grid.lower[d] + grid.cells[d] * grid.h[d];
    grid.periodic[d]   = d < dim && UnitInt(3) == 0 ? PETSC_TRUE : PETSC_FALSE;
    grid.wall_basis[d] = grid.periodic[d] ? MPM_WALL_BASIS_NONE : MPM_WALL_BASIS_EXTRAP;
  }
  MPMGridSetNodes(&grid, basis);
  patch.grid  = &grid;
  patch.basis = basis;
  for (int d = 0; d < 3; d++) {
    const PetscInt tiles = PetscMax(1, grid.nodes[d] / edge), first = UnitInt((int)tiles);
    const PetscInt last = first + 1 + UnitInt((int)(tiles - first));

    patch.own_lo[d] = first * edge - grid.layers[d];
    patch.own_n[d]  = (last == tiles ? grid.nodes[d] : last * edge) - first * edge;
    patch.lo[d]     = d < dim ? patch.own_lo[d] - reach : 0;
    patch.n[d]      = d < dim ? patch.own_n[d] + 2 * reach : 1;
  }
  PetscCall(MPMTilesSetUp(&patch, PETSC_FALSE));
  ncells = MPMTilesCells(&patch);
  CHECK_LE(ncells, MAX_CELLS);
  nown = 0;
  for (PetscInt k = 0; k < patch.own_n[2]; k++)
    for (PetscInt j = 0; j < patch.own_n[1]; j++)
      for (PetscInt i = 0; i < patch.own_n[0]; i++) {
        const PetscInt at[3] = {i, j, k};

        own[nown++] = MPMTileCell(dim, &patch.tiles, at);
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A cell of the patch: any, one of the first, or always the same. */
static PetscInt Cell(int where)
{
  return own[where == 0 ? UnitInt((int)nown) : where == 1 ? UnitInt((int)PetscMin(nown, 6)) : nown / 2];
}

static Particle Another(int where)
{
  static PetscInt64 numbers = 0;

  numbers++; /* no two are the same, and they come in no order; half of them lie close together */
  return (Particle){.id   = numbers % 4 < 2 ? numbers ^ 0x2a5
                                            : (PetscInt64)(UnitMix((uint64_t)numbers, 7, 7) >> 24 << 24) + numbers,
                    .cell = Cell(where)};
}

static int ByCellAndId(const void *a, const void *b)
{
  const Particle *p = (const Particle *)a, *q = (const Particle *)b;

  if (p->cell != q->cell) return p->cell < q->cell ? -1 : 1;
  return p->id < q->id ? -1 : p->id > q->id;
}

/* Writes what `stored` says to the particles of the program. */
static PetscErrorCode Store(void)
{
  PetscInt64 id[2 * MOST];
  MPMView    view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesSetSize(&particles, n));
  PetscCall(MPMParticlesGetView(&particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  for (PetscInt p = 0; p < n; p++) {
    view.id[p] = id[p] = stored[p].id;
    view.cell[p]       = stored[p].cell;
  }
  PetscCall(MPMParticlesRestoreView(&particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  PetscCall(UnitRows(&particles, id, 0, MPM_SCRATCH, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After a sort: the order, where each cell begins in it, and that every row is still that of its particle. The storage
   may have been put in order: `stored` follows. */
static PetscErrorCode CheckOrder(void)
{
  static Particle sorted[2 * MOST];
  PetscInt64      id[2 * MOST];
  PetscInt        q = 0, moved = 0, jumps = 0, before = 0;
  MPMView         view;

  PetscFunctionBeginUser;
  memcpy(sorted, stored, sizeof sorted);
  qsort(sorted, (size_t)n, sizeof sorted[0], ByCellAndId);
  CHECK_EQ(particles.n, n);
  CHECK_EQ(particles.nkept, n);
  CHECK_EQ(particles.nmovers, -1);
  PetscCall(MPMParticlesGetView(&particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  for (PetscInt p = 0; p < n; p++) {
    const PetscInt at = particles.order[p];

    CHECK(at >= 0 && at < n);
    if (at < 0 || at >= n) break;
    CHECK_EQ(view.id[at], sorted[p].id); /* numbers are distinct, so the order is a permutation */
    CHECK_EQ(view.cell[at], sorted[p].cell);
    jumps += at != (p ? (before + 1) % n : at);
    before = at;
  }
  for (PetscInt c = 0; c <= ncells; c++) {
    while (q < n && sorted[q].cell < c) q++;
    CHECK_EQ(particles.start[c], q);
    CHECK_EQ(particles.incoming[c], 0); /* as the next merge needs it */
  }
  for (PetscInt p = 0; p < n; p++) {
    moved += view.id[p] != stored[p].id;
    stored[p] = (Particle){.id = id[p] = view.id[p], .cell = view.cell[p]};
  }
  PetscCall(MPMParticlesRestoreView(&particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  if (moved) {
    reorders++;
    turned += particles.order[0] > 0;
    CHECK_EQ(jumps, 0); /* the storage is in order, from some row on and around its end */
    CHECK_EQ(particles.scattered, 0);
  }
  PetscCall(UnitRows(&particles, id, 0, MPM_SCRATCH, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Some particles change their cell or leave, as a commit notes it. */
static PetscErrorCode Commit(double moves, double leaves, int where)
{
  MPMView view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&particles, MPM_BIT(cell), &view));
  particles.nmovers = 0;
  for (PetscInt q = 0; q < n; q++) {
    const PetscInt p  = particles.order[q];
    PetscInt       to = UnitReal(0, 1) < moves ? Cell(where) : stored[p].cell;

    if (UnitReal(0, 1) < leaves) to = MPM_ELSEWHERE;
    if (to == stored[p].cell) continue;
    particles.movers[particles.nmovers++] = to < 0 ? MPM_FLAGGED(q) : q;
    view.cell[p] = stored[p].cell = to;
  }
  PetscCall(MPMParticlesRestoreView(&particles, MPM_BIT(cell), &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The list of leavers, by the movers and, where these are not known, by the cells. */
static PetscErrorCode CheckLeavers(PetscInt *nleavers, PetscInt leaver[])
{
  const PetscInt nmovers = particles.nmovers;

  PetscFunctionBeginUser;
  *nleavers = 0;
  for (PetscInt p = 0; p < n; p++)
    if (stored[p].cell < 0) leaver[(*nleavers)++] = p;
  for (int known = 0; known < 2; known++) {
    PetscInt nlisted, *listed;

    particles.nmovers = known ? nmovers : -1;
    PetscCall(MPMParticlesLeavers(&particles, &nlisted, &listed));
    CHECK_EQ(nlisted, *nleavers);
    for (PetscInt k = 0; k < PetscMin(nlisted, *nleavers); k++) CHECK_EQ(listed[k], leaver[k]);
    PetscCall(PetscFree(listed));
  }
  particles.nmovers = nmovers;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the leavers out and adds `come` others, in one of the two ways of migrate.c: others take the places of leavers
   first (direct), or all come behind the last; places that are left over are filled from the end. */
static void Migrate(PetscInt nleavers, const PetscInt leaver[], PetscInt come, int direct, int where)
{
  PetscInt filled = 0;

  for (; direct && filled < PetscMin(come, nleavers); filled++) stored[leaver[filled]] = Another(where);
  for (PetscInt k = nleavers; k > filled; k--) stored[leaver[k - 1]] = stored[--n];
  for (; filled < come; filled++) stored[n++] = Another(where);
  particles.nkept -= nleavers;
  migrations += nleavers + come > 0;
}

static PetscErrorCode Step(void)
{
  static const double part[] = {0, 0.02, 0.3, 1};
  PetscInt            leaver[2 * MOST], nleavers, come = 0;
  const int           where = UnitInt(3);

  PetscFunctionBeginUser;
  PetscCall(Commit(part[UnitInt(4)], UnitInt(2) ? 0 : 0.4 * part[UnitInt(4)] * part[1 + UnitInt(3)], where));
  PetscCall(CheckLeavers(&nleavers, leaver));
  switch (UnitInt(4)) {
  case 0:
    come = nleavers;
    break;
  case 1:
    come = UnitInt(4);
    break;
  case 2:
    come = UnitInt(60);
    break;
  default:
    break;
  }
  Migrate(nleavers, leaver, PetscMin(come, MOST - n + nleavers), UnitInt(2), UnitInt(3));
  PetscCall(Store());
  if (!UnitInt(10)) particles.nmovers = -1; /* movers are not known */
  *(particles.nmovers < 0 ? &sorts : &merges) += 1;
  PetscCall(MPMParticlesSort(&particles, &patch));
  PetscCall(CheckOrder());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Particles anywhere in the patch are found in their cells; one in another patch is an error. */
static PetscErrorCode Locate(int dim)
{
  MPMView        view;
  PetscErrorCode code;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&particles, MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind), &view));
  for (PetscInt p = 0; p < n; p++) {
    PetscReal xi[3], *x = view.x + p * dim;
    PetscInt  base[3], at[3];
    int       mine = 0;

    while (!mine) {
      mine = 1;
      for (int d = 0; d < dim; d++) {
        x[d] = grid.lower[d] +
               UnitReal((double)patch.own_lo[d], (double)(patch.own_lo[d] + patch.own_n[d] + 2)) * grid.h[d];
        if (!(x[d] >= grid.lower[d] && x[d] <= grid.upper[d])) mine = 0;
      }
      if (!mine) continue;
      CHECK(MPMLocate(dim, patch.basis, &grid, 0, x, MPMHalfWidths(dim, kinds, &view, p), xi, base));
      for (int d = 0; d < dim; d++) {
        at[d] = base[d] - patch.own_lo[d];
        if (at[d] < 0 || at[d] >= patch.own_n[d]) mine = 0;
      }
    }
    stored[p].cell = MPMTileCell(dim, &patch.tiles, at);
    view.cell[p]   = -1;
  }
  PetscCall(MPMParticlesRestoreView(&particles, MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind), &view));
  PetscCall(MPMParticlesLocate(&particles, &patch, kinds));
  PetscCall(CheckOrder());
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesGetView(&particles, MPM_BIT(x), &view));
  view.x[UnitInt((int)n) * dim] = UnitInt(2) ? grid.upper[0] + grid.h[0] : NAN;
  PetscCall(MPMParticlesRestoreView(&particles, MPM_BIT(x), &view));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = MPMParticlesLocate(&particles, &patch, kinds);
  PetscCall(PetscPopErrorHandler());
  CHECK_EQ(code, PETSC_ERR_PLIB);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a storage without particles. */
static PetscErrorCode Create(int dim, const MPMNeeds *needs)
{
  PetscFunctionBeginUser;
  memset(&particles, 0, sizeof particles);
  PetscCall(MPMParticlesLayout(&particles, dim, needs));
  PetscCall(MPMParticlesCreate(&particles, PETSC_COMM_SELF));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Scene(int dim, int scene)
{
  static const int sizes[] = {0, 1, 2, 17, 100, 400};
  const int        where   = UnitInt(3);
  MPMNeeds         needs   = UnitNeeds();

  PetscFunctionBeginUser;
  PetscCall(MakePatch(dim));
  UnitContext("scene %d of %d-D, basis %d, %d cells", scene, dim, (int)patch.basis, (int)ncells);
  if (patch.basis == MPM_BASIS_gimp) needs.stretched = PETSC_FALSE; /* half-widths are read there: no random bits */
  PetscCall(Create(dim, &needs));
  for (n = 0; n < sizes[scene % 6];) stored[n++] = Another(where);
  PetscCall(Store());
  particles.nmovers = -1;
  PetscCall(MPMParticlesSort(&particles, &patch));
  PetscCall(CheckOrder());
  for (int step = 0; step < STEPS; step++) {
    UnitContext("scene %d of %d-D, basis %d, %d cells, step %d", scene, dim, (int)patch.basis, (int)ncells, step);
    PetscCall(Step());
  }
  UnitContext("scene %d of %d-D, basis %d, particles located", scene, dim, (int)patch.basis);
  PetscCall(Locate(dim));
  PetscCall(MPMParticlesDestroy(&particles));
  PetscCall(MPMTilesDestroy(&patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields stay in their place in memory when particles come; spare places are at most an eighth, and given back. */
static PetscErrorCode Grow(void)
{
  const PetscInt first = 4000, come = 100;
  MPMNeeds       needs = UnitNeeds();
  void          *rows, *now;

  PetscFunctionBeginUser;
  UnitContext("arrivals");
  PetscCall(Create(2, &needs));
  particles.room = come;
  PetscCall(MPMParticlesSetSize(&particles, first));
  PetscCall(MPMParticlesGetField(&particles, MPM_FIELD_INDEX_x, &rows));
  PetscCall(MPMParticlesRestoreField(&particles, MPM_FIELD_INDEX_x));
  for (PetscInt k = 1; k <= 3; k++) {
    PetscCall(MPMParticlesSetSize(&particles, first + k * come));
    PetscCall(MPMParticlesGetField(&particles, MPM_FIELD_INDEX_x, &now));
    PetscCall(MPMParticlesRestoreField(&particles, MPM_FIELD_INDEX_x));
    CHECK(now == rows);
    CHECK_LE(particles.places, first + first / 8 + 4 * 64);
  }
  PetscCall(MPMParticlesSetSize(&particles, first / 2));
  CHECK_LE(particles.places, first / 2 + first / 4); /* memory is given back */
  PetscCall(MPMParticlesDestroy(&particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After particles have left, there still are as many places as the storage counts. The C library knows their bytes,
   except where PETSc checks allocations. */
static PetscErrorCode Shrink(void)
{
  const PetscInt first = 1700;
  MPMNeeds       needs = UnitNeeds();
  PetscBool      checked;

  PetscFunctionBeginUser;
  PetscCall(PetscMallocGetDebug(&checked, NULL, NULL));
  for (PetscInt left = 1000; left < first && !checked; left += 20) {
    void *rows;

    UnitContext("%d of %d particles remain", (int)left, (int)first);
    PetscCall(Create(2, &needs));
    particles.room = 50;
    PetscCall(MPMParticlesSetSize(&particles, first));
    PetscCall(MPMParticlesSetSize(&particles, left));
    PetscCall(MPMParticlesGetField(&particles, MPM_FIELD_INDEX_x, &rows));
    CHECK_GE((double)malloc_usable_size(rows), (double)particles.places * particles.bytes[MPM_FIELD_INDEX_x]);
    PetscCall(MPMParticlesRestoreField(&particles, MPM_FIELD_INDEX_x));
    PetscCall(MPMParticlesDestroy(&particles));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  for (int k = 0; k < UNIT_KINDS; k++) kinds[k] = (MPMKind){.m = 1, .V0 = 1, .l = {0.25, 0.25, 0.25}};
  for (int dim = 1; dim <= 3; dim++)
    for (int scene = 0; scene < SCENES; scene++) PetscCall(Scene(dim, scene));
  PetscCall(Grow());
  PetscCall(Shrink());
  UnitContext("what was tested");
  CHECK_GE(merges, 5000);
  CHECK_GE(sorts, 500);
  CHECK_GE(reorders, 500);
  CHECK_GE(turned, 100);
  CHECK_GE(reorders - turned, 100);
  CHECK_GE(migrations, 2000);
  PetscCall(PetscFinalize());
  return UnitEnd();
}
