/* rare.c - what transfers do for one particle at a time, since few particles or few scenes need it. */
#include "kernels/rare.h"
#include "kernels/cell.h"

#define ON_PLANE 1e-9 /* cells: what is behind a plane by less was put on it */
#define BEYOND   0.25 /* cells: what has passed a wall by more is no small error */

/* Notes in status the particles first .. last-1 of a block whose J is not a positive number, at their positions before
   the step. order [n] are the particles of the block, here and below. */
void MPMRareBadJ(PetscInt dim, const MPMPatch *patch, PetscBool has_F, PetscInt first, PetscInt last,
                 const PetscInt *order, const MPMStencils *s, const MPMBlock *b, MPMStatus *status)
{
  for (PetscInt l = first; l < last; l++) {
    PetscReal F[9], x[3], J = b->J[0][l];

    for (PetscInt d = 0; d < dim; d++) x[d] = s->x[d][l];
    for (PetscInt k = 0; k < dim * dim; k++) F[k] = b->F[k][l];
    if (has_F) J = MPMDet((int)dim, F) * (patch->grid->round ? b->F33[0][l] : 1);
    if (!(J > 0 && J < PETSC_MAX_REAL)) MPMStatusNote(status, MPM_BAD_J, patch->particles.id[order[l]], dim, x, J);
  }
}

/* Moves the n particles of a block back through periodic faces, into [lower, upper). */
void MPMRareWrap(PetscInt dim, const MPMPatch *patch, PetscInt n, const PetscInt *order)
{
  const MPMGrid *grid = patch->grid;

  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal lower = grid->lower[d], upper = grid->upper[d], length = upper - lower;

    for (PetscInt l = 0; l < n && grid->periodic[d]; l++) {
      PetscReal *at = patch->particles.x + (size_t)order[l] * (size_t)dim + d;

      if (*at >= lower && *at < upper) continue;
      *at -= PetscFloorReal((*at - lower) / length) * length;
      if (*at < lower || *at >= upper) *at = lower; /* after rounding */
    }
  }
}

/* Sets g = w (i - at) / sum w (i - at)^2 of the particles whose weights an extrapolated spline changes at a wall: there
   the sum, in cells^2, is not that of uniform splines. On the wall itself it is 0, and g is its limit, the gradient. */
void MPMRareInertia(PetscInt dim, MPMBasis basis, const MPMGrid *grid, PetscInt n, MPMStencils *s)
{
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt l = 0; l < n && grid->wall_basis[d] == MPM_WALL_BASIS_EXTRAP; l++) {
      const PetscReal cells = (PetscReal)grid->cells[d], at = s->at[d][l];
      const PetscReal xi = PetscMin((s->x[d][l] - grid->lower[d]) / grid->h[d], cells);
      PetscReal       w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL], sum = 0;

      if (!MPMWallWeights(basis, xi, grid->cells[d], grid->wall_basis[d], w, g)) continue;
      for (int i = 0; i < MPMBasisNodes(basis); i++) sum += w[i] * (i - at) * (i - at);
      for (int i = 0; i < MPMBasisNodes(basis); i++)
        s->g[d][i][l] = (sum > 0 ? w[i] * (i - at) / sum : g[i]) * (1 / grid->h[d]);
    }
}

/* Puts the particles of a block that have passed the plane of a piston in this step back on it. Returns them, a bit for
   each. */
uint64_t MPMRarePlanes(PetscInt dim, const MPMParams *par, const MPMPatch *patch, PetscInt n, const PetscInt *order,
                       const MPMStencils *s)
{
  uint64_t back = 0;

  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscReal sign = k % 2 ? -1 : 1, same = ON_PLANE * patch->grid->h[k / 2];

    for (PetscInt l = 0; l < n && par->planes & (PetscInt)1 << k; l++) {
      PetscReal *x = patch->particles.x + (size_t)order[l] * (size_t)dim + k / 2;

      if (sign * (*x - par->plane[k][1]) >= 0 || sign * (s->x[k / 2][l] - par->plane[k][0]) < -same) continue;
      *x = par->plane[k][1];
      back |= (uint64_t)1 << l;
    }
  }
  return back;
}

/* Puts a particle at x [dim] that has passed a closed face back on it, if it is no further than BEYOND. Domains of gimp
   reach beyond a wall, and the first node inside moves a particle that is nearer to the wall than half of its domain.
   At a wall that only pushes, nodes that are free yet move a particle that is there. Returns whether it did. */
static PetscBool PutBack(PetscInt dim, const MPMGrid *grid, PetscInt closed, PetscReal x[])
{
  PetscBool back = PETSC_FALSE;

  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscReal face = k % 2 ? grid->upper[k / 2] : grid->lower[k / 2],
                    by   = k % 2 ? x[k / 2] - face : face - x[k / 2];

    if (!(closed & (PetscInt)1 << k) || !(by > 0 && by < BEYOND * grid->h[k / 2])) continue;
    x[k / 2] = face;
    back     = PETSC_TRUE;
  }
  return back;
}

/* Finds the cells of n particles of a block, number which[] in it, at their new positions; the block is the entries of
   the order from q on. Those in a new cell are movers: it is noted, and they are added to the movers of the patch.
   Counts movers and leavers. dim and basis are constants. */
MPM_INLINE void RareCells(int dim, MPMBasis basis, const MPMParams *par, MPMPatch *patch, PetscInt q, PetscInt n,
                          const PetscInt *which, const PetscInt *order, const MPMStencils *s, MPMStatus *status)
{
  const MPMView *particles = &patch->particles;

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt l = which[k], p = order[l];
    PetscReal      x[3] = {0}, half[3] = {0};
    PetscInt       base[3], cell;
    const PetscInt copy = par->kinds[s->kind[l]].copy;

    for (int d = 0; d < dim; d++) x[d] = particles->x[(size_t)p * dim + d], half[d] = s->l[d][l];
    cell = MPMOwnCell(dim, basis, patch, copy, x, half, base);
    if (cell == MPM_NOWHERE && PutBack(dim, patch->grid, par->closed, x)) {
      for (int d = 0; d < dim; d++) particles->x[(size_t)p * dim + d] = x[d];
      cell = MPMOwnCell(dim, basis, patch, copy, x, half, base);
    }
    if (cell == particles->cell[p]) continue;
    particles->cell[p] = cell;
    if (patch->movers) patch->movers[patch->nmovers] = cell < 0 ? MPM_FLAGGED(q + l) : q + l;
    patch->nmovers++;
    status->moved++;
    if (cell == MPM_ELSEWHERE) status->left++;
    if (cell == MPM_NOWHERE) {
      PetscBool finite = PETSC_TRUE;

      for (int d = 0; d < dim; d++) finite = finite && PetscAbsReal(x[d]) <= PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
      MPMStatusNote(status, finite && par->deletes ? MPM_GONE : MPM_LEFT_GRID, particles->id[p], dim, x, 0);
    }
  }
}

void MPMRareCells(PetscInt dim, const MPMParams *par, MPMPatch *patch, PetscInt q, PetscInt n, const PetscInt *which,
                  const PetscInt *order, const MPMStencils *s, MPMStatus *status)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (patch->basis == MPM_BASIS_##name) {                                                                              \
    if (dim == 1) RareCells(1, MPM_BASIS_##name, par, patch, q, n, which, order, s, status);                           \
    if (dim == 2) RareCells(2, MPM_BASIS_##name, par, patch, q, n, which, order, s, status);                           \
    if (dim == 3) RareCells(3, MPM_BASIS_##name, par, patch, q, n, which, order, s, status);                           \
  }
#include "physics/basis.def"
}
