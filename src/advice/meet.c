/* meet.c - bodies of the total frame that meet each other or a wall, of which that frame knows nothing: its nodes are
   those of the places at the start. Bodies that have nodes in common at the start are joined, and a wall holds the
   bodies that reach its nodes at the start; nothing else acts between them, and where they do not touch the scene is
   refused. It is used before the first step and after steps, and changes no state.

   It looks when the fastest particle may have come a quarter of a cell farther, and after the last step. A body has met
   a wall that does not hold it where it lies beyond its plane; two bodies that are not joined have met where particles
   of both lie in one cell. It looks too whether matter that flows is squeezed beyond what was measured. Every decision
   follows from extremes and bits of all processes. */
#include "advice/watch.h"
#include "kernels/cell.h"
#include "physics/distance.h"
#include "physics/wall.h"

#define FIELDS (MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(kind) | MPM_BIT(F) | MPM_BIT(F33))

/* What is looked for: positions now, or those of the start. */
typedef struct {
  const MPMCore  *core;
  const MPMScene *scene;
  MPMView         view;
  PetscInt       *body;  /* [view.n] */
  PetscReal      *bound; /* [nbodies][3][2] the least coordinate, and less the largest, m */
} Look;

static const PetscReal *PlaceOf(const Look *l, PetscBool start, PetscInt p)
{
  return (start ? l->view.X : l->view.x) + p * l->core->grid.dim;
}

/* Finds the bounds of bodies. Collective on exchange.data. */
static PetscErrorCode FindBounds(Look *l, PetscBool start)
{
  const PetscInt dim = l->core->grid.dim, n = 6 * l->scene->nbodies;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n; k++) l->bound[k] = PETSC_MAX_REAL;
  for (PetscInt p = 0; p < l->view.n; p++)
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal      *bound = l->bound + 6 * l->body[p] + 2 * d;
      const PetscReal x     = PlaceOf(l, start, p)[d];

      bound[0] = PetscMin(bound[0], x);
      bound[1] = PetscMin(bound[1], -x);
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, l->bound, (PetscMPIInt)n, MPIU_REAL, MPI_MIN, l->core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Which cells a place marks: its own; those named by the first node of any stencil that has nodes in common with its
   own; its own and those a spacing away. */
typedef enum { OWN, STENCIL, SPACING } Reach;

/* Sets lo, hi to the cells that particle p marks along axis d if it marks `more` than its own. */
static void Marks(const Look *l, PetscBool start, Reach reach, PetscInt p, PetscInt d, PetscBool more, PetscInt *lo,
                  PetscInt *hi)
{
  const MPMCore  *core = l->core;
  const MPMGrid  *grid = &core->grid;
  const PetscReal x = PlaceOf(l, start, p)[d], by = more && reach == SPACING ? l->scene->bodies[l->body[p]].b[d] : 0;
  PetscReal       xi;

  if (reach == STENCIL) {
    const PetscInt far  = more ? MPMBasisNodes(core->basis) - 1 : 0;
    const PetscInt base = MPMCoordinate(core->basis, grid, (int)d, x, MPMKindOf(core->params.kinds, &l->view, p)->l[d],
                                        &xi);

    *lo = base - far;
    *hi = base + far;
    return;
  }
  *lo = (PetscInt)PetscFloorReal((x - by - grid->lower[d]) / grid->h[d]);
  *hi = (PetscInt)PetscFloorReal((x + by - grid->lower[d]) / grid->h[d]);
}

