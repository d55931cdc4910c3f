/* transfer.h - the two kernels of the Material Point Method: points to nodes (P2G) and nodes to points (G2P).

   Each is written once. dim, basis and parts are compile-time constants of always-inlined functions; transfer.c
   instantiates the combinations that the integrators use. Both walk the points in (cell, id) order in blocks of
   MPM_BLOCK, whose scratch stays in L1:
     P2G  stage stencils -> stress of the block, one call a material -> sums of a cell in local accumulators ->
          added to its nodes once a cell. The tree of additions depends on cells and ids alone, never on the blocks.
     G2P  stage stencils -> velocity, acceleration and velocity gradient -> new v, F, x.
   No branch depends on where a point came from, so every point gets the same instructions on every process.
   In: points x v F kind, nodes vel.  Out: nodes sum; points v F x dx cell; status.                                   */
#ifndef MPM_TRANSFER_H
#define MPM_TRANSFER_H

#include "mpm.h"

/* Stencils of a block: cell = index of the base node in the patch's arrays, weights and gradients per axis. */
typedef struct {
  PetscInt  cell[MPM_BLOCK];
  PetscReal w[MPM_BLOCK][3][MPM_MAX_STENCIL], g[MPM_BLOCK][3][MPM_MAX_STENCIL]; /* 1, 1/m */
  PetscReal at[MPM_BLOCK][3];                                                   /* from the base node, in cells */
} MPMStencils;

/* Index of node ijk in the arrays of the patch. */
MPM_INLINE PetscInt MPMNodeIndex(int dim, const MPMPatch *patch, const PetscInt ijk[])
{
  PetscInt c = 0;

  for (int d = dim - 1; d >= 0; d--) c = c * patch->n[d] + (ijk[d] - patch->lo[d]);
  return c;
}

/* Base node and coordinate in cells of position x in the grid, of a point with half-widths l [dim] in cells (which
   matter to gimp only). */
MPM_INLINE void MPMCoordinates(int dim, MPMBasis basis, const MPMGrid *grid, const PetscReal x[], const PetscReal l[],
                               PetscReal xi[], PetscInt base[])
{
  for (int d = 0; d < dim; d++) {
    xi[d]   = PetscMin((x[d] - grid->lower[d]) / grid->h[d], (PetscReal)grid->cells[d]); /* the quotient may round up */
    base[d] = MPMBasisBase(basis, &xi[d], basis == MPM_BASIS_gimp ? l[d] : 0, grid->cells[d], grid->periodic[d],
                           grid->wall_basis[d]);
  }
}

/* The same for any x; false if it is outside of the grid or not finite. */
MPM_INLINE PetscBool MPMLocate(int dim, MPMBasis basis, const MPMGrid *grid, const PetscReal x[], const PetscReal l[],
                               PetscReal xi[], PetscInt base[])
{
  for (int d = 0; d < dim; d++)
    if (!(x[d] >= grid->lower[d] && x[d] <= grid->upper[d])) return PETSC_FALSE;
  MPMCoordinates(dim, basis, grid, x, l, xi, base);
  return PETSC_TRUE;
}

/* The half-widths [dim] of point p of a view: those of its kind, or its own. */
MPM_INLINE const PetscReal *MPMHalfWidths(int dim, const MPMKind *kinds, const MPMView *view, PetscInt p)
{
  return view->l ? view->l + p * dim : kinds[view->kind ? view->kind[p] : 0].l;
}

/* The row of a field, of an own point or of a halo point (order entries from points.n on). */
#define MPM_ROW(patch, field, p, nc)                                                                                   \
  ((p) < (patch)->points.n ? (patch)->points.field + (p) * (nc)                                                        \
                           : (patch)->halo.field + ((p) - (patch)->points.n) * (nc))

/* Stencils of a block of points, whose cells are known. Those of an image across a periodic face are the point's own:
   only its cell lies elsewhere. */
