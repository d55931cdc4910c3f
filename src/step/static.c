/* static.c - a step without inertia in the total frame: SNES finds the displacements at which the residual, the sum of all
   forces on a node, is 0. The residual is made by the two transfers of an explicit step, on the state of the particles as
   the step began; nothing else of the state changes before the step has converged. */
#include "parallel/exchange.h"
#include "step/static.h"
#include "step/step.h"

/* PETSc's mark of a state without residual, SNESSetFunctionDomainError, would end a line search and outlast the solve. */
#define WORST 1e100 /* the residual of such a state, N */
#define SAME  1e-9  /* the parts by which sums of the same numbers may differ */
#define USUAL 5     /* iterations of Newton's method in a step */
#define LONG  1     /* s: a run that takes as long is foretold by its first two iterations */

/* Sets the displacements of the nodes, in the updated frame those of the step, to those of a vector, and their velocities to
   those after a step to these; or, if it is where they were as the step began, to those of then. Without inertia these are
   0. */
static PetscErrorCode ToNodes(struct MPMStatic *s, Vec from)
{
  const PetscInt     dim = s->core->grid.dim;
  const PetscScalar *u, *was, *v = NULL;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(from, &u));
  PetscCall(VecGetArrayRead(s->was, &was));
  if (s->M) PetscCall(VecGetArrayRead(s->v, &v));
  for (PetscInt q = 0; q < s->n; q++)
    for (PetscInt d = 0; d < dim; d++) {
      const PetscInt k     = q * dim + d;
      PetscReal     *state = s->core->exchange.patch.state + s->node[q] * MPM_MOTION_NC(dim);

      state[d]       = s->core->grid.total ? u[k] : u[k] / s->core->params.dt; /* a velocity in the updated frame */
      state[dim + d] = !s->M ? 0 : from == s->was ? v[k] : MPMStaticVelocity(s, k, u[k] - was[k], v[k]);
    }
  if (s->M) PetscCall(VecRestoreArrayRead(s->v, &v));
  PetscCall(VecRestoreArrayRead(s->was, &was));
  PetscCall(VecRestoreArrayRead(from, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the particles' state that of displacements u, from that as the step began. s->bad: some particle is turned inside
   out, and its stress has no meaning. */
static PetscErrorCode Try(struct MPMStatic *s, Vec u)
{
  MPMCore  *core = s->core;
  MPMStatus all;

  PetscFunctionBeginUser;
  PetscCall(ToNodes(s, u));
  PetscCall(MPMParticlesPutBack(&core->particles));
  MPMStatusReset(&core->status);
  PetscCall(MPMPhaseRun(core, core->program[0]));
  PetscCall(MPMPhaseRun(core, core->program[1]));
  all = core->status;
  PetscCall(core->exchange.type->reduce(core, &all));
  s->bad = MPMStatusIsBad(&all);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets r [n][dim] to the residual of the state that Try made, N: the forces on each node with the opposite sign, and 0
   where a wall holds it. p of the nodes becomes the force of the wall. *all: the norm with those of walls. */
static PetscErrorCode Forces(struct MPMStatic *s, Vec u, Vec r, PetscReal *all)
{
  MPMCore       *core = s->core;
  const PetscInt dim  = core->grid.dim;
  PetscScalar   *to;
  PetscBool      wrong = PETSC_FALSE;
  MPMSum sum[3]; /* squares, of the residual with the walls, of forces alone where there is inertia, of the residual */

  PetscFunctionBeginUser;
  if (core->needs.forced) PetscCall(MPMForcesUpdate(s->scene, core, core->t + core->params.dt));
  PetscCall(MPMPhaseRun(core, core->program[2]));
  if (s->ghosts)
    PetscCall(MPMStaticSprings(s, u, r));
  else
    PetscCall(VecSet(r, 0));
  for (int k = 0; k < 3; k++) MPMSumZero(&sum[k]);
  PetscCall(MPMStaticInertia(s, u, r));
  PetscCall(MPMExchangeOpenNodes(core));
  PetscCall(VecGetArray(r, &to));
  for (PetscInt q = 0; q < s->n; q++) {
    MPMNode *n = core->exchange.patch.node + s->node[q];

    for (PetscInt d = 0; d < dim; d++) {
      const PetscInt  k     = q * dim + d;
      const PetscReal given = n->f[d] + s->share * n->m * core->params.gravity[d], force = given - to[k];

      n->p[d] = s->held[k] ? -force / (1 + s->held_over) : 0; /* the mean over a step of Newmark */
      to[k]   = s->held[k] ? 0 : -force;
      if (PetscIsInfOrNanReal(force * force)) {
        wrong = PETSC_TRUE;
        continue;
      }
      MPMSumAdd(&sum[0], force * force);
      if (s->M) MPMSumAdd(&sum[1], given * given);
      MPMSumAdd(&sum[2], to[k] * to[k]);
    }
  }
  PetscCall(VecRestoreArray(r, &to));
  PetscCall(MPMExchangeCloseNodes(core));
  PetscCall(MPMSumReduce(sum, 3, core->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &wrong, 1, MPM_MPI_BOOL, MPI_LOR, core->exchange.data));
  *all    = wrong ? NAN : PetscSqrtReal(PetscMax(MPMSumValue(&sum[0]), MPMSumValue(&sum[1])));
  s->norm = wrong ? NAN : PetscSqrtReal(MPMSumValue(&sum[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticResidual(SNES snes, Vec u, Vec r, void *ctx)
{
  struct MPMStatic *s = ctx;
  PetscReal         all;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(Try(s, u));
  if (s->bad) {
    PetscCall(VecSet(r, WORST));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Forces(s, u, r, &all));
  s->scale = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticJacobian(SNES snes, Vec u, Mat A, Mat K, void *ctx)
{
  PetscFunctionBeginUser;
  (void)snes;
  (void)u;
  PetscCall(MPMStaticTangent(ctx, K, NULL, NULL));
  if (A != K) {
    PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says after two iterations of the first solve how long the run will take, if it is long. */
static PetscErrorCode Foretell(struct MPMStatic *s, PetscInt it)
{
  const MPMCore *core  = s->core;
  PetscReal      steps = PetscCeilReal((s->time->end - core->t) / core->params.dt * (1 - 1e-9)), all;
  PetscLogDouble now;
  char           words[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if (s->solves || (it && it != 2)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  if (!it) s->began = now;
  if (s->time->max_steps != PETSC_MAX_INT) steps = PetscMin(steps, (PetscReal)(s->time->max_steps - core->step));
  all = (now - s->began) / 2 * USUAL * steps;
  if (!it || all < LONG) PetscFunctionReturn(PETSC_SUCCESS);
  MPMTimeWords(all, words);
  PetscCall(MPMSay(
      &core->print, "predict",
      "two iterations of Newton's method took %.2g s: with %d in each of %.6g steps about %s in all; plastic flow takes more, and steps that are cut",
      now - s->began, USUAL, (double)steps, words));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton's method has converged when the residual is a part of the forces that are in equilibrium, those of walls among
   them; not of the first residual, which may be rounding already. */
PetscErrorCode MPMStaticConverged(SNES snes, PetscInt it, PetscReal x, PetscReal step, PetscReal f,
                                  SNESConvergedReason *reason, void *ctx)
{
  struct MPMStatic *s = ctx;
  PetscReal         rtol;
  PetscInt          most;

  PetscFunctionBeginUser;
  (void)x;
  (void)step;
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, &most, NULL));
  if (PetscAbsReal(f - s->norm) < SAME * f) f = s->norm; /* PETSc's depends on the cuts of the grid */
  s->residual = f;
  *reason     = SNES_CONVERGED_ITERATING;
  PetscCall(Foretell(s, it));
  if (s->bad)
    *reason = SNES_DIVERGED_FUNCTION_DOMAIN;
  else if (PetscIsInfOrNanReal(f))
    *reason = SNES_DIVERGED_FNORM_NAN;
  else if (f <= PetscMax(rtol * s->scale, s->least))
    *reason = SNES_CONVERGED_FNORM_RELATIVE;
  else if (f > 1e8 * s->scale)
    *reason = SNES_DIVERGED_DTOL;
  else if (it >= most)
    *reason = SNES_DIVERGED_MAX_IT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says in words where the largest part of the residual is: " near ..." by its node, or nothing. */
static PetscErrorCode Worst(struct MPMStatic *s, char words[2 * MPM_NAME_LEN])
{
  const MPMCore *core = s->core;
  const PetscInt dim  = core->grid.dim;
  PetscInt       most, begin, end;
  PetscReal      value, at[3] = {0, 0, 0};
  char           place[MPM_NAME_LEN];
  Vec            r;

  PetscFunctionBeginUser;
  words[0] = 0;
  PetscCall(SNESGetFunction(s->snes, &r, NULL, NULL));
  PetscCall(VecCopy(r, s->work));
  PetscCall(VecAbs(s->work));
  PetscCall(VecMax(s->work, &most, &value));
  if (most < 0 || !(value > 0) || PetscIsInfOrNanReal(value)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetOwnershipRange(r, &begin, &end));
  if (most >= begin && most < end) {
    PetscInt ijk[3];

    MPMStaticWhere(s, (most - begin) / dim, ijk);
    MPMGridNodeAt(&core->grid, ijk, at);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, at, 3, MPIU_REAL, MPI_SUM, core->exchange.data));
  MPMPlaceWords(dim, at, place);
  (void)snprintf(words, 2 * MPM_NAME_LEN, ", most at %s", place);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says in core->stop why a step found no equilibrium. */
static PetscErrorCode Fail(struct MPMStatic *s, SNESConvergedReason reason)
{
  MPMCore           *core = s->core;
  KSP                ksp;
  KSPConvergedReason linear;
  PetscInt           it;
  char               why[MPM_NAME_LEN], where[2 * MPM_NAME_LEN];
  const char        *what = s->M ? "no solution of the step" : "no equilibrium";

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(s->snes, &it));
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetConvergedReason(ksp, &linear));
  (void)snprintf(why, sizeof why, "%s",
                 linear == KSP_DIVERGED_INDEFINITE_MAT || linear == KSP_DIVERGED_INDEFINITE_PC
                     ? "the tangent is indefinite; try -ksp_type gmres"
                 : reason == SNES_DIVERGED_LINEAR_SOLVE ? KSPConvergedReasons[linear]
                                                        : SNESConvergedReasons[reason]);
  if (reason == SNES_CONVERGED_ITERATING)
    (void)snprintf(core->stop, sizeof core->stop,
                   "%s was found near the last one, at t=%g s: that at t=%g s has displacement gradients of %.3g "
                   "from it, and -dt_strain allows %g",
                   what, (double)core->t, (double)(core->t + core->params.dt), (double)s->leap, (double)s->most);
  else if (reason == SNES_DIVERGED_FUNCTION_DOMAIN || s->bad)
    (void)snprintf(core->stop, sizeof core->stop,
                   "%s was found at t=%g s: a particle would be turned inside out in Newton iteration %" PetscInt_FMT,
                   what, (double)(core->t + core->params.dt), it);
  else {
    PetscCall(Worst(s, where));
    (void)snprintf(core->stop, sizeof core->stop,
                   "%s was found at t=%g s: after %" PetscInt_FMT
                   " Newton iterations %.3g N are out of balance%s, of %.3g N (%s)",
                   what, (double)(core->t + core->params.dt), it, (double)s->residual, where, (double)s->scale, why);
  }
  MPMStatusReset(&core->status);
  PetscCall(ToNodes(s, s->was));
  PetscCall(MPMParticlesPutBack(&core->particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to core->half the work of gravity in this step less that of its full strength, J, by the displacements of nodes. */
static PetscErrorCode AddGravity(struct MPMStatic *s, PetscReal share)
{
  MPMCore           *core = s->core;
  const PetscInt     dim  = core->grid.dim;
  const PetscScalar *u, *was;
  MPMSum             sum;

  PetscFunctionBeginUser;
  if (share == 1) PetscFunctionReturn(PETSC_SUCCESS);
  MPMSumZero(&sum);
  PetscCall(MPMExchangeOpenNodes(core));
  PetscCall(VecGetArrayRead(s->u, &u));
  PetscCall(VecGetArrayRead(s->was, &was));
  for (PetscInt q = 0; q < s->n; q++)
    for (PetscInt d = 0; d < dim; d++)
      MPMSumAdd(&sum, core->exchange.patch.node[s->node[q]].m * core->params.gravity[d] *
                          (u[q * dim + d] - was[q * dim + d]));
  PetscCall(VecRestoreArrayRead(s->was, &was));
  PetscCall(VecRestoreArrayRead(s->u, &u));
  PetscCall(MPMExchangeCloseNodes(core));
  PetscCall(MPMSumReduce(&sum, 1, core->exchange.data));
  core->half += (share - 1) * MPMSumValue(&sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the displacements of the nodes into a vector. */
static PetscErrorCode FromNodes(struct MPMStatic *s, Vec to)
{
  const PetscInt dim = s->core->grid.dim;
  PetscScalar   *u;

  PetscFunctionBeginUser;
  PetscCall(VecSet(to, 0));
  if (!s->core->grid.total) PetscFunctionReturn(PETSC_SUCCESS); /* they are those of the step */
  PetscCall(VecGetArray(to, &u));
  for (PetscInt q = 0; q < s->n; q++)
    for (PetscInt d = 0; d < dim; d++)
      u[q * dim + d] = s->core->exchange.patch.state[s->node[q] * MPM_MOTION_NC(dim) + d];
  PetscCall(VecRestoreArray(to, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends a step of the updated frame: moves the particles, which stay at rest, and F-bar begins anew. */
static PetscErrorCode Move(struct MPMStatic *s)
{
  MPMCore       *core   = s->core;
  const PetscInt fields = MPM_BIT(v) | MPM_BIT(bar);
  MPMView        view;

  PetscFunctionBeginUser;
  if (core->grid.total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPhaseRun(core, core->program[3]));
  core->status.v2 = 0;
  s->stale        = PETSC_TRUE;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  PetscCall(PetscArrayzero(view.v, view.n * core->grid.dim));
  for (PetscInt p = 0; p < view.n && view.bar; p++) view.bar[p] = 1;
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins the solve of a step: what walls hold, and a first guess. */
static PetscErrorCode Begin(struct MPMStatic *s)
{
  MPMCore *core = s->core;

  PetscFunctionBeginUser;
  if (core->reactions) PetscCall(MPMTotalKeep(core));
  PetscCall(FromNodes(s, s->was));
  PetscCall(MPMStaticHold(s));
  PetscCall(VecCopy(s->was, s->u));
  s->share = MPMStaticShare(s, core->t + core->params.dt);
  s->scale = 0;
  PetscCall(MPMStaticInertiaBegin(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* If walls move, changes the first guess by one linear step, which carries what they do to the nodes inside; else the
   particles beside a wall could be turned inside out before Newton's method begins. */
static PetscErrorCode Predict(struct MPMStatic *s)
{
  const PetscInt n     = s->n * s->core->grid.dim;
  PetscBool      moves = PETSC_FALSE;
  PetscReal      all;
  PetscScalar   *u;
  KSP            ksp;

  PetscFunctionBeginUser;
  if (s->M) PetscFunctionReturn(PETSC_SUCCESS); /* inertia does that */
  PetscCall(VecGetArray(s->u, &u));
  for (PetscInt k = 0; k < n; k++)
    if (s->held[k] && u[k] != s->known[k]) moves = PETSC_TRUE;
  PetscCall(VecRestoreArray(s->u, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moves, 1, MPM_MPI_BOOL, MPI_LOR, s->core->exchange.data));
  if (!moves) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Try(s, s->u));
  PetscCall(Forces(s, s->u, s->r, &all));
  PetscCall(MPMStaticPress(s, s->r));
  PetscCall(VecScale(s->r, -1));
  PetscCall(VecCopy(s->was, s->work));
  PetscCall(VecGetArray(s->work, &u));
  for (PetscInt k = 0; k < n; k++) u[k] = s->held[k] ? s->known[k] - u[k] : 0;
  PetscCall(VecRestoreArray(s->work, &u));
  PetscCall(MPMStaticTangent(s, s->K, s->work, s->r));
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPSetOperators(ksp, s->K, s->K));
  PetscCall(KSPSolve(ksp, s->r, s->work));
  PetscCall(VecAXPY(s->u, 1, s->work));
  PetscCall(MPMStaticPress(s, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for the displacements of the step, and counts how. */
static PetscErrorCode Solve(struct MPMStatic *s, SNESConvergedReason *reason)
{
  PetscInt newton, krylov;
  KSP      ksp;
  PC       pc;

  PetscFunctionBeginUser;
  PetscCall(Begin(s));
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  /* So that a step depends on nothing but its state, and a restart has the same bits. KSPReset would forget -ksp_view. */
  PetscCall(PCReset(pc));
  PetscCall(Predict(s));
  if (s->bound[0]) PetscCall(KSPReset(ksp)); /* the variational inequality solves for fewer unknowns */
  PetscCall(SNESSolve(s->snes, NULL, s->u));
  PetscCall(SNESGetConvergedReason(s->snes, reason));
  PetscCall(SNESGetIterationNumber(s->snes, &newton));
  PetscCall(SNESGetLinearSolveIterations(s->snes, &krylov));
  s->newton += newton;
  s->krylov += krylov;
  s->solves++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticStep(MPMCore *core)
{
  struct MPMStatic   *s = core->implicit;
  SNESConvergedReason reason;
  PetscReal           all;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, s->solve));
  PetscCall(Solve(s, &reason));
  if (reason <= 0 && s->searches) { /* whole steps suit bending, shortened ones plastic flow */
    SNESLineSearch search;

    PetscCall(ToNodes(s, s->was));
    PetscCall(MPMParticlesPutBack(&core->particles)); /* the new solve begins with forces and gaps of this state */
    PetscCall(SNESGetLineSearch(s->snes, &search));
    PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBT));
    PetscCall(Solve(s, &reason));
    PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBASIC));
  }
  if (reason > 0) PetscCall(MPMStaticLeap(s, &s->leap));
  PetscCall(MPMTimersEnd(&core->timers, s->solve));
  if (reason > 0 && s->leap > s->most) reason = SNES_CONVERGED_ITERATING;
  if (reason <= 0) {
    s->failed++;
    PetscCall(Fail(s, reason));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Try(s, s->u));
  PetscCall(Forces(s, s->u, s->r, &all));
  PetscCall(MPMStaticPush(s, s->r));
  if (core->reactions) PetscCall(MPMReactionsPhase(core, 0, PETSC_FALSE));
  PetscCall(AddGravity(s, MPMStaticShare(s, core->t + 0.5 * core->params.dt)));
  PetscCall(Move(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
