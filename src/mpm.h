/* mpm.h - the header to read first: every structure and prototype of Pebble, layer by layer.

   Pebble moves material particles over a background grid (the Material Particle Method). Layers, each knowing only
   those above it: 1 physics    materials, walls, shapes, bases, transfers: plain arrays, no MPI, no DM, no options 2
   parallel   grid, particles, patch, exchange: who holds which particles and how they travel 3 program    scene (from
   options), step, run, output After this header read step.c: the whole method is two tables there. The equations and
   their numbers are those of docs/theory.md. Units are SI in all names; any consistent set works. Names: p particle, i
   node, d,e axis, k component. x v F sig J dt h mean what they mean in the theory.                 */
#ifndef MPM_H
#define MPM_H

#include <petscdmda.h>
#include <petscdmswarm.h>
#include "basis.h"

#if PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS ((PetscErrorCode)0)
#endif
#if !defined(PETSC_USE_REAL_DOUBLE) || defined(PETSC_USE_COMPLEX)
#error "Pebble needs a PETSc with real scalars in double precision"
#endif

#define MPM_VERSION   "0.1.0"
#define MPM_NAME_LEN  64
#define MPM_TEXT_LEN  2048
#define MPM_STAGED    64 /* particles that a transfer stages at a time: its scratch, 34 to 56 KiB, stays in L1 or near */
#define MPM_MEANWHILE 32 /* blocks of particles between calls of what else must get on */
#define MPM_BLOCK     72 /* the length of its rows: room for the widest vector past the last particle */
#define MPM_LINE      64 /* bytes of a line of the cache */
#define MPM_STRESS_NC 6  /* components of a symmetric tensor: xx xy xz yy yz zz */

/* Exit statuses of the program. */
enum { MPM_EXIT_OK = 0, MPM_EXIT_INPUT = 2, MPM_EXIT_STOPPED = 3 };

typedef struct _p_MPM *MPM;

/* ---------------------------------------------------------------------------------------------------------------
   1. Physics
   --------------------------------------------------------------------------------------------------------------- */

/* What a material's tests may assert. */
enum {
  MPM_OBJECTIVE    = 1, /* a rotation turns the stress and changes no energy */
  MPM_HYPERELASTIC = 2, /* J sig F^-T is the derivative of the energy by F */
  MPM_SMALL_STRAIN = 4, /* sig is the derivative of the energy by sym(F); right for small strains and rotations only */
  MPM_PLASTIC      = 8, /* tau stays within a yield surface, flow dissipates; Hencky elasticity on be until then */
  MPM_FLUID        = 16 /* tau is a function of J but for a viscous part, which dissipates */
};

/* Bits that name fields, for the rows of phases and of materials. */
enum {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) MPM_FIELD_INDEX_##name,
#include "fields.def"
#undef MPM_FIELD
  MPM_NUM_FIELDS
};
#define MPM_BIT(name) (1 << MPM_FIELD_INDEX_##name)

/* The fields that laws read and write: X(name, rows in a block). */
#define MPM_MATERIAL_FIELDS(X) X(F, 9) X(J, 1) X(be, 6) X(ep, 1) X(vc, 1) X(tau, 6)

#define MPM_MATERIAL_BIT(name, rows) | MPM_BIT(name)
#define MPM_MATERIAL_BITS            (0 MPM_MATERIAL_FIELDS(MPM_MATERIAL_BIT))

/* The state of a block of particles as laws see it, component-major. A field that the law's row does not list is unset.
 */
typedef struct {
#define MPM_MATERIAL_ROWS(name, rows) PetscReal name[rows][MPM_BLOCK];
  MPM_MATERIAL_FIELDS(MPM_MATERIAL_ROWS)
#undef MPM_MATERIAL_ROWS
} __attribute__((aligned(64))) MPMBlock;

typedef struct _MPMMaterial MPMMaterial;

/* A material law: functions of particles first .. last-1 of a block, one a dimension ([dim-1]); all J > 0. A law
   without history has stress and no update. */
typedef struct _MPMMaterialLaw MPMMaterialLaw;
struct _MPMMaterialLaw {
  /* constants from the options; what is wrong with them, beginning with the name of one, or NULL */
  const char *(*setup)(MPMMaterial *);
  /* Kirchhoff stress b->tau = J sig in Pa */
  void (*stress[3])(const MPMMaterial *, PetscInt first, PetscInt last, MPMBlock *b);
  /* the state after a step dt in s with velocity gradient L [dim*dim] in 1/s; b->F is new already */
  void (*update[3])(const MPMMaterial *, PetscReal dt, PetscReal (*L)[MPM_BLOCK], PetscInt first, PetscInt last,
                    MPMBlock *b);
  /* stored energy per reference volume W [last] in J/m^3 */
  void (*energy[3])(const MPMMaterial *, PetscInt first, PetscInt last, const MPMBlock *b, PetscReal W[]);
  /* upper bound of the squared speed of waves in the deformed state c2 [last] in m^2/s^2 */
  void (*speed2[3])(const MPMMaterial *, PetscInt first, PetscInt last, const MPMBlock *b, PetscReal c2[]);
  /* stress, update and speed2 for vectors of 8, 4, 2 particles: what the transfers call; NULL: they call those above */
  const MPMMaterialLaw *lanes[3];
};

typedef struct {
  /* parameters: options it takes besides rho; state: fields that its particles carry; lists separated by blanks */
  const char           *name, *parameters, *state, *what;
  PetscInt              traits;
  const MPMMaterialLaw *law;
} MPMMaterialType;

struct _MPMMaterial {
  char                   name[MPM_NAME_LEN];
  const MPMMaterialType *type;
  PetscInt               state;          /* bits of fields: those of the type, less what its constants make useless */
  PetscReal              rho, E, nu;     /* density in kg/m^3, Young's modulus in Pa, Poisson's ratio */
  PetscReal              lambda, mu;     /* Lame's constants in Pa, set by MPMMaterialSetUp */
  PetscReal              K, viscosity;   /* of a fluid: bulk modulus in Pa, viscosity in Pa s */
  PetscReal              gamma, tension; /* of a fluid: Tait's exponent (0: linear), largest tension in Pa (< 0: any) */
  PetscReal              yield, hardening;   /* of vonmises: yield stress and its slope by plastic strain in Pa */
  PetscReal              friction, dilation; /* of druckerprager: slopes of cone and flow, from angles in degrees */
  PetscReal              cohesion; /* of druckerprager, in Pa; after the set-up the trace of tau at the apex */
};

