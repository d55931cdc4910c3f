/* fit.c - how well the particles of a body fill its shape: the volume of the shape, and how many particles per cell
   represent it. Thin shapes may lie between the places of the lattice, or take up more of them than they should. */
#include "scene/fit.h"
#include "scene/lattice.h"

#define MOST_PPC    16  /* particles per cell and axis that are tried */
#define MOST_PLACES 1e7 /* places of the lattice that are tried */

/* Places a row, and rows an axis, by which the volume of a shape is found; by the dimension less one. */
static const PetscInt rows[] = {1, 256, 64}, places[] = {65536, 1024, 64};

/* Returns the volume of the shape of a body, m^dim, of a body of revolution its area, as the share of places of a fine
   lattice in its bounds that are inside: right to some per cent of a body that takes up a hundredth of its bounds. */
PetscReal MPMFitVolume(const MPMBody *b, PetscInt dim)
{
  const PetscInt n = rows[dim - 1], end = places[dim - 1], last = dim - 1;
  PetscReal      lower[3], upper[3], volume                     = 1;
  PetscInt64     inside = 0, all = end;
  MPMRow         row;

  MPMRegionBounds(&b->region, dim, lower, upper);
  if (b->round) lower[0] = PetscMax(0, lower[0]);
  for (PetscInt d = 0; d < dim; d++) volume *= upper[d] - lower[d];
  if (!(volume > 0)) return 0;
  for (PetscInt d = 0; d < last; d++) all *= n;
  row = (MPMRow){.dim = dim, .spacing = (upper[last] - lower[last]) / (PetscReal)end, .offset = lower[last]};
  for (PetscInt k = 0; k < all / end; k++) {
    PetscInt64 from = 0, to;

    for (PetscInt d = 0, at = k; d < last; d++, at /= n)
      row.x[d] = lower[d] + ((PetscReal)(at % n) + 0.5) * (upper[d] - lower[d]) / (PetscReal)n;
    row.x[last] = MPMRowPlace(&row, 0);
    for (; from < end; from = to) inside += MPMRegionSpan(&b->region, &row, from, end, &to) ? to - from : 0;
  }
  return volume * (PetscReal)inside / (PetscReal)all;
}

/* Returns the fewest particles per cell and axis, more than the body has, whose volume is near that of its shape,
   m^dim, or 0 if none of those that are tried is. */
static PetscInt Fitting(const MPMBody *b, const MPMGrid *grid, PetscReal volume)
{
  const PetscInt dim    = grid->dim;
  PetscInt       before = b->ppc[0];

  for (PetscInt d = 1; d < dim; d++) before = PetscMax(before, b->ppc[d]);
  for (PetscInt ppc = before + 1; ppc <= MOST_PPC; ppc++) {
    MPMBody    finer = *b;
    PetscReal  lower[3], upper[3], each = 1, all = 1;
    MPMLattice w;

    MPMRegionBounds(&b->region, dim, lower, upper);
    for (PetscInt d = 0; d < dim; d++) {
      finer.b[d] = grid->h[d] / (PetscReal)ppc;
      each *= finer.b[d];
      all *= (upper[d] - lower[d]) / finer.b[d] + 3;
    }
    if (all > MOST_PLACES) break;
    w = MPMLatticeBegin(&finer, dim);
    for (w.id = 0; MPMLatticeNext(&w);) continue;
    if (PetscAbsReal((PetscReal)w.id * each / volume - 1) <= MPM_FIT_MOST) return ppc;
  }
  return 0;
}

/* Writes why a body is not filled well, and what would fill it: its least extent beside the spacing of its particles,
   and more particles per cell, or another scale of its file. volume: of its shape, m^dim. */
void MPMFitTell(const MPMBody *b, const MPMGrid *grid, PetscReal volume, char text[MPM_TEXT_LEN])
{
  const PetscInt ppc = volume > 0 ? Fitting(b, grid, volume) : 0;
  PetscReal      lower[3], upper[3], most = 0;
  PetscInt       thin = 0;
  size_t         n;

  MPMRegionBounds(&b->region, grid->dim, lower, upper);
  for (PetscInt d = 0; d < grid->dim; d++) {
    most = PetscMax(most, (upper[d] - lower[d]) / b->b[d]);
    if ((upper[d] - lower[d]) / b->b[d] < (upper[thin] - lower[thin]) / b->b[thin]) thin = d;
  }
  (void)snprintf(text, MPM_TEXT_LEN, "along %c it is %.3g m, and its particles are %.3g m apart; ", "xyz"[thin],
                 (double)(upper[thin] - lower[thin]), (double)b -> b[thin]);
  n = strlen(text);
  if (b->region.type == MPM_REGION_stl && most < 2)
    (void)snprintf(text + n, MPM_TEXT_LEN - n, "is the unit of its file another one (-body_%s_scale)?", b->name);
  else if (ppc)
    (void)snprintf(text + n, MPM_TEXT_LEN - n, "use more of them per cell (-body_%s_ppc %" PetscInt_FMT ")", b->name,
                   ppc);
  else
    (void)snprintf(text + n, MPM_TEXT_LEN - n, "use smaller cells");
  n = strlen(text);
  for (PetscInt d = 1; ppc && d < grid->dim && text[n - 1] == ')'; d++, n = strlen(text))
    (void)snprintf(text + n - 1, MPM_TEXT_LEN - n + 1, ",%" PetscInt_FMT ")", ppc);
}

void MPMFitRefuse(MPMOptions o, const MPMGrid *grid, const MPMBody *b)
{
  const PetscReal volume = MPMFitVolume(b, grid->dim);
  char            why[MPM_TEXT_LEN];

  if (!(volume > 0)) {
    MPMOptionsFail(o, "body %s has no particles: nothing is inside of its shape%s; see -body_%s_shape", b->name,
                   b->region.others ? ", once others have cut it" : "", b->name);
    return;
  }
  MPMFitTell(b, grid, volume, why);
  MPMOptionsFail(o, "body %s has no particles: no place (i+1/2) h/ppc + offset lies in it; %.1500s", b->name, why);
}

void MPMFitPlace(const MPMBody *b, PetscBool huge, char text[], size_t len)
{
  const char *first = MPMRegionParameters[b->region.type];

  if (b->region.type == MPM_REGION_stl && huge)
    (void)snprintf(text, len, "; if its file is in mm, give -body_%s_scale 0.001", b->name);
  else if (b->region.type == MPM_REGION_stl)
    (void)snprintf(text, len, "; -body_%s_scale and -body_%s_shift change its size and place", b->name, b->name);
  else
    (void)snprintf(text, len, "; see -body_%s_%.*s, -grid_lower and -grid_upper", b->name, (int)strcspn(first, " "),
                   first);
}
