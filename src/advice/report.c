/* report.c - lines that a run prints of its scene before the first step, and of its results at the end (run/prints.c
   has their sequence). */
#include <unistd.h>
#include "physics/sizes.h"
#include "physics/skin.h"
#include "kernels/tile_index.h"
#include "parallel/exchange.h"
#include "advice/advice.h"

PetscErrorCode MPMReportScene(const MPMCore *core, const MPMScene *scene)
{
  static const char *const space[] = {"1-D uniaxial strain", "2-D plane strain", "3-D"};
  const PetscInt           dim     = core->grid.dim;
  PetscBool                cubes   = PETSC_TRUE; /* but for rounding */

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, "scene      %s   %s   ", scene->title,
                     core->grid.round ? "2-D axisymmetric (x is r, y is z)" : space[dim - 1]));
  for (PetscInt d = 0; d < dim; d++)
    PetscCall(MPMPrint(&core->print, "%s%" PetscInt_FMT, d ? "x" : "", core->grid.cells[d]));
  PetscCall(MPMPrint(&core->print, " cells  h="));
  for (PetscInt d = 1; d < dim; d++)
    if (PetscAbsReal(core->grid.h[d] - core->grid.h[0]) > 1e-12 * core->grid.h[0]) cubes = PETSC_FALSE;
  for (PetscInt d = 0; d < (cubes ? 1 : dim); d++)
    PetscCall(MPMPrint(&core->print, "%s%g", d ? "," : "", (double)core->grid.h[d]));
  PetscCall(MPMPrint(&core->print, "  %" PetscInt64_FMT " particles (", core->particles.total));
  for (PetscInt b = 0; b < scene->nbodies; b++)
    PetscCall(MPMPrint(&core->print, "%s%" PetscInt64_FMT, b ? "+" : "", scene->bodies[b].n));
  PetscCall(MPMPrint(&core->print, ")\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the bytes of a node: its numbers, where the particles of a cell begin, and how many come. */
static PetscInt NodeBytes(const MPMCore *core)
{
  return MPMNodeNumbers(core->grid.dim, MPMExchangeLines(core)) * (PetscInt)sizeof(PetscReal) +
         2 * (PetscInt)sizeof(PetscInt);
}

/* Returns the bytes of particles, with order and scratch, and of nodes, on all processes together. */
static PetscReal Memory(const MPMCore *core)
{
  PetscReal nodes = 1;

  for (PetscInt d = 0; d < core->grid.dim; d++) nodes *= core->grid.nodes[d];
  return MPMParticlesMemory(&core->particles) * (PetscReal)core->particles.total + nodes * (PetscReal)NodeBytes(core);
}

PetscErrorCode MPMReportFields(const MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, "fields     "));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (core->particles.present[f] && MPMFields[f].home == MPM_STATE)
      PetscCall(MPMPrint(&core->print, "%s ", MPMFields[f].name));
  PetscCall(MPMPrint(&core->print,
                     "  %" PetscInt_FMT " B/particle, %" PetscInt_FMT " with order and scratch%s, %" PetscInt_FMT
                     " B/node: %.3g MB for both\n",
                     MPMParticlesBytes(&core->particles, MPM_STATE), MPMParticlesMemory(&core->particles),
                     core->particles.saved ? " and a copy of what a step changes" : "", NodeBytes(core),
                     (double)(1e-6 * Memory(core))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints at which friction angles soils flow, since one cone is another angle in each kind of deformation. */
static PetscErrorCode PrintFriction(const MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials && core->grid.dim > 1; k++) {
    const MPMMaterial *m = &scene->materials[k];

    if (MPMListHas(m->type->parameters, "friction_angle"))
      PetscCall(MPMPrint(&core->print,
                         "friction   %s flows at %.3g degrees in plane strain, at %.3g in triaxial compression\n",
                         m->name, (double)m->acts[1], (double)m->acts[0]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportMethod(const MPMCore *core, const MPMScene *scene, const MPMMethod *method)
{
  const MPMTransfer *transfer = method->transfer;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, "kernels    %s%s / %s / ", MPMBasisNames[core->basis],
                     core->needs.stretched                                ? " stretch"
                     : !MPMBasisIsSpline(core->basis)                     ? ""
                     : core->grid.wall_basis[0] == MPM_WALL_BASIS_STEFFEN ? " steffen"
                                                                          : "",
                     method->scheme->name));
  PetscCall(MPMPrint(&core->print, "%s", transfer->name));
  if (core->grid.total) PetscCall(MPMPrint(&core->print, " mass order %" PetscInt_FMT, method->mass));
  if (transfer->rounds != MPM_NO_ROUNDS) PetscCall(MPMPrint(&core->print, " %" PetscInt_FMT, core->params.order));
  if (transfer->flip < 0 && core->params.flip < 1) PetscCall(MPMPrint(&core->print, " %g", (double)core->params.flip));
  if (transfer->flip < 0 && (transfer->parts & MPM_AFFINE))
    PetscCall(MPMPrint(&core->print, " strain %g", (double)core->params.strain));
  if (method->rate > 0) PetscCall(MPMPrint(&core->print, " damping rate %g", (double)method->rate));
  if (method->viscosity > 0) PetscCall(MPMPrint(&core->print, " viscosity %g m^2/s", (double)method->viscosity));
  for (PetscInt m = 0; m < scene->nmaterials; m++)
    PetscCall(MPMPrint(&core->print, " %s %s", m ? "+" : "/", scene->materials[m].type->name));
  PetscCall(MPMPrint(&core->print, ", %" PetscInt_FMT " lanes\n", MPMKernelWidth()));
  PetscCall(PrintFriction(core, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the line of a load with the sum `all` [n] of its forces or torques at time t; where they cancel, with that of their
   sizes too. */
static PetscErrorCode PrintInAll(const MPMCore *core, PetscInt n, const PetscReal all[], PetscReal size,
                                 const char unit[], PetscReal t)
{
  PetscReal sum = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, ", in all %s", n > 1 ? "(" : ""));
  for (PetscInt d = 0; d < n; d++) {
    const PetscReal shown = PetscAbsReal(all[d]) > 1e-9 * size ? all[d] : 0; /* not the rounding of what cancels */

    PetscCall(MPMPrint(&core->print, "%s%.3g", d ? ", " : "", (double)shown));
    sum += PetscSqr(shown);
  }
  PetscCall(MPMPrint(&core->print, "%s %s at t=%.3g s", n > 1 ? ")" : "", unit, (double)t));
  if (PetscSqrtReal(sum) < 0.99 * size)
    PetscCall(MPMPrint(&core->print, ", the sum of sizes %.3g %s", (double)size, unit));
  PetscCall(MPMPrint(&core->print, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does a stage give a load another value? */
static PetscBool IsOfStage(const MPMScene *scene, const MPMLoad *load)
{
  PetscBool any = PETSC_FALSE;

  for (PetscInt s = 0; s < scene->nstages; s++) {
    char      name[4 * MPM_NAME_LEN];
    PetscBool given = PETSC_FALSE;

    (void)snprintf(name, sizeof name, "-stage_%s_load_%s_value", scene->stages[s], load->name);
    (void)PetscOptionsHasName(NULL, NULL, name, &given);
    any = any || given;
  }
  return any;
}

/* Appends to the line of a load where it acts, lower to upper [dim], m, on the axes on which that is less than
   the body; notes if that is less than a cell of a side of some. */
static PetscErrorCode PrintExtent(const MPMCore *core, const MPMLoad *load, const PetscReal lower[],
                                  const PetscReal upper[], const PetscReal whole[], char narrow[MPM_TEXT_LEN])
{
  const MPMGrid *grid = &core->grid;
  char           finer[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal size = upper[d] - lower[d], h = grid->h[d];

    if (load->sides >> 2 * d & 3 || !(size > 0) || size > whole[d] - 1e-9 * h) continue;
    PetscCall(MPMPrint(&core->print, ", %c from %.3g to %.3g m", "xyz"[d], (double)lower[d], (double)upper[d]));
    if (size > h * (1 - 1e-9) || whole[d] < 2 * h) continue;
    MPMGridFiner(grid, 4 * MPMGridSmallestH(grid) / size, finer, sizeof finer);
    (void)snprintf(narrow, MPM_TEXT_LEN,
                   "-load_%s_value acts on %.3g m along %c, less than a cell, which smears it; check its places, or "
                   "choose %s",
                   load->name, (double)size, "xyz"[d], finer);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether particle p is of a body; if so lets its box [6] reach as far as that of the particle: -lower, upper, m. */
static PetscBool Reaches(const MPMBody *body, PetscInt dim, const MPMView *view, PetscInt p, PetscReal box[])
{
  if (view->id[p] < body->first || view->id[p] >= body->first + body->n) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) {
    box[d]     = PetscMax(box[d], -view->X[p * dim + d] + 0.5 * body->b[d]);
    box[3 + d] = PetscMax(box[3 + d], view->X[p * dim + d] + 0.5 * body->b[d]);
  }
  return PETSC_TRUE;
}

/* Appends to the line of load l on a volume where its particles are. */
static PetscErrorCode PrintPlaces(const MPMCore *core, const MPMScene *scene, PetscInt l, const MPMView *view)
{
  const MPMLoad *load = &scene->loads[l];
  const PetscInt dim  = core->grid.dim;
  PetscReal      box[12], lower[3], upper[3], whole[3]; /* of its particles, and of all of its body */
  char           narrow[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 12; d++) box[d] = -PETSC_MAX_REAL;
  for (PetscInt p = 0; p < view->n; p++)
    if (Reaches(&scene->bodies[load->body], dim, view, p, box + 6) && view->chosen[p] >> l & 1)
      (void)Reaches(&scene->bodies[load->body], dim, view, p, box);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, box, 12, MPIU_REAL, MPI_MAX, core->exchange.data));
  for (PetscInt d = 0; d < dim; d++) {
    lower[d] = 0 - box[d];
    upper[d] = box[3 + d];
    whole[d] = box[6 + d] + box[9 + d];
  }
  PetscCall(PrintExtent(core, load, lower, upper, whole, narrow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the k-th time at which a load is looked at: after each tenth of the run and, where it is 0 there, each hundredth. */
#define TENTHS     10
#define HUNDREDTHS 110
static PetscReal TriedAt(PetscReal end, PetscInt k)
{
  return k <= TENTHS ? end * k / TENTHS : end * (k - TENTHS) / 100;
}

/* Prints what a load on a volume acts on, and how large it is when it is largest. */
static PetscErrorCode PrintVolumeLoad(const MPMCore *core, const MPMScene *scene, PetscReal end, PetscInt l,
                                      const MPMView *view)
{
  const MPMLoad  *load       = &scene->loads[l];
  const PetscReal nowhere[3] = {0};
  PetscReal       most = 0, at = 0, largest[3] = {0};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k <= TENTHS || (k < HUNDREDTHS && !(most > 0)); k++) {
    const PetscReal t        = TriedAt(end, k);
    PetscReal       value[3] = {0}, size = 0;

    PetscCall(MPMExpressionEvaluate(load->value, core->grid.dim, nowhere, NULL, t, value));
    for (PetscInt d = 0; d < load->nc; d++) size += value[d] * value[d];
    if (!(size > most)) continue;
    at   = t;
    most = size;
    for (PetscInt d = 0; d < load->nc; d++) largest[d] = value[d];
  }
  PetscCall(MPMPrint(&core->print, "load       %s: %s on %" PetscInt64_FMT " particles of %s", load->name,
                     load->type == MPM_LOAD_FORCE ? "force" : "torque", load->n, scene->bodies[load->body].name));
  PetscCall(PrintPlaces(core, scene, l, view));
  PetscCall(PrintInAll(core, load->nc, largest, PetscSqrtReal(most), load->type == MPM_LOAD_FORCE ? "N" : "N m", at));
  if (!(most > 0) && end > 0 && !IsOfStage(scene, load))
    PetscCall(MPMWarn(&core->print,
                      "load %s is 0 at the start and after each hundredth of -time_end; see -load_%s_value", load->name,
                      load->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes that the pool has fewer patches with particles than workers, with the largest edge that makes enough. */
static PetscErrorCode NoteIdle(MPMCore *core, PetscInt workers)
{
  const PetscInt tile               = MPMTileEdge(core->basis);
  const PetscInt widest             = PetscMax(core->grid.nodes[0], PetscMax(core->grid.nodes[1], core->grid.nodes[2]));
  PetscInt       edge               = PetscMin(core->exchange.pool_cells, MPMPoolEdge(core->basis, widest)), has, n;
  char           more[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMPoolPatches(core, edge, &has));
  for (n = has; n < workers && edge > tile;) PetscCall(MPMPoolPatches(core, edge -= tile, &n));
  if (has >= workers) PetscFunctionReturn(PETSC_SUCCESS);
  if (n < workers)
    (void)snprintf(more, sizeof more, ", and smaller ones are not possible; use %" PetscInt_FMT " processes at most",
                   n + 1);
  PetscCall(MPMNote(&core->print,
                    "the pool has fewer patches with particles than workers, %" PetscInt_FMT " for %" PetscInt_FMT
                    ", so some have no work: -pool_cells %" PetscInt_FMT " makes %" PetscInt_FMT "%s",
                    has, workers, edge, n, more));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportParallel(MPMCore *core)
{
  const MPMPartition *part = &core->exchange.partition;
  PetscMPIInt         size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(&core->print, "parallel   %d processes, %s", size, core->exchange.type->name));
  if (core->exchange.type->by_workers)
    PetscCall(MPMPrint(&core->print, ": a master hands out patches of %" PetscInt_FMT " cells an axis",
                       core->exchange.pool_cells));
  else {
    for (PetscInt d = 0; d < core->grid.dim; d++)
      PetscCall(MPMPrint(&core->print, "%s%" PetscInt_FMT, d ? "x" : " ", part->p[d]));
    PetscCall(MPMPrint(&core->print,
                       ", particles max/mean %.3f, by the model %.3g s a step, of migration the leavers alone",
                       (double)part->imbalance, (double)part->predicted));
  }
  PetscCall(MPMPrint(&core->print, "\n"));
  if (core->exchange.type->by_workers) PetscCall(NoteIdle(core, size - 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportLoads(MPMCore *core, const MPMScene *scene, PetscReal end)
{
  const PetscInt dim    = core->grid.dim;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(depth) | MPM_BIT(kind) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(F) |
                          MPM_BIT(F33) | MPM_BIT(J) | MPM_BIT(chosen);
  MPMView view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt l = 0; l < scene->nloads; l++) {
    const MPMLoad *load    = &scene->loads[l];
    const MPMBody *body    = &scene->bodies[load->body];
    PetscInt64     n[7]    = {0}; /* particles, and the areas of their sides, in parts of that of the lattice */
    PetscReal      area[3] = {0}, all[3] = {0}, most = 0, at = 0;
    PetscReal      lower[3] = {0}, upper[3] = {0}, whole[6]; /* where it acts when it is largest; the body */
    char           narrow[MPM_TEXT_LEN] = "";
    MPMSum         rings[3]; /* of a body of revolution: areas */

    if (MPMLoadIsOnVolume(load)) {
      PetscCall(PrintVolumeLoad(core, scene, end, l, &view));
      continue;
    }
    for (PetscInt d = 0; d < 3; d++) MPMSumZero(&rings[d]);
    for (PetscInt d = 0; d < 6; d++) whole[d] = -PETSC_MAX_REAL;
    for (PetscInt p = 0; p < view.n; p++) {
      PetscInt sides = 0;

      for (PetscInt k = 0; k < 2 * dim; k++)
        if (MPMSkinLayer(view.depth[2 * dim * p + k]) == 0) sides |= (PetscInt)1 << k & load->sides;

      if (!sides || !Reaches(body, dim, &view, p, whole)) continue;
      n[0]++;
      for (PetscInt k = 0; k < 2 * dim; k++)
        if (sides >> k & 1) n[1 + k] += (PetscInt64)(MPM_SKIN_AREA * MPMSkinArea(view.depth[2 * dim * p + k]));
      for (PetscInt k = 0; k < 2 * dim && body->round; k++)
        if (sides >> k & 1)
          MPMSumAdd(&rings[k / 2], 2 * PETSC_PI * body->b[1 - k / 2] *
                                       (view.X[p * dim] + (k > 1 ? 0 : (k ? 0.5 : -0.5) * body->b[0])));
    }
    PetscCall(MPMSumReduce(rings, 3, core->exchange.data));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, n, 7, MPIU_INT64, MPI_SUM, core->exchange.data));
    PetscCall(MPMPrint(&core->print, "load       %s: %s on %" PetscInt64_FMT " particles of %s, area along each axis (",
                       load->name, load->type == MPM_LOAD_PRESSURE ? "pressure" : "traction", n[0], body->name));
    for (PetscInt d = 0; d < dim; d++) {
      area[d] = (PetscReal)(n[1 + 2 * d] + n[2 + 2 * d]) / MPM_SKIN_AREA;
      for (PetscInt e = 0; e < dim; e++) area[d] *= e == d ? 1 : body->b[e];
      if (body->round) area[d] = MPMSumValue(&rings[d]);
      PetscCall(MPMPrint(&core->print, "%s%g", d ? ", " : "", (double)area[d]));
    }
    PetscCall(MPMPrint(&core->print, ") m^%" PetscInt_FMT, body->round ? 2 : dim - 1));
    for (PetscInt k = 0; k <= TENTHS || (k < HUNDREDTHS && !(most > 0)); k++) {
      const PetscReal t       = TriedAt(end, k);
      PetscReal       from[3] = {PETSC_MAX_REAL, PETSC_MAX_REAL, PETSC_MAX_REAL},
                to[3]         = {-PETSC_MAX_REAL, -PETSC_MAX_REAL, -PETSC_MAX_REAL};
      MPMSum sum[4];

      for (PetscInt c = 0; c < 4; c++) MPMSumZero(&sum[c]);
      PetscCall(MPMForcesAdd(scene, core, load, &view, t, sum, from, to));
      PetscCall(MPMSumReduce(sum, 4, core->exchange.data));
      if (!(MPMSumValue(&sum[3]) > most)) continue;
      at   = t;
      most = MPMSumValue(&sum[3]);
      PetscCall(PetscArraycpy(lower, from, 3));
      PetscCall(PetscArraycpy(upper, to, 3));
      for (PetscInt d = 0; d < dim; d++) all[d] = MPMSumValue(&sum[d]);
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, lower, 3, MPIU_REAL, MPI_MIN, core->exchange.data));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, upper, 3, MPIU_REAL, MPI_MAX, core->exchange.data));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, whole, 6, MPIU_REAL, MPI_MAX, core->exchange.data));
    for (PetscInt d = 0; d < dim && n[0]; d++) whole[d] += whole[3 + d];
    PetscCall(PrintExtent(core, load, lower, upper, whole, narrow));
    PetscCall(PrintInAll(core, dim, all, most, "N", at));
    if (narrow[0]) PetscCall(MPMNote(&core->print, "%s", narrow));
    if (!n[0])
      PetscCall(MPMWarn(&core->print, "load %s acts on no particle", load->name));
    else if (!(most > 0) && end > 0 && !IsOfStage(scene, load))
      PetscCall(MPMWarn(
          &core->print,
          "load %s is 0 on all of these particles, at the start and after each hundredth of -time_end; see -load_%s_value",
          load->name, load->name));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in advice.h. The memory of the next order, which no step follows to use, has room for a number of each
   particle. */
_Static_assert(sizeof(float) <= sizeof(PetscInt), "the order has room for numbers of float");
PetscErrorCode MPMReportIndicator(MPMCore *core, const MPMScene *scene)
{
  MPMIndicator indicator = {0};
  PetscReal    rho       = 0;
  char         place[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMIndicatorCompute(scene, core, (float *)core->particles.spare, &indicator));
  for (PetscInt m = 0; m < scene->nmaterials; m++) rho = PetscMax(rho, scene->materials[m].rho);
  MPMPlaceWords(core->grid.dim, indicator.x, place);
  if (indicator.stress > 1e-10 * rho * core->status.c2)
    PetscCall(MPMPrint(&core->print, "indicator  stress jumps by %.3g %% of its rms %.3g Pa, most at %s: by %.3g %%\n",
                       (double)(100 * indicator.jump), (double)indicator.stress, place,
                       (double)(100 * indicator.largest)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in advice.h. After a fault some files may not be there. */
PetscErrorCode MPMReportResults(const MPMCore *core, const MPMScene *scene, const MPMOutput *out)
{
  const char *const ends[] = {".csv", ".h5", ".xdmf"};
  PetscInt          n      = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < (out->enabled ? 3 : 1) && out->dir[0]; k++) {
    char path[2 * MPM_TEXT_LEN];

    (void)snprintf(path, sizeof path, "%s/%s%s", out->dir, scene->name, ends[k]);
    if (access(path, F_OK)) continue;
    PetscCall(n++ ? MPMPrint(&core->print, " %s", ends[k]) : MPMPrint(&core->print, "results    %s", path));
  }
  if (n) PetscCall(MPMPrint(&core->print, "%s\n", out->resumed ? " (continued)" : out->replaced ? " (replaced)" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportKnown(MPMCore *core, const MPMScene *scene)
{
  PetscReal error, size;

  PetscFunctionBeginUser;
  if (!scene->known || !core->particles.total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMKnownError(scene, core, &error, &size));
  PetscCall(MPMPrint(&core->print, "reference  rms error of the displacement %.6g m", (double)error));
  if (size > 0) PetscCall(MPMPrint(&core->print, "; its rms is %.6g m", (double)size));
  if (size > error) PetscCall(MPMPrint(&core->print, ", so the relative error is %.4g", (double)(error / size)));
  PetscCall(MPMPrint(&core->print, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportExchange(const MPMCore *core)
{
  PetscInt shares = 1; /* into which the particles are divided */

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) shares *= core->exchange.partition.p[d];
  if (core->exchange.recuts)
    PetscCall(MPMPrint(
        &core->print, "balance    the grid was cut anew %" PetscInt_FMT " times, particles max/mean at the end %.3f\n",
        core->exchange.recuts, (double)core->status.most * shares / (double)PetscMax(1, core->particles.total)));
  if (core->exchange.migrations)
    PetscCall(MPMPrint(&core->print,
                       "migration  particles changed process %" PetscInt64_FMT " times, in %" PetscInt_FMT
                       " of %" PetscInt_FMT " steps\n",
                       core->exchange.migrants, core->exchange.migrations, core->step - core->timers.first));
  PetscFunctionReturn(PETSC_SUCCESS);
}
