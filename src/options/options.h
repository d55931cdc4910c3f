/* options.h - the strict reader of PETSc's option database. A vocabulary, which is a table of rows that the program
   passes in (run/options.def), says what options there are and which values they take.

   The first error is kept and later reads do nothing, so callers check once, at the end (MPMOptionsError). All
   processes read the same options, and no function is collective unless its description says so. */
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

/* A row of the vocabulary: the name of an option, with <m>, <b>, <l>, <c>, <p> or <f> for a material, body, load,
   contact, probe or face; its type; the values that are allowed; unit; default; meaning. A row without a name is the
   title of a group, which is in `help`. */
typedef struct {
  const char   *name;
  MPMOptionType type;
  const char   *allowed, *unit, *fallback, *help;
} MPMOptionRow;

/* A value of the option of a row, such as material_<m>_model, with a text: of a choice that there is, the options that
   it takes, as the ends of their names, separated by blanks; of a word of other programs, what to choose instead. */
typedef struct {
  const char *row, *value, *text;
} MPMOptionValue;

typedef struct {
  size_t              n;
  const MPMOptionRow *row;
  const char (*faces)[MPM_NAME_LEN]; /* [2 dim] names of the faces of a grid */
  /* Words of other programs, separated by blanks, for an option, or for its end after a "_", and what they stand for. */
  size_t naliases;
  const char *const (*aliases)[2]; /* [naliases] */
  size_t                nchoices, nforeign;
  const MPMOptionValue *choices; /* [nchoices] values of models, shapes, types */
  const MPMOptionValue *foreign; /* [nforeign] words of other programs, separated by blanks; row "": in names too */
} MPMVocabulary;

typedef struct _MPMOptions *MPMOptions;

