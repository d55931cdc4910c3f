/* expression.c - values as expressions of coordinates, time, pi and the usual functions, by muParser (its C interface);
   the components are separated by commas.                                                                            */
#include <muParserDLL.h>
#include "options/reader.h"

static const char letters[] = "xyzXYZt"; /* where a particle is, where it started, time */

struct _MPMExpression {
  muParserHandle_t parser;
  PetscReal        var[sizeof letters - 1];
};

/* muParser ends most of its messages, but not all, with a position that it counts from 0. Cuts it off. */
static void CutPosition(char message[])
{
  static const char *const ends[] = {" found at position ", " at expression position ", " at position "};

  for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++) {
    char *const at = strstr(message, ends[k]), *const number = at ? at + strlen(ends[k]) : NULL;

    if (at && !number[strspn(number, "0123456789.")]) *at = 0;
  }
}

/* Parses text, in which the letters in `variables` may stand. A fault is described in error, else error is "" and n is
   the number of components. Not collective.                                                                          */
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
    const char       name[2] = {*v, 0};
    PetscReal *const at      = &(*e)->var[strchr(letters, *v) - letters];

    *at = 0.5; /* any value: the first evaluation only checks the syntax */
    mupDefineVar((*e)->parser, name, at);
  }
  mupDefineConst((*e)->parser, "pi", PETSC_PI);
  mupSetExpr((*e)->parser, text);
  (void)mupEvalMulti((*e)->parser, &count);
  *n = count;
  if (mupError((*e)->parser)) {
    const PetscInt at = (PetscInt)mupGetErrorPos((*e)->parser);
    char           message[MPM_TEXT_LEN];

    (void)snprintf(message, sizeof message, "%s", mupGetErrorMsg((*e)->parser));
    CutPosition(message);
    (void)snprintf(error, len, "%.300s (at position %" PetscInt_FMT ")", message,
                   at >= 0 && at <= (PetscInt)strlen(text) ? at + 1 : (PetscInt)strlen(text) + 1);
    mupErrorReset((*e)->parser);
  }
  for (const char *q = strchr(text, '='); q && !error[0]; q = strchr(q + 1, '=')) /* muParser assigns to variables */
    if (q[1] == '=')
      q++;
    else if (q == text || !strchr("<>!", q[-1]))
      (void)snprintf(error, len, "= does not compare, == does");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The components at position x [dim] in m and time t in s, of a particle that started at X [dim], or NULL where no X
   may stand. Not collective. */
PetscErrorCode MPMExpressionEvaluate(MPMExpression e, PetscInt dim, const PetscReal x[], const PetscReal X[],
                                     PetscReal t, PetscReal value[])
{
  int              n;
  const muFloat_t *v;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    e->var[d]     = d < dim ? x[d] : 0;
    e->var[3 + d] = d < dim && X ? X[d] : 0;
  }
  e->var[6] = t;
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

/* Reads an option whose value is an expression of these variables with nc components; *e stays NULL if not given. */
PetscErrorCode MPMOptionsExpression(MPMOptions o, const char row[], const char name[], const char variables[],
                                    PetscInt nc, MPMExpression *e)
{
  char      full[MPM_FULL_LEN], text[MPM_TEXT_LEN], error[MPM_TEXT_LEN];
  PetscInt  n;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, row, name, text, &set));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMOptionsFullName(row, name, full);
  PetscCall(MPMExpressionCreate(text, variables, e, &n, error, sizeof error));
  if (error[0])
    MPMOptionsFail(o, "-%s %.300s: %s", full, text, error);
  else if (n != nc && nc == o->dim)
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " component%s, -dim %" PetscInt_FMT " needs %" PetscInt_FMT, full, n,
                   n == 1 ? "" : "s", nc, nc);
  else if (n != nc)
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " components, it needs %" PetscInt_FMT, full, n, nc);
  PetscFunctionReturn(PETSC_SUCCESS);
}
