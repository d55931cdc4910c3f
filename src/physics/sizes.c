/* sizes.c - cell sizes that divide the box of the grid, for what is told; sizes.h describes it. */
#include "physics/sizes.h"

/* Returns whether cells of size h divide the box. */
static PetscBool Divides(const MPMGrid *grid, PetscReal h)
{
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal length = grid->upper[d] - grid->lower[d], n = PetscFloorReal(length / h + 0.5);

    if (n < 1 || PetscAbsReal(n * h - length) > 1e-10 * length) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

void MPMGridSizes(const MPMGrid *grid, PetscReal most, char text[], size_t len)
{
  const PetscReal length = grid->upper[0] - grid->lower[0], n = PetscCeilReal(length / most * (1 - 1e-9));
  char            one[32] = "";
  size_t          at      = 0;

  for (PetscInt digits = 3; digits <= 12 && !one[0]; digits += 9)
    for (PetscReal k = n; k <= 1.5 * n + 1 && k < n + 1000 && !one[0]; k++) {
      (void)snprintf(one, sizeof one, "%.*g", (int)digits, (double)(length / k));
      if (!Divides(grid, strtod(one, NULL))) one[0] = 0;
    }
  text[0] = 0;
  for (PetscInt d = 0; d < grid->dim && at < len; d++, at += strlen(text + at)) {
    const PetscReal side = grid->upper[d] - grid->lower[d];

    if (!one[0])
      (void)snprintf(text + at, len - at, "%s%.12g", d ? "," : "",
                     (double)(side / PetscCeilReal(side / most * (1 - 1e-9))));
    else
      (void)snprintf(text + at, len - at, "%s%s", d ? "," : "", one);
  }
}

void MPMGridFiner(const MPMGrid *grid, PetscReal times, char text[], size_t len)
{
  if (grid->by_h) {
    (void)snprintf(text, len, "-grid_h ");
    MPMGridSizes(grid, MPMGridSmallestH(grid) / times, text + strlen(text), len - strlen(text));
    return;
  }
  (void)snprintf(text, len, "-grid_cells");
  for (PetscInt d = 0; d < grid->dim; d++)
    MPMAppend(text, len, "%c%.0f", d ? ',' : ' ',
              (double)PetscCeilReal(times * (PetscReal)grid->cells[d] * (1 - 1e-9)));
}
