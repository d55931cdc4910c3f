/* unit_light.c - light nodes: which nodes are light, that all others keep their motion, and that an advance with light
   nodes keeps momentum, angular momentum and a uniform acceleration, whatever masses and forces nodes have. And the
   layers in which loads act: what they give is the load on the surface, for every number of layers. */
#include "kernels/light.h"
#include "physics/skin.h"
#include "physics/wall.h"
#include "unit.h"

enum { MOST = 12, DIM = 3 };
static MPMNode   nodes[MOST * MOST * MOST], before[MOST * MOST * MOST];
static PetscReal motion[MOST * MOST * MOST * MPM_MOTION_NC(DIM)];
static PetscReal met[MOST * MOST * MOST];
static MPMSpan   spans[MOST * MOST];
static MPMWalls  walls; /* all faces are free */
static MPMGrid   grid;
static long      found; /* light nodes */

/* A patch that is the whole grid. */
static MPMPatch Patch(int dim)
{
  MPMPatch patch = {
      .grid = &grid, .node = nodes, .motion = motion, .value = {.met = met}, .span = spans, .tiles = {.lines = 1}};

  grid.dim = dim;
  for (int d = 0; d < 3; d++) {
    patch.n[d] = patch.own_n[d] = d < dim ? MOST : 1;
    grid.cells[d]               = MOST - 1;
  }
  for (int r = 0; r < MOST * MOST; r++) spans[r] = (MPMSpan){0, MOST, PETSC_FALSE};
  return patch;
}

static PetscInt Total(const MPMPatch *p)
{
  return p->n[0] * p->n[1] * p->n[2];
}

static void Where(const MPMPatch *p, PetscInt node, PetscReal x[3])
{
  x[0] = (PetscReal)(node % p->n[0]);
  x[1] = (PetscReal)(node / p->n[0] % p->n[1]);
  x[2] = (PetscReal)(node / p->n[0] / p->n[1]);
}

/* Masses of a body whose edges lie anywhere in the cells: the products of a profile along each axis, or random ones. */
static void Masses(const MPMPatch *p, PetscBool smooth)
{
  PetscReal profile[3][MOST];

  for (int d = 0; d < 3; d++)
    for (int i = 0; i < MOST; i++) {
      const PetscInt edge = PetscMin(i - 2, MOST - 3 - i);

      profile[d][i] = d >= grid.dim ? 1 : edge < 0 ? 0 : edge > 1 ? 1 : PetscPowReal(10, UnitReal(edge ? -1 : -6, 0));
    }
  for (PetscInt q = 0; q < Total(p); q++) {
    PetscReal x[3], m = 1;

    Where(p, q, x);
    for (int d = 0; d < 3; d++) m *= profile[d][(int)x[d]];
    if (!smooth) m = UnitInt(3) ? PetscPowReal(10, UnitReal(-5, 0)) : 0;
    nodes[q].m = m;
  }
}

/* The advance as step/nodes.c makes it, with no walls. */
static void Advance(const MPMPatch *p, const MPMParams *par)
{
  for (PetscInt q = 0; q < Total(p); q++)
    for (int d = 0; d < grid.dim; d++) {
      PetscReal *v = motion + q * MPM_MOTION_NC(grid.dim) + d, *a = v + grid.dim;

      *v = nodes[q].m > 0 ? nodes[q].p[d] / nodes[q].m : 0;
      *a = nodes[q].m > 0 ? nodes[q].f[d] / nodes[q].m + par->gravity[d] : 0;
      *v += par->kick * *a;
    }
}

/* Sets P to sum m a, and T to sum x x m a, or those of the forces: [3]; returns the sum of their sizes. */
static PetscReal Sums(const MPMPatch *p, const MPMParams *par, PetscBool forces, PetscReal P[3], PetscReal T[3])
{
  PetscReal size = 0;

  for (int d = 0; d < 3; d++) P[d] = T[d] = 0;
  for (PetscInt q = 0; q < Total(p); q++) {
    PetscReal x[3], f[3] = {0};

    Where(p, q, x);
    for (int d = 0; d < grid.dim; d++)
      f[d] = forces ? before[q].f[d] + before[q].m * par->gravity[d]
                    : before[q].m * motion[q * MPM_MOTION_NC(grid.dim) + grid.dim + d];
    for (int d = 0; d < 3; d++) {
      P[d] += f[d];
      T[d] += x[(d + 1) % 3] * f[(d + 2) % 3] - x[(d + 2) % 3] * f[(d + 1) % 3];
      size += MOST * fabs(f[d]);
    }
  }
  return size;
}

