/* expression.c - option values that are formulas of coordinates and time, through the C interface of muParser.
   Components are separated by commas. Formulas of a scene are read at the start and evaluated in steps. */
#include <muParserDLL.h>
#include "options/time_tables.h"

static const char letters[] = "xyzXYZt"; /* position x, position at the start X, time */

/* --- What a formula may contain ----------------------------------------------------------------------------------- */

static muFloat_t Sign(muFloat_t a)
{
  return (a > 0) - (a < 0);
}

static muFloat_t Nearest(muFloat_t a)
{
  return floor(a + 0.5);
}

static muFloat_t Sum(const muFloat_t *a, muInt_t n)
{
  muFloat_t sum = 0;

  for (muInt_t k = 0; k < n; k++) sum += a[k];
  return sum;
}

static muFloat_t Average(const muFloat_t *a, muInt_t n)
{
  return Sum(a, n) / n;
}

static muFloat_t Least(const muFloat_t *a, muInt_t n)
{
  muFloat_t least = a[0];

  for (muInt_t k = 1; k < n; k++) least = PetscMin(least, a[k]);
  return least;
}

static muFloat_t Largest(const muFloat_t *a, muInt_t n)
{
  muFloat_t largest = a[0];

  for (muInt_t k = 1; k < n; k++) largest = PetscMax(largest, a[k]);
  return largest;
}

const char *const MPMFormulaTitle =
    "formulas: values in quotes, of the variables that the option names; commas separate components";

/* Variables and operators, which muParser has itself; constants, with their value; functions of one, two or any number
   of arguments. No formula has other constants and functions than these, whatever the version of muParser has. */
static const struct {
  const char *what, *meaning;
  PetscReal   value;
  muFun1_t    one;
  muFun2_t    two;
  muMultFun_t any;
} words[] = {
    {"x, y, z", "place of the particle now, m", 0, NULL, NULL, NULL},
    {"X, Y, Z", "its place at the start, m", 0, NULL, NULL, NULL},
    {"t", "time, s", 0, NULL, NULL, NULL},
    {"pi", "3.14159...", PETSC_PI, NULL, NULL, NULL},
    {"_pi", "the same", PETSC_PI, NULL, NULL, NULL},
    {"_e", "2.71828..., the base of ln", 2.71828182845904523536, NULL, NULL, NULL},
    {"table(file.csv)",
     "value at the time t of a table of lines t,value; linear between them, constant before and after; a relative path starts at the folder of the options file",
     0, NULL, NULL, NULL},
    {"a + b, a - b, a*b, a/b", "as usual; -a^2 is -(a^2)", 0, NULL, NULL, NULL},
    {"a^b", "a to the power b; a^b^c is a^(b^c)", 0, NULL, NULL, NULL},
    {"a < b, a <= b, a > b, a >= b, a == b, a != b", "1 where it holds, else 0", 0, NULL, NULL, NULL},
    {"a && b, a || b", "1 where both are not 0, where one is not 0; else 0", 0, NULL, NULL, NULL},
    {"a ? b : c", "b where a is not 0, else c", 0, NULL, NULL, NULL},
    {"sin(a)", "sine of a in rad", 0, sin, NULL, NULL},
    {"cos(a)", "cosine", 0, cos, NULL, NULL},
    {"tan(a)", "tangent", 0, tan, NULL, NULL},
    {"asin(a)", "arc sine, in rad", 0, asin, NULL, NULL},
    {"acos(a)", "arc cosine", 0, acos, NULL, NULL},
    {"atan(a)", "arc tangent", 0, atan, NULL, NULL},
    {"atan2(a, b)", "angle of the point (b, a) from the first axis, in rad", 0, NULL, atan2, NULL},
    {"sinh(a)", "hyperbolic sine", 0, sinh, NULL, NULL},
    {"cosh(a)", "hyperbolic cosine", 0, cosh, NULL, NULL},
    {"tanh(a)", "hyperbolic tangent", 0, tanh, NULL, NULL},
    {"asinh(a)", "inverse of sinh", 0, asinh, NULL, NULL},
    {"acosh(a)", "inverse of cosh", 0, acosh, NULL, NULL},
    {"atanh(a)", "inverse of tanh", 0, atanh, NULL, NULL},
    {"exp(a)", "e to the power a", 0, exp, NULL, NULL},
    {"ln(a)", "natural logarithm", 0, log, NULL, NULL},
    {"log(a)", "the same", 0, log, NULL, NULL},
    {"log10(a)", "decimal logarithm", 0, log10, NULL, NULL},
    {"log2(a)", "binary logarithm", 0, log2, NULL, NULL},
    {"sqrt(a)", "square root", 0, sqrt, NULL, NULL},
    {"abs(a)", "absolute value", 0, fabs, NULL, NULL},
    {"sign(a)", "-1, 0 or 1", 0, Sign, NULL, NULL},
    {"rint(a)", "the nearest whole number; of two the larger", 0, Nearest, NULL, NULL},
    {"min(a, b, ...)", "the smallest of any number of values", 0, NULL, NULL, Least},
    {"max(a, b, ...)", "the largest", 0, NULL, NULL, Largest},
    {"sum(a, b, ...)", "their sum", 0, NULL, NULL, Sum},
    {"avg(a, b, ...)", "their mean", 0, NULL, NULL, Average},
};

