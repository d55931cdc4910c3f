/* base.h - what every file of Pebble includes: PETSc's basic types, inlining, lengths of texts, exit statuses. */
#ifndef MPM_BASE_H
#define MPM_BASE_H

#include <petscsys.h>
#include <stdint.h>
#include <string.h>

#if PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS ((PetscErrorCode)0)
#endif
#if PETSC_VERSION_GE(3, 24, 0) /* the type of a PetscBool in messages */
#define MPM_MPI_BOOL MPI_C_BOOL
#else
#define MPM_MPI_BOOL MPIU_BOOL
#endif
#if !defined(PETSC_USE_REAL_DOUBLE) || defined(PETSC_USE_COMPLEX)
#error "Pebble needs a PETSc with real scalars in double precision"
#endif

#define MPM_INLINE                                                                                                     \
  static inline __attribute__((always_inline, unused)) /* unused: no file calls all functions of a header */

#define MPM_VERSION  "0.1.0"
#define MPM_NAME_LEN 64   /* characters of a name, the closing 0 included */
#define MPM_TEXT_LEN 2048 /* characters of a text, likewise */
#define MPM_LINE     64   /* bytes of a line of the cache */

/* The exit statuses of the program: it reached its end, its input was wrong, it stopped before its end. */
enum { MPM_EXIT_OK = 0, MPM_EXIT_INPUT = 2, MPM_EXIT_STOPPED = 3 };

/* Returns whether `list`, whose words are separated by blanks, has `word` among them. */
MPM_INLINE PetscBool MPMListHas(const char list[], const char word[])
{
  const size_t n = strlen(word);

  for (const char *at = strstr(list, word); at; at = strstr(at + 1, word))
    if ((at == list || at[-1] == ' ') && (at[n] == 0 || at[n] == ' ')) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Appends to a text of `size` characters, its closing 0 included, what a format says, as far as there is room. */
__attribute__((format(printf, 3, 4))) void MPMAppend(char text[], size_t size, const char format[], ...);

/* Returns the first address from `memory` on at which a line of the cache begins. Records of a node that start there
   lie in one line each. */
MPM_INLINE void *MPMAlign(void *memory)
{
  return (void *)(((uintptr_t)memory + MPM_LINE - 1) / MPM_LINE * MPM_LINE);
}

/* Commit, compiler and flags of this build (version.c); output files carry them. */
extern const char MPMVersionGit[], MPMVersionCompiler[], MPMVersionFlags[];

#endif
