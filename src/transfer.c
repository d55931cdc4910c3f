/* transfer.c - which kernels to run, for the number of lanes that the processor has, and what they leave to one
   particle at a time because it is rare. */
#include "transfer.h"

/* Of each width, [dim-1]: to nodes, to particles. */
extern const MPMTransfer MPMTransfers_8[3][2], MPMTransfers_4[3][2], MPMTransfers_2[3][2];

/* 8 lanes with AVX-512, 4 with AVX2, else 2. The environment's PEBBLE_VECTOR asks for at most so many (notes.c): the
   bits are the same. */
PetscInt MPMTransferWidth(void)
{
  static PetscInt width = 0;

  if (!width) {
    const char *wish = getenv("PEBBLE_VECTOR");
    const int   most = wish && atoi(wish) >= 2 ? atoi(wish) : 8;

    width = 2;
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (most >= 4 && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) width = 4;
    if (most >= 8 && width == 4 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
      width = 8;
#endif
  }
  return width;
}

MPMTransfer MPMTransferFind(PetscInt dim, MPMBasis basis, PetscInt parts)
{
  const PetscInt to_nodes     = parts & (MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_P2G_FORCE) ? 1 : 0;
  const PetscInt to_particles = parts & (MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT | MPM_G2P_FILTER) ? 1 : 0;

  if (dim < 1 || dim > 3 || basis >= MPM_NUM_BASES || to_nodes == to_particles) return NULL;
#if defined(__x86_64__)
  if (MPMTransferWidth() == 8) return MPMTransfers_8[dim - 1][to_particles];
  if (MPMTransferWidth() == 4) return MPMTransfers_4[dim - 1][to_particles];
#endif
  return MPMTransfers_2[dim - 1][to_particles];
}

/* Notes a bad condition: the gravest kind, of its smallest id. */
void MPMNoteBad(MPMStatus *status, MPMBad bad, PetscInt64 id, PetscInt dim, const PetscReal x[], PetscReal J)
{
  if (status->bad != MPM_OK && (status->bad < bad || (status->bad == bad && status->id <= id))) return;
  status->bad = bad;
  status->id  = id;
  status->J   = J;
  for (PetscInt d = 0; d < dim; d++) status->x[d] = x[d];
}

/* The same for those of particles first .. last-1 of a block whose J is not a positive number. */
void MPMNoteBadJ(PetscInt dim, const MPMPatch *patch, PetscBool has_F, PetscInt first, PetscInt last,
                 const PetscInt *order, const MPMBlock *b, MPMStatus *status)
{
  for (PetscInt l = first; l < last; l++) {
    PetscReal F[9], J = b->J[0][l];

    for (PetscInt k = 0; k < dim * dim; k++) F[k] = b->F[k][l];
    if (has_F) J = MPMDet((int)dim, F);
    if (!(J > 0 && J < PETSC_MAX_REAL))
      MPMNoteBad(status, MPM_BAD_J, patch->particles.id[order[l]], dim,
                 patch->particles.x + (size_t)order[l] * (size_t)dim, J);
  }
}

/* Brings x [dim] of n particles back through periodic faces; [lower, upper) afterwards. */
void MPMWrap(PetscInt dim, const MPMGrid *grid, PetscInt n, MPMRow *x)
{
  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal lower = grid->lower[d], upper = grid->upper[d], length = upper - lower;

    for (PetscInt l = 0; l < n && grid->periodic[d]; l++) {
      PetscReal *at = &x[d][l];

      if (*at >= lower && *at < upper) continue;
      *at -= PetscFloorReal((*at - lower) / length) * length;
      if (*at < lower || *at >= upper) *at = lower; /* rounding */
    }
  }
}

/* Half-widths of n stretched domains (cpGIMP): those of the kind times the diagonal of V = sqrt(F F^T), which a
   rotation of the undeformed leaves as it is and which turns with the material, unlike the diagonal of F. */
