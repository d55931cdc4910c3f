/* xdmf.c - the file <scene>.xdmf, which lies beside the HDF5 file: a text by which ParaView, and the reader of VTK,
   open the snapshots. */
#include <errno.h>
#include "output/output.h"

static void XdmfArray(FILE *f, const char indent[], const char dims[], PetscBool whole, const char file[],
                      PetscInt step, const char path[])
{
  fprintf(f,
          "%s<DataItem Dimensions=\"%s\" NumberType=\"%s\" Precision=\"8\" Format=\"HDF\">%s:/step_%06" PetscInt_FMT
          "/%s</DataItem>\n",
          indent, dims, whole ? "Int" : "Float", file, step, path);
}

static void XdmfParticles(const MPMOutput *out, const MPMCore *core, FILE *f, const char file[], PetscInt k)
{
  const char *const types[] = {"", "Scalar", "", "Vector", "", "", "Tensor6", "", "", "Tensor"};
  const long long   n       = out->particles[k];
  char              dims[64], path[64];

  (void)core;
  fprintf(f, "      <Grid Name=\"particles\" GridType=\"Uniform\">\n        <Time Value=\"%.17g\"/>\n",
          (double)out->times[k]);
  fprintf(
      f,
      "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%lld\" NodesPerElement=\"1\"/>\n        <Geometry GeometryType=\"XYZ\">\n",
      n);
  (void)snprintf(dims, sizeof dims, "%lld 3", n);
  XdmfArray(f, "          ", dims, PETSC_FALSE, file, out->steps[k], "particles/x");
  fprintf(f, "        </Geometry>\n");
  for (PetscInt q = 0; q < MPM_NUM_DIAGNOSTICS; q++) {
    if (!(out->fields >> q & 1) || !strcmp(MPMDiagnostics[q].name, "x")) continue;
    if (MPMDiagnostics[q].nc == 1)
      (void)snprintf(dims, sizeof dims, "%lld", n);
    else
      (void)snprintf(dims, sizeof dims, "%lld %d", n, (int)MPMDiagnostics[q].nc);
    (void)snprintf(path, sizeof path, "particles/%s", MPMDiagnostics[q].name);
    fprintf(f, "        <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">\n", MPMDiagnostics[q].name,
            types[MPMDiagnostics[q].nc]);
    XdmfArray(f, "          ", dims, MPMDiagnostics[q].whole, file, out->steps[k], path);
    fprintf(f, "        </Attribute>\n");
  }
  fprintf(f, "      </Grid>\n");
}

static void XdmfNodes(const MPMOutput *out, const MPMCore *core, FILE *f, const char file[], PetscInt k)
{
  const MPMGrid *g = &core->grid;
  char           dims[128], vdims[160];

  (void)snprintf(dims, sizeof dims, "%lld %lld %lld", (long long)g->cells[2] + 1 - g->periodic[2],
                 (long long)g->cells[1] + 1 - g->periodic[1], (long long)g->cells[0] + 1 - g->periodic[0]);
  (void)snprintf(vdims, sizeof vdims, "%s 3", dims);
  fprintf(f, "      <Grid Name=\"grid\" GridType=\"Uniform\">\n        <Time Value=\"%.17g\"/>\n",
          (double)out->times[k]);
  fprintf(
      f,
      "        <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"%s\"/>\n        <Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n",
      dims);
  fprintf(
      f,
      "          <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">%.17g %.17g %.17g</DataItem>\n",
      (double)g->lower[2], (double)g->lower[1], (double)g->lower[0]);
  fprintf(
      f,
      "          <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">%.17g %.17g %.17g</DataItem>\n        </Geometry>\n",
      (double)g->h[2], (double)g->h[1], (double)g->h[0]);
  fprintf(f, "        <Attribute Name=\"mass\" AttributeType=\"Scalar\" Center=\"Node\">\n");
  XdmfArray(f, "          ", dims, PETSC_FALSE, file, out->steps[k], "grid/mass");
  fprintf(f, "        </Attribute>\n        <Attribute Name=\"v\" AttributeType=\"Vector\" Center=\"Node\">\n");
  XdmfArray(f, "          ", vdims, PETSC_FALSE, file, out->steps[k], "grid/v");
  fprintf(f, "        </Attribute>\n      </Grid>\n");
}

/* Writes <scene>.xdmf for the snapshots so far: to a new file, which is then renamed, so that <scene>.xdmf is complete
   at every moment. The first process writes; not collective. */
PetscErrorCode MPMXdmfWrite(const MPMOutput *out, const MPMCore *core, const MPMScene *scene)
{
  char        path[2 * MPM_TEXT_LEN], temporary[2 * MPM_TEXT_LEN + 8], file[MPM_NAME_LEN + 4];
  FILE       *f;
  PetscMPIInt rank;
  void (*const write[])(const MPMOutput *, const MPMCore *, FILE *, const char[], PetscInt) = {XdmfParticles,
                                                                                               XdmfNodes};
  const char *const names[]                                                                 = {"particles", "grid"};

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(path, sizeof path, "%s/%s.xdmf", out->dir, scene->name);
  (void)snprintf(temporary, sizeof temporary, "%s.new", path);
  (void)snprintf(file, sizeof file, "%s.h5", scene->name);
  f = fopen(temporary, "w");
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s", temporary, strerror(errno));
  fprintf(f, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n");
  for (int part = 0; part < (out->fields & MPM_OUTPUT_GRID ? 2 : 1); part++) {
    fprintf(f, "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", names[part]);
    for (PetscInt k = 0; k < out->count; k++) write[part](out, core, f, file, k);
    fprintf(f, "    </Grid>\n");
  }
  fprintf(f, "  </Domain>\n</Xdmf>\n");
  PetscCheck(!fclose(f) && !rename(temporary, path), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", path,
             strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}
