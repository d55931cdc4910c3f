/* options.h - the strict reader of PETSc's option database: what an option may be is told by a vocabulary, a table of
   rows, which the program hands in (run/options.def).

   The first error sticks, later reads do nothing, so callers check once, at the end (MPMOptionsError). All processes
   read the same. */
#ifndef MPM_OPTIONS_H
#define MPM_OPTIONS_H

#include "base/base.h"
#include "options/expression.h"

typedef enum {
  MPM_REAL,
  MPM_INT,
  MPM_BOOL,
  MPM_ENUM,
  MPM_TEXT,
  MPM_REALS,
  MPM_INTS,
  MPM_NAMES,
  MPM_LATER,
  MPM_MOVED
} MPMOptionType;

/* A row of the vocabulary. A group has no name; its help is its title. */
typedef struct {
  const char   *name;
  MPMOptionType type;
  const char   *allowed, *unit, *fallback, *help;
} MPMOptionRow;
typedef struct {
  size_t              n;
  const MPMOptionRow *row;
} MPMVocabulary;

typedef struct _MPMOptions *MPMOptions;

PetscErrorCode MPMOptionsCreate(const MPMVocabulary *, MPMOptions *);
PetscErrorCode MPMOptionsDestroy(MPMOptions *);
const char    *MPMOptionsError(MPMOptions); /* NULL if there was none */
void           MPMOptionsFail(MPMOptions, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
PetscErrorCode MPMOptionsShare(MPMOptions, MPI_Comm); /* a fault that any process has noted becomes that of all */
PetscErrorCode MPMOptionsDeclare(MPMOptions, PetscInt dim, PetscInt nm, char (*materials)[MPM_NAME_LEN], PetscInt nb,
                                 char (*bodies)[MPM_NAME_LEN], PetscInt nl, char (*loads)[MPM_NAME_LEN]);
PetscBool      MPMOptionsOverridden(const char name[], const char by[]);
PetscErrorCode MPMOptionsFinish(MPMOptions);       /* options that were given but that this scene never asked for */
PetscErrorCode MPMOptionsText(char **text);        /* the option set as given; caller frees */
PetscBool      MPMOptionsAreIn(const char path[]); /* is it one of the options files of this run? */

/* Readers: `row` is a name of the vocabulary, `name` the material, body or face that it is for (or NULL). set may be
   NULL. A value that is not given is the default of the table if that is a value; else it stays as the caller has
   it. */
PetscErrorCode MPMOptionsReal(MPMOptions, const char row[], const char name[], PetscReal *value, PetscBool *set);
PetscErrorCode MPMOptionsInt(MPMOptions, const char row[], const char name[], PetscInt *value, PetscBool *set);
PetscErrorCode MPMOptionsBool(MPMOptions, const char row[], const char name[], PetscBool *value);
PetscErrorCode MPMOptionsEnum(MPMOptions, const char row[], const char name[], char value[MPM_NAME_LEN],
                              PetscBool *set);
PetscErrorCode MPMOptionsReals(MPMOptions, const char row[], const char name[], PetscReal value[3], PetscBool *set);
PetscErrorCode MPMOptionsInts(MPMOptions, const char row[], const char name[], PetscInt value[3], PetscBool *set);
PetscErrorCode MPMOptionsString(MPMOptions, const char row[], const char name[], char value[MPM_TEXT_LEN],
                                PetscBool *set);
PetscErrorCode MPMOptionsNames(MPMOptions, const char row[], PetscInt *n, char (**names)[MPM_NAME_LEN]);
PetscErrorCode MPMOptionsExpression(MPMOptions, const char row[], const char name[], const char variables[],
                                    PetscInt nc, MPMExpression *);

/* Refuses the options among `all` (words separated by blanks) that a choice, which takes `taken`, has no use for. */
PetscErrorCode MPMOptionsRefuseOthers(MPMOptions, const char group[], const char name[], const char what[],
                                      const char choice[], const char all[], const char taken[]);

/* The number of `word` in a list of names of n rows, such as those of a .def file; n: it is none of them. */
PetscInt MPMOptionsFind(const char word[], PetscInt n, const char *const names[]);

/* What main does before MPI and PETSc start. MPMOptionsStart answers -help, -version and faults in the arguments and in
   the files they name: true if the program ends here, with that status. MPMOptionsStartFault is an error handler: one
   line for the rest that PETSc would answer with a stack of calls, until MPMOptionsStarted. */
PetscBool      MPMOptionsStart(const MPMVocabulary *, int argc, char **argv, int *status);
PetscErrorCode MPMOptionsStartFault(MPI_Comm, int, const char *, const char *, PetscErrorCode, PetscErrorType,
                                    const char *, void *);
void           MPMOptionsStarted(void);

#endif
