/* pages.h - pages of memory: large ones, and those that are not used yet. */
#ifndef MPM_PAGES_H
#define MPM_PAGES_H

#include "base/base.h"

void MPMLargePages(void *memory, size_t bytes);
void MPMGivePagesBack(void *memory, size_t bytes);

PetscErrorCode MPMPagesCalloc(size_t bytes, void *memory); /* memory: a pointer's address; free it with PetscFree */

#endif
