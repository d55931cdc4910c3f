/* core.h - what a step works on: grid, particles, the phases of the step, and how processes share the work.

   MPMCore is the part of a run that the code of a step uses. Scene, output, costs and studies are kept beside it, in
   MPM (run/mpm.h). */
#ifndef MPM_CORE_H
#define MPM_CORE_H

#include <petscsf.h>
#include "base/exact_sum.h"
#include "base/print.h"
#include "base/timers.h"
#include "kernels/light.h"
#include "kernels/node_rows.h"
#include "parallel/contact.h"
#include "parallel/rest.h"
#include "physics/rigid.h"
#include "parallel/partition.h"
#include "particles/box.h"
#include "particles/particles.h"

/* A phase of the step: a row of the table in step/phases.c. It declares the fields of particles that the phase uses:
   kernels get NULL for all other fields, and only the declared ones are sent to other processes. */
typedef enum { MPM_PARTICLES_TO_NODES, MPM_NODES, MPM_NODES_TO_PARTICLES } MPMPhaseKind;
typedef struct _MPMCore  MPMCore;
typedef struct _MPMPhase MPMPhase;
typedef void             MPMNodesUpdate(const MPMParams *, const MPMPatch *, const MPMNodes *);
struct MPMStatic; /* step/static.h */
struct _MPMPhase {
  const char     *name;
  MPMPhaseKind    kind;
  PetscInt        parts; /* bits: what a transfer does; unused by MPM_NODES */
  MPMNodesUpdate *nodes; /* MPM_NODES: updates one row of nodes */
  PetscInt        flops; /* MPM_NODES: operations per node and axis */
  PetscErrorCode (*after)(MPMCore *,
                          const MPMPhase *); /* MPM_NODES: what follows, collective on exchange.data; or NULL */
  PetscInt  motion;                          /* MPM_NODES: 1: velocities are new, and are sent; 2: accelerations too */
  PetscBool light;                           /* MPM_NODES: others carry the light nodes (kernels/light.h) */
  PetscInt  particles_in, particles_out;     /* bits of the fields that it reads, writes */
  PetscReal share;                           /* of the step over which a transfer to particles works */
  PetscInt  timer;                           /* number of its timer, set by MPMStepSetUp */
};

#define MPM_MAX_XPIC    16 /* largest -method_order of xpic */
#define MPM_MAX_PHASES  40 /* rows of the table of phases */
#define MPM_MAX_PROGRAM (8 + 3 * MPM_MAX_XPIC + 3)

/* A way to run the step. Physics, update schemes and output are the same for all; only these functions differ. setup
   and finish are collective on core->comm; sweep, nodes, reduce and settle are collective on the processes of
   exchange.data. */
typedef struct {
  const char *name;
  /* Cuts the grid and makes DMs and patch; the scene adds particles afterwards. h: the finished histogram of where
     these will be, which is needed if `cuts` is set. */
  PetscErrorCode (*setup)(MPMCore *, const MPMHistogram *h);
  PetscErrorCode (*sweep)(MPMCore *, const MPMPhase *); /* runs a transfer on all patches */
  PetscErrorCode (*nodes)(MPMCore *, const MPMPhase *); /* runs a node update, and updates the ghosts */
  PetscErrorCode (*reduce)(MPMCore *, MPMStatus *);     /* merges the status of all: the only reduction of a step */
  /* Sends each particle to the process that owns its cell, and sorts them. anew: no cell is known yet. */
  PetscErrorCode (*settle)(MPMCore *, PetscBool anew);
  /* Makes DMs and patch anew for other nodes of the grid, and sends each particle to the process that owns its new
     cell; then particles have to be settled anew. */
  PetscErrorCode (*renew)(MPMCore *);
  PetscErrorCode (*finish)(MPMCore *);            /* frees what setup made */
  PetscBool cuts;                                 /* does it cut the grid by a histogram? */
  PetscBool by_workers;                           /* do other processes do the work on particles? */
  PetscErrorCode (*serve)(MPMCore *);             /* what a process without data does, until the run ends */
  PetscErrorCode (*share)(MPMCore *, MPMShare *); /* adds ghosts, neighbours, cuts of this process; NULL: it has none */
} MPMExchangeType;

