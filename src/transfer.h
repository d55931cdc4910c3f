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
} MPMStencils;

/* Index of node ijk in the arrays of the patch. */
MPM_INLINE PetscInt MPMNodeIndex(int dim, const MPMPatch *patch, const PetscInt ijk[])
{
  PetscInt c = 0;

  for (int d = dim - 1; d >= 0; d--) c = c * patch->n[d] + (ijk[d] - patch->lo[d]);
  return c;
}

/* Base node and coordinate in cells of position x, which is in the grid or an image across a periodic face. */
MPM_INLINE void MPMCoordinates(int dim, MPMBasis basis, const MPMGrid *grid, const PetscReal x[], PetscReal xi[],
                               PetscInt base[])
{
  for (int d = 0; d < dim; d++) {
    xi[d]   = PetscMin((x[d] - grid->lower[d]) / grid->h[d], (PetscReal)grid->cells[d]); /* the quotient may round up */
    base[d] = MPMBasisBase(basis, xi[d], grid->cells[d]);
  }
}

/* The same for any x; false if it is outside of the grid or not finite. */
MPM_INLINE PetscBool MPMLocate(int dim, MPMBasis basis, const MPMGrid *grid, const PetscReal x[], PetscReal xi[],
                               PetscInt base[])
{
  for (int d = 0; d < dim; d++)
    if (!(x[d] >= grid->lower[d] && x[d] <= grid->upper[d])) return PETSC_FALSE;
  MPMCoordinates(dim, basis, grid, x, xi, base);
  return PETSC_TRUE;
}

/* The row of a field, of an own point or of a halo point (order entries from points.n on). */
#define MPM_ROW(patch, field, p, nc)                                                                                   \
  ((p) < (patch)->points.n ? (patch)->points.field + (p) * (nc)                                                        \
                           : (patch)->halo.field + ((p) - (patch)->points.n) * (nc))

