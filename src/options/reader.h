/* reader.h - what the files of the reader share: options.c and names.c. */
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

#endif