typedef struct {
  const MPMExchangeType *type;
  MPI_Comm               data; /* the processes that hold particles and grid; all DMs and files live on it */
  MPMPatch               patch;
  MPMLight               light;
  PetscSF                around;                   /* brings numbers of nodes to all ghosts; NULL: there are none */
  MPI_Datatype           record_type, motion_type; /* the sums of a node, its motion */
  char                  *boxes;                    /* memory for the sums of F-bar, of a worker of the pool too */
  size_t                 boxes_room;
  DM                     da;                        /* the nodes of the grid, with their motion */
  DM                     sums[MPM_NODE_LINES];      /* the same nodes, with the lines of their sums */
  Vec                    motion;                    /* the local vector whose array patch.motion is */
  Vec                    state;                     /* of the total frame, the one of patch.state; else NULL */
  Vec                    node_sums[MPM_NODE_LINES]; /* local vectors, whose arrays follow each other in patch.node */
  MPMBalance             balance;                   /* -parallel_balance */
  PetscBool              direct;                    /* -parallel_migrate direct */
  PetscBool              roundoff;                  /* -parallel_sums roundoff */
  PetscBool              ready;                     /* has setup been called? */
  PetscInt               pool_cells;                /* -pool_cells, as whole tiles */
  void                  *pool; /* data of the pool; its master uses the rest as a run on one process does */
  MPMPartition           partition;
  PetscInt               recuts;     /* how often the grid was cut anew */
  PetscInt               migrations; /* steps in which particles changed process */
  PetscInt64             migrants;   /* how many particles did so, in all steps */
  PetscReal busy, jobs, bytes;       /* of the pool's master: s not spent waiting, jobs sent, bytes sent and received */
  void     *ctx;                     /* data of the type */
} MPMExchange;

/* What the steps so far have done to the energy, in J: exact sums over the nodes and particles of this process
   (step/energy.c). Without -history_energy only the work of loads is summed. */
enum {
  MPM_ENERGY_loads,    /* work of body forces and loads */
  MPM_ENERGY_gravity,  /* work of gravity on the nodes */
  MPM_ENERGY_walls,    /* work of moving walls */
  MPM_ENERGY_rigid,    /* work of rigid bodies that move by formulas */
  MPM_ENERGY_friction, /* work of friction at walls and rigid bodies, and between bodies, below 0 */
  MPM_ENERGY_advance,  /* kinetic energy that accelerations and moving walls gave */
  MPM_ENERGY_damping,  /* kinetic energy that damping of all motion took, below 0 */
  MPM_ENERGY_volumes,  /* change of the stored energy where volumes are relaxed and fluids pushed out of bodies */
  MPM_ENERGY_stress,   /* work of the stress on particles whose law stores only a part of it, and of viscosity */
  MPM_ENERGY_mapped,   /* work of the stress that the mapping between particles and nodes gives; and */
  MPM_ENERGY_half,     /* the part of it that belongs to the next step: the work in the second half of the last one */
  MPM_NUM_ENERGIES
};
/* The mean velocity along which the acceleration of a node does its work in a step: v' - kick/2 a of the node; with
   musl the mean of the velocity before the advance and that of the second mapping; or the mean of the particles that it
   moves. */
typedef enum { MPM_MEAN_NODES, MPM_MEAN_AGAIN, MPM_MEAN_PARTICLES } MPMMean;
typedef struct {
  PetscBool on;    /* -history_energy */
  PetscBool loads; /* the work of loads and body forces is summed */
  MPMMean   mean;
  PetscBool maps, strained; /* is what the mapping does to the work of the stress summed? has the last step strained? */
  MPMSum    sum[MPM_NUM_ENERGIES];
  PetscReal *before, *stress; /* of the particles as a step begins: [n][x, v] where b is not 0; [n][F, tau] */
  PetscInt  *which, n;        /* [n] the particles of `before` */
  PetscInt   capacity;        /* particles for which there is room */
  /* The bodies whose dissipation is asked for: their number, ids first .. last-1 of each, what it is so far, J; and of
     the particles [n][2] the energy that their law stores as a step begins, per reference volume, and its theta. */
  PetscInt    nheat;
  PetscInt64 *ids;
  MPMSum     *heat;
  PetscReal  *stored;
} MPMEnergy;

/* Damping of all motion (step/damping.c). */
typedef struct {
  PetscReal time;    /* -damping_time, s; 0: none */
  PetscBool kinetic; /* -damping_kinetic */
  PetscReal last;    /* of kinetic: the kinetic energy after the last step, J */
  PetscInt  stops;   /* how often velocities were set to 0 */
  PetscBool rest; /* they were in the last step: they are those of the time of positions, and the next kick is half */
} MPMDamping;

/* The relaxation of volumes (step/volume.c). */
typedef struct {
  PetscBool fluids, sand; /* whether any of these relaxes */
  PetscReal sound;        /* speed of sound times rate of the fastest one, m/s; 0: none relaxes */
  PetscReal since;        /* time since the last one, s */
  PetscReal share;        /* of the steps that do it, for predictions */
} MPMVolumes;

/* What the walls of some faces have given the matter (step/reactions.c): exact sums over the nodes of this process, of
   the impulse since the last line of the history, N s, and of the work since the start, J. */
typedef struct {
  PetscInt   faces;           /* bits of the faces, 2 axis + side */
  PetscInt   filter, correct; /* numbers in the program of the phases of nodes besides the advance that count; or -1 */
  PetscReal  since;           /* core->kicked at the last line, s */
  MPMSum     impulse[6][3], work[6];
  PetscReal *before; /* velocities of the nodes at walls before a correction of afmpm */
  PetscInt   room;   /* numbers in it */
} MPMReactions;

