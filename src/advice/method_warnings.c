/* method_warnings.c - what makes a method doubtful in a scene: settings that are unstable, or that were measured to
   give wrong answers (docs/choosing.md). Each is one line before the first step, which names the setting and another
   one that works. */
#include <stdarg.h>
#include "advice/advice.h"

/* Prints a warning that begins with the name of the method. */
static PetscErrorCode Warn(const MPMCore *core, const MPMMethod *method, const char format[], ...)
    PETSC_ATTRIBUTE_FORMAT(3, 4);
static PetscErrorCode Warn(const MPMCore *core, const MPMMethod *method, const char format[], ...)
{
  char    text[MPM_TEXT_LEN];
  va_list args;

  PetscFunctionBeginUser;
  va_start(args, format);
  (void)vsnprintf(text, sizeof text, format, args);
  va_end(args);
  PetscCall(MPMWarn(&core->print, "%s with %s and %s %s", MPMBasisNames[core->basis], method->scheme->name,
                    method->transfer->name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The option for shorter steps, behind which a number has to stand. */
#define SHORTER_STEPS(time) (time->fixed > 0 ? "-dt_size auto -dt_cfl" : "-dt_cfl")

const char *MPMMethodSpline(void)
{
  PetscBool given;

  if (PetscOptionsHasName(NULL, NULL, "-method_gimp_update", &given) || !given) return "-method_basis bspline2";
  return "-method_basis bspline2 without -method_gimp_update";
}

static PetscBool IsAdvised(const MPMMethod *method)
{
  return !strcmp(method->scheme->name, MPM_UPDATE_ADVISED);
}

/* Writes the options of a method like this one that is stable where particles cross cells with steps of C = c dt/h: usl
   with the same basis, or with quadratic splines, with shorter steps if it needs them. */
static void Stable(const MPMCore *core, const MPMMethod *method, const MPMTime *time, PetscReal C,
                   char options[MPM_TEXT_LEN])
{
  const MPMBasis  own = core->basis, basis[] = {own, MPM_BASIS_bspline2};
  const PetscBool usl = IsAdvised(method);

  for (PetscInt k = 0; k < 2; k++) {
    const MPMStable stable           = MPMStableWith(core, method, basis[k], MPM_UPDATE_ADVISED);
    char            dt[MPM_NAME_LEN] = "";

    if (!(stable.crossing > 0) || (!k && (usl || stable.crossing < C))) continue;
    if (stable.crossing < C) (void)snprintf(dt, sizeof dt, " %s %g", SHORTER_STEPS(time), (double)stable.cfl);
    (void)snprintf(options, MPM_TEXT_LEN, "%s%s%s%s", usl ? "" : "-method_update " MPM_UPDATE_ADVISED,
                   basis[k] != own && !usl ? " " : "", basis[k] != own ? MPMMethodSpline() : "", dt);
    return;
  }
}

/* Returns a number with two digits, for texts. */
static PetscReal Round(PetscReal x)
{
  const PetscReal scale = x > 0 ? PetscPowReal(10, PetscFloorReal(PetscLog10Real(x)) - 1) : 1;

  return PetscFloorReal(x / scale + 0.5) * scale;
}

/* Warns of steps that are too long for the method, or notes that nothing is known of them. The remedy must not lead to
   the next warning: noise in n steps of C grows with n C^2, and in a given time with C. */
static PetscErrorCode WarnOfSteps(const MPMCore *core, const MPMMethod *method, const MPMTime *time, PetscReal dt)
{
  const MPMStable stable = MPMStableOf(core, method);
  const PetscReal C = MPMWaveCourant(core, dt), courant = MPMCourant(core, dt), grows = MPMStableTenfold(&stable, C);
  const PetscReal end   = (PetscReal)core->step + (time->end - core->t) / dt,
                  steps = PetscMin(end, (PetscReal)time->max_steps);
  const PetscReal most  = stable.grows > 0      ? stable.grows / (end * C)
                          : stable.crossing > 0 ? stable.crossing
                                                : stable.rest;
  const PetscReal use = PetscMin(stable.cfl, 0.99 * most >= 0.1 ? PetscFloorReal(99 * most) / 100 : Round(0.9 * most));
  char            cure[MPM_TEXT_LEN] = "", shorter[MPM_TEXT_LEN], when[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  (void)snprintf(shorter, sizeof shorter, "%s %g", SHORTER_STEPS(time), (double)use);
  if (use < MPM_BOUND_short_remedy || stable.crossing == 0)
    Stable(core, method, time, 0, cure); /* such short steps are hardly meant */
  if (cure[0])
    (void)snprintf(shorter, sizeof shorter, "%.1800s %s", cure, time->fixed > 0 ? "-dt_size auto" : "-dt_cfl 0.4");
  if (!stable.known)
    PetscCall(MPMNote(
        &core->print,
        "it has not been measured up to which time step %s with %s and %s is stable; compare with a run of half of it",
        MPMBasisNames[core->basis], method->scheme->name, method->transfer->name));
  if (C > PetscMax(stable.rest, stable.cfl) * (1 + 1e-9)) /* what is unstable at any step is told below */
    PetscCall(Warn(core, method, "is stable up to dt = %g h/c, and dt is %.3g h/c: expect the run to blow up; use %s",
                   (double)stable.rest, (double)C, shorter));
  else if (courant > MPM_BOUND_courant)
    PetscCall(Warn(core, method,
                   "has dt = %.3g h/(c+|v|), above 1: expect the run to blow up where matter moves; use %s",
                   (double)courant, shorter));
  else if (stable.crossing > 0 && C > stable.crossing * (1 + 1e-9) && steps > grows) {
    Stable(core, method, time, C, cure);
    if (stable.above > 0)
      (void)snprintf(when, sizeof when, ", at the fastest tenfold in %g of the %.0f steps", (double)Round(grows),
                     (double)steps);
    if (!(stable.grows > 0))
      PetscCall(Warn(core, method,
                     "amplifies noise where particles cross cells if dt is above %g h/c (here %.3g)%s; use %s%s%s",
                     (double)stable.crossing, (double)C, when, cure, use < MPM_BOUND_short_remedy ? "" : " or ",
                     use < MPM_BOUND_short_remedy ? "" : shorter));
    else
      PetscCall(Warn(core, method,
                     "amplifies noise where particles cross cells, tenfold in about %g of the %.0f steps; use %s",
                     (double)Round(grows), (double)steps, cure));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of methods that gave wrong answers. */
static PetscErrorCode WarnOfMethod(const MPMCore *core, const MPMMethod *method, const MPMTime *time)
{
  const MPMTransfer *transfer           = method->transfer;
  const PetscBool    linear             = core->basis == MPM_BASIS_linear;
  const PetscReal   *wrong              = MPMStableWrong(core, method);
  char               cure[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  if (MPMStableOf(core, method).crossing == 0) {
    Stable(core, method, time, 0, cure);
    PetscCall(Warn(core, method, "is unstable where particles cross cells%s; use %s",
                   linear ? ": nodes with almost no mass get arbitrary velocity gradients" : "",
                   core->params.strain > 0 && transfer->flip < 0 && !linear && IsAdvised(method)
                       ? "-method_affine_strain 0"
                       : cure));
  } else if (transfer->bounds == MPM_BOUNDS_FILTERED && (transfer->rounds != MPM_FILTER || core->params.order == 1))
    PetscCall(Warn(core, method,
                   "stops all motion in the time in which a wave crosses some cells; use -method_transfer aflip"));
  else if (wrong)
    PetscCall(Warn(core, method,
                   "was wrong by %g to %g %% on a manufactured solution; use -method_update " MPM_UPDATE_ADVISED,
                   (double)wrong[0], (double)wrong[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns if bodies differ so much in stiffness, or steps are so short, that what a transfer loses in each step counts.
   */
static PetscErrorCode WarnOfLoss(const MPMCore *core, const MPMScene *scene, const MPMMethod *method, PetscReal dt)
{
  PetscReal least = PETSC_MAX_REAL, c2 = core->status.c2;

  PetscFunctionBeginUser;
  if (method->rate != 0 || method->viscosity != 0 || !(core->params.flip < 1)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    const MPMMaterial *m = &scene->materials[k];

    least = PetscMin(least, (m->K > 0 ? m->K : m->lambda + 2 * m->mu) / m->rho);
  }
  if (least * MPM_BOUND_stiff < c2)
    PetscCall(Warn(core, method,
                   "loses energy in each step, and the steps are those of the stiffest body: the softest one loses "
                   "most of its motion; use -method_transfer aflip -method_flip 1"));
  else if (MPMCourant(core, dt) < MPM_BOUND_short_step)
    PetscCall(Warn(core, method,
                   "loses energy in each step, however short; use -method_transfer aflip, or -method_damping_rate"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns if a body spins and the transfer does not keep rotation. Sums for each body: m, m x [3], m v [3], m |x|^2,
   m |v|^2, and the moment m x cross v [3]. */
static PetscErrorCode WarnOfSpin(MPMCore *core, const MPMScene *scene, const MPMMethod *method, PetscReal end)
{
  enum { M, X, V = X + 3, XX = V + 3, VV, L, N = L + 3 };
  const PetscInt  dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v);
  const PetscBool affine = (method->transfer->parts & MPM_AFFINE) != 0;
  PetscReal      *sum;
  MPMView         view;

  PetscFunctionBeginUser;
  if (dim == 1 || (affine && method->transfer->flip >= 0)) PetscFunctionReturn(PETSC_SUCCESS);
  if (method->transfer->bounds == MPM_BOUNDS_UNKNOWN || core->grid.total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(N * scene->nbodies, &sum));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal x[3] = {0}, v[3] = {0}, *s;

    s = sum + N * MPMBodyOf(scene, view.id[p], 0);
    for (PetscInt d = 0; d < dim; d++) {
      x[d] = view.x[p * dim + d];
      v[d] = view.v[p * dim + d];
      s[X + d] += x[d];
      s[V + d] += v[d];
      s[XX] += x[d] * x[d];
      s[VV] += v[d] * v[d];
    }
    s[M] += 1;
    for (PetscInt d = 0; d < 3; d++) s[L + d] += x[(d + 1) % 3] * v[(d + 2) % 3] - x[(d + 2) % 3] * v[(d + 1) % 3];
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, sum, (PetscMPIInt)(N * scene->nbodies), MPIU_REAL, MPIU_SUM, core->exchange.data));
  for (PetscInt b = 0; b < scene->nbodies; b++) { /* a body has one density: its mass cancels */
    PetscReal *s = sum + N * b, l2 = 0, xx = s[XX], vv = s[VV];

    for (PetscInt d = 0; d < 3; d++) {
      const PetscReal l = s[L + d] -
                          (s[X + (d + 1) % 3] * s[V + (d + 2) % 3] - s[X + (d + 2) % 3] * s[V + (d + 1) % 3]) / s[M];

      l2 += l * l;
      xx -= s[X + d] * s[X + d] / s[M];
      vv -= s[V + d] * s[V + d] / s[M];
    }
    if (l2 > MPM_BOUND_spin * xx * vv &&
        vv > MPM_BOUND_still * s[VV]) { /* l^2 <= xx vv, and equal in 2-D if it only spins */
      const PetscReal turns = end * PetscSqrtReal(vv / xx) / (2 * PETSC_PI);

      if (!affine)
        PetscCall(Warn(core, method,
                       "slows down the spin of body %s by a quarter to a third in 3 turns of a disk of 8 cells; "
                       "-method_transfer aflip keeps it",
                       scene->bodies[b].name));
      else if (turns > MPM_BOUND_turns)
        PetscCall(
            Warn(core, method,
                 "slows down the spin of body %s by 10 to 30 %% in 100 turns of a disk of 8 cells, and the run has "
                 "%.0f; -method_transfer afmpm keeps it",
                 scene->bodies[b].name, (double)turns));
      break;
    }
  }
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MPMMethodAmplifies(const MPMCore *core, const MPMMethod *method, const MPMTime *time, const MPMWatch *w,
                             char what[MPM_TEXT_LEN], char options[MPM_TEXT_LEN])
{
  const MPMStable stable = MPMStableOf(core, method);
  const PetscReal C = w->wave, grows = MPMStableTenfold(&stable, C), steps = (PetscReal)core->step;

  if (stable.crossing > 0 && !(C > stable.crossing && steps > grows && w->grows_at >= 0)) return PETSC_FALSE;
  (void)snprintf(what, MPM_TEXT_LEN,
                 stable.crossing > 0
                     ? "the method amplifies noise where particles cross cells, tenfold in about %g steps"
                     : "the method is unstable where particles cross cells",
                 (double)Round(grows));
  if (stable.crossing > 0 && !(grows > 0)) what[strcspn(what, ",")] = 0;
  Stable(core, method, time, C, options);
  return PETSC_TRUE;
}

PetscErrorCode MPMMethodWarnings(MPMCore *core, const MPMScene *scene, const MPMMethod *method, const MPMTime *time,
                                 PetscReal dt)
{
  PetscFunctionBeginUser;
  if (core->needs.stepped) PetscFunctionReturn(PETSC_SUCCESS); /* nothing moves in time */
  PetscCall(WarnOfSteps(core, method, time, dt));
  PetscCall(WarnOfMethod(core, method, time));
  PetscCall(WarnOfLoss(core, scene, method, dt));
  PetscCall(WarnOfSpin(core, scene, method, time->end));
  PetscFunctionReturn(PETSC_SUCCESS);
}
