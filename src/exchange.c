/* exchange.c - the table of ways to run the step, and the status that they merge.                                     */
#include "mpm.h"

#define MPM_EXCHANGE(name, what) extern const MPMExchangeType MPMExchange_##name;
#include "exchange.def"
#undef MPM_EXCHANGE

const MPMExchangeType *const MPMExchangeTypes[] = {
#define MPM_EXCHANGE(name, what) &MPMExchange_##name,
#include "exchange.def"
#undef MPM_EXCHANGE
  NULL
};

void MPMStatusReset(MPMStatus *s)
{
  PetscMemzero(s, sizeof *s);
}

/* Maxima, sums of integers, and the bad condition of the smallest id: any order of merging gives the same. */
void MPMStatusMerge(MPMStatus *s, const MPMStatus *other)
{
  s->v2 = PetscMax(s->v2, other->v2);
  s->c2 = PetscMax(s->c2, other->c2);
  s->moved += other->moved;
  if (other->bad != MPM_OK && (s->bad == MPM_OK || other->id < s->id)) {
    s->bad = other->bad;
    s->id  = other->id;
    s->J   = other->J;
    PetscMemcpy(s->x, other->x, sizeof s->x);
  }
}
