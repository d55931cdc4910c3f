/* patch.h - what a phase works on: the constants of a step, and a patch, which is a box of cells with their particles,
   the nodes in and around the box, and tiles. */
#ifndef MPM_PATCH_H
#define MPM_PATCH_H

#include <stddef.h>
#include "base/status.h"
#include "kernels/node.h"
#include "physics/grid.h"
#include "physics/material.h"

struct MPMWalls; /* physics/wall.h, which kernels of particles do not see */

/* Constants of a step: all that kernels need of the scene. */
typedef struct {
  PetscReal      dt, kick;         /* s; positions and states change over dt, velocities over `kick` (MPMKick) */
  PetscReal      flip, gravity[3]; /* 1, m/s^2 */
  PetscReal      strain;           /* share of the strain rate in the affine velocity, see MPMAffine */
  PetscInt       order;            /* of xpic and afmpm, else 0 */
  PetscBool      own_inertia;      /* C near walls: by each particle's sum phi (x_i - x)^2 */
  PetscInt       carried;          /* bits of the states of materials that are written besides those that a law has */
  PetscInt       closed;  /* faces (bits, 2 axis + side) on which particles that have just passed them are put back */
  PetscBool      deletes; /* particles that leave the grid are to be removed, which is no error */
  PetscReal      outward; /* of bodies of revolution: share of the strain rate in C, 0 without C */
  PetscReal      light;   /* share of mass below which nodes are light (light.h); 0: none are */
  PetscInt       planes;  /* faces (bits) whose pistons no particle passes; where their planes are before and after */
  PetscReal      plane[6][2]; /* the step, m */
  PetscReal      push;        /* of a relaxation of volumes: share of what the density tells, see volume.h */
  PetscReal      lock_share;  /* of the mean of a box that particles take; the rest is their own */
  PetscInt       box;         /* cells of a box of F-bar on an axis: 1, 2 or 4; 0: there is none */
  const MPMKind *kinds;
  PetscInt       nkinds;
  const MPMMaterial     *materials;
  PetscInt               nmaterials;
  const struct MPMWalls *walls;
} MPMParams;

/* Tiles are boxes of 2^bits cells on each axis, counted from the first node of the grid. The cell of a particle is
   named by the base node of its stencil. Each tile has sums of its own for all nodes that its particles touch, `side`
   on an axis; then a node adds up the sums of the tiles that have some for it, from the lowest tile to the highest.
   Both sums are made in the same way wherever a tile is, and a tile is never cut: so the bits are the same however the
   grid is cut, and nothing is computed twice. */
#define MPM_TILE_BITS(stencil) ((stencil) > 2 ? 2 : 1) /* 2 or 4 cells, about twice the reach of a stencil */

/* On one axis, a tile has nodes 0 .. end-1, of which from .. to-1 are the patch's own. Its node 0 is node `at` of the
   patch's arrays. */
typedef struct {
  PetscInt from, to, end, at;
} MPMTileBox;

/* A range of the order: entries first .. last-1, particles of one row of tiles. */
typedef struct {
  PetscInt first, last, row;
} MPMRange;

/* The passes of a P2G phase, by their tiles.
     MPM_PASS_EARLY  tiles whose sums another process needs, or which a periodic face needs before the main pass; in
                     the pool, all tiles
     MPM_PASS_LATE   where sums of other processes are added first, other tiles of the first rows: their sums are made
                     while those messages are under way
     MPM_PASS_MAIN   all other tiles; afterwards the sums of all tiles are added to the nodes
   The sums of early and late tiles are kept until the main pass. */
typedef enum { MPM_PASS_MAIN, MPM_PASS_EARLY, MPM_PASS_LATE, MPM_NUM_PASSES } MPMPass;

/* Values of MPMTiles.slot that are no place of kept sums: the sums are in scratch; the tile has no particles. */
enum { MPM_TILE_SCRATCH = -1, MPM_TILE_EMPTY = -2 };

/* Values in place of the number of a cell or of a base node: the position is in another patch; it is outside the
   grid. */
enum { MPM_ELSEWHERE = -1, MPM_NOWHERE = -2 };

/* The tiles of a patch: a table of its own ones and of those `below`, whose particles touch its nodes. Cells are
   numbered row by row of cells (x fastest), within a row of tiles first: so particles are read in sequence, and one row
   of tiles is summed at a time. */
typedef struct {
  int         bits;                    /* log2 of the cells of a tile on an axis */
  PetscInt    n[3], below[3], keep[3]; /* on an axis: tiles of the table; not its own; uppermost ones that are early */
  PetscBool   wraps[3];                /* those below are the uppermost ones, across a periodic face */
  MPMTileBox *box[3];
  PetscInt   *slot;      /* [n2][n1][n0] place of the tile's kept sums in `sum`, or MPM_TILE_SCRATCH or _EMPTY */
  PetscInt (*used)[2];   /* [n2][n1] for each row: only tiles used[0] to used[1]-1 may have sums */
  PetscBool       waits; /* sums come from processes below */
  PetscInt        n_early, n_own, nslots; /* kept sums: of early tiles; of own ones; of all */
  const PetscInt *start;                  /* [cells+1] where the particles of a cell begin in the order */
  PetscInt        nruns[MPM_NUM_PASSES];  /* ranges of each pass, row after row of tiles */
  MPMRange       *runs[MPM_NUM_PASSES];
  PetscInt        lines;   /* of a node's sums that there is room for; the patch's arrays have as many */
  PetscReal      *sum;     /* [nslots][lines][nodes of a tile][MPM_NODE_NC] records like MPMNode */
  PetscReal      *scratch; /* [n0][lines][nodes of a tile][MPM_NODE_NC] sums of one row of tiles */
  size_t          room;
  void           *memory; /* the allocation of sum and scratch */
} MPMTiles;

/* Particles touch only nodes first .. last-1 of a row of nodes, and phases visit no others. fresh: their sums have not
   been zeroed yet. */
typedef struct {
  PetscInt  first, last;
  PetscBool fresh;
} MPMSpan;

/* A patch: a box of cells, their particles, and the nodes in and around it. */
typedef struct {
  const MPMGrid  *grid;
  MPMBasis        basis;
  PetscInt        lo[3], n[3];         /* box of nodes that the arrays cover, ghost nodes included */
  PetscInt        own_lo[3], own_n[3]; /* nodes, and the cells that they name, that are this patch's own */
  MPMTiles        tiles;
  MPMView         particles;
  const PetscInt *order; /* [particles.n] particles by (cell, id) */
  PetscInt  *movers; /* [nmovers] entries q of the order that are movers, MPM_FLAGGED(q) for those that left; or NULL */
  PetscInt   nmovers;
  MPMNode   *node;     /* [lines][n2][n1][n0] sums, complete for own nodes */
  PetscReal *motion;   /* [n2][n1][n0][MPM_MOTION_NC] m/s, m/s^2 */
  MPMNodeValues value; /* of own nodes */
  PetscReal    *state; /* the same of own nodes in the total frame: displacement, m, and velocity, m/s; or NULL */
  MPMSpan      *span;  /* [n2][n1] */
  PetscReal    *boxes; /* [boxes][materials][2] sums of F-bar (fbar.h); or NULL */
  void (*meanwhile)(void *ctx); /* called after every few blocks of P2G, so that messages progress; or NULL */
  void *ctx;
  void *memory; /* the allocation of node, span and value, where the patch owns them */
} MPMPatch;

/* Marks q >= 0 as a negative number, and converts that back to q. */
#define MPM_FLAGGED(q) (-1 - (q))

#endif
