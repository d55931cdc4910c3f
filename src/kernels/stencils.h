/* stencils.h - the stencils of a block of particles: base nodes, weights, gradients and the ends of its cells; and the
   material state of the block. Every transfer begins a block with MPMStage. */
#ifndef MPM_STENCILS_H
#define MPM_STENCILS_H

#include "kernels/blocks.h"
#include "kernels/round.h"
#include "kernels/tile_index.h"

/* Sets mass, volume, half-widths and whether there is an F of particles first .. last-1 to those of kind k. */
MPM_INLINE void MPMStageKind(int dim, const MPMParams *par, const MPMKind *k, PetscInt first, PetscInt last,
                             MPMStencils *s)
{
  const PetscReal m = k->m, V0 = k->V0, copy = (PetscReal)s->first[s->place[k->copy]] * s->stride;
  const PetscReal has_F = par->materials[k->material].state & MPM_BIT(F) ? 1 : 0;

  for (PetscInt l = first; l < last; l++) {
    s->m[l]     = m;
    s->V0[l]    = V0;
    s->copy[l]  = copy;
    s->has_F[l] = has_F;
  }
  for (int d = 0; d < dim; d++) {
    const PetscReal half = k->l[d];

    for (PetscInt l = first; l < last; l++) s->l[d][l] = half;
  }
}

/* Does so for the particles of a block. A lane whose particle in the block before was of the same kind has all that
   already, so nothing is left to do for most blocks. */
MPM_INLINE void MPMStageKinds(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                              MPMStencils *s)
{
  const PetscInt *kinds = patch->particles.kind, full = MPM_BLOCK_PARTICLES(dim);
  PetscInt        changed = 0;

  if (o->adjacent) { /* a full block; with no early exit, so that the compiler makes vectors of it */
    for (PetscInt l = 0; l < full; l++) changed |= kinds[o->particle[0] + l] ^ s->kind[l];
    if (!changed) return;
  }
  for (PetscInt l = 0, end; l < o->lanes; l = end) { /* for a sequence of particles of a kind at a time */
    const PetscInt kind = kinds[o->particle[l]];

    changed = 0;
    for (end = l; end < o->lanes && kinds[o->particle[end]] == kind; end++) {
      changed |= kind ^ s->kind[end];
      s->kind[end] = kind;
    }
    if (changed) MPMStageKind(dim, par, par->kinds + kind, l, end, s);
  }
}

/* Sets what does not change from block to block. */
MPM_INLINE void MPMStencilsBegin(int dim, const MPMParams *par, const MPMPatch *patch, MPMStencils *s)
{
  const MPMGrid *grid = patch->grid;

  memset(s, 0, sizeof *s);
  s->place  = grid->place;
  s->first  = grid->first;
  s->stride = grid->places > 1 ? 1 : 0;
  for (PetscInt d = 0; d < grid->stack; d++) s->stride *= (PetscReal)patch->n[d];
  MPMStageKind(dim, par, par->kinds, 0, MPM_BLOCK, s);
  for (int d = 0; d < dim; d++) {
    const PetscReal far = PetscMax(PetscAbsReal(grid->lower[d]), PetscAbsReal(grid->upper[d]));

    s->axis[d] = (MPMAxis){
        .lower   = grid->lower[d],
        .h       = grid->h[d],
        .inverse = 1 / grid->h[d],
        .cells   = grid->cells[d],
        .first   = patch->lo[d],
        .n       = patch->n[d],
        .reach   = MPMWallReach(patch->basis, grid->wall_basis[d]),
        .bases   = MPMBasisBasesOf(patch->basis, grid->cells[d], grid->periodic[d], grid->wall_basis[d]),
        .middle  = MPMBasisMiddle(patch->basis),
        .near    = 0.5 - 16 * PETSC_MACHINE_EPSILON * (far / grid->h[d] + grid->cells[d])};
  }
}

