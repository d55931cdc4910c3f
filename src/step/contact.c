/* contact.c - what bodies that meet do to each other's nodes. The nodes that have matter of both are put together in columns,
   which follow an axis to which the normal inclines (contact_find.c). If the matter of both sides of a column would come
   nearer to each other than its gap allows, it gets an impulse at the surface, and the opposite one on the other side:
   along the normal of the column, and by friction across.

   The surface of side s has for node k the weight N_sk = - sum_p V_p n_s . d phi_kp/dx, n_s into its matter: by it the
   matter ends with the velocity w_s = sum_k N_sk v_sk, where sum_k N_sk = 1, and an impulse p there is the part N_sk p of
   node k, as a uniform stress has it. The relative velocity changes by p sum_sk N_sk^2/m_sk. A node alone would also hold
   the matter behind the surface, over the reach of a stencil.

   Columns have nodes in common, so their impulses are found one after the other in SWEEPS rounds, by the velocities that the
   others have left; impulses along normals only push, and friction stays within its cone. Every process does this for all
   columns, with the same bits: of the sums over processes all terms but one are 0. docs/method.md has the formulas
   (Contact). */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/step.h"

#define SWEEPS 8
#define STOPS  4 /* rounds of free bodies at walls in each of them */

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
  PetscCall(PetscFree(c->stop));
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
  PetscCall(PetscCalloc1(7 * c->nsites, &sum));
  for (PetscInt k = 0; k < c->nsites; k++) {
    const PetscInt at = Own(patch, &c->site[k]);

    if (at < 0 || !(patch->node[at].m > 0)) continue;
    sum[7 * k] = patch->node[at].m;
    for (PetscInt d = 0; d < dim; d++) {
      sum[7 * k + 1 + d] = patch->motion[at * MPM_MOTION_NC(dim) + d];
      sum[7 * k + 4 + d] = patch->motion[at * MPM_MOTION_NC(dim) + dim + d];
    }
  }
  PetscCall(PetscMPIIntCast(7 * c->nsites, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, count, MPIU_REAL, MPI_SUM, core->exchange.data));
  for (PetscInt k = 0; k < c->nsites; k++) {
    c->site[k].m       = sum[7 * k];
    c->site[k].changes = PETSC_FALSE;
    for (PetscInt d = 0; d < 3; d++) {
      c->site[k].v[d] = c->site[k].was[d] = sum[7 * k + 1 + d];
      c->site[k].a[d] = sum[7 * k + 4 + d];
    }
  }
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the site of a part on a side if it has mass and a share there, else NULL. */
static MPMContactSite *SiteOf(const MPMContacts *c, const MPMContactPart *part, int side)
{
  const PetscInt k = c->node[part->node].site[side];

  return k >= 0 && c->site[k].m > 0 && part->share[side] > 0 ? &c->site[k] : NULL;
}

/* Returns the rigid body of a column, or NULL. */
static MPMRigid *RigidOf(const MPMCore *core, const MPMContactColumn *col)
{
  const PetscInt a = core->contacts->pair[col->pair].a;

  return a < 0 ? &core->rigids.body[-1 - a] : NULL;
}

/* Sets v [3] to the relative velocity of b and a at the surface, m/s. */
static void Relative(const MPMCore *core, const MPMContactColumn *col, PetscReal v[])
{
  const MPMContacts *c     = core->contacts;
  const MPMRigid    *rigid = RigidOf(core, col);

  for (PetscInt d = 0; d < 3; d++) v[d] = 0;
  if (rigid) MPMRigidVelocity(rigid, core->grid.dim, col->at, v);
  for (PetscInt d = 0; d < 3; d++) v[d] = -v[d];
  for (PetscInt k = col->first; k < col->last; k++)
    for (int side = 0; side < 2; side++) {
      const MPMContactSite *site = SiteOf(c, &c->part[k], side);

      for (PetscInt d = 0; d < 3 && site; d++) v[d] += (side ? 1 : -1) * c->part[k].share[side] * site->v[d];
    }
}

/* Gives the sites of a column an impulse J [3] on b, N s, and its opposite on a. */
static void Give(MPMContacts *c, const MPMContactColumn *col, const PetscReal J[])
{
  for (PetscInt k = col->first; k < col->last; k++)
    for (int side = 0; side < 2; side++) {
      MPMContactSite *site = SiteOf(c, &c->part[k], side);

      for (PetscInt d = 0; d < 3 && site; d++) site->v[d] += (side ? 1 : -1) * c->part[k].share[side] * J[d] / site->m;
    }
}