static PetscErrorCode Check(int dim, PetscBool smooth, PetscBool uniform)
{
  MPMPatch         patch = Patch(dim);
  MPMLight         light = {0};
  const MPMParams  par   = {.light = 0.1, .kick = UnitReal(0.1, 2), .gravity = {UnitReal(-9, 9)}, .walls = &walls};
  static PetscReal plain[MOST * MOST * MOST * MPM_MOTION_NC(DIM)];
  const PetscReal  A[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)};
  PetscReal        P[2][3], T[2][3], size;
  char             moved[MOST * MOST * MOST] = {0};

  PetscFunctionBeginUser;
  Masses(&patch, smooth);
  for (PetscInt q = 0; q < Total(&patch); q++)
    for (int d = 0; d < dim; d++) {
      nodes[q].p[d] = nodes[q].m * UnitReal(-1, 1);
      nodes[q].f[d] = uniform          ? nodes[q].m * (A[d] - par.gravity[d])
                      : nodes[q].m > 0 ? UnitReal(-1, 1) * PetscSqrtReal(nodes[q].m)
                                       : 0;
    }
  memcpy(before, nodes, sizeof nodes);
  Advance(&patch, &par);
  memcpy(plain, motion, sizeof motion);
  PetscCall(MPMLightMass(&light, &patch));
  PetscCall(MPMLightFind(&light, &par, &patch));
  UnitContext("%d-D, %s masses, %s forces, %d light nodes", dim, smooth ? "smooth" : "random",
              uniform ? "uniform" : "random", (int)light.n);
  MPMLightGive(&light, &par, &patch);
  Advance(&patch, &par);
  MPMLightMove(&light, &par, &patch);
  for (PetscInt q = 0; q < light.n; q++) { /* a light node has a neighbour of more than 1/0.1 of its mass */
    const PetscInt i = light.node[q].node, step[3] = {1, patch.n[0], patch.n[0] * patch.n[1]};

    moved[i] = 1;
    for (int c = 0; c < 27; c++) /* all that can be its carriers */
      if (light.node[q].side[0] || light.node[q].side[1] || light.node[q].side[2])
        moved[i + (c % 3) * light.node[q].side[0] * step[0] + c / 3 % 3 * light.node[q].side[1] * step[1] +
              c / 9 * light.node[q].side[2] * step[2]] = 1;
    for (int d = 0; d < dim; d++)
      if (light.node[q].side[d]) CHECK(before[i].m < 0.1 * before[i + light.node[q].side[d] * step[d]].m);
  }
  for (PetscInt q = 0; q < Total(&patch); q++)
    for (int c = 0; c < MPM_MOTION_NC(dim); c++) {
      const PetscReal now = motion[q * MPM_MOTION_NC(dim) + c], was = plain[q * MPM_MOTION_NC(dim) + c];

      if (!moved[q]) CHECK_EQ(now, was);
      if (uniform) CHECK_NEAR(now, was, 1e-12 * (1 + fabs(was)));
    }
  size = Sums(&patch, &par, PETSC_TRUE, P[0], T[0]);
  (void)Sums(&patch, &par, PETSC_FALSE, P[1], T[1]);
  for (int d = 0; d < 3; d++) {
    CHECK_NEAR(P[1][d], P[0][d], 1e-13 * size);
    CHECK_NEAR(T[1][d], T[0][d], 1e-13 * size);
  }
  found += light.n;
  PetscCall(MPMLightDestroy(&light));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The falls of w add up to 1, and w at a place is what they leave of it: so a uniform stress is in balance with its
   load. */
static void CheckSkin(PetscInt layers, PetscInt whole)
{
  PetscReal w = 1, fall;

  UnitContext("%d layers, %d of them whole", (int)layers, (int)whole);
  for (PetscInt layer = 0; layer < layers; layer++) {
    const PetscReal share = MPMSkinShare(MPMSkinPack(layer, layers, 5, 1), whole, &fall);

    CHECK_NEAR(share, w - fall / 2, 1e-15);
    CHECK(fall >= 0 && share >= 0 && share <= 1);
    w -= fall;
  }
  CHECK_NEAR(w, 0, 1e-15);
  CHECK_EQ(MPMSkinShare(0, whole, &fall), 0);
  CHECK_EQ(MPMSkinLayer(MPMSkinPack(3, layers, 5, 1)), 3);
  CHECK_EQ(MPMSkinSides(MPMSkinPack(3, layers, 63, 0.7)), 63);
  CHECK(fabs(MPMSkinArea(MPMSkinPack(3, layers, 63, 0.7)) - 0.7) < 0.002);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  for (int round = 0; round < 40; round++)
    for (int dim = 1; dim <= 3; dim++)
      for (int kind = 0; kind < 4; kind++)
        PetscCall(Check(dim, kind & 1 ? PETSC_TRUE : PETSC_FALSE, kind & 2 ? PETSC_TRUE : PETSC_FALSE));
  CHECK(found > 1000);
  for (PetscInt layers = 1; layers < 40; layers++)
    for (PetscInt whole = 1; whole < 10; whole++) CheckSkin(layers, whole);
  PetscCall(PetscFinalize());
  return UnitEnd();
}