PetscErrorCode MPMOptionsCreate(const MPMVocabulary *, MPMOptions *);
PetscErrorCode MPMOptionsDestroy(MPMOptions *);
const char    *MPMOptionsError(MPMOptions); /* NULL if there was none */
void           MPMOptionsFail(MPMOptions, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
PetscErrorCode MPMOptionsShare(MPMOptions, MPI_Comm); /* an error of any becomes one of all; collective on the comm */
PetscErrorCode MPMOptionsDeclare(MPMOptions, PetscInt dim, PetscInt nm, char (*materials)[MPM_NAME_LEN], PetscInt nb,
                                 char (*bodies)[MPM_NAME_LEN], PetscInt nl, char (*loads)[MPM_NAME_LEN]);
void           MPMOptionsDeclareOthers(MPMOptions, PetscInt np, char (*probes)[MPM_NAME_LEN], PetscInt nc,
                                       char (*contacts)[MPM_NAME_LEN]);                        /* before the others */
void           MPMOptionsDeclareStages(MPMOptions, PetscInt ns, char (*stages)[MPM_NAME_LEN]); /* likewise */

/* Returns the number of the stage among `names` [n] that an option, without its dash, is of, and sets *option to what
   it sets for it, in `given` itself; or returns -1 (stages.c). Not collective. */
PetscInt MPMStageOf(PetscInt n, char (*names)[MPM_NAME_LEN], const char given[], const char **option);

PetscBool      MPMOptionsOverridden(const char name[], const char by[]);
PetscErrorCode MPMOptionsMethodGiven(PetscBool *all, PetscBool *any);

/* Fails if the option is given with another value than `neutral` (NULL: with any): it does not apply with `by`, and
   why. */
PetscErrorCode MPMOptionsRefuse(MPMOptions, const char name[], const char *neutral, const char by[], const char why[]);

/* Returns whether an option, without its dash, is one of PETSc's solvers. Not collective. */
PetscBool           MPMOptionsIsOfSolver(const char name[]);
PetscErrorCode      MPMOptionsFinish(MPMOptions); /* refuses options that this scene never asked for */
const MPMOptionRow *MPMOptionsRow(MPMOptions,
                                  const char name[]);      /* of an option of the program, or NULL: it is PETSc's */
PetscBool           MPMOptionsAreIn(const char path[]);    /* is it an options file of this run? */
void                MPMOptionsNoteFile(const char path[]); /* makes it one; -rerun reads options from other files */

/* Readers: `row` is a name of the vocabulary, `name` the material, body, load or face that it is for, or NULL. *set, if
   not NULL, tells whether the option was given. If it was not, the value becomes the default of the row, or stays as
   the caller has set it where the row has no value but a description. */
PetscErrorCode MPMOptionsReal(MPMOptions, const char row[], const char name[], PetscReal *value, PetscBool *set);
PetscErrorCode MPMOptionsInt(MPMOptions, const char row[], const char name[], PetscInt *value, PetscBool *set);
PetscErrorCode MPMOptionsBool(MPMOptions, const char row[], const char name[], PetscBool *value);
PetscErrorCode MPMOptionsEnum(MPMOptions, const char row[], const char name[], char value[MPM_NAME_LEN],
                              PetscBool *set);
PetscErrorCode MPMOptionsReals(MPMOptions, const char row[], const char name[], PetscReal value[3], PetscBool *set);
PetscErrorCode MPMOptionsInts(MPMOptions, const char row[], const char name[], PetscInt value[3], PetscBool *set);
PetscErrorCode MPMOptionsString(MPMOptions, const char row[], const char name[], char value[MPM_TEXT_LEN],
                                PetscBool *set);
PetscErrorCode MPMOptionsPath(MPMOptions, const char row[], const char name[], char path[MPM_TEXT_LEN], PetscBool *set);
PetscErrorCode MPMOptionsNames(MPMOptions, const char row[], PetscInt *n, char (**names)[MPM_NAME_LEN]);
PetscErrorCode MPMOptionsExpression(MPMOptions, const char row[], const char name[], const char variables[],
                                    PetscInt nc, MPMExpression *);

/* Reads an option whose value is the name of a material or a body, and sets *k to its number among the n that are
   declared, or to n after a fault. names: the first of these names; the others follow at distances of `stride` bytes,
   as in an array of structures. */
PetscErrorCode MPMOptionsDeclared(MPMOptions, const char row[], const char name[], PetscInt n, const char names[],
                                  size_t stride, PetscInt *k);

/* The options of a run as a text (saved.c). */
PetscErrorCode MPMOptionsText(char **text);
PetscBool      MPMOptionsNext(const char **at, char name[4 * MPM_NAME_LEN], char value[MPM_TEXT_LEN]);
PetscBool      MPMOptionsFindIn(const char text[], const char name[], char value[MPM_TEXT_LEN]);

/* Options that have another value for a while (saved.c). */
PetscErrorCode MPMOptionsOverlay(const char name[], const char *value);
PetscErrorCode MPMOptionsOverlayEnd(void);

/* Refuses those options among `all` (words separated by blanks) that a choice does not take; it takes the words
   `taken`. */
PetscErrorCode MPMOptionsRefuseOthers(MPMOptions, const char group[], const char name[], const char what[],
                                      const char choice[], const char all[], const char taken[]);

/* Sets *k to the number of `word` in a list of n names, such as the rows of a .def file, of which it must be one. */
PetscErrorCode MPMOptionsFind(const char word[], PetscInt n, const char *const names[], PetscInt *k);

/* What main does before MPI and PETSc start. MPMOptionsStart answers -help, -version, and faults in the arguments and
   in the files that they name; it returns true if the program shall end with *status. MPMOptionsStartFault is a PETSc
   error handler, which prints one line for faults that PETSc finds while it starts, instead of a stack of calls.
   MPMOptionsStarted ends that. */
PetscBool      MPMOptionsStart(const MPMVocabulary *, int argc, char **argv, int *status);
PetscErrorCode MPMOptionsStartFault(MPI_Comm, int, const char *, const char *, PetscErrorCode, PetscErrorType,
                                    const char *, void *);
void           MPMOptionsStarted(void);

#endif
