/* tensor.h - the few small-matrix operations that materials and transfers share.

   dim is always a compile-time constant after inlining, so the loops unroll. F is [dim*dim] row-major; a symmetric
   tensor is [6] in the order xx xy xz yy yz zz, whole in every dimension: 2-D is plane strain (F33 = 1), 1-D is
   uniaxial strain (F22 = F33 = 1). */
#ifndef MPM_TENSOR_H
#define MPM_TENSOR_H

#include <petscsys.h>
#include <stdint.h>
#include <string.h>

#define MPM_INLINE static inline __attribute__((always_inline))

/* Row d, column e of a symmetric tensor stored as xx xy xz yy yz zz. */
MPM_INLINE int MPMSymIndex(int d, int e)
{
  const int lo = d < e ? d : e, hi = d < e ? e : d;

  return lo == 0 ? hi : lo + hi + 1;
}

MPM_INLINE PetscReal MPMDet(int dim, const PetscReal *F)
{
  if (dim == 1) return F[0];
  if (dim == 2) return F[0] * F[3] - F[1] * F[2];
  return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
}

/* b = F F^T, the left Cauchy-Green tensor. */
MPM_INLINE void MPMLeftCauchyGreen(int dim, const PetscReal *F, PetscReal b[6])
{
  b[0] = b[3] = b[5] = 1;
  b[1] = b[2] = b[4] = 0;
  for (int d = 0; d < dim; d++)
    for (int e = d; e < dim; e++) {
      PetscReal s = F[d * dim] * F[e * dim];
      for (int k = 1; k < dim; k++) s += F[d * dim + k] * F[e * dim + k];
      b[MPMSymIndex(d, e)] = s;
    }
}

/* F <- (I + dt L) F, eqs. (10) and (11). */
MPM_INLINE void MPMDeform(int dim, PetscReal dt, const PetscReal *L, PetscReal *F)
{
  PetscReal G[9];

  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      PetscReal s = L[d * dim] * F[e];
      for (int k = 1; k < dim; k++) s += L[d * dim + k] * F[k * dim + e];
      G[d * dim + e] = F[d * dim + e] + dt * s;
    }
  for (int k = 0; k < dim * dim; k++) F[k] = G[k];
}

/* Natural logarithm of a positive normal number, below 1 ulp: the algorithm of fdlibm's e_log.c (Sun Microsystems,
   1993), branch-free. Our own, because a state must have the same bits with every libm and compiler, and because it
   has to vectorise; libm's log promises neither. For x <= 0 or not
   finite it returns something: such a J has been noted by then, and the step will not stand. */
MPM_INLINE PetscReal MPMLog(PetscReal x)
{
  uint64_t   ix;
  PetscInt64 k;
  PetscReal  m;

  memcpy(&ix, &x, sizeof ix);
  k = (PetscInt64)((ix - 0x3fe6a09e667f3bcdULL + (1023ULL << 52)) >> 52) -
      1023; /* x = 2^k m, m in [sqrt(1/2), sqrt 2) */
  ix -= (uint64_t)k << 52;
  memcpy(&m, &ix, sizeof m);
  {
    const PetscReal dk = (PetscReal)k, f = m - 1.0, s = f / (f + 2.0), z = s * s, w = z * z, h = 0.5 * f * f;
    const PetscReal t1 = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    const PetscReal t2 = z * (6.666666666666735130e-01 +
                              w * (2.857142874366239149e-01 +
                                   w * (1.818357216161805012e-01 + w * 1.479819860510658591e-01)));

    return dk * 6.93147180369123816490e-01 - ((h - (s * (h + (t1 + t2)) + dk * 1.90821492927058770002e-10)) - f);
  }
}

#endif
