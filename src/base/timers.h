/* timers.h - where the time of a run goes: one timer for each named part of a step, each an event of -log_view.

   A part that runs inside another takes its seconds from that one: the seconds of all timers add up. With -report_path
   the timers also keep the processor time of the work itself, without messages, for each step (cost/path.c prints the
   critical path); and the simulator hears from them what was worked on (base/simulate.h). */
#ifndef MPM_TIMERS_H
#define MPM_TIMERS_H

#include "base/base.h"

/* Parts of a step that are no phases; the phases, by name, follow. OTHER is what no part has, and no event. */
enum {
  MPM_TIMER_FORCES,
  MPM_TIMER_REDUCE,
  MPM_TIMER_MIGRATE,
  MPM_TIMER_SORT,
  MPM_TIMER_SETTLE,
  MPM_TIMER_OTHER,
  MPM_TIMER_PHASES /* the first phase */
};
#define MPM_MAX_TIMERS 32
#define MPM_MAX_OPEN   4 /* parts in parts */

/* The processor time of the work, by timer: a row a step. */
typedef struct {
  PetscBool  on;            /* -report_path */
  PetscInt   row, capacity; /* the row of the step at work */
  PetscReal  start, paused; /* s */
  PetscReal *seconds;       /* [row+1][MPM_MAX_TIMERS] s, here; NULL: no step yet */
} MPMWork;

typedef struct {
  PetscInt       n; /* timers: MPM_TIMER_PHASES and the phases */
  const char    *name[MPM_MAX_TIMERS];
  PetscLogEvent  event[MPM_MAX_TIMERS];
  PetscLogDouble seconds[MPM_MAX_TIMERS]; /* s of all steps, here, less those of timers inside */
  PetscInt       nopen, open[MPM_MAX_OPEN];
  PetscLogDouble since;         /* when the innermost open timer went on */
  PetscBool      processor;     /* the clock is the processor's, which other programs do not lengthen */
  PetscReal      flops, bytes;  /* of the phases here, counted by hand; of the pool's master: its workers' too */
  PetscLogDouble steps, output; /* s of all steps, and of history and snapshots */
  MPMWork        work;
} MPMTimers;

/* Registers the events once a process. Collective on the world. */
PetscErrorCode MPMTimersCreate(MPMTimers *);
PetscErrorCode MPMTimersDestroy(MPMTimers *);

/* The timer of a phase of this name, made when it is met first. */
PetscErrorCode MPMTimersPhase(MPMTimers *, const char name[], PetscInt *timer);

/* The clock in s, and the interval between two calls around a part of a step. Not collective. */
PetscErrorCode MPMTimersClock(const MPMTimers *, PetscLogDouble *now);
PetscErrorCode MPMTimersBegin(MPMTimers *, PetscInt timer);
PetscErrorCode MPMTimersEnd(MPMTimers *, PetscInt timer);

/* Wall time of a timer, s of all steps here; of OTHER what is left of the steps. */
PetscReal MPMTimersSeconds(const MPMTimers *, PetscInt timer);

/* The k-th timer of a printed table, k = 0 .. n-1: the phases come first. */
PetscInt MPMTimersRow(const MPMTimers *, PetscInt k);

/* Work that belongs to a timer: its processor time, and `amount` units of the work `what` for the simulator (NULL: it
   is declared elsewhere). Pause and resume leave out what lies between them. Not collective. */
void MPMWorkBegin(MPMTimers *);
void MPMWorkEnd(MPMTimers *, PetscInt timer, const char what[], PetscReal amount);
void MPMWorkPause(MPMTimers *);
void MPMWorkResume(MPMTimers *);

/* Makes room for the work of a step. one_row: a process of the pool takes no part in steps and keeps sums over the
   run. */
PetscErrorCode MPMWorkStep(MPMTimers *, PetscBool one_row);

#endif
