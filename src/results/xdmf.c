/* xdmf.c - the files <name>.xdmf of the particles, .grid.xdmf of the nodes and .rigid.xdmf of the surfaces of rigid
   bodies, which lie beside the folder of the snapshots: texts by which ParaView (its readers Xdmf3 and Xdmf2), VTK and
   meshio open them. Each is a file of its own, since the readers Xdmf3 neither name the parts of a file nor let one
   choose among them. Each particle is a vertex of its own, of which the first reader draws nothing else; the numbers of
   the vertices are the ids, or the dataset `row` if particles were removed. The surfaces are edges or triangles. */
#include <errno.h>
#include <unistd.h>
#include "results/rigid_faces.h"

/* Writes snapshot k of what a file shows, whose data are in the HDF5 file `file`. */
typedef struct {
  const char *name, *end;
  void (*write)(const MPMOutput *, const MPMCore *, PetscInt64 started, FILE *, const char file[], PetscInt k);
} Part;

static void XdmfArray(FILE *f, const char indent[], const char dims[], PetscBool whole, const char file[],
                      PetscInt step, const char path[])
{
  fprintf(f,
          "%s<DataItem Dimensions=\"%s\" NumberType=\"%s\" Precision=\"8\" Format=\"HDF\">%s:/step_%06" PetscInt_FMT
          "/%s</DataItem>\n",
          indent, dims, whole ? "Int" : "Float", file, step, path);
}

