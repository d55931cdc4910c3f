/* stable.c - the largest stable time steps of a method, from the table stable.def. They are used before the first step,
   for the default of -dt_cfl and for warnings. */
#include "step/scheme.h"

/* The columns of the table for particles that cross cells. */
enum { FLIP, DAMPED, AFLIP_0, AFLIP_HALF, AFLIP_1, APIC, FILTERED, AFMPM, NUM_KINDS };

static const struct {
  const char *update;
  MPMBasis    basis;
  PetscReal   rest[2], crossing[NUM_KINDS];
} rows[] = {
#define MPM_GROWS(basis, update, steps)
#define MPM_STABLE(basis, update, rest, affine, ...) {#update, MPM_BASIS_##basis, {rest, affine}, {__VA_ARGS__}},
#include "step/stable.def"
#undef MPM_STABLE
#undef MPM_GROWS
};

static const struct {
  const char *update;
  MPMBasis    basis;
  PetscReal   steps;
} grows[] = {
#define MPM_GROWS(basis, update, steps) {#update, MPM_BASIS_##basis, steps},
#define MPM_STABLE(basis, update, rest, affine, ...)
#include "step/stable.def"
#undef MPM_STABLE
#undef MPM_GROWS
};

static int Kind(const MPMCore *core, const MPMMethod *method)
{
  const PetscBool affine = method->transfer->parts & MPM_AFFINE ? PETSC_TRUE : PETSC_FALSE;

  if (method->transfer->rounds == MPM_CORRECT) return AFMPM;
  if (affine && method->transfer->flip == 0) return APIC;
  if (affine) return core->params.strain > 0.5 ? AFLIP_1 : core->params.strain > 0 ? AFLIP_HALF : AFLIP_0;
  if (method->transfer->flip == 0) return FILTERED;
  return method->rate > 0 || method->viscosity > 0 || core->params.flip < 0.995 ? DAMPED : FLIP;
}

MPMStable MPMStableOf(const MPMCore *core, const MPMMethod *method)
{
  return MPMStableWith(core, method, core->basis, method->scheme->name);
}

MPMStable MPMStableWith(const MPMCore *core, const MPMMethod *method, MPMBasis basis, const char update[])
{
  const PetscBool affine = method->transfer->parts & MPM_AFFINE ? PETSC_TRUE : PETSC_FALSE;
  MPMStable       stable = {0, 0, 0.4, 0};

  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++)
    if (rows[k].basis == basis && !strcmp(rows[k].update, update)) {
      stable.crossing = rows[k].crossing[Kind(core, method)];
      stable.rest     = Kind(core, method) == AFMPM ? stable.crossing : rows[k].rest[affine];
    }
  if (stable.crossing / MPM_STABLE_MARGIN >= 0.15) /* in twentieths */
    stable.cfl = PetscMin(0.5, PetscFloorReal(stable.crossing / MPM_STABLE_MARGIN * 20 + 1e-9) / 20);
  for (size_t k = 0; k < sizeof grows / sizeof grows[0]; k++)
    if (grows[k].basis == basis && !strcmp(grows[k].update, update) && Kind(core, method) == FLIP)
      stable.grows = grows[k].steps;
  return stable;
}
