/* dmda.c - the background grid as PETSc has it, in 1, 2 or 3 dimensions: a DMDA of the nodes whose unknowns are their
   motion, and a compatible one whose unknowns are their sums. */
#include "particles/box.h"

/* Names the unknowns of a group from number `first` on: its name, that and an axis, or that and a number. Those that
   are out of the DMDA's unknowns are passed over. */
static PetscErrorCode NameUnknowns(DM da, PetscInt first, const MPMNodeGroup *g)
{
  const PetscInt most = g->components(3);
  char           name[MPM_NAME_LEN];
  PetscInt       unknowns;

  PetscFunctionBeginUser;
  PetscCall(DMDAGetDof(da, &unknowns));
  for (PetscInt c = 0; c < most; c++) {
    if (first + c < 0 || first + c >= unknowns) continue;
    (void)snprintf(name, sizeof name, "%s", g->name);
    if (most == 3) (void)snprintf(name, sizeof name, "%s_%c", g->name, "xyz"[c]);
    if (most != 1 && most != 3) (void)snprintf(name, sizeof name, "%s_%" PetscInt_FMT, g->name, c);
    PetscCall(DMDASetFieldName(da, first + c, name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the names of the unknowns if -dm_view is given. PETSc prints the rest of a DMDA when it is set up, but not
   these. Collective on the DMDA. */
static PetscErrorCode PrintUnknowns(DM da)
{
  const char *const *name;
  const char        *grid;
  PetscBool          asked;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-dm_view", &asked));
  if (!asked) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectGetName((PetscObject)da, &grid));
  PetscCall(DMDAGetFieldNames(da, &name));
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)da), "Unknowns of a node of %s:", grid));
  for (; *name; name++) PetscCall(PetscPrintf(PetscObjectComm((PetscObject)da), " %s", *name));
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)da), "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the DMDA "grid" of the grid's nodes, layers beyond the walls included, with the numbers of their motion as
   unknowns. Its node 0 is node -layers of the grid. Collective on comm.
     stencil   [in]  layers of ghost nodes around a process's box
     parts     [in]  boxes on each axis, and widths[axis][part] in nodes; NULL: comm has one process */
PetscErrorCode MPMGridCreateDM(const MPMGrid *grid, MPI_Comm comm, PetscInt stencil, const PetscInt parts[3],
                               PetscInt *const widths[3], DM *da)
{
  const PetscInt  nc = MPM_MOTION_NC(grid->dim), one[3] = {1, 1, 1}, *p = parts ? parts : one;
  const PetscInt *lx = widths ? widths[0] : NULL, *ly = widths ? widths[1] : NULL, *lz = widths ? widths[2] : NULL;
  const PetscInt *n = grid->nodes;
  DMBoundaryType  bc[3];
  PetscInt        named = 0;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) bc[d] = grid->periodic[d] ? DM_BOUNDARY_PERIODIC : DM_BOUNDARY_NONE;
  switch (grid->dim) {
  case 1:
    PetscCall(DMDACreate1d(comm, bc[0], n[0], nc, stencil, lx, da));
    break;
  case 2:
    PetscCall(DMDACreate2d(comm, bc[0], bc[1], DMDA_STENCIL_BOX, n[0], n[1], p[0], p[1], nc, stencil, lx, ly, da));
    break;
  default:
    PetscCall(DMDACreate3d(comm, bc[0], bc[1], bc[2], DMDA_STENCIL_BOX, n[0], n[1], n[2], p[0], p[1], p[2], nc, stencil,
                           lx, ly, lz, da));
  }
  PetscCall(PetscObjectSetName((PetscObject)*da, "grid"));
  PetscCall(DMSetFromOptions(*da));
  PetscCall(DMSetUp(*da));
  for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++) {
    if (g->home != MPM_IS_MOTION) continue;
    PetscCall(NameUnknowns(*da, named, g));
    named += g->components(grid->dim);
  }
  PetscCall(PrintUnknowns(*da));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the DMDA "sums" of the same nodes on the same processes, with the numbers of a line of their sums as unknowns
   ("more sums" for the other lines than the first one), and the local vector of these of a patch's nodes, after
   MPMPatchSetBox. It uses the memory of the patch, in which each record of a node begins a line of the cache; a vector
   that the DMDA makes would not be aligned so. Collective. */
PetscErrorCode MPMGridCreateSums(const MPMPatch *patch, DM da, PetscInt line, DM *sums, Vec *node_sums)
{
  const PetscInt nodes = MPMPatchNodes(patch);

  PetscFunctionBeginUser;
  PetscCall(DMDACreateCompatibleDMDA(da, MPM_NODE_NC, sums));
  PetscCall(PetscObjectSetName((PetscObject)*sums, line ? "more sums" : "sums"));
  for (PetscInt c = 0; c < MPM_NODE_NC; c++) PetscCall(DMDASetFieldName(*sums, c, "none"));
  for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++)
    if (g->home == MPM_IS_CORE || g->home == MPM_IS_SUM) PetscCall(NameUnknowns(*sums, g->at - line * MPM_NODE_NC, g));
  PetscCall(PrintUnknowns(*sums));
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, MPM_NODE_NC, MPM_NODE_NC * nodes,
                                  (PetscScalar *)(patch->node + line * nodes), node_sums));
  PetscCall(VecSetDM(*node_sums, *sums));
  PetscCall(PetscObjectSetName((PetscObject)*node_sums, line ? "more node sums" : "node sums"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