/* Makes a column ready for a phase: no impulse yet, and what one changes. advance: free bodies yield. */
static void Begin(const MPMCore *core, PetscBool advance, MPMContactColumn *col)
{
  const MPMContacts *c     = core->contacts;
  const MPMRigid    *rigid = RigidOf(core, col);

  col->press = col->inverse = 0;
  for (PetscInt d = 0; d < 3; d++) col->brake[d] = 0;
  for (PetscInt k = col->first; k < col->last; k++)
    for (int side = 0; side < 2; side++) {
      const MPMContactSite *site = SiteOf(c, &c->part[k], side);

      if (site) col->inverse += PetscSqr(c->part[k].share[side]) / site->m;
    }
  col->across = col->inverse;
  if (rigid && advance && col->inverse > 0) {
    PetscReal across;

    col->inverse += MPMRigidYields(rigid, col->at, col->n, &across);
    col->across += across;
  }
}

/* Adds to the impulses along n and across what is missing of the relative velocity v [3]: pushes alone where `decides`; with
   friction mu where `rubs`. Sets J [3] to what they change by. */
static void Missing(const PetscReal v[], const PetscReal n[], PetscReal least, PetscReal inverse, PetscReal across,
                    PetscBool decides, PetscReal mu, PetscReal *press, PetscReal brake[], PetscReal J[])
{
  PetscReal w = 0, more, size = 0, most, now[3];

  for (PetscInt d = 0; d < 3; d++) w += n[d] * v[d];
  more = (least - w) / inverse;
  if (decides) more = PetscMax(more, -*press);
  *press += more;
  for (PetscInt d = 0; d < 3; d++) J[d] = more * n[d];
  if (!(mu > 0)) return;
  for (PetscInt d = 0; d < 3; d++) {
    now[d] = brake[d] - (v[d] - w * n[d]) / across;
    size += now[d] * now[d];
  }
  size = PetscSqrtReal(size);
  most = *press > 0 ? mu * *press : 0;
  for (PetscInt d = 0; d < 3; d++) {
    if (size > most) now[d] *= most / size;
    J[d] += now[d] - brake[d];
    brake[d] = now[d];
  }
}

/* Changes the impulses of a column by what is missing now. decides: it only pushes, and may leave the matter alone; else it
   does what the advance has decided. rubs: with friction. */
static void Act(MPMCore *core, MPMContactColumn *col, PetscBool decides, PetscBool rubs)
{
  MPMContacts    *c  = core->contacts;
  MPMRigid       *rigid = RigidOf(core, col);
  PetscReal       v[3], J[3];

  if (!(col->inverse > 0) || (!decides && !col->held)) return;
  Relative(core, col, v);
  Missing(v, col->n, col->least, col->inverse, col->across, decides, rubs ? c->pair[col->pair].mu : 0, &col->press,
          col->brake, J);
  Give(c, col, J);
  for (PetscInt d = 0; d < 3; d++) J[d] = -J[d];
  if (rigid && rubs) MPMRigidPush(rigid, col->at, J);
}

/* Does the same for a free rigid body at a wall. */
static void ActStop(MPMCore *core, MPMContactStop *stop)
{
  const MPMFace *f     = &core->params.walls->given[stop->face / 2][stop->face % 2];
  MPMRigid      *rigid = &core->rigids.body[stop->rigid];
  PetscReal      v[3], J[3];

  MPMRigidVelocity(rigid, core->grid.dim, stop->at, v);
  for (PetscInt d = 0; d < 3 && MPMWallHas(f->type, MPM_WALL_MOVES); d++)
    if (d == stop->face / 2 || MPMWallHas(f->type, MPM_WALL_TANGENT)) v[d] -= f->velocity[d];
  Missing(v, stop->n, stop->least, stop->inverse, stop->across, PETSC_TRUE, stop->mu, &stop->press, stop->brake, J);
  MPMRigidPush(rigid, stop->at, J);
}

