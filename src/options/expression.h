/* expression.h - expressions of coordinates and time, with one or more components, by muParser. The functions are
   described in expression.c. */
#ifndef MPM_EXPRESSION_H
#define MPM_EXPRESSION_H

#include "base/base.h"

typedef struct _MPMExpression *MPMExpression;
PetscErrorCode MPMExpressionEvaluate(MPMExpression, PetscInt dim, const PetscReal x[], const PetscReal X[], PetscReal t,
                                     PetscReal value[]);
PetscReal      MPMExpressionTables(MPMExpression); /* when the last of its tables ends, s; 0: it has none */
PetscErrorCode MPMExpressionDestroy(MPMExpression *);

#endif
