/* report.c - what a run prints: the scene before the first step, and the summary
   at the end. */
#include <unistd.h>
#include "physics/skin.h"
#include "kernels/tile_index.h"
#include "parallel/exchange.h"
#include "run/mpm.h"

static PetscErrorCode PrintScene(MPM mpm)
{
  static const char *const space[] = {"1-D uniaxial strain", "2-D plane strain", "3-D"};
  const MPMScene          *scene   = &mpm->scene;
  const PetscInt           dim     = mpm->core.grid.dim;
  PetscBool                cubes   = PETSC_TRUE; /* but for rounding */

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&mpm->core.print, "scene      %s   %s   ", scene->title, space[dim - 1]));
  for (PetscInt d = 0; d < dim; d++)
    PetscCall(MPMPrint(&mpm->core.print, "%s%" PetscInt_FMT, d ? "x" : "", mpm->core.grid.cells[d]));
  PetscCall(MPMPrint(&mpm->core.print, " cells  h="));
  for (PetscInt d = 1; d < dim; d++)
    if (PetscAbsReal(mpm->core.grid.h[d] - mpm->core.grid.h[0]) > 1e-12 * mpm->core.grid.h[0]) cubes = PETSC_FALSE;
  for (PetscInt d = 0; d < (cubes ? 1 : dim); d++)
    PetscCall(MPMPrint(&mpm->core.print, "%s%g", d ? "," : "", (double)mpm->core.grid.h[d]));
  PetscCall(MPMPrint(&mpm->core.print, "  %" PetscInt64_FMT " particles (", mpm->core.particles.total));
  for (PetscInt b = 0; b < scene->nbodies; b++)
    PetscCall(MPMPrint(&mpm->core.print, "%s%" PetscInt64_FMT, b ? "+" : "", scene->bodies[b].n));
  PetscCall(MPMPrint(&mpm->core.print, ")\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the bytes of a node: its numbers, where the particles of a cell begin, and how many come. */
static PetscInt NodeBytes(const MPMCore *core)
{
  return MPMNodeNumbers(core->grid.dim, MPMExchangeLines(core)) * (PetscInt)sizeof(PetscReal) +
         2 * (PetscInt)sizeof(PetscInt);
}

PetscReal MPMMemory(MPM mpm)
{
  PetscReal nodes = 1;

  for (PetscInt d = 0; d < mpm->core.grid.dim; d++) nodes *= mpm->core.grid.nodes[d];
  return MPMParticlesMemory(&mpm->core.particles) * (PetscReal)mpm->core.particles.total +
         nodes * (PetscReal)NodeBytes(&mpm->core);
}

static PetscErrorCode PrintFields(MPM mpm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&mpm->core.print, "fields     "));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (mpm->core.particles.present[f] && MPMFields[f].home == MPM_STATE)
      PetscCall(MPMPrint(&mpm->core.print, "%s ", MPMFields[f].name));
  PetscCall(MPMPrint(&mpm->core.print,
                     "  %" PetscInt_FMT " B/particle, %" PetscInt_FMT " with order and scratch%s, %" PetscInt_FMT
                     " B/node: %.3g MB for both\n",
                     MPMParticlesBytes(&mpm->core.particles, MPM_STATE), MPMParticlesMemory(&mpm->core.particles),
                     mpm->retry.on ? " and a copy of what a step changes" : "", NodeBytes(&mpm->core),
                     (double)(1e-6 * MPMMemory(mpm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintMethod(MPM mpm)
{
  const MPMTransfer *transfer = mpm->method.transfer;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&mpm->core.print, "kernels    %s%s / %s / ", MPMBasisNames[mpm->core.basis],
                     mpm->core.needs.stretched                                ? " stretch"
                     : !MPMBasisIsSpline(mpm->core.basis)                     ? ""
                     : mpm->core.grid.wall_basis[0] == MPM_WALL_BASIS_STEFFEN ? " steffen"
                                                                              : "",
                     mpm->method.scheme->name));
  PetscCall(MPMPrint(&mpm->core.print, "%s", transfer->name));
  if (transfer->rounds != MPM_NO_ROUNDS)
    PetscCall(MPMPrint(&mpm->core.print, " %" PetscInt_FMT, mpm->core.params.order));
  if (transfer->flip < 0 && mpm->core.params.flip < 1)
    PetscCall(MPMPrint(&mpm->core.print, " %g", (double)mpm->core.params.flip));
  if (transfer->flip < 0 && (transfer->parts & MPM_AFFINE))
    PetscCall(MPMPrint(&mpm->core.print, " strain %g", (double)mpm->core.params.strain));
  if (mpm->method.rate > 0) PetscCall(MPMPrint(&mpm->core.print, " damping rate %g", (double)mpm->method.rate));
  if (mpm->method.viscosity > 0)
    PetscCall(MPMPrint(&mpm->core.print, " viscosity %g m^2/s", (double)mpm->method.viscosity));
  for (PetscInt m = 0; m < mpm->scene.nmaterials; m++)
    PetscCall(MPMPrint(&mpm->core.print, " %s %s", m ? "+" : "/", mpm->scene.materials[m].type->name));
  PetscCall(MPMPrint(&mpm->core.print, ", %" PetscInt_FMT " lanes\n", MPMKernelWidth()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints at which friction angles soils flow, since one cone is another angle in each kind of deformation. */
static PetscErrorCode PrintFriction(MPM mpm)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nmaterials && mpm->core.grid.dim > 1; k++) {
    const MPMMaterial *m = &mpm->scene.materials[k];

    if (MPMListHas(m->type->parameters, "friction_angle"))
      PetscCall(MPMPrint(&mpm->core.print,
                         "friction   %s flows at %.3g degrees in plane strain, at %.3g in triaxial compression\n",
                         m->name, (double)m->acts[1], (double)m->acts[0]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes that the pool has fewer patches with particles than workers, with the largest patches of which there are enough. */
static PetscErrorCode NoteIdle(MPM mpm, PetscInt workers)
{
  const PetscInt tile   = MPMTileEdge(mpm->core.basis);
  const PetscInt widest = PetscMax(mpm->core.grid.nodes[0], PetscMax(mpm->core.grid.nodes[1], mpm->core.grid.nodes[2]));
  PetscInt       edge   = PetscMin(mpm->core.exchange.pool_cells, MPMPoolEdge(mpm->core.basis, widest)), has, n;

  PetscFunctionBeginUser;
  PetscCall(MPMPoolPatches(&mpm->core, edge, &has));
  for (n = has; n < workers && edge > tile;) PetscCall(MPMPoolPatches(&mpm->core, edge -= tile, &n));
  if (has >= workers) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(&mpm->core.print,
                     "note       the pool has fewer patches with particles than workers, %" PetscInt_FMT
                     " for %" PetscInt_FMT ", so some have no work: ",
                     has, workers));
  PetscCall(n >= workers
                ? MPMPrint(&mpm->core.print, "-pool_cells %" PetscInt_FMT " makes %" PetscInt_FMT "\n", edge, n)
                : MPMPrint(&mpm->core.print,
                           "-pool_cells %" PetscInt_FMT " makes %" PetscInt_FMT
                           ", and smaller ones are not possible; use %" PetscInt_FMT " processes at most\n",
                           edge, n, n + 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints how the work is divided, if there is more than one process. */
static PetscErrorCode PrintParallel(MPM mpm)
{
  const MPMPartition *part = &mpm->core.exchange.partition;
  PetscMPIInt         size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->core.comm, &size));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(&mpm->core.print, "parallel   %d processes, %s", size, mpm->core.exchange.type->name));
  if (mpm->core.exchange.type->by_workers)
    PetscCall(MPMPrint(&mpm->core.print, ": a master hands out patches of %" PetscInt_FMT " cells an axis",
                       mpm->core.exchange.pool_cells));
  else {
    for (PetscInt d = 0; d < mpm->core.grid.dim; d++)
      PetscCall(MPMPrint(&mpm->core.print, "%s%" PetscInt_FMT, d ? "x" : " ", part->p[d]));
    PetscCall(MPMPrint(&mpm->core.print,
                       ", particles max/mean %.3f, by the model %.3g s a step, of migration the leavers alone",
                       (double)part->imbalance, (double)part->predicted));
  }
  PetscCall(MPMPrint(&mpm->core.print, "\n"));
  if (mpm->core.exchange.type->by_workers) PetscCall(NoteIdle(mpm, size - 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints what each load acts on at the start, and the sum of the sizes of its forces when it is largest, as it acts on
   the particles at their start. Collective on the exchange. */
static PetscErrorCode PrintLoads(MPM mpm)
{
  const PetscInt dim    = mpm->core.grid.dim;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(depth) | MPM_BIT(kind) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(F) |
                          MPM_BIT(J);
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&mpm->core.particles, fields, &view));
  for (PetscInt l = 0; l < mpm->scene.nloads; l++) {
    const MPMLoad *load    = &mpm->scene.loads[l];
    const MPMBody *body    = &mpm->scene.bodies[load->body];
    PetscInt64     n[7]    = {0}; /* particles, and their sides */
    PetscReal      area[3] = {0}, most = 0, at = 0;

    for (PetscInt p = 0; p < view.n; p++) {
      PetscInt sides = 0;

      for (PetscInt k = 0; k < 2 * dim; k++)
        if (MPMSkinLayer(view.depth[2 * dim * p + k]) == 0) sides |= (PetscInt)1 << k & load->sides;

      if (!sides || view.id[p] < body->first || view.id[p] >= body->first + body->n) continue;
      n[0]++;
      for (PetscInt k = 0; k < 2 * dim; k++) n[1 + k] += sides >> k & 1;
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 7, MPIU_INT64, MPI_SUM, mpm->core.exchange.data));
    PetscCall(MPMPrint(&mpm->core.print,
                       "load       %s: %s on %" PetscInt64_FMT " particles of %s, area along each axis (", load->name,
                       load->pressure ? "pressure" : "traction", n[0], body->name));
    for (PetscInt d = 0; d < dim; d++) {
      area[d] = (PetscReal)(n[1 + 2 * d] + n[2 + 2 * d]);
      for (PetscInt e = 0; e < dim; e++) area[d] *= e == d ? 1 : body->b[e];
      PetscCall(MPMPrint(&mpm->core.print, "%s%g", d ? ", " : "", (double)area[d]));
    }
    PetscCall(MPMPrint(&mpm->core.print, ") m^%" PetscInt_FMT, dim - 1));
    for (PetscInt k = 0; k <= 10; k++) {
      const PetscReal t    = mpm->time.end * k / 10;
      PetscReal       size = 0;

      PetscCall(MPMForcesSize(&mpm->scene, &mpm->core, load, &view, t, &size));
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &size, 1, MPIU_REAL, MPI_SUM, mpm->core.exchange.data));
      if (size > most) at = t;
      most = PetscMax(most, size);
    }
    PetscCall(MPMPrint(&mpm->core.print, ", in all %.3g N at t=%.3g s\n", (double)most, (double)at));
    if (!n[0])
      PetscCall(MPMWarn(&mpm->core.print, "load %s acts on no particle", load->name));
    else if (!(most > 0))
      PetscCall(MPMWarn(
          &mpm->core.print,
          "load %s is 0 on all of these particles, at the start and after each tenth of -time_end; see -load_%s_value",
          load->name, load->name));
  }
  PetscCall(MPMParticlesRestoreView(&mpm->core.particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of cuts that remove no particle. */
static PetscErrorCode WarnCuts(MPM mpm)
{
  const MPMScene *scene = &mpm->scene;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nfilled; k++)
    for (PetscInt cut = 0; cut < scene->bodies[k].region.ncut; cut++) {
      const MPMBody *b = &scene->bodies[k], *other = scene->bodies;
      PetscBool      nothing;

      PetscCall(MPMSceneCutsNothing(b, mpm->core.grid.dim, cut, &nothing));
      if (!nothing) continue;
      while (&other->region != b->region.others[cut]) other++;
      PetscCall(MPMWarn(&mpm->core.print,
                        "-body_%s_cut %s removes no particle of %s; check where the shapes are, and their sizes",
                        b->name, other->name, b->name));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints warnings: what makes results doubtful, as far as it is known before the first step. */
static PetscErrorCode PrintWarnings(MPM mpm, PetscReal dt)
{
  PetscBool advances = PETSC_FALSE;
  char      meets[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (mpm->scene.overlap)
    PetscCall(MPMWarn(&mpm->core.print,
                      "%" PetscInt64_FMT " particles lie in the shape of an earlier body too: matter is there twice",
                      mpm->scene.overlap));
  if (mpm->scene.behind)
    PetscCall(
        MPMWarn(&mpm->core.print,
                "%" PetscInt64_FMT
                " particles start behind a piston, which moves them along; shorten -bc_<f>_distance or cut the body",
                mpm->scene.behind));
  if (mpm->scene.on_line && mpm->core.basis == MPM_BASIS_linear)
    PetscCall(MPMWarn(
        &mpm->core.print,
        "%" PetscInt64_FMT
        " particles start exactly on lines of the grid, where the gradient of the linear basis jumps; shift them by "
        "-body_<b>_offset",
        mpm->scene.on_line));
  for (PetscInt k = 0; k < 2 * mpm->core.grid.dim && !advances; k++)
    PetscCall(MPMSceneWallAdvances(&mpm->scene, &mpm->core, k, mpm->time.end, &advances));
  if (advances)
    PetscCall(MPMWarn(
        &mpm->core.print,
        "a wall of type moving advances along its normal, but its face of the grid stays: right for displacements far below a cell only; a wall of type piston moves through the grid"));
  PetscCall(MPMSceneForesee(&mpm->scene, &mpm->core, mpm->time.end, meets));
  if (meets[0]) PetscCall(MPMWarn(&mpm->core.print, "%s, which ends the run; choose an earlier -time_end", meets));
  if (mpm->time.fixed > MPMViscousStep(&mpm->core))
    PetscCall(MPMWarn(&mpm->core.print,
                      "dt is above the bound of viscosity, h^2/(2 dim nu) = %.3g s: expect the run to blow up",
                      (double)MPMViscousStep(&mpm->core)));
  PetscCall(MPMDoubtsBodies(mpm));
  PetscCall(WarnCuts(mpm));
  PetscCall(MPMMethodWarnings(mpm, dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints what a run is before its first step, with -dry_run also what the model predicts of it. Collective on the
   exchange. */
PetscErrorCode MPMReportStart(MPM mpm)
{
  const PetscReal c = PetscSqrtReal(mpm->core.status.c2), v = PetscSqrtReal(mpm->core.status.v2),
                  dt = MPMTimeStep(&mpm->core, &mpm->time);
  PetscReal steps, step = 0;
  char      initial[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(PrintScene(mpm));
  PetscCall(MPMReportBodies(mpm));
  MPMInitialTell(&mpm->scene, initial);
  if (initial[0]) PetscCall(MPMPrint(&mpm->core.print, "initial    %s\n", initial));
  PetscCall(PrintFields(mpm));
  PetscCall(MPMPresetPrint(mpm));
  PetscCall(PrintMethod(mpm));
  PetscCall(PrintFriction(mpm));
  PetscCall(PrintParallel(mpm));
  PetscCall(MPMPrint(&mpm->core.print, "stability  c=%.3g m/s |v|=%.3g m/s   dt=%.3g s = %.3g h/(c+|v|)\n", (double)c,
                     (double)v, (double)dt, (double)MPMCourant(&mpm->core, dt)));
  steps = PetscCeilReal((mpm->time.end - mpm->core.t) / dt);
  for (PetscInt k = 0; k < 2; k++) { /* a step is cut at each exact time of output */
    const PetscReal every = k ? mpm->monitor.every : mpm->output.every;

    if ((k ? mpm->monitor.exact : mpm->output.exact) && every > 0)
      steps = PetscMax(steps, (mpm->time.end - mpm->core.t) / every * PetscCeilReal(every / dt * (1 - 1e-9)));
  }
  if (mpm->time.max_steps != PETSC_MAX_INT) steps = PetscMin(steps, (PetscReal)(mpm->time.max_steps - mpm->core.step));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) step += mpm->cost.predicted[e];
  PetscCall(MPMReportPrediction(mpm, steps, step));
  if (mpm->scene.dry_run) PetscCall(MPMMemoryPrint(mpm, steps * step));
  if (mpm->scene.dry_run)
    PetscCall(MPMModelView(&mpm->cost, &mpm->core, &mpm->scene, dt, steps, mpm->report.processes));
  PetscCall(PrintLoads(mpm));
  PetscCall(MPMDiskPrint(mpm, steps, steps * step));
  PetscCall(PrintWarnings(mpm, dt));
  PetscCall(MPMDoubtsWarn(mpm, steps, steps * step));
  if (mpm->scene.dry_run) PetscCall(MPMPrint(&mpm->core.print, "dry run    the scene is valid; no step was made\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints how far the stress is from what nodes and particles agree on, unless all of it is rounding. The memory of
   the next order, which no step follows to use, has room for a number of each particle. Collective on the exchange. */
_Static_assert(sizeof(float) <= sizeof(PetscInt), "the order has room for numbers of float");
static PetscErrorCode PrintIndicator(MPM mpm)
{
  MPMIndicator indicator;
  PetscReal    rho = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMIndicatorCompute(&mpm->scene, &mpm->core, (float *)mpm->core.particles.spare, &indicator));
  for (PetscInt m = 0; m < mpm->scene.nmaterials; m++) rho = PetscMax(rho, mpm->scene.materials[m].rho);
  if (indicator.stress > 1e-10 * rho * mpm->core.status.c2) {
    PetscCall(MPMPrint(&mpm->core.print, "indicator  stress jumps by %.3g %% of its rms %.3g Pa, most at (",
                       (double)(100 * indicator.jump), (double)indicator.stress));
    for (PetscInt d = 0; d < mpm->core.grid.dim; d++)
      PetscCall(MPMPrint(&mpm->core.print, "%s%g", d ? ", " : "", (double)indicator.x[d]));
    PetscCall(MPMPrint(&mpm->core.print, "): by %.3g %%\n", (double)(100 * indicator.largest)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the files of results that are there: after a fault some may not be. */
static PetscErrorCode PrintResults(MPM mpm)
{
  const char *const ends[] = {".csv", ".h5", ".xdmf"};
  PetscInt          n      = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < (mpm->output.enabled ? 3 : 1); k++) {
    char path[2 * MPM_TEXT_LEN];

    (void)snprintf(path, sizeof path, "%s/%s%s", mpm->output.dir, mpm->scene.name, ends[k]);
    if (access(path, F_OK)) continue;
    PetscCall(n++ ? MPMPrint(&mpm->core.print, " %s", ends[k]) : MPMPrint(&mpm->core.print, "results    %s", path));
  }
  if (n)
    PetscCall(MPMPrint(&mpm->core.print, "%s\n",
                       mpm->output.resumed    ? " (continued)"
                       : mpm->output.replaced ? " (replaced)"
                                              : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the summary: why the run ended, energies, error, files, phases, digest. Collective on the exchange. */
PetscErrorCode MPMReportEnd(MPM mpm)
{
  PetscInt       shares = 1; /* into which the particles are divided */
  PetscInt64     digest;
  PetscLogDouble now;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  if (mpm->report.progress) PetscCall(MPMPrint(&mpm->core.print, "\r\033[K"));
  if (mpm->core.stop[0]) {
    char line[2 * MPM_TEXT_LEN];

    (void)snprintf(line, sizeof line, "stopped at step %" PetscInt_FMT ", t=%g s: %s", mpm->core.step,
                   (double)mpm->core.t, mpm->core.stop);
    PetscCall(PetscFPrintf(mpm->core.comm, stderr, "%s\n", line));
  } else
    PetscCall(MPMPrint(&mpm->core.print, "done       %" PetscInt_FMT " steps, t=%g s, in %.3g s%s\n", mpm->core.step,
                       (double)mpm->core.t, now - mpm->report.start,
                       mpm->core.t < mpm->time.end ? " (-time_max_steps)" : ""));
  PetscCall(MPMReportEnergy(mpm));
  PetscCall(MPMAdvanceReport(mpm));
  if (mpm->report.indicator && !MPMStatusIsBad(&mpm->core.status) && mpm->core.particles.total)
    PetscCall(PrintIndicator(mpm));
  PetscCall(MPMWatchEnd(mpm));
  if (mpm->scene.known && mpm->core.particles.total) {
    PetscReal error, size;

    PetscCall(MPMKnownError(&mpm->scene, &mpm->core, &error, &size));
    PetscCall(MPMPrint(&mpm->core.print, "reference  rms error of the displacement %.6g m", (double)error));
    if (size > 0) PetscCall(MPMPrint(&mpm->core.print, "; its rms is %.6g m", (double)size));
    if (size > error) PetscCall(MPMPrint(&mpm->core.print, ", so the relative error is %.4g", (double)(error / size)));
    PetscCall(MPMPrint(&mpm->core.print, "\n"));
  }
  if (mpm->output.dir[0]) PetscCall(PrintResults(mpm));
  for (PetscInt d = 0; d < 3; d++) shares *= mpm->core.exchange.partition.p[d];
  if (mpm->core.exchange.recuts)
    PetscCall(MPMPrint(&mpm->core.print,
                       "balance    the grid was cut anew %" PetscInt_FMT " times, particles max/mean at the end %.3f\n",
                       mpm->core.exchange.recuts,
                       (double)mpm->core.status.most * shares / (double)PetscMax(1, mpm->core.particles.total)));
  if (mpm->core.exchange.migrations)
    PetscCall(MPMPrint(&mpm->core.print,
                       "migration  particles changed process %" PetscInt64_FMT " times, in %" PetscInt_FMT
                       " of %" PetscInt_FMT " steps\n",
                       mpm->core.exchange.migrants, mpm->core.exchange.migrations,
                       mpm->core.step - mpm->core.timers.first));
  PetscCall(MPMReportPhases(mpm));
#if defined(MPM_SIMULATE)
  PetscCall(MPMPrint(&mpm->core.print, "simulated  %.9g s a step\n",
                     (double)(mpm->core.timers.steps / PetscMax(1, mpm->core.step - mpm->core.timers.first))));
#endif
  PetscCall(MPMRoofline(&mpm->cost, &mpm->core, mpm->report.limits, mpm->report.no_limits));
  if (MPMStatusIsBad(&mpm->core.status)) PetscFunctionReturn(PETSC_SUCCESS); /* the failed state is in no file */
  PetscCall(MPMParticlesDigest(&mpm->core.particles, mpm->core.exchange.data, &digest));
  PetscCall(MPMPrint(&mpm->core.print, "digest %016llx\n", (unsigned long long)digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
