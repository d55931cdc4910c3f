/* lanes.h - numbers that are computed for several particles at a time: MPMReal is a vector of MPM_WIDTH reals, one
   particle a lane, by the vector types of gcc and clang: +, -, *, / and comparisons read as for scalars and act on each
   lane.

   The makefile compiles the files that need speed for 8, 4 and 2 lanes, each with the instructions for just that width
   (a vector wider than the processor's is split through memory, many times slower); transfer.c picks at the start.
   Everywhere else MPM_WIDTH is 1 and MPMReal is a plain PetscReal, so that the same functions serve single particles. A
   lane sees the same operations in every width and no compiler may choose to fuse any (-ffp-contract=off): the bits are
   the same in all. Where a + b * c shall be fused, MPMFma says so; since gcc makes no vector instruction of the fma of
   each lane, transfer_sums.c is compiled to fuse every product with its sum, and has none that is not to be. */
#ifndef MPM_LANES_H
#define MPM_LANES_H

#include "base/base.h"

#ifndef MPM_WIDTH
#define MPM_WIDTH 1
#endif

/* name_8 where MPM_WIDTH is 8, and so on. */
#define MPM_LANES_NAME(name)          MPM_LANES_JOIN(name, MPM_WIDTH)
#define MPM_LANES_JOIN(name, width)   MPM_LANES_JOIN_AGAIN(name, width)
#define MPM_LANES_JOIN_AGAIN(name, w) name##_##w

/* MPMMask is what comparisons give: combine by & and |, and choose by MPMSelect. MPMBits: the bits of reals, or a set
   of particles. */
#if MPM_WIDTH == 1
typedef PetscReal MPMReal;
typedef int       MPMMask;
typedef uint64_t  MPMBits;
#else
typedef PetscReal MPMReal __attribute__((vector_size(8 * MPM_WIDTH)));
typedef int64_t   MPMMask __attribute__((vector_size(8 * MPM_WIDTH)));
typedef uint64_t  MPMBits __attribute__((vector_size(8 * MPM_WIDTH)));
#endif

/* m ? a : b */
MPM_INLINE MPMReal MPMSelect(MPMMask m, MPMReal a, MPMReal b)
{
#if MPM_WIDTH == 1
  return m ? a : b;
#else
  return (MPMReal)((m & (MPMMask)a) | (~m & (MPMMask)b));
#endif
}

/* The same number in all lanes. */
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

/* True in no lane. */
MPM_INLINE MPMMask MPMNone(void)
{
  return MPMAll(0) != MPMAll(0);
}

MPM_INLINE MPMReal MPMMax(MPMReal a, MPMReal b)
{
  return MPMSelect(a < b, b, a); /* a where b is not a number */
}

MPM_INLINE MPMReal MPMMin(MPMReal a, MPMReal b)
{
  return MPMSelect(a > b, b, a);
}

MPM_INLINE MPMReal MPMAbs(MPMReal a)
{
  MPMBits bits;

  memcpy(&bits, &a, sizeof bits);
  bits &= 0x7fffffffffffffffULL;
  memcpy(&a, &bits, sizeof a);
  return a;
}

/* Rounded rightly, as the standard of floating point has it: the same bits everywhere. */
MPM_INLINE MPMReal MPMSqrt(MPMReal a)
{
#if MPM_WIDTH == 1
  return PetscSqrtReal(a);
#else
  for (int l = 0; l < MPM_WIDTH; l++) a[l] = __builtin_sqrt(a[l]);
  return a;
#endif
}

/* Largest integer <= a, |a| < 2^51, without a library call: adding 1.5 2^52 rounds to the nearest one. */
MPM_INLINE MPMReal MPMFloor(MPMReal a)
{
  const MPMReal nearest = (a + 6755399441055744.0) - 6755399441055744.0;

  return nearest - MPMSelect(nearest > a, MPMAll(1), MPMAll(0));
}

/* a * b + c, rounded once. Both compilers make one instruction of it; where the processor has none it is a call of
   the library, which is right and slow. */
MPM_INLINE MPMReal MPMFma(MPMReal a, MPMReal b, MPMReal c)
{
#if defined(MPM_CONTRACT) && defined(__FMA__) && !defined(__clang__) /* compiled with -ffp-contract=fast */
  return a * b + c;
#elif MPM_WIDTH == 1
  return __builtin_fma(a, b, c);
#else
  for (int l = 0; l < MPM_WIDTH; l++) c[l] = __builtin_fma(a[l], b[l], c[l]);
  return c;
#endif
}

