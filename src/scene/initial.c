/* initial.c - bodies that start with a stress (-initial_stress) or a deformation (-body_<b>_deformation). A stress is a
   Kirchhoff stress, by the volume V0 of a particle, so that the internal forces of eq. (4) balance the weight of what
   lies above. docs/materials.md has the formulas (Initial states). It is used before the first step. */
#include <strings.h>
#include "scene/cut.h"

#define RADIANS 2    /* a smaller angle of friction is likely to be one in radians: none is above pi/2 */
#define SMALL   0.02 /* of a stress: a smaller yield stress is likely to have another unit */

/* The lattice places of a body in a line along gravity: which lie in it, and the weight per area of those above each.
   It is kept until another line is asked for, since particles are made line by line. */
typedef struct {
  PetscBool  known;
  PetscInt64 at[3];       /* its place on the other axes */
  PetscInt64 first, n;    /* the places along gravity */
  PetscReal *above, *own; /* [n] of the places above one, and of the one itself, Pa */
  PetscReal *middle;      /* [n] the place of what is in the body, m */
} Line;

struct _MPMInitial {
  PetscBool     past;   /* the run goes on from a later state, so that nothing of this acts */
  MPMExpression stress; /* Pa, of x y z; NULL: by the weight */
  PetscBool     stressed;
  PetscReal    *k0; /* [nmaterials] horizontal over vertical stress */
  PetscInt      axis;
  PetscReal     g;    /* gravity along that axis, m/s^2 */
  Line         *line; /* [nbodies] */
};

