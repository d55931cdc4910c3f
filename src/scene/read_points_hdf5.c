/* read_points_hdf5.c - reads particles from HDF5 files: the datasets x [n][dim], and if one likes v [n][dim],
   F [n][dim*dim] or [n][dim][dim], volume [n], and material [n], the number of a material in -materials, from 0. */
#include "scene/points.h"

#if defined(PETSC_HAVE_HDF5)
#include <hdf5.h>

/* The datasets, in the sequence of a particle's numbers. */
static const char *const names[] = {"x", "v", "F", "volume", "material"};

/* Returns how many numbers a particle has in a dataset. */
static PetscInt Width(PetscInt dim, int set)
{
  return set < 2 ? dim : set == 2 ? dim * dim : 1;
}

static hid_t Open(const char path[])
{
  hid_t file;

  H5E_BEGIN_TRY
  {
    file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  }
  H5E_END_TRY
  return file;
}

/* Reads rows first .. first+n-1 of a dataset, `width` numbers each, or with n = -1 only finds how many there are. Says
   in why [len] what is wrong with it. *all stays if there is no such dataset. */
static void ReadSet(hid_t file, const char name[], PetscInt width, PetscInt64 first, PetscInt n, double *at,
                    PetscInt64 *all, char why[], size_t len)
{
  hid_t   set = -1, space = -1, memory = -1;
  hsize_t size[4] = {0}, start[4] = {0}, each = 1;
  int     axes;

  H5E_BEGIN_TRY
  {
    set = H5Lexists(file, name, H5P_DEFAULT) > 0 ? H5Dopen2(file, name, H5P_DEFAULT) : -1;
  }
  H5E_END_TRY
  if (set < 0) return;
  space = H5Dget_space(set);
  axes  = H5Sget_simple_extent_ndims(space);
  if (axes >= 1 && axes <= 3) (void)H5Sget_simple_extent_dims(space, size, NULL);
  for (int d = 1; d < axes && axes <= 3; d++) each *= size[d];
  if (axes < 1 || axes > 3 || each != (hsize_t)width) {
    (void)snprintf(why, len, "dataset %s has not %" PetscInt_FMT " number%s a particle", name, width,
                   width == 1 ? "" : "s");
  } else if (n >= 0) {
    const hsize_t numbers = (hsize_t)n * each;
    herr_t        error   = -1;

    start[0] = (hsize_t)first;
    size[0]  = (hsize_t)n;
    memory   = H5Screate_simple(1, &numbers, NULL);
    H5E_BEGIN_TRY
    {
      if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, size, NULL) >= 0)
        error = n ? H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, at) : 0;
    }
    H5E_END_TRY
    if (error < 0) (void)snprintf(why, len, "dataset %s cannot be read as numbers", name);
  } else
    *all = (PetscInt64)size[0];
  if (memory >= 0) (void)H5Sclose(memory);
  (void)H5Sclose(space);
  (void)H5Dclose(set);
}

PetscErrorCode MPMPointsOpenHDF5(MPMOptions o, MPMPoints *p)
{
  const hid_t file     = Open(p->path);
  char        why[128] = "";
  PetscBool  *has[5]   = {NULL, &p->velocity, &p->deformation, &p->volume, &p->material};
  PetscInt64  all[5]   = {-1, -1, -1, -1, -1};

  PetscFunctionBeginUser;
  p->hdf5 = PETSC_TRUE;
  if (file < 0) MPMOptionsFail(o, "%.600s: it is damaged", p->what);
  for (int s = 0; s < 5 && file >= 0; s++) {
    ReadSet(file, names[s], Width(p->dim, s), 0, -1, NULL, &all[s], why, sizeof why);
    if (!s && all[s] < 0 && !why[0]) (void)snprintf(why, sizeof why, "it has no dataset x");
    if (all[s] >= 0 && all[s] != all[0])
      (void)snprintf(why, sizeof why, "x has %" PetscInt64_FMT " rows, %s %" PetscInt64_FMT, all[0], names[s], all[s]);
    if (s) *has[s] = all[s] >= 0;
    if (why[0]) MPMOptionsFail(o, "%.600s: %s", p->what, why);
  }
  p->all = all[0];
  if (file >= 0) (void)H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsReadHDF5(const MPMPoints *p, MPMPointRows *rows, char why[], size_t len)
{
  const hid_t     file   = Open(p->path);
  const PetscBool has[5] = {PETSC_TRUE, p->velocity, p->deformation, p->volume, p->material};
  double         *at;
  PetscInt64      all;

  PetscFunctionBeginUser;
  if (file < 0) (void)snprintf(why, len, "it cannot be read");
  PetscCall(PetscMalloc1(9 * (size_t)rows->n + 1, &at));
  for (PetscInt s = 0, place = 0; s < 5 && !why[0]; place += Width(p->dim, (int)s), s++) {
    const PetscInt width = Width(p->dim, (int)s);

    if (!has[s]) continue;
    ReadSet(file, names[s], width, rows->first, rows->n, at, &all, why, len);
    for (PetscInt k = 0; k < rows->n && !why[0]; k++)
      for (PetscInt j = 0; j < width; j++)
        if (s < 4)
          rows->number[k * rows->stride + place + j] = (PetscReal)at[k * width + j];
        else
          rows->material[k] = at[k] >= 0 && at[k] < 1e6 ? (PetscInt)at[k] : -1;
  }
  PetscCall(PetscFree(at));
  if (file >= 0) (void)H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMPointsOpenHDF5(MPMOptions o, MPMPoints *p)
{
  PetscFunctionBeginUser;
  MPMOptionsFail(o, "%.600s needs a PETSc with HDF5, and this one has none; write the particles as CSV", p->what);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsReadHDF5(const MPMPoints *p, MPMPointRows *rows, char why[], size_t len)
{
  (void)p;
  (void)rows;
  (void)why;
  (void)len;
  return PETSC_SUCCESS;
}

#endif