extern const MPMMaterialType MPMMaterialTypes[]; /* rows of material.def; the last has no name */

PetscBool MPMListHas(const char list[],
                     const char word[]); /* does a list of words with blanks between hold this one? */

/* Lame's constants from E and nu, the law's own constants, and state. What is wrong with the options, or NULL. */
const char *MPMMaterialSetUp(MPMMaterial *);

/* A kind of particle: what all particles of a body share, so that no particle carries it. Bodies of the same material,
   density of particles and cell size share a kind. */
typedef struct {
  PetscInt  material; /* row of the scene's materials */
  PetscReal m, V0;    /* mass in kg, reference volume in m^3 (unit thickness where dim < 3) */
  PetscReal l[3];     /* half-width of the particle's domain at the start, in cells */
} MPMKind;

typedef enum {
#define MPM_WALL(name, parameters, what) MPM_WALL_##name,
#include "wall.def"
#undef MPM_WALL
  MPM_NUM_WALLS
} MPMWall;

typedef struct {
  MPMWall   type;
  PetscReal mu, velocity[3]; /* of friction: coefficient; of moving: velocity of the wall in m/s */
} MPMFace;

/* Applies the walls of the grid to the velocity v [dim] of node ijk [dim] (at or beyond a face). faces[axis][side].
   Returns whether v was constrained.                                                                                 */
PetscBool MPMWallsApply(const MPMFace (*faces)[2], PetscInt dim, const PetscInt ijk[], const PetscInt cells[],
                        PetscReal v[]);
PetscInt  MPMWallsAdvance(const MPMFace (*faces)[2], PetscInt dim, const PetscInt ijk[], const PetscInt cells[],
                          PetscReal dt, const PetscReal v[], PetscReal at[], PetscReal a[]);
void MPMWallsDerive(const MPMFace (*faces)[2], MPMFace (*before)[2], MPMFace (*gradient)[2], MPMFace (*residual)[2]);

/* A shape in space; dim coordinates of each member count. */
typedef enum {
#define MPM_REGION(name, solid, parameters, what) MPM_REGION_##name,
#include "region.def"
#undef MPM_REGION
  MPM_NUM_REGIONS
} MPMRegionType;
typedef struct {
  MPMRegionType type;
  PetscReal     center[3], lower[3], upper[3], radius, inner_radius;
} MPMRegion;

PetscBool MPMRegionInside(const MPMRegion *, PetscInt dim, const PetscReal x[]);
PetscBool MPMRegionSolid(const MPMRegion *); /* as region.def says */
void      MPMRegionBounds(const MPMRegion *, PetscInt dim, PetscReal lower[], PetscReal upper[]);

/* The background grid: node ijk lies at lower + ijk*h, 0 <= ijk <= cells. On an axis with walls, `layers` more nodes
   lie beyond each face; on a periodic axis node `cells` is node 0 again. */
typedef struct {
  PetscInt     dim, cells[3], layers[3], nodes[3]; /* nodes that are stored per axis, layers included */
  PetscReal    lower[3], upper[3], h[3];
  PetscBool    periodic[3];
  MPMWallBasis wall_basis[3]; /* form of the splines at the walls of each axis */
} MPMGrid;

void      MPMGridSetNodes(MPMGrid *, MPMBasis); /* layers and nodes, once the rest is known */
PetscReal MPMGridNodes(const MPMGrid *, MPMBasis);

/* Particles as kernels see them: one pointer a field, rows of its components; NULL where the scene has no such field or
   the running phase did not declare it.                                                                              */
typedef struct {
  PetscInt n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) ctype *name;
#include "fields.def"
#undef MPM_FIELD
} MPMView;

/* What a kernel finds on its way. Merged over patches and processes by MPMStatusMerge: max and sums of integers, so
   exact and without order. `bad` is the gravest condition that was met, which is the first of the list, with the
   smallest id that met it: a particle turned inside out soon throws others off the grid. */
typedef enum { MPM_OK, MPM_BAD_J, MPM_LEFT_GRID, MPM_TOO_WIDE, MPM_NUM_BAD } MPMBad;
typedef struct {
  MPMBad     bad;
  PetscInt64 id;
  PetscReal  x[3], J;     /* where it was, and its det F for MPM_BAD_J */
  PetscReal  v2, c2;      /* largest squared speed of a particle and of a wave, m^2/s^2 */
  PetscInt64 moved;       /* particles that changed cell */
  PetscInt64 interrupted; /* has a signal asked the run to end? */
  PetscInt64 left;        /* particles that left the patch */
  PetscInt64 hops;        /* patches that the farthest of these has to go along an axis */
  PetscInt64 most;        /* particles of the process that has most */
  PetscInt64 n, ids;      /* particles there are, and their fingerprint: none may get lost or doubled on the way */
} MPMStatus;

void MPMStatusReset(MPMStatus *);
void MPMStatusMerge(MPMStatus *, const MPMStatus *);

/* Constants of a step, all that kernels know of the scene. */
typedef struct {
  PetscReal          dt, flip, gravity[3]; /* s, 1, m/s^2 */
  PetscInt           order;                /* of xpic, else 0 */
  const MPMKind     *kinds;
  PetscInt           nkinds;
  const MPMMaterial *materials;
  const MPMFace (*faces)[2], (*before)[2], (*gradient)[2], (*residual)[2]; /* walls, as MPMWallsDerive makes them */
} MPMParams;

/* Number of values a node carries in `sum` and in `vel` (velocity, acceleration). The sums are a record of 8 in every
   dimension, mass, momentum [3] and force [3] from MPM_SUM_FORCE on: one vector, or a whole number of shorter ones,
   that lies in one line of the cache. Then the first and the last + 1 of the sums that parts of a transfer make. */
