/* snapshot.c - snapshots, which are written between steps: each is an HDF5 file <name>.snapshots/step_000123.h5.

   /                      attributes: provenance and the grid
   /step_000123           attributes time, step, dt, digest
     particles/id x ...   [N] or [N][nc], one row per particle, sorted by id on every number of processes
     rigid/x faces ...    the surfaces of rigid bodies, if there are any (rigid_faces.c)
     grid/mass v ...      [nz][ny][nx] and [nz][ny][nx][3], nodes sorted by coordinates; kernels/node.def names them
   Vectors have 3 components and tensors 9 in every dimension. A file has its name when it is complete. index.c joins
   the snapshots in one file, and xdmf.c writes the texts by which ParaView opens them. With a PETSc that has no HDF5,
   options that ask for snapshots are refused. */
#include "results/hdf5.h"
#include "results/output.h"
#include "results/provenance.h"
#include "results/rigid_faces.h"
#include "results/rows.h"

/* Lists the words of -output_fields. */
static void ListWords(char text[MPM_TEXT_LEN])
{
  text[0] = 0;
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    if (MPMDiagnostics[f].word[0]) MPMAppend(text, MPM_TEXT_LEN, "%s,", MPMDiagnostics[f].word);
  MPMAppend(text, MPM_TEXT_LEN, "grid");
}

