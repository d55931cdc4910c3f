/* contact.h - what a run keeps of contact between bodies whose particles have nodes of their own: what a scene declares, and
   what a step finds (step/contact_find.c) and applies (step/contact.c). */
#ifndef MPM_CONTACT_H
#define MPM_CONTACT_H

#include "physics/rigid.h"

/* Two copies of the grid's nodes whose bodies meet, a < b, and how; or a rigid body and a copy, with a = -1. */
typedef struct {
  PetscInt    a, b, axis; /* axis: the normal is along it; -1: it is found */
  const char *name;       /* of the contact, if its axis is given */
  MPMRigid   *rigid;      /* NULL: the pair is of two copies */
  PetscReal   mu;         /* of friction; PETSC_INFINITY: nothing slides while it touches */
  PetscBool   glued;      /* no contact is declared: where they meet they move as one */
  PetscBool   flows; /* one of them, a fluid (between bodies a soil too), keeps no shape: every node acts on its own */
  PetscBool   soft[2]; /* has a, b matter that keeps no shape? */
} MPMPair;

/* A node of a copy that takes part in contact: mass along each axis, kg, acceleration, m/s^2, and velocity, m/s, as a phase
   has left it, where bodies that are glued have the same one, and as contact changes it. */
typedef struct {
  PetscInt  copy, ijk[3];
  PetscReal m[3], a[3], was[3], v[3];
  PetscBool changes, tied; /* tied: it has the velocity of a rigid body */
} MPMContactSite;

/* A node of the grid that has matter of both copies of a pair: the sites of a and b; the normal there, from a to b. Of a and
   b each: the sum of the weights of the surface, in units; and for columns along each axis how far the end of the matter
   straight ahead is from the node along the normal, and of that beside, m. tied: a rigid body gives it its velocity, and so
   far in this phase the impulse `given`, N s. */
typedef struct {
  PetscInt   pair, ijk[3], site[2];
  PetscReal  n[3];
  PetscInt64 weight[2];
  PetscReal  near[2][3], wide[2];
  PetscBool  tied;
  PetscReal thin[2]; /* m, of a rigid body: the distance of the matter on its side; the thickness to the other side's */
  PetscReal given[3];
  PetscReal room[4]; /* of rigid bodies: what they leave of these gaps in this step, m; the last one beside */
} MPMContactNode;

/* A node's part in a column along an axis: its shares in the impulse on a and b. */
typedef struct {
  PetscInt  node, pair, axis, side;
  PetscReal share[2];
} MPMContactPart;

/* A column of nodes that follow each other along an axis, parts first .. last-1: its normal; at: where it acts on a
   rigid body, m; gap: between the matter of a and b, m; least: the least velocity with which they may part, below 0:
   approach, m/s; inverse: by how much an impulse of 1 N s changes it, 1/kg; across: and one across the normal, of matter
   alone; press, brake: the impulses along the normal and across it, on b, N s; held: is it given a velocity in this
   step? */
typedef struct {
  PetscInt  first, last, pair;
  PetscReal n[3], at[3], gap, least, inverse, across, press, brake[3];
  PetscBool held, slips; /* slips: a fluid there is too far from what it sticks to */
} MPMContactColumn;

/* An own tile of the patch with particles of one copy, and where it is among those of the grid. */
typedef struct {
  PetscInt tile, copy, at[3];
} MPMContactTile;

/* Tiles of the grid on each axis, n; of each copy bits of those with particles, [copies][words] of 64 bits; and the box
   around them: minus the lowest on each axis, the highest. beside: own tiles next to tiles of other copies. */
typedef struct {
  PetscInt  n[3], words, nbeside, room;
  uint64_t *bits;
  PetscInt (*box)[6];
  MPMContactTile *beside;
} MPMContactTiles;

typedef struct {
  PetscInt          npairs, nnodes, nsites, nparts, ncolumns;
  PetscInt          corrections; /* of afmpm in this step so far */
  PetscInt          shared;      /* the copy of all bodies that no contact names, or -1 */
  PetscBool         near;    /* are particles of two copies near each other? then `tiles` are those of all processes */
  PetscBool         beside;  /* it has been said that bodies lie beside each other, seen along the axis that is given */
  PetscInt          clear;   /* until bodies approach each other by so many cells, tiles need not be looked at again, */
  PetscReal         moved;   /* cells that a particle may have moved since they were; */
  PetscInt64        waiting; /* as long as so many particles have not flowed in yet */
  MPMContactTiles   tiles;
  MPMPair          *pair;   /* [npairs] */
  MPMContactNode   *node;   /* [nnodes]; these and the others are the same ones on all processes */
  MPMContactSite   *site;   /* [nsites] */
  MPMContactPart   *part;   /* [nparts] in sequence of columns */
  MPMContactColumn *column; /* [ncolumns] */
} MPMContacts;

#endif