/* How far the matter is from the walls that act on arrival (step/gaps.c), for the nodes of each such face, from `first`
   on. gap: m; after all of these what particles beside them that have sunk into the wall leave to them, m, or of a
   piston the gap of what it can pull. least: the least velocity, which MPMFace shows to the nodes; after all of these
   how far what a piston can pull is from each node, m. */
typedef struct {
  PetscInt   faces, first[6], n; /* bits of the faces, 2 axis + side; nodes of all of them */
  PetscReal *gap, *least;        /* [2 n] */
} MPMGaps;

/* What pistons do to the nodes beside their planes (step/pistons.c), for the columns of nodes along their normal.
   weight, held, relative: of the columns of all faces, numbered as the nodes of MPMGaps. sum, share, impulse: of the
   columns of one. */
typedef struct {
  PetscInt64 *weight;   /* [n][MPM_MAX_STENCIL] of its nodes at the end of its matter, in units */
  PetscBool  *held;     /* [n] does the piston give its end a velocity in this step? */
  PetscReal  *relative; /* [n] that velocity, relative to the piston and away from it, m/s */
  PetscReal  *sum;      /* [columns][MPM_MAX_STENCIL][2] velocity along the normal, m/s, and mass, kg, of its nodes */
  PetscReal  *share;    /* [columns][MPM_MAX_STENCIL] of its nodes in its impulse */
  PetscReal  *impulse;  /* [columns] kg m/s */
} MPMPistons;

/* Where a free rigid body stands on the wall of a face, 2 axis + side (step/rigid.c): the place, m; the least velocity
   away from the wall, below 0: approach, m/s; the impulses along the normal and across it, N s. */
typedef struct {
  PetscInt  body, face;
  PetscReal at[3], least, press, brake[3];
} MPMRigidSupport;

/* Rigid bodies. */
typedef struct {
  PetscInt         n;
  MPMRigid        *body;         /* [n] */
  PetscReal       *numbers;      /* [n][MPM_RIGID_NUMBERS] */
  PetscReal        since;        /* core->kicked at the last line of the history, s */
  PetscBool        driven, free; /* does any move by formulas? freely? */
  PetscReal        meet;      /* s: when two that move by formulas, or one and a fixed one, pass through each other; */
  PetscInt         meets[2];  /* which */
  PetscBool        thin;      /* it has been said that one has matter on both sides that shares nodes */
  PetscReal        energy[3]; /* work on free ones since the start by gravity, walls at rest and those that move, J */
  PetscReal        loads;     /* and by body forces, J */
  PetscInt         nsupports, room;
  MPMRigidSupport *support; /* [nsupports] in this step */
} MPMRigids;

#define MPM_NUM_LOST 11 /* components of the rows LOST of results/diagnostics.def */

struct _MPMCore {
  MPI_Comm          comm;
  MPMPrinter        print;
  MPMGrid           grid;
  MPMBasis          basis;
  MPMNeeds          needs;
  MPMParams         params;
  MPMPhase          phases[MPM_MAX_PHASES]; /* [nphases] the table of phases as this scene needs it */
  PetscInt          nphases;
  const MPMPhase   *program[MPM_MAX_PROGRAM]; /* [nprogram] the phases of a step, one after the other */
  PetscInt          nprogram, nrare; /* nrare: after these, phases that only some steps make, before the others */
  MPMExchange       exchange;
  MPMParticles      particles;
  MPMStatus         status; /* of the last step */
  MPMTimers         timers;
  MPMEnergy         energy;
  MPMDamping        damping;
  MPMRest           rest;
  MPMChanges        changes;
  MPMStages         stages;
  MPMGaps          *gaps;     /* or NULL: no wall only pushes */
  MPMPistons       *pistons;  /* or NULL: there is none */
  MPMContacts      *contacts; /* or NULL: bodies share the nodes of the grid, and there are no rigid ones */
  MPMRigids         rigids;
  MPMVolumes        volumes;
  MPMReactions     *reactions;          /* or NULL: the history asks for none */
  MPMSum            lost[MPM_NUM_LOST]; /* what the particles took along that this process removed (results/lost.c) */
  struct MPMStatic *implicit;           /* or NULL: steps are explicit */
  PetscReal        *before;    /* of the total frame, if energy or walls are followed: patch.state before nodes move */
  PetscReal         half;      /* of the total frame: work of gravity in the first step, whose kick is half, J */
  PetscReal         passed[6]; /* of the total frame: how far the wall of each face has moved along its axis, m */
  PetscReal         t, kicked; /* s; s, the sum of params.kick: velocities have changed over this time */
  PetscInt          step;
  char              stop[MPM_TEXT_LEN]; /* why the run has to stop early; it is empty if the run need not */
};

#endif
