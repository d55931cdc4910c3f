/* doubts_bodies.c - what is doubtful in where the particles of bodies are at the start, and in how much matter they
   are: particles of tables that lie at one place or are too large, and bodies whose particles have another volume than
   their shape has. */
#include <stdlib.h>
#include "run/mpm.h"
#include "scene/at_walls.h"
#include "scene/fit.h"
#include "scene/points.h"

#define NEAR  0.25 /* of the size of a particle; one that is nearer to another one is at its place */
#define LARGE 2    /* cells; larger particles leave gaps between them */
#define FULL  1.01 /* of the cells that the particles of a table lie in: more matter does not fit there */

/* A particle: its cell, its place, the edge of a cube of its volume or of a cell, its body and its row in the view. */
typedef struct {
  PetscInt  cell, body, row;
  PetscReal x[3], edge;
} Place;

/* What is found of the particles of a table. */
typedef struct {
  PetscInt64 near, at, large, cells; /* how many are near others, the first of these; how many are too large; cells */
  PetscReal  most;                   /* the largest volume of a particle */
  MPMSum     volume;                 /* m^dim, of all */
} Table;

static int ComparePlaces(const void *a, const void *b)
{
  const Place *p = (const Place *)a, *q = (const Place *)b;

  return p->cell != q->cell ? (p->cell < q->cell ? -1 : 1) : p->x[0] != q->x[0] ? (p->x[0] < q->x[0] ? -1 : 1) : 0;
}

/* Returns whether a particle has another one of the same cell at its place, among n that are sorted. */
static PetscBool IsNear(PetscInt dim, PetscInt n, const Place place[], PetscInt k)
{
  for (PetscInt side = -1; side <= 1; side += 2)
    for (PetscInt q = k + side; q >= 0 && q < n && place[q].cell == place[k].cell; q += side) {
      const PetscReal near = NEAR * PetscMin(place[q].edge, place[k].edge);
      PetscReal       far2 = 0;

      if (PetscAbsReal(place[q].x[0] - place[k].x[0]) > NEAR * place[k].edge) break;
      for (PetscInt d = 0; d < dim; d++) far2 += PetscSqr(place[q].x[d] - place[k].x[d]);
      if (far2 < near * near) return PETSC_TRUE;
    }
  return PETSC_FALSE;
}

