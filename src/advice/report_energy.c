/* report_energy.c - the lines of the summary about energy: what it was and is, and by which terms it changed. */
#include "advice/advice.h"

/* Described in watch.h: no wall and no rigid body gives matter a velocity, no source pushes matter into other matter, and no
   body force acts on it. */
PetscBool MPMEnergyIsFollowed(const MPMCore *core, const MPMScene *scene)
{
  if (MPMWallsHave(&scene->walls, MPM_WALL_MOVES)) return PETSC_FALSE;
  if (core->rigids.driven || core->rigids.free || core->particles.flows) return PETSC_FALSE;
  return !scene->body_force;
}

/* Prints the terms of the change of energy (-history_energy), in J and as a part of the largest energy and the work. */
static PetscErrorCode PrintTerms(const MPMCore *core, const MPMMonitor *mon, const MPMShown *shown)
{
  static const struct {
    const char *name;
    PetscInt    row;
  } terms[] = {
      {"gravity", MPM_SHOWS_energy_gravity},
      {"loads", MPM_SHOWS_load_work},
      {"walls", MPM_SHOWS_energy_walls},
      {"rigid", MPM_SHOWS_energy_rigid},
      {"friction", MPM_SHOWS_energy_friction},
      {"damping", MPM_SHOWS_energy_damping},
      {"volumes", MPM_SHOWS_energy_volumes},
      {"transfer", MPM_SHOWS_energy_transfer},
      {"laws", MPM_SHOWS_energy_laws},
      {"lag", MPM_SHOWS_energy_lag},
      {"integration", MPM_SHOWS_energy_integration},
  };
  const PetscReal base = mon->energy_max + PetscAbsReal(MPMShownWork(shown));
  PetscReal       sum  = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, "terms      of the change of energy, J, and in %% of %g J\n", (double)base));
  for (size_t k = 0; k < sizeof terms / sizeof terms[0]; k++) {
    const PetscReal value = MPMDiagnostics[terms[k].row].value(shown);

    if (!MPMDiagnosticIsOn(terms[k].row, core) && terms[k].row != MPM_SHOWS_load_work) continue;
    sum += value;
    PetscCall(MPMPrint(&core->print, "  %-12s %14.6g  %8.3f\n", terms[k].name, (double)value,
                       base > 0 ? (double)(100 * value / base) : 0));
  }
  if (core->changes.energy != 0) {
    sum += core->changes.energy;
    PetscCall(MPMPrint(&core->print, "  %-12s %14.6g  %8.3f\n", "changes", (double)core->changes.energy,
                       base > 0 ? (double)(100 * core->changes.energy / base) : 0));
  }
  PetscCall(
      MPMPrint(&core->print, "  %-12s %14.6g  %8.3f\n", "all", (double)sum, base > 0 ? (double)(100 * sum / base) : 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes whose work is in the residual, since only -history_energy sums it; or "". */
static void NotFollowed(const MPMCore *core, const MPMScene *scene, char text[MPM_TEXT_LEN])
{
  const PetscBool moving = MPMWallsHave(&scene->walls, MPM_WALL_MOVES);

  (void)snprintf(text, MPM_TEXT_LEN, "%s%s%s%s", scene->body_force ? ", body forces" : "",
                 moving ? ", moving walls" : "", core->rigids.driven ? ", rigid bodies" : "",
                 MPMDampingIsOn(core) ? ", damping" : "");
}

/* Prints the energies at the start and at the end, as the history has them, and warnings if they are doubtful. */
PetscErrorCode MPMReportEnergy(const MPMCore *core, const MPMScene *scene, const MPMMethod *method,
                               const MPMMonitor *mon, const MPMWatch *w)
{
  const MPMShown  shown = MPMMonitorShown(mon, core, scene);
  const PetscReal work = MPMShownWork(&shown), residual = MPMShownResidual(&shown);
  PetscReal       energy[2][3]; /* [start, end][kinetic, strain, rigid] */
  char            without[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  for (int k = 0; k < 2; k++) {
    const MPMTotals *t = k ? shown.now : shown.start;

    energy[k][0] = t->sum[MPM_SHOWS_kinetic_energy][0];
    energy[k][1] = t->sum[MPM_SHOWS_strain_energy][0];
    energy[k][2] = t->rigid;
  }
  PetscCall(MPMPrint(&core->print, "energy     kinetic %g -> %g J, strain %g -> %g J", (double)energy[0][0],
                     (double)energy[1][0], (double)energy[0][1], (double)energy[1][1]));
  if (core->rigids.free)
    PetscCall(MPMPrint(&core->print, ", of free rigid bodies %g -> %g J", (double)energy[0][2], (double)energy[1][2]));
  PetscCall(MPMPrint(&core->print, ", total %g -> %g J", (double)(energy[0][0] + energy[0][1] + energy[0][2]),
                     (double)(energy[1][0] + energy[1][1] + energy[1][2])));
  if (!core->energy.on) NotFollowed(core, scene, without);
  if (work != 0)
    PetscCall(MPMPrint(&core->print, ", work of %s %g J, residual %g J%s%s%s",
                       !core->energy.loads ? "gravity" : "gravity, body forces and loads", (double)work,
                       (double)residual, without[0] ? " with the work of " : "", without[0] ? without + 2 : "",
                       without[0] ? " (summed with -history_energy)" : ""));
  PetscCall(MPMPrint(&core->print, "\n"));
  if (core->energy.on) PetscCall(PrintTerms(core, mon, &shown));
  if (core->damping.kinetic)
    PetscCall(MPMPrint(&core->print, "damping    all velocities were set to 0 %" PetscInt_FMT " times\n",
                       core->damping.stops));
  if (MPMEnergyIsFollowed(core, scene) && residual > MPM_BOUND_energy_grown * (mon->energy_max + PetscAbsReal(work)))
    PetscCall(MPMWarn(&core->print, "energy grew by %.2g of its largest value, which nothing in the scene explains",
                      (double)(residual / (mon->energy_max + PetscAbsReal(work)))));
  if (w->courant > MPM_BOUND_courant)
    PetscCall(MPMWarn(&core->print, "dt reached %.3g h/(c+|v|) on the way, above the bound 1: do not trust the results",
                      (double)w->courant));
  else if (w->wave > MPMStableOf(core, method).rest * (1 + 1e-9))
    PetscCall(MPMWarn(&core->print,
                      "dt reached %.3g h/c on the way, and the method is stable up to %g: do not trust the results",
                      (double)w->wave, (double)MPMStableOf(core, method).rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
