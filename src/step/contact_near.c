/* contact_near.c - which particles may be near matter of another copy of the grid's nodes, or near rigid bodies. Tiles that
   have particles of one copy next to a tile that has particles of the other one are looked at, and no others, of these
   cells near a cell with particles of the other: so bodies that do not meet cost a loop over tiles. */
#include "step/contact_search.h"

/* Sets at [3] to the place of an own tile among those of a copy, and returns the copy. */
static PetscInt TilePlace(const Search *s, PetscInt tile, PetscInt at[])
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  edge  = MPMTileEdge(patch->basis),
                 own[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};
  PetscInt copy         = 0;

  for (PetscInt d = 0; d < 3; d++) {
    at[d] = (patch->own_lo[d] + grid->layers[d]) / edge + own[d] - t->below[d];
    if (d != grid->stack) continue;
    copy = at[d] / s->n[d];
    at[d] %= s->n[d];
  }
  return copy;
}

static PetscBool HasTile(const Search *s, PetscInt copy, const PetscInt at[])
{
  const PetscInt bit = (at[2] * s->n[1] + at[1]) * s->n[0] + at[0];

  return s->tiles[copy * s->words + bit / 64] >> bit % 64 & 1 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether a copy has particles in a tile or in one beside it. */
static PetscBool IsNear(const Search *s, PetscInt copy, const PetscInt at[])
{
  const MPMGrid *grid = &s->core->grid;

  for (PetscInt q = 0; q < 27; q++) {
    const PetscInt by[3] = {q % 3 - 1, q / 3 % 3 - 1, q / 9 - 1};
    PetscInt       to[3];
    PetscBool      inside = PETSC_TRUE;

    for (PetscInt d = 0; d < 3; d++) {
      to[d] = at[d] + by[d];
      if (grid->periodic[d]) to[d] = (to[d] + s->n[d]) % s->n[d];
      if (to[d] < 0 || to[d] >= s->n[d]) inside = PETSC_FALSE;
    }
    if (inside && HasTile(s, copy, to)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns the next one of the patch's own tiles that has particles after `tile`, or the first one after -1; or -1. */
static PetscInt NextTile(const MPMTiles *t, PetscInt tile)
{
  PetscInt row = tile < 0 ? 0 : tile / t->n[0], i = tile < 0 ? t->below[0] : tile % t->n[0] + 1;

  for (; row < t->n[1] * t->n[2]; row++, i = t->below[0]) {
    if (row % t->n[1] < t->below[1] || row / t->n[1] < t->below[2]) continue;
    for (i = PetscMax(i, t->used[row][0]); i < t->used[row][1]; i++)
      if (t->slot[row * t->n[0] + i] != MPM_TILE_EMPTY) return row * t->n[0] + i;
  }
  return -1;
}

/* Returns whether the boxes around the tiles of two copies, or tiles beside them, have any in common. */
static PetscBool BoxesMeet(const Search *s, const MPMPair *pair)
{
  if (pair->rigid) return PETSC_FALSE;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt *a = s->box[pair->a], *b = s->box[pair->b];

    if (a[3 + d] < 0 || b[3 + d] < 0) return PETSC_FALSE; /* no particles */
    if (!s->core->grid.periodic[d] && (a[3 + d] + 1 < -b[d] || b[3 + d] + 1 < -a[d])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Finds the tiles that have particles, of all processes, and sets *any to whether bodies of a pair are near each other
   somewhere. Collective on exchange.data. */
static PetscErrorCode FindTiles(Search *s, PetscBool *any)
{
  const MPMGrid  *grid = &s->core->grid;
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const PetscInt  edge = MPMTileEdge(s->core->basis);
  PetscInt        all  = 1, at[3];
  PetscBool       near = PETSC_FALSE;
  PetscMPIInt     count;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    s->n[d] = ((d == grid->stack && grid->copies > 1 ? grid->stride : grid->nodes[d]) + edge - 1) / edge;
    all *= s->n[d];
  }
  s->words = (all + 63) / 64;
  *any     = PETSC_FALSE;
  if (grid->copies < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(grid->copies * s->words, &s->tiles));
  for (PetscInt c = 0; c < grid->copies; c++)
    for (PetscInt d = 0; d < 6; d++) s->box[c][d] = PETSC_MIN_INT;
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt copy, bit;

    copy = TilePlace(s, tile, at);
    bit  = (at[2] * s->n[1] + at[1]) * s->n[0] + at[0];
    s->tiles[copy * s->words + bit / 64] |= (uint64_t)1 << bit % 64;
    for (PetscInt d = 0; d < 3; d++) {
      s->box[copy][d]     = PetscMax(s->box[copy][d], -at[d]);
      s->box[copy][3 + d] = PetscMax(s->box[copy][3 + d], at[d]);
    }
  }
  PetscCall(PetscMPIIntCast(6 * grid->copies, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->box, count, MPIU_INT, MPI_MAX, s->core->exchange.data));
  for (PetscInt k = 0; k < s->c->npairs; k++) near = BoxesMeet(s, &s->c->pair[k]) ? PETSC_TRUE : near;
  if (!near) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMPIIntCast(grid->copies * s->words, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->tiles, count, MPI_UINT64_T, MPI_BOR, s->core->exchange.data));
  for (PetscInt k = 0; k < s->c->npairs && !*any; k++)
    for (PetscInt bit = 0; bit < all && !*any && BoxesMeet(s, &s->c->pair[k]); bit++) {
      if (!s->tiles[s->c->pair[k].a * s->words + bit / 64]) {
        bit |= 63;
        continue;
      }
      at[0] = bit % s->n[0];
      at[1] = bit / s->n[0] % s->n[1];
      at[2] = bit / (s->n[0] * s->n[1]);
      if (HasTile(s, s->c->pair[k].a, at) && IsNear(s, s->c->pair[k].b, at)) *any = PETSC_TRUE;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells that have particles: a bit for each of a tile, which has 64 at most. Collective on exchange.data. */
static PetscErrorCode FindCells(Search *s)
{
  const MPMGrid  *grid = &s->core->grid;
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)grid->dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits, all = s->n[0] * s->n[1] * s->n[2];
  PetscMPIInt     count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->copies * all, &s->cells));
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt  at[3], copy;
    uint64_t *cells;

    copy  = TilePlace(s, tile, at);
    cells = s->cells + copy * all + (at[2] * s->n[1] + at[1]) * s->n[0] + at[0];
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + tile % t->n[0] * edge;

      for (PetscInt i = 0; i < edge; i++)
        if (cell[i] < cell[i + 1]) *cells |= (uint64_t)1 << (in * edge + i);
    }
  }
  PetscCall(PetscMPIIntCast(grid->copies * all, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->cells, count, MPI_UINT64_T, MPI_BOR, s->core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a copy has particles in a cell so near to one of a tile at place `at` [3], cell number `in` of it, that
   both touch the same nodes or the next ones. */
static PetscBool IsCellNear(const Search *s, PetscInt copy, const PetscInt at[], PetscInt in)
{
  const MPMGrid *grid = &s->core->grid;
  const PetscInt bits = s->core->exchange.patch.tiles.bits, edge = 1 << bits, reach = MPMBasisNodes(s->core->basis);
  PetscInt       lo[3] = {0}, hi[3] = {0}, to[3];

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscInt cell = at[d] * edge + (in >> bits * d & (edge - 1));

    lo[d] = cell - reach;
    hi[d] = cell + reach;
  }
  for (to[2] = lo[2]; to[2] <= hi[2]; to[2]++)
    for (to[1] = lo[1]; to[1] <= hi[1]; to[1]++)
      for (to[0] = lo[0]; to[0] <= hi[0]; to[0]++) {
        PetscInt  tile = 0, bit = 0;
        PetscBool inside = PETSC_TRUE;

        for (PetscInt d = 2; d >= 0; d--) {
          PetscInt cell = to[d];

          if (grid->periodic[d]) cell = (cell + grid->cells[d]) % grid->cells[d];
          if (cell < 0 || cell >= s->n[d] * edge) inside = PETSC_FALSE;
          tile = tile * s->n[d] + (cell >> bits);
          if (d < grid->dim) bit = (bit << bits) + (cell & (edge - 1));
        }
        if (inside && s->cells[copy * s->n[0] * s->n[1] * s->n[2] + tile] >> bit & 1) return PETSC_TRUE;
      }
  return PETSC_FALSE;
}

/* Makes room for n more particles in the list. */
static PetscErrorCode MakeRoom(Search *s, PetscInt n)
{
  PetscFunctionBeginUser;
  if (s->nwanted + n <= s->most) PetscFunctionReturn(PETSC_SUCCESS);
  s->most = 2 * (s->nwanted + n);
  PetscCall(PetscRealloc((size_t)s->most * sizeof *s->wanted, &s->wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a tile at place `at` [3] may have particles near a rigid body. */
static PetscBool IsRigidNear(const Search *s, const MPMRigid *rigid, const PetscInt at[])
{
  const MPMGrid *grid = &s->core->grid;
  const PetscInt edge = MPMTileEdge(s->core->basis);
  PetscReal      x[3] = {0}, n[3], half = 0, distance;

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal wide = 0.5 * (PetscReal)(edge + MPMBasisNodes(s->core->basis)) * grid->h[d];

    x[d] = grid->lower[d] + (PetscReal)(at[d] * edge - grid->layers[d]) * grid->h[d] + wide;
    half += PetscSqr(wide);
  }
  half = PetscSqrtReal(half);
  distance = MPMRigidDistance(rigid, grid->dim, x, n);
  return (rigid->tied ? distance : PetscAbsReal(distance)) < half + s->reach ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether particle p is near a rigid body: near its surface, of one that is tied also inside. */
static PetscBool IsParticleNear(const Search *s, const MPMRigid *rigid, PetscInt p)
{
  const PetscInt  dim = s->core->grid.dim;
  PetscReal       n[3];
  const PetscReal distance = MPMRigidDistance(rigid, dim, s->view.x + p * dim, n);

  return distance < s->reach && (rigid->tied || distance > -s->reach) ? PETSC_TRUE : PETSC_FALSE;
}

/* Lists those near a rigid body, as ListParticles does. */
static PetscErrorCode ListNearRigid(Search *s, PetscInt pair)
{
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)s->core->grid.dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits;
  const MPMRigid *rigid = s->c->pair[pair].rigid;

  PetscFunctionBeginUser;
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt at[3];

    if (TilePlace(s, tile, at) != s->c->pair[pair].b || !IsRigidNear(s, rigid, at)) continue;
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + tile % t->n[0] * edge;

      PetscCall(MakeRoom(s, cell[edge] - cell[0]));
      for (PetscInt q = cell[0]; q < cell[edge]; q++)
        if (IsParticleNear(s, rigid, s->core->particles.order[q]))
          s->wanted[s->nwanted++] = s->core->particles.order[q];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the particles here of one side (0: a, 1: b) of a pair that are near matter of the other one: from s->nwanted on. */
static PetscErrorCode ListParticles(Search *s, PetscInt pair, int side)
{
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)s->core->grid.dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits;
  const PetscInt  own  = side ? s->c->pair[pair].b : s->c->pair[pair].a,
                 other = side ? s->c->pair[pair].a : s->c->pair[pair].b;

  PetscFunctionBeginUser;
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt at[3];

    if (TilePlace(s, tile, at) != own || !IsNear(s, other, at)) continue;
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + tile % t->n[0] * edge;

      for (PetscInt i = 0; i < edge; i++) {
        const PetscInt n = cell[i + 1] - cell[i];

        if (!n || !IsCellNear(s, other, at, in * edge + i)) continue;
        PetscCall(MakeRoom(s, n));
        PetscCall(PetscArraycpy(s->wanted + s->nwanted, s->core->particles.order + cell[i], n));
        s->nwanted += n;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists those of all pairs. */
static PetscErrorCode ListAll(Search *s, PetscBool any)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * s->c->npairs + 1, &s->first));
  for (PetscInt k = 0; k < 2 * s->c->npairs; k++) {
    s->first[k] = s->nwanted;
    if (s->c->pair[k / 2].rigid && k % 2) PetscCall(ListNearRigid(s, k / 2));
    if (!s->c->pair[k / 2].rigid && any) PetscCall(ListParticles(s, k / 2, k % 2));
  }
  s->first[2 * s->c->npairs] = s->nwanted;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Calls act for each particle of one side of a pair that is near matter of the other one. */
PetscErrorCode MPMContactForParticles(Search *s, PetscInt pair, int side,
                                      PetscErrorCode (*act)(Search *, PetscInt, int, PetscInt))
{
  PetscFunctionBeginUser;
  for (PetscInt k = s->first[2 * pair + side]; k < s->first[2 * pair + side + 1]; k++)
    PetscCall(act(s, pair, side, s->wanted[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMContactNear(Search *s, PetscBool *any)
{
  PetscBool meet = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < s->core->grid.dim; d++)
    s->reach = PetscMax(s->reach, (0.5 * MPMBasisNodes(s->core->basis) + 1) * s->core->grid.h[d]);
  PetscCall(FindTiles(s, &meet));
  *any = meet || s->core->rigids.n ? PETSC_TRUE : PETSC_FALSE;
  if (!*any) PetscFunctionReturn(PETSC_SUCCESS);
  if (meet) PetscCall(FindCells(s));
  PetscCall(ListAll(s, meet));
  PetscFunctionReturn(PETSC_SUCCESS);
}
