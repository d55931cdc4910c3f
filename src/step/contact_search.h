/* contact_search.h - what the files that find contact share (contact_near.c, contact_normals.c, contact_columns.c,
   contact_find.c): a search, the stencils of single particles, and numbers of nodes. */
#ifndef MPM_CONTACT_SEARCH_H
#define MPM_CONTACT_SEARCH_H

#include <stdlib.h>
#include "kernels/cell.h"
#include "kernels/round.h"
#include "parallel/exchange.h"
#include "step/matter.h"
#include "step/step.h"

/* Of the depth to which single particles of what flows have crept into the other body, undone in a step: with 1e-4 water
   goes on to creep in, with 1e-3 blocks float a cell too high. */
#define MPM_CONTACT_PUSH 3e-4
#define UNIT             ldexp(1, -50) /* of sums of phi, and of the weights in sides of cells */

/* The sums at a node of a pair from which its normal comes, in units: of phi times 1, xi, xi xi^T (xx xy xz yy yz zz), c, c
   xi; xi = (x_p - x_i)/h. */
#define NSUMS 14
typedef struct {
  PetscInt   pair, ijk[3];
  PetscInt64 sum[NSUMS];
} Fit;

/* What the particles at the surface of one side tell a node of the normal, in units: sums of phi times the unit normal of the
   surface, and of phi. */
typedef PetscInt64 Faces[2][4];

/* A node of a pair or of a copy by a number, and its place in a list. */
typedef struct {
  PetscInt64 number;
  PetscInt   at;
} Key;

/* Nodes lo .. hi-1 of the patch's arrays. */
typedef struct {
  PetscInt lo[3], hi[3];
} Box;

/* What a search has: the records of nodes so far, and for each node of a box its record, from 1 on. */
typedef struct {
  MPMCore     *core;
  MPMContacts *c;
  MPMView      view;
  PetscReal    reach;                         /* m: what is nearer to a rigid body is looked at */
  uint64_t    *cells;                         /* [copies][tiles] bits of their cells that have particles */
  PetscInt    *wanted, *first, nwanted, most; /* the particles of each side of each pair that are near the other side */
  uint64_t    *mixed; /* [nwanted] the nodes of their stencils that the other side may touch too */
  Box         *box;   /* of each side of each pair: around all of these stencils */
  Fit         *fit;
  PetscInt     nfits, room, *map;
  Key         *key;    /* [nkeys] of nodes, each where its number is mapped to or behind it; at -1: none */
  size_t       nkeys;  /* a power of 2 */
  PetscReal   *normal; /* [nfits][3] */
  Faces       *faces;  /* [nfits] */
  PetscReal    full[MPM_MAX_COPIES]; /* particles of a cell that is full, of each copy */
} Search;

/* The stencil of a place: base node, nodes on each axis, weights and gradients, 1/cells. */
typedef struct {
  PetscInt  base[3], n[3];
  PetscReal xi[3], w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL];
} Stencil;

/* Sets the stencil of a place x [dim], m, by the domain of particle p. */
MPM_INLINE void SetStencilAt(const Search *s, PetscInt p, const PetscReal x[], Stencil *to)
{
  const MPMCore   *core = s->core;
  const MPMGrid   *grid = &core->grid;
  const int        dim  = (int)grid->dim;
  const PetscReal *l    = MPMHalfWidths(dim, core->params.kinds, &s->view, p);

  *to = (Stencil){.n = {1, 1, 1}};
  MPMCoordinates(dim, core->basis, grid, x, l, to->xi, to->base);
  for (int d = 0; d < dim; d++) {
    to->n[d] = MPMBasisNodes(core->basis);
    MPMBasisWeights(core->basis, to->xi[d], l[d], to->base[d], grid->cells[d], grid->wall_basis[d], to->w[d], to->g[d]);
  }
}

MPM_INLINE void SetStencil(const Search *s, PetscInt p, Stencil *to)
{
  SetStencilAt(s, p, s->view.x + p * s->core->grid.dim, to);
}

/* Sets ijk [3] to node at [3] of a stencil, as the grid numbers it across periodic faces. */
MPM_INLINE void SetIjk(const MPMGrid *grid, const Stencil *t, const PetscInt at[], PetscInt ijk[])
{
  for (PetscInt d = 0; d < 3; d++) {
    ijk[d] = d < grid->dim ? t->base[d] + at[d] : 0;
    if (grid->periodic[d]) ijk[d] = (ijk[d] + grid->cells[d]) % grid->cells[d];
  }
}

/* Returns whether the matter of a pair moves with a rigid body. */
MPM_INLINE PetscBool IsTied(const MPMPair *pair)
{
  return pair->rigid && pair->rigid->tied;
}

/* Returns how near nodes have to be to a rigid body that is tied, or to a body to which a fluid sticks, to be held, in
   cells along an axis. The last held node of a line is then as often outside as inside of the place from which the matter
   stretches as if it were held there: the node itself, with splines 1/4 and 1/3 of a cell behind it (measured 0.24 and
   0.33), which is sum phi (x_i - x)^2/h^2. */
