/* transfer.c - the instances of transfer.h's two kernels: every (dim, basis) with each set of parts that an integrator
   asks for. A new basis adds a row to basis.def and nothing here. */
#include "transfer.h"

/* The sets of parts, MPM_ALL_P2G(X, dim, basis) and so on for each. */
#define MPM_MP  (MPM_P2G_MASS | MPM_P2G_MOMENTUM)
#define MPM_MPF (MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_P2G_FORCE)
#define MPM_ALL_P2G(X, dim, basis)                                                                                     \
  X(dim, basis, MPM_MPF, mpf)                                                                                          \
  X(dim, basis, MPM_MP, mp)                                                                                            \
  X(dim, basis, MPM_P2G_MOMENTUM, p)                                                                                   \
  X(dim, basis, MPM_P2G_FORCE, f)                                                                                      \
  X(dim, basis, MPM_MPF | MPM_AFFINE, mpfa)                                                                            \
  X(dim, basis, MPM_MP | MPM_AFFINE, mpa)                                                                              \
  X(dim, basis, MPM_P2G_MOMENTUM | MPM_AFFINE, pa)                                                                     \
  X(dim, basis, MPM_P2G_MOMENTUM | MPM_RESIDUAL, pr)
#define MPM_ALL_G2P(X, dim, basis)                                                                                     \
  X(dim, basis, MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT, msc)                                                 \
  X(dim, basis, MPM_G2P_MOTION | MPM_G2P_COMMIT, mc)                                                                   \
  X(dim, basis, MPM_G2P_STRESS | MPM_G2P_COMMIT, sc)                                                                   \
  X(dim, basis, MPM_G2P_MOTION, m)                                                                                     \
  X(dim, basis, MPM_G2P_STRESS, s)                                                                                     \
  X(dim, basis, MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT | MPM_AFFINE, msca)                                   \
  X(dim, basis, MPM_G2P_MOTION | MPM_G2P_COMMIT | MPM_AFFINE, mca)                                                     \
  X(dim, basis, MPM_G2P_MOTION | MPM_AFFINE, ma)                                                                       \
  X(dim, basis, MPM_G2P_FILTER, f)                                                                                     \
  X(dim, basis, MPM_G2P_FILTER | MPM_RESIDUAL, fr)

#define MPM_INSTANCE_P2G(dim, basis, parts, tag)                                                                       \
  static void P2G_##basis##_##dim##_##tag(const MPMParams *par, MPMPatch *patch, MPMStatus *status)                    \
  {                                                                                                                    \
    (void)status;                                                                                                      \
    MPMP2G(dim, MPM_BASIS_##basis, parts, par, patch);                                                                 \
  }
#define MPM_INSTANCE_G2P(dim, basis, parts, tag)                                                                       \
  static void G2P_##basis##_##dim##_##tag(const MPMParams *par, MPMPatch *patch, MPMStatus *status)                    \
  {                                                                                                                    \
    MPMG2P(dim, MPM_BASIS_##basis, parts, par, patch, status);                                                         \
  }
#define MPM_BASIS(basis, nodes, layers, inertia, what)                                                                 \
  MPM_ALL_P2G(MPM_INSTANCE_P2G, 1, basis)                                                                              \
  MPM_ALL_P2G(MPM_INSTANCE_P2G, 2, basis)                                                                              \
  MPM_ALL_P2G(MPM_INSTANCE_P2G, 3, basis)                                                                              \
  MPM_ALL_G2P(MPM_INSTANCE_G2P, 1, basis)                                                                              \
  MPM_ALL_G2P(MPM_INSTANCE_G2P, 2, basis)                                                                              \
  MPM_ALL_G2P(MPM_INSTANCE_G2P, 3, basis)
#include "basis.def"
#undef MPM_BASIS

MPMTransfer MPMTransferFind(PetscInt dim, MPMBasis basis, PetscInt parts)
{
  static const struct {
    PetscInt    dim;
    MPMBasis    basis;
    PetscInt    parts;
    MPMTransfer run;
  } table[] = {
#define MPM_ENTRY_P2G(dim, basis, parts, tag) {dim, MPM_BASIS_##basis, parts, P2G_##basis##_##dim##_##tag},
#define MPM_ENTRY_G2P(dim, basis, parts, tag) {dim, MPM_BASIS_##basis, parts, G2P_##basis##_##dim##_##tag},
#define MPM_BASIS(basis, nodes, layers, inertia, what)                                                                 \
  MPM_ALL_P2G(MPM_ENTRY_P2G, 1, basis)                                                                                 \
  MPM_ALL_P2G(MPM_ENTRY_P2G, 2, basis)                                                                                 \
  MPM_ALL_P2G(MPM_ENTRY_P2G, 3, basis)                                                                                 \
  MPM_ALL_G2P(MPM_ENTRY_G2P, 1, basis)                                                                                 \
  MPM_ALL_G2P(MPM_ENTRY_G2P, 2, basis)                                                                                 \
  MPM_ALL_G2P(MPM_ENTRY_G2P, 3, basis)
#include "basis.def"
#undef MPM_BASIS
  };

  for (size_t r = 0; r < sizeof table / sizeof table[0]; r++)
    if (table[r].dim == dim && table[r].basis == basis && table[r].parts == parts) return table[r].run;
  return NULL;
}

/* Floating-point operations per point, counted by hand from transfer.h: an addition, product or quotient is 1; the law
   is counted as a neo-Hookean solid (a logarithm is 26). The adds of a cell's sums to its nodes are left out.        */
PetscReal MPMTransferFlops(PetscInt dim, MPMBasis basis, PetscInt parts)
{
  const PetscReal d = dim, ns = MPMBasisNodes(basis), nodes = PetscPowReal(ns, d);
  const PetscReal weights = d * (4 + 2 * ns), shape = (d + 1) * (d - 1); /* phi and dphi of a node */
  const PetscReal law = 26 + d * (d + 1) / 2 * (2 * d - 1) + 8, det = dim == 1 ? 0 : dim == 2 ? 3 : 14;
  PetscReal       flops = weights + nodes * shape;

  if (parts & MPM_P2G_MASS) flops += 2 * nodes;
  if (parts & MPM_P2G_MOMENTUM) flops += d + 2 * d * nodes;
  if (parts & MPM_P2G_FORCE) flops += det + law + d * d + 2 * d * d * nodes;
  if (parts & MPM_G2P_MOTION) flops += 4 * d * nodes + 8 * d;
  if (parts & MPM_G2P_STRESS)
    flops += 2 * d * d * nodes + d * d * (2 * d + 1) + 2 * det + d * (d + 1) / 2 * (2 * d - 1) + 6;
  if (parts & MPM_G2P_COMMIT) flops += 3 * d;
  return flops;
}
