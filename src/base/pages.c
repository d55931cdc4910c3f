/* pages.c - large pages: the processor looks up the place of each page that a step touches, and finds it sooner among
   pages of 2 MiB than among 512 times as many of 4 KiB. Pages that nothing has been written to need no memory. */
#define _GNU_SOURCE
#include "base/pages.h"
#include <stdint.h>
#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#define COLLAPSE 25 /* MADV_COLLAPSE of Linux 6.1 and later, which C libraries do not name yet */
#endif

/* Asks the system to hold as much of this memory as it can in pages of 2 MiB, with what is in it. If it has none, or
   does not do so for programs that ask, nothing changes. Not collective. */
void MPMLargePages(void *memory, size_t bytes)
{
#if defined(__linux__)
  const uintptr_t page = (uintptr_t)2 << 20, first = ((uintptr_t)memory + page - 1) / page * page,
                  last = ((uintptr_t)memory + bytes) / page * page;

  if (first >= last) return;
  (void)madvise((void *)first, last - first, MADV_HUGEPAGE);
  (void)madvise((void *)first, last - first, COLLAPSE);
#else
  (void)memory;
  (void)bytes;
#endif
}

/* Gives the memory of all pages within these bytes back to the system, until they are written to again; then they begin
   as zero. Where the system cannot do that, their content stays. Not collective. */
void MPMGivePagesBack(void *memory, size_t bytes)
{
#if defined(__linux__)
  const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), first = ((uintptr_t)memory + page - 1) / page * page,
                  last = ((uintptr_t)memory + bytes) / page * page;

  if (first < last) (void)madvise((void *)first, last - first, MADV_DONTNEED);
#else
  (void)memory;
  (void)bytes;
#endif
}

/* Allocates zeroed memory that takes pages only where something is written to it: to memory that was used before, calloc
   writes zeroes everywhere. Not collective. */
PetscErrorCode MPMPagesCalloc(size_t bytes, void *memory)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(bytes, (char **)memory));
  MPMGivePagesBack(*(char **)memory, bytes);
  PetscFunctionReturn(PETSC_SUCCESS);
}