/* Reads -output_fields a,b,...: words of diagnostics.def, and grid. *set says whether it was given. */
static PetscErrorCode ReadFields(MPMOutput *out, const MPMScene *scene, MPMOptions o, PetscBool *set)
{
  char      text[MPM_TEXT_LEN] = "", list[MPM_TEXT_LEN], *save = NULL;
  PetscInt  has = 0, asked = 0; /* fields that a material of the scene carries, or would if they were asked for */
  PetscBool all;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    has |= scene->materials[k].state;
    asked |= MPMMaterialAsked(&scene->materials[k]);
  }
  PetscCall(MPMOptionsString(o, "output_fields", NULL, text, set));
  all         = !*set || !strcmp(text, "all");
  out->fields = all ? MPM_OUTPUT_GRID : 0;
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    if (MPMDiagnosticIsField(f, has) &&
        (!MPMDiagnostics[f].word[0] || (all && !(MPMDiagnostics[f].uses & MPM_SHOW_ASKED))))
      out->fields |= (PetscInt64)1 << f;
  if (all) PetscFunctionReturn(PETSC_SUCCESS);
  for (char *w = strtok_r(text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    PetscInt f = 0;

    while (f < MPM_NUM_DIAGNOSTICS && strcmp(MPMDiagnostics[f].word, w)) f++;
    ListWords(list);
    if (f == MPM_NUM_DIAGNOSTICS && strcmp(w, "grid"))
      MPMOptionsFail(o, "-output_fields %s: choose among all, or a list of %s", w, list);
    if (f < MPM_NUM_DIAGNOSTICS && !MPMDiagnosticIsField(f, has | asked))
      MPMOptionsFail(o, "-output_fields %s: no material of this scene has it", w);
    out->fields |= f < MPM_NUM_DIAGNOSTICS ? (PetscInt64)1 << f : MPM_OUTPUT_GRID;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options of snapshots; the first fault is left in o. Not collective. */
PetscErrorCode MPMOutputSetFromOptions(MPMOutput *out, const MPMScene *scene, PetscReal time_end, MPMOptions o)
{
  char      format[MPM_NAME_LEN];
  PetscBool set, replace = PETSC_TRUE;

  PetscFunctionBeginUser;
  out->last  = -1;
  out->every = time_end / 20;
  PetscCall(MPMOptionsString(o, "output_dir", NULL, out->dir, NULL));
  PetscCall(MPMOptionsBool(o, "output_replace", NULL, &replace));
  out->keep = !replace;
  PetscCall(MPMOptionsEnum(o, "output_format", NULL, format, NULL));
  PetscCall(MPMOptionsReal(o, "output_every", NULL, &out->every, &set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  out->enabled = !strcmp(format, "hdf5");
#if !defined(PETSC_HAVE_HDF5)
  if (out->enabled)
    MPMOptionsFail(o, "-output_format hdf5, the default, needs a PETSc with HDF5, and this one has none; choose none");
#endif
  if (!out->enabled && set && !MPMOptionsOverridden("output_every", "output_format"))
    MPMOptionsFail(o, "-output_every does not apply: -output_format none writes no snapshots");
  PetscCall(MPMOptionsBool(o, "output_exact", NULL, &out->exact));
  if (out->exact && !out->enabled)
    MPMOptionsFail(o, "-output_exact does not apply: -output_format none writes no snapshots");
  if (out->exact && !(out->every > 0))
    MPMOptionsFail(o, "-output_exact does not apply: -output_every 0 writes a snapshot of every step");
  PetscCall(ReadFields(out, scene, o, &set));
  if (!out->enabled && set && !MPMOptionsOverridden("output_fields", "output_format"))
    MPMOptionsFail(o, "-output_fields does not apply: -output_format none writes no snapshots");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- HDF5 ------------------------------------------------------------------------------------------------------ */

#if defined(PETSC_HAVE_HDF5)

/* Replaces the ids of n particles here by their places among all that are left of `start`. Collective on comm. */
static PetscErrorCode PlacesOfIds(MPI_Comm comm, PetscInt start, PetscInt n, PetscInt row[])
{
  PetscInt *one, *place, at = 0;
  MPMRows   all;

  PetscFunctionBeginUser;
  PetscCall(MPMRowsCreate(comm, start, n, row, &all));
  PetscCall(PetscMalloc1(n, &one));
  PetscCall(PetscCalloc1(all.n, &place));
  for (PetscInt p = 0; p < n; p++) one[p] = 1;
  PetscCall(PetscSFReduceBegin(all.sf, MPIU_INT, one, place, MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(all.sf, MPIU_INT, one, place, MPI_REPLACE));
  for (PetscInt k = 0; k < all.n; k++) at += place[k];
  PetscCallMPI(MPI_Scan(MPI_IN_PLACE, &at, 1, MPIU_INT, MPI_SUM, comm));
  for (PetscInt k = all.n - 1; k >= 0; k--) {
    at -= place[k];
    place[k] = at;
  }
  PetscCall(PetscSFBcastBegin(all.sf, MPIU_INT, place, row, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(all.sf, MPIU_INT, place, row, MPI_REPLACE));
  PetscCall(PetscFree(one));
  PetscCall(PetscFree(place));
  PetscCall(PetscSFDestroy(&all.sf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the rows of the particles, sorted by id. Collective on exchange.data. */
static PetscErrorCode ParticleRows(MPMCore *core, const MPMScene *scene, MPMRows *rows)
{
  const MPI_Comm comm = core->exchange.data;
  PetscInt      *row;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id), &view));
  PetscCall(PetscMalloc1(view.n, &row));
  for (PetscInt p = 0; p < view.n; p++) row[p] = (PetscInt)view.id[p];
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id), &view));
  if (core->particles.total < MPMSceneStarted(scene))
    PetscCall(PlacesOfIds(comm, (PetscInt)MPMSceneStarted(scene), core->particles.n, row));
  PetscCall(MPMRowsCreate(comm, (PetscInt)core->particles.total, core->particles.n, row, rows));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the fields of the particles to the datasets from *set on. Collective on exchange.data. */
static PetscErrorCode WriteParticles(MPMOutput *out, MPMCore *core, const MPMScene *scene, MPMFile *file, PetscInt *set)
{
  const PetscInt n = core->particles.n;
  MPMShown       shown;
  MPMRows        rows;
  MPMView        view;
  PetscReal     *here, *sorted;

  PetscFunctionBeginUser;
  PetscCall(MPMShownBegin(scene, core, out->fields, &shown));
  PetscCall(ParticleRows(core, scene, &rows));
  PetscCall(PetscMalloc2(n * MPM_MAX_COMPONENTS, &here, rows.n * MPM_MAX_COMPONENTS, &sorted));
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) {
    const PetscInt nc = MPMDiagnostics[f].nc;

    if (!(out->fields >> f & 1)) continue;
    PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
    for (PetscInt p = 0; p < n; p++) MPMDiagnostics[f].fill(&shown, &view, p, here + p * nc);
    PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
    PetscCall(MPMRowsWrite(file, (*set)++, &rows, nc, here, sorted));
  }
  if (core->particles.total < MPMSceneStarted(scene)) {
    for (PetscInt k = 0; k < rows.n; k++) sorted[k] = (PetscReal)(rows.first + k);
    PetscCall(MPMFileWrite(file, (*set)++, rows.first, rows.n, sorted));
  }
  PetscCall(PetscFree2(here, sorted));
  PetscCall(MPMShownEnd(&shown));
  PetscCall(PetscSFDestroy(&rows.sf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the groups and datasets of a snapshot, in the sequence in which they are written. Not collective. */
static PetscErrorCode MakeDatasets(const MPMOutput *out, const MPMCore *core, const MPMScene *scene,
                                   const char digest[], MPMFile *file)
{
  const hsize_t n = (hsize_t)core->particles.total;
  char          name[MPM_NAME_LEN];
  hsize_t       extent[4] = {n, 0, 0, 3};
  hid_t         step = -1, group = -1;

  PetscFunctionBeginUser;
  (void)snprintf(name, sizeof name, "step_%06" PetscInt_FMT, core->step);
  if (file->file >= 0) {
    H5(step = H5Gcreate2(file->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5(group = H5Gcreate2(step, "particles", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
  PetscCall(MPMHDF5Real(step, "time", core->t));
  PetscCall(MPMHDF5Int(step, "step", core->step));
  PetscCall(MPMHDF5Real(step, "dt", core->step ? core->params.dt : 0));
  PetscCall(MPMHDF5Text(step, "digest", digest));
  PetscCall(MPMHDF5Text(step, "units", "time and dt in s"));
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) {
    const MPMDiagnostic *field = &MPMDiagnostics[f];

    if (!(out->fields >> f & 1)) continue;
    extent[1] = (hsize_t)field->nc;
    PetscCall(MPMFileDataset(file, group, field->name, field->unit, field->components, field->whole,
                             field->nc == 1 ? 1 : 2, extent));
  }
  if (core->particles.total < MPMSceneStarted(scene)) /* ids have gaps, and XDMF needs numbers that have none */
    PetscCall(MPMFileDataset(file, group, "row", "1", "", PETSC_TRUE, 1, extent));
  if (group >= 0) H5(H5Gclose(group));
  if (core->rigids.n) PetscCall(MPMRigidDatasets(out, core, file, step));
  if (out->fields & MPM_OUTPUT_GRID) {
    if (step >= 0) H5(group = H5Gcreate2(step, "grid", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    MPMNodesBetween(&core->grid, extent);
    for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++) {
      extent[3] = (hsize_t)g->components(3);
      if (g->dataset[0])
        PetscCall(MPMFileDataset(file, group, g->dataset, g->unit, extent[3] == 3 ? "x y z" : "", PETSC_FALSE,
                                 extent[3] > 1 ? 4 : 3, extent));
    }
    if (group >= 0) H5(H5Gclose(group));
  }
  if (step >= 0) H5(H5Gclose(step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteSnapshot(MPMOutput *out, MPMCore *core, const MPMScene *scene, char fault[MPM_TEXT_LEN])
{
  char     path[2 * MPM_TEXT_LEN], text[MPM_NAME_LEN];
  PetscInt set = 0;
  size_t   room;
  MPMFile  file;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesDigest(&core->particles, core->exchange.data, &out->digest));
  (void)snprintf(text, sizeof text, "%016llx", (unsigned long long)out->digest);
  MPMSnapshotPath(out, scene, core->step, PETSC_FALSE, path);
  PetscCall(MPMRigidFacesMake(out, core));
  PetscCall(MPMProvenanceWrite(core, scene, -1, &room));
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) room += out->fields >> f & 1 ? 640 : 0;
  for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++) room += g->dataset[0] ? 640 : 0;
  PetscCall(MPMFileCreate(&file, core->exchange.data, path, 0, room + 4096));
  PetscCall(MPMProvenanceWrite(core, scene, file.file, NULL));
  PetscCall(MakeDatasets(out, core, scene, text, &file));
  if (!out->begun && !file.rank) MPMOutputClear(out, scene, PETSC_FALSE);
  out->begun = PETSC_TRUE;
  PetscCall(MPMFileLay(&file));
  PetscCall(WriteParticles(out, core, scene, &file, &set));
  if (core->rigids.n) PetscCall(MPMRigidWrite(out, core, &file, &set));
  if (out->fields & MPM_OUTPUT_GRID) PetscCall(MPMNodesWrite(core, &file, &set));
  PetscCall(MPMFileClose(&file, PETSC_FALSE, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMIndexWrite(const MPMOutput *out, const MPMCore *core, const MPMScene *scene, char fault[MPM_TEXT_LEN])
{
  PetscFunctionBeginUser;
  (void)out;
  (void)scene;
  (void)fault;
  SETERRQ(core->comm, PETSC_ERR_SUP, "snapshots need a PETSc with HDF5");
}

static PetscErrorCode WriteSnapshot(MPMOutput *out, MPMCore *core, const MPMScene *scene, char fault[MPM_TEXT_LEN])
{
  PetscFunctionBeginUser;
  PetscCall(MPMIndexWrite(out, core, scene, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif

/* Writes index and text, if they do not have all snapshots; a fault is left in core->stop. Collective on the
   exchange. */
PetscErrorCode MPMOutputFinish(MPMOutput *out, MPMCore *core, const MPMScene *scene)
{
  char fault[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (out->failed || out->joined == out->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMIndexWrite(out, core, scene, fault));
  if (!fault[0]) PetscCall(MPMXdmfWrite(out, core, scene, fault));
  PetscCall(MPMOutputFail(core, fault, &out->failed));
  out->joined = out->count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a snapshot, if one is due or `force` is set; a fault is left in core->stop. Collective on the exchange. */
PetscErrorCode MPMOutputStep(MPMOutput *out, MPMCore *core, const MPMScene *scene, PetscBool force)
{
  char fault[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (!out->enabled || out->failed || out->last == core->step || !(force || core->t >= out->next))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WriteSnapshot(out, core, scene, fault));
  PetscCall(MPMOutputFail(core, fault, &out->failed));
  if (out->failed) PetscFunctionReturn(PETSC_SUCCESS);
  if (out->count % 64 == 0) {
    PetscCall(PetscRealloc((size_t)(out->count + 64) * sizeof *out->digests, &out->digests));
    PetscCall(PetscRealloc((size_t)(out->count + 64) * sizeof *out->steps, &out->steps));
    PetscCall(PetscRealloc((size_t)(out->count + 64) * sizeof *out->n, &out->n));
    PetscCall(PetscRealloc((size_t)(out->count + 64) * sizeof *out->times, &out->times));
  }
  out->digests[out->count] = out->digest;
  out->steps[out->count]   = core->step;
  out->n[out->count]       = (PetscInt)core->particles.total;
  out->times[out->count++] = core->t;
  if (out->count % (1 + out->count / 100) == 0) /* they are written as a whole, so not each time */
    PetscCall(MPMOutputFinish(out, core, scene));
  out->last = core->step;
  out->next = MPMNextTime(core->t, out->every);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the lists. Not collective. */
PetscErrorCode MPMOutputDestroy(MPMOutput *out)
{
  PetscFunctionBeginUser;
  PetscCall(MPMRigidFacesDestroy(out));
  PetscCall(PetscFree(out->digests));
  PetscCall(PetscFree(out->steps));
  PetscCall(PetscFree(out->n));
  PetscCall(PetscFree(out->times));
  PetscFunctionReturn(PETSC_SUCCESS);
}
