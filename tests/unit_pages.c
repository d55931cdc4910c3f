/* unit_pages.c - zeroed memory takes pages only where something is written, also where memory was used before. */
#define _GNU_SOURCE
#include "base/pages.h"
#include "unit.h"
#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>

/* Returns how many of the whole pages of this memory are there. */
static int PagesThere(const char *memory, size_t bytes)
{
  const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), first = ((uintptr_t)memory + page - 1) / page * page;
  const size_t    n = ((uintptr_t)memory + bytes - first) / page;
  unsigned char   there[64];
  int             sum = 0;

  CHECK_LE(n, sizeof there);
  CHECK(!mincore((void *)first, n * page, there));
  for (size_t k = 0; k < n; k++) sum += there[k] & 1;
  return sum;
}
#endif

int main(int argc, char **argv)
{
  enum { BYTES = 100000, TIMES = 20 };
  char *used[TIMES], *memory;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  for (int k = 0; k < TIMES; k++) {
    if (PetscMalloc1(BYTES, &used[k])) return 1;
    memset(used[k], 1, BYTES);
  }
  for (int k = 0; k < TIMES; k++) (void)PetscFree(used[k]);
  CHECK(!MPMPagesCalloc(BYTES, &memory));
#if defined(__linux__)
  CHECK_EQ(PagesThere(memory, BYTES), 0);
  memory[BYTES / 2] = 1;
  CHECK_EQ(PagesThere(memory, BYTES), 1);
#endif
  memory[BYTES / 2] = 0;
  for (int k = 0; k < BYTES; k++) CHECK_EQ(memory[k], 0);
  (void)PetscFree(memory);
  (void)PetscFinalize();
  return UnitEnd();
}
