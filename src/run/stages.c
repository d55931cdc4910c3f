/* stages.c - a run in parts (-stages): each is a run of its own, which goes on from the checkpoint at the end of the one
   before, with the options of its stage. All of them are read before the first step. */
#include <strings.h>
#include "run/mpm.h"

/* What is known of the run in stages. */
typedef struct {
  char     *text; /* the options as given */
  PetscInt  n;
  char      names[MPM_TEXT_LEN];      /* of the stages */
  PetscReal began;                    /* when the present stage begins, s */
  char      checkpoint[MPM_TEXT_LEN]; /* that it goes on from; "": what -restart_file says */
  PetscBool dry;                      /* -dry_run */
  PetscInt  nkeeps, *keeps; /* [stages][nkeeps]: of each, what `keeps` of its run is; nkeeps: materials and one */
  PetscBool read;           /* they are those of all stages */
  MPMStart  start;          /* of the first stage */
  PetscBool stretched;      /* the stage that was read last has domains that stretch */
  MPMSaid   said;
  char      end[2 * MPM_NAME_LEN]; /* the option that ends the stage */
} Stages;

/* Sets name to that of stage k = 1 .. n, and returns how long it lasts, s; all: of all stages. */
static PetscReal TimeOf(const Stages *s, PetscInt k, char name[MPM_NAME_LEN], PetscReal *all)
{
  PetscReal time = 0;
  char      list[MPM_TEXT_LEN], *save = NULL;

  (void)snprintf(list, sizeof list, "%s", s->names);
  *all = 0;
  for (char *word = strtok_r(list, ", ", &save); word; word = strtok_r(NULL, ", ", &save), k--) {
    char option[2 * MPM_NAME_LEN], value[MPM_TEXT_LEN];

    (void)snprintf(option, sizeof option, "-stage_%.100s_time", word);
    (void)MPMOptionsFindIn(s->text, option, value);
    *all += strtod(value, NULL);
    if (k != 1) continue;
    time = strtod(value, NULL);
    (void)snprintf(name, MPM_NAME_LEN, "%.*s", MPM_NAME_LEN - 1, word);
  }
  return time;
}