/* Gives free bodies the velocity that gravity alone would, and makes the places ready where they may meet walls. */
static void BeginFree(MPMCore *core)
{
  MPMContacts *c = core->contacts;

  for (PetscInt k = 0; k < core->rigids.n; k++)
    for (PetscInt d = 0; d < core->grid.dim && core->rigids.body[k].free; d++)
      core->rigids.body[k].velocity[d] += core->params.kick * core->params.gravity[d];
  for (MPMContactStop *stop = c->stop; stop < c->stop + c->nstops; stop++) {
    stop->press   = 0;
    stop->inverse = MPMRigidYields(&core->rigids.body[stop->rigid], stop->at, stop->n, &stop->across);
    for (PetscInt d = 0; d < 3; d++) stop->brake[d] = 0;
  }
}

/* Gives the nodes of pairs that are glued the same velocity; before contact acts as the one that they have, with the same
   acceleration. */
static void Glue(MPMContacts *c, PetscBool before)
{
  for (PetscInt k = 0; k < c->nnodes; k++) {
    MPMContactSite *a = &c->site[c->node[k].site[0]], *b = &c->site[c->node[k].site[1]];

    if (!c->pair[c->node[k].pair].glued || !(a->m > 0 && b->m > 0)) continue;
    for (PetscInt d = 0; d < 3; d++) {
      a->v[d] = b->v[d] = (a->m * a->v[d] + b->m * b->v[d]) / (a->m + b->m);
      if (before) a->was[d] = b->was[d] = a->v[d];
      if (before) a->a[d] = b->a[d] = (a->m * a->a[d] + b->m * b->a[d]) / (a->m + b->m);
    }
    a->changes = b->changes = PETSC_TRUE;
  }
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

    if (at < 0 || !(s->m > 0)) continue;
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

/* Adds up what rigid bodies have given the matter. The nodes count it as friction: what moving bodies do is work. */
static void Account(MPMCore *core)
{
  const MPMContacts *c = core->contacts;
  PetscReal          work = 0;
  PetscMPIInt        rank;

  for (const MPMContactColumn *col = c->column; col < c->column + c->ncolumns; col++) {
    MPMRigid *rigid = RigidOf(core, col);
    PetscReal V[3], J[3], r[3], by = 0;

    if (!rigid || !(col->press > 0)) continue;
    MPMRigidVelocity(rigid, core->grid.dim, col->at, V);
    for (PetscInt d = 0; d < 3; d++) {
      J[d] = col->press * col->n[d] + col->brake[d];
      r[d] = col->at[d] - rigid->pivot[d] - rigid->place[d];
      by += J[d] * V[d];
    }
    for (PetscInt d = 0; d < 3; d++) {
      const PetscInt e = (d + 1) % 3, f = (d + 2) % 3;

      rigid->impulse[d] += J[d];
      rigid->torque[d] += r[e] * J[f] - r[f] * J[e];
    }
    *rigid->work += by;
    work += by;
  }
  (void)MPI_Comm_rank(core->exchange.data, &rank);
  if (rank || !core->energy.on || work == 0) return;
  MPMSumAdd(&core->energy.sum[MPM_ENERGY_rigid], work);
  MPMSumAdd(&core->energy.sum[MPM_ENERGY_friction], -work);
}

PetscErrorCode MPMContactsAfter(MPMCore *core, const MPMPhase *phase)
{
  const PetscBool advance = phase->nodes == MPMNodesAdvance ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool decides = advance || phase->nodes == MPMNodesVelocity ? PETSC_TRUE : PETSC_FALSE;
  MPMContacts    *c       = core->contacts;

  PetscFunctionBeginUser;
  if (advance) BeginFree(core);
  if ((!c->nnodes && !(advance && c->nstops)) || phase->nodes == MPMNodesResidual) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Motion(core));
  for (PetscInt k = 0; k < c->ncolumns; k++) Begin(core, advance, &c->column[k]);
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    Glue(c, sweep ? PETSC_FALSE : PETSC_TRUE);
    for (PetscInt k = 0; k < c->ncolumns; k++) Act(core, &c->column[k], decides, advance);
    for (PetscInt k = 0; k < STOPS * c->nstops && advance; k++) ActStop(core, &c->stop[k % c->nstops]);
  }
  for (PetscInt k = 0; k < c->ncolumns && advance; k++) c->column[k].held = c->column[k].press > 0 ? PETSC_TRUE : PETSC_FALSE;
  if (advance) Account(core);
  Take(core, advance);
  PetscFunctionReturn(PETSC_SUCCESS);
}
