/* base.h - what every file of Pebble stands on: PETSc's basic types, inlining, lengths of texts, exit statuses. */
#ifndef MPM_BASE_H
#define MPM_BASE_H

#include <petscsys.h>
#include <stdint.h>
#include <string.h>

#if PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS ((PetscErrorCode)0)
#endif
#if !defined(PETSC_USE_REAL_DOUBLE) || defined(PETSC_USE_COMPLEX)
#error "Pebble needs a PETSc with real scalars in double precision"
#endif

#define MPM_INLINE                                                                                                     \
  static inline __attribute__((always_inline, unused)) /* unused: a file takes what it needs of a header */

#define MPM_VERSION  "0.1.0"
#define MPM_NAME_LEN 64   /* characters of a name, its end included */
#define MPM_TEXT_LEN 2048 /* characters of a text */
#define MPM_LINE     64   /* bytes of a line of the cache */

/* Exit statuses of the program. */
enum { MPM_EXIT_OK = 0, MPM_EXIT_INPUT = 2, MPM_EXIT_STOPPED = 3 };

/* Does a list of words, separated by blanks, hold this one? */
MPM_INLINE PetscBool MPMListHas(const char list[], const char word[])
{
  const size_t n = strlen(word);

  for (const char *at = strstr(list, word); at; at = strstr(at + 1, word))
    if ((at == list || at[-1] == ' ') && (at[n] == 0 || at[n] == ' ')) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The next address that begins a line of the cache, so that the record of a node lies in one. */
MPM_INLINE void *MPMAlign(void *memory)
{
  return (void *)(((uintptr_t)memory + MPM_LINE - 1) / MPM_LINE * MPM_LINE);
}

/* Provenance, in version.c: commit, compiler and flags of this build. */
extern const char MPMVersionGit[], MPMVersionCompiler[], MPMVersionFlags[];

#endif
