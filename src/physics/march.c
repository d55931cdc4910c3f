/* march.c - marching simplices: the zeros of a function on the edges of a lattice, joined to a surface. The function is
   computed once at each place of the lattice; two layers of them are kept. */
#include <stdlib.h>
#include "physics/march.h"

#define HALVINGS 6

typedef struct {
  const MPMImplicit *of;
  PetscInt           n[3]; /* boxes of the lattice */
  PetscReal          s[3]; /* m */
  MPMFaces          *to;
  PetscBool          memory;
} March;

static void Place(const March *m, const PetscInt k[], PetscReal x[])
{
  for (PetscInt d = 0; d < m->of->dim; d++) x[d] = m->of->lower[d] + (PetscReal)k[d] * m->s[d];
}

/* A value that is not a number is not positive. */
static PetscReal Value(const March *m, const PetscReal x[])
{
  const PetscReal f = m->of->f(m->of->context, m->of->dim, x);

  return PetscIsNanReal(f) ? -1 : f;
}

/* Sets at [dim] to the zero between the places a, where f > 0, and b of the lattice, by bisection, and by a line
   between the ends of the rest. */
static void Zero(const March *m, const PetscInt a[], const PetscInt b[], PetscReal fa, PetscReal fb, PetscReal at[])
{
  PetscReal x[3], y[3], middle[3], share;

  Place(m, a, x);
  Place(m, b, y);
  for (int k = 0; k < HALVINGS; k++) {
    PetscReal f;

    for (PetscInt d = 0; d < m->of->dim; d++) middle[d] = 0.5 * (x[d] + y[d]);
    f = Value(m, middle);
    if (f > 0) {
      fa = f;
      memcpy(x, middle, sizeof x);
    } else {
      fb = f;
      memcpy(y, middle, sizeof y);
    }
  }
  share = fa / (fa - fb);
  if (!(share >= 0 && share <= 1)) share = 0.5; /* not finite */
  for (PetscInt d = 0; d < m->of->dim; d++) at[d] = x[d] + share * (y[d] - x[d]);
}

static void Add(March *m, const PetscReal *const corner[])
{
  const PetscInt dim = m->of->dim;
  MPMFaces      *to  = m->to;

  if (to->n == to->room) {
    const PetscInt room = 2 * to->room + 256;
    PetscReal     *more = realloc(to->corner, (size_t)(room * dim * dim) * sizeof *more);

    if (!more) {
      m->memory = PETSC_FALSE;
      return;
    }
    to->corner = more;
    to->room   = room;
  }
  for (PetscInt k = 0; k < dim; k++)
    memcpy(to->corner + (to->n * dim + k) * dim, corner[k], (size_t)dim * sizeof **corner);
  to->n++;
}

/* Adds the faces of a simplex with the places k [dim + 1] of the lattice and the values f there: one between a corner
   and the others, or in 3-D two between two corners and two. */
static void Cut(March *m, PetscInt k[][3], const PetscReal f[])
{
  PetscInt  in[4], out[4], inner = 0, outer = 0;
  PetscReal at[4][3];

  for (PetscInt c = 0; c <= m->of->dim; c++)
    if (f[c] > 0)
      in[inner++] = c;
    else
      out[outer++] = c;
  for (PetscInt a = 0; a < inner; a++)
    for (PetscInt b = 0; b < outer; b++) Zero(m, k[in[a]], k[out[b]], f[in[a]], f[out[b]], at[a * outer + b]);
  if (!inner || !outer) return;
  if (inner * outer == 4) {
    Add(m, (const PetscReal *const[]){at[0], at[1], at[3]});
    Add(m, (const PetscReal *const[]){at[0], at[3], at[2]});
  } else
    Add(m, (const PetscReal *const[]){at[0], at[1], at[2]});
}

/* Goes through the simplices of the box at place k, whose corners have the values f [2][2][2], x fastest: from its
   first corner to its last along the axes, in each of their sequences. */
static void Box(March *m, const PetscInt k[], const PetscReal f[])
{
  static const PetscInt axes[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 0, 1}, {1, 2, 0}, {2, 1, 0}};
  const PetscInt        dim = m->of->dim, simplices = dim == 3 ? 6 : dim;

  for (PetscInt q = 0; q < simplices; q++) {
    PetscInt  at[4][3] = {{k[0], k[1], k[2]}}, corner = 0;
    PetscReal value[4] = {f[0]};

    for (PetscInt c = 1; c <= dim; c++) {
      const PetscInt axis = axes[q][c - 1];

      memcpy(at[c], at[c - 1], sizeof at[c]);
      at[c][axis]++;
      corner += 1 << axis;
      value[c] = f[corner];
    }
    Cut(m, at, value);
  }
}

PetscBool MPMMarch(const MPMImplicit *of, MPMFaces *to)
{
  const PetscInt dim       = of->dim;
  March          m         = {.of = of, .n = {1, 1, 1}, .to = to, .memory = PETSC_TRUE};
  PetscInt       places[3] = {1, 1, 1}, layers;
  PetscReal     *layer[2], *all;

  for (PetscInt d = 0; d < dim; d++) {
    m.n[d]    = PetscMax(1, (PetscInt)PetscCeilReal((of->upper[d] - of->lower[d]) / of->spacing[d] - 1e-6));
    m.s[d]    = (of->upper[d] - of->lower[d]) / (PetscReal)m.n[d];
    places[d] = m.n[d] + 1;
  }
  layers = places[2];
  all    = malloc(2 * (size_t)(places[0] * places[1]) * sizeof *all);
  if (!all) return PETSC_FALSE;
  layer[0] = all;
  layer[1] = all + places[0] * places[1];
  for (PetscInt z = 0; z < layers && m.memory; z++) {
    PetscReal *const upper = layer[z % 2], *const lower = layer[dim == 3 ? 1 - z % 2 : z % 2];

    for (PetscInt y = 0; y < places[1]; y++)
      for (PetscInt x = 0; x < places[0]; x++) {
        PetscReal at[3];

        Place(&m, (const PetscInt[]){x, y, z}, at);
        upper[y * places[0] + x] = Value(&m, at);
      }
    for (PetscInt y = 0; y < m.n[1] && (dim < 3 || z); y++)
      for (PetscInt x = 0; x < m.n[0]; x++) {
        PetscReal f[8];
        PetscInt  positive = 0;

        for (PetscInt c = 0; c < 1 << dim; c++) {
          f[c] = (c & 4 ? upper : lower)[(y + (c >> 1 & 1)) * places[0] + x + (c & 1)];
          positive += f[c] > 0;
        }
        if (positive > 0 && positive < 1 << dim) Box(&m, (const PetscInt[]){x, y, dim == 3 ? z - 1 : 0}, f);
      }
  }
  free(all);
  return m.memory;
}
