/* pages.h - pages of memory: large ones, and those that are not used yet. */
#ifndef MPM_PAGES_H
#define MPM_PAGES_H

#include <stddef.h>

void MPMLargePages(void *memory, size_t bytes);
void MPMGivePagesBack(void *memory, size_t bytes);

#endif