#define MPM_SUM_NC(dim)           8
#define MPM_SUM_FORCE             4
#define MPM_SUM_MET               7 /* axes (bits, a whole number) along which the advance met a wall that only pushes */
#define MPM_VEL_NC(dim)           (2 * (dim))
#define MPM_SUM_FIRST(dim, parts) ((parts)&MPM_P2G_MASS ? 0 : (parts)&MPM_P2G_MOMENTUM ? 1 : MPM_SUM_FORCE)
#define MPM_SUM_LAST(dim, parts)  ((parts)&MPM_P2G_FORCE ? MPM_SUM_FORCE + (dim) : 1 + (dim))

/* Components of each field: MPMComponents_x(dim), ... */
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  MPM_INLINE int MPMComponents_##name(int dim)                                                                         \
  {                                                                                                                    \
    (void)dim;                                                                                                         \
    return nc;                                                                                                         \
  }
#include "fields.def"
#undef MPM_FIELD

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
   are needed across a periodic face before their pass; all in the pool. MPM_PASS_LATE: where sums of other processes
   have to come first, others of the first rows, so that these need not be waited for. MPM_PASS_MAIN: all others; and
   the sums of all are added to the nodes. Sums of early and late tiles are kept. */
typedef enum { MPM_PASS_MAIN, MPM_PASS_EARLY, MPM_PASS_LATE, MPM_NUM_PASSES } MPMPass;

/* What the table of tiles says of one: which sums are kept (>= 0), it has particles, or none. */
enum { MPM_TILE_SCRATCH = -1, MPM_TILE_EMPTY = -2 };

/* Instead of the number of a cell or a base node: that of the position is in another patch, or it is outside the grid.
 */
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
  PetscReal      *sum;     /* [nslots][nodes of a tile][MPM_SUM_NC] kg, kg m/s, N */
  PetscReal      *scratch; /* [n0][nodes of a tile][MPM_SUM_NC] of the row at work */
  size_t          room;
  void           *memory; /* behind sum and scratch */
} MPMTiles;

/* Particles touch nodes first .. last-1 of a row; others are never visited. fresh: their sums are still to be zeroed.
 */
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
  PetscInt *movers; /* [nmovers] places q in order of particles that changed cell, as the commit notes them, of those
                       that left the patch MPM_FLAGGED(q); or NULL */
  PetscInt   nmovers;
  PetscReal *sum;               /* [n2][n1][n0][MPM_SUM_NC] kg, kg m/s, N; complete for own nodes */
  PetscReal *vel;               /* [n2][n1][n0][MPM_VEL_NC] m/s, m/s^2 */
  MPMSpan   *span;              /* [n2][n1] */
  void (*meanwhile)(void *ctx); /* called now and then while particles are summed; or NULL */
  void *ctx;
  void *memory; /* behind sum and span, where the patch owns them */
} MPMPatch;

/* Marks place q of a list, by a negative number; and q for such a number. */
#define MPM_FLAGGED(q) (-1 - (q))

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

typedef void (*MPMTransfer)(const MPMParams *, MPMPatch *, PetscInt parts, MPMStatus *);

/* The kernel for these parts, NULL if there is none; and its floating-point operations per particle. */
MPMTransfer MPMTransferFind(PetscInt dim, MPMBasis basis, PetscInt parts);
PetscReal   MPMTransferFlops(PetscInt dim, MPMBasis basis, PetscInt parts);
PetscInt    MPMTransferWidth(void); /* particles that kernels handle at a time: 8, 4 or 2, as the processor allows */

/* ---------------------------------------------------------------------------------------------------------------
   2. Parallel: who holds what
   --------------------------------------------------------------------------------------------------------------- */

/* The particles of this process: a DMSWARM_BASIC swarm stores the fields, plain arrays the scratch. */
typedef struct {
  DM         swarm;
  PetscInt   dim, n, capacity;        /* n: particles here; capacity: of the scratch and of order */
  PetscInt64 total;                   /* particles of the whole scene */
  PetscInt64 ids;                     /* the fingerprint of all particles of the scene */
  PetscReal  scattered;               /* particles that came to another cell since the storage was put in order */
  void      *scratch[MPM_NUM_FIELDS]; /* arrays of the scratch fields */
  PetscBool  present[MPM_NUM_FIELDS]; /* does the scene have the field? */
  PetscInt   bytes[MPM_NUM_FIELDS];   /* of a particle */
  PetscInt  *order, *start;           /* [n] particles by (cell, id); [cells of the patch + 1] */
  PetscInt  *spare;                   /* [n] the next order is made here */
  PetscInt  *arrivals;                /* [cells] particles that come to a cell; all 0 between uses */
  PetscInt  *movers, nmovers;         /* the particles that changed cell since, as in MPMPatch; -1: not known */
  PetscInt   nkept; /* particles below this one are where order has them, but those that changed cell or left */
  PetscInt   nstart;
} MPMParticles;

PetscErrorCode MPMParticlesLayout(MPM, MPMParticles *);
PetscErrorCode MPMParticlesCreate(MPM, MPMParticles *, MPI_Comm);
PetscErrorCode MPMParticlesSetSize(MPMParticles *, PetscInt n);
PetscErrorCode MPMParticlesResize(MPMParticles *);
PetscErrorCode MPMParticlesGetView(MPMParticles *, PetscInt fields, MPMView *);
PetscErrorCode MPMParticlesRestoreView(MPMParticles *, PetscInt fields, MPMView *);
PetscErrorCode MPMParticlesGetField(MPMParticles *, PetscInt field, void **at);
PetscErrorCode MPMParticlesRestoreField(MPMParticles *, PetscInt field);
PetscErrorCode MPMParticlesLeavers(MPMParticles *, PetscInt *n, PetscInt **which);
PetscErrorCode MPMParticlesSort(MPMParticles *, const MPMPatch *);
PetscErrorCode MPMParticlesLocate(MPMParticles *, const MPMPatch *, const MPMKind *);
PetscErrorCode MPMParticlesFingerprint(MPMParticles *, PetscInt64 *ids);
uint64_t       MPMParticleHash(PetscInt64 id); /* of one particle */
PetscErrorCode MPMParticlesCheck(MPMParticles *, MPI_Comm, PetscInt64 n, PetscInt64 ids);
PetscErrorCode MPMParticlesDigest(MPMParticles *, MPI_Comm, PetscInt64 *digest);
PetscErrorCode MPMParticlesDestroy(MPMParticles *);

