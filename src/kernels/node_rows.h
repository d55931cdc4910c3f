/* node_rows.h - how loops see the nodes of a patch: row by row of its own nodes, with what node.def lists. */
#ifndef MPM_NODE_ROWS_H
#define MPM_NODE_ROWS_H

#include "kernels/patch.h"

/* A row of own nodes along x, or of a part of the patch's arrays. Arrays begin at node 0 of the row; those of its own
   nodes that particles touch are first .. last-1, maybe none. */
typedef struct {
  PetscInt      row;                 /* of the arrays */
  PetscInt      first, last, ijk[3]; /* ijk: the number of node 0 in the grid */
  MPMNode      *sum;                 /* the first line; of the others by MPMNodesSum */
  PetscReal    *motion;              /* [MPM_MOTION_NC(dim)] each */
  PetscReal    *state;               /* as motion: displacement and velocity in the total frame, else NULL */
  MPMNodeValues value;
  PetscInt      line; /* from a line of sums to the next one, in records */
} MPMNodes;

/* Sets r to the patch's own row j, k. */
MPM_INLINE void MPMNodesRow(const MPMPatch *patch, PetscInt j, PetscInt k, MPMNodes *r)
{
  const PetscInt dim = patch->grid->dim, own = patch->own_lo[0] - patch->lo[0];
  PetscInt       at;

  r->row    = (k + patch->own_lo[2] - patch->lo[2]) * patch->n[1] + j + patch->own_lo[1] - patch->lo[1];
  at        = r->row * patch->n[0];
  r->first  = PetscMax(own, patch->span[r->row].first);
  r->last   = PetscMin(own + patch->own_n[0], patch->span[r->row].last);
  r->ijk[0] = patch->lo[0];
  r->ijk[1] = patch->own_lo[1] + j;
  r->ijk[2] = patch->own_lo[2] + k;
  r->sum    = patch->node + at;
  r->motion = patch->motion + at * MPM_MOTION_NC(dim);
  r->state  = patch->state ? patch->state + at * MPM_MOTION_NC(dim) : NULL;
  r->line   = patch->n[0] * patch->n[1] * patch->n[2];
#define MPM_NODE_VALUE(name, nc, unit, meaning) r->value.name = patch->value.name + at * MPMNodeComponents_##name(dim);
#include "kernels/node.def"
}

/* Repeats a statement for each row of the patch's own nodes, with what is in it in `r`. */
#define MPM_FOR_OWN_ROWS(patch, r)                                                                                     \
  for (PetscInt mpm_k = 0; mpm_k < (patch)->own_n[2]; mpm_k++)                                                         \
    for (PetscInt mpm_j = 0; mpm_j < (patch)->own_n[1]; mpm_j++)                                                       \
      for (MPMNodes r, *mpm_r = (MPMNodesRow(patch, mpm_j, mpm_k, &r), &r); mpm_r; mpm_r = NULL)

/* Returns the components of the sums from MPM_NODE_<name> on, at node i of the row. */
MPM_INLINE PetscReal *MPMNodesSum(const MPMNodes *r, PetscInt number, PetscInt i)
{
  return (PetscReal *)(r->sum + number / MPM_NODE_NC * r->line + i) + number % MPM_NODE_NC;
}

#endif
