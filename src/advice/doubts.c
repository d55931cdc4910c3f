/* doubts.c - what is doubtful in a scene whose options are valid, as far as it can be told before the first step: it is
   refused where the run could only fail, else warned of, or noted where a value is surely not what was meant. */
#include "advice/unlikely.h"

/* Returns by how much rounding may shift the lattice of particles, in its spacings. Its places are multiples of the
   spacing b from the origin of space, and b comes from the difference of the corners of the grid, which at coordinates
   x is known to eps x. After x/b spacings that error has grown to eps x^2/(L b), with L the length of the grid. Sets
   *largest to the largest coordinate on that axis, m. */
static PetscReal LatticeShift(const MPMGrid *grid, const MPMScene *scene, PetscReal *largest)
{
  PetscReal most = 0;

  *largest = 0;
  for (PetscInt d = 0; d < grid->dim; d++)
    for (PetscInt k = 0; k < scene->nbodies; k++) {
      const PetscReal x     = PetscMax(PetscAbsReal(grid->lower[d]), PetscAbsReal(grid->upper[d]));
      const PetscReal b     = grid->h[d] / (PetscReal)scene->bodies[k].ppc[d];
      const PetscReal shift = PETSC_MACHINE_EPSILON * x * (1 + x / (grid->upper[d] - grid->lower[d])) / b;

      if (shift > most) most = shift, *largest = x;
    }
  return most;
}