/* Sets *meet to whether bodies a and b mark a cell together, b with its own ones. Collective on exchange.data. */
static PetscErrorCode ShareCells(const Look *l, PetscBool start, Reach reach, PetscInt a, PetscInt b, PetscBool *meet)
{
  const MPMGrid *grid     = &l->core->grid;
  const PetscInt dim      = grid->dim;
  PetscInt       first[3] = {0}, n[3] = {1, 1, 1}, all = 1; /* cells of the box that both can mark */
  unsigned char *mark;

  PetscFunctionBeginUser;
  *meet = PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal *A = l->bound + 6 * a + 2 * d, *B = l->bound + 6 * b + 2 * d;
    const PetscReal  far = reach == OWN ? 0 : MPM_MAX_STENCIL * grid->h[d] + l->scene->bodies[a].b[d];
    const PetscReal  lo = PetscMax(A[0] - far, B[0] - far), hi = PetscMin(-A[1] + far, -B[1] + far);

    if (!(hi >= lo) || !((hi - lo) / grid->h[d] < 1e6)) PetscFunctionReturn(PETSC_SUCCESS);
    first[d] = (PetscInt)PetscFloorReal((lo - grid->lower[d]) / grid->h[d]);
    n[d]     = (PetscInt)PetscFloorReal((hi - grid->lower[d]) / grid->h[d]) - first[d] + 1;
    all *= n[d];
  }
  PetscCall(PetscCalloc1(all, &mark));
  for (PetscInt p = 0; p < l->view.n; p++) {
    PetscInt from[3] = {0}, to[3] = {0};

    if (l->body[p] != a && l->body[p] != b) continue;
    for (PetscInt d = 0; d < dim; d++) {
      Marks(l, start, reach, p, d, (PetscBool)(l->body[p] == a), &from[d], &to[d]);
      from[d] = PetscMax(0, from[d] - first[d]);
      to[d]   = PetscMin(n[d] - 1, to[d] - first[d]);
    }
    for (PetscInt k = from[2]; k <= to[2]; k++)
      for (PetscInt j = from[1]; j <= to[1]; j++)
        for (PetscInt i = from[0]; i <= to[0]; i++) mark[(k * n[1] + j) * n[0] + i] |= l->body[p] == a ? 1 : 2;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, mark, (PetscMPIInt)all, MPI_UNSIGNED_CHAR, MPI_BOR, l->core->exchange.data));
  for (PetscInt k = 0; k < all && !*meet; k++) *meet = (PetscBool)(mark[k] == 3);
  PetscCall(PetscFree(mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the wall of a face holds what is at it. */
static PetscBool Holds(const Look *l, PetscInt face)
{
  return MPMWallHas(l->scene->walls.given[face / 2][face % 2].type, MPM_WALL_NORMAL);
}

/* Returns how far inside the plane of a face, which walls have moved by `passed` along its axis, a body is, m. */
static PetscReal Inside(const Look *l, PetscInt b, PetscInt face, PetscReal passed)
{
  const MPMGrid  *grid = &l->core->grid;
  const PetscReal own  = l->bound[6 * b + face];

  return face % 2 ? grid->upper[face / 2] + passed + own : own - grid->lower[face / 2] - passed;
}

/* Returns the gap of body a at the start, m, to body b, or if `face` >= 0 to the plane of that face; or PETSC_MIN_REAL
   if a shape of the two has no distance. A ball around a particle of a that reaches to the surface of a lies in a, so
   the sum of the particle's distances from both is never less than the gap, and the least is the gap where surfaces are
   flat. At one of radius R it is too large by y^2/(2 R), y: how far the particle is beside the nearest place.
   Collective on exchange.data. */
static PetscErrorCode Gap(const Look *l, PetscInt a, PetscInt b, PetscInt face, PetscReal *gap)
{
  const MPMRegion *A = &l->scene->bodies[a].region, *B = &l->scene->bodies[b].region;
  const MPMGrid   *grid = &l->core->grid;
  PetscReal        n[3];

  PetscFunctionBeginUser;
  *gap = PETSC_MIN_REAL;
  if (!MPMRegionHasDistance(A) || !MPMRegionHasDistance(B)) PetscFunctionReturn(PETSC_SUCCESS);
  *gap = PETSC_MAX_REAL;
  for (PetscInt p = 0; p < l->view.n; p++) {
    const PetscReal *X = PlaceOf(l, PETSC_TRUE, p);
    PetscReal        far;

    if (l->body[p] != a) continue;
    if (face < 0)
      far = MPMRegionDistance(B, grid->dim, X, n);
    else
      far = face % 2 ? grid->upper[face / 2] - X[face / 2] : X[face / 2] - grid->lower[face / 2];
    *gap = PetscMin(*gap, far + MPMRegionDistance(A, grid->dim, X, n));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, gap, 1, MPIU_REAL, MPI_MIN, l->core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a gap, m, is too small to be one. */
static PetscBool IsClosed(const Look *l, PetscInt a, PetscReal gap)
{
  PetscReal spacing = PETSC_MAX_REAL;

  for (PetscInt d = 0; d < l->core->grid.dim; d++) spacing = PetscMin(spacing, l->scene->bodies[a].b[d]);
  return gap < MPM_BOUND_touch * spacing;
}

/* Returns the body that stands for all that are one piece with b: of those that touch, directly or through others. */
static PetscInt Piece(const PetscInt piece[], PetscInt b)
{
  while (piece[b] != b) b = piece[b];
  return b;
}

/* Finds which walls hold which bodies and which bodies are joined; refuses those of them that are not one piece by touching,
   also through others, and says which touch. Collective on exchange.data. */
static PetscErrorCode Begin(MPMWatch *w, Look *l, MPMCore *core)
{
  const PetscInt nb = l->scene->nbodies;
  PetscInt      *piece;
  PetscReal      gap;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(nb, &piece));
  for (PetscInt b = 0; b < nb; b++) piece[b] = b;
  PetscCall(PetscCalloc2(6 * nb, &w->held, nb * nb, &w->joined));
  PetscCall(FindBounds(l, PETSC_TRUE));
  for (PetscInt b = 0; b < nb; b++)
    for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
      const PetscReal in = Inside(l, b, k, 0), h = core->grid.h[k / 2], spacing = l->scene->bodies[b].b[k / 2];

      if (!Holds(l, k) || !(in < 0.5 * h * (PetscReal)MPMBasisNodes(core->basis))) continue;
      w->held[6 * b + k] = PETSC_TRUE;
      if (w->joins || core->stop[0]) continue;
      if (MPMWallHas(l->scene->walls.given[k / 2][k % 2].type, MPM_WALL_PUSHES)) continue; /* its nodes know the gap */
      PetscCall(Gap(l, b, b, k, &gap));
      if (gap == PETSC_MIN_REAL && in > spacing) gap = in - 0.5 * spacing;
      if (IsClosed(l, b, gap)) continue;
      (void)snprintf(
          core->stop, sizeof core->stop,
          "%s starts %.3g cells inside of its wall %s, nearer than the nodes of the wall reach: in the total "
          "frame that wall would hold it from the start; put it at the wall or farther away, use finer cells, "
          "or use %s",
          l->scene->bodies[b].name, (double)(gap / h), MPMFaceNames[k], w->use);
    }
  for (PetscInt a = 0; a < nb; a++)
    for (PetscInt b = a + 1; b < nb; b++) {
      PetscBool touch;

      PetscCall(ShareCells(l, PETSC_TRUE, STENCIL, a, b, &w->joined[a * nb + b]));
      if (!w->joined[a * nb + b] || w->joins || core->stop[0]) continue;
      PetscCall(Gap(l, a, b, -1, &gap));
      touch = IsClosed(l, a, gap);
      if (gap == PETSC_MIN_REAL) PetscCall(ShareCells(l, PETSC_TRUE, SPACING, a, b, &touch));
      if (!touch) continue;
      piece[Piece(piece, b)] = Piece(piece, a);
      PetscCall(MPMNote(&core->print, "%s and %s touch at the start: in the total frame they are one piece for ever",
                        l->scene->bodies[a].name, l->scene->bodies[b].name));
    }
  for (PetscInt a = 0; a < nb && !w->joins; a++)
    for (PetscInt b = a + 1; b < nb; b++)
      if (w->joined[a * nb + b] && Piece(piece, a) != Piece(piece, b) && !core->stop[0])
        (void)snprintf(core->stop, sizeof core->stop,
                       "%s and %s have nodes in common though they do not touch: in the total frame these would join "
                       "them for ever; put them together or farther apart, use finer cells, or use %s",
                       l->scene->bodies[a].name, l->scene->bodies[b].name, w->use);
  PetscCall(PetscFree(piece));
  w->refused = (PetscBool)(core->stop[0] != 0);
  w->joins   = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Looks at walls: leaves a reason to stop, or warns once of a body that passes beside where it is held. */
static PetscErrorCode LookAtWalls(MPMWatch *w, Look *l, MPMCore *core)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < l->scene->nbodies; b++)
    for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
      const PetscReal in   = Inside(l, b, k, core->passed[k]);
      const char     *wall = MPMWallNames[l->scene->walls.given[k / 2][k % 2].type];

      if (!Holds(l, k) || !(in < 0)) continue;
      if (!w->held[6 * b + k] && !core->stop[0])
        (void)snprintf(core->stop, sizeof core->stop,
                       "%s has met its wall %s (%s), and the total frame has no contact; use %s",
                       l->scene->bodies[b].name, MPMFaceNames[k], wall, w->use);
      else if (w->held[6 * b + k] && !w->passed && -in > MPM_BOUND_passed * core->grid.h[k / 2]) {
        w->passed = PETSC_TRUE;
        PetscCall(
            MPMWarn(&core->print,
                    "seen at t=%g s: %s reaches %.3g m beyond the plane of its wall %s (%s), beside the place where "
                    "that holds it; the total frame has no contact there",
                    (double)core->t, l->scene->bodies[b].name, (double)-in, MPMFaceNames[k], wall));
      }
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the particle of a plastic law with the least principal stretch; beyond the bound it leaves a reason to stop, or
   warns once with -check_law warn. Collective on exchange.data. */
static PetscErrorCode LookAtFlow(MPMWatch *w, Look *l, MPMCore *core)
{
  const PetscInt dim   = core->grid.dim;
  PetscBool      flows = PETSC_FALSE;
  MPMFound       flat  = {-1, -1, {0}, {0}}; /* value: less the square of the least stretch */
  char           at[MPM_NAME_LEN], what[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < l->scene->nmaterials; m++)
    if (l->scene->materials[m].type->traits & MPM_PLASTIC) flows = PETSC_TRUE;
  if (!flows) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt p = 0; p < l->view.n; p++) {
    const MPMMaterial *m     = core->params.materials + MPMKindOf(core->params.kinds, &l->view, p)->material;
    MPMFound           found = {0, 16 * l->view.id[p], {0}, {0}};
    PetscReal          b[6], squares[3], axes[3][3];

    if (!(m->type->traits & MPM_PLASTIC)) continue;
    MPMLeftCauchyGreen((int)dim, l->view.F + p * dim * dim, b);
    MPMEigen((int)dim, b, squares, axes);
    found.value = -squares[0];
    if (m->round) found.value = PetscMax(found.value, -PetscSqr(l->view.F33[p]));
    for (PetscInt d = 0; d < dim; d++) {
      found.value = PetscMax(found.value, -squares[d]);
      found.x[d]  = l->view.x[p * dim + d];
    }
    MPMFoundTake(&flat, &found);
  }
  PetscCall(MPMFoundAgree(&flat, core->exchange.data));
  if (flat.key < 0 || -flat.value > MPM_BOUND_squeezed * MPM_BOUND_squeezed) PetscFunctionReturn(PETSC_SUCCESS);
  MPMPlaceWords(dim, flat.x, at);
  (void)snprintf(what, sizeof what,
                 "particle %" PetscInt64_FMT
                 " of %s at %s is squeezed to %.2g of its length, and plastic laws are known to "
                 "be right in the total frame down to %g; use %s",
                 flat.key / 16, l->scene->bodies[MPMBodyOf(l->scene, flat.key / 16, 0)].name, at,
                 (double)PetscSqrtReal(-flat.value), (double)MPM_BOUND_squeezed, w->use);
  if (w->may_leave && !w->squeezed) PetscCall(MPMWarn(&core->print, "seen at t=%g s: %s", (double)core->t, what));
  if (!w->may_leave && !core->stop[0])
    (void)snprintf(core->stop, sizeof core->stop, "%.1500s, or go on all the same (-check_law warn)", what);
  w->squeezed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begin and end a look at the particles. Not collective. */
static PetscErrorCode Open(Look *l, MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, FIELDS, &l->view));
  PetscCall(PetscMalloc2(PetscMax(1, l->view.n), &l->body, 6 * l->scene->nbodies, &l->bound));
  for (PetscInt p = 0, b = 0; p < l->view.n; p++) l->body[p] = b = MPMBodyOf(l->scene, l->view.id[p], b);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Close(Look *l, MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(l->body, l->bound));
  PetscCall(MPMParticlesRestoreView(&core->particles, FIELDS, &l->view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMMeetBegin(MPMWatch *w, MPMCore *core, const MPMScene *scene)
{
  Look l = {.core = core, .scene = scene};

  PetscFunctionBeginUser;
  PetscCall(Open(&l, core));
  PetscCall(Begin(w, &l, core));
  PetscCall(Close(&l, core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMMeetLook(MPMWatch *w, MPMCore *core, const MPMScene *scene, PetscBool last)
{
  const PetscReal far = MPM_BOUND_meet * MPMGridSmallestH(&core->grid);
  Look            l   = {.core = core, .scene = scene};

  PetscFunctionBeginUser;
  w->moved += core->params.dt * PetscSqrtReal(core->status.v2);
  if (w->moved < far && !last && !core->implicit) PetscFunctionReturn(PETSC_SUCCESS);
  if (w->moved >= far) w->moved = 0; /* a run that goes on from the last step looks when one would that had not ended */
  PetscCall(Open(&l, core));
  PetscCall(FindBounds(&l, PETSC_FALSE));
  PetscCall(LookAtWalls(w, &l, core));
  PetscCall(LookAtFlow(w, &l, core));
  for (PetscInt a = 0; a < scene->nbodies; a++)
    for (PetscInt b = a + 1; b < scene->nbodies && !core->stop[0]; b++) {
      PetscBool meet;

      if (w->joined[a * scene->nbodies + b]) continue;
      PetscCall(ShareCells(&l, PETSC_FALSE, OWN, a, b, &meet));
      if (meet)
        (void)snprintf(
            core->stop, sizeof core->stop,
            "%s and %s have met, particles of both are in one cell, and the total frame has no contact; use %s",
            scene->bodies[a].name, scene->bodies[b].name, w->use);
    }
  PetscCall(Close(&l, core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMMeetDestroy(MPMWatch *w)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(w->held, w->joined));
  PetscFunctionReturn(PETSC_SUCCESS);
}
