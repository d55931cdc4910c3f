/* forces.c - body forces and loads: the acceleration b [dim], m/s^2, of every particle besides gravity, eq. (13) of
   docs/method.md. At the beginning of each step it is evaluated from expressions of position and time.

   A load acts on the sides of a body that are surface: those where the neighbour on the lattice was not in the body at
   the start. Such a side has the normal N of that side of the box around a particle. The force per area at the start is
   T, for a pressure p it is T = -p J F^-T N (Nanson's formula for the deformed surface). It acts as physics/skin.h
   says: b has the body force, and S, Pa, the stress w T (x) N as a Kirchhoff stress, w T (x) F N. T is that of the
   place at the surface; its F is taken from the particle, whose column it is. */
#include "physics/skin.h"
#include "scene/scene.h"

/* Reads on which sides of its body a load on a surface acts. */
static PetscErrorCode ReadSides(const MPMScene *scene, PetscInt dim, MPMOptions o, MPMLoad *load)
{
  char      face[MPM_NAME_LEN] = "", sides[MPM_TEXT_LEN / 2] = "all", where[2 * MPM_NAME_LEN];
  PetscBool given;

  PetscFunctionBeginUser;
  if (!MPMOptionsError(o) && scene->bodies[load->body].points)
    MPMOptionsFail(o,
                   "-load_%s_body %s does not apply: particles from a file have no known surface; use -load_%s_type "
                   "force or -acceleration",
                   load->name, scene->bodies[load->body].name, load->name);
  (void)snprintf(where, sizeof where, "-load_%s_where", load->name);
  PetscCall(PetscOptionsHasName(NULL, NULL, where, &given));
  if (given)
    MPMOptionsFail(o,
                   "%s does not apply: it is of loads of type force and torque; a %s has -load_%s_face, and its "
                   "-load_%s_value may be a formula of x, y, z and X, Y, Z",
                   where, load->type == MPM_LOAD_PRESSURE ? "pressure" : "traction", load->name, load->name);
  PetscCall(MPMOptionsEnum(o, "load_<l>_face", load->name, face, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * dim; k++) {
    if (!strcmp(face, "all") || !strcmp(face, MPMFaceNames[k])) load->sides |= (PetscInt)1 << k;
    MPMAppend(sides, sizeof sides, "|%s", MPMFaceNames[k]);
  }
  if (!load->sides)
    MPMOptionsFail(o, "-load_%s_face %s: -dim %" PetscInt_FMT " has the sides %s", load->name, face, dim, sides);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads on which particles of its body a load on a volume acts, and about which point. */
static PetscErrorCode ReadPlaces(const MPMGrid *grid, MPMOptions o, MPMLoad *load)
{
  PetscFunctionBeginUser;
  PetscCall(MPMOptionsExpression(o, "load_<l>_where", load->name, "XYZ", 1, &load->where));
  if (load->type != MPM_LOAD_TORQUE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsReals(o, "load_<l>_point", load->name, load->point, &load->fixed));
  if (grid->dim == 1) MPMOptionsFail(o, "-load_%s_type torque needs -dim 2 or 3: nothing turns in 1-D", load->name);
  for (PetscInt d = 0; d < grid->dim; d++)
    if (grid->periodic[d])
      MPMOptionsFail(o,
                     "-load_%s_type torque does not apply: the grid is periodic along %c, where places have no "
                     "one distance from a point",
                     load->name, "xyz"[d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLoad(const MPMScene *scene, const MPMCore *core, MPMOptions o, MPMLoad *load)
{
  const PetscInt dim                = core->grid.dim;
  char           type[MPM_NAME_LEN] = "", body[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "load_<l>_body", load->name, body, NULL));
  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++)
    if (!strcasecmp(scene->bodies[b].name, body))
      MPMOptionsFail(o, "-load_%s_body %s: loads act on particles, and %s has none; %s", load->name, body, body,
                     scene->bodies[b].rigid == MPM_RIGID_NONE ? "it is a shape for others"
                                                              : "a rigid body moves by -body_<b>_rigid moving or free");
  PetscCall(MPMOptionsDeclared(o, "load_<l>_body", load->name, scene->nbodies, scene->bodies->name,
                               sizeof *scene->bodies, &load->body));
  PetscCall(MPMOptionsEnum(o, "load_<l>_type", load->name, type, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  load->type = !strcmp(type, "pressure")   ? MPM_LOAD_PRESSURE
               : !strcmp(type, "traction") ? MPM_LOAD_TRACTION
               : !strcmp(type, "force")    ? MPM_LOAD_FORCE
                                           : MPM_LOAD_TORQUE;
  load->nc   = load->type == MPM_LOAD_PRESSURE || (load->type == MPM_LOAD_TORQUE && dim < 3) ? 1 : dim;
  PetscCall(MPMLoadIsOnVolume(load) ? ReadPlaces(&core->grid, o, load) : ReadSides(scene, dim, o, load));
  PetscCall(MPMOptionsExpression(o, "load_<l>_value", load->name, MPMLoadIsOnVolume(load) ? "t" : "xyzXYZt", load->nc,
                                 &load->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -acceleration and -loads. The first fault is left in o. */
PetscErrorCode MPMForcesSetFromOptions(MPMScene *scene, const MPMCore *core, MPMOptions o)
{

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsExpression(o, "acceleration", NULL, "xyzXYZt", core->grid.dim, &scene->acceleration));
  for (PetscInt k = 0; k < scene->nloads; k++) {
    PetscCall(ReadLoad(scene, core, o, &scene->loads[k]));
    scene->nvolume += MPMLoadIsOnVolume(&scene->loads[k]);
  }
  if (scene->nvolume && scene->nloads > MPM_MOST_LOADS)
    MPMOptionsFail(o, "-loads: %" PetscInt_FMT " loads, of which some are forces or torques; then %d are allowed",
                   scene->nloads, MPM_MOST_LOADS);
  scene->body_force  = scene->acceleration ? PETSC_TRUE : PETSC_FALSE;
  scene->forced      = scene->acceleration || scene->nloads;
  scene->keeps_start = scene->forced;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the loads and the expressions of forces. */
PetscErrorCode MPMForcesDestroy(MPMScene *scene)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExpressionDestroy(&scene->acceleration));
  for (PetscInt k = 0; k < scene->nloads; k++) {
    PetscCall(MPMExpressionDestroy(&scene->loads[k].value));
    PetscCall(MPMExpressionDestroy(&scene->loads[k].where));
  }
  PetscCall(PetscFree(scene->loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets F [dim*dim] and J F^-T of particle p. */
static void Deformation(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, PetscReal F[],
                        PetscReal cofactor[])
{
  const PetscReal J = m->state & MPM_BIT(J) ? view->J[p] : 1, axes = m->round ? 3 : (PetscReal)dim;

  if (m->state & MPM_BIT(F)) {
    for (PetscInt k = 0; k < dim * dim; k++) F[k] = view->F[p * dim * dim + k];
    MPMCofactor((int)dim, F, cofactor);
    for (PetscInt k = 0; k < dim * dim && m->round; k++) cofactor[k] *= view->F33[p];
    return;
  }
  for (PetscInt k = 0; k < dim * dim; k++) { /* a material without F has J^(1/dim) I */
    F[k]        = k % (dim + 1) ? 0 : PetscPowReal(J, 1 / axes);
    cofactor[k] = k % (dim + 1) ? 0 : PetscPowReal(J, 1 - 1 / axes);
  }
}

/* Returns the share of a traction that a side on this axis takes of a particle at the surface that has several: the
   particle's surface is as large as the sum of its normals, but two opposite sides have none. */
static PetscReal Share(PetscInt dim, const MPMBody *b, PetscInt sides, PetscInt axis)
{
  PetscReal sum = 0, squares = 0, own = 0;

  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal area = (sides >> (2 * d + 1) & 1) != (sides >> 2 * d & 1) ? 1 / b->b[d] : 0; /* for its volume */

    if (d == axis) own = area;
    sum += area;
    squares += area * area;
  }
  return own > 0 ? PetscSqrtReal(squares) / sum : 0;
}

/* Adds what a load gives particle p at time t: to b [dim], m/s^2, and to S [dim*dim], Pa. Without a stress that could
   balance S inside, as in a fluid, all of the load is a body force on the particles at the surface. */
static PetscErrorCode AddLoad(const MPMScene *scene, const MPMCore *core, const MPMLoad *load, const MPMView *view,
                              PetscInt p, PetscReal t, PetscReal b[], PetscReal S[])
{
  const PetscInt     dim = core->grid.dim, *depth = view->depth ? view->depth + 2 * dim * p : NULL;
  const MPMBody     *body  = &scene->bodies[load->body];
  const MPMKind     *kind  = &scene->kinds[view->kind ? view->kind[p] : body->kind];
  const PetscReal    whole = !body->round ? scene->kinds[body->kind].V0
                             : body->memo ? 2 * PETSC_PI * view->X[p * dim] * body->b[0] * body->b[1]
                                          : kind->V0;
  const MPMMaterial *m     = &scene->materials[body->material];
  const PetscBool    thin  = !(m->state & MPM_BIT(F));
  PetscReal          F[9], cofactor[9];

  PetscFunctionBeginUser;
  if (MPMLoadIsOnVolume(load) || view->id[p] < body->first || view->id[p] >= body->first + body->n)
    PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscInt axis = k / 2, sign = k % 2 ? 1 : -1;
    PetscReal      value[3], x[3], X[3], T[3], fall, w, away; /* away: from the particle at the surface, m */
    PetscInt       layer;

    if (!(load->sides >> k & 1) || depth[k] == 0) continue;
    layer = MPMSkinLayer(depth[k]);
    away  = sign * (PetscReal)layer * body->b[axis];
    w     = MPMSkinShare(depth[k], MPMSkinWhole(body->ppc[axis]), &fall);
    if (thin ? layer != 0 : !(w > 0)) continue;
    if (thin) w = 0, fall = 1;
    if (body->round && axis == 0) /* the surface outside of a particle is longer than its own circle, or shorter */
      fall += sign * (thin ? 0.5 : w) * body->b[axis] / view->X[p * dim];
    Deformation(dim, m, view, p, F, cofactor);
    for (PetscInt d = 0; d < dim; d++) {
      x[d] = view->x[p * dim + d] + F[d * dim + axis] * away;
      X[d] = view->X[p * dim + d] + (d == axis ? away : 0);
    }
    PetscCall(MPMExpressionEvaluate(load->value, dim, x, X, t, value));
    for (PetscInt d = 0; d < dim; d++)
      T[d] = load->type == MPM_LOAD_PRESSURE ? -value[0] * cofactor[d * dim + axis] * sign
                                             : value[d] * Share(dim, body, MPMSkinSides(depth[k]) & load->sides, axis);
    for (PetscInt d = 0; d < dim; d++) {
      b[d] += T[d] * fall / body->b[axis] * whole * MPMSkinArea(depth[k]) / kind->m;
      for (PetscInt e = 0; e < dim; e++) S[d * dim + e] += w * T[d] * sign * F[e * dim + axis];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to sum [4], N, the forces of a load on the particles of a view at time t, s, by axis, and their sizes; and lets
   lower and upper [dim], m, reach as far as the boxes of these. Not collective. */
PetscErrorCode MPMForcesAdd(const MPMScene *scene, const MPMCore *core, const MPMLoad *load, const MPMView *view,
                            PetscReal t, MPMSum sum[], PetscReal lower[], PetscReal upper[])
{
  const PetscInt   dim  = core->grid.dim;
  const PetscReal *half = scene->bodies[load->body].b;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < view->n; p++) {
    const PetscReal m    = MPMKindOf(scene->kinds, view, p)->m;
    PetscReal       b[3] = {0}, S[9] = {0}, size;

    PetscCall(AddLoad(scene, core, load, view, p, t, b, S));
    size = m * PetscSqrtReal(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    for (PetscInt d = 0; d < 3; d++) MPMSumAdd(&sum[d], m * b[d]);
    MPMSumAdd(&sum[3], size);
    for (PetscInt d = 0; d < dim && size > 0; d++) {
      lower[d] = PetscMin(lower[d], view->X[p * dim + d] - 0.5 * half[d]);
      upper[d] = PetscMax(upper[d], view->X[p * dim + d] + 0.5 * half[d]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the body force and the loads are finite at time 0 for a particle at x [dim] whose lattice place is X
   [dim], both in m; if one is not, its option is named in o. Not collective. */
PetscErrorCode MPMForcesCheck(const MPMScene *scene, const MPMCore *core, MPMOptions o, const PetscReal x[],
                              const PetscReal X[])
{

  PetscFunctionBeginUser;
  for (PetscInt k = -1; k < scene->nloads; k++) {
    const MPMExpression e        = k < 0 ? scene->acceleration : scene->loads[k].value;
    PetscReal           value[3] = {0};

    if (!e) continue;
    PetscCall(MPMExpressionEvaluate(e, core->grid.dim, x, X, 0, value));
    for (PetscInt d = 0; d < (k >= 0 ? scene->loads[k].nc : core->grid.dim); d++)
      if (!(PetscAbsReal(value[d]) <= PETSC_MAX_REAL))
        MPMOptionsFail(o, "-%s%s%s is not finite at x = %g%s at the start", k < 0 ? "acceleration" : "load_",
                       k < 0 ? "" : scene->loads[k].name, k < 0 ? "" : "_value", (double)x[0],
                       core->grid.dim > 1 ? ", ..." : "");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets S [dim*dim], Pa, to the stress that pressures give particle p, and B [dim][nc], m/s^2, and P [nc][nc], Pa, to
   the derivatives by F, of bodies of revolution then F33 (nc), of what they give it: the body force b, and S F^-T,
   which acts in the reference state. They are central differences, which are exact but for rounding, since a pressure
   is of second order in F at most. *any: it has some. The view has F and F33, which are changed and put back. Not
   collective. */
PetscErrorCode MPMForcesTangent(const MPMScene *scene, const MPMCore *core, MPMView *view, PetscInt p, PetscReal t,
                                PetscReal S[], PetscReal B[], PetscReal P[], PetscBool *any)
{
  const PetscInt  dim = core->grid.dim, n = dim * dim, nc = core->grid.round ? n + 1 : n;
  const PetscReal step = 1e-3;

  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  PetscCall(PetscArrayzero(B, dim * nc));
  PetscCall(PetscArrayzero(P, nc * nc));
  PetscCall(PetscArrayzero(S, n));
  for (PetscInt k = 0; k < scene->nloads; k++) {
    PetscReal none[3] = {0};

    if (scene->loads[k].type != MPM_LOAD_PRESSURE) continue;
    PetscCall(AddLoad(scene, core, &scene->loads[k], view, p, t, none, S));
    for (PetscInt q = 0; q < nc; q++) {
      PetscReal *F = view->F + p * n, *own = q < n ? F + q : view->F33 + p, was = *own;

      for (int side = -1; side <= 1; side += 2) {
        PetscReal b[3] = {0}, now[9] = {0}, cofactor[9], J;

        *own = was + side * step;
        PetscCall(AddLoad(scene, core, &scene->loads[k], view, p, t, b, now));
        MPMCofactor((int)dim, F, cofactor);
        J = MPMDet((int)dim, F);
        for (PetscInt d = 0; d < dim; d++) {
          B[d * nc + q] += side * b[d] / (2 * step);
          if (b[d] != 0) *any = PETSC_TRUE;
          for (PetscInt e = 0; e < n; e++) {
            const PetscReal part = now[d * dim + e % dim] * cofactor[e % dim * dim + e / dim] / J;

            P[(d * dim + e / dim) * nc + q] += side * part / (2 * step);
            if (part != 0) *any = PETSC_TRUE;
          }
        }
      }
      *own = was;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the acceleration of the body force on free rigid bodies for the time t, s: that at their centre. */
static PetscErrorCode PushRigids(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->rigids.n && scene->acceleration; k++) {
    MPMRigid *r = &core->rigids.body[k];
    PetscReal x[3];

    if (!r->free) continue;
    for (PetscInt d = 0; d < 3; d++) x[d] = r->pivot[d] + r->place[d];
    PetscCall(MPMExpressionEvaluate(scene->acceleration, core->grid.dim, x, r->pivot, t, r->pushed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the fields b, m/s^2, and S, Pa, of the particles here, and the body force on free rigid bodies, for the time t,
   s. Collective on exchange.data. */
PetscErrorCode MPMForcesUpdate(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  const PetscInt dim    = core->grid.dim;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(F) | MPM_BIT(F33) | MPM_BIT(J) |
                          MPM_BIT(depth) | MPM_BIT(kind) | MPM_BIT(chosen) | MPM_BIT(b) | MPM_BIT(S);
  MPMView       view;
  MPMVolumeLoad volume[MPM_MOST_LOADS];

  PetscFunctionBeginUser;
  PetscCall(PushRigids(scene, core, t));
  if (scene->nvolume) PetscCall(MPMVolumeLoadsSum(scene, core, t, volume));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal b[3] = {0}, S[9] = {0};

    if (scene->acceleration)
      PetscCall(MPMExpressionEvaluate(scene->acceleration, dim, view.x + p * dim, view.X + p * dim, t, b));
    MPMKnownForce(scene, dim, view.X + p * dim, t, b);
    for (PetscInt k = 0; k < scene->nloads; k++) PetscCall(AddLoad(scene, core, &scene->loads[k], &view, p, t, b, S));
    if (scene->nvolume && view.chosen[p]) {
      const MPMKind *kind = MPMKindOf(scene->kinds, &view, p);

      MPMVolumeLoadsAdd(scene, volume, dim, view.chosen[p], view.x + p * dim, kind->V0 / kind->m, b);
    }
    for (PetscInt d = 0; d < dim; d++) view.b[p * dim + d] = b[d];
    for (PetscInt k = 0; k < dim * dim && view.S; k++) view.S[p * dim * dim + k] = S[k];
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