/* Refuses, in the options, scenes that could only fail later. Not collective. */
PetscErrorCode MPMDoubtsRefuse(const MPMCore *core, const MPMScene *scene, const MPMTime *time, MPMOptions o)
{
  const PetscReal steps = time->fixed > 0 ? time->end / time->fixed : 0;
  PetscReal       x, shift;

  PetscFunctionBeginUser;
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  shift = LatticeShift(&core->grid, scene, &x);
  if (shift > MPM_BOUND_shift_refused)
    MPMOptionsFail(o,
                   "-grid_lower, -grid_upper: coordinates up to %g m are too large for cells of %g m: rounding may "
                   "shift the particles by %.2g of their spacing; move the origin into the scene",
                   (double)x, (double)MPMGridSmallestH(&core->grid), (double)shift);
  if (steps > MPM_BOUND_most_steps && time->max_steps == PETSC_MAX_INT)
    MPMOptionsFail(o,
                   "-dt_size %g makes %.3g steps until -time_end %g, a run makes %.0f at most; choose a larger one, or "
                   "-time_max_steps",
                   (double)time->fixed, (double)steps, (double)time->end, (double)MPM_BOUND_most_steps);
  for (PetscInt k = 0; k < scene->nbodies && core->needs.stretched; k++)
    for (PetscInt d = 0; d < core->grid.dim; d++)
      if (scene->bodies[k].ppc[d] == 1)
        MPMOptionsFail(
            o,
            "-body_%s_ppc 1 does not apply: with -method_gimp_update stretch a domain of a whole cell cannot "
            "stretch; choose 2 or more on each axis, or -method_gimp_update none",
            scene->bodies[k].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the option that gives the modulus of a material. */
static const char *ModulusOf(const MPMMaterial *m)
{
  return m->type->traits & MPM_FLUID ? "K" : MPMListHas(m->type->parameters, "E") ? "E" : "c0";
}

/* --- Notes: values that are surely not what was meant ------------------------------------------------------------- */

/* Notes temperatures in degrees Celsius. */
static PetscErrorCode NoteCelsius(const MPMPrinter *print, const MPMMaterial *m)
{
  PetscFunctionBeginUser;
  if (MPMListHas(m->type->parameters, "temperature") && m->temperature < MPM_BOUND_cold && m->melting > MPM_BOUND_hot)
    PetscCall(MPMNote(
        print,
        "-material_%s_temperature %g is in K, as -material_%s_melting is; if degrees Celsius are meant, write %g and "
        "%g",
        m->name, (double)m->temperature, m->name, (double)(m->temperature + 273.15), (double)(m->melting + 273.15)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes that a run of automatic time steps that nothing else limits, or a stage of it, ends after a few of them. */
static PetscErrorCode NoteSteps(const MPMCore *core, const MPMScene *scene, const MPMTime *time, PetscReal steps)
{
  const MPMStages *s = &core->stages;

  PetscFunctionBeginUser;
  if (!(steps > 0 && steps < MPM_BOUND_few_steps) || time->fixed > 0 || time->max_steps != PETSC_MAX_INT)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (s->n && core->t <= s->began)
    PetscCall(MPMNote(
        &core->print,
        "-stage_%s_time: the stage makes only %g step%s in its %.3g s, in which waves cross few cells; check it, and the "
        "units of moduli and densities",
        scene->stages[s->now - 1], (double)steps, steps > 1 ? "s" : "", (double)(time->end - s->began)));
  else if (!core->step)
    PetscCall(MPMNote(
        &core->print,
        "the run makes only %g step%s until -time_end %g s, in which waves cross few cells; check it, and the units "
        "of moduli and densities",
        (double)steps, steps > 1 ? "s" : "", (double)(time->end - core->stages.began)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints notes on values that are surely odd. Not collective. */
PetscErrorCode MPMDoubtsNote(const MPMCore *core, const MPMScene *scene)
{
  const PetscReal *g     = core->params.gravity;
  const PetscInt   dim   = core->grid.dim;
  const PetscReal  size  = PetscSqrtReal(g[0] * g[0] + (dim > 1 ? g[1] * g[1] : 0) + (dim > 2 ? g[2] * g[2] : 0));
  const PetscBool  earth = size > MPM_BOUND_earth_least && size < MPM_BOUND_earth_most;

  PetscFunctionBeginUser;
  if (earth && dim > 1 && g[dim - 1] > MPM_BOUND_earth_least)
    PetscCall(MPMNote(&core->print, "-gravity points upward, along +%c", "xyz"[dim - 1]));
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    PetscCall(NoteCelsius(&core->print, &scene->materials[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Warnings: what the method cannot do in this scene ------------------------------------------------------------ */

/* Warns of nearly incompressible solids. In 1-D the one strain is that of volume, which cannot lock. */
static PetscErrorCode WarnLocking(const MPMCore *core, const MPMScene *scene)
{
  const PetscBool spline = MPMBasisIsSpline(core->basis);

  PetscFunctionBeginUser;
  if (core->params.box || core->grid.dim == 1) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    const MPMMaterial *m = &scene->materials[k];

    if ((m->type->traits & MPM_FLUID) || !(m->nu > MPM_BOUND_locks) || m->mu < MPM_BOUND_yield_least * m->lambda)
      continue;
    PetscCall(MPMWarn(
        &core->print,
        "%s is nearly incompressible (nu %g): %s makes it %s (locking); use %sa finer grid, or -method_locking fbar",
        m->name, (double)m->nu, MPMBasisNames[core->basis], spline ? "too stiff on coarse grids" : "far too stiff",
        spline ? "" : "bspline2 and "));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of fluids that gimp lets sink into walls: the domain of a particle at a wall reaches beyond it, so that the
   node inside moves the particle along the normal though the wall holds the nodes on it. Solids are pushed back by
   their stress; a fluid on a floor sinks on until its particles lie on the wall. */
static PetscErrorCode WarnSink(const MPMCore *core, const MPMScene *scene)
{
  PetscBool fluid = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    if (scene->materials[k].type->traits & MPM_FLUID) fluid = PETSC_TRUE;
  for (PetscInt k = 0; k < 2 * core->grid.dim && fluid && core->basis == MPM_BASIS_gimp; k++) {
    const MPMWall type = scene->walls.given[k / 2][k % 2].type;

    if (!MPMWallHas(type, MPM_WALL_NORMAL)) continue;
    PetscCall(
        MPMWarn(&core->print,
                "gimp lets the fluid sink into the wall %s (%s) by up to half of a particle's domain; use bspline2",
                MPMFaceNames[k], MPMWallNames[type]));
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of methods whose state at rest under loads is another one: where stress and motion come from different
   velocities of the nodes, and particles keep none of their own velocity, so that forces that do not quite balance at
   the nodes move the particles on. Measured on a ring under pressure: displacements change by 1 to 4 %, with usl and
   apic or pic by less than 0.1 %. */
static PetscErrorCode WarnRest(const MPMCore *core, const MPMScene *scene, const MPMMethod *method)
{
  PetscFunctionBeginUser;
  if (scene->nloads && core->params.flip == 0 && !method->scheme->direct)
    PetscCall(
        MPMWarn(&core->print,
                "%s with %s changes the state at rest under loads, by some per cent of the displacement; use usl, or "
                "-method_transfer flip",
                method->scheme->name, method->transfer->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Warnings: what is hardly meant, by ratios, since any units are allowed that go together ---------------------- */

/* Warns of bodies that start faster than their own waves: of them only a shock is left. */
static PetscErrorCode WarnSpeed(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    const MPMBody     *b       = &scene->bodies[k];
    const MPMMaterial *m       = &scene->materials[b->material];
    const PetscBool    fluid   = (m->type->traits & MPM_FLUID) != 0;
    const PetscReal    modulus = fluid ? m->K : m->lambda + 2 * m->mu, c = PetscSqrtReal(modulus / m->rho);

    if (!(PetscSqrtReal(b->v2) > c)) continue;
    PetscCall(MPMWarn(
        &core->print,
        "%s starts at %.3g m/s, faster than its own sound, %.3g m/s; check -body_%s_velocity, -material_%s_%s and "
        "-material_%s_rho, and their units",
        b->name, (double)PetscSqrtReal(b->v2), (double)c, b->name, m->name, ModulusOf(m), m->name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of bodies that their own weight would crush, by the stress below their height H, rho g H. */
static PetscErrorCode WarnWeight(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  if (MPMUnlikelyGravity(core, scene)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    const MPMBody     *b     = &scene->bodies[k];
    const MPMMaterial *m     = &scene->materials[b->material];
    const PetscBool    fluid = (m->type->traits & MPM_FLUID) != 0;
    PetscReal          lower[3], upper[3], weight = 0;

    if (b->source.on) continue; /* how much of it there is at once is not known */
    MPMRegionBounds(&b->region, core->grid.dim, lower, upper);
    for (PetscInt d = 0; d < core->grid.dim; d++)
      weight += m->rho * PetscAbsReal(core->params.gravity[d]) * (upper[d] - lower[d]);
    weight /= fluid ? m->K : m->E;
    if (!(weight > MPM_BOUND_weight)) continue;
    PetscCall(MPMWarn(
        &core->print,
        "the weight of %s presses it by rho g H/%s = %.3g; check -gravity, -material_%s_rho and -material_%s_%s, and "
        "their units",
        b->name, fluid ? "K" : "E", (double)weight, m->name, m->name, ModulusOf(m)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a rigid body that stays beside a side of a body shuts it off: one that stands still, or moves along
   the axis of that side alone. */
static PetscBool IsShut(const MPMCore *core, const MPMScene *scene, const MPMTime *time, const PetscReal lower[],
                        const PetscReal upper[], PetscInt axis, PetscInt side)
{
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes; k++) {
    const MPMBody  *b    = &scene->bodies[k];
    PetscReal       v[9] = {0}, low[3], high[3], gap;
    const PetscReal x[3] = {0};
    PetscBool       shut = PETSC_TRUE;

    if (b->removed || b->spin || (b->rigid != MPM_RIGID_FIXED && b->rigid != MPM_RIGID_MOVING)) continue;
    if (b->velocity && MPMExpressionEvaluate(b->velocity, core->grid.dim, x, x, 0.5 * time->end, v)) continue;
    MPMRegionBounds(&b->region, core->grid.dim, low, high);
    gap = side ? low[axis] - upper[axis] : lower[axis] - high[axis];
    for (PetscInt d = 0; d < core->grid.dim; d++)
      if (d == axis ? PetscAbsReal(gap) > core->grid.h[d]
                    : v[d] != 0 || low[d] > lower[d] + core->grid.h[d] || high[d] < upper[d] - core->grid.h[d])
        shut = PETSC_FALSE;
    if (shut) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns whether a body has room beside it, across gravity: an axis that is not periodic, and on which it does not
   reach from wall to wall, or to rigid bodies in their place. */
static PetscBool HasRoom(const MPMCore *core, const MPMScene *scene, const MPMTime *time, const PetscReal lower[],
                         const PetscReal upper[])
{
  const MPMGrid *grid = &core->grid;

  for (PetscInt d = 0; d < grid->dim; d++) {
    const MPMFace *f = scene->walls.given[d];

    if (core->params.gravity[d] != 0 || grid->periodic[d]) continue;
    for (PetscInt side = 0; side < 2; side++) {
      const PetscReal gap = side ? grid->upper[d] - upper[d] : lower[d] - grid->lower[d];

      if ((!MPMWallHas(f[side].type, MPM_WALL_NORMAL) || gap > f[side].distance + grid->h[d]) &&
          !IsShut(core, scene, time, lower, upper, d, side))
        return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* Warns that dry sand runs the farther the smaller the cells are, and tells the viscosity with which it does not. */
static PetscErrorCode WarnRuns(const MPMCore *core, const MPMScene *scene, const MPMMethod *method, const MPMTime *time)
{
  const char *name = NULL, *of = NULL;
  PetscReal   nu = 0;

  PetscFunctionBeginUser;
  if (method->viscosity > 0 || core->grid.total || MPMDampingIsOn(core)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    const MPMBody     *b = &scene->bodies[k];
    const MPMMaterial *m = &scene->materials[b->material];
    PetscReal          lower[3], upper[3];

    if (b->alone || b->source.on || !(m->state & MPM_BIT(vc)) || m->cohesion > 0) continue;
    MPMRegionBounds(&b->region, core->grid.dim, lower, upper);
    for (PetscInt d = 0; d < core->grid.dim && HasRoom(core, scene, time, lower, upper); d++) {
      const PetscReal own = MPM_BOUND_runs *
                            PetscSqrtReal(PetscAbsReal(core->params.gravity[d]) * PetscPowReal(upper[d] - lower[d], 3));

      if (own > nu) nu = own, name = b->name, of = m->name;
    }
  }
  if (name && core->grid.round)
    PetscCall(MPMWarn(&core->print,
                      "how far %s runs out grows as cells get smaller, and is a third too short with -material_%s_fit "
                      "triaxial; if it counts, use plane_strain, -method_transfer flip -method_damping_viscosity %.1g "
                      "(docs/choosing.md, soils)",
                      name, of, (double)nu));
  else if (name)
    PetscCall(MPMWarn(&core->print,
                      "how far %s runs out grows as cells get smaller; if it counts, use -method_transfer flip "
                      "-method_damping_viscosity %.1g (docs/choosing.md, soils)",
                      name, (double)nu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of friction angles that act as others: a cone that was fitted in triaxial compression is stronger in plane
   strain. Who gives -material_<m>_fit knows, but where nothing flows. */
static PetscErrorCode WarnAngle(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    const MPMMaterial *m = &scene->materials[k];
    char               name[3 * MPM_NAME_LEN], fit[3 * MPM_NAME_LEN];
    PetscReal          angle = 0;
    PetscBool          chosen;

    (void)snprintf(name, sizeof name, "-material_%s_friction_angle", m->name);
    (void)snprintf(fit, sizeof fit, "-material_%s_fit", m->name);
    PetscCall(PetscOptionsHasName(NULL, NULL, fit, &chosen));
    PetscCall(PetscOptionsGetReal(NULL, NULL, name, &angle, NULL));
    if (core->grid.dim != 2 || (chosen && (m->acts[1] < 90 || core->grid.round)) ||
        m->acts[1] - angle <= MPM_BOUND_angle_acts)
      continue;
    if (core->grid.round)
      PetscCall(
          MPMWarn(&core->print,
                  "%s %.3g, fitted in triaxial compression, acts like %.3g degrees where a body of revolution "
                  "flows as in plane strain, as sand that runs out does; then give %s plane_strain, for specimens "
                  "in triaxial compression %s triaxial",
                  name, (double)angle, (double)m->acts[1], fit, fit));
    else
      PetscCall(MPMWarn(
          &core->print,
          "%s %.3g, fitted in triaxial compression, acts in plane strain like %.3g degrees%s; if %.3g is meant in "
          "plane strain, give %s plane_strain%s%s%s",
          name, (double)angle, (double)m->acts[1], m->acts[1] < 90 ? "" : " or more, so that it hardly flows",
          (double)angle, fit, chosen ? "" : ", else ", chosen ? "" : fit, chosen ? "" : " triaxial"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes fluids of a scene of bodies of revolution, whose volumes are not relaxed as they would be in a plane. */
static PetscErrorCode NoteRound(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials && core->grid.round; k++)
    if (scene->materials[k].type->traits & MPM_FLUID)
      PetscCall(
          MPMNote(&core->print,
                  "the volumes of %s are not relaxed, with -geometry axisymmetric: after a splash its level may be "
                  "wrong; compare with a plane or 3-D scene if it counts",
                  scene->materials[k].name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the warnings and notes before the first step. Not collective. */
PetscErrorCode MPMDoubtsWarn(const MPMCore *core, const MPMScene *scene, const MPMMethod *method, const MPMTime *time,
                             const MPMForecast *f)
{
  const PetscReal seconds = f->steps * f->step;
  PetscReal       x;
  const PetscReal shift = LatticeShift(&core->grid, scene, &x);

  PetscFunctionBeginUser;
  if (shift > MPM_BOUND_shift_warned)
    PetscCall(MPMWarn(
        &core->print,
        "coordinates up to %g m are large beside cells of %g m: rounding may shift the particles by %.2g of their "
        "spacing; move the origin into the scene",
        (double)x, (double)MPMGridSmallestH(&core->grid), (double)shift));
  if (f->steps > MPM_BOUND_most_steps)
    PetscCall(MPMWarn(
        &core->print,
        "%.3g steps are more than a run makes, %.0f: it will end early; choose an earlier -time_end, larger cells or "
        "a slower wave",
        (double)f->steps, (double)MPM_BOUND_most_steps));
  if (seconds > MPM_BOUND_year)
    PetscCall(
        MPMWarn(&core->print,
                "the run would take about %.2g years; choose an earlier -time_end, larger cells or a larger time step",
                (double)(seconds / MPM_BOUND_year)));
  PetscCall(NoteSteps(core, scene, time, f->steps));
  PetscCall(WarnLocking(core, scene));
  PetscCall(WarnSink(core, scene));
  PetscCall(WarnRest(core, scene, method));
  PetscCall(WarnSpeed(core, scene));
  PetscCall(WarnWeight(core, scene));
  PetscCall(WarnAngle(core, scene));
  PetscCall(WarnRuns(core, scene, method, time));
  PetscCall(NoteRound(core, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
