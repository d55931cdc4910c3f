/* exact_sum.c - an exact sum of doubles: a fixed-point number of 2176 bits, kept in words of 32 bits (a
   superaccumulator, Kulisch 2002). Integer addition gives the same result in any sequence, so totals are the same on
   any number of processes. */
#include "base/exact_sum.h"

/* Sets the sum to 0. */
void MPMSumZero(MPMSum *s)
{
  memset(s, 0, sizeof *s);
}

/* Moves what exceeds 32 bits in each word to the next; afterwards all words but the last are in [0, 2^32). */
static void Carry(MPMSum *s)
{
  for (int w = 0; w + 1 < MPM_SUM_WORDS; w++) {
    const PetscInt64 carry = s->word[w] >> 32;

    s->word[w] -= carry * ((PetscInt64)1 << 32);
    s->word[w + 1] += carry;
  }
  s->pending = 0;
}

/* Adds x, which must be finite. A double is +-m 2^(e-1075), where m has 53 bits: these fall into three words, from bit
   e on. */
void MPMSumAdd(MPMSum *s, PetscReal x)
{
  uint64_t bits, m;
  int      e, shift, w;

  memcpy(&bits, &x, sizeof bits);
  e = (int)((bits >> 52) & 0x7ff);
  m = bits & 0xfffffffffffffULL;
  if (e)
    m |= 1ULL << 52;
  else
    e = 1;
  w     = e / 32;
  shift = e % 32;
  {
    const uint64_t   lo = (m & 0xffffffffULL) << shift, hi = (m >> 32) << shift;
    const PetscInt64 a = (PetscInt64)(lo & 0xffffffffULL), b = (PetscInt64)((lo >> 32) + (hi & 0xffffffffULL)),
                     c    = (PetscInt64)(hi >> 32);
    const PetscInt64 sign = bits >> 63 ? -1 : 1;

    s->word[w] += sign * a;
    s->word[w + 1] += sign * b;
    s->word[w + 2] += sign * c;
  }
  if (++s->pending == 1 << 29) Carry(s);
}

/* Adds up each of n sums over the processes of comm; all processes get the results. Collective on comm. */
PetscErrorCode MPMSumReduce(MPMSum *s, PetscInt n, MPI_Comm comm)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n; k++) {
    Carry(&s[k]);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s[k].word, MPM_SUM_WORDS, MPIU_INT64, MPI_SUM, comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the sum as a double, which differs from the exact sum by less than one unit in the last place. */
PetscReal MPMSumValue(MPMSum *s)
{
  PetscReal value = 0;
  PetscBool negative;

  Carry(s);
  negative = s->word[MPM_SUM_WORDS - 1] < 0;
  if (negative) {
    for (int w = 0; w < MPM_SUM_WORDS; w++) s->word[w] = -s->word[w];
    Carry(s);
  }
  for (int w = 0; w < MPM_SUM_WORDS; w++) value += ldexp((PetscReal)s->word[w], 32 * w - 1075); /* smallest first */
  if (negative)
    for (int w = 0; w < MPM_SUM_WORDS; w++) s->word[w] = -s->word[w];
  return negative ? -value : value;
}
