/* transfer.h - the two kernels of the Material Point Method: particles to nodes (P2G) and nodes to particles (G2P).

   Each is written once, for vectors of MPM_WIDTH lanes (lanes.h), as functions that are always inlined: dim is a
   compile-time constant in them, and so is the basis where weights are computed. transfer_lanes.c instantiates them and
   is compiled once for each width, as is transfer_sums.c, which has the innermost loops. P2G takes the steps of this
   list from top to bottom; G2P works on the same blocks:

     order    particles by (cell, id) in ranges (MPMRange): G2P takes one of all, P2G those of a row of tiles at a time.
     blocks   of 64 particles of these ranges (3-D: 32), whatever their cells: lanes are particles (MPMBlockOrder).
       |      Weights, stress and sums are in scratch in L1; v and F go from row to row, a vector at a time.
     cells    particles of a block with the same base node are added up in local accumulators: lanes are the sums of a
       |      node. A cell may continue in the next block. G2P: the motion of the cell's nodes is interpolated at its
       |      particles, which are the lanes.
     tiles    of 2 or 4 cells an axis, with own sums for all nodes that their particles touch. The sums of early and
       |      late tiles (MPMPass) are kept; those of others are in scratch until their row of tiles is complete.
     nodes    patch->node: the main pass adds a complete row of tiles to it, tile by tile.

   A cell is named by its base node, s->base, an index of the patch's arrays; its number in the table of tiles,
   particles.cell, defines the order. The tree of additions - particles of a cell by id, cells of a tile, tiles of a
   node - depends on cells and ids alone, never on blocks, lanes or processes. Equation numbers are those of
   docs/method.md. Input: particles x v F kind id cell state, and l b C r dx where a scene has them; the motion of
   nodes. Output: sums of nodes; particles v F x dx cell, and state tau C r l likewise; status. For a first reading leave
   out what has to do with walls and with cells that are cut. */
#ifndef MPM_TRANSFER_H
#define MPM_TRANSFER_H

#include "kernels/patch.h"

/* Parts of a transfer, which a phase chooses (bits). */
enum {
  MPM_P2G_MASS     = 1,      /* sum m_p phi                                   eq. (1) */
  MPM_P2G_MOMENTUM = 2,      /* sum m_p v_p phi                               eq. (2) */
  MPM_P2G_FORCE    = 4,      /* - sum V0 tau_p grad phi + sum m_p b_p phi     eqs. (4), (13) */
  MPM_G2P_MOTION   = 8,      /* v_p, displacement of the step                 eqs. (8), (9) */
  MPM_G2P_STRESS   = 16,     /* L, F and material state, checks, wave speed   eqs. (3), (10), (11), (12) */
  MPM_G2P_COMMIT   = 32,     /* x <- x + dx, new cell */
  MPM_AFFINE       = 64,     /* with momentum and motion: v_p + C_p (x_i - x_p), and C_p (APIC) */
  MPM_RESIDUAL     = 128,    /* with momentum: sums r_p in place of v_p (xpic, afmpm) */
  MPM_G2P_FILTER   = 256,    /* r_p, or v_p, less its interpolation by the nodes (xpic, afmpm) */
  MPM_P2G_EARLY    = 512,    /* for the pass of early tiles, see MPMPass */
  MPM_P2G_LATE     = 1024,   /* for the pass of late tiles */
  MPM_P2G_WHOLE    = 2048,   /* messages have whole records of nodes (-method_carry all) */
  MPM_G2P_FBAR     = 4096,   /* with stress: one change of volume for the particles of a box, fbar.h */
  MPM_P2G_FBAR     = 8192,   /* with forces: one pressure for them */
  MPM_P2G_VOLUME   = 16384,  /* alone: volumes and pressures of fluids, volume.h; with MPM_AFFINE: and its slope */
  MPM_G2P_VOLUME   = 32768,  /* alone: relaxes the volumes of fluids */
  MPM_P2G_ROUND    = 65536,  /* with mass: that of nodes along r, round.h */
  MPM_P2G_TOTAL    = 131072, /* with forces: of the first Piola-Kirchhoff stress (total.h) */
  MPM_P2G_NODES    = 262144, /* with momentum: sums what the first numbers of the nodes' motion are at the particles */
  MPM_G2P_TOTAL    = 524288  /* alone: x, v, F and material state of the displacements and velocities of nodes */
};

/* The parts whose sums are in the first line of a node's record. */
#define MPM_P2G_CORE (MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_P2G_FORCE | MPM_P2G_VOLUME)

/* Lists the numbers of a node's record that these parts sum, ascending, which are those that messages have; returns how
   many. */
MPM_INLINE PetscInt MPMNodeSums(PetscInt dim, PetscInt parts, PetscInt which[MPM_NODE_NUMBERS])
{
  PetscInt n = 0;

#define MPM_NODE_LIST(part, nc, at)                                                                                    \
  for (PetscInt c = 0; c < (nc) && (parts & (part)); c++) which[n++] = (at) + c;
#define MPM_NODE_CORE(name, member, nc, part, dataset, unit, meaning) MPM_NODE_LIST(part, nc, MPM_NODE_##name)
#define MPM_NODE_SHARE(name, place, nc, part, unit, meaning)          MPM_NODE_LIST(part, nc, place)
#include "kernels/node.def"
  if ((parts & MPM_P2G_WHOLE) && (parts & MPM_P2G_CORE))
    for (n = 0; n < MPM_NODE_NC; n++) which[n] = n;
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning) MPM_NODE_LIST(part, nc, MPM_NODE_##name)
#include "kernels/node.def"
#undef MPM_NODE_LIST
  return n;
}

/* Returns the parts whose sums are in a line of the record besides the first one. */
MPM_INLINE PetscInt MPMNodeParts(PetscInt line)
{
  PetscInt parts = 0;

  (void)line;
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)                                                    \
  if (MPM_NODE_##name / MPM_NODE_NC == line) parts |= (part);
#include "kernels/node.def"
  return parts;
}

/* Returns how many lines of the record there are up to the last one that these parts sum. */
MPM_INLINE PetscInt MPMNodeLines(PetscInt parts)
{
  PetscInt lines = 1;

  for (PetscInt line = 1; line < MPM_NODE_LINES; line++)
    if (MPMNodeParts(line) & parts) lines = line + 1;
  return lines;
}

/* Runs the parts of a transfer on a patch, whose view has the fields that they need; notes its findings in status. Not
   collective. */
typedef void (*MPMKernel)(const MPMParams *, MPMPatch *, PetscInt parts, MPMStatus *);

/* MPMKernelFind returns the kernel for these parts, NULL if there is none; MPMKernelFlops its floating-point operations
   per particle. */
MPMKernel MPMKernelFind(PetscInt dim, MPMBasis basis, PetscInt parts);
PetscReal MPMKernelFlops(PetscInt dim, MPMBasis basis, PetscInt parts);
PetscInt  MPMKernelWidth(void); /* particles that kernels compute at a time: 8, 4 or 2, as the processor allows */

#endif
