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
#define MPM_STABLE(basis, update, rest, affine, ...) {#update, MPM_BASIS_##basis, {rest, affine}, {__VA_ARGS__}},
#include "step/stable.def"
};

static const struct {
  const char *update;
  MPMBasis    basis;
  PetscReal   steps;
} grows[] = {
#define MPM_GROWS(basis, update, steps) {#update, MPM_BASIS_##basis, steps},
#include "step/stable.def"
};

static const struct {
  const char *update;
  MPMBasis    basis;
  PetscReal   steps[NUM_KINDS];
} above[] = {
#define MPM_GROWS_ABOVE(basis, update, ...) {#update, MPM_BASIS_##basis, {__VA_ARGS__}},
#include "step/stable.def"
};

static const struct {
  const char *update, *transfer;
  MPMBasis    basis;
  PetscReal   percent[2];
} wrong[] = {
#define MPM_WRONG(basis, update, transfer, least, most) {#update, #transfer, MPM_BASIS_##basis, {least, most}},
#include "step/stable.def"
};

static const PetscReal total[MPM_NUM_BASES][MPM_MAX_MASS] = {
#define MPM_STABLE_TOTAL(basis, first, second, third) [MPM_BASIS_##basis] = {first, second, third},
#include "step/stable.def"
};

/* Sets the columns of a method: that at rest, and that where particles cross cells. */
static void Columns(const MPMCore *core, const MPMMethod *method, int *rest, int *crossing)
{
  const MPMBounds bounds = method->transfer->bounds;
  const PetscReal strain = core->params.strain;
  const PetscBool damped = (PetscBool)(method->rate > 0 || method->viscosity > 0 || core->params.flip < 0.995);

  *rest     = bounds == MPM_BOUNDS_APIC || bounds == MPM_BOUNDS_AFLIP;
  *crossing = bounds == MPM_BOUNDS_AFMPM      ? AFMPM
              : bounds == MPM_BOUNDS_APIC     ? APIC
              : bounds == MPM_BOUNDS_AFLIP    ? (strain > 0.5 ? AFLIP_1
                                                 : strain > 0 ? AFLIP_HALF
                                                              : AFLIP_0)
              : bounds == MPM_BOUNDS_FILTERED ? FILTERED
              : damped                        ? DAMPED
                                              : FLIP;
}

MPMStable MPMStableOf(const MPMCore *core, const MPMMethod *method)
{
  return MPMStableWith(core, method, core->basis, method->scheme->name);
}

MPMStable MPMStableWith(const MPMCore *core, const MPMMethod *method, MPMBasis basis, const char update[])
{
  MPMStable stable = {PETSC_FALSE, PETSC_INFINITY, PETSC_INFINITY, 0.4, 0, 0};
  int       rest, crossing;

  if (method->transfer->bounds == MPM_BOUNDS_TOTAL) { /* in twentieths; beyond 0.7 the error of dt^2 leads */
    stable.known = PETSC_TRUE;
    stable.rest = stable.crossing = total[basis][method->mass - 1];
    stable.cfl                    = PetscMin(0.7, PetscFloorReal(stable.rest / MPM_STABLE_MARGIN * 20 + 1e-9) / 20);
    return stable;
  }
  Columns(core, method, &rest, &crossing);
  for (size_t k = 0; k < sizeof rows / sizeof rows[0] && method->transfer->bounds != MPM_BOUNDS_UNKNOWN; k++)
    if (rows[k].basis == basis && !strcmp(rows[k].update, update)) {
      stable.known    = PETSC_TRUE;
      stable.crossing = rows[k].crossing[crossing];
      stable.rest     = crossing == AFMPM ? stable.crossing : rows[k].rest[rest];
    }
  if (!stable.known) return stable;
  if (stable.crossing / MPM_STABLE_MARGIN >= 0.15) /* in twentieths */
    stable.cfl = PetscMin(MPM_STABLE_LONGEST, PetscFloorReal(stable.crossing / MPM_STABLE_MARGIN * 20 + 1e-9) / 20);
  for (size_t k = 0; k < sizeof grows / sizeof grows[0]; k++)
    if (grows[k].basis == basis && !strcmp(grows[k].update, update) && crossing == FLIP) stable.grows = grows[k].steps;
  for (size_t k = 0; k < sizeof above / sizeof above[0]; k++)
    if (above[k].basis == basis && !strcmp(above[k].update, update)) stable.above = above[k].steps[crossing];
  return stable;
}

PetscReal MPMStableTenfold(const MPMStable *stable, PetscReal C)
{
  if (stable->grows > 0) return stable->grows / (C * C);
  return stable->above > 0 && C > stable->crossing ? stable->above / (C - stable->crossing) : 0;
}

const PetscReal *MPMStableWrong(const MPMCore *core, const MPMMethod *method)
{
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++)
    if (wrong[k].basis == core->basis && !strcmp(wrong[k].update, method->scheme->name) &&
        !strcmp(wrong[k].transfer, method->transfer->name))
      return wrong[k].percent;
  return NULL;
}
