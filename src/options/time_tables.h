/* time_tables.h - tables over time in formulas. */
#ifndef MPM_TIME_TABLES_H
#define MPM_TIME_TABLES_H

#include "options/reader.h"

/* A table: its lines, sorted by time, s. */
typedef struct {
  PetscInt   n;
  PetscReal *t, *value; /* [n] */
} MPMTable;

/* Reads the tables of a formula, the value `text` of the option `full`: plain is the formula with a variable _table<k>
   in the place of each. error [len]: what is wrong, or "". The caller destroys the tables. Not collective. */
PetscErrorCode MPMTablesRead(const char full[], const char text[], char plain[MPM_TEXT_LEN], PetscInt *n,
                             MPMTable **tables, char error[], size_t len);
PetscReal      MPMTableValue(const MPMTable *, PetscReal t);
PetscErrorCode MPMTablesDestroy(PetscInt n, MPMTable **tables);

#endif