MPM_INLINE PetscReal HeldWithin(MPMBasis basis)
{
  return 0.5 + 1e-9 + (MPMBasisIsSpline(basis) ? 1 / (PetscReal)MPMBasisInertia(basis) : 0);
}

/* Returns where the cells of row `in` of a tile of a patch, 2^bits of them, are among those of which `start` says where their
   particles begin in the order. */
MPM_INLINE const PetscInt *TileRow(int dim, const MPMTiles *t, PetscInt tile, PetscInt in)
{
  return t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + (tile % t->n[0] << t->bits);
}

/* Returns whether node at [3] of a stencil is among some of its nodes (bits). */
MPM_INLINE PetscBool IsAmong(const Stencil *t, const PetscInt at[], uint64_t some)
{
  return (some >> ((at[2] * t->n[1] + at[1]) * t->n[0] + at[0]) & 1) != 0;
}

#define FOR_STENCIL(t, at)                                                                                             \
  for (at[2] = 0; at[2] < (t)->n[2]; at[2]++)                                                                          \
    for (at[1] = 0; at[1] < (t)->n[1]; at[1]++)                                                                        \
      for (at[0] = 0; at[0] < (t)->n[0]; at[0]++)

/* A number for each node of a pair, or of a copy. */
MPM_INLINE PetscInt64 KeyOf(const MPMGrid *grid, PetscInt of, const PetscInt ijk[])
{
  PetscInt64 key = of;

  for (PetscInt d = grid->dim - 1; d >= 0; d--)
    key = key * (grid->cells[d] + 2 * MPM_GRID_APART) + ijk[d] + MPM_GRID_APART;
  return key;
}

/* Returns where a number is in the table of the keys, or the empty place where it belongs. */
MPM_INLINE Key *PlaceOfKey(const Search *s, PetscInt64 number)
{
  size_t at = (size_t)(((uint64_t)number * 0x9e3779b97f4a7c15u) >> 32) & (s->nkeys - 1);

  while (s->key[at].at >= 0 && s->key[at].number != number) at = (at + 1) & (s->nkeys - 1);
  return &s->key[at];
}

/* Returns the place of a number in the list of the keys, or -1. */
MPM_INLINE PetscInt FindKey(const Search *s, PetscInt64 number)
{
  return PlaceOfKey(s, number)->at;
}

/* Sets the keys to the numbers of n nodes, whose records of so many bytes have pair and ijk at these offsets. */
MPM_INLINE PetscErrorCode SetKeys(Search *s, PetscInt n, const void *first, size_t bytes, size_t pair, size_t ijk)
{
  PetscFunctionBeginUser;
  for (s->nkeys = 16; s->nkeys < 2 * (size_t)n;) s->nkeys *= 2;
  PetscCall(PetscRealloc(s->nkeys * sizeof *s->key, &s->key));
  for (size_t k = 0; k < s->nkeys; k++) s->key[k].at = -1;
  for (PetscInt k = 0; k < n; k++) {
    const char *row = (const char *)first + (size_t)k * bytes;
    const Key   key = {KeyOf(&s->core->grid, *(const PetscInt *)(row + pair), (const PetscInt *)(row + ijk)), k};

    *PlaceOfKey(s, key.number) = key;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tiles (contact_tiles.c). Find finds those here that have particles of each copy, and the boxes around those of all processes;
   Collect collects those of all processes; both are collective on exchange.data. Place sets at [3] to where an own tile is
   among those of the grid, and Copy also returns the copy of its particles: copies at the same place have none in the same
   tile. Next returns the next one of the patch's own tiles that has particles after `tile`, or the first one after -1, or -1.
   IsNear returns whether a copy has particles in a tile at most `by` tiles from `at`. List lists the own tiles beside those
   of other copies. */
PetscErrorCode MPMContactFindTiles(MPMCore *);
PetscErrorCode MPMContactCollectTiles(MPMCore *);
void           MPMContactTilePlace(const MPMCore *, PetscInt tile, PetscInt at[]);
PetscInt       MPMContactTileCopy(const MPMCore *, const MPMView *, PetscInt tile, PetscInt at[]);
PetscInt       MPMContactNextTile(const MPMTiles *, PetscInt tile);
PetscBool      MPMContactIsNear(const MPMCore *, PetscInt copy, const PetscInt at[], PetscInt by);
PetscErrorCode MPMContactListTiles(MPMCore *);

/* Find which particles are near matter of another copy, or near rigid bodies (contact_near.c); call a function for those of one
   side, 0: a, 1: b, of a pair; find the records `fit` of nodes and the normals there (contact_normals.c); make parts and
   columns of the nodes (contact_columns.c). All but the second are collective on exchange.data. */
PetscErrorCode MPMContactNear(Search *);
typedef PetscErrorCode (*MPMContactAct)(Search *, PetscInt pair, int side, PetscInt p, uint64_t mixed);
PetscErrorCode MPMContactForParticles(Search *, PetscInt pair, int side, MPMContactAct);
PetscErrorCode MPMContactNormals(Search *);
PetscErrorCode MPMContactColumns(MPMCore *);

#endif
