/* contact.h - what a run keeps of contact between bodies whose particles have nodes of their own: what a scene declares, and what a step
   finds (step/contact_find.c) and applies (step/contact.c). */
#ifndef MPM_CONTACT_H
#define MPM_CONTACT_H

#include "base/exact_sum.h"

/* Two copies of the grid's nodes whose bodies meet, a < b, and how. */
typedef struct {
  PetscInt  a, b, axis; /* axis: the normal is along it; -1: it is found */
  PetscReal mu;         /* of friction; PETSC_INFINITY: nothing slides while it touches */
  PetscBool glued;      /* no contact is declared: where they meet they move as one */
} MPMPair;

/* A node that has matter of both copies of a pair, or of a body beside a rigid one: its place in the grid; the normal there,
   from a to b; the axis and side of its column. Of a and b each: the sum of the weights of the surface, in units; how far
   the end of the matter straight ahead is from the node along the normal, and of that beside, m; its share in the impulse
   of its column. */
typedef struct {
  PetscInt   pair, ijk[3], axis, side;
  PetscReal  n[3], share[2];
  PetscInt64 weight[2];
  PetscReal  near[2], wide[2];
} MPMContactNode;

/* A column of nodes, first .. last-1, which follow each other along their axis. gap: between the matter of a and b, m;
   least: the least velocity with which they may part, below 0: approach, m/s; held: is it given one in this step, and
   which. */
typedef struct {
  PetscInt  first, last;
  PetscReal gap, least, to;
  PetscBool held;
} MPMContactColumn;

typedef struct {
  PetscInt          npairs, nnodes, ncolumns, room;
  MPMPair          *pair;   /* [npairs] */
  MPMContactNode   *node;   /* [nnodes] in sequence of pairs and columns: the same ones on all processes */
  MPMContactColumn *column; /* [ncolumns] */
  PetscReal        *sum;    /* [nnodes][2][4] mass, kg, and velocity, m/s, of the nodes of both copies */
  PetscInt64        met;    /* columns that were held in the last step */
} MPMContacts;

#endif