/* The material state of particle p of a view, as far as it is there, as particle 0 of a block. */
void MPMParticlesState(PetscInt dim, const MPMView *, PetscInt p, MPMBlock *);

/* Where a field lives, and the rows of fields.def. */
typedef enum { MPM_STATE, MPM_SWARM, MPM_SCRATCH } MPMHome;
typedef struct {
  const char   *name, *unit, *meaning;
  PetscDataType type;
  MPMHome       home;
} MPMFieldInfo;
extern const MPMFieldInfo MPMFields[MPM_NUM_FIELDS];
PetscInt                  MPMFieldComponents(PetscInt field, PetscInt dim);
PetscInt                  MPMParticlesBytes(const MPMParticles *, MPMHome most);
PetscInt                  MPMParticlesMemory(const MPMParticles *);

/* Calls an inline function with the bytes of a field's row first: of known widths, they are copied in registers. */
/* clang-format off */
#define MPM_FOR_WIDTH(bytes, FUNCTION, ...)                                                                            \
  do switch (bytes) {                                                                                                  \
    case 4:  FUNCTION(4, __VA_ARGS__);  break;                                                                         \
    case 8:  FUNCTION(8, __VA_ARGS__);  break;                                                                         \
    case 16: FUNCTION(16, __VA_ARGS__); break;                                                                         \
    case 24: FUNCTION(24, __VA_ARGS__); break;                                                                         \
    case 32: FUNCTION(32, __VA_ARGS__); break;                                                                         \
    case 48: FUNCTION(48, __VA_ARGS__); break;                                                                         \
    case 72: FUNCTION(72, __VA_ARGS__); break;                                                                         \
    default: FUNCTION((size_t)(bytes), __VA_ARGS__);                                                                   \
    }                                                                                                                  \
  while (0)
/* clang-format on */

/* What a process has in a step, as the model (model.c) counts it. */
typedef struct {
  PetscReal particles, nodes,
      ghosts; /* own particles, own nodes that particles touch, nodes above its box that they touch */
  PetscReal neighbours, processes; /* that it sends to, and awaits from, in an exchange; all processes */
  PetscReal axes, cuts;            /* that are cut; planes between boxes, on all axes together */
  PetscReal crossing;              /* particles of all processes that change process in a step */
  PetscReal row, waits;            /* particles of a row along its cuts; chance that a row crosses a cut of an axis */
} MPMShare;

/* The model near a share, linear: s, s a particle, a ghost node, a node, a neighbour, a particle that changes process;
   cells that the fastest particle is taken to move in a step. */
typedef struct {
  PetscReal fixed, particle, ghost, node, neighbour, leaver, moved;
} MPMCosts;

/* How the grid is cut into boxes of nodes, one a process: p[d] parts on axis d, of l[d][...] nodes each. */
typedef struct {
  PetscInt  p[3], *l[3];
  MPMCosts  costs;                /* by which cuts are chosen: set before MPMPartitionChoose */
  PetscReal imbalance, predicted; /* largest over mean number of particles of a process; s a step by the costs */
  MPMShare  worst;                /* of the process for which predicted is largest; no processes, no crossing */
} MPMPartition;

typedef enum { MPM_BALANCE_NONE, MPM_BALANCE_START, MPM_BALANCE_AUTO } MPMBalance;

/* Particles per bin of nodes: each bin covers `coarse` nodes an axis. Processes count some of the particles each; the
   first has the summed-area tables, the others only lists of what they counted. */
typedef struct {
  MPI_Comm    comm;
  PetscInt    dim, nodes[3], n[3], coarse, stencil; /* stencil: nodes of a particle's stencil per axis */
  PetscInt64 *table;                                /* [n2+1][n1+1][n0+1] particles below */
  PetscInt64 *occupied;                             /* likewise: bins with particles below */
  PetscInt64 *list;                                 /* [listed][2] entry of table, particles */
  PetscInt    listed, capacity;
} MPMHistogram;

PetscErrorCode MPMHistogramCreate(const MPMGrid *, MPMBasis, MPI_Comm, MPMHistogram *);
PetscErrorCode MPMHistogramAdd(MPMHistogram *, const PetscInt base[], PetscInt64 particles); /* before Finish */
PetscErrorCode MPMHistogramFinish(MPMHistogram *);
PetscErrorCode MPMHistogramDestroy(MPMHistogram *);
PetscErrorCode MPMPartitionChoose(const MPMHistogram *, PetscMPIInt size, MPMBalance, MPMPartition *);
PetscReal      MPMPartitionCost(const MPMHistogram *, MPMPartition *);        /* sets imbalance and worst */
PetscInt       MPMPartitionLargest(const MPMGrid *, MPMBasis, PetscInt size); /* the largest legal count <= size */
PetscErrorCode MPMPartitionShare(MPMPartition *, MPI_Comm); /* that of its first process becomes that of all */
PetscErrorCode MPMPartitionDestroy(MPMPartition *);

PetscErrorCode MPMGridCreateDM(const MPMGrid *, MPI_Comm, PetscInt stencil, const MPMPartition *, DM *);

/* A phase of the step: a row of constants, documentation and contract at once. Kernels get NULL for particle fields
   that the row does not declare; an exchange sends just the declared ones. Node fields are there for the reader. */
