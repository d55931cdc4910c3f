/* tensor.h - operations on small matrices, for material laws and transfers.

   dim is a compile-time constant after inlining, so the loops unroll. An MPMReal is one particle or, in the files that
   are compiled for lanes, several (lanes.h). F is [dim*dim] row-major; a symmetric tensor is [6] in the sequence xx xy
   xz yy yz zz, complete in every dimension: 2-D is plane strain (F33 = 1), 1-D is uniaxial strain (F22 = F33 = 1). */
#ifndef MPM_TENSOR_H
#define MPM_TENSOR_H

#include "base/masks.h"

/* Returns where row d, column e of a symmetric tensor is in xx xy xz yy yz zz. */
MPM_INLINE int MPMSymIndex(int d, int e)
{
  const int lo = d < e ? d : e, hi = d < e ? e : d;

  return lo == 0 ? hi : lo + hi + 1;
}

/* The components of a symmetric tensor that are not always 0 in a dimension: xx yy zz; xx xy yy zz; all six. */
#define MPM_SYM_NC(dim) ((dim) == 1 ? 3 : (dim) == 2 ? 4 : 6)

/* MPMSymPlace returns where component k of these is among the six; MPMSymUnit returns component k of the unit
   tensor. */
MPM_INLINE int MPMSymPlace(int dim, int k)
{
  return dim == 3 ? k : dim == 2 ? (k == 0 ? 0 : k == 1 ? 1 : k == 2 ? 3 : 5) : (k == 0 ? 0 : k == 1 ? 3 : 5);
}

MPM_INLINE int MPMSymUnit(int dim, int k)
{
  const int place = MPMSymPlace(dim, k);

  return place == 0 || place == 3 || place == 5;
}

/* Returns which of the components of MPM_SYM_NC is row d, column e; d, e < dim. */
MPM_INLINE int MPMSymPart(int dim, int d, int e)
{
  return dim == 3 ? MPMSymIndex(d, e) : d + e;
}

/* Returns det F. */
MPM_INLINE MPMReal MPMDet(int dim, const MPMReal *F)
{
  if (dim == 1) return F[0];
  if (dim == 2) return F[0] * F[3] - F[1] * F[2];
  return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
}

/* Computes b = F F^T, the left Cauchy-Green tensor. */
MPM_INLINE void MPMLeftCauchyGreen(int dim, const MPMReal *F, MPMReal b[6])
{
  b[0] = b[3] = b[5] = MPMAll(1);
  b[1] = b[2] = b[4] = MPMAll(0);
  for (int d = 0; d < dim; d++)
    for (int e = d; e < dim; e++) {
      MPMReal s = F[d * dim] * F[e * dim];
      for (int k = 1; k < dim; k++) s += F[d * dim + k] * F[e * dim + k];
      b[MPMSymIndex(d, e)] = s;
    }
}

/* Updates F <- (I + dt L) F, eqs. (10) and (11) of docs/method.md. */
MPM_INLINE void MPMDeform(int dim, PetscReal dt, const MPMReal *L, MPMReal *F)
{
  MPMReal G[9];

  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      MPMReal s = L[d * dim] * F[e];
      for (int k = 1; k < dim; k++) s += L[d * dim + k] * F[k * dim + e];
      G[d * dim + e] = F[d * dim + e] + dt * s;
    }
  for (int k = 0; k < dim * dim; k++) F[k] = G[k];
}

/* Returns the natural logarithm of a positive normal number, with an error below 1 ulp: the algorithm of fdlibm's
   e_log.c (Sun Microsystems, 1993) without branches. It is used instead of libm's log because states must have the same
   bits with every libm and compiler, and because it must vectorise. If x <= 0 or not finite its value means nothing;
   such a J has been noted as bad by then, and the run stops. */
MPM_INLINE MPMReal MPMLog(MPMReal x)
{
  const PetscReal magic = 6755399441055744.0; /* 1.5 2^52: a sum with it has integers in its low bits */
  MPMBits         ix, k;
  MPMReal         m, dk;

  memcpy(&ix, &x, sizeof ix);
  k = ((ix - 0x3fe6a09e667f3bcdULL + (1023ULL << 52)) >> 52) - 1023; /* x = 2^k m, m in [sqrt(1/2), sqrt 2) */
  ix -= k << 52;
  k += 0x4338000000000000ULL; /* the bits of 1.5 2^52 + k */
  memcpy(&m, &ix, sizeof m);
  memcpy(&dk, &k, sizeof dk);
  dk -= magic;
  {
    const MPMReal f = m - 1.0, s = f / (f + 2.0), z = s * s, w = z * z, h = 0.5 * f * f;
    const MPMReal t1 = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    const MPMReal t2 = z *
                       (6.666666666666735130e-01 +
                        w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860510658591e-01)));

    return dk * 6.93147180369123816490e-01 - ((h - (s * (h + (t1 + t2)) + dk * 1.90821492927058770002e-10)) - f);
  }
}