MPM_INLINE void MPMStage(int dim, MPMBasis basis, const MPMParams *par, const MPMPatch *patch, PetscInt n,
                         const PetscInt *order, MPMStencils *s)
{
  const MPMGrid *grid = patch->grid;

  for (PetscInt q = 0; q < n; q++) {
    const PetscBool  own  = order[q] < patch->points.n ? PETSC_TRUE : PETSC_FALSE;
    const MPMView   *view = own ? &patch->points : &patch->halo;
    const PetscInt   p    = own ? order[q] : order[q] - patch->points.n;
    const PetscReal *x = view->x + p * dim, *l = NULL;
    PetscReal        xi[3];
    PetscInt         base[3];

    if (basis == MPM_BASIS_gimp) l = MPMHalfWidths(dim, par->kinds, view, p);
    MPMCoordinates(dim, basis, grid, x, l, xi, base); /* x was checked when it was committed */
    s->cell[q] = view->cell[p];
    for (int d = 0; d < dim; d++) {
      PetscReal w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];

      MPMBasisWeights(basis, xi[d], basis == MPM_BASIS_gimp ? l[d] : 0, base[d], grid->cells[d], grid->wall_basis[d], w,
                      g);
      s->at[q][d] = xi[d] - (PetscReal)base[d];
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        s->w[q][d][i] = w[i];
        s->g[q][d][i] = g[i] / grid->h[d];
      }
    }
  }
}

#define MPM_MAX_NODES (MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL)

/* Nodes of a stencil. */
MPM_INLINE int MPMStencilSize(int dim, MPMBasis basis)
{
  const int ns = MPMBasisNodes(basis);

  return dim == 1 ? ns : dim == 2 ? ns * ns : ns * ns * ns;
}

/* Offsets of the nodes of a stencil from its base node in the patch's arrays, x fastest. */
MPM_INLINE void MPMStencilOffsets(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt at[])
{
  const int ns = MPMBasisNodes(basis);

  for (int a = 0; a < MPMStencilSize(dim, basis); a++) {
    at[a] = a % ns;
    if (dim > 1) at[a] += a / ns % ns * patch->n[0];
    if (dim > 2) at[a] += a / (ns * ns) * patch->n[0] * patch->n[1];
  }
}

/* Tensor products of point l of the block: weights phi and gradients dphi (1/m) of the nodes of its stencil. */
MPM_INLINE void MPMShape(int dim, MPMBasis basis, const MPMStencils *s, PetscInt l, PetscReal phi[],
                         PetscReal (*dphi)[3])
{
  const int ns = MPMBasisNodes(basis);

  for (int a = 0; a < MPMStencilSize(dim, basis); a++) {
    const int       i = a % ns, j = a / ns % ns, k = a / (ns * ns);
    const PetscReal wx = s->w[l][0][i], wy = dim > 1 ? s->w[l][1][j] : 1, wz = dim > 2 ? s->w[l][2][k] : 1;

    phi[a]     = wx * wy * wz;
    dphi[a][0] = s->g[l][0][i] * wy * wz;
    if (dim > 1) dphi[a][1] = wx * s->g[l][1][j] * wz;
    if (dim > 2) dphi[a][2] = wx * wy * s->g[l][2][k];
  }
}

/* Kinds of the points of a block. */
MPM_INLINE void MPMStageKinds(const MPMParams *par, const MPMPatch *patch, PetscInt n, const PetscInt *order,
                              PetscInt *kind)
{
  for (PetscInt l = 0; l < n; l++) kind[l] = par->nkinds > 1 ? *MPM_ROW(patch, kind, order[l], 1) : 0;
}

/* For each run of points of the same material in a block: m is it, points first to next-1 are of it. */
#define MPM_FOR_MATERIALS(par, n, kind)                                                                                \
  for (PetscInt first = 0, next = 0; first < (n); first = next)                                                        \
    for (const MPMMaterial *m = MPMSameMaterial(par, n, kind, first, &next); m; m = NULL)

MPM_INLINE const MPMMaterial *MPMSameMaterial(const MPMParams *par, PetscInt n, const PetscInt *kind, PetscInt first,
                                              PetscInt *next)
{
  const PetscInt row = par->kinds[kind[first]].material;

  for (*next = first + 1; *next < n && par->kinds[kind[*next]].material == row;) (*next)++;
  return par->materials + row;
}

