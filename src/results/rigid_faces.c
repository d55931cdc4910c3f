/* rigid_faces.c - rigid bodies in snapshots: the surface of each, which is sampled once, where it is at that time.

   /step_000123/rigid     attribute names: of the bodies, with commas between them
     place turn           [n][3] where the pivot is, [n][9] a rotation: of each body
     x                    [corners][3]
     faces                [faces][dim] the corners of each face; edges in 2-D, triangles in 3-D
     body                 [faces] the number of its body, from 0 on */
#include <stdlib.h>
#include "results/rigid_faces.h"

PetscErrorCode MPMRigidFacesMake(MPMOutput *out, const MPMCore *core)
{
  const MPMRigids *r = &core->rigids;

  PetscFunctionBeginUser;
  if (!r->n || out->first) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(r->n + 1, &out->first));
  for (PetscInt b = 0; b < r->n; b++) {
    PetscCheck(MPMRegionOutline(r->body[b].shape, &core->grid, &out->faces), PETSC_COMM_SELF, PETSC_ERR_MEM,
               "no memory for the surface of %s", r->body[b].name);
    out->first[b + 1] = out->faces.n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRigidFacesDestroy(MPMOutput *out)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(out->first));
  free(out->faces.corner);
  out->faces = (MPMFaces){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

#if defined(PETSC_HAVE_HDF5)

PetscErrorCode MPMRigidDatasets(const MPMOutput *out, const MPMCore *core, MPMFile *file, hid_t step)
{
  const MPMRigids *r   = &core->rigids;
  const hsize_t    dim = (hsize_t)core->grid.dim, faces = (hsize_t)out->faces.n, bodies = (hsize_t)r->n;
  hid_t            group               = -1;
  char             names[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  if (step >= 0) H5(group = H5Gcreate2(step, "rigid", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  for (PetscInt b = 0; b < r->n; b++) MPMAppend(names, sizeof names, "%s%s", b ? "," : "", r->body[b].name);
  PetscCall(MPMHDF5Text(group, "names", names));
  PetscCall(MPMFileDataset(file, group, "place", "m", "x y z", PETSC_FALSE, 2, (const hsize_t[]){bodies, 3}));
  PetscCall(MPMFileDataset(file, group, "turn", "1", "xx xy xz yx yy yz zx zy zz", PETSC_FALSE, 2,
                           (const hsize_t[]){bodies, 9}));
  PetscCall(MPMFileDataset(file, group, "x", "m", "x y z", PETSC_FALSE, 2, (const hsize_t[]){faces * dim, 3}));
  PetscCall(MPMFileDataset(file, group, "faces", "1", "", PETSC_TRUE, 2, (const hsize_t[]){faces, dim}));
  PetscCall(MPMFileDataset(file, group, "body", "1", "", PETSC_TRUE, 1, (const hsize_t[]){faces}));
  if (group >= 0) H5(H5Gclose(group));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets x [3] to where the place X [dim] of a body's shape is. */
static void Moved(const MPMRigid *r, PetscInt dim, const PetscReal X[], PetscReal x[])
{
  for (PetscInt d = 0; d < 3; d++) x[d] = 0;
  for (PetscInt d = 0; d < dim; d++) {
    x[d] = r->pivot[d] + r->place[d];
    for (PetscInt e = 0; e < dim; e++) x[d] += r->turn[3 * d + e] * (X[e] - r->pivot[e]);
  }
}

PetscErrorCode MPMRigidWrite(const MPMOutput *out, const MPMCore *core, MPMFile *file, PetscInt *set)
{
  const MPMRigids *r   = &core->rigids;
  const PetscInt   dim = core->grid.dim, corners = out->faces.n * dim;
  PetscReal       *value;

  PetscFunctionBeginUser;
  if (file->rank) {
    *set += 5;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(PetscMax(3 * corners, 9 * r->n), &value));
  for (PetscInt b = 0; b < r->n; b++) {
    for (PetscInt d = 0; d < 3; d++) value[3 * b + d] = 0;
    for (PetscInt d = 0; d < dim; d++) value[3 * b + d] = r->body[b].pivot[d] + r->body[b].place[d];
  }
  PetscCall(MPMFileWrite(file, (*set)++, 0, 3 * r->n, value));
  for (PetscInt b = 0; b < r->n; b++)
    for (PetscInt k = 0; k < 9; k++) value[9 * b + k] = r->body[b].turn[k];
  PetscCall(MPMFileWrite(file, (*set)++, 0, 9 * r->n, value));
  for (PetscInt b = 0; b < r->n; b++)
    for (PetscInt k = out->first[b] * dim; k < out->first[b + 1] * dim; k++)
      Moved(&r->body[b], dim, out->faces.corner + (r->body[b].gone ? out->first[b] * dim : k) * dim, value + 3 * k);
  PetscCall(MPMFileWrite(file, (*set)++, 0, 3 * corners, value));
  for (PetscInt k = 0; k < corners; k++) value[k] = (PetscReal)k;
  PetscCall(MPMFileWrite(file, (*set)++, 0, corners, value));
  for (PetscInt b = 0; b < r->n; b++)
    for (PetscInt k = out->first[b]; k < out->first[b + 1]; k++) value[k] = (PetscReal)b;
  PetscCall(MPMFileWrite(file, (*set)++, 0, out->faces.n, value));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif
