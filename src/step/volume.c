/* volume.c - when volumes relax (kernels/volume.h), by how much, and what the nodes do in between. It happens before
   the phases of a step, each time after sound has crossed two cells, so that it depends neither on dt nor on the
   processes; if only sand relaxes, then after steps at whose end some was open. Other scenes have none of it.
   docs/method.md has the formulas. */
#include "parallel/exchange.h"
#include "step/step.h"

#define CROSSED 2.   /* cells that sound crosses between two relaxations of rate 1 */
#define FASTER  0.5  /* share of the mismatch that goes while the fastest particle crosses a cell */
#define AT_REST 0.2  /* speed that is added to that of the fastest one, of sqrt(g h) */
#define PUSH    0.04 /* largest share at a time */

/* Returns the speed of sound, m/s, of a material that relaxes, times its rate; 0 of others: of sand in 1-D, where a
   node has no room for what it needs, with dilation, since then the density does not tell what is open, and beside
   fluids that relax, whose pressure is another. */
static PetscReal Sound(const MPMMaterial *m, PetscInt dim, PetscBool fluids)
{
  const PetscBool sand = m->state & MPM_BIT(vc) && dim > 1 && !(m->dilation > 0) && !fluids ? PETSC_TRUE : PETSC_FALSE;

  if (m->type->traits & MPM_FLUID) return m->relaxation * PetscSqrtReal(m->K / m->rho);
  return sand ? m->relaxation * PetscSqrtReal((m->lambda + 2 * m->mu) / m->rho) : 0;
}

void MPMVolumesSetUp(MPMCore *core, MPMMaterial *materials, const MPMTime *time)
{
  const PetscReal h       = MPMGridSmallestH(&core->grid);
  MPMVolumes     *v       = &core->volumes;
  PetscReal       crossed = time->cfl; /* cells in a step */

  v->sound  = 0;
  v->fluids = v->sand = PETSC_FALSE;
  for (PetscInt k = 0; k < core->params.nkinds; k++) {
    const MPMMaterial *m = &materials[core->params.kinds[k].material];

    if (m->type->traits & MPM_FLUID && m->relaxation > 0) v->fluids = PETSC_TRUE;
  }
  for (int pass = 0; pass < 2; pass++) /* the fastest one, then their shares of it */
    for (PetscInt k = 0; k < core->params.nkinds; k++) {
      MPMMaterial    *m = &materials[core->params.kinds[k].material];
      const PetscReal c = Sound(m, core->grid.dim, v->fluids);

      if (!pass) v->sound = PetscMax(v->sound, c);
      if (c > 0 && !(m->type->traits & MPM_FLUID)) v->sand = PETSC_TRUE;
      m->follows = pass && c > 0 ? c / v->sound : 0;
    }
  if (time->fixed > 0) crossed = time->fixed * v->sound / h;
  v->share = PetscMin(1, crossed / CROSSED);
}

PetscBool MPMVolumesRelax(const MPMCore *core)
{
  return core->volumes.sound > 0 ? PETSC_TRUE : PETSC_FALSE;
}

void MPMNodesVolume(const MPMParams *par, const MPMPatch *patch, const MPMNodes *r)
{
  const MPMGrid *grid = patch->grid;
  const PetscInt dim = grid->dim, nc = MPM_MOTION_NC(dim);

  (void)par;
  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n      = r->sum + i;
    PetscReal     *motion = r->motion + i * nc, space = 1;
    const PetscInt ijk[3] = {r->ijk[0] + i, r->ijk[1], r->ijk[2]};

    for (PetscInt d = 0; d < dim; d++)
      space *= grid->h[d] * (grid->periodic[d] ? 1
                                               : MPMBasisIntegral(patch->basis, MPMGridFold(grid, d, ijk[d]),
                                                                  grid->cells[d], grid->wall_basis[d]));
    for (PetscInt c = 0; c < nc; c++) motion[c] = 0;
    motion[0] = space > 0 ? n->m / space : 1;
    motion[1] = n->p[0] > 0 ? n->p[1] / n->p[0] : 0;
    if (nc > 2) motion[2] = n->m > 0 ? n->p[2] / n->m : 0;
  }
}

PetscErrorCode MPMVolumesStep(MPMCore *core, const MPMStatus *last)
{
  MPMVolumes     *v = &core->volumes;
  const PetscReal h = MPMGridSmallestH(&core->grid), dt = core->params.dt, since = v->since;
  PetscReal       g2 = 0;

  PetscFunctionBeginUser;
  v->since = since + dt;
  if (since * v->sound < CROSSED * h || !(v->fluids || last->opened)) PetscFunctionReturn(PETSC_SUCCESS);
  v->since = dt;
  for (PetscInt d = 0; d < core->grid.dim; d++) g2 += PetscSqr(core->params.gravity[d]);
  core->params.push = PetscMin(
      PUSH, FASTER * (PetscSqrtReal(last->v2) + AT_REST * PetscSqrtReal(PetscSqrtReal(g2) * h)) * since / h);
  if (core->energy.on) PetscCall(MPMEnergyVolumes(core, -1));
  for (PetscInt k = 0; k < core->nrare; k++) PetscCall(MPMPhaseRun(core, core->program[core->nprogram + k]));
  if (core->energy.on) PetscCall(MPMEnergyVolumes(core, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}
