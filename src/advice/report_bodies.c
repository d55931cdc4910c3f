/* report_bodies.c - what a run prints of its bodies before the first step: shape, material, particles, mass and volume,
   so that a wrong unit or place shows. */
#include "advice/advice.h"
#include "scene/points.h"

#define SHOWN 8 /* bodies that get a line of their own; the others share one */

/* Counts the particles of the first bodies, n [shown + 1] with those of all others last, and sums mass and volume of
   those bodies, sum [shown][2], whose particles may differ in them. Collective on the exchange. */
static PetscErrorCode CountParticles(MPMCore *core, const MPMScene *scene, PetscInt shown, PetscInt64 n[],
                                     MPMSum (*sum)[2])
{
  const MPMBody *bodies = scene->bodies;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(kind);
  MPMView        view;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b <= shown; b++) n[b] = 0;
  for (PetscInt b = 0; b < shown; b++) {
    MPMSumZero(&sum[b][0]);
    MPMSumZero(&sum[b][1]);
  }
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMKind *kind = MPMKindOf(scene->kinds, &view, p);
    PetscInt       b    = 0;

    while (b < shown && (view.id[p] < bodies[b].first || view.id[p] >= bodies[b].first + bodies[b].n)) b++;
    n[b]++;
    if (b == shown) continue;
    MPMSumAdd(&sum[b][0], kind->m);
    MPMSumAdd(&sum[b][1], kind->V0);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, (PetscMPIInt)shown + 1, MPIU_INT64, MPI_SUM, core->exchange.data));
  PetscCall(MPMSumReduce(sum[0], 2 * shown, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the name of the first body that has a copy of the nodes. */
static const char *BodyOf(const MPMScene *scene, PetscInt copy)
{
  PetscInt b = 0;

  while (b + 1 < scene->nbodies && scene->bodies[b].copy != copy) b++;
  return scene->bodies[b].name;
}

static const char *const per[] = {" for a cross-section of 1 m^2", " for a thickness of 1 m", ""};

/* Prints which bodies meet, and how. */
static PetscErrorCode ReportContacts(const MPMCore *core, const MPMScene *scene)
{
  PetscInt declared = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; core->contacts && k < core->contacts->npairs; k++) {
    const MPMPair *pair = &core->contacts->pair[k];

    if (pair->rigid || pair->glued || ++declared > SHOWN) continue;
    PetscCall(MPMPrint(&core->print, "contact    %s and %s: ", BodyOf(scene, pair->a), BodyOf(scene, pair->b)));
    PetscCall(pair->mu < PETSC_INFINITY ? MPMPrint(&core->print, "friction %g\n", (double)pair->mu)
                                        : MPMPrint(&core->print, "nothing slides\n"));
  }
  for (PetscInt k = 0; k < PetscMin(SHOWN, core->rigids.n); k++) {
    const MPMRigid *r = &core->rigids.body[k];

    PetscCall(MPMPrint(&core->print, "rigid      %s: %s, %s, ", r->name, MPMRegionNames[r->shape->type],
                       r->free    ? "free"
                       : r->moves ? "moving"
                                  : "fixed"));
    PetscCall(r->tied ? MPMPrint(&core->print, "tied") : MPMPrint(&core->print, "friction %g", (double)r->mu));
    if (r->free)
      PetscCall(MPMPrint(&core->print, ", %g kg%s", (double)r->mass, per[core->grid.round ? 2 : core->grid.dim - 1]));
    PetscCall(MPMPrint(&core->print, "\n"));
  }
  if (core->rigids.n > SHOWN)
    PetscCall(MPMPrint(&core->print, "rigid      and %" PetscInt_FMT " more\n", core->rigids.n - SHOWN));
  if (declared > SHOWN)
    PetscCall(MPMPrint(&core->print, "contact    of %" PetscInt_FMT " more pairs of bodies\n", declared - SHOWN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Directions along which it is seen whether bodies lie apart, those of 1-D, 2-D and 3-D first. */
static const PetscInt ways[][3] = {{1, 0, 0}, {0, 1, 0},  {1, 1, 0}, {1, -1, 0}, {0, 0, 1},  {1, 0, 1},  {1, 0, -1},
                                   {0, 1, 1}, {0, 1, -1}, {1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {1, -1, -1}};
static const PetscInt nways[]   = {1, 4, 13};
#define WAYS (sizeof ways / sizeof ways[0])

/* Returns whether two bodies lie more than two cells apart along a direction. A, B [WAYS][2]: how far the centres of their
   particles reach along each direction and against it, m, or PETSC_MIN_REAL if there are none. */
static PetscBool AreApart(const MPMGrid *grid, PetscReal A[][2], PetscReal B[][2])
{
  if (A[0][0] == PETSC_MIN_REAL || B[0][0] == PETSC_MIN_REAL) return PETSC_FALSE;
  for (PetscInt k = 0; k < nways[grid->dim - 1]; k++) {
    PetscReal cell2 = 0;

    for (PetscInt d = 0; d < grid->dim; d++) cell2 += PetscSqr((PetscReal)ways[k][d] * grid->h[d]);
    if (PetscMax(-A[k][0] - B[k][1], -A[k][1] - B[k][0]) > 2 * PetscSqrtReal(cell2)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Prints what bodies that lie apart will do where they meet, if there is no contact. Collective on exchange.data. */
static PetscErrorCode ReportSticking(MPMCore *core, const MPMScene *scene)
{
  const PetscInt dim = core->grid.dim, nb = scene->nbodies;
  PetscReal(*reach)[WAYS][2]; /* [nb] */
  PetscMPIInt count;
  MPMView     view;
  PetscBool   told = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (core->contacts || core->grid.total || nb < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(nb, &reach));
  for (PetscInt b = 0; b < nb; b++)
    for (size_t k = 0; k < WAYS; k++) reach[b][k][0] = reach[b][k][1] = PETSC_MIN_REAL;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(x) | MPM_BIT(id), &view));
  for (PetscInt p = 0, b = 0; p < view.n; p++) {
    b = MPMBodyOf(scene, view.id[p], b);
    for (PetscInt k = 0; k < nways[dim - 1]; k++) {
      PetscReal along = 0;

      for (PetscInt d = 0; d < dim; d++) along += (PetscReal)ways[k][d] * view.x[p * dim + d];
      reach[b][k][0] = PetscMax(reach[b][k][0], along);
      reach[b][k][1] = PetscMax(reach[b][k][1], -along);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(x) | MPM_BIT(id), &view));
  PetscCall(PetscMPIIntCast((PetscInt)(2 * WAYS) * nb, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, reach, count, MPIU_REAL, MPIU_MAX, core->exchange.data));
  for (PetscInt a = 0; a < nb; a++)
    for (PetscInt b = a + 1; b < nb && !told; b++) {
      if (!AreApart(&core->grid, reach[a], reach[b])) continue;
      told = PETSC_TRUE;
      PetscCall(MPMPrint(&core->print,
                         "contact    none: where %s and %s meet they act on each other from about a cell apart, stick, "
                         "and do not slide; -contact_mu 0.3 lets bodies touch, slide and part\n",
                         scene->bodies[a].name, scene->bodies[b].name));
    }
  PetscCall(PetscFree(reach));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportBodies(MPMCore *core, const MPMScene *scene)
{
  const PetscInt shown = scene->nbodies > SHOWN + 1 ? SHOWN : scene->nbodies;
  PetscInt64     n[SHOWN + 2];
  MPMSum         sum[SHOWN + 1][2];
  char           at[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(CountParticles(core, scene, shown, n, sum));
  for (PetscInt b = 0; b < shown; b++) {
    const MPMBody  *body = &scene->bodies[b];
    const PetscReal mass = MPMSumValue(&sum[b][0]), volume = MPMSumValue(&sum[b][1]);

    PetscCall(MPMPrint(&core->print, "body       %s: %s", body->name, MPMRegionNames[body->region.type]));
    if (!body->points || !body->points->material)
      PetscCall(MPMPrint(&core->print, " of %s", scene->materials[body->material].name));
    PetscCall(MPMPrint(&core->print, ", %" PetscInt64_FMT " particles, %.6g kg, %.6g m^3%s\n", n[b], (double)mass,
                       (double)volume, core->grid.round ? " in full turns" : per[core->grid.dim - 1]));
  }
  for (PetscInt b = 0; b < shown; b++) {
    const MPMSource *s = &scene->bodies[b].source;

    if (!s->on) continue;
    MPMPlaceWords(core->grid.dim, s->v, at);
    PetscCall(MPMPrint(&core->print,
                       "source     %s: %" PetscInt64_FMT " particles flow in from t=%g to %g s, with %s m/s\n",
                       scene->bodies[b].name, scene->bodies[b].n, (double)s->from, (double)s->to, at));
  }
  if (shown < scene->nbodies)
    PetscCall(MPMPrint(&core->print,
                       "body       and %" PetscInt_FMT " more bodies with %" PetscInt64_FMT " particles together\n",
                       scene->nbodies - shown, n[shown]));
  PetscCall(ReportContacts(core, scene));
  PetscCall(ReportSticking(core, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportMet(const MPMCore *core)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->rigids.n; k++) {
    const MPMRigid *r = &core->rigids.body[k];

    if (!r->moves || r->free || r->met) continue;
    PetscCall(MPMNote(
        &core->print,
        "the rigid body %s moved, but met nothing: its reaction was 0 all the time; check its place, -body_%s_velocity and -time_end",
        r->name, r->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
