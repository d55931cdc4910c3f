/* ranges.c - laws that leave the range for which they were made: the rows of physics/range.def. It is used after steps
   and where a run stops, and changes no state. */
#include "advice/watch.h"

/* --- Measures ----------------------------------------------------------------------------------------------------- */

/* A particle p of a view, of a material, and how far it is out of the range. Each measure has the words that tell it.
   */
typedef PetscReal (*Measure)(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p);

/* Computes the angle of the rotation R of F = V R, in rad, and the principal stretches [3]. */
static PetscReal Polar(PetscInt dim, const PetscReal F[], PetscReal stretch[3])
{
  PetscReal b[6], n[3][3], trace = 0;

  stretch[0] = stretch[1] = stretch[2] = 1;
  if (dim == 1) stretch[0] = F[0];
  if (dim == 2) {
    const PetscReal c = F[0] + F[3], s = F[2] - F[1], sum = PetscSqrtReal(c * c + s * s),
                    difference = PetscSqrtReal(PetscSqr(F[0] - F[3]) + PetscSqr(F[1] + F[2]));

    stretch[0] = 0.5 * (sum + difference);
    stretch[1] = 0.5 * (sum - difference);
    return PetscAbsReal(PetscAtan2Real(s, c));
  }
  if (dim < 3) return 0;
  MPMLeftCauchyGreen(3, F, b);
  MPMEigen(3, b, stretch, n);
  for (PetscInt k = 0; k < 3; k++) {
    stretch[k] = PetscSqrtReal(stretch[k]);
    for (PetscInt d = 0; d < 9; d++) trace += n[k][d / 3] * F[d] * n[k][d % 3] / stretch[k];
  }
  return PetscAcosReal(PetscMax(-1, PetscMin(1, 0.5 * (trace - 1))));
}

/* Returns whether F is so near to 1 that neither turn nor strain counts. */
static PetscBool IsSmall(PetscInt dim, const PetscReal F[])
{
  PetscReal size2 = 0;

  for (PetscInt k = 0; k < dim * dim; k++) size2 += PetscSqr(F[k] - (k % (dim + 1) ? 0 : 1));
  return size2 < 0.08 * 0.08;
}

static PetscReal Measure_turn(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p)
{
  PetscReal stretch[3];

  (void)m;
  return IsSmall(dim, view->F + p * dim * dim) ? 0 : Polar(dim, view->F + p * dim * dim, stretch) * 180 / PETSC_PI;
}

static PetscReal Measure_strain(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p)
{
  PetscReal stretch[3], most = 0;

  (void)m;
  if (IsSmall(dim, view->F + p * dim * dim)) return 0;
  (void)Polar(dim, view->F + p * dim * dim, stretch);
  for (PetscInt k = 0; k < 3; k++) most = PetscMax(most, PetscAbsReal(stretch[k] - 1));
  return most;
}

/* A gas may be compressed by any part of its volume. */
static PetscReal Measure_compression(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p)
{
  (void)dim;
  return MPMMaterialIsGas(m) ? 0 : 1 - view->J[p];
}

static PetscReal Measure_heat(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p)
{
  (void)dim;
  return m->melting > m->temperature ? view->theta[p] / (m->melting - m->temperature) : 0;
}

/* How a measure is told. */
#define MPM_TOLD_turn        "has turned by %.3g degrees"
#define MPM_TOLD_strain      "is strained by %.3g"
#define MPM_TOLD_compression "is compressed by %.3g of its volume"
#define MPM_TOLD_heat        "has come %.3g of the way to where it melts"

static const struct {
  const char *law;
  Measure     measure;
  PetscReal   share, warn, stop;
  const char *told, *remedy;
} rows[] = {
#define MPM_RANGE(law, measure, share, warn, stop, remedy)                                                             \
  {#law, Measure_##measure, share, warn, stop, MPM_TOLD_##measure, remedy},
#include "physics/range.def"
};
#define NROWS ((PetscInt)(sizeof rows / sizeof rows[0]))
_Static_assert(sizeof rows / sizeof rows[0] <= MPM_MAX_RANGES, "MPM_MAX_RANGES is too small");

/* --- A look at all ------------------------------------------------------------------------------------------------ */

PetscInt MPMRangesOf(const MPMScene *scene)
{
  PetscInt bits = 0;

  for (PetscInt r = 0; r < NROWS; r++)
    for (PetscInt m = 0; m < scene->nmaterials; m++)
      if (!strcmp(scene->materials[m].type->name, rows[r].law)) bits |= 1 << r;
  return bits;
}

PetscErrorCode MPMRangesLook(MPMCore *core, PetscInt asked, PetscInt *beyond, PetscInt *lost, MPMFound most[])
{
  const PetscInt dim    = core->grid.dim;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(F) | MPM_BIT(J) | MPM_BIT(theta);
  PetscInt64     n[2][MPM_MAX_RANGES] = {{0}}; /* particles beyond the bound, and of the law */
  MPMView        view;

  PetscFunctionBeginUser;
  *beyond = *lost = 0;
  if (!asked) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt r = 0; r < NROWS; r++) most[r] = (MPMFound){-1, -1, {0}, {0}};
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMMaterial *m = core->params.materials + MPMKindOf(core->params.kinds, &view, p)->material;

    for (PetscInt r = 0; r < NROWS; r++) {
      MPMFound found = {0, 16 * view.id[p], {0}, {0}};

      if (!(asked & 1 << r) || strcmp(m->type->name, rows[r].law)) continue;
      found.value = rows[r].measure(dim, m, &view, p);
      n[1][r]++;
      n[0][r] += found.value > rows[r].warn;
      if (!(found.value > rows[r].warn)) continue;
      for (PetscInt d = 0; d < dim; d++) found.x[d] = view.x[p * dim + d];
      MPMFoundTake(&most[r], &found);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 2 * MPM_MAX_RANGES, MPIU_INT64, MPI_SUM, core->exchange.data));
  for (PetscInt r = 0; r < NROWS; r++) {
    if (!(n[0][r] > 0 && (PetscReal)n[0][r] > rows[r].share * (PetscReal)n[1][r])) continue;
    PetscCall(MPMFoundAgree(&most[r], core->exchange.data));
    most[r].of[0] = (PetscReal)n[0][r];
    *beyond |= 1 << r;
    if (rows[r].stop > 0 && most[r].value > rows[r].stop) *lost |= 1 << r;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMRangesTell(const MPMScene *scene, PetscInt dim, PetscInt row, const MPMFound *most, char text[MPM_TEXT_LEN])
{
  const MPMBody     *b = &scene->bodies[MPMBodyOf(scene, most->key / 16, 0)];
  const MPMMaterial *m = &scene->materials[b->material];
  char               place[MPM_NAME_LEN];

  MPMPlaceWords(dim, most->x, place);
  (void)snprintf(text, MPM_TEXT_LEN, "%s, of %s, is out of its range: particle %" PetscInt64_FMT " of %s at %s ",
                 rows[row].law, m->name, most->key / 16, b->name, place);
  MPMAppend(text, MPM_TEXT_LEN, rows[row].told, (double)most->value);
  MPMAppend(text, MPM_TEXT_LEN, " (up to %g is right)", (double)rows[row].warn);
}

void MPMRangesCure(const MPMScene *scene, PetscInt row, const MPMFound *most, char text[MPM_TEXT_LEN])
{
  const MPMBody *b = &scene->bodies[MPMBodyOf(scene, most->key / 16, 0)];

  (void)snprintf(text, MPM_TEXT_LEN, rows[row].remedy, scene->materials[b->material].name);
}
