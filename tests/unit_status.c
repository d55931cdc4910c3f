/* unit_status.c - MPMStatusMerge is commutative and associative and keeps the gravest condition's smallest id, so that
   a run's status does not depend on the order in which patches and processes report. (A particle is on one process: ids
   are distinct.)       */
#include "base/status.h"
#include "unit.h"

static MPMStatus Random(PetscInt64 id)
{
  MPMStatus s;

  MPMStatusReset(&s);
  s.v2    = UnitReal(0, 10);
  s.c2    = UnitInt(4) ? UnitReal(0, 10) : 3; /* equal ones too */
  s.moved = UnitInt(1000);
  s.left  = UnitInt(1000);
  s.n     = UnitInt(1000);
  s.ids   = (PetscInt64)UnitBits(); /* a sum, modulo 2^64 */
  s.hops  = UnitInt(10);
  s.most  = UnitInt(1000);
  s.asked = UnitInt(5) == 0;
  if (UnitInt(2)) {
    s.bad = (MPMBad)(1 + UnitInt(MPM_NUM_BAD - 1));
    s.id  = id;
    for (int d = 0; d < 3; d++) s.x[d] = UnitReal(-1, 1);
    s.J = UnitReal(-1, 1);
  }
  return s;
}

static int Equal(const MPMStatus *a, const MPMStatus *b)
{
  return a->bad == b->bad && a->id == b->id && !memcmp(a->x, b->x, sizeof a->x) && a->J == b->J && a->v2 == b->v2 &&
         a->c2 == b->c2 && a->moved == b->moved && a->left == b->left && a->n == b->n && a->ids == b->ids &&
         a->hops == b->hops && a->most == b->most && a->asked == b->asked;
}

static MPMStatus Merge(MPMStatus a, MPMStatus b)
{
  MPMStatusMerge(&a, &b);
  return a;
}

int main(void)
{
  for (int round = 0; round < 20000; round++) {
    const PetscInt64 far = round % 3 ? 0 : (PetscInt64)1 << 40; /* ids beyond 32 bits too */
    PetscInt64       id[3];
    MPMStatus        s[3], none, all[6];
    int              k = 0;

    UnitContext("round %d", round);
    id[0] = UnitInt(100);
    id[1] = 100 + UnitInt(100);
    id[2] = 200 + UnitInt(100) + far;
    for (int i = 2; i > 0; i--) { /* any order of the ids, zero among them */
      const int        j = UnitInt(i + 1);
      const PetscInt64 t = id[i];
      id[i]              = id[j];
      id[j]              = t;
    }
    for (int i = 0; i < 3; i++) s[i] = Random(id[i]);
    MPMStatusReset(&none);
    for (int i = 0; i < 3; i++) {
      const MPMStatus left = Merge(none, s[i]), right = Merge(s[i], none), twice = Merge(s[i], s[(i + 1) % 3]),
                      swapped = Merge(s[(i + 1) % 3], s[i]);

      CHECK(Equal(&left, &s[i]));
      CHECK(Equal(&right, &s[i]));
      CHECK(Equal(&twice, &swapped));
    }
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        if (i != j) all[k++] = Merge(Merge(s[i], s[j]), s[3 - i - j]);
    for (k = 1; k < 6; k++) CHECK(Equal(&all[k], &all[0]));
    {
      const MPMStatus right = Merge(s[0], Merge(s[1], s[2]));
      int             first = -1;

      CHECK(Equal(&right, &all[0]));
      for (int i = 0; i < 3; i++)
        if (s[i].bad != MPM_OK &&
            (first < 0 || s[i].bad < s[first].bad || (s[i].bad == s[first].bad && s[i].id < s[first].id)))
          first = i;
      CHECK_EQ(all[0].bad, first < 0 ? MPM_OK : s[first].bad);
      if (first >= 0) {
        CHECK_EQ(all[0].id, s[first].id);
        CHECK_EQ(all[0].J, s[first].J);
        CHECK_SAME(all[0].x, s[first].x, sizeof s[first].x);
      }
      CHECK_EQ(all[0].moved, s[0].moved + s[1].moved + s[2].moved);
      CHECK_EQ(all[0].left, s[0].left + s[1].left + s[2].left);
      CHECK_EQ(all[0].n, s[0].n + s[1].n + s[2].n);
      CHECK((uint64_t)all[0].ids == (uint64_t)s[0].ids + (uint64_t)s[1].ids + (uint64_t)s[2].ids);
      CHECK_EQ(all[0].v2, PetscMax(s[0].v2, PetscMax(s[1].v2, s[2].v2)));
      CHECK_EQ(all[0].hops, PetscMax(s[0].hops, PetscMax(s[1].hops, s[2].hops)));
      CHECK_EQ(all[0].most, PetscMax(s[0].most, PetscMax(s[1].most, s[2].most)));
      CHECK_EQ(all[0].asked, PetscMax(s[0].asked, PetscMax(s[1].asked, s[2].asked)));
      CHECK_EQ(all[0].c2, PetscMax(s[0].c2, PetscMax(s[1].c2, s[2].c2)));
    }
  }
  return UnitEnd();
}