/* Vectors at any address: of reals, so that a compiler knows that writing one changes no other type. */
#if MPM_WIDTH == 1
typedef PetscReal MPMRealAt;
#else
typedef PetscReal MPMRealAt __attribute__((vector_size(8 * MPM_WIDTH), aligned(8)));
#endif

MPM_INLINE MPMReal MPMRead(const PetscReal *from)
{
  return *(const MPMRealAt *)from;
}

MPM_INLINE void MPMWrite(PetscReal *to, MPMReal a)
{
  *(MPMRealAt *)to = a;
}

/* A set of particles 0 .. 63, a bit each, whose parts are in the lanes; adds those lanes of a vector that begins at
   particle l in which m is true. */
MPM_INLINE MPMBits MPMCollect(MPMMask m, PetscInt l, MPMBits set)
{
#if MPM_WIDTH == 1
  return m && l < 64 ? set | (uint64_t)1 << l : set;
#elif MPM_WIDTH == 8
  return set | ((MPMBits)m & ((MPMBits){1, 2, 4, 8, 16, 32, 64, 128} << l));
#elif MPM_WIDTH == 4
  return set | ((MPMBits)m & ((MPMBits){1, 2, 4, 8} << l));
#else
  return set | ((MPMBits)m & ((MPMBits){1, 2} << l));
#endif
}

/* Lists the particles of a set that are below n > 0, and how many these are. */
MPM_INLINE PetscInt MPMList(MPMBits set, PetscInt n, PetscInt *list)
{
  uint64_t bits = 0;
  PetscInt k    = 0;

#if MPM_WIDTH == 1
  bits = set;
#else
  for (int l = 0; l < MPM_WIDTH; l++) bits |= set[l];
#endif
  for (bits &= ~(uint64_t)0 >> (64 - n); bits; bits &= bits - 1) list[k++] = __builtin_ctzll(bits);
  return k;
}

/* Stores lanes first .. last-1 alone; the others of `to` belong to somebody else. */
MPM_INLINE void MPMWritePart(PetscReal *to, MPMReal a, PetscInt first, PetscInt last)
{
  if (first <= 0 && last >= MPM_WIDTH) MPMWrite(to, a);
#if MPM_WIDTH > 1
  else
    for (PetscInt l = 0; l < MPM_WIDTH; l++)
      if (l >= first && l < last) to[l] = a[l];
#endif
}

/* Not m. Which lanes of a vector that begins at l belong to first .. last-1? Is it true in any lane? The largest
   lane. */
#if MPM_WIDTH == 1
MPM_INLINE MPMMask MPMNot(MPMMask m)
{
  return !m;
}

MPM_INLINE MPMMask MPMBetween(PetscInt l, PetscInt first, PetscInt last)
{
  return first <= l && l < last;
}

MPM_INLINE PetscBool MPMAny(MPMMask m)
{
  return m ? PETSC_TRUE : PETSC_FALSE;
}

MPM_INLINE PetscReal MPMLargest(MPMReal a)
{
  return a;
}
#else
MPM_INLINE MPMMask MPMNot(MPMMask m)
{
  return ~m;
}

MPM_INLINE MPMMask MPMBetween(PetscInt l, PetscInt first, PetscInt last)
{
  MPMReal lane = MPMAll(0);

  if (first <= l && l + MPM_WIDTH <= last) return lane == lane; /* as a rule */
  for (int k = 0; k < MPM_WIDTH; k++) lane[k] = k;
  return (lane >= MPMAll((PetscReal)(first - l))) & (lane < MPMAll((PetscReal)(last - l)));
}

MPM_INLINE PetscBool MPMAny(MPMMask m)
{
  int64_t any = 0;

  for (int l = 0; l < MPM_WIDTH; l++) any |= m[l];
  return any ? PETSC_TRUE : PETSC_FALSE;
}

MPM_INLINE PetscReal MPMLargest(MPMReal a)
{
  PetscReal most = a[0];

  for (int l = 1; l < MPM_WIDTH; l++) most = PetscMax(most, a[l]);
  return most;
}
#endif

#endif
