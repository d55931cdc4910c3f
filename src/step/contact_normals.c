/* contact_normals.c - the nodes that have matter of two copies, or of one beside a rigid body, and the normals there.

   The normal at a node comes from the surfaces near it (UseFaces); where there are none it is that of the plane that
   separates the particles of a and b best, by weighted least squares:
     sum_p phi_p (n . (x_p - x_i) + d - c_p)^2 + SMOOTH |n|^2 is least,  c_p = 1 for b and -1 for a.
   docs/method.md has the reasons. All sums are of whole numbers, so they have the same bits in every sequence. */
#include "base/algebra.h"
#include "step/contact_search.h"

#define SMOOTH 1e-9 /* cells^2, times the sum of phi: it only matters where all particles lie on a line */
#define AHEAD                                                                                                          \
  0.75 /* cells: a block slides on a plane within 0.1 %; with 0.5 and 1 within 1 %, and ends sink in with more */
#define AGREE 8 /* power of how well the surface of one side agrees: 1 where it is flat, 0.7 at a corner */
#define OUTSIDE                                                                                                        \
  1 /* cells: nodes that are farther out of a rigid body do not hold a fluid; with 0.5 water leaks into it */
#define BAND 0.6 /* cells: how much farther than a stencil's reach the nodes of columns are from a rigid body */

