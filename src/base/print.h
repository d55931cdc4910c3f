/* print.h - how the program prints: through an MPMPrinter, which has the processes and a switch for silence. */
#ifndef MPM_PRINT_H
#define MPM_PRINT_H

#include "base/base.h"

/* The notes and warnings that were printed, one a line. about: NULL, or what is looked at now: then nothing is printed but
   notes and warnings that were not yet, with this name. */
typedef struct {
  char       *lines;
  size_t      n;
  const char *about;
} MPMSaid;

typedef struct {
  MPI_Comm    comm;     /* the first of these processes prints */
  PetscBool   quiet;    /* nothing is printed: a run of a calibration */
  PetscBool   progress; /* a line of progress may be on the terminal; MPMSay takes its place */
  MPMSaid    *said;     /* or NULL: it is not kept */
  const char *end;      /* the option that ends a stage, in the place of -time_end; or NULL */
} MPMPrinter;

/* Prints as printf does, on the first process alone. PetscPrintf is not used as it would write 3 as "3.". Not
   collective. */
PetscErrorCode MPMPrint(const MPMPrinter *, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);

/* Prints a line: its label in the margin, and the text, which ends it. Not collective. */
PetscErrorCode MPMSay(const MPMPrinter *, const char label[], const char format[], ...) PETSC_ATTRIBUTE_FORMAT(3, 4);
#define MPMWarn(printer, ...) MPMSay(printer, "warning", __VA_ARGS__)
#define MPMNote(printer, ...) MPMSay(printer, "note", __VA_ARGS__)

/* Puts the option that ends the stage in the place of -time_end in a line [length]. Not collective. */
void MPMPrintEndOf(const MPMPrinter *, char line[], size_t length);

/* Writes a time in s with two digits and the unit that suits it, as in "34 minutes". Not collective. */
void MPMTimeWords(PetscReal seconds, char words[MPM_NAME_LEN]);

/* Writes a place x [dim], m, as in "(1, 2)". Not collective. */
void MPMPlaceWords(PetscInt dim, const PetscReal x[], char words[MPM_NAME_LEN]);

#endif
