/* timers.c - the clock, the timers of the parts of a step, and their events; timers.h describes them. */
#include <petscdm.h>
#include <petscsf.h>
#include <petsctime.h>
#include <time.h>
#include "base/simulate.h"
#include "base/timers.h"

static const char *const parts[] = {"FORCES", "REDUCE", "MIGRATE", "SORT", "SETTLE", "other"};
_Static_assert(sizeof parts / sizeof parts[0] == MPM_TIMER_PHASES, "every part of a step that is no phase has a name");

/* Returns the processor time of this thread in s. */
static PetscReal Processor(void)
{
  struct timespec now;

  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (PetscReal)now.tv_sec + 1e-9 * (PetscReal)now.tv_nsec;
}

/* Finds the event of this name, or registers it. */
static PetscErrorCode Event(const char name[], PetscLogEvent *event)
{
  static PetscClassId id = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscLogEventGetId(name, event));
  if (*event >= 0) PetscFunctionReturn(PETSC_SUCCESS); /* an earlier run of this program has registered it */
  if (!id) PetscCall(PetscClassIdRegister("MPM", &id));
  PetscCall(PetscLogEventRegister(name, id, event));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTimersCreate(MPMTimers *t)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(t->seconds, sizeof t->seconds));
  PetscCall(DMInitializePackage()); /* -log_view needs equal events on all processes; workers of a pool make no DM */
  PetscCall(PetscSFInitializePackage());
  t->n = MPM_TIMER_PHASES;
  for (PetscInt k = 0; k < MPM_TIMER_PHASES; k++) {
    t->name[k] = parts[k];
    if (k != MPM_TIMER_OTHER) PetscCall(Event(parts[k], &t->event[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the times of the work. Not collective. */
PetscErrorCode MPMTimersDestroy(MPMTimers *t)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(t->work.seconds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTimersPhase(MPMTimers *t, const char name[], PetscInt *timer)
{
  PetscFunctionBeginUser;
  for (*timer = MPM_TIMER_PHASES; *timer < t->n && strcmp(t->name[*timer], name);) ++*timer;
  if (*timer < t->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(t->n < MPM_MAX_TIMERS, PETSC_COMM_SELF, PETSC_ERR_PLIB, "phase %s: there are %d timers at most", name,
             MPM_MAX_TIMERS);
  t->name[t->n] = name;
  PetscCall(Event(name, &t->event[t->n++]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTimersClock(const MPMTimers *t, PetscLogDouble *now)
{
  PetscFunctionBeginUser;
  if (t->processor)
    *now = Processor();
  else
    PetscCall(PetscTime(now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the time since the last call to the innermost open timer. */
static PetscErrorCode AddTime(MPMTimers *t)
{
  PetscLogDouble now;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersClock(t, &now));
  if (t->nopen) t->seconds[t->open[t->nopen - 1]] += now - t->since;
  t->since = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTimersBegin(MPMTimers *t, PetscInt timer)
{
  PetscFunctionBeginUser;
  PetscCheck(t->nopen < MPM_MAX_OPEN, PETSC_COMM_SELF, PETSC_ERR_PLIB, "timer %s: %d are open already", t->name[timer],
             MPM_MAX_OPEN);
  PetscCall(PetscLogEventBegin(t->event[timer], 0, 0, 0, 0));
  PetscCall(AddTime(t));
  t->open[t->nopen++] = timer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTimersEnd(MPMTimers *t, PetscInt timer)
{
  PetscFunctionBeginUser;
  PetscCheck(t->nopen && t->open[t->nopen - 1] == timer, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "timer %s is not the innermost that is open", t->name[timer]);
  PetscCall(AddTime(t));
  t->nopen--;
  PetscCall(PetscLogEventEnd(t->event[timer], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MPMTimersSeconds(const MPMTimers *t, PetscInt timer)
{
  PetscReal other = t->steps;

  if (timer != MPM_TIMER_OTHER) return t->seconds[timer];
  for (PetscInt k = 0; k < t->n; k++) other -= t->seconds[k];
  return other;
}

PetscInt MPMTimersRow(const MPMTimers *t, PetscInt k)
{
  return k < t->n - MPM_TIMER_PHASES ? MPM_TIMER_PHASES + k : k - (t->n - MPM_TIMER_PHASES);
}

void MPMWorkBegin(MPMTimers *t)
{
  if (t->work.on) t->work.start = Processor();
}

void MPMWorkEnd(MPMTimers *t, PetscInt timer, const char what[], PetscReal amount)
{
  MPMWork *w = &t->work;

  if (w->on && w->seconds) w->seconds[w->row * MPM_MAX_TIMERS + timer] += Processor() - w->start;
  if (what) MPMSimulateWork(what, amount);
}

void MPMWorkPause(MPMTimers *t)
{
  if (t->work.on) t->work.paused = Processor();
}

void MPMWorkResume(MPMTimers *t)
{
  if (t->work.on) t->work.start += Processor() - t->work.paused;
}

PetscErrorCode MPMWorkStep(MPMTimers *t, PetscBool one_row)
{
  MPMWork *w = &t->work;

  PetscFunctionBeginUser;
  if (!w->on || (w->seconds && one_row)) PetscFunctionReturn(PETSC_SUCCESS);
  if (w->seconds) w->row++;
  if (w->row >= w->capacity) {
    PetscReal     *seconds;
    const PetscInt capacity = 2 * w->capacity + 64;

    PetscCall(PetscCalloc1(capacity * MPM_MAX_TIMERS, &seconds));
    PetscCall(PetscArraycpy(seconds, w->seconds, w->capacity * MPM_MAX_TIMERS));
    PetscCall(PetscFree(w->seconds));
    w->seconds  = seconds;
    w->capacity = capacity;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