/* Returns e^x with an error below 1 ulp: the algorithm of fdlibm's e_exp.c (Sun Microsystems, 1993) without branches,
   for the same reasons as MPMLog. Beyond the range it gives 0 and infinity; a subnormal result is right to its last
   bit. */
MPM_INLINE MPMReal MPMExp(MPMReal x)
{
  const PetscReal magic = 6755399441055744.0; /* 1.5 2^52: adding it leaves an integer in the low bits */
  MPMBits         ik, half, rest;
  MPMReal         shifted, a, b;

  x       = MPMMax(MPMMin(x, MPMAll(710)), MPMAll(-746));
  shifted = x * 1.44269504088896338700e+00 + magic;
  memcpy(&ik, &shifted, sizeof ik);
  ik -= 0x4338000000000000ULL; /* x = k ln 2 + (hi - lo), |hi - lo| <= ln 2/2; k here modulo 2^64 */
  /* 2^k is a product of two powers, since k goes from -1076 to 1024; all products but the last are exact. k + 2048 > 0,
     so the shift is one of an unsigned number, which all processors have. */
  half = (ik + 2048) >> 1;
  rest = (ik + 2048) - half;
  half = (half - 1024 + 1023) << 52;
  rest = (rest - 1024 + 1023) << 52;
  memcpy(&a, &half, sizeof a);
  memcpy(&b, &rest, sizeof b);
  {
    const MPMReal dk = shifted - magic;
    const MPMReal hi = x - dk * 6.93147180369123816490e-01, lo = dk * 1.90821492927058770002e-10;
    const MPMReal r = hi - lo, z = r * r;
    const MPMReal c = r - z * (1.66666666666666019037e-01 +
                               z * (-2.77777777770155933842e-03 +
                                    z * (6.61375632143793436117e-05 +
                                         z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));

    return (1.0 - ((lo - (r * c) / (2.0 - c)) - hi)) * a * b;
  }
}

/* Applies one Jacobi rotation in the plane of axes p and q (r is the third axis): A [3][3], symmetric, becomes R A R^T
   with A[p][q] = 0, and the rows of V are rotated with it. It takes the smaller of the two possible angles and no
   difference of close numbers, so eigenvalues that are close together are as accurate as others. Lanes where `done` is
   true are not rotated. */
MPM_INLINE void MPMJacobi(MPMReal A[3][3], MPMReal V[3][3], int p, int q, int r, MPMMask done)
{
  const MPMReal none = MPMAll(0), b = A[p][q], h = 0.5 * (A[q][q] - A[p][p]), root = MPMSqrt(h * h + b * b);
  const MPMReal d       = h + MPMSelect(h < 0, -root, root);
  const MPMMask nonzero = d != 0; /* lanes that do not rotate divide by 1, so that they raise no exception */
  const MPMReal t = MPMSelect(MPMNot(done) & nonzero, b / MPMSelect(nonzero, d, MPMAll(1)), none); /* tan, |t| <= 1 */
  const MPMReal c = 1 / MPMSqrt(1 + t * t), s = t * c, Apr = A[p][r], Aqr = A[q][r];

  A[p][p] -= t * b;
  A[q][q] += t * b;
  A[p][q] = A[q][p] = none;
  A[p][r] = A[r][p] = c * Apr - s * Aqr;
  A[q][r] = A[r][q] = s * Apr + c * Aqr;
  for (int k = 0; k < 3; k++) {
    const MPMReal vp = V[p][k], vq = V[q][k];

    V[p][k] = c * vp - s * vq;
    V[q][k] = s * vp + c * vq;
  }
}

/* Computes eigenvalues [3], unsorted, and unit eigenvectors vectors[k][axis] of a symmetric tensor a [6], by Jacobi
   rotations. The error is a few units in the last place of the largest eigenvalue, and for a positive definite tensor
   of each one (Demmel and Veselic, SIAM J. Matrix Anal. Appl. 13 (1992) 1204). In 2-D one rotation is exact. In 3-D
   rounds of three rotations converge quadratically; no tensor was seen to need more than 5, and the loop allows 8. The
   squares of components must neither vanish nor overflow. Only +, -, *, / and square roots are used, so the bits are
   the same everywhere. Lanes that have converged stay unchanged until all have. */
MPM_INLINE void MPMEigen(int dim, const MPMReal a[6], MPMReal values[3], MPMReal vectors[3][3])
{
  const PetscReal tiny    = 0x1p-112; /* an element whose relative square is this small changes no digit */
  MPMReal         A[3][3] = {{a[0], a[1], a[2]}, {a[1], a[3], a[4]}, {a[2], a[4], a[5]}};
  MPMMask         done    = MPMNone();

  for (int k = 0; k < 3; k++)
    for (int d = 0; d < 3; d++) vectors[k][d] = MPMAll(k == d);
  if (dim == 2) MPMJacobi(A, vectors, 0, 1, 2, done);
  for (int sweep = 0; sweep < 8 && dim == 3; sweep++) {
    const MPMMask first  = A[0][1] * A[0][1] <= tiny * MPMAbs(A[0][0] * A[1][1]);
    const MPMMask second = A[0][2] * A[0][2] <= tiny * MPMAbs(A[0][0] * A[2][2]);
    const MPMMask third  = A[1][2] * A[1][2] <= tiny * MPMAbs(A[1][1] * A[2][2]);

    done |= first & second & third;
    if (!MPMAny(MPMNot(done))) break;
    MPMJacobi(A, vectors, 0, 1, 2, done);
    MPMJacobi(A, vectors, 0, 2, 1, done);
    MPMJacobi(A, vectors, 1, 2, 0, done);
  }
  for (int k = 0; k < 3; k++) values[k] = A[k][k];
}

/* Computes a = sum_k values[k] n_k n_k^T with n_k = vectors[k], the inverse of MPMEigen. */
MPM_INLINE void MPMSpectral(int dim, const MPMReal values[3], MPMReal vectors[3][3], MPMReal a[6])
{
  for (int d = 0; d < 3; d++)
    for (int e = d; e < 3; e++) {
      MPMReal s = MPMAll(0);
      if (d < dim && e < dim)
        for (int k = 0; k < dim; k++) s += values[k] * vectors[k][d] * vectors[k][e];
      else if (d == e)
        s = values[d];
      a[MPMSymIndex(d, e)] = s;
    }
}

/* Computes the diagonal V [dim] of the left stretch tensor sqrt(F F^T). */
MPM_INLINE void MPMStretch(int dim, const MPMReal *F, MPMReal V[3])
{
  MPMReal b[6], squares[3], n[3][3];

  MPMLeftCauchyGreen(dim, F, b);
  if (dim == 1) {
    V[0] = MPMAbs(F[0]);
  } else if (dim == 2) { /* by Cayley-Hamilton, V^2 - tr(V) V + det(V) I = 0 */
    const MPMReal J = MPMAbs(MPMDet(2, F)), trace = MPMSqrt(b[0] + b[3] + 2 * J);

    V[0] = (b[0] + J) / trace;
    V[1] = (b[3] + J) / trace;
  } else {
    MPMEigen(3, b, squares, n);
    for (int d = 0; d < 3; d++) {
      V[d] = MPMAll(0);
      for (int k = 0; k < 3; k++) V[d] += MPMSqrt(squares[k]) * n[k][d] * n[k][d];
    }
  }
}

#if MPM_WIDTH == 1 /* for single particles */

/* Computes c = J F^-T [dim*dim], by which areas deform. */
MPM_INLINE void MPMCofactor(int dim, const PetscReal *F, PetscReal *c)
{
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      const int p = (d + 1) % 3, q = (d + 2) % 3, r = (e + 1) % 3, s = (e + 2) % 3;

      if (dim == 1) c[0] = 1;
      if (dim == 2) c[d * 2 + e] = (d == e ? 1 : -1) * F[(1 - d) * 2 + 1 - e];
      if (dim == 3) c[d * 3 + e] = F[p * 3 + r] * F[q * 3 + s] - F[p * 3 + s] * F[q * 3 + r];
    }
}

#endif

#endif
