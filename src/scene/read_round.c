/* read_round.c - what bodies of revolution (-geometry axisymmetric) do not have, refused by name, and the affine
   velocity with which they start. It is used before the first step. */
#include "scene/scene.h"

/* Returns whether a shape is the mirror image of itself on the other side of the axis, so that the half of it where
   x >= 0 is a body of revolution. */
static PetscBool IsMirrored(const MPMRegion *r)
{
  return (r->type == MPM_REGION_sphere || r->type == MPM_REGION_annulus) && r->center[0] == 0;
}

static void CheckBody(const MPMBody *b, MPMOptions o)
{
  PetscReal lower[3], upper[3];

  if (b->points) {
    MPMOptionsFail(o, "-body_%s_shape file does not apply: with -geometry axisymmetric bodies have other shapes",
                   b->name);
    return;
  }
  if (b->deformation)
    MPMOptionsFail(o, "-body_%s_deformation does not apply: with -geometry axisymmetric give -initial_stress", b->name);
  if (b->alone && !b->rigid) return;                              /* a shape that cuts others may be anywhere */
  if (b->rigid && b->region.type == MPM_REGION_halfspace) return; /* its part in the grid is a cone */
  MPMRegionBounds(&b->region, 2, lower, upper);
  if (lower[0] < 0 && !IsMirrored(&b->region))
    MPMOptionsFail(
        o,
        "body %s crosses the axis: it reaches to x = %g, and with -geometry axisymmetric x is the radius; give "
        "the part from x = 0 on, or a sphere or annulus with its center at x = 0",
        b->name, (double)lower[0]);
}

PetscErrorCode MPMSceneCheckRound(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nbodies + scene->nshapes && !MPMOptionsError(o); k++) CheckBody(&scene->bodies[k], o);
  if (core->params.gravity[0] != 0)
    MPMOptionsFail(o, "-gravity %g along x does not apply: with -geometry axisymmetric gravity is along the axis, y",
                   (double)core->params.gravity[0]);
  if (core->grid.periodic[0])
    MPMOptionsFail(o, "-bc_xmin_type periodic does not apply: with -geometry axisymmetric x is the radius");
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    if (scene->materials[k].relaxation > 0)
      MPMOptionsFail(o, "-material_%s_relaxation does not apply: volumes are not relaxed with -geometry axisymmetric",
                     scene->materials[k].name);
  for (PetscInt k = 0; k < scene->nloads; k++)
    if (scene->loads[k].type == MPM_LOAD_TORQUE)
      MPMOptionsFail(o, "-load_%s_type torque does not apply: with -geometry axisymmetric nothing turns",
                     scene->loads[k].name);
  if (scene->known && MPMKnownStarts(scene))
    MPMOptionsFail(o, "-mms_type and -reference_type do not apply: with -geometry axisymmetric the known solution is "
                      "-reference_type expression");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the affine velocity C [dim*dim], 1/s, with which a particle at x [dim], m, of a body of revolution starts: the
   gradient of the body's velocity, of which the strain rate counts by its share. In planes C starts as 0, with which a
   uniform expansion is right in the first step too; here it would not be so near the axis. */
PetscErrorCode MPMSceneStartAffine(const MPMCore *core, const MPMBody *b, const PetscReal x[], PetscReal C[])
{
  const PetscInt dim = core->grid.dim;
  PetscReal      L[9];

  PetscFunctionBeginUser;
  for (PetscInt e = 0; e < dim; e++) {
    const PetscReal by   = 0x1p-10 * b->b[e];
    PetscReal       y[3] = {0}, lower[3], upper[3];

    PetscCall(PetscArraycpy(y, x, dim));
    y[e] = x[e] - by;
    PetscCall(MPMExpressionEvaluate(b->velocity, dim, y, NULL, 0, lower));
    y[e] = x[e] + by;
    PetscCall(MPMExpressionEvaluate(b->velocity, dim, y, NULL, 0, upper));
    for (PetscInt d = 0; d < dim; d++) L[d * dim + e] = (upper[d] - lower[d]) / (2 * by);
  }
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt e = 0; e < dim; e++)
      C[d * dim + e] = core->params.strain * 0.5 * (L[d * dim + e] + L[e * dim + d]) +
                       0.5 * (L[d * dim + e] - L[e * dim + d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
