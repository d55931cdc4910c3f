/* doubts_start.c - what is doubtful in where the particles of bodies are at the start, and in how much matter they
   are: particles of tables that lie at one place or are too large, and bodies whose particles have another volume than
   their shape has. */
#include <stdlib.h>
#include "advice/unlikely.h"
#include "scene/at_walls.h"
#include "scene/cut.h"
#include "scene/fit.h"
#include "scene/points.h"

#define ACROSS 16   /* places along an axis at which it is seen how deep a rigid body is */
#define GRIP   1.99 /* cells: matter that reaches less far into a tied body is not held well */

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
      const PetscReal near = MPM_BOUND_at_one_place * PetscMin(place[q].edge, place[k].edge);
      PetscReal       far2 = 0;

      if (PetscAbsReal(place[q].x[0] - place[k].x[0]) > MPM_BOUND_at_one_place * place[k].edge) break;
      for (PetscInt d = 0; d < dim; d++) far2 += PetscSqr(place[q].x[d] - place[k].x[d]);
      if (far2 < near * near) return PETSC_TRUE;
    }
  return PETSC_FALSE;
}

/* Examines the particles of tables [nbodies - nfilled] here. Not collective. */
static PetscErrorCode Examine(MPMCore *core, const MPMScene *scene, Table table[])
{
  const PetscInt dim = core->grid.dim, nf = scene->nfilled,
                 fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(F) | MPM_BIT(cell);
  PetscReal cell        = 1;
  Place    *place;
  MPMView   view;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) cell *= core->grid.h[d];
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  PetscCall(PetscMalloc1(PetscMax(1, view.n), &place));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMKind *kind   = MPMKindOf(core->params.kinds, &view, p);
    PetscReal      volume = kind->V0;
    Place         *q      = &place[p];

    *q = (Place){.cell = view.cell[p], .row = p, .body = MPMBodyOf(scene, view.id[p], 0)};
    if (core->grid.round) volume /= 2 * PETSC_PI * PetscMax(view.x[p * dim], 1e-3 * core->grid.h[0]); /* its area */
    if (view.F && (scene->materials[kind->material].state & MPM_BIT(F)))
      volume *= MPMDet((int)dim, view.F + p * dim * dim);
    for (PetscInt d = 0; d < dim; d++) q->x[d] = view.x[p * dim + d];
    q->edge = PetscPowReal(PetscMin(volume, cell), 1 / (PetscReal)dim);
    if (q->body < nf) continue;
    table[q->body - nf].large += volume > MPM_BOUND_large * cell;
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
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of the particles of a table. */
static PetscErrorCode WarnTable(const MPMCore *core, const MPMBody *b, Table *t)
{
  const PetscInt  dim  = core->grid.dim;
  const PetscReal have = MPMSumValue(&t->volume);
  PetscReal       cell = 1, grid = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) {
    cell *= core->grid.h[d];
    grid *= core->grid.upper[d] - core->grid.lower[d];
  }
  if (t->near)
    PetscCall(MPMWarn(
        &core->print,
        "%" PetscInt64_FMT " of the %" PetscInt64_FMT
        " particles of %s lie at the place of another one, or nearer than a quarter of their size, the first is number %" PetscInt64_FMT
        " of %s: matter is there twice",
        t->near, b->n, b->name, t->at - b->first + 1, b->points->path));
  if (have > grid)
    PetscCall(MPMWarn(&core->print,
                      "the particles of %s have a volume of %.3g m^%" PetscInt_FMT
                      " together, more than the grid, %.3g; see the column volume of %s, and its unit",
                      b->name, (double)have, dim, (double)grid, b->points->path));
  else if (have > MPM_BOUND_full * (PetscReal)t->cells * cell)
    PetscCall(MPMWarn(&core->print,
                      "the particles of %s have a volume of %.3g m^%" PetscInt_FMT " together, and the %" PetscInt64_FMT
                      " cells in which they lie %.3g; see the column volume of %s, and its unit",
                      b->name, (double)have, dim, t->cells, (double)((PetscReal)t->cells * cell), b->points->path));
  else if (have < MPM_BOUND_sparse * (PetscReal)t->cells * cell)
    PetscCall(
        MPMWarn(&core->print,
                "the particles of %s have a volume of %.3g m^%" PetscInt_FMT
                " together, %.2g of that of the cells in which they lie; see the column volume of %s, and its unit",
                b->name, (double)have, dim, (double)(have / ((PetscReal)t->cells * cell)), b->points->path));
  if (t->large)
    PetscCall(MPMWarn(
        &core->print,
        "%" PetscInt64_FMT " of the %" PetscInt64_FMT
        " particles of %s are larger than %d cells, the largest has %.3g: they leave gaps; give more and smaller "
        "ones, or larger cells",
        t->large, b->n, b->name, (int)MPM_BOUND_large, (double)(t->most / cell)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of tables. Collective on exchange.data. */
static PetscErrorCode WarnTables(MPMCore *core, const MPMScene *scene)
{
  const PetscInt n      = scene->nbodies - scene->nfilled;
  const MPI_Comm comm   = core->exchange.data;
  const MPI_Op   how[4] = {MPI_SUM, MPI_MIN, MPI_SUM, MPI_SUM};
  Table         *table;

  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &table));
  for (PetscInt k = 0; k < n; k++) {
    table[k].at = INT64_MAX;
    MPMSumZero(&table[k].volume);
  }
  PetscCall(Examine(core, scene, table));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt64 *const count[4] = {&table[k].near, &table[k].at, &table[k].large, &table[k].cells};

    for (int c = 0; c < 4; c++) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count[c], 1, MPIU_INT64, how[c], comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &table[k].most, 1, MPIU_REAL, MPI_MAX, comm));
    PetscCall(MPMSumReduce(&table[k].volume, 1, comm));
    PetscCall(WarnTable(core, &scene->bodies[scene->nfilled + k], &table[k]));
  }
  PetscCall(PetscFree(table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of bodies whose particles have another volume than their shape, in which they start. */
static PetscErrorCode WarnShapes(const MPMCore *core, const MPMScene *scene)
{
  const MPMGrid *grid = &core->grid;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nfilled; k++) {
    const MPMBody  *b     = &scene->bodies[k];
    const PetscReal shape = MPMFitVolume(b, grid->dim);
    const PetscReal have  = (PetscReal)b->parts / (PetscReal)MPMCutParts(grid->dim) *
                           (b->round ? b->b[0] * b->b[1] : scene->kinds[b->kind].V0);
    char why[MPM_TEXT_LEN];

    if (b->source.on || !(PetscAbsReal(have / shape - 1) > MPM_FIT_MOST)) continue;
    MPMFitTell(b, grid, shape, why);
    PetscCall(MPMWarn(&core->print,
                      "the particles of %s have a volume of %.3g m^%" PetscInt_FMT ", and its shape %.3g: %s", b->name,
                      (double)have, grid->dim, (double)shape, why));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of particles of fluids, soils and metals that would start exactly on walls: they start a little inside, and
   what should rest does not. */
static PetscErrorCode WarnOnWalls(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nfilled; k++) {
    const MPMBody *b                    = &scene->bodies[k];
    PetscBool      any                  = PETSC_FALSE;
    char           offset[MPM_NAME_LEN] = "";

    for (PetscInt d = 0; d < core->grid.dim && !b->points; d++) {
      const PetscBool lie = MPMAtWallsLie(scene, core, b, d);
      const PetscReal at  = b->offset[d] + (lie ? 0.5 * b->b[d] : 0);

      any = any || lie;
      MPMAppend(offset, sizeof offset, "%s%.10g", d ? "," : "", (double)at);
    }
    if (any)
      PetscCall(MPMWarn(
          &core->print,
          "particles of %s would start exactly on a wall, and start a tenth of their spacing inside: what should rest "
          "does not; use -body_%s_offset %s",
          b->name, b->name, offset));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of cuts that remove no particle. */
static PetscErrorCode WarnCuts(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nfilled; k++)
    for (PetscInt cut = 0; cut < scene->bodies[k].region.ncut; cut++) {
      const MPMBody *b = &scene->bodies[k], *other = scene->bodies;
      PetscBool      nothing;

      PetscCall(MPMSceneCutsNothing(b, core->grid.dim, cut, &nothing));
      if (!nothing) continue;
      while (&other->region != b->region.others[cut]) other++;
      PetscCall(MPMWarn(&core->print,
                        "-body_%s_cut %s removes no particle of %s; check where the shapes are, and their sizes",
                        b->name, other->name, b->name));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of where matter is, and of what walls and viscosity will do. */
static PetscErrorCode WarnStart(const MPMCore *core, const MPMScene *scene, const MPMTime *time)
{
  PetscBool   advances = PETSC_FALSE;
  const char *piston   = NULL;
  char        meets[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (scene->overlap)
    PetscCall(MPMWarn(
        &core->print,
        "%" PetscInt64_FMT
        " particles lie in the shape of an earlier body too: matter is there twice; move one, or give -body_<b>_cut",
        scene->overlap));
  for (PetscInt k = 0; k < 6; k++)
    if (scene->walls.given[k / 2][k % 2].type == MPM_WALL_piston && scene->walls.place[k] > 0)
      piston = piston ? "<f>" : MPMFaceNames[k];
  if (scene->behind)
    PetscCall(
        MPMWarn(&core->print,
                "%" PetscInt64_FMT
                " particles start behind a piston, which moves them along; shorten -bc_%s_distance or cut the body",
                scene->behind, piston));
  if (scene->on_line && core->basis == MPM_BASIS_linear)
    PetscCall(MPMWarn(
        &core->print,
        "%" PetscInt64_FMT
        " particles start exactly on lines of the grid, where the gradient of the linear basis jumps; shift them by "
        "-body_<b>_offset",
        scene->on_line));
  for (PetscInt k = 0; k < 2 * core->grid.dim && !advances && !core->grid.total; k++)
    PetscCall(MPMSceneWallAdvances(scene, core, k, time->end, &advances));
  if (advances)
    PetscCall(MPMWarn(
        &core->print,
        "a wall of type moving advances along its normal, but its face of the grid stays: right for displacements far below a cell only; a wall of type piston moves through the grid"));
  PetscCall(MPMSceneForesee(scene, core, time->end, meets));
  if (meets[0])
    PetscCall(MPMWarn(&core->print, "%s, which ends the run; %schoose an earlier -time_end", meets,
                      strstr(meets, "leaves") ? "check the sign of its velocity, or " : ""));
  if (time->fixed > MPMViscousStep(core))
    PetscCall(MPMWarn(&core->print,
                      "dt is above the bound of viscosity, h^2/(2 dim nu) = %.3g s: expect the run to blow up",
                      (double)MPMViscousStep(core)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns how deep a place of a rigid body in the grid lies below its surface, m: the deepest of ACROSS along each axis. */
static PetscReal Deepest(const MPMRigid *r, const MPMGrid *grid)
{
  PetscReal lower[3], upper[3], deep = 0;
  PetscInt  all = 1;

  MPMRegionBounds(r->shape, grid->dim, lower, upper);
  for (PetscInt d = 0; d < grid->dim; d++) {
    lower[d] = PetscMax(lower[d], grid->lower[d]);
    upper[d] = PetscMin(upper[d], grid->upper[d]);
    all *= ACROSS;
  }
  for (PetscInt k = 0; k < all; k++) {
    PetscReal x[3], n[3];

    for (PetscInt d = 0, q = k; d < grid->dim; d++, q /= ACROSS)
      x[d] = lower[d] + (upper[d] - lower[d]) * ((PetscReal)(q % ACROSS) + 0.5) / ACROSS;
    deep = PetscMax(deep, -MPMRigidDistance(r, grid->dim, x, n));
  }
  return deep;
}

/* Warns of rigid bodies that are tied and hold nothing at the start, or too little. Collective on exchange.data. */
static PetscErrorCode WarnTied(MPMCore *core)
{
  const MPMRigids *r   = &core->rigids;
  PetscBool        any = PETSC_FALSE;
  const PetscReal  h   = MPMGridSmallestH(&core->grid);
  PetscReal       *deep; /* how deep matter lies in a body, m, or below 0 */
  MPMView          view;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < r->n; k++) any = any || r->body[k].tied;
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(r->n, &deep));
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(x) | MPM_BIT(kind), &view));
  for (PetscInt k = 0; k < r->n; k++) {
    deep[k] = -1;
    for (PetscInt p = 0; p < view.n && r->body[k].tied; p++) {
      PetscReal       n[3], half = 0; /* of the particle, along the normal */
      const PetscReal by = -MPMRigidDistance(&r->body[k], core->grid.dim, view.x + p * core->grid.dim, n);

      for (PetscInt d = 0; d < core->grid.dim; d++)
        half += PetscAbsReal(n[d]) * MPMKindOf(core->params.kinds, &view, p)->l[d] * core->grid.h[d];
      if (by > 0) deep[k] = PetscMax(deep[k], by + half);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(x) | MPM_BIT(kind), &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, deep, (PetscMPIInt)r->n, MPIU_REAL, MPI_MAX, core->exchange.data));
  for (PetscInt k = 0; k < r->n; k++) {
    if (!r->body[k].tied) continue;
    if (deep[k] < 0)
      PetscCall(
          MPMWarn(&core->print,
                  "-body_%s_tied: no particle lies in the rigid body %s at the start, and it holds what lies in it; "
                  "let matter reach two cells into it",
                  r->body[k].name, r->body[k].name));
    else if (deep[k] < PetscMin(GRIP * h, Deepest(&r->body[k], &core->grid) - 0.5 * h))
      PetscCall(
          MPMWarn(&core->print,
                  "-body_%s_tied: matter lies only %.2g cells deep in the rigid body %s at the start; let it reach "
                  "two cells into it",
                  r->body[k].name, (double)(deep[k] / h), r->body[k].name));
  }
  PetscCall(PetscFree(deep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the body that reaches the wall of a face, or NULL. */
static const MPMBody *Reaches(const MPMCore *core, const MPMScene *scene, PetscInt d, PetscInt side)
{
  PetscReal plane, sign, lower[3], upper[3];

  MPMWallPlane(&scene->walls, &core->grid, 2 * d + side, &plane, &sign);
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    MPMRegionBounds(&scene->bodies[k].region, core->grid.dim, lower, upper);
    if (sign * ((side ? upper[d] : lower[d]) - plane) < 0.5 * core->grid.h[d]) return &scene->bodies[k];
  }
  return NULL;
}

/* Warns of gravity that points away from every wall, where no wall could hold the bodies: walls of type fixed and
   moving hold what touches them in any direction, friction also along itself. Others that do not just push hold what hangs
   from them. */
static PetscErrorCode WarnFall(const MPMCore *core, const MPMScene *scene)
{
  const PetscReal *g     = core->params.gravity;
  PetscInt         walls = 0, down = 0, from = 0;
  const MPMBody   *hangs = NULL;
  MPMOdd           odd;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < core->grid.dim; d++) {
    if (PetscAbsReal(g[d]) > PetscAbsReal(g[down])) down = d;
    for (PetscInt side = 0; side < 2; side++) {
      const MPMWall type = scene->walls.given[d][side].type;

      if (!MPMWallHas(type, MPM_WALL_NORMAL)) continue;
      walls++;
      if (MPMWallHas(type, MPM_WALL_TANGENT | MPM_WALL_MOVES) || (MPMWallHas(type, MPM_WALL_BRAKES) && g[d] == 0) ||
          (side ? g[d] > 0 : g[d] < 0))
        PetscFunctionReturn(PETSC_SUCCESS);
      if (!MPMWallHas(type, MPM_WALL_PUSHES) && g[d] != 0 && !hangs) {
        hangs = Reaches(core, scene, d, side);
        from  = 2 * d + side;
      }
    }
  }
  if (!walls || g[down] == 0 || core->rigids.n) PetscFunctionReturn(PETSC_SUCCESS);
  if (hangs) {
    PetscCall(MPMNote(&core->print,
                      "%s hangs from its wall -bc_%s_type %s, which does not let go; a wall that lets go is separate",
                      hangs->name, MPMFaceNames[from], MPMWallNames[scene->walls.given[from / 2][from % 2].type]));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (MPMUnlikelyStatic(&odd) && !MPMWallHas(scene->walls.given[down][0].type, MPM_WALL_NORMAL) &&
      !MPMWallHas(scene->walls.given[down][1].type, MPM_WALL_NORMAL))
    PetscFunctionReturn(PETSC_SUCCESS); /* which a note says, for any load */
  PetscCall(MPMWarn(
      &core->print,
      "gravity points away from every wall, along %c%c: nothing holds the bodies; turn -gravity, or choose -bc_%s_type",
      g[down] > 0 ? '+' : '-', "xyz"[down], MPMFaceNames[2 * down + (g[down] > 0)]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMDoubtsStart(MPMCore *core, const MPMScene *scene, const MPMTime *time, PetscBool restarted)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSceneForeseeRigids(scene, core, time->end));
  PetscCall(WarnStart(core, scene, time));
  if (!restarted) { /* else particles are not where they started */
    PetscCall(WarnTables(core, scene));
    PetscCall(WarnShapes(core, scene));
    PetscCall(WarnOnWalls(core, scene));
    PetscCall(WarnTied(core));
  }
  PetscCall(WarnCuts(core, scene));
  PetscCall(WarnFall(core, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