/* Described in reader.h. */
PetscBool MPMFormulaWord(size_t k, const char **what, const char **meaning)
{
  if (k >= sizeof words / sizeof words[0]) return PETSC_FALSE;
  *what    = words[k].what;
  *meaning = words[k].meaning;
  return PETSC_TRUE;
}

/* Gives a parser the constants and functions of the table in place of its own. */
static void Define(muParserHandle_t parser)
{
  mupClearConst(parser);
  mupClearFun(parser);
  for (size_t k = 0; k < sizeof words / sizeof words[0]; k++) {
    char name[MPM_NAME_LEN];

    (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(words[k].what, "("), words[k].what);
    if (words[k].value != 0) mupDefineConst(parser, name, words[k].value);
    if (words[k].one) mupDefineFun1(parser, name, words[k].one, 1);
    if (words[k].two) mupDefineFun2(parser, name, words[k].two, 1);
    if (words[k].any) mupDefineMultFun(parser, name, words[k].any, 1);
  }
}

/* --- Reading and evaluating --------------------------------------------------------------------------------------- */

struct _MPMExpression {
  muParserHandle_t parser;
  PetscReal        var[sizeof letters - 1];
  PetscInt         ntables; /* tables over time: of each a variable, with its value at the time of an evaluation */
  MPMTable        *tables;
  PetscReal       *now;
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

/* Adds to what is said of a token that is not known which variables there are. */
static void AddVariables(const char variables[], char error[], size_t len)
{
  size_t at = strlen(error);

  at += (size_t)snprintf(error + at, len - at, variables[0] ? "; its variables are" : "; it has no variables");
  for (const char *v = variables; *v; v++) at += (size_t)snprintf(error + at, len - at, " %c", *v);
}

/* Parses text, which may use the letters in `variables`. error [len] gets a description of a fault, or "" if there is
   none; *n is the number of components. The caller destroys *e. Not collective. */
static PetscErrorCode Create(const char full[], const char given[], const char variables[], MPMExpression *e,
                             PetscInt *n, char error[], size_t len)
{
  int  count = 0;
  char text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  *n = 0;
  PetscCall(PetscNew(e));
  PetscCall(MPMTablesRead(full, given, text, &(*e)->ntables, &(*e)->tables, error, len));
  if ((*e)->ntables && !error[0] && !strchr(variables, 't'))
    (void)snprintf(error, len, "a table is one over time, and this formula does not depend on t");
  (*e)->parser = mupCreate(muBASETYPE_FLOAT);
  PetscCheck((*e)->parser, PETSC_COMM_SELF, PETSC_ERR_LIB, "muParser has no parser left");
  for (const char *v = variables; *v; v++) {
    const char       name[2] = {*v, 0};
    PetscReal *const at      = &(*e)->var[strchr(letters, *v) - letters];

    *at = 0.5; /* any value will do: the first evaluation only checks the syntax */
    mupDefineVar((*e)->parser, name, at);
  }
  PetscCall(PetscCalloc1(PetscMax(1, (*e)->ntables), &(*e)->now));
  for (PetscInt k = 0; k < (*e)->ntables; k++) {
    char name[MPM_NAME_LEN];

    (void)snprintf(name, sizeof name, "_table%" PetscInt_FMT, k);
    mupDefineVar((*e)->parser, name, &(*e)->now[k]);
  }
  Define((*e)->parser);
  if (error[0]) PetscFunctionReturn(PETSC_SUCCESS);
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
    if (!strncmp(message, "Unexpected token", 16)) AddVariables(variables, error, len);
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
  for (PetscInt k = 0; k < e->ntables; k++) e->now[k] = MPMTableValue(&e->tables[k], t);
  v = mupEvalMulti(e->parser, &n);
  PetscCheck(!mupError(e->parser), PETSC_COMM_SELF, PETSC_ERR_LIB, "muParser: %s", mupGetErrorMsg(e->parser));
  for (int k = 0; k < n; k++) value[k] = v[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MPMExpressionTables(MPMExpression e)
{
  PetscReal last = 0;

  for (PetscInt k = 0; e && k < e->ntables; k++) last = PetscMax(last, e->tables[k].t[e->tables[k].n - 1]);
  return last;
}

/* Frees an expression, or does nothing if it is NULL. Not collective. */
PetscErrorCode MPMExpressionDestroy(MPMExpression *e)
{
  PetscFunctionBeginUser;
  if (!*e) PetscFunctionReturn(PETSC_SUCCESS);
  mupRelease((*e)->parser);
  PetscCall(MPMTablesDestroy((*e)->ntables, &(*e)->tables));
  PetscCall(PetscFree((*e)->now));
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
  PetscCall(Create(full, text, variables, e, &n, error, sizeof error));
  if (error[0])
    MPMOptionsFail(o, "-%s %.300s: %s", full, text, error);
  else if (n != nc && nc == o->dim)
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " component%s, -dim %" PetscInt_FMT " needs %" PetscInt_FMT, full, n,
                   n == 1 ? "" : "s", nc, nc);
  else if (n != nc)
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " components, it needs %" PetscInt_FMT, full, n, nc);
  PetscFunctionReturn(PETSC_SUCCESS);
}
