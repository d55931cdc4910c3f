/* pages.h - large pages of memory. */
#ifndef MPM_PAGES_H
#define MPM_PAGES_H

#include <stddef.h>

void MPMLargePages(void *memory, size_t bytes);

#endif
