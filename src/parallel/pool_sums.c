/* pool_sums.c - the sums that a worker sends to the master where workers keep the particles (-pool_particles workers): the
   tiles that have particles, the sums of those at borders, and the sums of the nodes that are complete at the worker. */
#include "kernels/tile_index.h"
#include "parallel/pool_keep.h"

/* Sets how many nodes there are whose sums are complete here, and in how many ranges; lists these if list is not NULL. */
void MPMKeepRanges(const MPMCore *core, PetscInt *ranges, PetscInt *nodes, MPMKeepRange *list)
{
  const MPMKeepBase *base  = (const MPMKeepBase *)core->exchange.pool;
  const MPMPatch    *patch = &core->exchange.patch;

  *ranges = *nodes = 0;
  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++)
    for (PetscInt i = patch->span[r].first; i < patch->span[r].last; i++) {
      const PetscInt first = i, *whose = base->whose + r * patch->n[0];

      while (i < patch->span[r].last && whose[i] == base->rank) i++;
      if (i == first) continue;
      if (list) list[*ranges] = (MPMKeepRange){r * patch->n[0] + first, i - first};
      ++*ranges;
      *nodes += i - first;
    }
}

/* Returns how many tiles have particles, and lists them with their numbers if list is not NULL. */
PetscInt MPMKeepTiles(const MPMCore *core, MPMKeepTile *list)
{
  const MPMTiles *t   = &core->exchange.patch.tiles;
  const int       dim = (int)core->grid.dim;
  PetscInt        n   = 0;

  for (PetscInt row = 0; row < t->n[1] * t->n[2]; row++)
    for (PetscInt i = t->used[row][0]; i < t->used[row][1]; i++) {
      if (t->slot[row * t->n[0] + i] == MPM_TILE_EMPTY) continue;
      if (list) list[n] = (MPMKeepTile){row * t->n[0] + i, 0};
      for (PetscInt in = 0; in < 1 << t->bits * (dim - 1) && list; in++) {
        const PetscInt *cell = t->start + MPMTileRowCell(dim, t, row, in) + (i << t->bits);

        list[n].n += cell[1 << t->bits] - cell[0];
      }
      n++;
    }
  return n;
}

/* Packs the tiles that have particles, the sums of those at borders, and the sums that are complete, at *m. */
PetscErrorCode MPMKeepPackSums(MPMCore *core, const MPMPhase *phase, MPMKeepAnswer *answer, char *begin, char **m)
{
  const MPMPatch *patch = &core->exchange.patch;
  MPMKeepTile    *tile  = (MPMKeepTile *)*m;
  MPMKeepRange   *range;
  PetscInt        which[MPM_NODE_NC], nodes;
  const PetscInt  nc = MPMNodeSums(core->grid.dim, phase->parts, which);
  PetscReal      *to;

  PetscFunctionBeginUser;
  answer->tiles = MPMKeepTiles(core, tile);
  *m            = MPMKeepAlign(begin, (char *)(tile + answer->tiles));
  for (PetscInt k = 0; k < answer->tiles; k++)
    if (patch->tiles.slot[tile[k].tile] >= 0)
      *m += MPMTilesCopy(patch, patch->tiles.slot[tile[k].tile], phase->parts, PETSC_TRUE, *m);
  range = (MPMKeepRange *)*m;
  MPMKeepRanges(core, &answer->ranges, &nodes, range);
  to = (PetscReal *)MPMKeepAlign(begin, (char *)(range + answer->ranges));
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscInt k = 0; k < answer->ranges; k++)
    for (PetscInt i = range[k].first; i < range[k].first + range[k].n; i++)
      for (PetscInt c = 0; c < nc; c++) *to++ = ((const PetscReal *)(patch->node + i))[which[c]];
  PetscCall(MPMExchangeCloseNodes(core));
  *m = (char *)to;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the numbers of particles of a worker's tiles, and the sums of those at borders; notes where those of nodes are. */
PetscErrorCode MPMKeepTakeSums(MPMCore *core, MPMKeep *keep, const MPMPhase *phase, PetscMPIInt from,
                               const MPMKeepAnswer *answer, PetscInt64 *n)
{
  MPMPatch          *patch = &core->exchange.patch;
  MPMKeepWorker     *w     = &keep->worker[from];
  const MPMKeepTile *tile  = (const MPMKeepTile *)(w->in + sizeof *answer);
  char              *m     = MPMKeepAlign(w->in, (char *)(tile + answer->tiles));

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < answer->tiles; k++) {
    PetscCheck(keep->base.owner[tile[k].tile] == from && !keep->count[tile[k].tile], PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "worker %d sent sums of tile %" PetscInt_FMT ", which is not its own", from, tile[k].tile);
    keep->count[tile[k].tile] = tile[k].n;
    *n += tile[k].n;
    if (!keep->base.border[tile[k].tile]) continue;
    PetscCall(MPMTilesCome(patch, tile[k].tile));
    m += MPMTilesCopy(patch, patch->tiles.slot[tile[k].tile], phase->parts, PETSC_FALSE, m);
  }
  w->range   = (const MPMKeepRange *)m;
  w->nranges = answer->ranges;
  w->sums    = (const PetscReal *)MPMKeepAlign(w->in, (char *)(w->range + w->nranges));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the sums of the nodes that workers have completed, after those of tiles at borders have been added up to nodes.
   Phases visit all nodes between the first and the last of a row; those that nobody touches have sums of 0. */
PetscErrorCode MPMKeepTakeNodes(MPMCore *core, MPMKeep *keep, const MPMPhase *phase)
{
  MPMPatch      *patch = &core->exchange.patch;
  const PetscInt rows = patch->n[1] * patch->n[2], dim = core->grid.dim;
  const PetscInt c0 = MPM_NODE_FIRST(phase->parts), c1 = MPM_NODE_LAST(dim, phase->parts);
  PetscInt       which[MPM_NODE_NC];
  const PetscInt nc = MPMNodeSums(dim, phase->parts, which);
  MPMSpan       *before;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(rows, &before));
  PetscCall(PetscArraycpy(before, patch->span, rows));
  for (PetscMPIInt w = 1; w < keep->base.size; w++)
    for (PetscInt k = 0; k < keep->worker[w].nranges; k++) {
      const MPMKeepRange *range = &keep->worker[w].range[k];
      MPMSpan            *span  = &patch->span[range->first / patch->n[0]];
      const PetscInt      first = range->first % patch->n[0];

      span->first = PetscMin(span->first, first);
      span->last  = PetscMax(span->last, first + range->n);
    }
  for (PetscInt r = 0; r < rows; r++)
    for (PetscInt i = patch->span[r].first; i < patch->span[r].last; i++) {
      PetscReal *node = (PetscReal *)(patch->node + r * patch->n[0] + i);

      if (i >= before[r].first && i < before[r].last) continue; /* it has been zeroed */
      if ((phase->parts & MPM_P2G_MASS) && (phase->parts & MPM_P2G_FORCE))
        memset(node, 0, sizeof *patch->node);
      else
        for (PetscInt c = c0; c < c1; c++) node[c] = 0;
    }
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    const PetscReal *sum = keep->worker[w].sums;

    for (PetscInt k = 0; k < keep->worker[w].nranges; k++)
      for (PetscInt i = 0; i < keep->worker[w].range[k].n; i++) {
        PetscReal *node = (PetscReal *)(patch->node + keep->worker[w].range[k].first + i);

        for (PetscInt c = 0; c < nc; c++) node[which[c]] = *sum++;
      }
  }
  PetscCall(PetscFree(before));
  PetscFunctionReturn(PETSC_SUCCESS);
}