void MPMStretchDomains(PetscInt dim, const MPMParams *par, MPMPatch *patch, PetscInt n, const PetscInt *order,
                       const MPMRow *x, MPMStatus *status)
{
  const MPMView *particles = &patch->particles;

  for (PetscInt q = 0; q < n; q++) {
    const PetscInt p = order[q];
    PetscReal      V[3], at[3];

    MPMStretch((int)dim, particles->F + (size_t)(p * dim * dim), V);
    for (PetscInt d = 0; d < dim; d++) at[d] = x[d][q];
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal l = par->kinds[particles->kind ? particles->kind[p] : 0].l[d] * V[d];

      if (!(l <= 0.5)) { /* its stencil would be too small */
        MPMNoteBad(status, MPM_TOO_WIDE, particles->id[p], dim, at, 2 * l);
        l = 0.5;
      }
      particles->l[p * dim + d] = l;
    }
  }
}

/* Floating-point operations per particle, counted by hand from transfer.h and transfer_sums.c: an addition, product or
   quotient is 1, a fused multiply-add 2; the law is counted as a neo-Hookean solid (a logarithm is 26). Only lanes that
   hold something count. The adds of a cell's sums to its nodes, xpic's filter and the forms of splines at walls are
   left out. */
PetscReal MPMTransferFlops(PetscInt dim, MPMBasis basis, PetscInt parts)
{
  static const PetscReal weights[] = {
      [MPM_BASIS_linear] = 1, [MPM_BASIS_gimp] = 26, [MPM_BASIS_bspline2] = 15, [MPM_BASIS_bspline3] = 24};
  const PetscReal d = dim, ns = MPMBasisNodes(basis), rows = dim == 1 ? 1 : PetscPowReal(ns, d - 1), nodes = rows * ns;
  const PetscReal planes = dim == 3 ? ns : 0, inner = dim == 1 ? 0 : rows; /* products with wz; with wy */
  const PetscReal sym = d * (d + 1) / 2, det = dim == 1 ? 0 : dim == 2 ? 3 : 14;
  const PetscReal law       = 26 + det + sym * (2 * d - 1) + 1 + sym + 2 * d;
  const PetscReal one_force = dim == 3 ? 4 * (planes + inner + nodes) : dim == 2 ? 3 * inner + 4 * nodes : 2 * nodes;
  const PetscReal values    = parts & MPM_G2P_MOTION ? 2 * d : d;
  const PetscReal sums      = (parts & MPM_P2G_MASS ? 1 : 0) + (parts & MPM_P2G_MOMENTUM ? d : 0);
  PetscReal       flops     = d * (6 + weights[basis] + ns); /* coordinate, number of the cell; g/h */

  flops += sums * (planes + inner + 2 * nodes);
  if (parts & MPM_P2G_MOMENTUM) flops += d;
  if (parts & MPM_P2G_FORCE) flops += law + d * d + d * one_force;
  if ((parts & MPM_P2G_MOMENTUM) && (parts & MPM_AFFINE)) flops += 4 * d * d + d * (4 * planes + 3 * inner + 2 * nodes);
  if (parts & (MPM_G2P_MOTION | MPM_G2P_FILTER)) flops += 2 * values * (nodes + inner + planes);
  if (parts & MPM_G2P_MOTION) flops += 8 * d;
  if (parts & MPM_G2P_STRESS) { /* without the motion the velocities' rows come extra */
    flops += 2 * d * (nodes + 2 * inner + 3 * planes);
    if (!(parts & MPM_G2P_MOTION)) flops += 2 * d * (nodes + (dim == 3 ? inner : 0));
    flops += d * d * (2 * d + 1) + 2 * det + sym * (2 * d - 1) + d * d + 6;
  }
  if ((parts & MPM_G2P_MOTION) && (parts & MPM_AFFINE))
    flops += 3 * d * ns + 2 * d * (2 * nodes + 3 * inner + 3 * planes);
  if (parts & MPM_G2P_COMMIT) flops += d * (1 + 6 + 2);
  return flops;
}