typedef enum { MPM_PARTICLES_TO_NODES, MPM_NODES, MPM_NODES_TO_PARTICLES } MPMPhaseKind;
typedef struct {
  const char  *name;
  MPMPhaseKind kind;
  PetscInt     parts;                                         /* of the transfer; for MPM_NODES unused */
  void (*nodes)(const MPMParams *, MPMPatch *, PetscInt row); /* for MPM_NODES: one row of nodes */
  PetscInt    particles_in, particles_out;                    /* bits of particle fields */
  const char *nodes_in, *nodes_out;                           /* m p f v a */
} MPMPhase;

/* Messages: their length in bytes as MPI takes it, or an error; room for one; bytes of a particle's fields. */
PetscErrorCode MPMMessageLength(size_t bytes, PetscMPIInt *len);
PetscErrorCode MPMMessageRoom(char **buffer, size_t *capacity, size_t need);
size_t         MPMParticlesRowBytes(const MPMParticles *, PetscInt fields);

PetscErrorCode MPMPatchSetBox(MPMPatch *, const MPMGrid *, MPMBasis, DM da);
void           MPMPatchVisitAll(MPMPatch *);
void          *MPMAlign(void *memory);
PetscInt       MPMPatchNodes(const MPMPatch *);
PetscErrorCode MPMPatchRun(MPM, MPMPatch *, const MPMPhase *, MPMPass, MPMStatus *);
PetscErrorCode MPMPatchDestroy(MPMPatch *);

PetscErrorCode MPMTilesSetUp(MPMPatch *, PetscBool alone);
PetscErrorCode MPMTilesAssign(MPMPatch *, PetscBool keep,
                              const PetscInt start[]); /* [cells+1] where cells' particles begin */
void           MPMTilesWrap(MPMPatch *);
void           MPMTilesFindSpans(MPMPatch *);
PetscInt       MPMTilesCells(const MPMPatch *);
PetscInt       MPMTilesSent(const MPMPatch *, const int toward[3]);
size_t         MPMTilesBytes(const MPMPatch *, const int toward[3], PetscInt parts, PetscBool above);
size_t         MPMTilesPack(const MPMPatch *, const int toward[3], PetscInt parts, char *message);
void           MPMTilesUnpack(MPMPatch *, const int toward[3], PetscInt parts, const char *message);
size_t         MPMTilesCopy(const MPMPatch *, PetscInt slot, PetscInt parts, PetscBool pack, char *message);
PetscErrorCode MPMTilesDestroy(MPMPatch *);

/* A way to run the step. Physics, integrators and output are the same for all; only these functions differ. */
typedef struct {
  const char *name, *what;
  PetscErrorCode (*setup)(MPM);                   /* DMs, patches; then the scene adds particles */
  PetscErrorCode (*sweep)(MPM, const MPMPhase *); /* run a transfer on all patches */
  PetscErrorCode (*nodes)(MPM, const MPMPhase *); /* run a node phase and make its values known where they are read */
  PetscErrorCode (*reduce)(MPM, MPMStatus *);     /* merge the status of all processes: the one reduction of a step */
  PetscErrorCode (*settle)(MPM, PetscBool anew);  /* bring the particles home and in order; anew: no cell is known */
  PetscErrorCode (*finish)(MPM);
  PetscBool farms;                          /* the particles' work is done by others */
  PetscErrorCode (*serve)(MPM);             /* what a process without data does, until the run ends */
  PetscErrorCode (*share)(MPM, MPMShare *); /* ghosts, neighbours of this process; NULL: none */
} MPMExchangeType;

typedef struct {
  const MPMExchangeType *type;
  MPI_Comm               data; /* the processes that hold particles and grid; all DMs and files live on it */
  MPMPatch               patch;
  DM                     da;
  Vec                    vel; /* local vector behind patch.vel */
  MPMBalance             balance;
  PetscBool              direct;     /* -parallel_migrate direct */
  PetscBool              roundoff;   /* -parallel_sums roundoff */
  PetscBool              ready;      /* is set up */
  PetscInt               pool_cells; /* -pool_cells */
  void                  *farm;       /* of the pool: its master uses the rest as a run on one process does */
  MPMPartition           partition;
  PetscInt               recuts;     /* how often the grid was cut anew */
  PetscInt               migrations; /* steps in which particles changed process */
  PetscInt64             migrants;   /* how many did, in all */
  PetscReal busy, chunks, bytes; /* of the pool's master: s not spent waiting, patches handed out, bytes both ways */
  void     *ctx;
} MPMExchange;

PetscErrorCode MPMExchangeOpen(MPM, const MPMPhase *);
PetscErrorCode MPMExchangeClose(MPM, const MPMPhase *);
PetscErrorCode MPMExchangeRun(MPM, const MPMPhase *, MPMPass);

extern const MPMExchangeType *const MPMExchangeTypes[];                      /* rows of exchange.def, ends with NULL */
extern const MPMExchangeType        MPMExchange_serial, MPMExchange_spatial; /* the pool's master is one of them */

/* ---------------------------------------------------------------------------------------------------------------
   3. Program
   --------------------------------------------------------------------------------------------------------------- */

/* The strict reader of the option database; see options.c. The first error sticks, later reads do nothing. */
typedef struct _MPMOptions *MPMOptions;

