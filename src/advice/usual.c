/* usual.c - notes numbers in the options that are far from what is usual (usual.def), with the value that was probably
   meant. Numbers are compared with other ones of the scene by ratios, which hold in any units that go together, or with
   those of nature where units are SI. It changes no state. */
#include "advice/unlikely.h"

enum { OF_ANY, OF_SOIL, OF_FLUID, OF_WATER, OF_DENSE, OF_METAL, OF_SOLID };
enum { SCALE_SI, SCALE_ONE, SCALE_WEIGHT, SCALE_MODULUS, SCALE_SHEAR, SCALE_HEAT };
enum {
  UNITS_NONE,
  UNITS_PRESSURE,
  UNITS_DENSITY,
  UNITS_ANGLE,
  UNITS_COEFFICIENT,
  UNITS_FRACTION,
  UNITS_SPEED,
  UNITS_SPECIFIC,
  UNITS_VISCOSITY,
  UNITS_TIME
};

static const struct {
  const char *option;
  int         of, scale;
  PetscReal   below, above, from, to;
  int         units;
} rows[] = {
#define MPM_USUAL(option, of, scale, below, above, from, to, units, source)                                            \
  {option, OF_##of, SCALE_##scale, below, above, from, to, UNITS_##units},
#include "advice/usual.def"
};

/* The words for the values of each kind of material, and the unit of each kind of number. */
static const char *const words[] = {"usual is",    "soils have", "liquids have", "water has", "solids as dense have",
                                    "metals have", "solids have"};
static const char *const unit[]  = {"", " Pa", " kg/m^3", " degrees", "", "", " m/s", " J/(kg K)", " Pa s", " s"};

/* Units in which a number may have been given, and what it has to be multiplied by; those of factor 0 are in Convert. */
static const struct {
  int         units;
  PetscReal   factor;
  const char *name;
} meant[] = {
    {UNITS_PRESSURE, 1e3, "kPa are meant"},
    {UNITS_PRESSURE, 1e6, "MPa are meant"},
    {UNITS_PRESSURE, 1e9, "GPa are meant"},
    {UNITS_PRESSURE, 1e-3, "it was turned into Pa twice"},
    {UNITS_PRESSURE, 1e-6, "it was turned into Pa twice"},
    {UNITS_DENSITY, 1e3, "t/m^3 or g/cm^3 are meant"},
    {UNITS_DENSITY, 1e3 / 9.81, "it is the unit weight in kN/m^3"},
    {UNITS_DENSITY, 1 / 9.81, "it is the unit weight in N/m^3"},
    {UNITS_DENSITY, 1e-3, "g/m^3 are meant"},
    {UNITS_ANGLE, 180 / PETSC_PI, "radians are meant"},
    {UNITS_ANGLE, 0, "it is a slope in per cent"},
    {UNITS_COEFFICIENT, 0, "it is an angle in degrees"},
    {UNITS_COEFFICIENT, 100, "it was turned from per cent twice"},
    {UNITS_FRACTION, 0.01, "per cent are meant"},
    {UNITS_FRACTION, 100, "it was turned from per cent twice"},
    {UNITS_SPEED, 1e3, "km/s are meant"},
    {UNITS_SPEED, 1e-3, "it is in mm/s"},
    {UNITS_SPECIFIC, 1e3, "kJ/(kg K) are meant"},
    {UNITS_VISCOSITY, 1e-3, "mPa s are meant"},
    {UNITS_VISCOSITY, 0, "it is the kinematic one, in m^2/s"},
    {UNITS_TIME, 60, "minutes are meant"},
    {UNITS_TIME, 3600, "hours are meant"},
};

/* Returns whether a row is of a material. */
static PetscBool IsOf(int of, const MPMMaterial *m)
{
  const PetscBool fluid = (m->type->traits & MPM_FLUID) != 0, loose = m->type->traits & MPM_LOOSE && !fluid;

  switch (of) {
  case OF_SOIL:
    return loose && MPMUnlikelyCohesion(m) <= 1e5;
  case OF_FLUID:
    return fluid;
  case OF_WATER:
    return fluid && m->rho > 950 && m->rho < 1050;
  case OF_DENSE:
    return !fluid && !loose && m->rho >= MPM_BOUND_dense;
  case OF_METAL:
    return !fluid && !loose && m->type->traits & MPM_PLASTIC && m->rho >= 5000;
  case OF_SOLID:
    return !fluid;
  default:
    return PETSC_TRUE;
  }
}

/* Returns what a number of material k is divided by, with the words for it; 0: it is not looked at. */
static PetscReal Scale(const MPMLook *look, PetscInt k, int scale, int units, char text[MPM_WORDS])
{
  const MPMMaterial *m  = &look->scene->materials[PetscMax(0, k)];
  const PetscBool    si = look->earth ||
                               (!MPMUnlikelyTonnes(m) &&
                                (units == UNITS_DENSITY ? MPMUnlikelyModulus(m, PETSC_FALSE) >= MPM_BOUND_si_modulus
                                                           : m->rho >= MPM_BOUND_si_density))
                              ? PETSC_TRUE
                              : PETSC_FALSE;
  const PetscBool    E  = MPMListHas(m->type->parameters, "E") ? PETSC_TRUE : PETSC_FALSE;
  PetscReal          size;

  text[0] = 0;
  switch (scale) {
  case SCALE_SI:
    return si ? 1 : 0;
  case SCALE_WEIGHT:
    size = MPMUnlikelyWeight(look, k);
    (void)snprintf(text, MPM_WORDS, "the stress by its weight, rho g H = %.3g Pa", (double)size);
    return size;
  case SCALE_MODULUS:
    (void)snprintf(text, MPM_WORDS, "-material_%s_%s", m->name, E ? "E" : "G");
    return E ? m->E : m->mu;
  case SCALE_SHEAR:
    (void)snprintf(text, MPM_WORDS, "the speed of shear waves, sqrt(G/rho)");
    return PetscSqrtReal(m->mu / m->rho);
  case SCALE_HEAT:
    (void)snprintf(text, MPM_WORDS, "c0^2/(293 K)");
    return PetscSqr(m->c0) / 293;
  default:
    return 1;
  }
}

/* Returns a number of unit j of the table `meant` in the unit of the program. */
static PetscReal Convert(const MPMLook *look, PetscInt k, size_t j, PetscReal value)
{
  if (meant[j].factor > 0) return value * meant[j].factor;
  switch (meant[j].units) {
  case UNITS_ANGLE:
    return PetscAtanReal(value / 100) * 180 / PETSC_PI;
  case UNITS_COEFFICIENT:
    return value < 90 ? PetscTanReal(value * PETSC_PI / 180) : 0;
  default:
    return value * look->scene->materials[k].rho;
  }
}

/* Tells a number of material k, or of no material (k < 0), by row r, if it is not usual. */
static PetscErrorCode Tell(const MPMLook *look, size_t r, PetscInt k, const char *name, PetscBool *told)
{
  const char *open = strchr(rows[r].option, '<');
  char        group[MPM_NAME_LEN], text[MPM_WORDS], line[MPM_TEXT_LEN];
  PetscReal   value, scale, ratio;
  MPMOdd      odd = {0};

  PetscFunctionBeginUser;
  (void)snprintf(group, sizeof group, "%.*s", open ? (int)(open - rows[r].option - 1) : MPM_NAME_LEN - 1,
                 rows[r].option);
  if (*told || (k >= 0 && !IsOf(rows[r].of, &look->scene->materials[k]))) PetscFunctionReturn(PETSC_SUCCESS);
  if (!MPMUnlikelyNumber(group, name, open ? open + 3 : "", &odd, &value) || value == 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  scale = Scale(look, k, rows[r].scale, rows[r].units, text);
  if (!(scale > 0) || PetscIsInfOrNanReal(scale) || PetscIsInfOrNanReal(value)) PetscFunctionReturn(PETSC_SUCCESS);
  ratio = value / scale;
  if (!(ratio < rows[r].below || ratio > rows[r].above)) PetscFunctionReturn(PETSC_SUCCESS);
  if (ratio >= (rows[r].units == UNITS_COEFFICIENT ? MPM_BOUND_sticks
                : rows[r].scale == SCALE_MODULUS   ? MPM_BOUND_yield_none
                                                   : PETSC_MAX_REAL))
    PetscFunctionReturn(PETSC_SUCCESS); /* it is a way to have no bound */
  if (text[0])
    (void)snprintf(line, sizeof line, "%s %s%s is %.3g times %s; %s %g to %g times it", odd.option, odd.value,
                   unit[rows[r].units], (double)ratio, text, words[rows[r].of], (double)rows[r].from,
                   (double)rows[r].to);
  else
    (void)snprintf(line, sizeof line, "%s %s%s: %s %g to %g", odd.option, odd.value, unit[rows[r].units],
                   words[rows[r].of], (double)rows[r].from, (double)rows[r].to);
  for (size_t j = 0; j < sizeof meant / sizeof meant[0]; j++) {
    const PetscReal other = meant[j].units == rows[r].units ? Convert(look, k, j, value) : -1;

    if (!(other / scale >= rows[r].from && other / scale <= rows[r].to)) continue;
    MPMAppend(line, sizeof line, "; if %s, write %.3g", meant[j].name, (double)other);
    break;
  }
  PetscCall(MPMNote(&look->core->print, "%s", line));
  *told = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMUsualNote(const MPMLook *look)
{
  const MPMScene *scene = look->scene;
  const struct {
    char        kind;
    PetscInt    n;
    const char *names;
    size_t      stride;
  } all[] = {
      {'m', scene->nmaterials, scene->materials->name, sizeof *scene->materials},
      {'c', scene->ncontacts, scene->ncontacts ? scene->contacts[0] : NULL, MPM_NAME_LEN},
      {'b', scene->nshapes, scene->nshapes ? scene->bodies[scene->nbodies].name : NULL, sizeof *scene->bodies},
      {'f', 2 * look->core->grid.dim, MPMFaceNames[0], MPM_NAME_LEN},
  };

  PetscFunctionBeginUser;
  for (size_t j = 0; j < sizeof all / sizeof all[0]; j++)
    for (PetscInt k = 0; k < all[j].n; k++) {
      PetscBool told = PETSC_FALSE;

      for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        const char *open = strchr(rows[r].option, '<');

        if (open && open[1] == all[j].kind)
          PetscCall(Tell(look, r, all[j].kind == 'm' ? k : -1, all[j].names + (size_t)k * all[j].stride, &told));
      }
    }
  for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
    PetscBool told = PETSC_FALSE;

    if (!strchr(rows[r].option, '<')) PetscCall(Tell(look, r, -1, NULL, &told));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