/* Sets the ratio of horizontal to vertical stress of each material. */
static PetscErrorCode ReadRatios(const MPMScene *scene, MPMInitial *in, MPMOptions o)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->nmaterials, &in->k0));
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    const MPMMaterial *m     = &scene->materials[k];
    PetscReal          angle = 0;

    if (m->type->traits & MPM_FLUID) {
      in->k0[k] = 1;
      continue;
    }
    in->k0[k] = m->lambda / (m->lambda + 2 * m->mu); /* nu/(1 - nu) */
    if (MPMListHas(m->type->parameters, "friction_angle")) {
      PetscCall(MPMOptionsReal(o, "material_<m>_friction_angle", m->name, &angle, NULL));
      in->k0[k] = 1 - PetscSinReal(angle * PETSC_PI / 180);
    }
    PetscCall(MPMOptionsReal(o, "material_<m>_k0", m->name, &in->k0[k], NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -initial_stress and -body_<b>_deformation. What goes on from a state, after a restart and in stages after the
   first, may have other materials and another gravity than the start. The first fault is left in o. Not collective. */
PetscErrorCode MPMInitialSetFromOptions(MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  const PetscInt dim = core->grid.dim, n = dim * (dim + 1) / 2 + core->grid.round;
  char           what[MPM_TEXT_LEN] = "none";
  PetscInt       axes               = 0;
  PetscBool      deformed           = PETSC_FALSE;
  MPMInitial    *in;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "initial_stress", NULL, what, NULL));
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    MPMBody *b = &scene->bodies[k];

    PetscCall(MPMOptionsExpression(o, "body_<b>_deformation", b->name, "xyz", dim * dim, &b->deformation));
    if (b->points && (b->deformation || strcasecmp(what, "none")))
      MPMOptionsFail(o, "-%s%s%s does not apply: body %s has shape file, where columns Fxx ... give the start",
                     b->deformation ? "body_" : "initial_stress", b->deformation ? b->name : "",
                     b->deformation ? "_deformation" : "", b->name);
    if (!b->deformation) continue;
    deformed = PETSC_TRUE;
    if (strcasecmp(what, "none"))
      MPMOptionsFail(o, "-body_%s_deformation does not apply: -initial_stress gives the deformation", b->name);
    if (MPMKnownStarts(scene))
      MPMOptionsFail(o, "-body_%s_deformation does not apply: -mms_type or -reference_type sets the start", b->name);
  }
  if (MPMOptionsError(o) || (!deformed && !strcasecmp(what, "none"))) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&in));
  scene->initial = in;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-restart_file", &in->past));
  if (core->stages.now > 1) in->past = PETSC_TRUE;
  if (deformed) PetscFunctionReturn(PETSC_SUCCESS);
  if (MPMKnownStarts(scene))
    MPMOptionsFail(o, "-initial_stress does not apply: -mms_type or -reference_type sets the start");
  in->stressed = PETSC_TRUE;
  if (strcasecmp(what, "k0")) {
    if (dim > 1 && !strpbrk(what, ",")) /* no formula, but a word */
      MPMOptionsFail(o, "-initial_stress %.100s: choose none, k0, or a formula of %" PetscInt_FMT " components", what,
                     n);
    PetscCall(MPMOptionsExpression(o, "initial_stress", NULL, "xyz", n, &in->stress));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt d = 0; d < dim; d++)
    if (core->params.gravity[d] != 0) {
      axes++;
      in->axis = d;
      in->g    = core->params.gravity[d];
    }
  if (axes != 1 && !in->past)
    MPMOptionsFail(o, "-initial_stress k0 needs a -gravity along one axis, not along %" PetscInt_FMT, axes);
  PetscCall(ReadRatios(scene, in, o));
  if (!in->past) PetscCall(PetscCalloc1(scene->nbodies, &in->line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes what bodies start with, for a line of the start of a run, or "". Not collective. */
void MPMInitialTell(const MPMScene *scene, char text[MPM_TEXT_LEN])
{
  const MPMInitial *in = scene->initial;

  text[0] = 0;
  if (!in || in->past) return;
  (void)snprintf(text, MPM_TEXT_LEN, "%s",
                 !in->stressed ? "deformation by formula"
                 : in->stress  ? "stress by formula"
                               : "stress by the weight above, horizontal over vertical:");
  for (PetscInt k = 0; k < scene->nmaterials && in->k0; k++)
    MPMAppend(text, MPM_TEXT_LEN, "%s %s %.4g", k ? "," : "", scene->materials[k].name, (double)in->k0[k]);
}

/* Returns the size of gravity, m/s^2, if bodies start with the stress by the weight above, else 0. Not collective. */
PetscReal MPMInitialGravity(const MPMScene *scene)
{
  return scene->initial && scene->initial->k0 ? PetscAbsReal(scene->initial->g) : 0;
}

PetscErrorCode MPMInitialDestroy(MPMScene *scene)
{
  MPMInitial *in = scene->initial;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nbodies; k++) PetscCall(MPMExpressionDestroy(&scene->bodies[k].deformation));
  if (!in) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->nbodies && in->line; k++)
    PetscCall(PetscFree3(in->line[k].above, in->line[k].own, in->line[k].middle));
  PetscCall(MPMExpressionDestroy(&in->stress));
  PetscCall(PetscFree(in->k0));
  PetscCall(PetscFree(in->line));
  PetscCall(PetscFree(scene->initial));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The weight above a place ------------------------------------------------------------------------------------- */

/* Returns which lattice place of a body, along axis d, has x, m, in its box. */
static PetscInt64 PlaceOf(const MPMBody *b, PetscInt d, PetscReal x)
{
  return (PetscInt64)PetscFloorReal((x - b->offset[d]) / b->b[d]);
}

/* Finds the line of a body's lattice places nearest to x [dim], m. */
static PetscErrorCode FindLine(const MPMScene *scene, const MPMCore *core, PetscInt body, const PetscReal x[])
{
  const MPMInitial *in  = scene->initial;
  const MPMBody    *b   = &scene->bodies[body];
  const PetscInt    dim = core->grid.dim, a = in->axis;
  Line             *line = &in->line[body];
  PetscBool         same = line->known;
  PetscReal         lower[3], upper[3], y[3], sum = 0;
  const PetscReal   layer = scene->materials[b->material].rho * PetscAbsReal(in->g) * b->b[a];

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++)
    if (d != a && PlaceOf(b, d, x[d]) != line->at[d]) same = PETSC_FALSE;
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt d = 0; d < dim; d++) {
    line->at[d] = PlaceOf(b, d, x[d]);
    y[d]        = ((PetscReal)line->at[d] + 0.5) * b->b[d] + b->offset[d];
  }
  if (!line->known) {
    MPMRegionBounds(&b->region, dim, lower, upper);
    line->first = PlaceOf(b, a, lower[a]) - 1;
    line->n     = PlaceOf(b, a, upper[a]) + 2 - line->first;
    PetscCall(PetscMalloc3(line->n, &line->above, line->n, &line->own, line->n, &line->middle));
    line->known = PETSC_TRUE;
  }
  for (PetscInt64 k = 0; k < line->n; k++) { /* from the uppermost place down */
    const PetscInt64 at = in->g < 0 ? line->n - 1 - k : k;
    PetscReal        X[3];

    y[a]             = ((PetscReal)(line->first + at) + 0.5) * b->b[a] + b->offset[a];
    line->above[at]  = sum;
    line->own[at]    = 0;
    line->middle[at] = y[a];
    if (MPMRegionInside(&b->region, dim, y)) {
      line->own[at]    = layer * (PetscReal)MPMCut(b, dim, y, X) / (PetscReal)MPMCutParts(dim);
      line->middle[at] = X[a];
    }
    sum += line->own[at];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets *weight to the weight per area of all matter above x [dim], m, in Pa: that of particles whose boxes lie above
   it, and a part of the box in which it lies, which is a half for the particle there. */
static PetscErrorCode Weight(const MPMScene *scene, const MPMCore *core, const PetscReal x[], PetscReal *weight)
{
  const MPMInitial *in = scene->initial;
  const PetscInt    a  = in->axis;

  PetscFunctionBeginUser;
  *weight = 0;
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    const MPMBody *b    = &scene->bodies[k];
    const Line    *line = &in->line[k];
    PetscInt64     at;
    PetscReal      share;

    PetscCall(FindLine(scene, core, k, x));
    at    = PetscMin(PetscMax(PlaceOf(b, a, x[a]) - line->first, 0), line->n - 1);
    share = (line->middle[at] - x[a]) / b->b[a];
    share = 0.5 + (in->g < 0 ? share : -share);
    *weight += line->above[at] + PetscMin(1, PetscMax(0, share)) * line->own[at];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds two bodies that overlap on the lines that were found last: places of which the middle is in a place of the other. */
static PetscBool Twice(const MPMScene *scene, PetscInt bodies[2])
{
  const MPMInitial *in = scene->initial;

  for (PetscInt k = 0; k < scene->nbodies * scene->nbodies; k++) {
    const PetscInt one = k / scene->nbodies, two = k % scene->nbodies;
    const Line    *own = &in->line[one], *other = &in->line[two];

    for (PetscInt64 at = 0; at < own->n && one < two; at++) {
      const PetscInt64 there = PlaceOf(&scene->bodies[two], in->axis, own->middle[at]) - other->first;

      if (!(own->own[at] > 0) || there < 0 || there >= other->n || !(other->own[there] > 0)) continue;
      bodies[0] = one;
      bodies[1] = two;
      return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* --- The state of a particle -------------------------------------------------------------------------------------- */

/* Writes components of a stress to text: those of the axes that there are, or, if `whole`, all that the dimension has. */
static void Write(PetscInt dim, PetscBool whole, const PetscReal tau[], char text[], size_t len)
{
  static const char *const names[] = {"xx", "xy", "xz", "yy", "yz", "zz"};

  text[0] = 0;
  for (int k = 0; k < (whole || dim == 3 ? MPM_SYM_NC((int)dim) : dim == 2 ? 3 : 1); k++)
    MPMAppend(text, len, "%s%s %.4g", k ? ", " : "", names[MPMSymPlace((int)dim, k)],
              (double)tau[MPMSymPlace((int)dim, k)]);
}

/* Writes what is probably wrong where a stress cannot be, "; ..."; of stresses by weight also the option that can
   change it. */
static void Hint(const MPMScene *scene, const MPMMaterial *m, PetscBool beyond, const PetscReal tau[],
                 char text[MPM_TEXT_LEN / 4])
{
  PetscInt twice[2];

  const PetscBool fluid   = (m->type->traits & MPM_FLUID) != 0;
  const PetscReal modulus = fluid ? m->K : m->lambda + 2 * m->mu;
  PetscReal       angle = 90, most = 0, yield = 0;
  char            name[3 * MPM_NAME_LEN], of[3 * MPM_NAME_LEN];

  text[0] = 0;
  (void)snprintf(name, sizeof name, "-material_%s_friction_angle", m->name);
  (void)PetscOptionsGetReal(NULL, NULL, name, &angle, NULL);
  (void)snprintf(of, sizeof of, "-material_%s_yield", m->name);
  (void)PetscOptionsGetReal(NULL, NULL, of, &yield, NULL);
  for (int d = 0; d < 3; d++) most = PetscMax(most, PetscAbsReal(tau[MPMSymIndex(d, d)]));
  if (!(most <= PETSC_MAX_REAL)) return;
  if (scene->initial->line && Twice(scene, twice))
    (void)snprintf(text, MPM_TEXT_LEN / 4, "; %s and %s overlap above it, where matter is twice; give -body_%s_cut %s",
                   scene->bodies[twice[0]].name, scene->bodies[twice[1]].name, scene->bodies[twice[0]].name,
                   scene->bodies[twice[1]].name);
  else if (scene->initial->stress && tau[0] + tau[3] + tau[5] > 0)
    (void)snprintf(text, MPM_TEXT_LEN / 4, "; compression is negative");
  else if (angle < RADIANS)
    (void)snprintf(text, MPM_TEXT_LEN / 4, "; %s %g is in degrees, as radians it would be %.3g", name, (double)angle,
                   (double)(angle * 180 / PETSC_PI));
  else if (beyond && yield > 0 && yield < SMALL * most)
    (void)snprintf(text, MPM_TEXT_LEN / 4, "; %s %g is only %.2g of it, both are in Pa", of, (double)yield,
                   (double)(yield / most));
  else if (!beyond && most > 0.1 * modulus)
    (void)snprintf(text, MPM_TEXT_LEN / 4, "; -material_%s_%s is too small for such a stress, both are in Pa", m->name,
                   fluid                                  ? "K"
                   : MPMListHas(m->type->parameters, "E") ? "E"
                                                          : "c0");
  else if (beyond && !scene->initial->stress)
    (void)snprintf(text, MPM_TEXT_LEN / 4, "; choose -material_%s_k0", m->name);
}

PetscErrorCode MPMInitialState(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal X[],
                               MPMMaterialStart *s, char wrong[MPM_TEXT_LEN])
{
  const MPMInitial  *in     = scene->initial;
  const MPMMaterial *m      = &scene->materials[b->material];
  const PetscInt     dim    = core->grid.dim;
  PetscReal          tau[6] = {0}, value[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, weight;
  const char        *why;
  char               at[128], has[256], can[256] = "", hint[MPM_TEXT_LEN / 4];

  PetscFunctionBeginUser;
  wrong[0] = 0;
  for (PetscInt d = 0; d < dim; d++) value[d * (dim + 1)] = 1;
  if (!in->stressed || in->past) {
    if (b->deformation && !in->past) PetscCall(MPMExpressionEvaluate(b->deformation, dim, X, NULL, 0, value));
    why = MPMMaterialDeformed(m, dim, value, s);
  } else {
    if (in->stress) {
      PetscCall(MPMExpressionEvaluate(in->stress, dim, X, NULL, 0, value));
      for (int d = 0, k = 0; d < dim; d++)
        for (int e = d; e < dim; e++) tau[MPMSymIndex(d, e)] = value[k++];
      if (m->round) tau[5] = value[3];
    } else {
      PetscCall(Weight(scene, core, X, &weight));
      for (int d = 0; d < 3; d++) tau[MPMSymIndex(d, d)] = d == in->axis ? -weight : -in->k0[b->material] * weight;
    }
    why = MPMMaterialStressed(m, dim, !in->stress, tau, s);
  }
  if (!why) PetscFunctionReturn(PETSC_SUCCESS);
  MPMPlaceWords(dim, X, at);
  Write(dim, !(in->stress && !m->round), tau, has, sizeof has);
  Write(dim, !(in->stress && !m->round), s->tau, can, sizeof can);
  Hint(scene, m, why[0] == 'b', tau, hint);
  if (!in->stressed)
    (void)snprintf(wrong, MPM_TEXT_LEN, "-body_%s_deformation: at %s it has an F %s", b->name, at, why);
  else
    (void)snprintf(wrong, MPM_TEXT_LEN, "-initial_stress: body %s (%s) at %s would have the stress %s Pa, %s%s%s%s%s",
                   b->name, m->type->name, at, has, why, why[0] == 'b' ? "; its law allows " : "",
                   why[0] == 'b' ? can : "", why[0] == 'b' ? " Pa" : "", hint);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMInitialSet(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal X[],
                             PetscInt p, MPMView *view)
{
  const MPMMaterial *m   = &scene->materials[b->material];
  const PetscInt     dim = core->grid.dim;
  MPMMaterialStart   s;
  char               wrong[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMInitialState(scene, core, b, X, &s, wrong)); /* nothing is wrong: that was checked before */
  for (PetscInt k = 0; k < dim * dim && view->F && (m->state & MPM_BIT(F)); k++) view->F[p * dim * dim + k] = s.F[k];
  if (view->F33 && (m->state & MPM_BIT(F33))) view->F33[p] = s.F33;
  if (view->J && (m->state & MPM_BIT(J))) view->J[p] = s.J;
  for (int k = 0; k < MPM_SYM_NC((int)dim); k++) {
    const PetscInt at = p * MPM_SYM_NC((int)dim) + k;

    if (view->be && (m->state & MPM_BIT(be))) view->be[at] = s.be[MPMSymPlace((int)dim, k)];
    if (view->tau && (m->state & MPM_BIT(tau))) view->tau[at] = s.tau[MPMSymPlace((int)dim, k)];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
