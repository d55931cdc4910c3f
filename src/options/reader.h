/* reader.h - declarations that only the files of the reader need. */
#ifndef MPM_READER_H
#define MPM_READER_H

#include "options/options.h"

#define MPM_FULL_LEN (2 * MPM_NAME_LEN) /* longest name of the vocabulary with a name of the scene in it */

struct _MPMOptions {
  const MPMVocabulary *table;
  char                 error[MPM_TEXT_LEN];
  PetscInt             dim, nm, nb, nl; /* of the declarations; nm = nb = nl = 0 before these */
  char (*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN], (*loads)[MPM_NAME_LEN];
  PetscInt nasked, masked; /* full names that were asked for: number and capacity */
  char (*asked)[MPM_FULL_LEN];
};

void MPMOptionsFullName(const char row[], const char name[], char full[MPM_FULL_LEN]);

/* Functions for the time before PETSc starts (files.c). MPMOptionsIsOption returns whether PETSc takes a word for an
   option (-1 and -inf are values). MPMOptionsCheckFile checks an options file, which `nesting` others include; error
   gets what is wrong. MPMOptionsYaml is the YAML file that PETSc reads last, or NULL. */
PetscBool          MPMOptionsIsOption(const char word[]);
void               MPMOptionsCheckFile(const char name[], int nesting, char error[], size_t len);
extern const char *MPMOptionsYaml;

#endif
