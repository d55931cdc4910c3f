/* expression.c - option values that are expressions of coordinates, time, pi and the usual functions, through the C
   interface of muParser. Components are separated by commas. Formulas of a scene are read at the start and evaluated in
   steps. */
#include <muParserDLL.h>
#include "options/reader.h"

static const char letters[] = "xyzXYZt"; /* position x, position at the start X, time */

struct _MPMExpression {
  muParserHandle_t parser;
  PetscReal        var[sizeof letters - 1];
};

/* Cuts off the position, counted from 0, with which muParser ends most of its messages. */
static void CutPosition(char message[])
{
  static const char *const ends[] = {" found at position ", " at expression position ", " at position "};

  for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++) {
    char *const at = strstr(message, ends[k]), *const number = at ? at + strlen(ends[k]) : NULL;

    if (at && !number[strspn(number, "0123456789.")]) *at = 0;
  }
}

/* Parses text, which may use the letters in `variables`. error [len] gets a description of a fault, or "" if there is
   none; *n is the number of components. The caller destroys *e. Not collective. */
static PetscErrorCode Create(const char text[], const char variables[], MPMExpression *e, PetscInt *n, char error[],
                             size_t len)
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

    *at = 0.5; /* any value will do: the first evaluation only checks the syntax */
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
  if (MPMOptionsDash(text)) (void)snprintf(error, len, "write a plain - in place of the Unicode minus");
  for (const char *q = strchr(text, '='); q && !error[0]; q = strchr(q + 1, '=')) /* muParser would assign */
    if (q[1] == '=')
      q++;
    else if (q == text || !strchr("<>!", q[-1]))
      (void)snprintf(error, len, "= does not compare, == does");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the components at position x [dim] in m and time t in s, for a particle that started at X [dim] in m; X may
   be NULL if the expression has none. value has a place for each component. Not collective. */
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

/* Frees an expression, or does nothing if it is NULL. Not collective. */
PetscErrorCode MPMExpressionDestroy(MPMExpression *e)
{
  PetscFunctionBeginUser;
  if (!*e) PetscFunctionReturn(PETSC_SUCCESS);
  mupRelease((*e)->parser);
  PetscCall(PetscFree(*e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads an option whose value is an expression of these variables with nc components; *e stays as it is if the option
   is not given. Not collective. */
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
  PetscCall(Create(text, variables, e, &n, error, sizeof error));
  if (error[0])
    MPMOptionsFail(o, "-%s %.300s: %s", full, text, error);
  else if (n != nc && nc == o->dim)
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " component%s, -dim %" PetscInt_FMT " needs %" PetscInt_FMT, full, n,
                   n == 1 ? "" : "s", nc, nc);
  else if (n != nc)
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " components, it needs %" PetscInt_FMT, full, n, nc);
  PetscFunctionReturn(PETSC_SUCCESS);
}
