/* lanes.h - numbers that are computed for several particles at a time: an MPMReal is a vector of MPM_WIDTH reals, one
   particle a lane. It is a vector type of gcc and clang, whose +, -, *, / and comparisons act on each lane.

   The makefile compiles the files that need speed for 8, 4 and 2 lanes, each with the instructions for just that width
   (a vector wider than the processor's registers is split through memory, many times slower); transfer.c picks the
   width when the program starts. Everywhere else MPM_WIDTH is 1 and MPMReal is a plain PetscReal, so the same functions
   serve single particles. Each lane takes the same operations in every width, and no compiler may fuse any by its own
   choice (-ffp-contract=off): all widths give the same bits. MPMFma is a * b + c fused. Where a compiler makes no
   vector instruction of what is written for each lane, that instruction is called by its name, for 8 and 4 lanes. */
#ifndef MPM_LANES_H
#define MPM_LANES_H

#include "base/base.h"

#ifndef MPM_WIDTH
#define MPM_WIDTH 1
#endif
#if MPM_WIDTH > 2
#include <immintrin.h>
#endif

/* The name with the number of lanes added: name_8 where MPM_WIDTH is 8. */
#define MPM_LANES_NAME(name)          MPM_LANES_JOIN(name, MPM_WIDTH)
#define MPM_LANES_JOIN(name, width)   MPM_LANES_JOIN_AGAIN(name, width)
#define MPM_LANES_JOIN_AGAIN(name, w) name##_##w

/* Before a loop of constant length, at most 6: it is unrolled, so that vectors that it indexes are in registers. */
#if MPM_WIDTH < 4
#define MPM_UNROLL
#elif defined(__clang__)
#define MPM_UNROLL _Pragma("unroll")
#else
#define MPM_UNROLL _Pragma("GCC unroll 6")
#endif

/* An MPMMask is the result of a comparison; & and | combine masks, and MPMSelect chooses by one. An MPMBits holds the
   bits of reals. */
#if MPM_WIDTH == 1
typedef PetscReal MPMReal;
typedef int       MPMMask;
typedef uint64_t  MPMBits;
#else
typedef PetscReal MPMReal __attribute__((vector_size(8 * MPM_WIDTH)));
typedef int64_t   MPMMask __attribute__((vector_size(8 * MPM_WIDTH)));
typedef uint64_t  MPMBits __attribute__((vector_size(8 * MPM_WIDTH)));
#endif

/* Returns, in each lane, a where m is true and b elsewhere. */
MPM_INLINE MPMReal MPMSelect(MPMMask m, MPMReal a, MPMReal b)
{
#if MPM_WIDTH == 1
  return m ? a : b;
#else
  return (MPMReal)((m & (MPMMask)a) | (~m & (MPMMask)b));
#endif
}

/* Returns b in the lanes `which` (bits, a constant) and a elsewhere. With 4 lanes these are the first or the last two,
   with fewer all or none. */
MPM_INLINE MPMReal MPMBlend(unsigned which, MPMReal a, MPMReal b)
{
#if MPM_WIDTH == 8
  return _mm512_mask_blend_pd((__mmask8)which, a, b);
#elif MPM_WIDTH == 4
  return which == 0x3 ? _mm256_blend_pd(a, b, 0x3) : _mm256_blend_pd(a, b, 0xc);
#else
  return which ? b : a;
#endif
}

/* Returns a vector with the same number in all lanes. */
MPM_INLINE MPMReal MPMAll(PetscReal a)
{
#if MPM_WIDTH == 8
  return (MPMReal){a, a, a, a, a, a, a, a};
#elif MPM_WIDTH == 4
  return (MPMReal){a, a, a, a};
#elif MPM_WIDTH == 2
  return (MPMReal){a, a};
#else
  return a;
#endif
}

/* Returns the mask that is true in no lane. */
MPM_INLINE MPMMask MPMNone(void)
{
  return MPMAll(0) != MPMAll(0);
}

/* Returns the larger of a and b in each lane, and a where they are equal or one of them is not a number. (The
   instruction returns its second operand there.) */
MPM_INLINE MPMReal MPMMax(MPMReal a, MPMReal b)
{
#if MPM_WIDTH == 8
  return _mm512_max_pd(b, a);
#elif MPM_WIDTH == 4
  return _mm256_max_pd(b, a);
#else
  return MPMSelect(a < b, b, a);
#endif
}