/* Adds a particle to the sums of its nodes; those that only one side touches get no normal, and need no moments. */
static PetscErrorCode AddToFits(Search *s, PetscInt pair, int side, PetscInt p, uint64_t mixed)
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  const PetscInt  copy  = side ? s->c->pair[pair].b : s->c->pair[pair].a;
  const Box      *box   = &s->box[2 * pair + side];
  const PetscInt  n[2]  = {box->hi[0] - box->lo[0], box->hi[1] - box->lo[1]};
  PetscInt        at[3], first = 0;
  Stencil         t;

  PetscFunctionBeginUser;
  SetStencil(s, p, &t);
  for (PetscInt d = 2; d >= 0; d--) {
    if (d < grid->dim) first += t.base[d] + MPMGridFirst(grid, d, copy) - patch->lo[d] - box->lo[d];
    if (d > 0) first *= n[d - 1];
    for (PetscInt i = 0; i < t.n[d] && d >= grid->dim; i++) t.w[d][i] = 1;
  }
  FOR_STENCIL(&t, at)
  {
    const PetscInt  i     = first + (at[2] * n[1] + at[1]) * n[0] + at[0];
    const PetscReal units = 1 / UNIT * t.w[0][at[0]] * t.w[1][at[1]] * t.w[2][at[2]];
    PetscReal       xi[3] = {0};
    PetscInt        k     = 4;
    Fit            *fit;

    if (!(units > 0)) continue;
    if (!s->map[i]) {
      if (s->nfits == s->room) {
        s->room = 2 * s->room + 256;
        PetscCall(PetscRealloc((size_t)s->room * sizeof *s->fit, &s->fit));
      }
      fit = &s->fit[s->nfits++];
      PetscCall(PetscMemzero(fit, sizeof *fit));
      fit->pair = pair;
      SetIjk(grid, &t, at, fit->ijk);
      s->map[i] = s->nfits;
    }
    fit = &s->fit[s->map[i] - 1];
    fit->sum[0] += (PetscInt64)units;
    fit->sum[10] += side ? (PetscInt64)units : -(PetscInt64)units;
    if (!IsAmong(&t, at, mixed)) continue;
    for (PetscInt d = 0; d < grid->dim; d++) xi[d] = t.xi[d] - (PetscReal)(t.base[d] + at[d]);
    for (PetscInt d = 0; d < 3; d++) {
      const PetscInt64 one = (PetscInt64)(units * xi[d]);

      fit->sum[1 + d] += one;
      fit->sum[11 + d] += side ? one : -one;
      for (PetscInt e = d; e < 3; e++) fit->sum[k++] += (PetscInt64)(units * xi[d] * xi[e]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int InOrderOfFits(const void *a, const void *b)
{
  const Fit *p = a, *q = b;

  if (p->pair != q->pair) return p->pair < q->pair ? -1 : 1;
  for (PetscInt d = 2; d >= 0; d--)
    if (p->ijk[d] != q->ijk[d]) return p->ijk[d] < q->ijk[d] ? -1 : 1;
  return 0;
}

/* Collects the sums of all processes, and merges those of a node. Collective on exchange.data. */
static PetscErrorCode CollectFits(Search *s)
{
  PetscMPIInt size, n, *counts, *from;
  PetscInt    all = 0, kept = 0;
  Fit        *mine;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(s->core->exchange.data, &size));
  if (size > 1) {
    PetscCall(PetscMPIIntCast(s->nfits * (PetscInt)sizeof *mine, &n));
    PetscCall(PetscMalloc2(size, &counts, size, &from));
    PetscCallMPI(MPI_Allgather(&n, 1, MPI_INT, counts, 1, MPI_INT, s->core->exchange.data));
    for (PetscMPIInt k = 0; k < size; k++) {
      PetscCall(PetscMPIIntCast(all, &from[k]));
      all += counts[k];
    }
    mine     = s->fit;
    s->nfits = s->room = all / (PetscInt)sizeof *mine;
    PetscCall(PetscMalloc1(s->room, &s->fit));
    PetscCallMPI(MPI_Allgatherv(mine, n, MPI_BYTE, s->fit, counts, from, MPI_BYTE, s->core->exchange.data));
    PetscCall(PetscFree(mine));
    PetscCall(PetscFree2(counts, from));
  }
  if (s->nfits) qsort(s->fit, (size_t)s->nfits, sizeof *s->fit, InOrderOfFits);
  for (PetscInt k = 0; k < s->nfits; k++) {
    Fit *to = kept ? &s->fit[kept - 1] : NULL;

    if (to && !InOrderOfFits(to, &s->fit[k]))
      for (PetscInt q = 0; q < NSUMS; q++) to->sum[q] += s->fit[k].sum[q];
    else
      s->fit[kept++] = s->fit[k];
  }
  s->nfits = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets n [3] to the normal at a node by its sums; returns false if only one side has matter there, or it has no normal. */
static PetscBool SetFitted(const MPMGrid *grid, const MPMPair *pair, const Fit *fit, PetscReal n[])
{
  static const int row[3][3] = {{4, 5, 6}, {5, 7, 8}, {6, 8, 9}};
  const int        dim       = (int)grid->dim;
  const PetscReal  all       = (PetscReal)fit->sum[0];
  PetscReal        A[4][4], b[4], size = 0;

  if (fit->sum[10] >= fit->sum[0] || fit->sum[10] <= -fit->sum[0]) return PETSC_FALSE;
  for (int d = 0; d < dim; d++) {
    for (int e = 0; e < dim; e++) A[d][e] = (PetscReal)fit->sum[row[d][e]] / all;
    A[d][d] += SMOOTH;
    A[d][dim] = A[dim][d] = (PetscReal)fit->sum[1 + d] / all;
    b[d]                  = (PetscReal)fit->sum[11 + d] / all;
  }
  A[dim][dim] = 1;
  b[dim]      = (PetscReal)fit->sum[10] / all;
  if (!MPMSolve(dim + 1, 4, &A[0][0], b)) return PETSC_FALSE;
  for (int d = 0; d < 3; d++) n[d] = d < dim && (pair->axis < 0 || pair->axis == d) ? b[d] / grid->h[d] : 0;
  for (int d = 0; d < dim; d++) size += n[d] * n[d];
  if (!(size > 0)) return PETSC_FALSE;
  for (int d = 0; d < dim; d++) n[d] /= PetscSqrtReal(size);
  return PETSC_TRUE;
}

/* Sets n [3] of a node from the surfaces that face each other there, as far as there are any: the mean of both sides by how
   much they have, and by how well they agree: at a corner of one body the surface of the other one counts. */
static void UseFaces(PetscInt dim, Faces of, PetscReal n[])
{
  PetscReal sum[3] = {0}, length = 0;

  for (int side = 0; side < 2; side++) {
    const PetscReal all  = (PetscReal)of[side][3];
    PetscReal       size = 0, weight;

    for (PetscInt d = 0; d < dim; d++) size += PetscSqr((PetscReal)of[side][d]);
    size = PetscSqrtReal(size);
    if (!(size > 0)) continue;
    weight = all * PetscPowReal(size / all, AGREE);
    for (PetscInt d = 0; d < dim; d++) sum[d] += (side ? -1 : 1) * weight * (PetscReal)of[side][d] / size;
  }
  for (PetscInt d = 0; d < dim; d++) length += sum[d] * sum[d];
  if (!(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0)) return; /* only one side has matter there */
  for (PetscInt d = 0; d < dim && length > 0; d++) n[d] = sum[d] / PetscSqrtReal(length);
}

/* Returns how much matter of the other side is at a place `by` cells ahead of the surface of particle p, along the unit normal
   n [dim] of that: the sums of its particles' phi interpolated to there, by those of full cells. */
static PetscReal Filled(const Search *s, PetscInt pair, int side, PetscInt p, const PetscReal n[], PetscReal rim,
                        PetscReal by)
{
  const MPMGrid *grid = &s->core->grid;
  PetscReal      x[3] = {0}, h = 0, found = 0;
  PetscInt       at[3];
  Stencil        t;

  for (PetscInt d = 0; d < grid->dim; d++) h += PetscSqr(n[d] * grid->h[d]);
  for (PetscInt d = 0; d < grid->dim; d++) {
    x[d] = s->view.x[p * grid->dim + d] + (rim + by * PetscSqrtReal(h)) * n[d];
    if (grid->periodic[d])
      x[d] -= PetscFloorReal((x[d] - grid->lower[d]) / (grid->upper[d] - grid->lower[d])) *
              (grid->upper[d] - grid->lower[d]);
    if (!(x[d] >= grid->lower[d] && x[d] < grid->upper[d])) return 0;
  }
  SetStencilAt(s, p, x, &t);
  FOR_STENCIL(&t, at)
  {
    PetscReal phi = 1;
    PetscInt  ijk[3], k;

    SetIjk(grid, &t, at, ijk);
    k = FindKey(s, KeyOf(grid, pair, ijk));
    for (PetscInt d = 0; d < grid->dim; d++) phi *= t.w[d][at[d]];
    if (k >= 0) found += phi * 0.5 * (PetscReal)(s->fit[k].sum[0] + (side ? -1 : 1) * s->fit[k].sum[10]);
  }
  return found * UNIT / s->full[side ? s->c->pair[pair].a : s->c->pair[pair].b];
}

/* Lets a particle at the surface of a body that keeps its shape tell the nodes of its stencil the normal of that, as far as
   there is matter of the other side ahead. */
static PetscErrorCode TellFaces(Search *s, PetscInt pair, int side, PetscInt p, uint64_t mixed)
{
  const MPMCore   *core = s->core;
  const int        dim  = (int)core->grid.dim;
  const PetscReal *rim  = s->view.rim + p * dim;
  PetscReal        F[9], cofactor[9], turned[3] = {0}, size = 0, far = 0, ahead;
  PetscInt         at[3];
  Stencil          t;

  PetscFunctionBeginUser;
  if (!mixed || !MPMMaterialKeepsShape(&core->params.materials[MPMKindOf(core->params.kinds, &s->view, p)->material]))
    PetscFunctionReturn(PETSC_SUCCESS);
  (void)MPMMatterDeformation(core, &s->view, p, F);
  MPMCofactor(dim, F, cofactor);
  for (int d = 0; d < dim; d++) {
    for (int e = 0; e < dim; e++) turned[d] += cofactor[d * dim + e] * rim[e];
    size += turned[d] * turned[d];
    far += rim[d] * rim[d];
  }
  if (!(size > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  for (int d = 0; d < dim; d++) turned[d] /= PetscSqrtReal(size);
  far   = MPMDet(dim, F) * far / PetscSqrtReal(size);
  ahead = Filled(s, pair, side, p, turned, far, AHEAD);
  if (ahead > 0) ahead = PetscMax(0, ahead - Filled(s, pair, side, p, turned, far, -AHEAD));
  for (int k = 0; k < 3; k++) ahead *= ahead; /* so that of the surfaces at a corner the one that faces matter counts */
  SetStencil(s, p, &t);
  FOR_STENCIL(&t, at)
  {
    PetscReal   units = ahead / UNIT;
    PetscInt    ijk[3], k;
    PetscInt64 *to;

    if (!IsAmong(&t, at, mixed)) continue;
    SetIjk(&core->grid, &t, at, ijk);
    k = FindKey(s, KeyOf(&core->grid, pair, ijk));
    if (k < 0) continue;
    for (int d = 0; d < dim; d++) units *= t.w[d][at[d]];
    if (!(units > 0)) continue;
    to = s->faces[k][side];
    for (int d = 0; d < dim; d++) to[d] += (PetscInt64)(units * turned[d]);
    to[3] += (PetscInt64)units;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does so, or sets the normal of a rigid body at a node that is near its surface. */
static PetscBool SetNormal(const MPMCore *core, const MPMPair *pair, const Fit *fit, PetscReal n[])
{
  const MPMGrid *grid = &core->grid;
  PetscReal      x[3], distance;
  PetscInt       axis = 0;

  if (!pair->rigid) return SetFitted(grid, pair, fit, n);
  MPMGridNodeAt(grid, fit->ijk, x);
  distance = MPMRigidDistance(pair->rigid, grid->dim, x, n);
  for (PetscInt d = grid->dim; d < 3; d++) n[d] = 0;
  for (PetscInt d = 1; d < grid->dim; d++)
    if (PetscAbsReal(n[d]) > PetscAbsReal(n[axis])) axis = d;
  if (pair->rigid->tied) return distance <= HeldWithin(core->basis) * PetscAbsReal(n[axis]) * grid->h[axis];
  if (pair->flows && distance > OUTSIDE * grid->h[axis]) return PETSC_FALSE;
  return PetscAbsReal(distance) < (0.5 * MPMBasisNodes(core->basis) + BAND) * grid->h[axis];
}

/* Finds the normals at the nodes of the sums, [nfits][3]; they are 0 where there is none. Collective on exchange.data. */
static PetscErrorCode FindNormals(Search *s)
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(3 * s->nfits + 1, &s->normal));
  PetscCall(PetscCalloc1(s->nfits + 1, &s->faces));
  for (PetscInt k = 0; k < s->nfits; k++)
    if (!SetNormal(s->core, &s->c->pair[s->fit[k].pair], &s->fit[k], s->normal + 3 * k))
      for (PetscInt d = 0; d < 3; d++) s->normal[3 * k + d] = 0;
  PetscCall(SetKeys(s, s->nfits, s->fit, sizeof *s->fit, offsetof(Fit, pair), offsetof(Fit, ijk)));
  for (PetscInt pair = 0; pair < s->c->npairs; pair++)
    for (int side = 0; side < 2 && s->c->pair[pair].axis < 0 && !s->c->pair[pair].rigid; side++)
      PetscCall(MPMContactForParticles(s, pair, side, TellFaces));
  PetscCall(PetscMPIIntCast(8 * s->nfits, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->faces, count, MPIU_INT64, MPI_SUM, s->core->exchange.data));
  for (PetscInt k = 0; k < s->nfits; k++) UseFaces(s->core->grid.dim, s->faces[k], s->normal + 3 * k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMContactNormals(Search *s)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2 * s->c->npairs; k++) {
    const Box *box = &s->box[k];

    if (s->first[k] == s->first[k + 1]) continue;
    PetscCall(PetscCalloc1((box->hi[0] - box->lo[0]) * (box->hi[1] - box->lo[1]) * (box->hi[2] - box->lo[2]), &s->map));
    PetscCall(MPMContactForParticles(s, k / 2, k % 2, AddToFits));
    PetscCall(PetscFree(s->map));
  }
  PetscCall(CollectFits(s));
  PetscCall(FindNormals(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
