/* expression.c - values as expressions of coordinates, pi and the usual functions, by muParser (its C interface); the
   components are separated by commas.                                                                                */
#include <muParserDLL.h>
#include "mpm.h"

struct _MPMExpression {
  muParserHandle_t parser;
  PetscReal        var[4]; /* x y z t */
};

/* Parses text, in which the names in `variables` (of "xyzt") may stand. A fault is described in error, else error is
   "" and n is the number of components. Not collective.                                                              */
PetscErrorCode MPMExpressionCreate(const char text[], const char variables[], MPMExpression *e, PetscInt *n,
                                   char error[], size_t len)
{
  int count = 0;

  PetscFunctionBeginUser;
  error[0] = 0;
  *n       = 0;
  PetscCall(PetscNew(e));
  (*e)->parser = mupCreate(muBASETYPE_FLOAT);
  PetscCheck((*e)->parser, PETSC_COMM_SELF, PETSC_ERR_LIB, "muParser has no parser left");
  for (const char *v = variables; *v; v++) {
    const char name[2] = {*v, 0};

    (*e)->var[*v == 't' ? 3 : *v - 'x'] = 0.5; /* any value: the first evaluation only checks the syntax */
    mupDefineVar((*e)->parser, name, &(*e)->var[*v == 't' ? 3 : *v - 'x']);
  }
  mupDefineConst((*e)->parser, "pi", PETSC_PI);
  mupSetExpr((*e)->parser, text);
  (void)mupEvalMulti((*e)->parser, &count);
  *n = count;
  if (mupError((*e)->parser)) {
    const PetscInt at = (PetscInt)mupGetErrorPos((*e)->parser);

    (void)snprintf(error, len, "%s (at position %" PetscInt_FMT ")", mupGetErrorMsg((*e)->parser),
                   at >= 0 && at <= (PetscInt)strlen(text) ? at + 1 : (PetscInt)strlen(text) + 1);
    mupErrorReset((*e)->parser);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The components at position x [dim] in m and time t in s. Not collective. */
PetscErrorCode MPMExpressionEvaluate(MPMExpression e, PetscInt dim, const PetscReal x[], PetscReal t, PetscReal value[])
{
  int              n;
  const muFloat_t *v;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) e->var[d] = d < dim ? x[d] : 0;
  e->var[3] = t;
  v         = mupEvalMulti(e->parser, &n);
  PetscCheck(!mupError(e->parser), PETSC_COMM_SELF, PETSC_ERR_LIB, "muParser: %s", mupGetErrorMsg(e->parser));
  for (int k = 0; k < n; k++) value[k] = v[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExpressionDestroy(MPMExpression *e)
{
  PetscFunctionBeginUser;
  if (!*e) PetscFunctionReturn(PETSC_SUCCESS);
  mupRelease((*e)->parser);
  PetscCall(PetscFree(*e));
  PetscFunctionReturn(PETSC_SUCCESS);
}