/* Sets the weights of a spline near walls, particle by particle. */
static __attribute__((noinline)) void MPMStageWalls(int dim, MPMBasis basis, const MPMGrid *grid, PetscInt n,
                                                    MPMStencils *s)
{
  for (PetscInt l = 0; l < n; l++)
    for (int d = 0; d < dim; d++) {
      const PetscReal cells = (PetscReal)grid->cells[d], xi = (s->x[d][l] - grid->lower[d]) / grid->h[d];
      PetscReal       w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];

      if (!MPMWallWeights(basis, PetscMin(xi, cells), grid->cells[d], grid->wall_basis[d], w, g)) continue;
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        s->w[d][i][l] = w[i];
        s->g[d][i][l] = g[i] * (1 / grid->h[d]);
      }
    }
}

/* Computes base nodes and weights of a block of particles; their positions were checked when they were committed. */
MPM_INLINE void MPMStageWeights(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt lanes, MPMStencils *s)
{
  const PetscBool round   = patch->grid->round && basis == MPM_BASIS_gimp ? PETSC_TRUE : PETSC_FALSE;
  const MPMAxis   axes[3] = {s->axis[0], s->axis[1], s->axis[2]}; /* a copy, which no write changes */
  MPMReal         least[3], most[3];                              /* of xi */
  PetscBool       wall = PETSC_FALSE;

  for (int d = 0; d < dim; d++) least[d] = MPMAll(axes[d].cells), most[d] = MPMAll(0);
  for (PetscInt q = 0; q < lanes; q += MPM_WIDTH) {
    MPMReal index = MPMAll(0);

    MPM_UNROLL
    for (int d = dim - 1; d >= 0; d--) {
      const MPMAxis *axis = &axes[d];
      MPMReal        l    = MPMRead(&s->l[d][q]), base, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
      MPMReal        xi   = MPMDivide(MPMRead(&s->x[d][q]) - axis->lower, axis->h, axis->inverse);

      xi    = MPMMin(MPMAll(axis->cells), xi); /* the quotient may round up */
      base  = MPMBasisBases(basis, &axis->bases, l, &xi);
      index = d == dim - 1 ? base - axis->first : index * axis->n + (base - axis->first);
      if (round && d == 0) /* no domain reaches beyond the axis */
        l = MPMMin(l, MPMMax(xi + axis->lower * axis->inverse, MPMAll(MPM_ROUND_LEAST)));
      MPMBasisInside(basis, xi, l, base, w, g);
      MPMWrite(&s->at[d][q], xi - base);
      MPM_UNROLL
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        MPMWrite(&s->w[d][i][q], w[i]);
        MPMWrite(&s->g[d][i][q], g[i] * axis->inverse);
      }
      if (MPMBasisIsSpline(basis)) least[d] = MPMMin(least[d], xi), most[d] = MPMMax(most[d], xi);
    }
    MPMWrite(&s->base[q], patch->grid->places > 1 ? index + MPMRead(&s->copy[q]) : index);
  }
  for (int d = 0; d < dim && MPMBasisIsSpline(basis); d++)
    if (MPMAny((least[d] < axes[d].reach) | (axes[d].cells - most[d] < axes[d].reach))) wall = PETSC_TRUE;
  s->walled = wall;
  if (wall) MPMStageWalls(dim, basis, patch->grid, lanes, s);
}

/* Computes the stencils of a block of particles, and where its cells end. */
MPM_INLINE void MPMStage(int dim, const MPMParams *par, const MPMPatch *patch, MPMBlockOrder *o, MPMStencils *s)
{
  uint64_t ends = 0;

  MPMGather(dim, patch->grid->total ? patch->particles.X : patch->particles.x, o, s->x);
  if (par->nkinds > 1) MPMStageKinds(dim, par, patch, o, s);
  if (patch->particles.l) MPMGather(dim, patch->particles.l, o, s->l);
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (patch->basis == MPM_BASIS_##name) MPMStageWeights(dim, MPM_BASIS_##name, patch, o->lanes, s);
#include "physics/basis.def"
  /* A cell ends where the next particle has another base node. The last particle is compared with a leftover past it:
     that may set bit n, and MPMList takes only bits below n. */
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH)
    ends |= MPMSet(MPMRead(&s->base[l]) != MPMRead(&s->base[l] + 1), l) << 1;
  o->ncells             = MPMList(ends, o->n, o->end) + 1;
  o->end[o->ncells - 1] = o->n;
}

