/* transfer.h - the two kernels of the Material Point Method: particles to nodes (P2G) and nodes to particles (G2P).

   Each is written once, for vectors of MPM_WIDTH lanes (lanes.h); dim is a compile-time constant of always-inlined
   functions, and so is the basis where weights are made. transfer_lanes.c instantiates them and is compiled once a
   width, as are the innermost loops, in transfer_sums.c. P2G goes down this map; G2P goes over the same blocks:

     order    particles by (cell, id), in runs (MPMRange): G2P takes all as one, P2G those of a row of tiles at a time.
     blocks   of MPM_STAGED particles of these runs, whatever their cells. Their rows are gathered into scratch in L1
       |      (3-D: or near); weights, stress, new v, F and x are made there: lanes are particles (MPMBlockOrder).
     cells    particles of a block with the same base node, added up in local accumulators: lanes are the sums of a
       |      node. A cell may go on in the next block. G2P: the motion of the cell's nodes to its particles, the lanes.
     tiles    of 2 or 4 cells an axis, with sums of their own for all nodes that their particles touch: of open tiles in
       |      scratch, of early and late ones kept (MPMPass) until the main pass closes their row.
     nodes    patch->node, which gets the sums of a row of tiles, tile by tile, when the row is closed.

   A cell is its base node, s->base, an index of the patch's arrays; its number in the table of tiles, particles.cell,
   is what the order goes by. The tree of additions - particles of a cell by id, cells of a tile, tiles of a node -
   depends on cells and ids alone, never on blocks, lanes or processes. Equation numbers: docs/theory.md. In: particles
   x v F kind id cell state, and l b C r dx where a scene has them; the motion of nodes. Out: sums of nodes; particles v
   F x dx cell, and state tau C r likewise; status. For a first reading leave out what has to do with walls and with
   MPMBegun.     */
#ifndef MPM_TRANSFER_H
#define MPM_TRANSFER_H

#include "kernels/patch.h"

/* Parts of a transfer: what a phase asks the one P2G body and the one G2P body to do. */
enum {
  MPM_P2G_MASS     = 1,   /* sum m_p phi                                   eq. (1) */
  MPM_P2G_MOMENTUM = 2,   /* sum m_p v_p phi                               eq. (2) */
  MPM_P2G_FORCE    = 4,   /* - sum V0 tau_p grad phi + sum m_p b_p phi     eqs. (4), (13) */
  MPM_G2P_MOTION   = 8,   /* v_p, displacement of the step                 eqs. (8), (9) */
  MPM_G2P_STRESS   = 16,  /* L, F and material state, checks, wave speed   eqs. (3), (10), (11), (12) */
  MPM_G2P_COMMIT   = 32,  /* x <- x + dx, new cell */
  MPM_AFFINE       = 64,  /* with momentum and motion: v_p + C_p (x_i - x_p), and C_p (APIC) */
  MPM_RESIDUAL     = 128, /* with momentum: of r_p in place of v_p (xpic) */
  MPM_G2P_FILTER   = 256, /* r_p less its part that the grid takes up (xpic) */
  MPM_P2G_EARLY    = 512, /* of early tiles, see MPMPass */
  MPM_P2G_LATE     = 1024 /* of late ones */
};

typedef void (*MPMKernel)(const MPMParams *, MPMPatch *, PetscInt parts, MPMStatus *);

/* The kernel for these parts, NULL if there is none; and its floating-point operations per particle. */
MPMKernel MPMKernelFind(PetscInt dim, MPMBasis basis, PetscInt parts);
PetscReal MPMKernelFlops(PetscInt dim, MPMBasis basis, PetscInt parts);
PetscInt  MPMKernelWidth(void); /* particles that kernels handle at a time: 8, 4 or 2, as the processor allows */

/* Fused products and sums in registers, n rounds of as many independent chains as hide their latency, with the vectors
   that the kernels use: how many operations that were. What cost/roofline.c takes for the limit of a core. */
typedef PetscReal MPMChains(PetscInt n, PetscReal start, volatile PetscReal *end);
extern MPMChains  MPMChains_8, MPMChains_4, MPMChains_2;
MPMChains        *MPMKernelChains(void);

#endif
