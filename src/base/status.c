/* status.c - how the findings of a step are noted and merged; status.h describes them. */
#include "base/status.h"

/* Sets all findings to none. */
void MPMStatusReset(MPMStatus *s)
{
  PetscMemzero(s, sizeof *s);
}

/* Returns whether the state is not valid. */
PetscBool MPMStatusIsBad(const MPMStatus *s)
{
  return s->bad != MPM_OK && s->bad != MPM_GONE;
}

void MPMStatusNote(MPMStatus *s, MPMBad bad, PetscInt64 id, PetscInt dim, const PetscReal x[], PetscReal J)
{
  if (s->bad != MPM_OK && (s->bad < bad || (s->bad == bad && s->id <= id))) return;
  s->bad = bad;
  s->id  = id;
  s->J   = J;
  for (PetscInt d = 0; d < dim; d++) s->x[d] = x[d];
}

/* Merges the findings of `other` into s: maxima, sums of integers, and of the bad conditions the gravest with its
   smallest id. The sequence of merging does not change the result. */
void MPMStatusMerge(MPMStatus *s, const MPMStatus *other)
{
  s->v2 = PetscMax(s->v2, other->v2);
  s->c2 = PetscMax(s->c2, other->c2);
  s->moved += other->moved;
  s->left += other->left;
  s->hops   = PetscMax(s->hops, other->hops);
  s->asked  = PetscMax(s->asked, other->asked);
  s->opened = PetscMax(s->opened, other->opened);
  s->most   = PetscMax(s->most, other->most);
  s->n += other->n;
  s->ids = (PetscInt64)((uint64_t)s->ids + (uint64_t)other->ids); /* modulo 2^64 */
  if (other->bad != MPM_OK &&
      (s->bad == MPM_OK || other->bad < s->bad || (other->bad == s->bad && other->id < s->id))) {
    s->bad = other->bad;
    s->id  = other->id;
    s->J   = other->J;
    PetscMemcpy(s->x, other->x, sizeof s->x);
  }
}