PetscErrorCode MPMOptionsCreate(MPMOptions *);
PetscErrorCode MPMOptionsDestroy(MPMOptions *);
const char    *MPMOptionsError(MPMOptions); /* NULL if there was none */
void           MPMOptionsFail(MPMOptions, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
PetscErrorCode MPMOptionsShare(MPMOptions, MPI_Comm); /* a fault that any process has noted becomes that of all */
PetscErrorCode MPMOptionsDeclare(MPMOptions, PetscInt dim, PetscInt nm, char (*materials)[MPM_NAME_LEN], PetscInt nb,
                                 char (*bodies)[MPM_NAME_LEN], PetscInt nl, char (*loads)[MPM_NAME_LEN]);
PetscBool      MPMOptionsOverridden(const char name[], const char by[]);
PetscErrorCode MPMOptionsFinish(MPMOptions); /* options that were given but that this scene never asked for */
PetscErrorCode MPMOptionsText(char **text);  /* the option set as given; caller frees */

/* Readers: `row` is a name of options.def, `name` the material, body or face that it is for (or NULL). set may be
   NULL. A value that is not given keeps the default of the table (lists: what the caller put there).                 */
PetscErrorCode MPMOptionsReal(MPMOptions, const char row[], const char name[], PetscReal *value, PetscBool *set);
PetscErrorCode MPMOptionsInt(MPMOptions, const char row[], const char name[], PetscInt *value, PetscBool *set);
PetscErrorCode MPMOptionsBool(MPMOptions, const char row[], const char name[], PetscBool *value);
PetscErrorCode MPMOptionsEnum(MPMOptions, const char row[], const char name[], char value[MPM_NAME_LEN],
                              PetscBool *set);
PetscErrorCode MPMOptionsReals(MPMOptions, const char row[], const char name[], PetscReal value[3], PetscBool *set);
PetscErrorCode MPMOptionsInts(MPMOptions, const char row[], const char name[], PetscInt value[3], PetscBool *set);
PetscErrorCode MPMOptionsString(MPMOptions, const char row[], const char name[], char value[MPM_TEXT_LEN],
                                PetscBool *set);
PetscErrorCode MPMOptionsNames(MPMOptions, const char row[], PetscInt *n, char (**names)[MPM_NAME_LEN]);

/* Expressions of coordinates, one a component, by muParser. */
typedef struct _MPMExpression *MPMExpression;
PetscErrorCode MPMExpressionCreate(const char text[], const char variables[], MPMExpression *, PetscInt *n,
                                   char error[], size_t len);
PetscErrorCode MPMExpressionEvaluate(MPMExpression, PetscInt dim, const PetscReal x[], const PetscReal X[], PetscReal t,
                                     PetscReal value[]);
PetscErrorCode MPMOptionsExpression(MPMOptions, const char row[], const char name[], const char variables[],
                                    PetscInt nc, MPMExpression *);
PetscErrorCode MPMExpressionDestroy(MPMExpression *);

/* A body: where its particles start, of what, how fast. */
typedef struct {
  char          name[MPM_NAME_LEN];
  MPMRegion     region;
  PetscInt      material, kind, ppc[3];
  PetscReal     offset[3], b[3]; /* of its lattice of particles, and their spacing, m */
  MPMExpression velocity;        /* m/s, of x y z; NULL: at rest */
  PetscInt64    first, n;        /* ids first .. first+n-1 */
  PetscInt64    row;             /* its first row of lattice places, of those of all bodies */
} MPMBody;

PetscErrorCode MPMExchangeSetFromOptions(MPM, MPMOptions);

/* A load on the surface of a body: pressure against the deformed surface, or a traction per area at the start. */
typedef struct {
  char          name[MPM_NAME_LEN];
  PetscInt      body, sides; /* row of the scene's bodies; bits of the sides that it acts on, as in field surface */
  PetscBool     pressure;
  MPMExpression value; /* Pa, of x y z X Y Z t */
} MPMLoad;

/* A solution that is known: exact, or made so by a body force that belongs to it. Rows of reference.def. */
typedef struct _MPMReference MPMReference;
typedef struct _MPMKnown     MPMKnown; /* the one of this scene */

typedef struct {
  char          title[MPM_TEXT_LEN], name[MPM_NAME_LEN];
  PetscBool     dry_run;
  MPMMaterial  *materials;
  PetscInt      nmaterials;
  MPMBody      *bodies;
  PetscInt      nbodies;
  MPMKind      *kinds;
  PetscInt      nkinds;
  MPMFace       faces[3][2], before[3][2], gradient[3][2], residual[3][2]; /* as MPMWallsDerive makes them */
  MPMLoad      *loads;
  PetscInt      nloads;
  MPMExpression acceleration;        /* body force per mass in m/s^2, of x y z X Y Z t; or NULL */
  MPMKnown     *known;               /* or NULL */
  PetscBool     forced, keeps_start; /* are there body forces or loads; do particles carry their place at the start? */
  PetscInt64    overlap;             /* particles that lie in an earlier body too */
  PetscInt64    on_line;             /* particles that start exactly on a line of the grid */
  PetscInt64 rows, *share_first; /* of lattice places; [shares] particles before each of as many equal shares of them */
  PetscMPIInt shares;
} MPMScene;

PetscErrorCode MPMSceneSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMSceneCountParticles(MPM, MPMOptions);
PetscErrorCode MPMSceneAddParticles(MPM);
PetscErrorCode MPMSceneHistogram(MPM, MPMHistogram *);
PetscErrorCode MPMSceneDestroy(MPMScene *);

PetscErrorCode MPMKnownSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMKnownDestroy(MPMScene *);
PetscBool      MPMKnownStarts(const MPMScene *);
PetscBool      MPMKnownStart(const MPMScene *, PetscInt dim, const PetscReal X[], PetscReal x[], PetscReal v[],
                             PetscReal F[]);
void           MPMKnownForce(const MPMScene *, PetscInt dim, const PetscReal X[], PetscReal t, PetscReal b[]);
PetscErrorCode MPMKnownError(MPM, PetscReal *error, PetscReal *size);

/* Body forces and loads of the particles here for the time t, into field b. Not collective. */
PetscErrorCode MPMForcesSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMForcesUpdate(MPM, PetscReal t);
PetscErrorCode MPMForcesCheck(MPM, MPMOptions, const PetscReal x[], const PetscReal X[]);
PetscErrorCode MPMForcesDestroy(MPMScene *);

/* An update scheme: a row of phases. */
#define MPM_MAX_ORDER  16 /* of xpic */
#define MPM_MAX_PHASES (8 + 3 * MPM_MAX_ORDER)

/* What is timed of a step: the phases by their rows in step.c, then the rest. */
#define MPM_MAX_TIMERS 22
enum {
  MPM_TIMER_FORCES = MPM_MAX_TIMERS - 6,
  MPM_TIMER_REDUCE,
  MPM_TIMER_MIGRATE,
  MPM_TIMER_SORT,
  MPM_TIMER_SETTLE,
  MPM_TIMER_OTHER
};
typedef struct {
  const char     *name, *what;
  PetscBool       keeps_increment; /* x is read again after the motion: dx waits for the commit */
  const MPMPhase *phases[MPM_MAX_PHASES];
} MPMIntegrator;

extern const MPMIntegrator *const MPMIntegrators[]; /* usf usl musl, ends with NULL */

PetscErrorCode MPMStepSetUp(MPM); /* mpm->phases */
PetscErrorCode MPMPhaseBegin(MPM, const MPMPhase *);
PetscErrorCode MPMPhaseEnd(MPM, const MPMPhase *, PetscInt nparticles);

/* Parts of settling that -log_view and the table of phases show beside it: MPM_TIMER_MIGRATE and _SORT. Not collective.
 */
PetscErrorCode MPMSettlingBegin(MPM, PetscInt timer);
PetscErrorCode MPMSettlingEnd(MPM, PetscInt timer);

PetscErrorCode MPMStep(MPM);      /* t -> t + dt; collective on the exchange */
PetscErrorCode MPMStepNodes(MPM); /* mass and velocity of the nodes for the state as it is, for output */
PetscErrorCode MPMStepBound(MPM); /* v2 and c2 of the state as it is, into mpm->status */
PetscErrorCode MPMStepView(MPM);  /* the table of phases, after the run */
const char    *MPMTimerName(PetscInt timer);
PetscReal      MPMTimerSeconds(MPM, PetscInt timer); /* wall time here, of all steps */

/* The model of a step. The time of n particles or nodes: call + n each, where each is each[k] at size[k] and goes from
   one to the next by the logarithm of n, as caches overflow. */
#define MPM_RATE_SIZES 3
typedef struct {
  PetscReal call, size[MPM_RATE_SIZES], each[MPM_RATE_SIZES]; /* s, 1, s */
} MPMRate;

/* A migration takes call + stage s + process P + particle n + leaver q seconds for n particles here, of which q leave
   and as many come, and P processes; s is log2(P) for DMSwarmMigrate, and the number of axes that are cut here for
   direct messages. */
typedef struct {
  PetscReal call, stage, process, particle, leaver;
} MPMMigration;

typedef struct {
  MPMRate      rate[MPM_MAX_TIMERS];   /* all passes of a step together */
  PetscReal    exchange, message;      /* s an exchange with the neighbours, and a message on its way */
  PetscReal    post;                   /* s that a message takes of the processors at its ends */
  PetscReal    wire, copy;             /* s a byte: on its way, packed and unpacked */
  PetscReal    kept;                   /* s a byte of tiles' sums that are sent: zeroed, packed, unpacked */
  PetscReal    reduction;              /* s of the step's reduction for each doubling of the processes */
  MPMMigration migration[2];           /* swarm, direct */
  PetscReal    chunk, farm;            /* s a patch of the pool, s a byte of it, on either side */
  PetscReal    flop, byte;             /* s that a core takes at best for an operation, a byte of memory; 0: unknown */
  char         from[2 * MPM_NAME_LEN]; /* where the constants come from */
} MPMModel;

/* The work of each step, see path.c. */
typedef struct {
  PetscBool on;    /* -report_path */
  PetscBool clock; /* timers read processor time */
  PetscInt  row, capacity;
  PetscReal start, paused, *seconds;  /* [row+1][MPM_MAX_TIMERS] s of processor time, here */
  PetscReal messages[MPM_MAX_TIMERS]; /* s a step, by the model, of the process that sends most */
} MPMPath;
PetscErrorCode MPMClock(MPM, PetscLogDouble *);
void           MPMWorkBegin(MPM);
void           MPMWorkEnd(MPM, PetscInt timer);
void           MPMWorkPause(MPM);
void           MPMWorkResume(MPM);
PetscErrorCode MPMWorkStep(MPM);
PetscErrorCode MPMWorkView(MPM);

PetscErrorCode MPMModelSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMModelSetUp(MPM);
PetscErrorCode MPMModelLoad(MPM, char wrong[], size_t len);
void           MPMModelMethod(MPM, char text[], size_t len);
PetscReal      MPMModelTimer(MPM, PetscInt timer, const MPMShare *);
void           MPMModelCosts(MPM, PetscReal particles, MPMCosts *);
void           MPMModelCross(PetscInt dim, PetscReal layer, PetscReal per_cell, PetscReal moved, MPMShare *);
PetscErrorCode MPMModelShare(MPM, MPMShare *); /* of this process as it is */
PetscErrorCode MPMModelPredict(MPM);
PetscErrorCode MPMModelView(MPM);
PetscErrorCode MPMCalibrate(MPM);

/* An exact sum of doubles: a 2176-bit fixed-point number. Order-free, so equal on any number of processes. */
#define MPM_SUM_WORDS 68
typedef struct {
  PetscInt64 word[MPM_SUM_WORDS];
  PetscInt   pending;
} MPMSum;
void           MPMSumZero(MPMSum *);
void           MPMSumAdd(MPMSum *, PetscReal);
PetscReal      MPMSumValue(MPMSum *); /* below 1 ulp from exact */
PetscErrorCode MPMSumReduce(MPMSum *, PetscInt n, MPI_Comm);

/* Totals of the state. */
typedef struct {
  PetscReal  kinetic, strain;                     /* J: m v^2/2, V0 W */
  PetscReal  momentum[3], moment[3], mass, speed; /* sum m v, sum m x, sum m, sum m |v| */
  PetscInt64 n;
} MPMTotals;
PetscErrorCode MPMTotalsCompute(MPM, MPMTotals *);

typedef struct {
  FILE     *file;                         /* on the first process of the data communicator */
  PetscReal every, next;                  /* s of simulated time */
  PetscReal check_energy, check_momentum; /* relative; 0: off */
  PetscReal energy_max;                   /* the largest kinetic + strain energy so far, J */
  PetscReal speed_max;                    /* the largest sum m |v| so far, kg m/s */
  PetscInt  last;                         /* step of the last line */
  PetscBool off;                          /* no file, no totals: a run of the calibration */
  MPMTotals start, now;
} MPMMonitor;
PetscErrorCode MPMMonitorSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMMonitorStep(MPM, PetscBool force); /* may set mpm->stop */
PetscErrorCode MPMMonitorDestroy(MPMMonitor *);
PetscReal      MPMMonitorWork(MPM);
PetscReal      MPMNextTime(PetscReal t, PetscReal every); /* when a cadence is due again */

typedef struct {
  char        dir[MPM_TEXT_LEN];
  PetscBool   enabled;
  PetscBool   replaced;    /* files of the same name were there */
  PetscReal   every, next; /* s of simulated time */
  PetscInt    fields;      /* bits of MPMOutputFields, and MPM_OUTPUT_GRID */
  PetscInt    count, last; /* snapshots written; step of the last */
  PetscInt   *steps;       /* [count] */
  PetscReal  *times;       /* [count] s */
  PetscViewer viewer;      /* of the HDF5 file */
} MPMOutput;
#define MPM_OUTPUT_GRID (1 << 30) /* bit of the nodes in MPMOutput.fields */

/* A field of a snapshot: fills one row of nc values for particle p. */
typedef struct {
  const char *name, *option, *unit, *components; /* option: its word in -output_fields; NULL: always there */
  PetscInt    nc;
  PetscBool   whole; /* whole numbers */
  PetscInt    needs; /* bits of fields: it is there if the scene has them */
  void (*fill)(MPM, const MPMView *, PetscInt p, PetscReal row[]);
} MPMOutputField;
extern const MPMOutputField MPMOutputFields[]; /* the last has no name */

PetscErrorCode MPMOutputSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMOutputReadFields(MPM, MPMOptions, PetscBool *set);
PetscErrorCode MPMOutputMakeFolder(MPM, MPMOptions);
PetscErrorCode MPMOutputStep(MPM, PetscBool force);
PetscErrorCode MPMOutputDestroy(MPM);
PetscErrorCode MPMXdmfWrite(MPM);

PetscErrorCode MPMPrint(MPM, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
PetscErrorCode MPMNotes(MPM);
PetscErrorCode MPMReportStart(MPM);
PetscErrorCode MPMReportProgress(MPM);
PetscErrorCode MPMReportEnd(MPM);
PetscErrorCode MPMRoofline(MPM); /* the line `speed`: what was achieved, of what the machine can */
PetscErrorCode MPMLimits(MPI_Comm, PetscReal *flop, PetscReal *byte);

/* A ladder of runs; see study.c. */
typedef struct {
  char      type[MPM_NAME_LEN], vary[MPM_NAME_LEN]; /* type "": none */
  PetscInt  levels;
  PetscReal order_min; /* < 0: any */
  PetscBool finest;    /* the last run is the reference */
} MPMStudy;
PetscErrorCode MPMStudySetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMStudyRun(MPM, int *status);
PetscErrorCode MPMPlotLogLog(const char path[], const char title[], const char xlabel[], const char ylabel[],
                             PetscInt n, const PetscReal x[], const PetscReal y[]);

/* Everything of a run. */
struct _p_MPM {
  MPI_Comm             comm;
  MPMScene             scene;
  MPMGrid              grid;
  MPMBasis             basis;
  const MPMIntegrator *integrator;
  PetscBool            affine, stretched;       /* APIC; GIMP domains follow the deformation */
  MPMPhase             phases[MPM_MAX_TIMERS];  /* the table of phases as this scene needs it */
  const MPMPhase      *program[MPM_MAX_PHASES]; /* [nprogram] the phases of a step */
  PetscInt             nprogram;
  MPMExchange          exchange;
  MPMParticles         particles;
  MPMParams            params;
  MPMStatus            status; /* of the last step */
  MPMMonitor           monitor;
  MPMOutput            output;
  MPMStudy             study;
  PetscReal            flops, bytes; /* of the phases here, counted by hand; of the pool's master: its workers' too */
  MPMModel             model;
  PetscBool            calibrate;                                              /* -model_calibrate */
  char                 model_file[2 * MPM_TEXT_LEN], model_note[MPM_TEXT_LEN]; /* why the file is not used */
  PetscReal            predicted[MPM_MAX_TIMERS];                              /* s a step, by the model */
  MPMPath              path;
  PetscBool            report_limits;                 /* measure those of the machine for the line `speed` */
  PetscBool            quiet;                         /* prints nothing: a rung of a study */
  PetscReal            t, time_end, dt_fixed, dt_cfl; /* s; dt_fixed 0: automatic */
  PetscInt             step, max_steps;
  PetscBool            progress;           /* a line of progress stands on the terminal */
  PetscReal            courant;            /* the largest dt (c + |v|)/h of the run */
  char                 stop[MPM_TEXT_LEN]; /* why the run has to stop early; empty: it need not */
  PetscLogDouble       phase_start, wall_start, wall_report, wall_steps, phase_seconds[MPM_MAX_TIMERS];
  PetscLogDouble       wall_output; /* s of history and snapshots */
};

PetscErrorCode MPMCreate(MPI_Comm, MPM *);
PetscErrorCode MPMSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMSetUp(MPM);
PetscErrorCode MPMRun(MPM);
PetscErrorCode MPMDestroy(MPM *);
PetscReal      MPMTimeStep(MPM); /* dt of the next step, s */
PetscReal      MPMCourant(MPM, PetscReal dt);
PetscReal      MPMViscousStep(MPM);  /* bound of dt by viscosity, s; infinite without */
PetscInt       MPMInterrupted(void); /* did SIGINT or SIGTERM come? */

/* For the simulator: the time that work takes, declared where it is done; elsewhere nothing. See simulate.c. */
#if defined(MPM_SIMULATE)
void MPMSimulateExecute(PetscReal seconds);
void MPMSimulateWork(const char name[], PetscReal amount);
#else
MPM_INLINE void MPMSimulateWork(const char name[], PetscReal amount)
{
  (void)name;
  (void)amount;
}
#endif

/* Provenance, in version.c: version, commit, compiler and flags of this build. */
extern const char MPMVersionGit[], MPMVersionCompiler[], MPMVersionFlags[];

#endif
