/* study_work.h - the work-precision study: the settings of methods that it compares, its table of runs, and what it
   makes of them. */
#ifndef MPM_STUDY_WORK_H
#define MPM_STUDY_WORK_H

#include "run/study.h"

/* A setting of a method: what is replaced in the scene besides its grid. The last of a study is the scene's own, in
   which nothing is replaced. */
typedef struct {
  PetscBool   own;
  char        name[2 * MPM_NAME_LEN]; /* in messages */
  const char *preset;                 /* value of -method_preset, which sets all of the rest; or "" */
  const char *basis, *update;         /* words of the lists; "" where own */
  char        transfer[MPM_NAME_LEN], number[MPM_NAME_LEN]; /* number: -method_flip or -method_order; "" the default */
  PetscInt    ppc;                                          /* 0: the scene's */
  PetscReal   cfl;                                          /* 0: the scene's */
} MPMSetting;

/* study_settings.c: makes the settings of the lists, without those that the program refuses or warns of, for each of
   which it prints a line; the caller frees them. MPMSettingApply replaces the options of a run: a setting on grid
   `level`; it is not collective, the others are collective on base->core.comm. */
PetscErrorCode MPMSettingsCreate(MPM base, PetscInt *n, MPMSetting **settings);
PetscErrorCode MPMSettingApply(MPMChanges *, MPM base, const MPMSetting *, PetscInt level);
/* Writes the options by which a user repeats a run of this result; digits that name a run: its options, this program's
   version, the processes, and `with`. */
PetscErrorCode MPMSettingOptions(MPM base, const MPMSetting *, const MPMStudyResult *, char text[MPM_TEXT_LEN]);
PetscErrorCode MPMSettingKey(MPM base, const MPMSetting *, PetscInt level, const char with[], char key[17]);

/* A row of the table: a run. Numbers are NaN where there is none. */
typedef struct {
  const MPMSetting *setting; /* NULL: a row of the file that this study does not make */
  PetscInt          level;
  PetscBool         done; /* it has been run as often as wanted, now or before */
  char              study[16], basis[MPM_NAME_LEN], gimp_update[MPM_NAME_LEN], update[MPM_NAME_LEN];
  char              transfer[MPM_NAME_LEN], cells[MPM_NAME_LEN], status[16], key[17], note[MPM_TEXT_LEN / 4];
  double            flip, strain, rate, order, ppc, cfl, h, particles,
      steps;                            /* cfl: -dt_cfl, or dt if -dt_size is fixed: then NaN */
  double seconds, least, most, repeats; /* s of the steps: mean, least, most of so many runs */
  double ns, memory, error, front;      /* ns a particle and step; MiB; part of the solution's size; 1 or 0 */
} MPMWorkRow;

/* The table of a study. floor: errors below it say nothing, since the references differ by that much. */
typedef struct {
  PetscInt    n, capacity, nsettings;
  MPMWorkRow *row;
  MPMSetting *setting; /* [nsettings] */
  PetscReal   floor;
  char        path[2 * MPM_TEXT_LEN];
} MPMWorkTable;

/* study_table.c: the file. Rows that it has and the study has not are kept in it as "other". Not collective. */
PetscErrorCode MPMWorkAdd(MPMWorkTable *, MPMWorkRow **);
PetscErrorCode MPMWorkRead(MPMWorkTable *, char fault[MPM_TEXT_LEN]);
PetscErrorCode MPMWorkWrite(const MPMWorkTable *, char fault[MPM_TEXT_LEN]);
void           MPMWorkPut(MPMWorkRow *, const MPMStudyResult *);
PetscErrorCode MPMWorkDestroy(MPMWorkTable *);

/* study_front.c. MPMFrontMark marks the rows that no other beats in both time and error; MPMFrontTime returns the
   seconds that a setting takes to reach an error, between two of its grids by their logarithms, -1: it does not; and
   the largest part by which repeats differ there. MPMFrontReport prints the table, the front and the cheapest settings;
   collective on base->core.comm. */
void           MPMFrontMark(MPMWorkTable *);
PetscReal      MPMFrontTime(const MPMWorkTable *, const MPMSetting *, PetscReal error, PetscReal *spread);
PetscErrorCode MPMFrontReport(MPM base, MPMWorkTable *);

PetscErrorCode MPMStudyWorkPrecision(MPM base, int *status);

#endif
