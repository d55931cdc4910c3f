/* static_solver.c - the solver of static steps: its options and PETSc's defaults, how it is made and freed, and what a run says of
   it. */
#include "parallel/exchange.h"
#include "physics/tangent.h"
#include "step/static.h"

#define ITERATIONS 25 /* of Newton, before a step is made anew with half its length */
#define GRAIN      43 /* binary digits of the entries of K below that of a large one; sums of up to 2^10 of that are exact */
#define ROUNDING   1e-13 /* of the largest stiffness: a smaller force on a node is rounding */

PetscErrorCode MPMStaticSetFromOptions(MPMCore *core, const MPMScene *scene, const MPMTime *when, MPMOptions o)
{
  struct MPMStatic *s;
  PetscBool         set;
  char              time[MPM_NAME_LEN], rtol[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&s));
  core->implicit = s;
  s->core        = core;
  s->scene       = scene;
  s->time        = when;
  s->ramp        = when->end;
  PetscCall(MPMOptionsEnum(o, "method_time", NULL, time, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsReal(o, "method_gamma", NULL, &s->gamma, &set));
  s->beta = s->gamma / 2;
  if (strcmp(time, "newmark") && set && !MPMOptionsOverridden("method_gamma", "method_time"))
    MPMOptionsFail(o, "-method_gamma does not apply: it is of -method_time newmark");
  if (!strcmp(time, "euler")) s->beta = 1, s->gamma = 0;
  s->inertia = (PetscBool)(strcmp(time, "static") != 0);
  if (s->inertia || core->stages.now > 1) s->ramp = 0; /* gravity acts whole since the end of the first stage */
  PetscCall(PetscOptionsGetString(NULL, NULL, "-snes_rtol", rtol, sizeof rtol, &set));
  if (set && !(strtod(rtol, NULL) > 0 && strtod(rtol, NULL) < 1))
    MPMOptionsFail(
        o,
        "-snes_rtol %.40s must be a number between 0 and 1: the part of the forces that may be out of balance, "
        "1e-8 unless given",
        rtol);
  PetscCall(MPMOptionsReal(o, "gravity_ramp", NULL, &s->ramp, &set));
  PetscCall(MPMOptionsReal(o, "method_stabilize_factor", NULL, &s->ghost, NULL));
  PetscCall(MPMOptionsReal(o, "dt_strain", NULL, &s->most, NULL));
  PetscCall(MPMOptionsReal(o, "method_stabilize_fill", NULL, &s->fill, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets PETSc add what comes from other processes in one sequence, and not as it arrives, in matrices and in the products of
   multigrid, so that a run has the same bits each time (but not after a restart with multigrid, whose estimates depend on
   those before); or, in the end, takes these options back. */
static PetscErrorCode OrderSums(const MPMCore *core, PetscBool on)
{
  static const char *const order[][2] = {{"-matstash_reproduce", NULL}, {"-matptap_via", "allatonce"}};
  PetscMPIInt              size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  for (size_t k = 0; k < sizeof order / sizeof order[0] && size > 1; k++)
    PetscCall(on ? PetscOptionsSetValue(NULL, order[k][0], order[k][1]) : PetscOptionsClearValue(NULL, order[k][0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees what belongs to the places of the particles. */
static PetscErrorCode Clear(struct MPMStatic *s)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&s->snes));
  PetscCall(MatDestroy(&s->K));
  PetscCall(MatDestroy(&s->ghosts));
  PetscCall(PetscFree(s->run));
  PetscCall(VecDestroy(&s->u));
  PetscCall(VecDestroy(&s->r));
  PetscCall(VecDestroy(&s->was));
  PetscCall(VecDestroy(&s->work));
  PetscCall(VecDestroy(&s->v));
  PetscCall(VecDestroy(&s->past));
  PetscCall(MatDestroy(&s->M));
  for (int side = 0; side < 2; side++) PetscCall(VecDestroy(&s->bound[side]));
  PetscCall(DMDestroy(&s->numbers));
  PetscCall(PetscFree(s->node));
  PetscCall(PetscFree(s->at));
  PetscCall(PetscFree(s->held));
  PetscCall(PetscFree(s->pressed));
  PetscCall(PetscFree(s->known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticDestroy(MPMCore *core)
{
  PetscFunctionBeginUser;
  if (!core->implicit) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(OrderSums(core, PETSC_FALSE));
  PetscCall(Clear(core->implicit));
  PetscCall(PetscFree(core->implicit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the text of the first error of PETSc, in place of its stack of calls. */
static PetscErrorCode Keep(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                           PetscErrorType type, const char *text, void *kept)
{
  (void)comm;
  (void)line;
  (void)function;
  (void)file;
  if (type == PETSC_ERROR_INITIAL && text) (void)snprintf(kept, MPM_TEXT_LEN, "%.*s", (int)strcspn(text, "\n"), text);
  return code;
}

/* Lets PETSc read the options of its solvers; what it cannot use ends the run before its first step. */
static PetscErrorCode ReadOptions(struct MPMStatic *s)
{
  char           text[MPM_TEXT_LEN] = "";
  PetscErrorCode code;

  PetscFunctionBeginUser;
  PetscCall(PetscPushErrorHandler(Keep, text));
  code = SNESSetFromOptions(s->snes);
  PetscCall(PetscPopErrorHandler());
  if (code && !s->core->stop[0])
    (void)snprintf(s->core->stop, sizeof s->core->stop,
                   "an option of PETSc's solvers (-snes_*, -ksp_*, -pc_*) is wrong: %.500s; -help petsc lists them",
                   text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the solver, with the defaults that PETSc's own options change. */
static PetscErrorCode CreateSolver(struct MPMStatic *s)
{
  const MPMCore *core = s->core;
  PetscMPIInt    size;
  PetscBool      direct, given;
  SNESLineSearch search;
  KSP            ksp;
  PC             pc;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->exchange.data, &size));
  direct = core->grid.dim < 3; /* where K is indefinite multigrid fails, and in 2-D this is fast */
  PetscCall(SNESCreate(core->exchange.data, &s->snes));
  PetscCall(SNESSetType(s->snes, s->bound[0] ? SNESVINEWTONRSLS : SNESNEWTONLS));
  PetscCall(SNESSetFunction(s->snes, s->r, MPMStaticResidual, s));
  PetscCall(SNESSetJacobian(s->snes, s->K, s->K, MPMStaticJacobian, s));
  PetscCall(SNESSetTolerances(s->snes, 0, 1e-8, 0, ITERATIONS, 100000));
  PetscCall(SNESSetConvergenceTest(s->snes, MPMStaticConverged, s, NULL));
  PetscCall(SNESGetLineSearch(s->snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-snes_linesearch_type", &given));
  if (given) s->searches = PETSC_FALSE;
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPSetType(ksp, direct ? KSPPREONLY : s->symmetric ? KSPCG : KSPGMRES));
  if (direct && size > 1 && !s->bound[0])
    PetscCall(MPMStaticWholeCreate(s, pc));
  else
    /* Masses make K well conditioned, so that Jacobi's is enough. */
    PetscCall(PCSetType(pc, direct && size == 1 ? PCLU : direct ? PCREDUNDANT : s->inertia ? PCJACOBI : PCGAMG));
  PetscCall(KSPSetTolerances(ksp, 1e-6, PETSC_DEFAULT, PETSC_DEFAULT, s->inertia ? 5000 : 500));
  PetscCall(KSPGMRESSetRestart(ksp, 100));
  PetscCall(ReadOptions(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the unknowns, springs, masses and the solver. */
static PetscErrorCode Build(struct MPMStatic *s)
{
  const MPMCore *core = s->core;
  PetscInt       unknowns;
  int            exponent;

  PetscFunctionBeginUser;
  s->nominal = s->stiff / PetscSqr(MPMGridSmallestH(&core->grid)) *
               (core->grid.round ? 2 * PETSC_PI * core->grid.upper[0] : 1);
  for (PetscInt d = 0; d < core->grid.dim; d++) s->nominal *= core->grid.h[d];
  (void)frexp(s->nominal, &exponent);
  s->grain = s->ghost > 0 ? ldexp(1, exponent - GRAIN) : 0; /* without springs there may be smaller entries */
  s->least = ROUNDING * s->stiff;
  for (PetscInt d = 1; d < core->grid.dim; d++) s->least *= MPMGridSmallestH(&core->grid);
  if (core->grid.round) s->least *= 2 * PETSC_PI * core->grid.upper[0];
  PetscCall(MPMStaticNumber(s));
  PetscCall(VecGetSize(s->u, &unknowns));
  s->least *= PetscSqrtReal((PetscReal)unknowns); /* the norm of so many */
  if (s->ghost > 0) PetscCall(MPMStaticStabilise(s));
  if (s->inertia) PetscCall(MPMStaticMass(s));
  if (core->gaps) PetscCall(PetscCalloc1(PetscMax(1, s->n * core->grid.dim), &s->pressed));
  for (int side = 0; side < 2 && core->gaps; side++) PetscCall(VecDuplicate(s->u, &s->bound[side]));
  PetscCall(CreateSolver(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticRenew(struct MPMStatic *s)
{
  MPMCore *core = s->core;

  PetscFunctionBeginUser;
  PetscCall(MPMPhaseRun(core, MPMStepStartPhase(core, 0)));
  if (!s->stale) PetscFunctionReturn(PETSC_SUCCESS);
  s->stale = PETSC_FALSE;
  PetscCall(MPMTimersBegin(&core->timers, s->solve));
  PetscCall(Clear(s));
  PetscCall(
      PetscArrayzero(core->exchange.patch.state, MPMPatchNodes(&core->exchange.patch) * MPM_MOTION_NC(core->grid.dim)));
  PetscCall(Build(s));
  PetscCall(MPMTimersEnd(&core->timers, s->solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticCreate(MPMCore *core)
{
  struct MPMStatic *s = core->implicit;

  PetscFunctionBeginUser;
  s->symmetric = !(core->params.box && core->params.lock_share < 1);
  for (PetscInt k = 0; k < core->params.nmaterials; k++) {
    const MPMMaterial *m = &core->params.materials[k];

    s->stiff = PetscMax(s->stiff, m->lambda + 2 * m->mu);
    if (m->type->traits & MPM_PLASTIC) s->searches = PETSC_TRUE;
    if (!MPMTangentIsSymmetric(m, core->grid.dim)) s->symmetric = PETSC_FALSE;
  }
  for (PetscInt k = 0; k < s->scene->nloads; k++)
    if (s->scene->loads[k].type == MPM_LOAD_PRESSURE) s->symmetric = PETSC_FALSE;
  PetscCall(MPMTimersPhase(&core->timers, "SOLVE", &s->solve));
  PetscCall(MPMTimersPhase(&core->timers, "TANGENT", &s->tangent));
  PetscCall(OrderSums(core, PETSC_TRUE));
  if (!core->grid.total) PetscCall(core->exchange.type->sweep(core, MPMStepStartPhase(core, 0)));
  PetscCall(Build(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticCheckOptions(MPMCore *core)
{
  PetscInt          n;
  char            **names, **values;
  struct MPMStatic *s = core->implicit;

  PetscFunctionBeginUser;
  if (!s || !s->solves || s->checked) PetscFunctionReturn(PETSC_SUCCESS);
  s->checked = PETSC_TRUE;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n; k++)
    if (!core->stop[0] && MPMOptionsIsOfSolver(names[k]))
      (void)snprintf(
          core->stop, sizeof core->stop,
          "-%.100s is an option that PETSc's solvers of this run do not have; -help lists those of PETSc, and "
          "-snes_view says which solvers these are",
          names[k]);
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets *exact to whether the steps have the same bits on any number of processes: if the tangent and the residual have, and PETSc
   does nothing with them but LU. Steps that are solved again with a line search have not. */
static PetscErrorCode IsExact(const struct MPMStatic *s, PetscBool *exact)
{
  KSP            ksp, whole;
  PC             pc;
  SNESLineSearch how;
  PetscBool      newton, basic, once, lu;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(SNESGetLineSearch(s->snes, &how));
  PetscCall(MPMStaticWholeSolver(pc, &whole));
  PetscCall(PetscObjectTypeCompare((PetscObject)s->snes, SNESNEWTONLS, &newton));
  PetscCall(PetscObjectTypeCompare((PetscObject)how, SNESLINESEARCHBASIC, &basic));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPPREONLY, &once));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCLU, &lu));
  *exact = s->grain > 0 && !s->M && newton && basic && once && (lu || whole);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticPrint(const MPMCore *core)
{
  const struct MPMStatic *s = core->implicit;
  PetscInt                n;
  KSP                     ksp, whole;
  PC                      pc;
  KSPType                 linear;
  PCType                  with;
  SNESType                type;
  SNESLineSearch          search;
  SNESLineSearchType      how;
  PetscReal               bytes, solver;
  PetscBool               exact = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MPMStaticMatrixBytes(s, PETSC_TRUE, &bytes));
  PetscCall(MPMStaticForetellBytes(s, &solver));
  PetscCall(VecGetSize(s->u, &n));
  PetscCall(SNESGetType(s->snes, &type));
  PetscCall(SNESGetLineSearch(s->snes, &search));
  PetscCall(SNESLineSearchGetType(search, &how));
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetType(ksp, &linear));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCGetType(pc, &with));
  PetscCall(MPMStaticWholeSolver(pc, &whole));
  if (whole) PetscCall(PCShellGetName(pc, &with));
  PetscCall(IsExact(s, &exact));
  PetscCall(MPMPrint(&core->print,
                     "solver     %" PetscInt_FMT
                     " unknowns, matrices of %.3g MB, about %.3g MB for pc; snes %s with line search %s, "
                     "ksp %s, pc %s; the same bits %s\n",
                     n, (double)(bytes / 1e6), (double)(solver / 1e6), type, how, linear, with,
                     exact && s->searches ? "on any number of processes, but where a step needs a line search"
                     : exact              ? "on any number of processes"
                                          : "each time on as many processes"));
  for (PetscInt k = 0; k < core->params.nmaterials; k++)
    if (!MPMTangentIsOwn(&core->params.materials[k]))
      PetscCall(MPMPrint(&core->print,
                         "tangent    of %s by differences of its stress: its law has no tangent of its own\n",
                         core->params.materials[k].name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticReport(const MPMCore *core)
{
  const struct MPMStatic *s = core->implicit;
  PetscReal               bytes;
  PetscBool               known;
  char                    took[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  if (!s || !s->solves) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMStaticSolverBytes(s, &bytes, &known));
  if (known) (void)snprintf(took, sizeof took, "; pc took %.3g MB", (double)(bytes / 1e6));
  PetscCall(MPMPrint(&core->print,
                     "%-10s %" PetscInt_FMT " solves, of which %" PetscInt_FMT " found no %s, with %" PetscInt_FMT
                     " Newton and %" PetscInt_FMT " linear iterations; last residual %.2g of the forces%s\n",
                     s->M ? "implicit" : "static", s->solves, s->failed, s->M ? "solution" : "equilibrium", s->newton,
                     s->krylov, (double)(s->scale > 0 ? s->residual / s->scale : 0), took));
  if (s->loose > 0)
    PetscCall(
        MPMWarn(&core->print,
                "solves ended with up to %.2g of the forces out of balance, and what follows from them is hardly a "
                "solution; leave out -snes_rtol, which is 1e-8 then, and other options of PETSc's solvers",
                (double)s->loose));
  PetscFunctionReturn(PETSC_SUCCESS);
}
