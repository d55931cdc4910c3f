/* unit_tables.c - what the tables of a step have room for: the program of every scheme with every transfer, a timer for
   every phase, under its own name; a phase too many is refused and leaves the other timers as they are. And what timers
   tell: parts inside of parts take their seconds from these, so that all seconds add up to the outer interval. */
#include <time.h>
#include "run/mpm.h"
#include "unit.h"

/* Errors are returned, not printed. */
static PetscErrorCode Quiet(void)
{
  return PetscPushErrorHandler(PetscReturnErrorHandler, NULL);
}

/* Is the event of this timer, which -log_view shows, the one of its name? */
static PetscErrorCode CheckEvent(const MPMTimers *t, PetscInt timer)
{
  PetscLogEvent event;

  PetscFunctionBeginUser;
  PetscCall(PetscLogEventGetId(t->name[timer], &event));
  CHECK(event >= 0);
  CHECK_EQ(t->event[timer], event);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The program of a method: it fits, and is that of its rows; every phase of the table has a timer of its name. */
static PetscErrorCode CheckMethod(const MPMScheme *scheme, const MPMTransfer *transfer, PetscInt order)
{
  static MPMCore  core;
  const MPMMethod method = {.scheme = scheme, .transfer = transfer};
  const PetscInt  rounds = transfer->rounds == MPM_CORRECT ? order - 1 : order; /* three phases each */
  PetscInt        n = 0, from = 0;                                              /* from: where the rounds begin */

  PetscFunctionBeginUser;
  UnitContext("%s %s, order %d", scheme->name, transfer->name, (int)order);
  memset(&core, 0, sizeof core);
  core.params.order = order;
  for (const int *k = scheme->phases; *k >= 0; k++) n++;
  CHECK(n > 0 && n < MPM_MAX_SCHEME);
  PetscCall(MPMStepSetUp(&core, &method));
  CHECK_EQ(core.nprogram, 3 * rounds + n);
  while (transfer->rounds == MPM_CORRECT && strcmp(core.program[from++]->name, "ADVANCE")) CHECK_LE(from, n);
  CHECK_LE(core.nprogram, MPM_MAX_PROGRAM);
  CHECK(core.nphases > 0 && core.nphases <= MPM_MAX_PHASES);
  CHECK_LE(core.timers.n, MPM_MAX_TIMERS);
  for (PetscInt k = 0; k < core.nprogram; k++) {
    const MPMPhase *phase = core.program[k];

    CHECK(phase >= core.phases && phase < core.phases + core.nphases);
    if (k < from || k >= from + 3 * rounds) {
      CHECK_EQ(phase - core.phases, scheme->phases[k < from ? k : k - 3 * rounds]);
      continue;
    }
    /* the filter: to nodes, nodes, to particles; from the second order on of what is left. Corrections: to particles,
       of v each time, to nodes, nodes */
    CHECK_EQ((PetscInt)phase->kind, transfer->rounds == MPM_CORRECT ? (k - from + 2) % 3 : k % 3);
    if (phase->kind == MPM_PARTICLES_TO_NODES && transfer->rounds == MPM_CORRECT)
      CHECK(phase->parts & MPM_RESIDUAL);
    else if (phase->kind != MPM_NODES)
      CHECK_EQ(phase->parts & MPM_RESIDUAL ? 1 : 0, k >= 3 && transfer->rounds == MPM_FILTER ? 1 : 0);
  }
  for (PetscInt k = 0; k < core.nphases; k++) {
    const MPMPhase *phase = &core.phases[k];

    CHECK(phase->name && phase->name[0]);
    CHECK((phase->kind == MPM_NODES) == (phase->nodes != NULL));
    /* what the transfer adds, it adds to what carries velocity, and to nothing else */
    CHECK_EQ(phase->parts & transfer->parts,
             phase->parts & (MPM_P2G_MOMENTUM | MPM_G2P_MOTION) && !(phase->parts & MPM_RESIDUAL) ? transfer->parts
                                                                                                  : 0);
    CHECK(phase->timer >= MPM_TIMER_PHASES && phase->timer < core.timers.n);
    CHECK(!strcmp(core.timers.name[phase->timer], phase->name));
    PetscCall(CheckEvent(&core.timers, phase->timer));
    for (PetscInt i = 0; i < k; i++) /* phases share a timer if and only if they share the name */
      CHECK((core.phases[i].timer == phase->timer) == !strcmp(core.phases[i].name, phase->name));
    if (phase->kind != MPM_NODES)
      for (PetscInt dim = 1; dim <= 3; dim++)
        for (int basis = 0; basis < MPM_NUM_BASES; basis++)
          CHECK(MPMKernelFind(dim, (MPMBasis)basis, phase->parts) != NULL);
  }
  for (PetscInt k = 0; k < 2; k++) { /* what output shows of nodes: first sums, then their velocity */
    const MPMPhase *phase = MPMStepOutputPhase(&core, k);

    CHECK(phase >= core.phases && phase < core.phases + core.nphases);
    CHECK_EQ(phase->kind, k ? MPM_NODES : MPM_PARTICLES_TO_NODES);
  }
  PetscCall(MPMTimersDestroy(&core.timers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every name of the table of timers once, of the rows that are printed too, phases first. */
static PetscErrorCode CheckNames(const MPMTimers *t)
{
  int seen[MPM_MAX_TIMERS] = {0};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < t->n; k++) {
    const PetscInt row = MPMTimersRow(t, k);

    CHECK(row >= 0 && row < t->n);
    if (row < 0 || row >= t->n) continue;
    CHECK_EQ(seen[row], 0);
    seen[row] = 1;
    CHECK_EQ(row >= MPM_TIMER_PHASES ? 1 : 0, k < t->n - MPM_TIMER_PHASES ? 1 : 0);
    CHECK(t->name[k] && t->name[k][0]);
    for (PetscInt i = 0; i < k; i++) CHECK(strcmp(t->name[i], t->name[k]));
    if (k != MPM_TIMER_OTHER) PetscCall(CheckEvent(t, k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Phases as long as there is room, each asked for twice; then one too many. */
static PetscErrorCode Capacity(void)
{
  static char names[MPM_MAX_TIMERS + 1][16];
  struct {
    char      below[256];
    MPMTimers timers;
    char      above[256];
  } guarded, before;
  MPMTimers     *t = &guarded.timers;
  PetscInt       timer;
  PetscErrorCode code;

  PetscFunctionBeginUser;
  UnitContext("capacity");
  memset(&guarded, 0, sizeof guarded);
  memset(guarded.below, 0x5a, sizeof guarded.below);
  memset(guarded.above, 0x5a, sizeof guarded.above);
  PetscCall(MPMTimersCreate(t));
  CHECK_EQ(t->n, MPM_TIMER_PHASES);
  for (PetscInt k = 0; k < MPM_TIMER_PHASES; k++) t->seconds[k] = 100 + k;
  for (PetscInt k = MPM_TIMER_PHASES; k < MPM_MAX_TIMERS; k++) {
    (void)snprintf(names[k], sizeof names[k], "PHASE_%d", (int)k);
    for (int again = 0; again < 2; again++) {
      PetscCall(MPMTimersPhase(t, names[k], &timer));
      CHECK_EQ(timer, k);
      CHECK_EQ(t->n, k + 1);
    }
    t->seconds[k] = 100 + k;
    PetscCall(CheckNames(t));
  }
  memcpy(&before, &guarded, sizeof before);
  PetscCall(Quiet());
  code = MPMTimersPhase(t, "TOO_MANY", &timer);
  PetscCall(PetscPopErrorHandler());
  CHECK_EQ(code, PETSC_ERR_PLIB);
  CHECK_SAME(&before, &guarded, sizeof before); /* no other timer, nor what lies beside them, has changed */
  PetscCall(MPMTimersPhase(t, names[MPM_MAX_TIMERS - 1], &timer)); /* those that there are can still be asked for */
  CHECK_EQ(timer, MPM_MAX_TIMERS - 1);
  for (PetscInt k = 0; k < MPM_MAX_TIMERS; k++)
    if (k != MPM_TIMER_OTHER) CHECK_EQ(MPMTimersSeconds(t, k), 100 + k);
  PetscCall(CheckNames(t));
  PetscCall(MPMTimersDestroy(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Works for some 20 to 200 microseconds. */
static void Work(void)
{
  struct timespec from, to;
  const long      wanted = 20000 + UnitInt(180000);
  volatile double x      = 1;

  (void)clock_gettime(CLOCK_MONOTONIC, &from);
  do {
    for (int k = 0; k < 100; k++) x = x * 1.0000001 + 1e-9;
    (void)clock_gettime(CLOCK_MONOTONIC, &to);
  } while ((to.tv_sec - from.tv_sec) * 1000000000L + to.tv_nsec - from.tv_nsec < wanted);
}

/* What a timer must have at least, and at most: the clock is read just inside and just outside of its interval. */
static double least[MPM_MAX_TIMERS], most[MPM_MAX_TIMERS];

/* A part with parts in it, `depth` more at most. Its bounds less those of the parts inside are added to its timer's.
   *in, *out: its interval, read inside and outside. */
static PetscErrorCode Part(MPMTimers *t, int depth, double *in, double *out)
{
  const PetscInt any = UnitInt((int)t->n), mine = any == MPM_TIMER_OTHER ? MPM_TIMER_SETTLE : any, open = t->nopen;
  const int      parts  = depth ? UnitInt(4) : 0;
  double         inside = 0, outside = 0;
  PetscLogDouble a, b, c, d;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersClock(t, &a));
  PetscCall(MPMTimersBegin(t, mine));
  PetscCall(MPMTimersClock(t, &b));
  CHECK_EQ(t->nopen, open + 1);
  Work();
  for (int k = 0; k < parts; k++) {
    double i = 0, o = 0;

    PetscCall(Part(t, depth - 1, &i, &o));
    inside += i;
    outside += o;
    if (UnitInt(2)) Work();
  }
  PetscCall(MPMTimersClock(t, &c));
  PetscCall(MPMTimersEnd(t, mine));
  PetscCall(MPMTimersClock(t, &d));
  CHECK_EQ(t->nopen, open);
  *in  = c - b;
  *out = d - a;
  least[mine] += *in - outside;
  most[mine] += *out - inside;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rounds of nested parts: each timer has its own time, all together that of the outer parts, `other` the rest. */
static PetscErrorCode Nesting(PetscBool processor)
{
  const double rounding = 1e-9; /* s: the clock counts from long ago */
  MPMTimers    t        = {.processor = processor};
  double       in = 0, out = 0, sum = 0;
  PetscInt     timer;

  PetscFunctionBeginUser;
  UnitContext("nested parts, %s clock", processor ? "the processor's" : "the wall");
  memset(least, 0, sizeof least);
  memset(most, 0, sizeof most);
  PetscCall(MPMTimersCreate(&t));
  PetscCall(MPMTimersPhase(&t, "P2G", &timer));
  PetscCall(MPMTimersPhase(&t, "G2P", &timer));
  for (int round = 0; round < 60; round++) {
    double         i = 0, o = 0;
    PetscLogDouble from, to;

    PetscCall(MPMTimersClock(&t, &from));
    PetscCall(Part(&t, MPM_MAX_OPEN - 1, &i, &o));
    Work(); /* belongs to no part */
    PetscCall(MPMTimersClock(&t, &to));
    in += i;
    out += o;
    t.steps += to - from;
  }
  for (PetscInt k = 0; k < t.n; k++) {
    if (k == MPM_TIMER_OTHER) continue;
    UnitContext("nested parts, %s clock, timer %s", processor ? "the processor's" : "the wall", t.name[k]);
    CHECK_GE(MPMTimersSeconds(&t, k), least[k] - rounding);
    CHECK_LE(MPMTimersSeconds(&t, k), most[k] + rounding);
    CHECK(MPMTimersSeconds(&t, k) > 0);
    sum += MPMTimersSeconds(&t, k);
  }
  CHECK_GE(sum, in - rounding);
  CHECK_LE(sum, out + rounding);
  CHECK_NEAR(sum + MPMTimersSeconds(&t, MPM_TIMER_OTHER), t.steps, rounding);
  CHECK_GE(MPMTimersSeconds(&t, MPM_TIMER_OTHER), 60 * 15e-6); /* 60 times 20 us and more, all outside of parts */
  CHECK_EQ(t.seconds[MPM_TIMER_OTHER], 0);
  PetscCall(MPMTimersDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Parts that do not close in turn, and too many open ones, are refused and change nothing. */
static PetscErrorCode Misuse(void)
{
  MPMTimers      t = {.n = 0}, before;
  PetscErrorCode code;

  PetscFunctionBeginUser;
  UnitContext("misuse");
  PetscCall(MPMTimersCreate(&t));
  PetscCall(Quiet());
  memcpy(&before, &t, sizeof t);
  code = MPMTimersEnd(&t, MPM_TIMER_SORT); /* nothing is open */
  CHECK_EQ(code, PETSC_ERR_PLIB);
  CHECK_SAME(&before, &t, sizeof t);
  for (PetscInt k = 0; k < MPM_MAX_OPEN; k++) PetscCall(MPMTimersBegin(&t, k));
  memcpy(&before, &t, sizeof t);
  code = MPMTimersBegin(&t, MPM_TIMER_SORT);
  CHECK_EQ(code, PETSC_ERR_PLIB);
  CHECK_SAME(&before, &t, sizeof t);
  code = MPMTimersEnd(&t, MPM_MAX_OPEN - 2); /* not the innermost */
  CHECK_EQ(code, PETSC_ERR_PLIB);
  CHECK_SAME(&before, &t, sizeof t);
  for (PetscInt k = MPM_MAX_OPEN; k-- > 0;) PetscCall(MPMTimersEnd(&t, k));
  CHECK_EQ(t.nopen, 0);
  PetscCall(PetscPopErrorHandler());
  PetscCall(MPMTimersDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rows of -report_path: one a step, however many, each with the work of its step; of the pool's workers one. */
static PetscErrorCode WorkRows(PetscBool one_row)
{
  const int steps = 1000;
  MPMTimers t     = {.n = 0};

  PetscFunctionBeginUser;
  UnitContext("rows of work%s", one_row ? ", one" : "");
  PetscCall(MPMTimersCreate(&t));
  PetscCall(MPMWorkStep(&t, one_row)); /* not on: no rows */
  CHECK(t.work.seconds == NULL);
  t.work.on = PETSC_TRUE;
  for (int step = 0; step < steps; step++) {
    PetscCall(MPMWorkStep(&t, one_row));
    CHECK_EQ(t.work.row, one_row ? 0 : step);
    CHECK(t.work.row < t.work.capacity);
    if (!one_row)
      for (int k = 0; k < MPM_MAX_TIMERS; k++) CHECK_EQ(t.work.seconds[t.work.row * MPM_MAX_TIMERS + k], 0);
    t.work.seconds[t.work.row * MPM_MAX_TIMERS + MPM_MAX_TIMERS - 1] += step + 1;
    t.work.seconds[t.work.row * MPM_MAX_TIMERS] += 1;
    MPMWorkBegin(&t);
    if (step % 100 == 0) Work();
    MPMWorkEnd(&t, MPM_TIMER_SORT, NULL, 0);
  }
  for (int step = 0; step < steps && !one_row; step++) {
    CHECK_EQ(t.work.seconds[step * MPM_MAX_TIMERS], 1);
    CHECK_EQ(t.work.seconds[step * MPM_MAX_TIMERS + MPM_MAX_TIMERS - 1], step + 1);
    CHECK_GE(t.work.seconds[step * MPM_MAX_TIMERS + MPM_TIMER_SORT], 0);
    if (step % 100 == 0) CHECK(t.work.seconds[step * MPM_MAX_TIMERS + MPM_TIMER_SORT] > 0);
  }
  if (one_row) CHECK_EQ(t.work.seconds[MPM_MAX_TIMERS - 1], steps * (steps + 1) / 2);
  PetscCall(MPMTimersDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  for (const MPMScheme *scheme = MPMSchemes; scheme->name; scheme++)
    for (const MPMTransfer *transfer = MPMTransfers; transfer->name; transfer++)
      for (PetscInt order = transfer->rounds ? 1 : 0; order <= (transfer->rounds ? MPM_MAX_XPIC : 0); order++)
        PetscCall(CheckMethod(scheme, transfer, order));
  PetscCall(Capacity());
  for (int processor = 0; processor < 2; processor++) PetscCall(Nesting(processor ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(Misuse());
  PetscCall(WorkRows(PETSC_FALSE));
  PetscCall(WorkRows(PETSC_TRUE));
  PetscCall(PetscFinalize());
  return UnitEnd();
}