/* Lets the options be those of stage k. Intervals of output are parts of the time of all stages, where none is given. */
static PetscErrorCode SetOptions(const Stages *s, PetscInt k)
{
  char     *options, name[MPM_NAME_LEN], value[MPM_TEXT_LEN];
  PetscReal all;
  const struct {
    const char *name;
    PetscReal   value;
  } times[] = {
      {"-time_end", s->began + TimeOf(s, k, name, &all)}, {"-output_every", all / 20}, {"-history_every", all / 100}};

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsOverlayEnd());
  PetscCall(MPMStagesOptions(s->text, k, &options));
  PetscCall(MPMStagesOverlay(s->text, options));
  for (size_t j = 0; j < sizeof times / sizeof times[0]; j++) {
    char given[MPM_TEXT_LEN];

    (void)snprintf(value, sizeof value, "%.15g",
                   (double)PetscMax(0, times[j].value)); /* as one would write it: 0.3, not 0.1 + 0.2 */
    if (!j || (j && all > 0 && !MPMOptionsFindIn(options, times[j].name, given) &&
               !(j == 1 && MPMOptionsFindIn(options, "-output_format", given) && !strcasecmp(given, "none"))))
      PetscCall(MPMOptionsOverlay(times[j].name, value));
  }
  if (s->checkpoint[0]) PetscCall(MPMOptionsOverlay("-restart_file", s->checkpoint));
  PetscCall(PetscFree(options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes an empty run of stage k. */
static PetscErrorCode Make(Stages *s, PetscInt k, MPM *mpm, MPMOptions *o)
{
  char      name[MPM_NAME_LEN];
  PetscReal end = s->began, all;

  PetscFunctionBeginUser;
  for (PetscInt j = k; j <= s->n; j++) end += TimeOf(s, j, name, &all);
  PetscCall(MPMCreate(PETSC_COMM_WORLD, mpm));
  PetscCall(MPMOptionsCreate(&MPMOptionTable, o));
  (void)TimeOf(s, k, name, &all);
  (void)snprintf(s->end, sizeof s->end, "-stage_%s_time", name);
  (*mpm)->core.print.said = &s->said;
  (*mpm)->core.print.end  = s->end;
  (*mpm)->core.stages     = (MPMStages){k, s->n, s->began, end};
  (*mpm)->keeps           = s->read ? s->keeps + (k - 1) * s->nkeeps : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets stage k > 1 know what it would know of the one before from a checkpoint. */
static PetscErrorCode Follow(const Stages *s, PetscInt k, MPM mpm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMStagesOptions(s->text, k - 1, &mpm->checkpoint.options));
  mpm->checkpoint.start = s->start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the fault of a stage; the first one is without a name where the fault is of an option as it was given. */
static PetscErrorCode Tell(const Stages *s, PetscInt k, MPMOptions o)
{
  const MPMPrinter printer = {.end = s->end};
  char             error[2 * MPM_TEXT_LEN], name[MPM_NAME_LEN] = "", option[MPM_TEXT_LEN], value[MPM_TEXT_LEN];
  PetscReal        all;

  PetscFunctionBeginUser;
  (void)TimeOf(s, k, name, &all);
  (void)snprintf(error, sizeof error, "%s", MPMOptionsError(o));
  if (!strstr(error, "-time_end does not apply")) MPMPrintEndOf(&printer, error, sizeof error);
  (void)snprintf(option, sizeof option, "-stage_%s_%.*s", name, (int)strcspn(error, " :"), error + 1);
  option[strcspn(option, " :")] = 0;
  if (error[0] == '-' && MPMOptionsFindIn(s->text, option, value)) k = 2; /* the stage gives it */
  PetscCall(PetscFPrintf(PETSC_COMM_WORLD, stderr, k > 1 ? "stage %s: %s\n" : "%s%s\n", k > 1 ? name : "", error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the fault of the options of a stage: that one of them may not change there comes before what follows from it. */
static PetscErrorCode Blame(const Stages *s, PetscInt k, MPMOptions o)
{
  char why[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMStagesForbidden(s->text, s->names, k, o, why));
  PetscCall(why[0] ? PetscFPrintf(PETSC_COMM_WORLD, stderr, "%s\n", why) : Tell(s, k, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes what stage k, which has been read, needs of its particles; refuses what they could not have. */
static PetscErrorCode NoteNeeds(Stages *s, PetscInt k, MPM mpm, MPMOptions o)
{
  const MPMScene *scene = &mpm->scene;
  PetscBool       flows = PETSC_FALSE;
  PetscInt       *keeps;

  PetscFunctionBeginUser;
  if (k > 1 && mpm->core.needs.stretched && !s->stretched)
    MPMOptionsFail(
        o, "-method_basis gimp begins in this stage, and its domains, which stretch with elastic matter, have to do "
           "so from the start; give -method_basis gimp for all stages, or another basis here");
  s->stretched = mpm->core.needs.stretched;
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMSetNeeds(mpm));
  s->nkeeps = scene->nmaterials + 1;
  if (!s->keeps) PetscCall(PetscCalloc1(s->n * s->nkeeps, &s->keeps));
  keeps = s->keeps + (k - 1) * s->nkeeps;
  for (PetscInt m = 0; m < scene->nmaterials; m++) keeps[m] = scene->materials[m].state;
  for (PetscInt b = 0; b < scene->nfilled; b++) flows = flows || scene->bodies[b].source.on;
  if (flows && mpm->core.needs.rim) keeps[s->nkeeps - 1] |= MPM_BIT(rim);
  if (flows && mpm->core.needs.start) keeps[s->nkeeps - 1] |= MPM_BIT(X);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets each stage keep what a later one needs; and F if any does, since J takes its place where it is not kept. */
static void KeepForLater(Stages *s)
{
  for (PetscInt m = 0; m < s->nkeeps; m++) {
    PetscInt all = 0, later = 0;

    for (PetscInt k = 0; k < s->n; k++) all |= s->keeps[k * s->nkeeps + m] & MPM_BIT(F);
    for (PetscInt k = s->n - 1; k >= 0; k--) {
      const PetscInt needs = s->keeps[k * s->nkeeps + m];

      s->keeps[k * s->nkeeps + m] = later | all;
      later |= needs;
    }
  }
  s->read = PETSC_TRUE;
}

/* Reads the options of all stages, without what a checkpoint says and without the constants of the model, whose file a
   calibration makes. */
static PetscErrorCode ReadAll(Stages *s, PetscBool *good)
{
  char      name[MPM_NAME_LEN], checkpoint[MPM_TEXT_LEN];
  PetscReal all;

  PetscFunctionBeginUser;
  *good = PETSC_TRUE;
  (void)snprintf(checkpoint, sizeof checkpoint, "%s", s->checkpoint);
  for (PetscInt k = 1; k <= s->n && *good; k++) {
    MPM        mpm;
    MPMOptions o;

    PetscCall(SetOptions(s, k));
    PetscCall(MPMOptionsOverlay("-restart_file", NULL));
    PetscCall(MPMOptionsOverlay("-model_file", NULL));
    PetscCall(Make(s, k, &mpm, &o));
    if (k > 1) PetscCall(Follow(s, k, mpm));
    PetscCall(MPMReadOptions(mpm, o));
    if (k == 1) s->start = mpm->scene.start;
    if (!MPMOptionsError(o)) PetscCall(NoteNeeds(s, k, mpm, o));
    *good = !MPMOptionsError(o);
    if (!*good) PetscCall(Blame(s, k, o));
    s->began += TimeOf(s, k, name, &all);
    PetscCall(MPMOptionsDestroy(&o));
    PetscCall(MPMDestroy(&mpm));
  }
  s->began = 0;
  if (*good) KeepForLater(s);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes stage k, or finds in *k which one the checkpoint is of, if it is another. *ended: it has come to its end. */
static PetscErrorCode One(Stages *s, PetscInt                    *k, PetscErrorCode (*read)(MPM, MPMOptions),
                          PetscErrorCode (*run)(MPM, int *), int *status, PetscBool *ended)
{
  MPM        mpm;
  MPMOptions o;

  PetscFunctionBeginUser;
  *ended = PETSC_FALSE;
  PetscCall(SetOptions(s, *k));
  PetscCall(Make(s, *k, &mpm, &o));
  mpm->checkpoint.follows = s->checkpoint[0] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(read(mpm, o));
  if (mpm->checkpoint.other) {
    *k       = mpm->checkpoint.stage;
    s->began = mpm->checkpoint.began;
  } else if (MPMOptionsError(o)) {
    PetscCall(Tell(s, *k, o));
    *status = MPM_EXIT_INPUT;
  } else {
    PetscCall(run(mpm, status));
    s->dry = mpm->scene.dry_run;
    *ended = !mpm->scene.dry_run && !mpm->core.stop[0] && MPMEnds(mpm);
    PetscCallMPI(MPI_Bcast(ended, 1, MPM_MPI_BOOL, 0, PETSC_COMM_WORLD)); /* workers of a pool know nothing of it */
    s->began = mpm->core.t;
    (void)snprintf(s->checkpoint, sizeof s->checkpoint, "%s",
                   mpm->checkpoint.path[0] ? mpm->checkpoint.path : mpm->checkpoint.from);
    PetscCallMPI(MPI_Bcast(&s->began, 1, MPIU_REAL, 0, PETSC_COMM_WORLD));
    PetscCallMPI(MPI_Bcast(s->checkpoint, sizeof s->checkpoint, MPI_CHAR, 0, PETSC_COMM_WORLD));
    if (*ended) ++*k;
  }
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells what is doubtful in the options of a later stage of a dry run and was not yet, by the particles of the start. What is
   refused there is left to the run: it may suit the state in which the stage begins. */
static PetscErrorCode Look(Stages *s, PetscInt stage)
{
  MPM        mpm;
  MPMOptions o;
  PetscReal  all;
  char       name[MPM_NAME_LEN], about[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  s->checkpoint[0] = 0;
  s->began         = 0;
  for (PetscInt k = 1; k < stage; k++) s->began += TimeOf(s, k, name, &all);
  (void)TimeOf(s, stage, name, &all);
  (void)snprintf(about, sizeof about, "stage %s", name);
  s->said.about = about;
  PetscCall(SetOptions(s, stage));
  PetscCall(Make(s, stage, &mpm, &o));
  PetscCall(Follow(s, stage, mpm));
  PetscCall(MPMSetFromOptions(mpm, o));
  if (!MPMOptionsError(o)) {
    PetscCall(MPMNotes(&mpm->core, &mpm->scene, &mpm->monitor, &mpm->output, &mpm->report));
    PetscCall(MPMSetUp(mpm));
  }
  if (!MPMOptionsError(o) && !mpm->core.stop[0]) PetscCall(MPMRun(mpm));
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStagesRun(PetscErrorCode (*read)(MPM, MPMOptions), PetscErrorCode (*run)(MPM, int *), int *status)
{
  Stages    s     = {0};
  PetscInt  k     = 1;
  PetscBool ended = PETSC_TRUE, good;
  char      list[MPM_TEXT_LEN], *save = NULL;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsText(&s.text));
  (void)MPMOptionsFindIn(s.text, "-stages", s.names);
  (void)snprintf(list, sizeof list, "%s", s.names);
  for (char *word = strtok_r(list, ", ", &save); word; word = strtok_r(NULL, ", ", &save)) s.n++;
  PetscCall(ReadAll(&s, &good));
  if (!good) *status = MPM_EXIT_INPUT;
  while (good && k <= s.n && *status == MPM_EXIT_OK) {
    const PetscInt was = k;

    PetscCall(One(&s, &k, read, run, status, &ended));
    if (k == was) break; /* it stopped, or was not to run */
  }
  for (k = 2; s.dry && good && *status == MPM_EXIT_OK && k <= s.n; k++) PetscCall(Look(&s, k));
  PetscCall(PetscFree(s.keeps));
  PetscCall(PetscFree(s.said.lines));
  PetscCall(MPMOptionsOverlayEnd());
  PetscCall(PetscFree(s.text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