static void XdmfParticles(const MPMOutput *out, const MPMCore *core, PetscInt64 started, FILE *f, const char file[],
                          PetscInt k)
{
  const char *const types[] = {"", "Scalar", "", "Vector", "", "", "", "", "", "Tensor"};
  const long long   n       = out->n[k];
  char              dims[64], path[64];

  (void)core;
  fprintf(f, "      <Grid Name=\"particles\" GridType=\"Uniform\">\n        <Time Value=\"%.17g\"/>\n",
          (double)out->times[k]);
  fprintf(f, "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%lld\" NodesPerElement=\"1\">\n", n);
  (void)snprintf(dims, sizeof dims, "%lld", n);
  XdmfArray(f, "          ", dims, PETSC_TRUE, file, out->steps[k], n < started ? "particles/row" : "particles/id");
  fprintf(f, "        </Topology>\n        <Geometry GeometryType=\"XYZ\">\n");
  (void)snprintf(dims, sizeof dims, "%lld 3", n);
  XdmfArray(f, "          ", dims, PETSC_FALSE, file, out->steps[k], "particles/x");
  fprintf(f, "        </Geometry>\n");
  for (PetscInt q = 0; q < MPM_NUM_DIAGNOSTICS; q++) {
    if (!(out->fields >> q & 1)) continue;
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

static void XdmfNodes(const MPMOutput *out, const MPMCore *core, PetscInt64 started, FILE *f, const char file[],
                      PetscInt k)
{
  const MPMGrid *g = &core->grid;
  char           dims[128], wides[160], path[MPM_NAME_LEN];

  (void)snprintf(dims, sizeof dims, "%lld %lld %lld", (long long)g->cells[2] + 1 - g->periodic[2],
                 (long long)g->cells[1] + 1 - g->periodic[1], (long long)g->cells[0] + 1 - g->periodic[0]);
  (void)started;
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
  for (const MPMNodeGroup *q = MPMNodeGroups; q->name; q++) {
    const PetscInt    wide    = q->components(3);
    const char *const types[] = {[1] = "Scalar", [3] = "Vector", [6] = "Tensor6"};

    if (!q->dataset[0]) continue;
    (void)snprintf(path, sizeof path, "grid/%s", q->dataset);
    (void)snprintf(wides, sizeof wides, wide > 1 ? "%s %d" : "%s", dims, (int)wide);
    fprintf(f, "        <Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">\n", q->dataset, types[wide]);
    XdmfArray(f, "          ", wides, PETSC_FALSE, file, out->steps[k], path);
    fprintf(f, "        </Attribute>\n");
  }
  fprintf(f, "      </Grid>\n");
}

static void XdmfRigids(const MPMOutput *out, const MPMCore *core, PetscInt64 started, FILE *f, const char file[],
                       PetscInt k)
{
  const int       dim     = (int)core->grid.dim;
  const long long n       = out->faces.n;
  const char     *types[] = {"", "Polyvertex", "Polyline", "Triangle"};
  char            dims[64];

  (void)started;
  fprintf(f, "      <Grid Name=\"rigid\" GridType=\"Uniform\">\n        <Time Value=\"%.17g\"/>\n",
          (double)out->times[k]);
  fprintf(f, "        <Topology TopologyType=\"%s\" NumberOfElements=\"%lld\" NodesPerElement=\"%d\">\n", types[dim], n,
          dim);
  (void)snprintf(dims, sizeof dims, "%lld %d", n, dim);
  XdmfArray(f, "          ", dims, PETSC_TRUE, file, out->steps[k], "rigid/faces");
  fprintf(f, "        </Topology>\n        <Geometry GeometryType=\"XYZ\">\n");
  (void)snprintf(dims, sizeof dims, "%lld 3", n * dim);
  XdmfArray(f, "          ", dims, PETSC_FALSE, file, out->steps[k], "rigid/x");
  fprintf(f, "        </Geometry>\n        <Attribute Name=\"body\" AttributeType=\"Scalar\" Center=\"Cell\">\n");
  (void)snprintf(dims, sizeof dims, "%lld", n);
  XdmfArray(f, "          ", dims, PETSC_TRUE, file, out->steps[k], "rigid/body");
  fprintf(f, "        </Attribute>\n      </Grid>\n");
}

/* Writes one of the files, unless this run has no such part; returns whether that was possible. */
static PetscBool WriteFile(const Part *part, const MPMOutput *out, const MPMCore *core, const MPMScene *scene,
                           char path[2 * MPM_TEXT_LEN])
{
  char      fresh[2 * MPM_TEXT_LEN + 16], file[2 * MPM_TEXT_LEN];
  FILE     *f;
  PetscBool good;

  (void)snprintf(path, 2 * MPM_TEXT_LEN, "%s/%s%s", out->dir, scene->name, part->end);
  (void)snprintf(fresh, sizeof fresh, "%s" MPM_NEW_FILE, path);
  (void)unlink(fresh); /* one that an earlier run left; a link is not followed */
  f = fopen(fresh, "wx");
  if (!f) return PETSC_FALSE;
  fprintf(f, "<?xml version=\"1.0\"?>\n<!-- pebble " MPM_VERSION " -->\n<Xdmf Version=\"3.0\">\n  <Domain>\n");
  fprintf(f, "    <Grid Name=\"%s\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", part->name);
  for (PetscInt k = 0; k < out->count; k++) {
    MPMSnapshotPath(out, scene, out->steps[k], PETSC_TRUE, file);
    part->write(out, core, MPMSceneStarted(scene), f, file, k);
  }
  fprintf(f, "    </Grid>\n  </Domain>\n</Xdmf>\n");
  good = !fflush(f) && !ferror(f);
  if (fclose(f)) good = PETSC_FALSE;
  if (good && !rename(fresh, path)) return PETSC_TRUE;
  (void)unlink(fresh);
  return PETSC_FALSE;
}

PetscErrorCode MPMXdmfWrite(MPMOutput *out, const MPMCore *core, const MPMScene *scene, char fault[MPM_TEXT_LEN])
{
  const Part parts[] = {
      {"grid", ".grid.xdmf", XdmfNodes}, {"rigid", ".rigid.xdmf", XdmfRigids}, {"particles", ".xdmf", XdmfParticles}};
  const PetscBool there[] = {(out->fields & MPM_OUTPUT_GRID) != 0, core->rigids.n ? PETSC_TRUE : PETSC_FALSE,
                             PETSC_TRUE};
  char            path[2 * MPM_TEXT_LEN];
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  fault[0] = 0;
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMRigidFacesMake(out, core));
  for (int k = 0; k < 3 && !fault[0]; k++)
    if (there[k] && !WriteFile(&parts[k], out, core, scene, path))
      (void)snprintf(fault, MPM_TEXT_LEN, "cannot write %.1500s: %s", path, strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}
