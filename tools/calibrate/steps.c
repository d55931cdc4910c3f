/* steps.c - compares the times of whole steps with what the model predicts: of steps of all processes together, which
   show what an exchange costs besides its messages, and of the scene itself, as a check. */
#include "calibrate.h"

#define SPANS           5   /* parts of a run, between which the model predicts */
#define SPAN            60  /* steps of each */
#define CHECK_PARTICLES 1e6 /* per process; a check with more would take long */
#define CHECK_WORK      2e5 /* particles times steps of a run, but it has 20 to 500 steps */

/* Predicts the seconds of a step by the model, with this cost of an exchange. Collective on scene->core.comm. */
static PetscErrorCode PredictWith(MPM scene, MPM mpm, PetscReal exchange, PetscReal *seconds)
{
  PetscFunctionBeginUser;
  mpm->cost.model          = scene->cost.model;
  mpm->cost.model.exchange = exchange;
  *seconds                 = 0;
  PetscCall(MPMModelPredict(&mpm->cost, &mpm->core, MPMTimeStep(&mpm->core, &mpm->time)));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) *seconds += e == MPM_TIMER_MIGRATE ? 0 : mpm->cost.predicted[e];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds `part` times the prediction for the present state: bodies move from process to process, so the mean over the run
   counts. Collective on scene->core.comm. */
static PetscErrorCode PredictPart(MPM scene, MPM mpm, PetscReal part, TogetherTimes *t)
{
  PetscReal none, all;

  PetscFunctionBeginUser;
  PetscCall(PredictWith(scene, mpm, 0, &none));
  PetscCall(PredictWith(scene, mpm, 1, &all)); /* 1 s: far more than all else */
  t->predicted += part * none;
  t->exchanges += part * (all - none);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Times steps of all processes together, and predicts them. Collective on scene->core.comm. */
PetscErrorCode TimeTogether(MPM scene, TogetherTimes *t)
{
  PetscReal   coarser;
  PetscMPIInt size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(scene->core.comm, &size));
  coarser = PetscPowReal((PetscReal)scene->core.particles.total / (600. * size), 1 / (PetscReal)scene->core.grid.dim);
  for (int repeat = 0, tries = 0; repeat < 8 && tries < 16; tries++) {
    PetscReal step = PETSC_MAX_REAL;
    MPM       mpm;

    PetscCall(SetRun(scene, "spatial", coarser, SPANS * SPAN));
    PetscCall(MakeRun(scene->core.comm, &mpm));
    if (!mpm) { /* too coarse for so many processes */
      coarser /= 1.5;
      continue;
    }
    t->predicted = t->exchanges = 0;
    PetscCall(PredictPart(scene, mpm, 0.5 / SPANS, t));
    for (int k = 1; k <= SPANS; k++) { /* the mean is taken by the trapezoidal rule */
      mpm->time.max_steps = k * SPAN;
      PetscCall(MPMRun(mpm));
      PetscCall(PredictPart(scene, mpm, (k < SPANS ? 1. : 0.5) / SPANS, t));
    }
    if (mpm->core.step)
      step = (mpm->core.timers.steps - MPMTimersSeconds(&mpm->core.timers, MPM_TIMER_MIGRATE)) /
             (PetscReal)mpm->core.step;
    PetscCall(Slowest(scene->core.comm, &step));
    PetscCall(MPMDestroy(&mpm));
    Least(&t->step, step);
    repeat++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Times the first steps of the scene as it is: the least seconds per step go to *least. A scene with too many particles
   is not run. Collective on comm. */
PetscErrorCode TimeItself(MPM scene, MPI_Comm comm, PetscReal *least)
{
  const PetscReal n = (PetscReal)scene->core.particles.total;
  PetscMPIInt     size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (n > CHECK_PARTICLES * size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SetRun(scene, "spatial", 1, (PetscInt)PetscMax(20, PetscMin(500, CHECK_WORK / n))));
  for (int repeat = 0; repeat < (n < 3e4 ? 8 : n < 3e5 ? 2 : 1); repeat++) {
    PetscReal step;
    MPM       mpm;

    PetscCall(MakeRun(comm, &mpm));
    if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MPMRun(mpm));
    step = mpm->core.step ? mpm->core.timers.steps / (PetscReal)mpm->core.step : PETSC_MAX_REAL;
    PetscCall(Slowest(comm, &step));
    PetscCall(MPMDestroy(&mpm));
    Least(least, step);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the time of these steps, `least`, with the prediction of the model beside it. Collective on comm, whose first
   process is that of the scene. */
PetscErrorCode CheckItself(MPM scene, MPI_Comm comm, PetscReal least)
{
  PetscReal   predicted = 0;
  PetscMPIInt size;
  MPM         mpm;

  PetscFunctionBeginUser;
  if (least == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(SetRun(scene, "spatial", 1, 1));
  PetscCall(MakeRun(comm, &mpm));
  mpm->cost.model = scene->cost.model;
  PetscCall(MPMModelPredict(&mpm->cost, &mpm->core, MPMTimeStep(&mpm->core, &mpm->time)));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) predicted += mpm->cost.predicted[e];
  PetscCall(MPMPrint(
      &scene->core.print,
      "check      first steps of the scene itself on %d process%s: %.3g s a step, predicted %.3g, ratio %.2f\n", size,
      size > 1 ? "es" : "", (double)least, (double)predicted, (double)(predicted / least)));
  MPMModelMissed(&scene->cost.model, predicted / least);
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
