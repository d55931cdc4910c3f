/* rest.c - the end of a run whose bodies are at rest (-time_rest), which is looked for after some steps, and what a run
   says at its end of the rest of its bodies. */
#include "advice/advice.h"

#define SHOWN 6  /* bodies whose displacements are printed */
#define EVERY 16 /* steps between looks: a number of steps, so that a restart changes nothing */

PetscErrorCode MPMRestLook(MPMCore *core, const MPMScene *scene)
{
  const MPMRest *r     = &core->rest;
  PetscReal      share = PETSC_INFINITY;
  MPMTotals      now;

  PetscFunctionBeginUser;
  if (!(r->limit > 0) || core->step % EVERY || core->stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (r->unbalanced <= r->limit) { /* else the sums over all particles are not needed */
    PetscCall(MPMTotalsCompute(scene, core, &now));
    if (now.wrong < 0) share = MPMShownKineticShare(&now);
  }
  MPMRestNote(core, share);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says how far the particle of each body that has gone farthest is from where it was at first, on a periodic axis the shorter
   way: what has slid is at rest too. */
static PetscErrorCode TellMoved(MPMCore *core, const MPMScene *scene)
{
  const MPMGrid *grid   = &core->grid;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X), dim = grid->dim;
  PetscReal     *far, rest                                           = -1;
  PetscInt       shown              = 0;
  char           text[MPM_TEXT_LEN] = "";
  MPMView        view;

  PetscFunctionBeginUser;
  if (!core->particles.present[MPM_FIELD_INDEX_X])
    PetscFunctionReturn(PETSC_SUCCESS); /* what flows in has no place at the start */
  PetscCall(PetscMalloc1(scene->nbodies, &far));
  for (PetscInt b = 0; b < scene->nbodies; b++) far[b] = -1; /* it has no particles */
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0, b = 0; p < view.n; p++) {
    PetscReal sum = 0;

    b = MPMBodyOf(scene, view.id[p], b);
    for (PetscInt d = 0; d < dim; d++) {
      const PetscReal length = grid->upper[d] - grid->lower[d];
      PetscReal       way    = view.x[p * dim + d] - view.X[p * dim + d];

      if (grid->periodic[d]) way -= length * round(way / length);
      sum += way * way;
    }
    far[b] = PetscMax(far[b], PetscSqrtReal(sum));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, far, (PetscMPIInt)scene->nbodies, MPIU_REAL, MPI_MAX, core->exchange.data));
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    const size_t n = strlen(text);

    if (far[b] < 0) continue;
    if (shown++ < SHOWN)
      (void)snprintf(text + n, sizeof text - n, "%s%s by %.3g m", n ? ", " : "", scene->bodies[b].name, (double)far[b]);
    else
      rest = PetscMax(rest, far[b]);
  }
  if (shown) PetscCall(MPMPrint(&core->print, "moved      since the start, at the most: %s", text));
  if (shown > SHOWN)
    PetscCall(MPMPrint(&core->print, ", %" PetscInt_FMT " others by %.3g m", shown - SHOWN, (double)rest));
  if (shown) PetscCall(MPMPrint(&core->print, "; a cell is %.3g m\n", (double)MPMGridSmallestH(grid)));
  PetscCall(PetscFree(far));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestTell(MPMCore *core, const MPMScene *scene, const MPMTotals *now, const MPMTime *time)
{
  const MPMRest  *r                   = &core->rest;
  const PetscReal share               = MPMShownKineticShare(now);
  char            since[MPM_NAME_LEN] = "", ratios[3 * MPM_NAME_LEN], energy[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if ((!r->on && !core->implicit) || !core->step || MPMStatusIsBad(&core->status)) PetscFunctionReturn(PETSC_SUCCESS);
  if (core->implicit) {
    PetscCall(TellMoved(core, scene));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (r->reached) (void)snprintf(since, sizeof since, "at rest since t=%g s: ", (double)r->since);
  (void)snprintf(energy, sizeof energy, "%.2g of strain energy", (double)share);
  if (!(share < 1e12)) (void)snprintf(energy, sizeof energy, "without strain energy");
  (void)snprintf(ratios, sizeof ratios, "largest force out of balance %.2g of the largest that acts, kinetic energy %s",
                 (double)r->unbalanced, energy);
  PetscCall(MPMPrint(&core->print, "rest       %s%s\n", since, ratios));
  PetscCall(TellMoved(core, scene));
  if (r->limit > 0 && !r->reached && core->t >= time->end)
    PetscCall(
        MPMWarn(&core->print,
                "the bodies are not at rest at -time_end: %s; -time_rest asks for %g over %.3g s. Go on with "
                "-restart_file and a later -time_end (in stages a longer -stage_<s>_time), or damp the motion with "
                "-damping_kinetic",
                ratios, (double)r->limit, (double)MPMRestHold(core)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
