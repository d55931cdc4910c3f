/* sampled.c - samples the distance from faces on a lattice, and interpolates it. */
#include <stdlib.h>
#include "physics/sampled.h"

#define PAD  2   /* places of the lattice beyond the reach, for the interpolation */
#define NEAR 3.5 /* spacings: further from the faces every second place is enough, since the distance is smooth there */

static size_t Number(const MPMSampledDistance *s, const PetscInt k[])
{
  return ((size_t)k[0] * (size_t)s->n[1] + (size_t)k[1]) * (size_t)s->n[2] + (size_t)k[2];
}

/* Sets the distance at place k from the faces; *face: a guess, and then the nearest. */
static void Measure(MPMSampledDistance *s, const MPMNearest *faces, const PetscInt k[], PetscInt *face)
{
  PetscReal x[3], at[3], distance;

  for (PetscInt d = 0; d < 3; d++) x[d] = s->lower[d] + (PetscReal)k[d] * s->spacing[d];
  distance                  = MPMNearestPlace(faces, x, at, face);
  s->distance[Number(s, k)] = (float)(distance * s->sign(s->context, x, distance, *face < 0 ? NULL : at));
}

/* Interpolates the distance at place k from places with even numbers, by the cubic polynomials of MPMSampledAt. */
static PetscReal FromEven(const MPMSampledDistance *s, const PetscInt k[])
{
  static const PetscReal middle[4] = {-1 / 16., 9 / 16., 9 / 16., -1 / 16.};
  PetscReal              sum       = 0;

  for (PetscInt q = 0; q < 64; q++) {
    PetscInt  from[3], part = q;
    PetscReal w = 1;

    for (PetscInt d = 0; d < 3; d++, part /= 4) {
      from[d] = k[d];
      if (k[d] % 2) {
        from[d] = PetscClipInterval(k[d] + 2 * (part % 4) - 3, 0, s->n[d] - 1);
        w *= middle[part % 4];
      } else if (part % 4)
        w = 0;
    }
    if (w != 0) sum += w * (PetscReal)s->distance[Number(s, from)];
  }
  return sum;
}

MPMSampledDistance *MPMSampledCreate(const MPMNearest *faces, const PetscReal spacing[3], MPMSide sign,
                                     const void *context)
{
  MPMSampledDistance *s = calloc(1, sizeof *s);
  PetscInt            k[3], face = -1; /* that of the last place is a good guess for the next */
  PetscReal           near = 0;
  size_t              n    = 1;

  if (!s) return NULL;
  s->reach   = faces->reach;
  s->sign    = sign;
  s->context = context;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt beyond = (PetscInt)PetscCeilReal(s->reach / spacing[d]) + PAD;

    near          = PetscMax(near, NEAR * spacing[d]);
    s->spacing[d] = spacing[d];
    s->lower[d]   = faces->box[d] - (PetscReal)beyond * spacing[d];
    s->n[d] = ((PetscInt)PetscCeilReal((faces->box[3 + d] - faces->box[d]) / spacing[d]) / 2 + beyond + 1) * 2 + 1;
    n *= (size_t)s->n[d];
  }
  s->distance = malloc(n * sizeof *s->distance);
  if (!s->distance) {
    MPMSampledDestroy(&s);
    return NULL;
  }
  for (PetscInt even = 1; even >= 0; even--)
    for (k[0] = 0; k[0] < s->n[0]; k[0] += 1 + even)
      for (k[1] = 0; k[1] < s->n[1]; k[1] += 1 + even)
        for (k[2] = 0; k[2] < s->n[2]; k[2] += 1 + even) {
          PetscReal far;

          if (!even && !(k[0] % 2 || k[1] % 2 || k[2] % 2)) continue;
          far = even ? 0 : FromEven(s, k);
          if (PetscAbsReal(far) > near)
            s->distance[Number(s, k)] = (float)PetscClipInterval(far, -s->reach, s->reach);
          else
            Measure(s, faces, k, &face);
        }
  return s;
}

void MPMSampledDestroy(MPMSampledDistance **s)
{
  if (!*s) return;
  free((*s)->distance);
  free(*s);
  *s = NULL;
}

PetscReal MPMSampledAt(const MPMSampledDistance *s, const PetscReal x[], PetscReal n[])
{
  PetscReal w[3][4], g[3][4], value = 0, slope[3] = {0}, size = 0;
  PetscInt  base[3];
  PetscBool beyond = PETSC_FALSE;

  for (PetscInt d = 0; d < 3; d++) {
    const PetscReal at = (x[d] - s->lower[d]) / s->spacing[d], k = PetscFloorReal(at), t = at - k;

    if (!(at >= 1 && at < (PetscReal)(s->n[d] - 2))) beyond = PETSC_TRUE;
    if (beyond) break;
    base[d] = (PetscInt)k - 1;
    w[d][0] = 0.5 * t * (-1 + t * (2 - t));
    w[d][1] = 1 + 0.5 * t * t * (-5 + 3 * t);
    w[d][2] = 0.5 * t * (1 + t * (4 - 3 * t));
    w[d][3] = 0.5 * t * t * (t - 1);
    g[d][0] = 0.5 * (-1 + t * (4 - 3 * t)) / s->spacing[d];
    g[d][1] = 0.5 * t * (-10 + 9 * t) / s->spacing[d];
    g[d][2] = 0.5 * (1 + t * (8 - 9 * t)) / s->spacing[d];
    g[d][3] = 0.5 * t * (3 * t - 2) / s->spacing[d];
  }
  for (PetscInt i = 0; i < 4 && !beyond; i++)
    for (PetscInt j = 0; j < 4; j++) {
      const float *row = s->distance + Number(s, (const PetscInt[]){base[0] + i, base[1] + j, base[2]});
      PetscReal    sum = 0, along = 0;

      for (PetscInt k = 0; k < 4; k++) {
        sum += w[2][k] * (PetscReal)row[k];
        along += g[2][k] * (PetscReal)row[k];
      }
      value += w[0][i] * w[1][j] * sum;
      slope[0] += g[0][i] * w[1][j] * sum;
      slope[1] += w[0][i] * g[1][j] * sum;
      slope[2] += w[0][i] * w[1][j] * along;
    }
  if (beyond) {
    value = s->reach;
    for (PetscInt d = 0; d < 3; d++) slope[d] = x[d] - s->lower[d] - 0.5 * (PetscReal)(s->n[d] - 1) * s->spacing[d];
  }
  for (PetscInt d = 0; d < 3; d++) size += slope[d] * slope[d];
  size = PetscSqrtReal(size);
  for (PetscInt d = 0; d < 3; d++) n[d] = size > 0 ? slope[d] / size : d == 0;
  return PetscClipInterval(value, -s->reach, s->reach);
}
