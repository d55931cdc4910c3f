/* snapshot_nodes.c - the nodes of the grid in snapshots. */
#include "parallel/exchange.h"
#include "results/rows.h"
#include "step/step.h"
#if defined(PETSC_HAVE_HDF5)

void MPMNodesBetween(const MPMGrid *grid, hsize_t extent[3])
{
  for (PetscInt d = 0; d < 3; d++)
    extent[2 - d] = (hsize_t)(d < grid->dim ? grid->cells[d] - grid->periodic[d] : 0) + 1;
}

/* Returns the numbers of a group [components] at a node of the patch's arrays, whose access is open. */
static const PetscReal *NumbersOf(const MPMPatch *patch, const MPMNodeGroup *group, PetscInt node)
{
  const PetscInt   dim  = patch->grid->dim;
  const PetscReal *from = patch->motion + node * MPM_MOTION_NC(dim);

  for (const MPMNodeGroup *g = MPMNodeGroups; g < group; g++)
    if (g->home == MPM_IS_MOTION) from += g->components(dim);
  if (group->home != MPM_IS_MOTION)
    from = (PetscReal *)(patch->node + group->at / MPM_NODE_NC * MPMPatchNodes(patch) + node) + group->at % MPM_NODE_NC;
  return from;
}

/* The nodes of a place of copies that this process owns between the walls: their rows, and for each its number in the
   patch's arrays, or -1 where no particle touches it. */
typedef struct {
  PetscInt n, *node;
  MPMRows  rows;
} PlaceRows;

/* Finds them. Collective on the exchange. */
static PetscErrorCode PlaceRowsCreate(const MPMCore *core, PetscInt place, PlaceRows *c)
{
  const MPMGrid  *grid  = &core->grid;
  const MPMPatch *patch = &core->exchange.patch;
  PetscInt        lo[3], n[3], from[3], at = 0, *row, *node;
  hsize_t         extent[3];

  PetscFunctionBeginUser;
  MPMNodesBetween(grid, extent);
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt end = place && d == grid->stack ? PetscMin(grid->high[place], (PetscInt)extent[2 - d])
                                                   : (PetscInt)extent[2 - d];

    from[d] = patch->own_lo[d] - MPMGridFirstOf(grid, d, place);
    lo[d]   = PetscMax(from[d], place && d == grid->stack ? grid->low[place] : 0);
    n[d]    = PetscMax(0, PetscMin(from[d] + patch->own_n[d], end) - lo[d]);
    from[d] += patch->lo[d] - patch->own_lo[d];
  }
  PetscCall(PetscMalloc1(n[0] * n[1] * n[2], &row));
  PetscCall(PetscMalloc1(n[0] * n[1] * n[2], &node));
  for (PetscInt k = lo[2]; k < lo[2] + n[2]; k++)
    for (PetscInt j = lo[1]; j < lo[1] + n[1]; j++)
      for (PetscInt i = lo[0]; i < lo[0] + n[0]; i++, at++) {
        const PetscInt  line = (k - from[2]) * patch->n[1] + j - from[1], x = i - from[0];
        const PetscBool touched = x >= patch->span[line].first && x < patch->span[line].last;

        row[at]  = (k * (PetscInt)extent[1] + j) * (PetscInt)extent[2] + i;
        node[at] = touched ? line * patch->n[0] + x : -1;
      }
  PetscCall(MPMRowsCreate(core->exchange.data, (PetscInt)(extent[0] * extent[1] * extent[2]), at, row, &c->rows));
  PetscCall(PetscFree(row));
  c->n    = at;
  c->node = node;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the numbers of a group of nodes, of place after place, to the rows sorted [components]; those of its motion are
   means by mass where several have mass, which is as far as it has come. Collective on the exchange. */
static PetscErrorCode AddPlaces(MPMCore *core, const MPMNodeGroup *g, const PlaceRows *places, PetscReal *sorted)
{
  const MPMPatch *patch   = &core->exchange.patch;
  const PetscInt  nplaces = PetscMax(1, core->grid.places), wide = g->components(3), n = places->rows.n;
  const PetscBool mean = g->home == MPM_IS_MOTION && nplaces > 1;
  PetscReal      *all, *part, *mass;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2((wide + 1) * n, &part, n, &mass));
  for (const PlaceRows *c = places; c < places + nplaces; c++) {
    PetscCall(PetscCalloc1((wide + 1) * c->n, &all));
    PetscCall(MPMExchangeOpenNodes(core));
    for (PetscInt q = 0; q < c->n; q++) {
      const PetscReal m = mean && c->node[q] >= 0 ? patch->node[c->node[q]].m : 1;

      all[(wide + 1) * q + wide] = mean && c->node[q] < 0 ? 0 : m;
      for (PetscInt k = 0; k < g->components(core->grid.dim) && c->node[q] >= 0; k++)
        all[(wide + 1) * q + k] = NumbersOf(patch, g, c->node[q])[k];
    }
    PetscCall(MPMExchangeCloseNodes(core));
    PetscCall(MPMRowsSend(&c->rows, wide + 1, all, part));
    for (PetscInt q = 0; q < n; q++) {
      const PetscReal m = part[(wide + 1) * q + wide], before = mass[q];

      mass[q] += m;
      for (PetscInt k = 0; k < wide; k++) {
        const PetscReal now = part[(wide + 1) * q + k];

        if (!mean) sorted[wide * q + k] += now;
        if (mean && m > 0)
          sorted[wide * q + k] = before > 0 ? (before * sorted[wide * q + k] + m * now) / mass[q] : now;
      }
    }
    PetscCall(PetscFree(all));
  }
  PetscCall(PetscFree2(part, mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMNodesWrite(MPMCore *core, MPMFile *file, PetscInt *set)
{
  const PetscInt nplaces = PetscMax(1, core->grid.places);
  PlaceRows      places[MPM_MAX_COPIES];

  PetscFunctionBeginUser;
  PetscCall(MPMStepNodes(core));
  for (PetscInt c = 0; c < nplaces; c++) PetscCall(PlaceRowsCreate(core, c, &places[c]));
  for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++) {
    const PetscInt wide = g->components(3);
    PetscReal     *sorted;

    if (!g->dataset[0]) continue;
    PetscCall(PetscCalloc1(wide * places->rows.n, &sorted));
    PetscCall(AddPlaces(core, g, places, sorted));
    PetscCall(MPMFileWrite(file, (*set)++, wide * places->rows.first, wide * places->rows.n, sorted));
    PetscCall(PetscFree(sorted));
  }
  for (PetscInt c = 0; c < nplaces; c++) {
    PetscCall(PetscFree(places[c].node));
    PetscCall(PetscSFDestroy(&places[c].rows.sf));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
typedef int MPMSnapshotNodesNothing; /* a file must not be empty */
#endif
