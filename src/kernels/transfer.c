/* transfer.c - the choice of the kernels for the number of lanes that the processor has, and the count of their
   floating-point operations. */
#include "kernels/transfer.h"

/* For each width: [dim-1][to nodes, to particles]. */
extern const MPMKernel MPMKernels_8[3][2], MPMKernels_4[3][2], MPMKernels_2[3][2];

/* Returns 8 with AVX-512, 4 with AVX2, else 2. The environment variable PEBBLE_VECTOR sets an upper limit
   (advice/notes.c). The bits of results do not depend on it. */
PetscInt MPMKernelWidth(void)
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

/* Returns the kernel for these parts, or NULL if there is none: all parts must be of one direction. Not collective. */
MPMKernel MPMKernelFind(PetscInt dim, MPMBasis basis, PetscInt parts)
{
  const PetscInt to_nodes     = parts & MPM_P2G_CORE || MPMNodeLines(parts) > 1 ? 1 : 0;
  const PetscInt to_particles = parts & (MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT | MPM_G2P_FILTER |
                                         MPM_G2P_VOLUME | MPM_G2P_TOTAL)
                                    ? 1
                                    : 0;

  if (dim < 1 || dim > 3 || basis >= MPM_NUM_BASES || to_nodes == to_particles) return NULL;
#if defined(__x86_64__)
  if (MPMKernelWidth() == 8) return MPMKernels_8[dim - 1][to_particles];
  if (MPMKernelWidth() == 4) return MPMKernels_4[dim - 1][to_particles];
#endif
  return MPMKernels_2[dim - 1][to_particles];
}

/* Returns how many sums of nodes besides those of the first line these parts make. */
static PetscReal Further(PetscInt dim, PetscInt parts)
{
  PetscInt n = 0;

  for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++)
    if (g->home == MPM_IS_SUM && parts & g->part) n += g->components(dim);
  return (PetscReal)n;
}

/* Returns the floating-point operations per particle, counted by hand from transfer_sums.c, p2g.h and g2p.h: an
   addition, product or quotient is 1, a fused multiply-add 2. The law is counted as a neo-Hookean solid (a logarithm is
   26). Lanes without a particle do not count. The sums of a cell added to its tile, the filter of xpic and the forms of
   splines at walls are left out. */
PetscReal MPMKernelFlops(PetscInt dim, MPMBasis basis, PetscInt parts)
{
  static const PetscReal weights[] = {
      [MPM_BASIS_linear] = 1, [MPM_BASIS_gimp] = 26, [MPM_BASIS_bspline2] = 15, [MPM_BASIS_bspline3] = 24};
  const PetscReal d = dim, ns = MPMBasisNodes(basis), rows = dim == 1 ? 1 : PetscPowReal(ns, d - 1), nodes = rows * ns;
  const PetscReal planes = dim == 3 ? ns : 0, inner = dim == 1 ? 0 : rows; /* products with wz; with wy */
  const PetscReal sym = d * (d + 1) / 2, det = dim == 1 ? 0 : dim == 2 ? 3 : 14;
  const PetscReal law       = 26 + det + sym * (2 * d - 1) + 1 + sym + 2 * d;
  const PetscReal one_force = dim == 3 ? 4 * (planes + inner + nodes) : dim == 2 ? 2 * inner + 4 * nodes : 2 * nodes;
  const PetscReal values    = parts & MPM_G2P_MOTION ? 2 * d : d;
  const PetscReal sums      = (parts & MPM_P2G_MASS ? 1 : 0) + (parts & MPM_P2G_MOMENTUM ? d : 0) +
                         (parts & MPM_P2G_VOLUME ? 3 : 0) + Further(dim, parts);
  PetscReal flops = d * (6 + weights[basis] + ns); /* coordinate, number of the cell; g/h */

  flops += sums * (planes + inner + 2 * nodes);
  if (parts & MPM_P2G_MOMENTUM) flops += d;
  if (parts & MPM_P2G_FORCE) flops += law + (dim == 2 ? 3 : d * d) + d * one_force;
  if (parts & MPM_P2G_FBAR)
    flops += law + 2 * det + d * (6 + weights[basis] + ns) + 4 * d + 8; /* weights and law again */
  if ((parts & MPM_P2G_VOLUME) && (parts & MPM_AFFINE)) flops += 5 + 4 * d + 4 * planes + 3 * inner + 2 * nodes;
  if (parts & MPM_G2P_VOLUME) flops += 2 * values * (nodes + inner + planes) + 2 * d * (nodes + 2 * inner) + 30 + 4 * d;
  if ((parts & MPM_P2G_MOMENTUM) && (parts & MPM_AFFINE)) flops += 4 * d * d + d * (4 * planes + 3 * inner + 2 * nodes);
  if (parts & (MPM_G2P_MOTION | MPM_G2P_FILTER)) flops += 2 * values * (nodes + inner + planes);
  if (parts & MPM_G2P_MOTION) flops += 8 * d;
  if (parts & MPM_G2P_STRESS) { /* without the motion, rows of velocities have to be summed too */
    flops += 2 * d * (nodes + 2 * inner + 3 * planes);
    if (!(parts & MPM_G2P_MOTION)) flops += 2 * d * (nodes + (dim == 3 ? inner : 0));
    flops += d * d * (2 * d + 1) + 2 * det + sym * (2 * d - 1) + d * d + 6;
  }
  if (parts & MPM_G2P_FBAR) /* weights and gradients again; then the growth twice, the sums and the factor */
    flops += d * (6 + weights[basis] + ns) + 2 * d * (2 * nodes + 2 * inner + 3 * planes + (dim == 3 ? inner : 0)) +
             2 * (det + 2 * d + 2) + det + 4 + (dim == 3 ? 70 : 8) + 2 * d * d;
  if ((parts & MPM_G2P_MOTION) && (parts & MPM_AFFINE))
    flops += 3 * d * ns + 2 * d * (2 * nodes + 3 * inner + 3 * planes);
  if (parts & MPM_G2P_COMMIT) flops += d * (1 + 3); /* x + dx; the distance from the middle of the cell */
  return flops;
}
