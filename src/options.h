/* options.h - shared by options*.c: the vocabulary as a table, and what is asked of it. */
#ifndef MPM_OPTIONS_H
#define MPM_OPTIONS_H

#include "mpm.h"

#define MPM_FULL_LEN (2 * MPM_NAME_LEN) /* of a name of the vocabulary with a material or body put in */

typedef enum {
  MPM_REAL,
  MPM_INT,
  MPM_BOOL,
  MPM_ENUM,
  MPM_TEXT,
  MPM_REALS,
  MPM_INTS,
  MPM_NAMES,
  MPM_LATER
} MPMOptionType;

/* A row of options.def. A group has no name; its help is its title. */
typedef struct {
  const char   *name;
  MPMOptionType type;
  const char   *allowed, *unit, *fallback, *help;
} MPMOptionRow;

extern const MPMOptionRow MPMOptionTable[];
extern const size_t       MPMOptionTableSize;

struct _MPMOptions {
  char     error[MPM_TEXT_LEN];
  PetscInt dim, nm, nb, nl; /* as declared; nm = nb = nl = 0 before */
  char (*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN], (*loads)[MPM_NAME_LEN];
  PetscInt nasked, masked; /* full names that were asked for: number and space */
  char (*asked)[MPM_FULL_LEN];
};

void MPMOptionsFullName(const char row[], const char name[], char full[MPM_FULL_LEN]);

/* What main does before MPI and PETSc start. MPMOptionsStart answers -help, -version and faults in the arguments and in
   the files they name: true if the program ends here, with that status. MPMOptionsStartFault is an error handler: one
   line for the rest that PETSc would answer with a stack of calls, until MPMOptionsStarted.                          */
PetscBool      MPMOptionsStart(int argc, char **argv, int *status);
PetscErrorCode MPMOptionsStartFault(MPI_Comm, int, const char *, const char *, PetscErrorCode, PetscErrorType,
                                    const char *, void *);
void           MPMOptionsStarted(void);

#endif