MPM_INLINE void MPMStage(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt n, const PetscInt *order,
                         MPMStencils *s)
{
  const MPMGrid *grid = patch->grid;

  for (PetscInt l = 0; l < n; l++) {
    const PetscReal *x = MPM_ROW(patch, x, order[l], dim);
    PetscReal        xi[3];
    PetscInt         base[3];

    MPMCoordinates(dim, basis, grid, x, xi, base); /* x was checked when it was committed */
    s->cell[l] = MPMNodeIndex(dim, patch, base);
    for (int d = 0; d < dim; d++) {
      PetscReal w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];

      MPMBasisWeights(basis, xi[d], base[d], grid->cells[d], w, g);
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        s->w[l][d][i] = w[i];
        s->g[l][d][i] = g[i] / grid->h[d];
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

/* Calls one function of the materials' laws on a block: once for each run of points of the same material. */
#define MPM_FOR_MATERIALS(par, n, kind, function, F, out)                                                              \
  for (PetscInt first = 0, next; first < (n); first = next) {                                                          \
    const PetscInt     row = (par)->kinds[(kind)[first]].material;                                                     \
    const MPMMaterial *m   = (par)->materials + row;                                                                   \
    for (next = first + 1; next < (n) && (par)->kinds[(kind)[next]].material == row;) next++;                          \
    m->type->law->function(m, next - first, (F) + first, (out) + first);                                               \
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

/* Sums over points to nodes: mass (1), momentum (2) and internal force (4), with V sig = V0 tau. */
MPM_INLINE void MPMP2G(int dim, MPMBasis basis, int parts, const MPMParams *par, MPMPatch *patch)
{
  const int   nn = MPMStencilSize(dim, basis), nc = MPM_SUM_NC(dim);
  const int   c0   = parts & MPM_P2G_MASS ? 0 : parts & MPM_P2G_MOMENTUM ? 1 : 1 + dim; /* components that are summed */
  const int   c1   = parts & MPM_P2G_FORCE ? nc : 1 + dim;
  PetscInt    cell = -1, kind[MPM_BLOCK], at[MPM_MAX_NODES];
  MPMStencils s;
  PetscReal   phi[MPM_MAX_NODES], dphi[MPM_MAX_NODES][3];
  PetscReal   F[9 * MPM_BLOCK], tau[MPM_STRESS_NC * MPM_BLOCK];
  PetscReal   acc[MPM_MAX_NODES * MPM_SUM_NC(3)] = {0};

  MPMStencilOffsets(dim, basis, patch, at);
  for (PetscInt q = 0; q < patch->norder; q += MPM_BLOCK) {
    const PetscInt *order = patch->order + q, n = PetscMin(MPM_BLOCK, patch->norder - q);

    MPMStage(dim, basis, patch, n, order, &s);
    MPMStageKinds(par, patch, n, order, kind);
    if (parts & MPM_P2G_FORCE) {
      for (PetscInt l = 0; l < n; l++) {
        const PetscReal *Fp = MPM_ROW(patch, F, order[l], dim * dim);
        for (int k = 0; k < dim * dim; k++) F[k * MPM_BLOCK + l] = Fp[k];
      }
      MPM_FOR_MATERIALS(par, n, kind, stress[dim - 1], F, tau)
    }
    for (PetscInt l = 0; l < n; l++) {
      const MPMKind *k = par->kinds + kind[l];
      PetscReal      mv[3], flux[3][3]; /* m v; - V0 tau */

      if (s.cell[l] != cell) {
        if (cell >= 0) MPMFlush(dim, basis, c0, c1, at, patch->sum + cell * nc, acc);
        cell = s.cell[l];
      }
      if (parts & MPM_P2G_MOMENTUM) {
        const PetscReal *v = MPM_ROW(patch, v, order[l], dim);
        for (int d = 0; d < dim; d++) mv[d] = k->m * v[d];
      }
      if (parts & MPM_P2G_FORCE)
        for (int d = 0; d < dim; d++)
          for (int e = 0; e < dim; e++) flux[d][e] = -k->V0 * tau[MPMSymIndex(d, e) * MPM_BLOCK + l];
      MPMShape(dim, basis, &s, l, phi, dphi);
      for (int a = 0; a < nn; a++) {
        PetscReal *node = acc + a * nc;

        if (parts & MPM_P2G_MASS) node[0] += phi[a] * k->m;
        if (parts & MPM_P2G_MOMENTUM)
          for (int d = 0; d < dim; d++) node[1 + d] += phi[a] * mv[d];
        if (parts & MPM_P2G_FORCE)
          for (int d = 0; d < dim; d++) {
            PetscReal f = flux[d][0] * dphi[a][0];
            for (int e = 1; e < dim; e++) f += flux[d][e] * dphi[a][e];
            node[1 + dim + d] += f;
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

/* New F of a block from its velocity gradients L [n][dim*dim] in 1/s: eqs. (10), (11); checks J; speeds of waves. */
MPM_INLINE void MPMUpdateF(int dim, const MPMParams *par, MPMPatch *patch, PetscInt n, const PetscInt *order,
                           const PetscReal (*L)[9], MPMStatus *status)
{
  PetscInt  kind[MPM_BLOCK];
  PetscReal F[9 * MPM_BLOCK], c2[MPM_BLOCK];

  for (PetscInt l = 0; l < n; l++) {
    const PetscInt p  = order[l];
    PetscReal     *Fp = patch->points.F + p * dim * dim, J;

    MPMDeform(dim, par->dt, L[l], Fp);
    J = MPMDet(dim, Fp);
    if (!(J > 0 && J < PETSC_MAX_REAL))
      MPMNoteBad(status, MPM_BAD_J, patch->points.id[p], dim, patch->points.x + p * dim, J);
    for (int k = 0; k < dim * dim; k++) F[k * MPM_BLOCK + l] = Fp[k];
  }
  MPMStageKinds(par, patch, n, order, kind);
  MPM_FOR_MATERIALS(par, n, kind, speed2[dim - 1], F, c2)
  for (PetscInt l = 0; l < n; l++) status->c2 = PetscMax(status->c2, c2[l]);
}

/* Index of the cell of position x if it is the patch's own; -1 in another patch, -2 outside of the grid. base: its
 * node. */
MPM_INLINE PetscInt MPMOwnCell(int dim, MPMBasis basis, const MPMPatch *patch, const PetscReal x[], PetscInt base[])
{
  PetscReal xi[3];

  if (!MPMLocate(dim, basis, patch->grid, x, xi, base)) return -2;
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

/* x <- x + dx; the cell it is in now; counts the points that changed cell, and those that left the patch. */
MPM_INLINE void MPMCommit(int dim, MPMBasis basis, MPMPatch *patch, PetscInt p, PetscInt cell, const PetscReal dx[],
                          MPMStatus *status)
{
  PetscReal x[3];
  PetscInt  base[3], now;

  for (int d = 0; d < dim; d++) x[d] = patch->points.x[p * dim + d] + dx[d];
  MPMWrap(dim, patch->grid, x);
  for (int d = 0; d < dim; d++) patch->points.x[p * dim + d] = x[d];
  now = MPMOwnCell(dim, basis, patch, x, base);
  if (now == -2) MPMNoteBad(status, MPM_LEFT_GRID, patch->points.id[p], dim, x, 0);
  status->moved += now != cell;
  status->left += now < 0;
  patch->points.cell[p] = now;
}

/* From nodes to points: motion (8), (9); velocity gradient (3) and F; commit of the new position. */
MPM_INLINE void MPMG2P(int dim, MPMBasis basis, int parts, const MPMParams *par, MPMPatch *patch, MPMStatus *status)
{
  const int   nn = MPMStencilSize(dim, basis), nc = MPM_VEL_NC(dim);
  PetscInt    at[MPM_MAX_NODES];
  MPMStencils s;
  PetscReal   phi[MPM_MAX_NODES], dphi[MPM_MAX_NODES][3], L[MPM_BLOCK][9];

  MPMStencilOffsets(dim, basis, patch, at);
  for (PetscInt q = 0; q < patch->points.n; q += MPM_BLOCK) {
    const PetscInt *order = patch->own_order + q, n = PetscMin(MPM_BLOCK, patch->points.n - q);

    MPMStage(dim, basis, patch, n, order, &s);
    for (PetscInt l = 0; l < n; l++) {
      const PetscReal *base  = patch->vel + s.cell[l] * nc;
      PetscReal        vn[3] = {0}, an[3] = {0}; /* sum phi v', sum phi a */

      MPMShape(dim, basis, &s, l, phi, dphi);
      for (int d = 0; d < dim; d++) { /* a sum at a time: it stays in a register */
        if (parts & MPM_G2P_MOTION)
          for (int a = 0; a < nn; a++) {
            vn[d] += phi[a] * base[at[a] * nc + d];
            an[d] += phi[a] * base[at[a] * nc + dim + d];
          }
        if (parts & MPM_G2P_STRESS)
          for (int e = 0; e < dim; e++) {
            PetscReal sum = 0;

            for (int a = 0; a < nn; a++) sum += base[at[a] * nc + d] * dphi[a][e];
            L[l][d * dim + e] = sum;
          }
      }
      if (parts & MPM_G2P_MOTION) {
        PetscReal *v = patch->points.v + order[l] * dim, v2 = 0, dx[3];

        for (int d = 0; d < dim; d++) {
          v[d] = par->flip * (v[d] + par->dt * an[d]) + (1 - par->flip) * vn[d];
          v2 += v[d] * v[d];
          dx[d] = par->dt * vn[d];
        }
        status->v2 = PetscMax(status->v2, v2);
        if (parts & MPM_G2P_COMMIT)
          MPMCommit(dim, basis, patch, order[l], s.cell[l], dx, status);
        else
          for (int d = 0; d < dim; d++) patch->points.dx[order[l] * dim + d] = dx[d];
      }
      if ((parts & MPM_G2P_COMMIT) && !(parts & MPM_G2P_MOTION))
        MPMCommit(dim, basis, patch, order[l], s.cell[l], patch->points.dx + order[l] * dim, status);
    }
    if (parts & MPM_G2P_STRESS) MPMUpdateF(dim, par, patch, n, order, L, status);
  }
}

#endif
