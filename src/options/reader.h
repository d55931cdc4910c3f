/* reader.h - what the files of the reader share. */
#ifndef MPM_READER_H
#define MPM_READER_H

#include "options/options.h"

#define MPM_FULL_LEN (2 * MPM_NAME_LEN) /* of a name of the vocabulary with a material or body put in */

struct _MPMOptions {
  const MPMVocabulary *table;
  char                 error[MPM_TEXT_LEN];
  PetscInt             dim, nm, nb, nl; /* as declared; nm = nb = nl = 0 before */
  char (*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN], (*loads)[MPM_NAME_LEN];
  PetscInt nasked, masked; /* full names that were asked for: number and space */
  char (*asked)[MPM_FULL_LEN];
};

void MPMOptionsFullName(const char row[], const char name[], char full[MPM_FULL_LEN]);

/* Before PETSc starts (files.c). Is a word an option, as PETSc sees it? -1 and -inf are values. What is wrong with an
   options file, which stands in `nesting` others, goes to error. The YAML file that PETSc reads last, or NULL. */
PetscBool          MPMOptionsIsOption(const char word[]);
void               MPMOptionsCheckFile(const char name[], int nesting, char error[], size_t len);
extern const char *MPMOptionsYaml;

#endif