/* Examines the particles of tables [nbodies - nfilled] here. Not collective. */
static PetscErrorCode Examine(MPM mpm, Table table[])
{
  const MPMCore  *core  = &mpm->core;
  const MPMScene *scene = &mpm->scene;
  const PetscInt  dim = core->grid.dim, nf = scene->nfilled,
                 fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(F) | MPM_BIT(cell);
  PetscReal cell        = 1;
  Place    *place;
  MPMView   view;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) cell *= core->grid.h[d];
  PetscCall(MPMParticlesGetView(&mpm->core.particles, fields, &view));
  PetscCall(PetscMalloc1(PetscMax(1, view.n), &place));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMKind *kind   = MPMKindOf(core->params.kinds, &view, p);
    PetscReal      volume = kind->V0;
    Place         *q      = &place[p];

    *q = (Place){.cell = view.cell[p], .row = p, .body = MPMBodyOf(scene, view.id[p], 0)};
    if (view.F && (scene->materials[kind->material].state & MPM_BIT(F)))
      volume *= MPMDet((int)dim, view.F + p * dim * dim);
    for (PetscInt d = 0; d < dim; d++) q->x[d] = view.x[p * dim + d];
    q->edge = PetscPowReal(PetscMin(volume, cell), 1 / (PetscReal)dim);
    if (q->body < nf) continue;
    table[q->body - nf].large += volume > LARGE * cell;
    table[q->body - nf].most = PetscMax(table[q->body - nf].most, volume);
    MPMSumAdd(&table[q->body - nf].volume, volume);
  }
  qsort(place, (size_t)view.n, sizeof *place, ComparePlaces);
  for (PetscInt k = 0; k < view.n; k++) {
    Table   *t     = place[k].body < nf ? NULL : &table[place[k].body - nf];
    PetscInt first = k;

    if (!t) continue;
    while (first > 0 && place[first - 1].cell == place[k].cell && place[first - 1].body != place[k].body) first--;
    t->cells += !first || place[first - 1].cell != place[k].cell;
    if (!IsNear(dim, view.n, place, k)) continue;
    t->near++;
    t->at = PetscMin(t->at, view.id[place[k].row]);
  }
  PetscCall(PetscFree(place));
  PetscCall(MPMParticlesRestoreView(&mpm->core.particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of the particles of a table. */
static PetscErrorCode WarnTable(MPM mpm, const MPMBody *b, Table *t)
{
  const PetscInt  dim  = mpm->core.grid.dim;
  const PetscReal have = MPMSumValue(&t->volume);
  PetscReal       cell = 1, grid = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) {
    cell *= mpm->core.grid.h[d];
    grid *= mpm->core.grid.upper[d] - mpm->core.grid.lower[d];
  }
  if (t->near)
    PetscCall(MPMWarn(
        &mpm->core.print,
        "%" PetscInt64_FMT " of the %" PetscInt64_FMT
        " particles of %s lie at the place of another one, or nearer than a quarter of their size, the first is number %" PetscInt64_FMT
        " of %s: matter is there twice",
        t->near, b->n, b->name, t->at - b->first + 1, b->points->path));
  if (have > grid)
    PetscCall(MPMWarn(&mpm->core.print,
                      "the particles of %s have a volume of %.3g m^%" PetscInt_FMT
                      " together, more than the grid, %.3g; see the column volume of %s, and its unit",
                      b->name, (double)have, dim, (double)grid, b->points->path));
  else if (have > FULL * (PetscReal)t->cells * cell)
    PetscCall(MPMWarn(&mpm->core.print,
                      "the particles of %s have a volume of %.3g m^%" PetscInt_FMT " together, and the %" PetscInt64_FMT
                      " cells in which they lie %.3g; see the column volume of %s, and its unit",
                      b->name, (double)have, dim, t->cells, (double)((PetscReal)t->cells * cell), b->points->path));
  if (t->large)
    PetscCall(MPMWarn(
        &mpm->core.print,
        "%" PetscInt64_FMT " of the %" PetscInt64_FMT
        " particles of %s are larger than %d cells, the largest has %.3g: they leave gaps; give more and smaller "
        "ones, or larger cells",
        t->large, b->n, b->name, LARGE, (double)(t->most / cell)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of tables. Collective on exchange.data. */
static PetscErrorCode WarnTables(MPM mpm)
{
  const MPMScene *scene  = &mpm->scene;
  const PetscInt  n      = scene->nbodies - scene->nfilled;
  const MPI_Comm  comm   = mpm->core.exchange.data;
  const MPI_Op    how[4] = {MPI_SUM, MPI_MIN, MPI_SUM, MPI_SUM};
  Table          *table;

  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &table));
  for (PetscInt k = 0; k < n; k++) {
    table[k].at = INT64_MAX;
    MPMSumZero(&table[k].volume);
  }
  PetscCall(Examine(mpm, table));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt64 *const count[4] = {&table[k].near, &table[k].at, &table[k].large, &table[k].cells};

    for (int c = 0; c < 4; c++) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count[c], 1, MPIU_INT64, how[c], comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &table[k].most, 1, MPIU_REAL, MPI_MAX, comm));
    PetscCall(MPMSumReduce(&table[k].volume, 1, comm));
    PetscCall(WarnTable(mpm, &scene->bodies[scene->nfilled + k], &table[k]));
  }
  PetscCall(PetscFree(table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of bodies whose particles have another volume than their shape, in which they start. */
static PetscErrorCode WarnShapes(MPM mpm)
{
  const MPMGrid *grid = &mpm->core.grid;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nfilled; k++) {
    const MPMBody  *b     = &mpm->scene.bodies[k];
    const PetscReal shape = MPMFitVolume(b, grid->dim), have = (PetscReal)b->n * mpm->scene.kinds[b->kind].V0;
    char            why[MPM_TEXT_LEN];

    if (!(PetscAbsReal(have / shape - 1) > MPM_FIT_MOST)) continue;
    MPMFitTell(b, grid, shape, why);
    PetscCall(MPMWarn(&mpm->core.print,
                      "the particles of %s have a volume of %.3g m^%" PetscInt_FMT ", and its shape %.3g: %s", b->name,
                      (double)have, grid->dim, (double)shape, why));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of particles of fluids, soils and metals that would start exactly on walls: they start a little inside, and
   what should rest does not. */
static PetscErrorCode WarnOnWalls(MPM mpm)
{
  const MPMCore *core = &mpm->core;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nfilled; k++) {
    const MPMBody *b                    = &mpm->scene.bodies[k];
    PetscBool      any                  = PETSC_FALSE;
    char           offset[MPM_NAME_LEN] = "";

    for (PetscInt d = 0; d < core->grid.dim && !b->points; d++) {
      const PetscBool lie = MPMAtWallsLie(&mpm->scene, core, b, d);
      const PetscReal at  = b->offset[d] + (lie ? 0.5 * b->b[d] : 0);

      any = any || lie ? PETSC_TRUE : PETSC_FALSE;
      (void)snprintf(offset + strlen(offset), sizeof offset - strlen(offset), "%s%.10g", d ? "," : "", (double)at);
    }
    if (any)
      PetscCall(MPMWarn(
          &mpm->core.print,
          "particles of %s would start exactly on a wall, and start a tenth of their spacing inside: what should rest "
          "does not; use -body_%s_offset %s",
          b->name, b->name, offset));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMDoubtsBodies(MPM mpm)
{
  PetscFunctionBeginUser;
  if (mpm->checkpoint.from[0]) PetscFunctionReturn(PETSC_SUCCESS); /* their places are not those of the start */
  PetscCall(WarnTables(mpm));
  PetscCall(WarnShapes(mpm));
  PetscCall(WarnOnWalls(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
