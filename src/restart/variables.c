/* variables.c - copies of the variables of a run, before a step that may be undone. */
#include "restart/variables.h"

static size_t Bytes(const MPMVariable *v)
{
  static const size_t size[] = {[MPM_VARIABLE_REAL]  = sizeof(PetscReal),
                                [MPM_VARIABLE_INT]   = sizeof(PetscInt),
                                [MPM_VARIABLE_INT64] = sizeof(PetscInt64),
                                [MPM_VARIABLE_BOOL]  = sizeof(PetscBool),
                                [MPM_VARIABLE_TEXT]  = 1,
                                [MPM_VARIABLE_SUM]   = sizeof(MPMSum),
                                [MPM_VARIABLE_BYTES] = 1};

  return v->at && v->uses & MPM_UNDONE ? (size_t)v->n * size[v->type] : 0;
}

PetscErrorCode MPMVariablesSave(const MPMVariables *v, char **copy)
{
  size_t at = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < v->n; k++) at += Bytes(&v->row[k]);
  PetscCall(PetscMalloc1(at, copy));
  at = 0;
  for (PetscInt k = 0; k < v->n; k++) {
    PetscCall(PetscMemcpy(*copy + at, v->row[k].at, Bytes(&v->row[k])));
    at += Bytes(&v->row[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMVariablesPutBack(const MPMVariables *v, const char copy[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < v->n; k++) {
    PetscCall(PetscMemcpy(v->row[k].at, copy, Bytes(&v->row[k])));
    copy += Bytes(&v->row[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
