/* rest.c - the end of a run whose bodies are at rest (-time_rest), which is looked for after some steps, and what a run
   says at its end of the rest of its bodies. */
#include "advice/advice.h"

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

PetscErrorCode MPMRestTell(const MPMCore *core, const MPMTotals *now, const MPMTime *time)
{
  const MPMRest  *r     = &core->rest;
  const PetscReal share = MPMShownKineticShare(now);
  char            since[MPM_NAME_LEN] = "", ratios[3 * MPM_NAME_LEN], energy[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if (!r->on || !core->step || MPMStatusIsBad(&core->status)) PetscFunctionReturn(PETSC_SUCCESS);
  if (r->reached) (void)snprintf(since, sizeof since, "at rest since t=%g s: ", (double)r->since);
  (void)snprintf(energy, sizeof energy, "%.2g of strain energy", (double)share);
  if (!(share < 1e12)) (void)snprintf(energy, sizeof energy, "without strain energy");
  (void)snprintf(ratios, sizeof ratios, "largest force out of balance %.2g of the largest that acts, kinetic energy %s",
                 (double)r->unbalanced, energy);
  PetscCall(MPMPrint(&core->print, "rest       %s%s\n", since, ratios));
  if (r->limit > 0 && !r->reached && core->t >= time->end)
    PetscCall(MPMWarn(&core->print,
                      "the bodies are not at rest at -time_end: %s; -time_rest asks for %g over %.3g s. Go on with "
                      "-restart_file and a later -time_end (in stages a longer -stage_<s>_time), or damp the motion with "
                      "-damping_kinetic",
                      ratios, (double)r->limit, (double)MPMRestHold(core)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