/* Returns the smaller of a and b in each lane, and a where they are equal or one of them is not a number. */
MPM_INLINE MPMReal MPMMin(MPMReal a, MPMReal b)
{
#if MPM_WIDTH == 8
  return _mm512_min_pd(b, a);
#elif MPM_WIDTH == 4
  return _mm256_min_pd(b, a);
#else
  return MPMSelect(a > b, b, a);
#endif
}

/* Returns the absolute value in each lane, by clearing the bit of the sign. */
MPM_INLINE MPMReal MPMAbs(MPMReal a)
{
  MPMBits bits;

  memcpy(&bits, &a, sizeof bits);
  bits &= 0x7fffffffffffffffULL;
  memcpy(&a, &bits, sizeof a);
  return a;
}

/* Returns the square root in each lane. IEEE 754 defines its rounding, so its bits are the same everywhere. */
MPM_INLINE MPMReal MPMSqrt(MPMReal a)
{
#if MPM_WIDTH == 1
  return PetscSqrtReal(a);
#else
  for (int l = 0; l < MPM_WIDTH; l++) a[l] = __builtin_sqrt(a[l]);
  return a;
#endif
}

/* Returns the largest integer <= a in each lane, for |a| < 2^51 and not -0, without a library call: where there is no
   instruction, adding 1.5 2^52 rounds to the nearest integer. */
MPM_INLINE MPMReal MPMFloor(MPMReal a)
{
#if MPM_WIDTH == 8
  return _mm512_roundscale_pd(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
#elif MPM_WIDTH == 4
  return _mm256_floor_pd(a);
#else
  const MPMReal nearest = (a + 6755399441055744.0) - 6755399441055744.0;

  return nearest - MPMSelect(nearest > a, MPMAll(1), MPMAll(0));
#endif
}

/* Returns a * b + c, rounded once. Where the processor has no instruction for it, the library computes it, with the
   same result but slowly. */
MPM_INLINE MPMReal MPMFma(MPMReal a, MPMReal b, MPMReal c)
{
#if MPM_WIDTH == 8
  return _mm512_fmadd_pd(a, b, c);
#elif MPM_WIDTH == 4
  return _mm256_fmadd_pd(a, b, c);
#elif MPM_WIDTH == 1
  return __builtin_fma(a, b, c);
#else
  for (int l = 0; l < MPM_WIDTH; l++) c[l] = __builtin_fma(a[l], b[l], c[l]);
  return c;
#endif
}

/* Returns the bits of a / b in fewer cycles, if inverse is 1 / b rounded: a * inverse is wrong by at most two units in
   the last place; the first correction by the remainder makes that less than one, the second rounds as the quotient is
   rounded (Markstein 1990), unless a is so small that the remainder is not a normal number. */
MPM_INLINE MPMReal MPMDivide(MPMReal a, PetscReal b, PetscReal inverse)
{
#if MPM_WIDTH == 2 /* where a fused multiply-add is a call of the library */
  (void)inverse;
  return a / b;
#else
  MPMReal q = a * inverse;

  q = MPMFma(MPMFma(-q, MPMAll(b), a), MPMAll(inverse), q);
  return MPMFma(MPMFma(-q, MPMAll(b), a), MPMAll(inverse), q);
#endif
}

/* A vector at any address. Its type is made of reals, so the compiler may assume that writing one changes no data of
   another type. */
#if MPM_WIDTH == 1
typedef PetscReal MPMRealAt;
#else
typedef PetscReal MPMRealAt __attribute__((vector_size(8 * MPM_WIDTH), aligned(8)));
#endif

/* Reads MPM_WIDTH reals that follow each other in memory. */
MPM_INLINE MPMReal MPMRead(const PetscReal *from)
{
  return *(const MPMRealAt *)from;
}

/* Writes MPM_WIDTH reals one after the other to memory. */
MPM_INLINE void MPMWrite(PetscReal *to, MPMReal a)
{
  *(MPMRealAt *)to = a;
}

/* Writes the lanes first .. last-1 alone; the other numbers at `to` belong to other particles and stay. */
MPM_INLINE void MPMWritePart(PetscReal *to, MPMReal a, PetscInt first, PetscInt last)
{
  if (first <= 0 && last >= MPM_WIDTH) MPMWrite(to, a);
#if MPM_WIDTH > 1
  else
    for (PetscInt l = 0; l < MPM_WIDTH; l++)
      if (l >= first && l < last) to[l] = a[l];
#endif
}

/* Returns the largest lane. */
MPM_INLINE PetscReal MPMLargest(MPMReal a)
{
#if MPM_WIDTH == 1
  return a;
#else
  PetscReal most = a[0];

  for (int l = 1; l < MPM_WIDTH; l++) most = PetscMax(most, a[l]);
  return most;
#endif
}

#endif