/* Reads the state of a block's points as far as the phase declared it and the scene has it. */
MPM_INLINE void MPMGather(int dim, const MPMPatch *patch, PetscInt n, const PetscInt *order, MPMBlock *b)
{
#define MPM_GATHER(name, rows)                                                                                         \
  if (patch->points.name)                                                                                              \
    for (PetscInt l = 0; l < n; l++) {                                                                                 \
      const PetscReal *from = MPM_ROW(patch, name, order[l], MPMComponents_##name(dim));                               \
      for (int k = 0; k < MPMComponents_##name(dim); k++) b->name[k][l] = from[k];                                     \
    }
  MPM_MATERIAL_FIELDS(MPM_GATHER)
#undef MPM_GATHER
}

/* Adds the sums of one cell, components c0 to c1-1, to its nodes, and clears them. */
MPM_INLINE void MPMFlush(int dim, MPMBasis basis, int c0, int c1, const PetscInt at[], PetscReal *node, PetscReal *acc)
{
  const int nc = MPM_SUM_NC(dim);

  for (int a = 0; a < MPMStencilSize(dim, basis); a++)
    for (int c = c0; c < c1; c++) {
      node[at[a] * nc + c] += acc[a * nc + c];
      acc[a * nc + c] = 0;
    }
}

/* Sums over points to nodes: mass (1), momentum (2) and force (4), (13), with V sig = V0 tau. */
MPM_INLINE void MPMP2G(int dim, MPMBasis basis, int parts, const MPMParams *par, MPMPatch *patch)
{
  const int        nn = MPMStencilSize(dim, basis), ns = MPMBasisNodes(basis), nc = MPM_SUM_NC(dim);
  const int        c0 = MPM_SUM_FIRST(dim, parts), c1 = MPM_SUM_LAST(dim, parts);
  const PetscReal *h    = patch->grid->h;
  PetscInt         cell = -1, kind[MPM_BLOCK], at[MPM_MAX_NODES];
  MPMStencils      s;
  PetscReal        phi[MPM_MAX_NODES], dphi[MPM_MAX_NODES][3];
  MPMBlock         b;
  PetscReal        acc[MPM_MAX_NODES * MPM_SUM_NC(3)] = {0};

  MPMStencilOffsets(dim, basis, patch, at);
  for (PetscInt q = 0; q < patch->norder; q += MPM_BLOCK) {
    const PetscInt *order = patch->order + q, n = PetscMin(MPM_BLOCK, patch->norder - q);

    MPMStage(dim, basis, par, patch, n, order, &s);
    MPMStageKinds(par, patch, n, order, kind);
    if (parts & MPM_P2G_FORCE) {
      MPMGather(dim, patch, n, order, &b);
      MPM_FOR_MATERIALS(par, n, kind)
      if (!(m->state & MPM_BIT(tau))) m->type->law->stress[dim - 1](m, first, next, &b);
    }
    for (PetscInt l = 0; l < n; l++) {
      const MPMKind *k = par->kinds + kind[l];
      PetscReal      mv[3], mC[3][3], mb[3] = {0}, flux[3][3]; /* m v; m C h; m b; - V0 tau */

      if (s.cell[l] != cell) {
        if (cell >= 0) MPMFlush(dim, basis, c0, c1, at, patch->sum + cell * nc, acc);
        cell = s.cell[l];
      }
      if (parts & MPM_P2G_MOMENTUM) {
        const PetscReal *v = parts & MPM_RESIDUAL ? MPM_ROW(patch, r, order[l], dim) : MPM_ROW(patch, v, order[l], dim);
        for (int d = 0; d < dim; d++) mv[d] = k->m * v[d];
      }
      if (parts & MPM_AFFINE) { /* m (v + C (x_i - x_p)), x_i - x_p = (i - at) h */
        const PetscReal *C = MPM_ROW(patch, C, order[l], dim * dim);
        for (int d = 0; d < dim; d++)
          for (int e = 0; e < dim; e++) {
            mC[d][e] = k->m * C[d * dim + e] * h[e];
            mv[d] -= mC[d][e] * s.at[l][e];
          }
      }
      if (parts & MPM_P2G_FORCE) {
        for (int d = 0; d < dim; d++)
          for (int e = 0; e < dim; e++) flux[d][e] = -k->V0 * b.tau[MPMSymPart(dim, d, e)][l];
        if (patch->points.b)
          for (int d = 0; d < dim; d++) mb[d] = k->m * MPM_ROW(patch, b, order[l], dim)[d];
      }
      MPMShape(dim, basis, &s, l, phi, dphi);
      for (int a = 0; a < nn; a++) {
        const int  i[3] = {a % ns, a / ns % ns, a / (ns * ns)};
        PetscReal *node = acc + a * nc;

        if (parts & MPM_P2G_MASS) node[0] += phi[a] * k->m;
        if (parts & MPM_P2G_MOMENTUM)
          for (int d = 0; d < dim; d++) {
            PetscReal p = mv[d];
            if (parts & MPM_AFFINE)
              for (int e = 0; e < dim; e++) p += mC[d][e] * i[e];
            node[1 + d] += phi[a] * p;
          }
        if (parts & MPM_P2G_FORCE)
          for (int d = 0; d < dim; d++) {
            PetscReal f = flux[d][0] * dphi[a][0];
            for (int e = 1; e < dim; e++) f += flux[d][e] * dphi[a][e];
            node[1 + dim + d] += patch->points.b ? f + phi[a] * mb[d] : f;
          }
      }
    }
  }
  if (cell >= 0) MPMFlush(dim, basis, c0, c1, at, patch->sum + cell * nc, acc);
}

/* Notes a bad condition: the gravest kind, of its smallest id. Rare, so never inlined into the loops. */
static __attribute__((noinline)) void MPMNoteBad(MPMStatus *status, MPMBad bad, PetscInt64 id, PetscInt dim,
                                                 const PetscReal x[], PetscReal J)
{
  if (status->bad != MPM_OK && (status->bad < bad || (status->bad == bad && status->id <= id))) return;
  status->bad = bad;
  status->id  = id;
  status->J   = J;
  for (PetscInt d = 0; d < dim; d++) status->x[d] = x[d];
}

/* New F and material state of a block from its velocity gradients L [dim*dim] in 1/s: eqs. (10) to (12); checks J;
   speeds of waves. */
MPM_INLINE void MPMUpdateState(int dim, const MPMParams *par, MPMPatch *patch, PetscInt n, const PetscInt *order,
                               PetscReal (*L)[MPM_BLOCK], MPMStatus *status)
{
  const MPMView *points = &patch->points;
  PetscInt       kind[MPM_BLOCK];
  PetscReal      c2[MPM_BLOCK];
  MPMBlock       b;

  MPMStageKinds(par, patch, n, order, kind);
  MPMGather(dim, patch, n, order, &b);
  MPM_FOR_MATERIALS(par, n, kind)
  {
    const MPMMaterialLaw *law = m->type->law;

    if (m->state & MPM_BIT(F))
      for (PetscInt l = first; l < next; l++) {
        PetscReal F[9], G[9];

        for (int k = 0; k < dim * dim; k++) {
          F[k] = b.F[k][l];
          G[k] = L[k][l];
        }
        MPMDeform(dim, par->dt, G, F);
        for (int k = 0; k < dim * dim; k++) b.F[k][l] = points->F[order[l] * dim * dim + k] = F[k];
      }
    if (law->update[dim - 1]) {
      law->update[dim - 1](m, par->dt, L, first, next, &b);
      for (PetscInt l = first; l < next; l++) {
#define MPM_SCATTER(name, rows)                                                                                        \
  if (m->state & MPM_BIT(name) & ~MPM_BIT(F))                                                                          \
    for (int k = 0; k < MPMComponents_##name(dim); k++)                                                                \
      points->name[order[l] * MPMComponents_##name(dim) + k] = b.name[k][l];
        MPM_MATERIAL_FIELDS(MPM_SCATTER)
#undef MPM_SCATTER
      }
    }
    for (PetscInt l = first; l < next; l++) {
      PetscReal F[9], J = b.J[0][l];

      if (m->state & MPM_BIT(F)) {
        for (int k = 0; k < dim * dim; k++) F[k] = b.F[k][l];
        J = MPMDet(dim, F);
      }
      if (!(J > 0 && J < PETSC_MAX_REAL))
        MPMNoteBad(status, MPM_BAD_J, points->id[order[l]], dim, points->x + order[l] * dim, J);
    }
    law->speed2[dim - 1](m, first, next, &b, c2);
  }
  for (PetscInt l = 0; l < n; l++) status->c2 = PetscMax(status->c2, c2[l]);
}

/* Index of the cell of position x if it is the patch's own; -1 in another patch, -2 outside of the grid. base: its
 * node. */
MPM_INLINE PetscInt MPMOwnCell(int dim, MPMBasis basis, const MPMPatch *patch, const PetscReal x[], const PetscReal l[],
                               PetscInt base[])
{
  PetscReal xi[3];

  if (!MPMLocate(dim, basis, patch->grid, x, l, xi, base)) return -2;
  for (int d = 0; d < dim; d++)
    if (base[d] < patch->own_lo[d] || base[d] >= patch->own_lo[d] + patch->own_n[d]) return -1;
  return MPMNodeIndex(dim, patch, base);
}

/* Brings x back through periodic faces; [lower, upper) afterwards. */
MPM_INLINE void MPMWrap(int dim, const MPMGrid *grid, PetscReal x[])
{
  for (int d = 0; d < dim; d++) {
    const PetscReal length = grid->upper[d] - grid->lower[d];

    if (!grid->periodic[d] || (x[d] >= grid->lower[d] && x[d] < grid->upper[d])) continue;
    x[d] -= PetscFloorReal((x[d] - grid->lower[d]) / length) * length;
    if (x[d] < grid->lower[d] || x[d] >= grid->upper[d]) x[d] = grid->lower[d]; /* rounding */
  }
}

/* Half-widths of a stretched domain (cpGIMP): those of the kind times the diagonal of V = sqrt(F F^T), which a rotation
   of the undeformed leaves as it is and which turns with the material, unlike the diagonal of F. */
MPM_INLINE void MPMStretchDomain(int dim, const MPMParams *par, MPMPatch *patch, PetscInt p, const PetscReal x[],
                                 MPMStatus *status)
{
  const MPMView *points = &patch->points;
  PetscReal      V[3];

  MPMStretch(dim, points->F + p * dim * dim, V);
  for (int d = 0; d < dim; d++) {
    PetscReal l = par->kinds[points->kind ? points->kind[p] : 0].l[d] * V[d];

    if (!(l <= 0.5)) { /* its stencil would be too small */
      MPMNoteBad(status, MPM_TOO_WIDE, points->id[p], dim, x, 2 * l);
      l = 0.5;
    }
    points->l[p * dim + d] = l;
  }
}

/* x <- x + dx; the cell it is in now; counts the points that changed cell, and those that left the patch. */
MPM_INLINE void MPMCommit(int dim, MPMBasis basis, const MPMParams *par, MPMPatch *patch, PetscInt p, PetscInt cell,
                          const PetscReal dx[], MPMStatus *status)
{
  const PetscReal *l = NULL;
  PetscReal        x[3];
  PetscInt         base[3], now;

  for (int d = 0; d < dim; d++) x[d] = patch->points.x[p * dim + d] + dx[d];
  MPMWrap(dim, patch->grid, x);
  for (int d = 0; d < dim; d++) patch->points.x[p * dim + d] = x[d];
  if (basis == MPM_BASIS_gimp) {
    if (patch->points.l) MPMStretchDomain(dim, par, patch, p, x, status);
    l = MPMHalfWidths(dim, par->kinds, &patch->points, p);
  }
  now = MPMOwnCell(dim, basis, patch, x, l, base);
  if (now == -2) MPMNoteBad(status, MPM_LEFT_GRID, patch->points.id[p], dim, x, 0);
  status->moved += now != cell;
  status->left += now < 0;
  patch->points.cell[p] = now;
}

/* The new velocity of point p from vn = sum phi v', an = sum phi a (8), and its displacement (9). */
MPM_INLINE void MPMMove(int dim, const MPMParams *par, MPMPatch *patch, PetscInt p, const PetscReal vn[],
                        const PetscReal an[], PetscReal dx[], MPMStatus *status)
{
  PetscReal *v = patch->points.v + p * dim, v2 = 0;

  for (int d = 0; d < dim; d++) {
    if (patch->points.r) /* xpic: what the grid took up of v_p, accelerated */
      v[d] = v[d] - patch->points.r[p * dim + d] + par->dt * an[d];
    else
      v[d] = par->flip * (v[d] + par->dt * an[d]) + (1 - par->flip) * vn[d];
    v2 += v[d] * v[d];
    dx[d] = par->dt * (patch->points.r ? v[d] : vn[d]);
  }
  status->v2 = PetscMax(status->v2, v2);
}

/* From nodes to points: motion (8), (9); velocity gradient (3), F and state; commit of the new position. */
MPM_INLINE void MPMG2P(int dim, MPMBasis basis, int parts, const MPMParams *par, MPMPatch *patch, MPMStatus *status)
{
  const int   nn = MPMStencilSize(dim, basis), ns = MPMBasisNodes(basis), nc = MPM_VEL_NC(dim);
  const int   inertia = MPMBasisInertia(basis);
  PetscInt    at[MPM_MAX_NODES];
  MPMStencils s;
  PetscReal   phi[MPM_MAX_NODES], dphi[MPM_MAX_NODES][3], L[9][MPM_BLOCK];

  MPMStencilOffsets(dim, basis, patch, at);
  for (PetscInt q = 0; q < patch->points.n; q += MPM_BLOCK) {
    const PetscInt *order = patch->own_order + q, n = PetscMin(MPM_BLOCK, patch->points.n - q);

    MPMStage(dim, basis, par, patch, n, order, &s);
    for (PetscInt l = 0; l < n; l++) {
      const PetscReal *base  = patch->vel + s.cell[l] * nc;
      PetscReal        vn[3] = {0}, an[3] = {0}, dx[3], G[9]; /* sum phi v', sum phi a; sum v' grad phi */

      MPMShape(dim, basis, &s, l, phi, dphi);
      for (int d = 0; d < dim; d++) { /* a sum at a time: it stays in a register */
        if (parts & (MPM_G2P_MOTION | MPM_G2P_FILTER))
          for (int a = 0; a < nn; a++) vn[d] += phi[a] * base[at[a] * nc + d];
        if (parts & MPM_G2P_MOTION)
          for (int a = 0; a < nn; a++) an[d] += phi[a] * base[at[a] * nc + dim + d];
        if ((parts & MPM_G2P_STRESS) || ((parts & MPM_AFFINE) && !inertia))
          for (int e = 0; e < dim; e++) {
            PetscReal sum = 0;

            for (int a = 0; a < nn; a++) sum += base[at[a] * nc + d] * dphi[a][e];
            G[d * dim + e] = sum;
          }
      }
      if (parts & MPM_G2P_STRESS)
        for (int k = 0; k < dim * dim; k++) L[k][l] = G[k];
      if (parts & MPM_AFFINE)
        for (int d = 0; d < dim; d++)
          for (int e = 0; e < dim; e++) {
            PetscReal sum = 0;

            for (int a = 0; a < nn && inertia; a++) {
              const int i[3] = {a % ns, a / ns % ns, a / (ns * ns)};
              sum += phi[a] * base[at[a] * nc + d] * ((PetscReal)i[e] - s.at[l][e]);
            }
            patch->points.C[(order[l] * dim + d) * dim + e] = inertia ? sum * inertia / patch->grid->h[e]
                                                                      : G[d * dim + e];
          }
      if (parts & MPM_G2P_FILTER) {
        PetscReal *r = patch->points.r + order[l] * dim;
        for (int d = 0; d < dim; d++) r[d] = (parts & MPM_RESIDUAL ? r : patch->points.v + order[l] * dim)[d] - vn[d];
      }
      if (parts & MPM_G2P_MOTION) {
        MPMMove(dim, par, patch, order[l], vn, an, dx, status);
        if (!(parts & MPM_G2P_COMMIT))
          for (int d = 0; d < dim; d++) patch->points.dx[order[l] * dim + d] = dx[d];
        else if (!(parts & MPM_G2P_STRESS))
          MPMCommit(dim, basis, par, patch, order[l], s.cell[l], dx, status);
        else /* the new state comes first */
          for (int d = 0; d < dim; d++) s.at[l][d] = dx[d];
      }
    }
    if (parts & MPM_G2P_STRESS) MPMUpdateState(dim, par, patch, n, order, L, status);
    if ((parts & MPM_G2P_STRESS) && (parts & MPM_G2P_COMMIT))
      for (PetscInt l = 0; l < n; l++)
        MPMCommit(dim, basis, par, patch, order[l], s.cell[l],
                  parts & MPM_G2P_MOTION ? s.at[l] : patch->points.dx + order[l] * dim, status);
  }
}

#endif
