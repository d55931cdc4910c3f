/* light.c - light nodes: how they are found, and how the next nodes carry them; light.h says why. All that a patch
   needs of other patches are the sums of nodes up to MPM_LIGHT_LAYERS from its own, so what becomes of a node does not
   depend on how the grid is cut: contributions to it are added in the sequence of the nodes that they come from. */
#include "base/pages.h"
#include "kernels/light.h"
#include "kernels/node_rows.h"
#include "kernels/round.h"
#include "physics/wall.h"

#define OUTWARD 3 /* in light->given: of bodies of revolution, the momentum of v_r = r (round.h) */

/* Returns the distance in the arrays between neighbours on axis d. */
MPM_INLINE PetscInt Step(const MPMPatch *patch, PetscInt d)
{
  return d == 0 ? 1 : d == 1 ? patch->n[0] : patch->n[0] * patch->n[1];
}

/* Sets [first, last) to where row j, k of the arrays may have mass among its nodes from .. to - 1: of an own row its
   span, and nodes of other patches on both sides of it. */
MPM_INLINE void Occupied(const MPMPatch *patch, PetscInt j, PetscInt k, PetscInt from, PetscInt to, PetscInt *first,
                         PetscInt *last)
{
  const MPMSpan *span   = patch->span + k * patch->n[1] + j;
  const PetscInt own[3] = {patch->own_lo[0] - patch->lo[0], j + patch->lo[1] - patch->own_lo[1],
                           k + patch->lo[2] - patch->own_lo[2]};

  *first = from;
  *last  = to;
  if (own[1] < 0 || own[1] >= patch->own_n[1] || own[2] < 0 || own[2] >= patch->own_n[2]) return;
  if (from >= own[0]) *first = PetscMax(from, span->first);
  if (to <= own[0] + patch->own_n[0]) *last = PetscMin(to, span->last);
}

