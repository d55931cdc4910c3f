/* timers.h - timers for the parts of a step, one for each name; each is also an event of -log_view.

   A part that runs inside another one is not counted in that one, so the seconds of all timers add up to the total.
   With -report_path the timers also keep the processor time of the work itself, without messages, for each step;
   cost/path.c prints the critical path from it. MPMWorkEnd also tells the simulator what was worked on
   (base/simulate.h). */
#ifndef MPM_TIMERS_H
#define MPM_TIMERS_H

#include "base/base.h"

/* The parts of a step that are no phases; the timers of the phases follow them. OTHER is the time that belongs to no
   part, and it has no event. */
enum {
  MPM_TIMER_FORCES,
  MPM_TIMER_REDUCE,
  MPM_TIMER_MIGRATE,
  MPM_TIMER_SORT,
  MPM_TIMER_SETTLE,
  MPM_TIMER_OTHER,
  MPM_TIMER_PHASES /* the number of the first phase */
};
#define MPM_MAX_TIMERS 48
#define MPM_MAX_OPEN   4 /* timers that may be open at once, each inside the one before */

/* The processor time of the work, a row for each step and a column for each timer. */
typedef struct {
  PetscBool  on;            /* -report_path */
  PetscInt   row, capacity; /* the row of the current step; rows that fit */
  PetscReal  start, paused; /* s */
  PetscReal *seconds;       /* [row+1][MPM_MAX_TIMERS] s of this process; NULL before the first step */
} MPMWork;

typedef struct {
  PetscInt       n; /* timers that there are: MPM_TIMER_PHASES and one for each phase */
  const char    *name[MPM_MAX_TIMERS];
  PetscLogEvent  event[MPM_MAX_TIMERS];
  PetscLogDouble seconds[MPM_MAX_TIMERS]; /* s of this process in all steps, less those of timers inside */
  PetscInt       nopen, open[MPM_MAX_OPEN];
  PetscLogDouble since;         /* when the innermost open timer was last started or continued */
  PetscBool      processor;     /* the clock counts processor time, to which other programs add nothing */
  PetscReal      flops, bytes;  /* counted by hand, of phases here; of the pool's master: its workers' too */
  PetscInt       first;         /* the step from which on this run has made steps: not 0 after a restart */
  PetscLogDouble steps, output; /* s of all steps; s of history and snapshots */
  MPMWork        work;
} MPMTimers;

/* Sets all times to 0 and registers the events, once in a process. Collective on the world. */
PetscErrorCode MPMTimersCreate(MPMTimers *);
PetscErrorCode MPMTimersDestroy(MPMTimers *);

/* Returns the timer of the phase of this name, and makes it if there is none yet. The name must stay valid. Not
   collective. */
PetscErrorCode MPMTimersPhase(MPMTimers *, const char name[], PetscInt *timer);

/* MPMTimersClock reads the clock in s; Begin and End enclose a part of a step. Not collective. */
PetscErrorCode MPMTimersClock(const MPMTimers *, PetscLogDouble *now);
PetscErrorCode MPMTimersBegin(MPMTimers *, PetscInt timer);
PetscErrorCode MPMTimersEnd(MPMTimers *, PetscInt timer);

/* Returns the time of a timer on this process, in s over all steps; for OTHER, the time of the steps that no other
   timer has. Not collective. */
PetscReal MPMTimersSeconds(const MPMTimers *, PetscInt timer);

/* Returns the timer that is row k = 0 .. n-1 of a printed table: phases come before the other parts. */
PetscInt MPMTimersRow(const MPMTimers *, PetscInt k);

/* Begin and End enclose work of a timer: its processor time is noted, and the simulator is told of `amount` units of
   the work `what` (NULL: it is told elsewhere). Pause and Resume leave out what lies between them. Not collective. */
void MPMWorkBegin(MPMTimers *);
void MPMWorkEnd(MPMTimers *, PetscInt timer, const char what[], PetscReal amount);
void MPMWorkPause(MPMTimers *);
void MPMWorkResume(MPMTimers *);

/* Begins a row for the work of a new step. one_row: all work of the run is added in one row, for processes of the pool,
   which take no part in whole steps. Not collective. */
PetscErrorCode MPMWorkStep(MPMTimers *, PetscBool one_row);

#endif
