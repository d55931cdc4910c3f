/* columns.c - the list of the columns of the history that one asks for (measures.h). */
#include "results/measures.h"

PetscErrorCode MPMMeasuresAdd(MPMMeasures *m, const char a[], const char b[], const char c[], const char unit[],
                              PetscBool whole)
{
  MPMMeasure *column;

  PetscFunctionBeginUser;
  if (m->n % 32 == 0) {
    PetscCall(PetscRealloc((size_t)(m->n + 32) * sizeof *m->column, &m->column));
    PetscCall(PetscRealloc((size_t)(m->n + 32) * sizeof *m->value, &m->value));
  }
  m->value[m->n] = 0;
  column         = &m->column[m->n++];
  (void)snprintf(column->name, sizeof column->name, "%s_%s%s%s", a, b, c[0] ? "_" : "", c);
  column->unit  = unit;
  column->whole = whole;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMMeasuresFind(const MPMMeasures *m, const char name[])
{
  for (PetscInt k = 0; k < m->n; k++)
    if (!strcmp(m->column[k].name, name)) return k;
  return -1;
}