PetscErrorCode MPMLightMass(MPMLight *light, const MPMPatch *patch)
{
  const PetscInt rows  = patch->n[1] * patch->n[2];
  const size_t   nodes = (size_t)(patch->n[0] * rows);

  PetscFunctionBeginUser;
  if (!light->mass) {
    PetscCall(MPMPagesCalloc(nodes * sizeof *light->mass, &light->mass));
    PetscCall(MPMPagesCalloc(nodes * MPM_LIGHT_GIVEN * sizeof *light->given, &light->given));
    PetscCall(PetscCalloc1(rows, &light->filled));
  }
  MPM_FOR_OWN_ROWS(patch, r)
  {
    PetscReal *mass = light->mass + r.row * patch->n[0];

    for (PetscInt i = light->filled[r.row].first; i < light->filled[r.row].last; i++) mass[i] = 0;
    for (PetscInt i = r.first; i < r.last; i++) mass[i] = r.sum[i].m;
    light->filled[r.row] = (MPMSpan){r.first, r.last, PETSC_FALSE};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the side on which a node of mass m > 0 is light on axis d: its neighbour there has more than 1/share of its
   mass, and the opposite one less than share of it; else 0. at: the node's place in the arrays on this axis. */
MPM_INLINE int Side(const MPMPatch *patch, const PetscReal *mass, PetscInt d, PetscInt at, PetscReal share)
{
  const PetscInt  step = Step(patch, d);
  const PetscReal m = *mass, below = at > 0 ? mass[-step] : 0, above = at < patch->n[d] - 1 ? mass[step] : 0;

  if (m < share * above && below <= share * m) return 1;
  if (m < share * below && above <= share * m) return -1;
  return 0;
}

/* Returns the number of a light node's carriers. */
MPM_INLINE int Carriers(const MPMLightNode *light)
{
  return 1 << ((light->side[0] != 0) + (light->side[1] != 0) + (light->side[2] != 0));
}

/* Returns carrier number c of a light node, an index of the arrays, and its weight. */
MPM_INLINE PetscInt Carrier(const MPMPatch *patch, const MPMLightNode *light, int c, PetscReal *weight)
{
  PetscInt carrier = light->node;

  *weight = 1;
  for (PetscInt d = 0; d < 3; d++) {
    if (!light->side[d]) continue;
    carrier += (c & 1 ? 2 : 1) * light->side[d] * Step(patch, d);
    *weight *= c & 1 ? -1 : 2;
    c >>= 1;
  }
  return carrier;
}

/* Sets at [3] to the place of a node in the arrays. */
MPM_INLINE void Place(const MPMPatch *patch, PetscInt node, PetscInt at[])
{
  at[0] = node % patch->n[0];
  at[1] = node / patch->n[0] % patch->n[1];
  at[2] = node / (patch->n[0] * patch->n[1]);
}

/* Returns whether the light node can be carried: its carriers are in the arrays, have more than 1/share of its mass
   each, and are not light themselves. at [3]: its place in the arrays. */
static PetscBool IsCarried(const MPMPatch *patch, const PetscReal *mass, const MPMLightNode *node, const PetscInt at[],
                           PetscReal share)
{
  for (PetscInt d = 0; d < 3; d++)
    if (at[d] + 2 * node->side[d] < 0 || at[d] + 2 * node->side[d] >= patch->n[d]) return PETSC_FALSE;
  for (int c = 0; c < Carriers(node); c++) {
    PetscReal      weight;
    const PetscInt carrier = Carrier(patch, node, c, &weight);
    PetscInt       place[3];

    Place(patch, carrier, place);
    if (!(share * mass[carrier] > mass[node->node])) return PETSC_FALSE;
    for (PetscInt d = 0; d < patch->grid->dim; d++)
      if (Side(patch, mass + carrier, d, place[d], share)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns whether the wall of a face acts on node i of its axis, which has n cells. A piston acts on the nodes `beside`
   its plane too, but holds only the matter of a column as a whole. */
MPM_INLINE PetscBool AtFace(const MPMFace *f, int side, PetscInt n, PetscInt i, PetscBool beside)
{
  if (!MPMWallHas(f->type, MPM_WALL_NORMAL)) return PETSC_FALSE;
  if ((side ? n - i : i) <= f->reach) return PETSC_TRUE;
  return beside && f->type == MPM_WALL_piston && i >= f->first && i < f->first + f->beside ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether a wall acts along axis d on node i of the axis, or a piston is beside it. */
MPM_INLINE PetscBool AtWall(const MPMWalls *walls, const MPMGrid *grid, PetscInt d, PetscInt i)
{
  for (int side = 0; side < 2; side++)
    if (AtFace(&walls->given[d][side], side, grid->cells[d], i, PETSC_TRUE)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Adds node i, j, k of the arrays to the list if it is light. */
static PetscErrorCode Look(MPMLight *light, const MPMParams *par, const MPMPatch *patch, PetscInt i, PetscInt j,
                           PetscInt k)
{
  const PetscInt at[3] = {i, j, k};
  MPMLightNode   node  = {.node = (k * patch->n[1] + j) * patch->n[0] + i};
  PetscBool      any   = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < patch->grid->dim; d++) {
    node.side[d] = Side(patch, light->mass + node.node, d, at[d], par->light);
    if (node.side[d] && AtWall(par->walls, patch->grid, d, MPMGridFold(patch->grid, d, patch->lo[d] + at[d])))
      node.side[d] = 0;
    if (node.side[d]) any = PETSC_TRUE;
  }
  if (!any || (light->held && light->held[node.node]) || !IsCarried(patch, light->mass, &node, at, par->light))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (light->n == light->room) {
    light->room = 2 * light->room + 256;
    PetscCall(PetscRealloc((size_t)light->room * sizeof *light->node, &light->node));
  }
  light->node[light->n++] = node;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMLightFind(MPMLight *light, const MPMParams *par, const MPMPatch *patch)
{
  PetscReal most = 0; /* a node that is light has less mass than the share of the largest one */
  PetscInt  from[3], to[3];

  PetscFunctionBeginUser;
  light->n = 0;
  for (PetscInt k = 0; k < patch->n[2]; k++)
    for (PetscInt j = 0; j < patch->n[1]; j++) {
      const PetscReal *mass = light->mass + (k * patch->n[1] + j) * patch->n[0];
      PetscInt         first, last;

      Occupied(patch, j, k, 0, patch->n[0], &first, &last);
      for (PetscInt i = first; i < last; i++) most = PetscMax(most, mass[i]);
    }
  for (PetscInt d = 0; d < 3; d++) {
    from[d] = PetscMax(0, patch->own_lo[d] - 2 - patch->lo[d]);
    to[d]   = PetscMin(patch->n[d], patch->own_lo[d] + patch->own_n[d] + 2 - patch->lo[d]);
  }
  for (PetscInt k = from[2]; k < to[2]; k++)
    for (PetscInt j = from[1]; j < to[1]; j++) {
      const PetscReal *mass = light->mass + (k * patch->n[1] + j) * patch->n[0];
      PetscInt         first, last;

      Occupied(patch, j, k, from[0], to[0], &first, &last);
      for (PetscInt i = first; i < last; i++)
        if (mass[i] > 0 && mass[i] < par->light * most) PetscCall(Look(light, par, patch, i, j, k));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a node of the arrays is one of the patch's own. */
MPM_INLINE PetscBool IsOwn(const MPMPatch *patch, PetscInt node)
{
  PetscInt place[3];

  Place(patch, node, place);
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt at = place[d] + patch->lo[d] - patch->own_lo[d];

    if (at < 0 || at >= patch->own_n[d]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns the mass of a node of the arrays along axis d. */
MPM_INLINE PetscReal Mass(const MPMPatch *patch, PetscInt node, PetscInt d)
{
  return MPMNodeMass(patch->grid, patch->node + node, patch->lo[0] + node % patch->n[0], d);
}

/* Returns the mass that was collected for a carrier along axis d. Along r it is such that a uniform expansion of
   carriers and light nodes has the momentum that they have. */
MPM_INLINE PetscReal GivenMass(const MPMPatch *patch, PetscInt node, const PetscReal given[], PetscInt d)
{
  const MPMGrid  *grid = patch->grid;
  const PetscReal r    = grid->lower[0] + (PetscReal)(patch->lo[0] + node % patch->n[0]) * grid->h[0];

  return grid->round && !d && r > 0 ? given[OUTWARD] / r : given[0];
}

/* Adds to light->given what light nodes give to their carriers here, times the carriers' weights: mass and force, or,
   where `inertia`, their masses times their accelerations, without gravity. */
static void Collect(MPMLight *light, const MPMParams *par, const MPMPatch *patch, PetscBool inertia)
{
  const PetscInt dim = patch->grid->dim, nc = MPM_MOTION_NC(dim);

  for (PetscInt q = 0; q < light->n; q++)
    for (int k = 0; k < Carriers(&light->node[q]); k++) {
      PetscReal        weight;
      const PetscInt   node = light->node[q].node, carrier = Carrier(patch, &light->node[q], k, &weight);
      const PetscReal *a  = patch->motion + node * nc + dim;
      PetscReal       *to = light->given + carrier * MPM_LIGHT_GIVEN;

      if (!IsOwn(patch, carrier)) continue;
      to[0] += weight * patch->node[node].m;
      if (patch->grid->round) to[OUTWARD] += weight * patch->node[node].p[2];
      for (PetscInt d = 0; d < dim; d++)
        to[1 + d] += weight * (inertia ? Mass(patch, node, d) * (a[d] - par->gravity[d]) : patch->node[node].f[d]);
    }
}

/* Visits each own carrier once: returns what was collected for it, to be zeroed, or NULL if it has been visited or is
   not an own node. */
static PetscReal *Collected(MPMLight *light, const MPMPatch *patch, PetscInt carrier)
{
  PetscReal *given = light->given + carrier * MPM_LIGHT_GIVEN;

  return IsOwn(patch, carrier) && given[0] != 0 ? given : NULL;
}

/* Sets ijk [3] to the number of a node in the grid, and returns the axes (bits) along which a wall may hold it. */
static int Held(const MPMParams *par, const MPMPatch *patch, PetscInt node, PetscInt ijk[])
{
  const int dim  = (int)patch->grid->dim;
  int       held = 0;

  Place(patch, node, ijk);
  for (int d = 0; d < 3; d++) {
    const PetscInt at = MPMGridFold(patch->grid, d, ijk[d] += patch->lo[d]);

    for (int side = 0; side < 2 && d < dim; side++) {
      const MPMFace *f = &par->walls->given[d][side];

      if (!AtFace(f, side, patch->grid->cells[d], at, PETSC_FALSE)) continue;
      held |= MPMWallHas(f->type, MPM_WALL_TANGENT | MPM_WALL_BRAKES) ? (1 << dim) - 1 : 1 << d;
    }
  }
  return held;
}

void MPMLightGive(MPMLight *light, const MPMParams *par, MPMPatch *patch)
{
  Collect(light, par, patch, PETSC_FALSE);
  for (PetscInt q = 0; q < light->n; q++)
    for (int k = 0; k < Carriers(&light->node[q]); k++) {
      PetscReal      weight;
      const PetscInt carrier = Carrier(patch, &light->node[q], k, &weight);
      PetscReal     *given   = Collected(light, patch, carrier);
      MPMNode       *n       = patch->node + carrier;
      PetscInt       ijk[3];
      int            held;

      if (!given) continue;
      held = Held(par, patch, carrier, ijk);
      for (PetscInt d = 0; d < patch->grid->dim; d++) /* what a wall holds is its reaction */
        if (held >> d & 1)
          n->f[d] += given[1 + d];
        else
          n->f[d] = (n->f[d] + given[1 + d]) *
                    (Mass(patch, carrier, d) / (Mass(patch, carrier, d) + GivenMass(patch, carrier, given, d)));
      for (PetscInt c = 0; c < MPM_LIGHT_GIVEN; c++) given[c] = 0;
    }
}

/* Gives node the acceleration `a` [dim], as if its force had made it, and the velocity that follows; not along the axes
   `held` (bits). */
static void Accelerate(const MPMParams *par, MPMPatch *patch, PetscInt node, const PetscReal a[], int held)
{
  const PetscInt dim = patch->grid->dim;
  PetscReal     *v   = patch->motion + node * MPM_MOTION_NC(dim);

  for (PetscInt d = 0; d < dim; d++) {
    if (held >> d & 1) continue;
    v[d] += par->kick * (a[d] - v[dim + d]);
    v[dim + d]             = a[d];
    patch->node[node].f[d] = Mass(patch, node, d) * (a[d] - par->gravity[d]);
  }
}

void MPMLightMove(MPMLight *light, const MPMParams *par, MPMPatch *patch)
{
  const PetscInt dim = patch->grid->dim, nc = MPM_MOTION_NC(dim);
  PetscInt       ijk[3];

  for (PetscInt q = 0; q < light->n; q++) {
    const PetscInt node = light->node[q].node;
    PetscReal      a[3] = {0};
    int            held;

    for (int k = 0; k < Carriers(&light->node[q]); k++) {
      PetscReal      weight;
      const PetscInt carrier = Carrier(patch, &light->node[q], k, &weight);

      for (PetscInt d = 0; d < dim; d++) a[d] += weight * patch->motion[carrier * nc + dim + d];
    }
    Accelerate(par, patch, node, a, 0);
    held = Held(par, patch, node, ijk);
    if (held) (void)MPMWallsApply(par->walls->given, patch->grid, ijk, 0, patch->motion + node * nc);
    for (PetscInt d = 0; d < dim && IsOwn(patch, node); d++) /* its carriers have its force, and the wall its weight */
      if (held >> d & 1 && (patch->motion[node * nc + dim + d] == 0 || MPMNodeStopped(patch->value.met[node], d)))
        patch->node[node].f[d] = 0;
  }
  Collect(light, par, patch, PETSC_TRUE);
  for (PetscInt q = 0; q < light->n; q++)
    for (int k = 0; k < Carriers(&light->node[q]); k++) {
      PetscReal      weight, a[3];
      const PetscInt carrier = Carrier(patch, &light->node[q], k, &weight);
      PetscReal     *given   = Collected(light, patch, carrier);
      int            held;

      if (!given) continue;
      held = Held(par, patch, carrier, ijk);
      for (PetscInt d = 0; d < dim; d++) {
        const PetscReal now = patch->motion[carrier * nc + dim + d];

        a[d] = now;
        if (!(held >> d & 1))
          a[d] += (GivenMass(patch, carrier, given, d) * (now - par->gravity[d]) - given[1 + d]) /
                  Mass(patch, carrier, d);
      }
      Accelerate(par, patch, carrier, a, held);
      for (PetscInt c = 0; c < MPM_LIGHT_GIVEN; c++) given[c] = 0;
    }
}

PetscErrorCode MPMLightDestroy(MPMLight *light)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(light->node));
  PetscCall(PetscFree(light->held));
  PetscCall(PetscFree(light->mass));
  PetscCall(PetscFree(light->filled));
  PetscCall(PetscFree(light->given));
  light->n = light->room = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