/* Returns the radii, m, of a vector of staged particles. */
MPM_INLINE MPMReal MPMRadius(const MPMStencils *s, PetscInt l)
{
  return MPMMax(MPMRead(&s->x[0][l]), MPMAll(MPM_ROUND_LEAST * s->axis[0].h));
}

/* Sets row 4 of velocity gradients to v_r/r, 1/s, of a block's particles. */
MPM_INLINE void MPMRoundGradient(const MPMBlockOrder *o, const MPMStencils *s, const MPMComponent vr, MPMComponent *L)
{
  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) MPMWrite(&L[4][l], MPMRead(vr + l) / MPMRadius(s, l));
}

/* The innermost loops of transfer_sums.c that sum over the nodes of a block's cells, for its particles:
   [dim-1][nodes per axis - 2][motion: 0 none, 1 all of it, 2 its first dim numbers, 3 the first one, in 2-D][stress].
   nodes [n2][n1][n0][MPM_MOTION_NC] has the motion of the patch's nodes. */
typedef void (*MPMInterpolateBlocks)(const MPMBlockOrder *, const MPMStencils *, const PetscInt n[],
                                     const PetscReal *nodes, MPMComponent *value, MPMComponent *gradient);
extern const MPMInterpolateBlocks MPM_LANES_NAME(MPMInterpolateBlock)[3][3][4][2];

#define MPM_MAX_NODES (MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL)

/* --- Materials ---------------------------------------------------------------------------------------------------- */

/* Repeats a statement for each sequence of lanes of a block that have the same material; lanes past the last particle
   repeat it. It declares m, the material, and its lanes first to next-1. (The inner loop runs once; it declares m.) */
#define MPM_FOR_MATERIALS(m, first, next, par, lanes, kind)                                                            \
  for (PetscInt first = 0, next = 0; first < (lanes); first = next)                                                    \
    for (const MPMMaterial *m = MPMSameMaterial(par, lanes, kind, first, &next); m; m = NULL)

/* Returns the material of lane `first`; lanes first to *next-1 have the same. */
MPM_INLINE const MPMMaterial *MPMSameMaterial(const MPMParams *par, PetscInt lanes, const PetscInt *kind,
                                              PetscInt first, PetscInt *next)
{
  const PetscInt row = par->kinds[kind[first]].material;

  *next = lanes;
  if (par->nmaterials > 1)
    for (*next = first + 1; *next < lanes && par->kinds[kind[*next]].material == row;) (*next)++;
  return par->materials + row;
}

/* Returns the functions of a material for this width if there are any, else those for one lane. */
MPM_INLINE const MPMMaterialLaw *MPMLaw(const MPMMaterial *m)
{
  const MPMMaterialLaw *law = m->type->law->lanes[MPM_WIDTH == 8 ? 0 : MPM_WIDTH == 4 ? 1 : 2];

  return law ? law : m->type->law;
}

/* Reads the fields `which` (bits) of the material state of a block's particles, as far as the phase declared them and a
   law of the block has them: in a scene of fluids and solids most blocks have no use for the fields of the others.
   Returns the fields (bits) of these laws. */
MPM_INLINE PetscInt MPMGatherState(int dim, const MPMParams *par, const MPMPatch *patch, PetscInt which,
                                   const MPMBlockOrder *o, const MPMStencils *s, MPMBlock *b)
{
  PetscInt state = 0;

  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind) state |= m->state;
#define MPM_GATHER(name, rows)                                                                                         \
  if (patch->particles.name && (which & (state | par->carried) & MPM_BIT(name)))                                       \
    MPMGather(MPMComponents_##name(dim), patch->particles.name, o, b->name);
  MPM_MATERIAL_FIELDS(MPM_GATHER)
#undef MPM_GATHER
  return state;
}

#endif
