/* patch.h - what a kernel works on: the constants of a step, and a patch, which is a box of cells with their particles,
   the nodes there and around, and tiles. */
#ifndef MPM_PATCH_H
#define MPM_PATCH_H

#include <stddef.h>
#include "base/status.h"
#include "physics/grid.h"
#include "physics/material.h"

struct MPMWalls; /* physics/wall.h, which kernels of particles do not see */

/* Constants of a step: all that kernels know of the scene. */
typedef struct {
  PetscReal              dt, flip, gravity[3]; /* s, 1, m/s^2 */
  PetscInt               xpic;                 /* order of xpic, else 0 */
  const MPMKind         *kinds;
  PetscInt               nkinds;
  const MPMMaterial     *materials;
  const struct MPMWalls *walls;
} MPMParams;

/* What a node sums from particles: the same record in every dimension, one vector of 8 numbers or a whole number of
   shorter ones, which lies in one line of the cache. */
typedef struct {
  PetscReal m, p[3], f[3]; /* mass in kg, momentum in kg m/s, force in N */
  PetscReal met;           /* axes (bits, a whole number) along which the advance met a wall that only pushes */
} MPMNode;
#define MPM_NODE_NC    8 /* the record as numbers, for vectors and messages */
#define MPM_NODE_FORCE 4
_Static_assert(sizeof(MPMNode) == 8 * sizeof(PetscReal), "the record of a node is one line of the cache");
_Static_assert(offsetof(MPMNode, p) == sizeof(PetscReal), "momentum follows the mass");
_Static_assert(offsetof(MPMNode, f) == MPM_NODE_FORCE * sizeof(PetscReal), "forces begin at their place");

/* The first number of the record that parts of a transfer (transfer.h) sum, and the one after the last. */
#define MPM_NODE_FIRST(dim, parts) ((parts)&MPM_P2G_MASS ? 0 : (parts)&MPM_P2G_MOMENTUM ? 1 : MPM_NODE_FORCE)
#define MPM_NODE_LAST(dim, parts)  ((parts)&MPM_P2G_FORCE ? MPM_NODE_FORCE + (dim) : 1 + (dim))

/* Numbers that tell the motion of a node: velocity [dim] in m/s and acceleration [dim] in m/s^2. */
#define MPM_MOTION_NC(dim) (2 * (dim))

/* Tiles: blocks of 2^bits cells an axis, counted from the first node of the grid. A "cell" is the base node of a
   particle's stencil. Particles are added up in tiles, each with its own sums of all nodes that its particles touch,
   `side` on an axis; then nodes add up the tiles that have some for them, from the lowest to the highest. Both sums are
   made the same wherever the tiles are, and tiles are never cut: hence the same bits however the grid is cut, without
   anything being computed twice. */
#define MPM_TILE_BITS(stencil) ((stencil) > 2 ? 2 : 1) /* 2 or 4 cells, about twice what a stencil reaches */

/* On one axis, a tile has nodes 0 .. end-1, of which from .. to-1 are the patch's own; 0 is node `at` of its arrays. */
typedef struct {
  PetscInt from, to, end, at;
} MPMTileBox;

/* A run of the order: entries first .. last-1, particles of a row of tiles. */
typedef struct {
  PetscInt first, last, row;
} MPMRange;

/* Which tiles a sweep of particles to nodes is for. MPM_PASS_EARLY: those whose sums another process needs, or which
   are needed across a periodic face before the main pass; all in the pool. MPM_PASS_LATE: where sums of other processes
   have to come first, others of the first rows, so that these need not be waited for. MPM_PASS_MAIN: all others; and
   the sums of all are added to the nodes. Sums of early and late tiles are kept. */
typedef enum { MPM_PASS_MAIN, MPM_PASS_EARLY, MPM_PASS_LATE, MPM_NUM_PASSES } MPMPass;

/* What the table of tiles says of one: which sums are kept (>= 0), it has particles, or none. */
enum { MPM_TILE_SCRATCH = -1, MPM_TILE_EMPTY = -2 };

/* Instead of the number of a cell or a base node: that of the position is in another patch, or it is outside the
   grid. */
enum { MPM_ELSEWHERE = -1, MPM_NOWHERE = -2 };

/* The tiles of a patch: a table of its own and of those `below` whose particles touch its nodes. Cells are numbered row
   by row of cells (x fastest), those of a row of tiles first: so kernels stream through particles, and a row of tiles
   is at work at a time. */
typedef struct {
  int         bits;                    /* log2 of the cells on an axis */
  PetscInt    n[3], below[3], keep[3]; /* of the table on each axis; not its own; uppermost ones that are early */
  PetscBool   wraps[3];                /* those below are the uppermost ones again */
  MPMTileBox *box[3];
  PetscInt   *slot;      /* [n2][n1][n0] which of the kept sums are the tile's, or as above */
  PetscInt (*used)[2];   /* [n2][n1] of a row: tiles used[0] to used[1]-1 may have sums, no others have */
  PetscBool       waits; /* sums come from processes below */
  PetscInt        n_early, n_own, nslots; /* kept sums: of early tiles, of own ones, and all */
  const PetscInt *start;                  /* [cells+1] where the particles of a cell begin in the order */
  PetscInt        nruns[MPM_NUM_PASSES];  /* of the order, each pass's from row to row */
  MPMRange       *runs[MPM_NUM_PASSES];
  PetscReal      *sum;     /* [nslots][nodes of a tile][MPM_NODE_NC] records like MPMNode */
  PetscReal      *scratch; /* [n0][nodes of a tile][MPM_NODE_NC] of the row at work */
  size_t          room;
  void           *memory; /* behind sum and scratch */
} MPMTiles;

/* Particles touch nodes first .. last-1 of a row; others are never visited. fresh: their sums are still to be
   zeroed. */
typedef struct {
  PetscInt  first, last;
  PetscBool fresh;
} MPMSpan;

/* The unit of work: a box of cells, their particles, and the nodes there and around. */
typedef struct {
  const MPMGrid  *grid;
  MPMBasis        basis;
  PetscInt        lo[3], n[3];         /* box of nodes that the arrays cover */
  PetscInt        own_lo[3], own_n[3]; /* nodes, and cells, that are this patch's own */
  MPMTiles        tiles;
  MPMView         particles;
  const PetscInt *order; /* [particles.n] particles by (cell, id) */
  PetscInt  *movers; /* [nmovers] places q in order of particles that changed cell, as the commit notes them, of those
                             that left the patch MPM_FLAGGED(q); or NULL */
  PetscInt   nmovers;
  MPMNode   *node;              /* [n2][n1][n0] complete for own nodes */
  PetscReal *motion;            /* [n2][n1][n0][MPM_MOTION_NC] m/s, m/s^2 */
  MPMSpan   *span;              /* [n2][n1] */
  void (*meanwhile)(void *ctx); /* called now and then while particles are summed; or NULL */
  void *ctx;
  void *memory; /* behind node and span, where the patch owns them */
} MPMPatch;

/* A negative number for place q of a list, which flags it; and q for such a number. */
#define MPM_FLAGGED(q) (-1 - (q))

#endif
