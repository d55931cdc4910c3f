/* contact.c - what bodies that meet do to each other's nodes. The nodes that have matter of both are put together in columns,
   which follow an axis to which the normal inclines (contact_find.c). If the matter of both sides of a column would come
   nearer to each other than its gap allows, it gets an impulse at the surface, and the opposite one on the other side:
   along the normal of the column, and by friction across.

   The surface of side s has for node k the weight N_sk = - sum_p V_p n_s . d phi_kp/dx, n_s into its matter: by it the
   matter ends with the velocity w_s = sum_k N_sk v_sk, where sum_k N_sk = 1, and an impulse p there is the part N_sk p of
   node k, as a uniform stress has it. The relative velocity changes by p sum_sk N_sk^2/m_sk. A node alone would also hold
   the matter behind the surface, over the reach of a stencil.

   Columns have nodes in common, so their impulses are found one after the other in rounds, by the velocities that the
   others have left; impulses along normals only push, and friction stays within its cone. Every process does this for all
   columns, with the same bits: of the sums over processes all terms but one are 0. docs/method.md has the formulas
   (Contact). */
#include "base/algebra.h"
#include "physics/wall.h"
#include "step/friction.h"
#include "step/step.h"

#define ROUNDS  200  /* at most, */
#define NUMBERS 8    /* of a site that processes exchange: mass, that along the first axis, velocity, acceleration */
#define QUIET   1e-6 /* until one changes velocities by less than this part of the largest change in a round */

