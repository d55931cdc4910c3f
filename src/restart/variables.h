/* variables.h - the variables of a run besides its particles: what a checkpoint keeps, and what a step that is undone
   puts back. The table of them is run/state.def. */
#ifndef MPM_VARIABLES_H
#define MPM_VARIABLES_H

#include "base/exact_sum.h"

/* SUM: exact sums, whose parts the processes have; a checkpoint keeps their values. BYTES: a structure, which no
   checkpoint keeps. All others are the same on all processes. */
typedef enum {
  MPM_VARIABLE_REAL,
  MPM_VARIABLE_INT,
  MPM_VARIABLE_INT64,
  MPM_VARIABLE_BOOL,
  MPM_VARIABLE_TEXT,
  MPM_VARIABLE_SUM,
  MPM_VARIABLE_BYTES
} MPMVariableType;

/* What is done with a variable: a checkpoint has it; a step that is undone puts it back. */
enum { MPM_KEPT = 1, MPM_UNDONE = 2 };

/* A variable: n numbers, or n bytes, at `at`. 0 of them: this run does not have it. */
typedef struct {
  const char     *name;
  MPMVariableType type;
  PetscInt        n;
  void           *at;
  int             uses; /* MPM_KEPT, MPM_UNDONE */
} MPMVariable;

/* The table of a run, as its owner fills it in. */
#define MPM_MOST_VARIABLES 96
typedef struct {
  PetscInt    n;
  MPMVariable row[MPM_MOST_VARIABLES];
} MPMVariables;

/* Copy all variables that a step that is undone puts back to memory, which the caller frees, and put them back. Neither
   is collective. */
PetscErrorCode MPMVariablesSave(const MPMVariables *, char **copy);
PetscErrorCode MPMVariablesPutBack(const MPMVariables *, const char copy[]);

#endif
