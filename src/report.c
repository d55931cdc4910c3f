/* report.c - what a run prints: the scene before the first step, progress on a terminal, the summary. */
#include <stdarg.h>
#include <unistd.h>
#include "mpm.h"

/* Prints as printf does, on the first process; PetscPrintf would write 3 as "3.". Not collective. */
PetscErrorCode MPMPrint(MPM mpm, const char format[], ...)
{
  PetscMPIInt rank;
  va_list     args;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  va_start(args, format);
  if (!rank && !mpm->quiet) (void)vprintf(format, args);
  va_end(args);
  (void)fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintScene(MPM mpm)
{
  static const char *const space[] = {"1-D uniaxial strain", "2-D plane strain", "3-D"};
  const MPMScene          *scene   = &mpm->scene;
  const PetscInt           dim     = mpm->grid.dim;
  PetscBool                cubes   = PETSC_TRUE; /* but for rounding */

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(mpm, "scene      %s   %s   ", scene->title, space[dim - 1]));
  for (PetscInt d = 0; d < dim; d++) PetscCall(MPMPrint(mpm, "%s%" PetscInt_FMT, d ? "x" : "", mpm->grid.cells[d]));
  PetscCall(MPMPrint(mpm, " cells  h="));
  for (PetscInt d = 1; d < dim; d++)
    if (PetscAbsReal(mpm->grid.h[d] - mpm->grid.h[0]) > 1e-12 * mpm->grid.h[0]) cubes = PETSC_FALSE;
  for (PetscInt d = 0; d < (cubes ? 1 : dim); d++)
    PetscCall(MPMPrint(mpm, "%s%g", d ? "," : "", (double)mpm->grid.h[d]));
  PetscCall(MPMPrint(mpm, "  %" PetscInt64_FMT " particles (", mpm->particles.total));
  for (PetscInt b = 0; b < scene->nbodies; b++)
    PetscCall(MPMPrint(mpm, "%s%" PetscInt64_FMT, b ? "+" : "", scene->bodies[b].n));
  PetscCall(MPMPrint(mpm, ")\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintFields(MPM mpm)
{
  const PetscInt bytes = MPMParticlesMemory(&mpm->particles), dim = mpm->grid.dim;
  const PetscInt node = (MPM_SUM_NC(dim) + MPM_VEL_NC(dim)) * (PetscInt)sizeof(PetscReal) +
                        2 * (PetscInt)sizeof(PetscInt); /* where the particles of a cell begin, and how many come */
  PetscReal nodes = 1;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(mpm, "fields     "));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (mpm->particles.present[f] && MPMFields[f].home == MPM_STATE) PetscCall(MPMPrint(mpm, "%s ", MPMFields[f].name));
  for (PetscInt d = 0; d < dim; d++) nodes *= mpm->grid.nodes[d];
  PetscCall(MPMPrint(mpm,
                     "  %" PetscInt_FMT " B/particle, %" PetscInt_FMT " with order and scratch, %" PetscInt_FMT
                     " B/node: %.3g MB for both\n",
                     MPMParticlesBytes(&mpm->particles, MPM_STATE), bytes, node,
                     (double)(1e-6 * (bytes * (PetscReal)mpm->particles.total + nodes * (PetscReal)node))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintMethod(MPM mpm)
{
  static const char *const bases[] = {
#define MPM_BASIS(name, nodes, layers, inertia, what) #name,
#include "basis.def"
#undef MPM_BASIS
  };

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(mpm, "kernels    %s%s / %s / ", bases[mpm->basis],
                     mpm->stretched                                      ? " stretch"
                     : !MPMBasisIsSpline(mpm->basis)                     ? ""
                     : mpm->grid.wall_basis[0] == MPM_WALL_BASIS_STEFFEN ? " steffen"
                                                                         : "",
                     mpm->integrator->name));
  if (mpm->affine)
    PetscCall(MPMPrint(mpm, "apic"));
  else if (mpm->params.order)
    PetscCall(MPMPrint(mpm, "xpic %" PetscInt_FMT, mpm->params.order));
  else if (mpm->params.flip == 1)
    PetscCall(MPMPrint(mpm, "flip"));
  else if (mpm->params.flip == 0)
    PetscCall(MPMPrint(mpm, "pic"));
  else
    PetscCall(MPMPrint(mpm, "flip %g", (double)mpm->params.flip));
  for (PetscInt m = 0; m < mpm->scene.nmaterials; m++)
    PetscCall(MPMPrint(mpm, " %s %s", m ? "+" : "/", mpm->scene.materials[m].type->name));
  PetscCall(MPMPrint(mpm, ", %" PetscInt_FMT " lanes\n", MPMTransferWidth()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the work is divided, when there is someone to divide it with. */
static PetscErrorCode PrintParallel(MPM mpm)
{
  const MPMPartition *part = &mpm->exchange.partition;
  PetscMPIInt         size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(mpm, "parallel   %d processes, %s", size, mpm->exchange.type->name));
  if (mpm->exchange.type->farms)
    PetscCall(
        MPMPrint(mpm, ": %s of %" PetscInt_FMT " cells an axis", mpm->exchange.type->what, mpm->exchange.pool_cells));
  else {
    for (PetscInt d = 0; d < mpm->grid.dim; d++)
      PetscCall(MPMPrint(mpm, "%s%" PetscInt_FMT, d ? "x" : " ", part->p[d]));
    PetscCall(MPMPrint(mpm, ", particles max/mean %.3f, by the model %.3g s a step, of migration the leavers alone",
                       (double)part->imbalance, (double)part->predicted));
  }
  PetscCall(MPMPrint(mpm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does a wall move, at all or along its normal? */
static PetscBool MovingWall(MPM mpm, PetscBool normal)
{
  for (PetscInt k = 0; k < 2 * mpm->grid.dim; k++) {
    const MPMFace *face = &mpm->scene.faces[k / 2][k % 2];
    if (face->type == MPM_WALL_moving && (!normal || face->velocity[k / 2] != 0)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* What each load acts on, at the start. Collective on the exchange. */
static PetscErrorCode PrintLoads(MPM mpm)
{
  const PetscInt dim = mpm->grid.dim, fields = MPM_BIT(id) | MPM_BIT(surface);
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&mpm->particles, fields, &view));
  for (PetscInt l = 0; l < mpm->scene.nloads; l++) {
    const MPMLoad *load    = &mpm->scene.loads[l];
    const MPMBody *body    = &mpm->scene.bodies[load->body];
    PetscInt64     n[7]    = {0}; /* particles, and their sides */
    PetscReal      area[3] = {0};

    for (PetscInt p = 0; p < view.n; p++) {
      const PetscInt sides = view.surface[p] & load->sides;

      if (!sides || view.id[p] < body->first || view.id[p] >= body->first + body->n) continue;
      n[0]++;
      for (PetscInt k = 0; k < 2 * dim; k++) n[1 + k] += sides >> k & 1;
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 7, MPIU_INT64, MPI_SUM, mpm->exchange.data));
    PetscCall(MPMPrint(mpm, "load       %s: %s on %" PetscInt64_FMT " particles of %s, area along each axis (",
                       load->name, load->pressure ? "pressure" : "traction", n[0], body->name));
    for (PetscInt d = 0; d < dim; d++) {
      area[d] = (PetscReal)(n[1 + 2 * d] + n[2 + 2 * d]);
      for (PetscInt e = 0; e < dim; e++) area[d] *= e == d ? 1 : body->b[e];
      PetscCall(MPMPrint(mpm, "%s%g", d ? ", " : "", (double)area[d]));
    }
    PetscCall(MPMPrint(mpm, ") m^%" PetscInt_FMT "\n", dim - 1));
    if (!n[0]) PetscCall(MPMPrint(mpm, "warning    load %s acts on no particle\n", load->name));
  }
  PetscCall(MPMParticlesRestoreView(&mpm->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the user should know before time is spent. */
static PetscErrorCode PrintWarnings(MPM mpm, PetscReal courant)
{
  PetscFunctionBeginUser;
  if (mpm->scene.overlap)
    PetscCall(MPMPrint(mpm,
                       "warning    %" PetscInt64_FMT
                       " particles lie in the shape of an earlier body too: matter is there twice\n",
                       mpm->scene.overlap));
  if (mpm->scene.on_line && mpm->basis == MPM_BASIS_linear)
    PetscCall(MPMPrint(mpm,
                       "warning    %" PetscInt64_FMT
                       " particles start exactly on lines of the grid, where the gradient of the linear basis jumps; "
                       "shift them by -body_<b>_offset\n",
                       mpm->scene.on_line));
  if (MovingWall(mpm, PETSC_TRUE))
    PetscCall(MPMPrint(
        mpm, "warning    a wall of type moving advances along its normal, but its face of the grid stays: right for "
             "displacements far below a cell only\n"));
  if (mpm->dt_fixed > MPMViscousStep(mpm))
    PetscCall(MPMPrint(
        mpm, "warning    dt is above the bound of viscosity, h^2/(2 dim nu) = %.3g s: expect the run to blow up\n",
        (double)MPMViscousStep(mpm)));
  if (courant > 1)
    PetscCall(MPMPrint(mpm, "warning    dt is %.2g h/(c+|v|), above the bound 1: expect the run to blow up\n",
                       (double)courant));
  if (mpm->basis == MPM_BASIS_linear && !strcmp(mpm->integrator->name, "usl"))
    PetscCall(MPMPrint(
        mpm,
        "warning    linear with usl is unstable where particles cross cells: nodes of vanishing mass get any velocity gradient; use musl or usf\n"));
  if (mpm->basis == MPM_BASIS_linear && mpm->affine)
    PetscCall(MPMPrint(
        mpm,
        "warning    linear with apic is unstable where particles cross cells: nodes of vanishing mass get any velocity gradient; use bspline2\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start-up print; with -dry_run also what the model says of other numbers of processes. Collective. */
PetscErrorCode MPMReportStart(MPM mpm)
{
  const PetscReal c = PetscSqrtReal(mpm->status.c2), v = PetscSqrtReal(mpm->status.v2), dt = MPMTimeStep(mpm);
  PetscReal       steps, step = 0;

  PetscFunctionBeginUser;
  PetscCall(PrintScene(mpm));
  PetscCall(PrintFields(mpm));
  PetscCall(PrintMethod(mpm));
  PetscCall(PrintParallel(mpm));
  PetscCall(MPMPrint(mpm, "stability  c=%.3g m/s |v|=%.3g m/s   dt=%.3g s = %.3g h/(c+|v|)\n", (double)c, (double)v,
                     (double)dt, (double)MPMCourant(mpm, dt)));
  steps = PetscMin(PetscCeilReal(mpm->time_end / dt), (PetscReal)mpm->max_steps);
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) step += mpm->predicted[e];
  PetscCall(MPMPrint(mpm, "predict    %.6g steps of %.3g s, about %.2g s without output\n", (double)steps, (double)step,
                     (double)(steps * step)));
  if (mpm->scene.dry_run) PetscCall(MPMModelView(mpm));
  PetscCall(PrintLoads(mpm));
  PetscCall(PrintWarnings(mpm, MPMCourant(mpm, dt)));
  if (mpm->scene.dry_run) PetscCall(MPMPrint(mpm, "dry run    the scene is valid; no step was made\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does what we print go to a terminal? Under Open MPI's mpiexec it always seems to: then the one that started us knows.
 */
static PetscBool OnTerminal(void)
{
  char    link[64], to[MPM_NAME_LEN];
  ssize_t n;

  if (!getenv("OMPI_COMM_WORLD_RANK")) return isatty(STDOUT_FILENO) ? PETSC_TRUE : PETSC_FALSE;
  (void)snprintf(link, sizeof link, "/proc/%ld/fd/1", (long)getppid());
  n = readlink(link, to, sizeof to - 1);
  return n > 5 && !strncmp(to, "/dev/", 5) && (n < 9 || strncmp(to, "/dev/null", 9)) ? PETSC_TRUE : PETSC_FALSE;
}

/* A line that overwrites itself, at most once a second, if standard output is a terminal. Not collective. */
PetscErrorCode MPMReportProgress(MPM mpm)
{
  PetscMPIInt    rank;
  PetscLogDouble now, spent;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  if (rank || mpm->quiet || now - mpm->wall_report < 1 || !OnTerminal()) PetscFunctionReturn(PETSC_SUCCESS);
  if (mpm->wall_report > 0) {
    const PetscReal part = PetscMax(mpm->t / mpm->time_end, (PetscReal)mpm->step / mpm->max_steps);

    spent         = now - mpm->wall_start;
    mpm->progress = PETSC_TRUE;
    printf("\rstep %" PetscInt_FMT "  t=%.4g of %.4g s  %.0f %%  %.0f s left   ", mpm->step, (double)mpm->t,
           (double)mpm->time_end, (double)(100 * part), (double)(spent * (1 - part) / part));
    (void)fflush(stdout);
  }
  mpm->wall_report = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Energies at the start and the end, and what went wrong with them. The last line of the history has the same. */
static PetscErrorCode PrintEnergy(MPM mpm)
{
  const MPMTotals *a = &mpm->monitor.start, *b = &mpm->monitor.now;
  const PetscReal  work     = MPMMonitorWork(mpm);
  const PetscReal  residual = b->kinetic + b->strain - a->kinetic - a->strain - work;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(mpm, "energy     kinetic %g -> %g J, strain %g -> %g J, total %g -> %g J", (double)a->kinetic,
                     (double)b->kinetic, (double)a->strain, (double)b->strain, (double)(a->kinetic + a->strain),
                     (double)(b->kinetic + b->strain)));
  if (work != 0) PetscCall(MPMPrint(mpm, ", work of gravity %g J, residual %g J", (double)work, (double)residual));
  PetscCall(MPMPrint(mpm, "\n"));
  if (!mpm->scene.forced && !MovingWall(mpm, PETSC_FALSE) &&
      residual > 0.05 * (mpm->monitor.energy_max + PetscAbsReal(work)))
    PetscCall(MPMPrint(mpm,
                       "warning    energy grew by %.2g of its largest value, which nothing in the scene explains\n",
                       (double)(residual / (mpm->monitor.energy_max + PetscAbsReal(work)))));
  if (mpm->courant > 1)
    PetscCall(MPMPrint(mpm,
                       "warning    dt reached %.3g h/(c+|v|) on the way, above the bound 1: do not trust the results\n",
                       (double)mpm->courant));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The summary: why it ended, energies, phases, digest. Collective. */
PetscErrorCode MPMReportEnd(MPM mpm)
{
  PetscInt64     digest;
  PetscLogDouble now;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  if (mpm->progress) PetscCall(MPMPrint(mpm, "\r\033[K"));
  if (mpm->stop[0]) {
    char line[2 * MPM_TEXT_LEN];

    (void)snprintf(line, sizeof line, "stopped at step %" PetscInt_FMT ", t=%g s: %s", mpm->step, (double)mpm->t,
                   mpm->stop);
    PetscCall(PetscFPrintf(mpm->comm, stderr, "%s\n", line));
  } else
    PetscCall(MPMPrint(mpm, "done       %" PetscInt_FMT " steps, t=%g s, in %.3g s%s\n", mpm->step, (double)mpm->t,
                       now - mpm->wall_start, mpm->t < mpm->time_end ? " (-time_max_steps)" : ""));
  PetscCall(PrintEnergy(mpm));
  if (mpm->scene.known) {
    PetscReal error, size;

    PetscCall(MPMKnownError(mpm, &error, &size));
    PetscCall(MPMPrint(mpm, "reference  rms error of the displacement %.6g m", (double)error));
    if (size > error)
      PetscCall(MPMPrint(mpm, ", of its rms %.6g m a part of %.4g", (double)size, (double)(error / size)));
    PetscCall(MPMPrint(mpm, "\n"));
  }
  if (mpm->output.dir[0])
    PetscCall(MPMPrint(mpm, "results    %s/%s.csv%s%s\n", mpm->output.dir, mpm->scene.name,
                       mpm->output.enabled ? " .h5 .xdmf" : "", mpm->output.replaced ? " (replaced)" : ""));
  if (mpm->exchange.recuts)
    PetscCall(MPMPrint(mpm,
                       "balance    the grid was cut anew %" PetscInt_FMT " times, particles max/mean at the end %.3f\n",
                       mpm->exchange.recuts,
                       (double)mpm->status.most * mpm->exchange.partition.p[0] * mpm->exchange.partition.p[1] *
                           mpm->exchange.partition.p[2] / (double)mpm->particles.total));
  if (mpm->exchange.migrations)
    PetscCall(MPMPrint(mpm,
                       "migration  particles changed process %" PetscInt64_FMT " times, in %" PetscInt_FMT
                       " of %" PetscInt_FMT " steps\n",
                       mpm->exchange.migrants, mpm->exchange.migrations, mpm->step));
  if (mpm->step > 0) PetscCall(MPMStepView(mpm));
#if defined(MPM_SIMULATE)
  PetscCall(MPMPrint(mpm, "simulated  %.9g s a step\n", (double)(mpm->wall_steps / PetscMax(1, mpm->step))));
#endif
  PetscCall(MPMRoofline(mpm));
  if (mpm->status.bad != MPM_OK) PetscFunctionReturn(PETSC_SUCCESS); /* the failed state is in no file */
  PetscCall(MPMParticlesDigest(&mpm->particles, mpm->exchange.data, &digest));
  PetscCall(MPMPrint(mpm, "digest %016llx\n", (unsigned long long)digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