PetscErrorCode MPMContactsDestroy(MPMCore *core)
{
  MPMContacts *c = core->contacts;

  PetscFunctionBeginUser;
  if (!c) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(c->pair));
  PetscCall(PetscFree(c->node));
  PetscCall(PetscFree(c->site));
  PetscCall(PetscFree(c->part));
  PetscCall(PetscFree(c->column));
  PetscCall(PetscFree(c->tiles.bits));
  PetscCall(PetscFree(c->tiles.box));
  PetscCall(PetscFree(c->tiles.beside));
  PetscCall(PetscFree(core->contacts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number in the patch of a site if this process owns it, else -1. */
static PetscInt Own(const MPMPatch *patch, const MPMContactSite *site)
{
  PetscInt at = 0;

  for (PetscInt d = 2; d >= 0; d--) {
    const PetscInt i = site->ijk[d] + MPMGridFirst(patch->grid, d, site->copy);

    if (i < patch->own_lo[d] || i >= patch->own_lo[d] + patch->own_n[d]) return -1;
    at = at * patch->n[d] + i - patch->lo[d];
  }
  return at;
}

/* Collects mass and velocity of all sites. Collective on exchange.data. */
static PetscErrorCode Motion(MPMCore *core)
{
  const MPMPatch *patch = &core->exchange.patch;
  MPMContacts    *c     = core->contacts;
  const PetscInt  dim   = core->grid.dim;
  PetscMPIInt     count;
  PetscReal      *sum;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(NUMBERS * c->nsites, &sum));
  for (PetscInt k = 0; k < c->nsites; k++) {
    const PetscInt at = Own(patch, &c->site[k]);
    PetscReal     *to = sum + NUMBERS * k;

    if (at < 0 || !(patch->node[at].m > 0)) continue;
    to[0] = patch->node[at].m;
    to[1] = MPMNodeMass(patch->grid, &patch->node[at], c->site[k].ijk[0], 0);
    for (PetscInt d = 0; d < dim; d++) {
      to[2 + d] = patch->motion[at * MPM_MOTION_NC(dim) + d];
      to[5 + d] = patch->motion[at * MPM_MOTION_NC(dim) + dim + d];
    }
  }
  PetscCall(PetscMPIIntCast(NUMBERS * c->nsites, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, count, MPIU_REAL, MPI_SUM, core->exchange.data));
  for (PetscInt k = 0; k < c->nsites; k++) {
    c->site[k].changes = PETSC_FALSE;
    for (PetscInt d = 0; d < 3; d++) {
      c->site[k].m[d] = sum[NUMBERS * k + !d];
      c->site[k].v[d] = c->site[k].was[d] = sum[NUMBERS * k + 2 + d];
      c->site[k].a[d]                     = sum[NUMBERS * k + 5 + d];
    }
  }
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the site of a part on a side if it has mass and a share there, else NULL. */
static MPMContactSite *SiteOf(const MPMContacts *c, const MPMContactPart *part, int side)
{
  const PetscInt k = c->node[part->node].site[side];

  return k >= 0 && c->site[k].m[1] > 0 && part->share[side] > 0 ? &c->site[k] : NULL;
}

/* Returns the rigid body of a column if it is free and yields in this phase, or NULL. */
static MPMRigid *Free(const MPMContacts *c, const MPMContactColumn *col, PetscBool yield)
{
  MPMRigid *rigid = yield ? c->pair[col->pair].rigid : NULL;

  return rigid && rigid->free ? rigid : NULL;
}

/* Sets v [3] to the relative velocity of b and a at the surface, m/s. */
static void Relative(const MPMCore *core, const MPMContactColumn *col, PetscReal v[])
{
  const MPMContacts *c     = core->contacts;
  const MPMRigid    *rigid = c->pair[col->pair].rigid;

  for (PetscInt d = 0; d < 3; d++) v[d] = 0;
  if (rigid) MPMRigidVelocity(rigid, core->grid.dim, col->at, v);
  for (PetscInt d = 0; d < 3; d++) v[d] = -v[d];
  for (PetscInt k = col->first; k < col->last; k++)
    for (int side = 0; side < 2; side++) {
      const MPMContactSite *site = SiteOf(c, &c->part[k], side);

      for (PetscInt d = 0; d < 3 && site; d++) v[d] += (side ? 1 : -1) * c->part[k].share[side] * site->v[d];
    }
}

/* Gives the sites of a column an impulse J [3] on b, N s, and its opposite on a; free: to a rigid body, or NULL. */
static void Give(MPMContacts *c, const MPMContactColumn *col, const PetscReal J[], MPMRigid *free)
{
  const PetscReal back[3] = {-J[0], -J[1], -J[2]};

  if (free) MPMRigidKick(free, col->at, back);
  for (PetscInt k = col->first; k < col->last; k++)
    for (int side = 0; side < 2; side++) {
      MPMContactSite *site = SiteOf(c, &c->part[k], side);

      for (PetscInt d = 0; d < 3 && site; d++)
        site->v[d] += (side ? 1 : -1) * c->part[k].share[side] * J[d] / site->m[d];
    }
}

/* Returns by how much a site with this share yields to an impulse, 1/kg, along a unit vector whose component along the first
   axis is e: in bodies of revolution nodes have another mass along r. */
static PetscReal Yields(const MPMContactSite *site, PetscReal share, PetscReal e)
{
  if (site->m[0] == site->m[1]) return PetscSqr(share) / site->m[1];
  return PetscSqr(share) * (e * e / site->m[0] + (1 - e * e) / site->m[1]);
}

/* Makes a column ready for a phase: no impulse yet, and what one changes; free: a rigid body that it changes too, or NULL. */
static void Begin(const MPMContacts *c, MPMContactColumn *col, const MPMRigid *free)
{
  col->press = col->inverse = col->across = 0;
  for (PetscInt d = 0; d < 3; d++) col->brake[d] = 0;
  for (PetscInt k = col->first; k < col->last; k++)
    for (int side = 0; side < 2; side++) {
      const MPMContactSite *site = SiteOf(c, &c->part[k], side);

      if (!site) continue;
      col->inverse += Yields(site, c->part[k].share[side], col->n[0]);
      col->across += Yields(site, c->part[k].share[side], col->n[1]);
    }
  if (free && col->inverse > 0) col->inverse += MPMRigidYields(free, col->at, col->n);
}

/* Changes the impulses of a column by what is missing now. decides: it only pushes, and may leave the matter alone; else it
   does what the advance has decided. rubs: with friction. free: a rigid body that yields, or NULL. Returns by how much the
   relative velocity changes, m/s. */
static PetscReal Act(MPMCore *core, MPMContactColumn *col, PetscBool decides, PetscBool rubs, MPMRigid *free)
{
  MPMContacts    *c  = core->contacts;
  const PetscReal mu = c->pair[col->pair].mu;
  PetscReal       v[3], J[3], w = 0, more;

  if (!(col->inverse > 0) || (!decides && !col->held)) return 0;
  Relative(core, col, v);
  for (PetscInt d = 0; d < 3; d++) w += col->n[d] * v[d];
  more = (col->least - w) / col->inverse;
  if (decides) more = PetscMax(more, -col->press);
  col->press += more;
  for (PetscInt d = 0; d < 3; d++) J[d] = more * col->n[d];
  if (rubs && mu > 0 && !col->slips) {
    PetscReal brake[3], inverse = col->across;

    if (free) {
      PetscReal t[3], slide = 0;

      for (PetscInt d = 0; d < 3; d++) {
        t[d] = v[d] - w * col->n[d];
        slide += t[d] * t[d];
      }
      for (PetscInt d = 0; d < 3 && slide > 0; d++) t[d] /= PetscSqrtReal(slide);
      if (slide > 0) inverse += MPMRigidYields(free, col->at, t);
    }
    for (PetscInt d = 0; d < 3; d++) brake[d] = col->brake[d] - (v[d] - w * col->n[d]) / inverse;
    MPMFrictionSet(mu, col->press, brake, col->brake, J);
  }
  Give(c, col, J, free);
  return col->inverse * (PetscAbsReal(J[0]) + PetscAbsReal(J[1]) + PetscAbsReal(J[2]));
}

/* Gives the nodes of pairs that are glued the same velocity; before contact acts as the one that they have, with the same
   acceleration. */
static void Glue(MPMContacts *c, PetscBool before)
{
  for (PetscInt k = 0; k < c->nnodes; k++) {
    MPMContactSite *a = &c->site[c->node[k].site[0]], *b = &c->site[c->node[k].site[1]];

    if (!c->pair[c->node[k].pair].glued || !(a->m[1] > 0 && b->m[1] > 0)) continue;
    for (PetscInt d = 0; d < 3; d++) {
      a->v[d] = b->v[d] = (a->m[d] * a->v[d] + b->m[d] * b->v[d]) / (a->m[d] + b->m[d]);
      if (before) a->was[d] = b->was[d] = a->v[d];
      if (before) a->a[d] = b->a[d] = (a->m[d] * a->a[d] + b->m[d] * b->a[d]) / (a->m[d] + b->m[d]);
    }
    a->changes = b->changes = PETSC_TRUE;
  }
}

/* Gives the nodes that are tied to a rigid body its velocity there. Returns the largest change, m/s. */
static PetscReal Hold(MPMCore *core)
{
  MPMContacts *c    = core->contacts;
  PetscReal    most = 0, x[3], V[3];

  for (MPMContactNode *q = c->node; q < c->node + c->nnodes; q++) {
    MPMContactSite *site = &c->site[q->site[1]];

    if (!q->tied || !(site->m[1] > 0)) continue;
    MPMGridNodeAt(&core->grid, q->ijk, x);
    MPMRigidVelocity(c->pair[q->pair].rigid, core->grid.dim, x, V);
    for (PetscInt d = 0; d < core->grid.dim; d++) {
      most = PetscMax(most, PetscAbsReal(V[d] - site->v[d]));
      q->given[d] += site->m[d] * (V[d] - site->v[d]);
      site->v[d] = V[d];
    }
    site->changes = PETSC_TRUE;
  }
  return most;
}

/* Gives own nodes the velocities of their sites, and in the advance the accelerations; walls hold them all the same. */
static void Take(MPMCore *core, PetscBool advance)
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMGrid  *grid  = &core->grid;
  const PetscInt  dim   = grid->dim;

  for (const MPMContactSite *s = core->contacts->site; s < core->contacts->site + core->contacts->nsites; s++) {
    const PetscInt at      = Own(patch, s);
    PetscReal     *v       = patch->motion + at * MPM_MOTION_NC(dim);
    PetscInt       ijk[3]  = {0};
    PetscBool      changes = s->changes;

    if (at < 0 || !(s->m[1] > 0)) continue;
    for (PetscInt d = 0; d < dim; d++) {
      ijk[d] = s->ijk[d] + MPMGridFirst(grid, d, s->copy);
      if (s->v[d] != s->was[d]) changes = PETSC_TRUE;
    }
    if (!changes) continue;
    for (PetscInt d = 0; d < dim; d++) v[d] = s->v[d];
    (void)MPMWallsApply(core->params.walls->given, grid, ijk, 0, v);
    for (PetscInt d = 0; d < dim && advance; d++) v[dim + d] = s->a[d] + (v[d] - s->was[d]) / core->params.kick;
  }
}

/* Sets V [3] to the velocity of a rigid body at x: of a free one the mean of those before the step and after it. */
static void MeanVelocity(MPMRigid *r, PetscInt dim, const PetscReal x[], PetscReal V[])
{
  PetscReal velocity[3], spin[3];
  MPMRigid  mean = *r;

  for (PetscInt d = 0; d < 3; d++) {
    velocity[d] = 0.5 * (r->velocity[d] + (r->free ? r->before[d] : r->velocity[d]));
    spin[d]     = 0.5 * (r->spin[d] + (r->free ? r->before[3 + d] : r->spin[d]));
  }
  mean.velocity = velocity;
  mean.spin     = spin;
  MPMRigidVelocity(&mean, dim, x, V);
}

/* Returns whether a phase is the last correction of afmpm, whose impulses particles take like those of the advance. */
static PetscBool IsLastCorrection(MPMCore *core, const MPMPhase *phase)
{
  MPMContacts *c = core->contacts;

  if (phase->nodes == MPMNodesAdvance) c->corrections = 0;
  return phase->nodes == MPMNodesCorrect && ++c->corrections == core->params.order - 1;
}

/* Adds an impulse J [3], N s, of a rigid body on the matter at x [3] to what it has done; returns its work, J. */
static PetscReal AddTo(MPMRigid *rigid, PetscInt dim, const PetscReal x[], const PetscReal J[])
{
  PetscReal V[3], r[3], torque[3], by = 0;

  MeanVelocity(rigid, dim, x, V);
  for (PetscInt d = 0; d < 3; d++) {
    r[d] = x[d] - rigid->pivot[d] - rigid->place[d];
    by += J[d] * V[d];
  }
  MPMCross(r, J, torque);
  for (PetscInt d = 0; d < 3; d++) {
    rigid->impulse[d] += J[d];
    rigid->torque[d] += torque[d];
  }
  *rigid->work += by;
  return by;
}

/* Adds up what rigid bodies have given the matter. The nodes count it as friction: what moving bodies do is work, and what
   free ones give is no loss. What pushes particles of fluids out of a body counts as the relaxation of volumes does. */
static void Account(MPMCore *core, PetscBool advance)
{
  const MPMContacts *c       = core->contacts;
  const PetscBool    relaxes = core->volumes.sound > 0; /* with that term */
  PetscReal          work = 0, taken = 0, pushed = 0;
  PetscMPIInt        rank;

  for (const MPMContactColumn *col = c->column; col < c->column + c->ncolumns; col++) {
    MPMRigid *rigid = c->pair[col->pair].rigid;
    PetscReal J[3], by;

    if (relaxes && c->pair[col->pair].flows) pushed += col->press * PetscMax(0, col->least);
    if (!rigid || (advance ? !(col->press > 0) : col->press == 0)) continue;
    for (PetscInt d = 0; d < 3; d++) J[d] = col->press * col->n[d] + col->brake[d];
    by = AddTo(rigid, core->grid.dim, col->at, J);
    taken += by;
    if (!rigid->free) work += by;
  }
  for (const MPMContactNode *q = c->node; q < c->node + c->nnodes; q++) {
    PetscReal x[3], by;

    if (!q->tied) continue;
    MPMGridNodeAt(&core->grid, q->ijk, x);
    by = AddTo(c->pair[q->pair].rigid, core->grid.dim, x, q->given);
    taken += by;
    work += by; /* it is not free */
  }
  (void)MPI_Comm_rank(core->exchange.data, &rank);
  if (rank || !core->energy.on) return;
  MPMSumAdd(&core->energy.sum[MPM_ENERGY_rigid], work);
  MPMSumAdd(&core->energy.sum[MPM_ENERGY_volumes], pushed);
  MPMSumAdd(&core->energy.sum[MPM_ENERGY_friction], -taken - pushed);
}

/* One round: columns, free rigid bodies at walls, and ties. Returns the largest change of a velocity, m/s. (PetscMax is a
   macro: a function in it would act twice.) */
static PetscReal Round(MPMCore *core, PetscBool decides, PetscBool advance, PetscBool yield)
{
  MPMContacts *c    = core->contacts;
  PetscReal    most = 0, change;

  for (PetscInt k = 0; k < c->ncolumns; k++) {
    change = Act(core, &c->column[k], decides, advance, Free(c, &c->column[k], yield));
    most   = PetscMax(most, change);
  }
  change = yield ? MPMRigidsStand(core) : 0;
  most   = PetscMax(most, change);
  change = Hold(core);
  return PetscMax(most, change);
}

PetscErrorCode MPMContactsAfter(MPMCore *core, const MPMPhase *phase)
{
  const PetscBool advance = phase->nodes == MPMNodesAdvance;
  const PetscBool decides = advance || phase->nodes == MPMNodesVelocity;
  MPMContacts    *c       = core->contacts;
  const PetscBool counts  = IsLastCorrection(core, phase) || advance;
  const PetscBool yield   = counts && core->rigids.free;
  PetscReal       largest = 0, most = 1;

  PetscFunctionBeginUser;
  if (advance && yield) PetscCall(MPMRigidsBegin(core));
  if ((!c->nnodes && !(yield && core->rigids.nsupports)) || phase->nodes == MPMNodesResidual)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Motion(core));
  for (PetscInt k = 0; k < c->ncolumns; k++) Begin(c, &c->column[k], Free(c, &c->column[k], yield));
  for (PetscInt k = 0; k < c->nnodes; k++)
    for (PetscInt d = 0; d < 3; d++) c->node[k].given[d] = 0;
  for (int rounds = 0; rounds < ROUNDS && (!rounds || most > QUIET * largest); rounds++) {
    Glue(c, !rounds);
    most    = Round(core, decides, advance, yield);
    largest = PetscMax(largest, most);
  }
  for (PetscInt k = 0; k < c->ncolumns && advance; k++) c->column[k].held = c->column[k].press > 0;
  if (counts) Account(core, advance);
  Take(core, advance);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares a site with the node ijk [3] of a copy: sites are in the sequence of copies, rows and places in these. */
static int Compare(const MPMContactSite *site, PetscInt copy, const PetscInt ijk[])
{
  if (site->copy != copy) return site->copy < copy ? -1 : 1;
  for (PetscInt d = 2; d >= 0; d--)
    if (site->ijk[d] != ijk[d]) return site->ijk[d] < ijk[d] ? -1 : 1;
  return 0;
}

/* Returns the site at the node ijk [3] of a copy if it has mass, or NULL. */
static const MPMContactSite *FindSite(const MPMContacts *c, PetscInt copy, const PetscInt ijk[])
{
  PetscInt lo = 0, hi = c->nsites;

  while (hi - lo > 0) {
    const PetscInt middle = (lo + hi) / 2;

    if (Compare(&c->site[middle], copy, ijk) < 0)
      lo = middle + 1;
    else
      hi = middle;
  }
  return lo < c->nsites && !Compare(&c->site[lo], copy, ijk) && c->site[lo].m[1] > 0 ? &c->site[lo] : NULL;
}

void MPMContactsGave(const MPMCore *core, const PetscInt ijk[], PetscReal dv[])
{
  const MPMGrid        *grid  = &core->grid;
  const PetscInt        place = MPMGridPlace(grid, ijk[grid->stack]);
  const MPMContactSite *site  = NULL;
  PetscInt              at[3] = {0};

  for (PetscInt d = 0; d < grid->dim; d++) at[d] = MPMGridFold(grid, d, ijk[d]);
  for (PetscInt copy = 0; copy < PetscMax(1, grid->copies) && !site; copy++) /* of one place, one has mass there */
    if (grid->place[copy] == place) site = FindSite(core->contacts, copy, at);
  for (PetscInt d = 0; d < grid->dim; d++) dv[d] = site ? site->v[d] - site->was[d] : 0;
}

PetscBool MPMContactsPush(const MPMCore *core, const PetscInt ijk[], PetscReal e[])
{
  PetscReal dv[3] = {0}, size = 0;

  if (!core->contacts) return PETSC_FALSE;
  MPMContactsGave(core, ijk, dv);
  for (PetscInt d = 0; d < core->grid.dim; d++) size += PetscSqr(dv[d]);
  for (PetscInt d = 0; d < 3 && size > 0; d++) e[d] = dv[d] / PetscSqrtReal(size);
  return size > 0;
}

PetscErrorCode MPMSurfacesAfter(MPMCore *core, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  if (core->contacts) PetscCall(MPMContactsAfter(core, phase));
  if (core->pistons) PetscCall(MPMPistonsAfter(core, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}
