/* volume.c - when volumes relax (kernels/volume.h), by how much, and what the nodes do in between. It happens before
   the phases of a step, each time after sound has crossed two cells, so that it depends neither on dt nor on the
   processes; if only sand relaxes, then after steps at whose end some was open. Other scenes have none of it.
   docs/method.md has the formulas. */
#include "parallel/exchange.h"
#include "physics/rigid.h"
#include "physics/wall.h"
#include "step/step.h"

#define CROSSED 2.   /* cells that sound crosses between two relaxations of rate 1 */
#define FASTER  0.5  /* share of the mismatch that goes while the fastest particle crosses a cell */
#define AT_REST 0.2  /* speed that is added to that of the fastest one, of sqrt(g h) */
#define PUSH    0.04 /* largest share at a time */
#define FULL    0.8  /* density from which on a node whose function a piston cuts counts as full, and not as more */

/* Returns the speed of sound, m/s, of a material that relaxes, times its rate; 0 of others: of sand in 1-D, where a
   node has no room for what it needs, with dilation, since then the density does not tell what is open, and beside
   fluids that relax, whose pressure is another. */
static PetscReal Sound(const MPMMaterial *m, PetscInt dim, PetscBool fluids)
{
  const PetscBool sand = m->state & MPM_BIT(vc) && dim > 1 && !(m->dilation > 0) && !fluids;

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
  return core->volumes.sound > 0;
}

/* Returns the integral from `from` to `to`, in cells, of the function of node i of axis d. */
static PetscReal Between(MPMBasis basis, const MPMGrid *grid, PetscInt d, PetscInt i, PetscReal from, PetscReal to)
{
  static const PetscReal at[] = {-0.774596669241483377, 0, 0.774596669241483377}, weight[] = {5. / 18, 4. / 9, 5. / 18};
  const MPMBasis         hats = basis == MPM_BASIS_gimp ? MPM_BASIS_linear : basis;
  PetscReal              sum  = 0;

  from = PetscMax(from, (PetscReal)(i - 2));
  to   = PetscMin(to, (PetscReal)(i + 2));
  for (PetscReal begin = from, end; begin < to; begin = end) {
    end = PetscMin(to, 0.5 * PetscFloorReal(2 * begin) + 0.5); /* splines are polynomials on each half of a cell */
    for (int q = 0; q < 3; q++) {
      PetscReal      xi   = 0.5 * (begin + end) + 0.5 * (end - begin) * at[q], w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
      const PetscInt base = MPMBasisBase(hats, &xi, 0, grid->cells[d], PETSC_FALSE, grid->wall_basis[d]);

      MPMBasisWeights(hats, xi, 0, base, grid->cells[d], grid->wall_basis[d], w, g);
      if (i >= base && i < base + MPMBasisNodes(hats)) sum += (end - begin) * weight[q] * w[i - base];
    }
  }
  return sum;
}

/* Returns the integral, in cells, of the function of node i of axis d over the part of the grid that is before the
   pistons, 0 behind them. Sets *cut if the plane of one cuts it. */
static PetscReal Room(const MPMParams *par, const MPMPatch *patch, PetscInt d, PetscInt i, PetscBool *cut)
{
  const MPMGrid *grid = patch->grid;
  PetscBool      here = PETSC_FALSE;
  PetscReal      end[2];

  if (grid->periodic[d]) return 1;
  for (PetscInt side = 0; side < 2 && par->planes; side++) {
    const MPMFace  *f  = &par->walls->given[d][side];
    const PetscReal at = par->walls->place[2 * d + side] / grid->h[d];

    end[side] = side ? (PetscReal)grid->cells[d] - at : at;
    if (f->type == MPM_WALL_piston && (side ? grid->cells[d] - i : i) <= f->reach + f->beside) *cut = here = PETSC_TRUE;
  }
  return here ? Between(patch->basis, grid, d, i, end[0], end[1])
              : MPMBasisIntegral(patch->basis, i, grid->cells[d], grid->wall_basis[d]);
}

void MPMNodesVolume(const MPMParams *par, const MPMPatch *patch, const MPMNodes *r)
{
  const MPMGrid *grid = patch->grid;
  const PetscInt dim = grid->dim, nc = MPM_MOTION_NC(dim);

  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n      = r->sum + i;
    PetscReal     *motion = r->motion + i * nc, space = 1;
    const PetscInt ijk[3] = {r->ijk[0] + i, r->ijk[1], r->ijk[2]};
    PetscBool      cut    = PETSC_FALSE;

    for (PetscInt d = 0; d < dim; d++) space *= grid->h[d] * Room(par, patch, d, MPMGridFold(grid, d, ijk[d]), &cut);
    for (PetscInt c = 0; c < nc; c++) motion[c] = 0;
    motion[0] = space > 0 ? n->m / space : 1;
    if (cut) motion[0] = PetscMin(1, motion[0] / FULL);
    motion[1] = n->p[0] > 0 ? n->p[1] / n->p[0] : 0;
    if (nc > 2) motion[2] = n->m > 0 ? n->p[2] / n->m : 0;
  }
}

/* Returns the share of the function of a node that is before a plane, whose distance is t cells, below 0 if the node is
   behind it: by a curve that is within a fifth of the integrals of all bases where they matter. */
static PetscReal ShareBefore(MPMBasis basis, PetscReal t)
{
  const PetscReal half = MPMBasisIsSpline(basis) ? MPMBasisNodes(basis) > 3 ? 1.4 : 1.2 : 1;
  const PetscReal u    = PetscClipInterval(0.5 * (t / half + 1), 0, 1);

  return u * u * (3 - 2 * u);
}

/* Returns the share of the function of a node at x that is outside of a rigid body: all of it, if matter may be in the
   body, or if it is far from it. */
static PetscReal ShareBeside(const MPMCore *core, const MPMRigid *r, const PetscReal x[])
{
  const MPMGrid *grid = &core->grid;
  PetscReal      n[3] = {0}, h2 = 0, away2 = 0, reach2 = 0, distance;

  if (r->gone || r->tied) return 1;
  for (PetscInt d = 0; d < grid->dim; d++) {
    away2 += PetscSqr(x[d] - r->pivot[d] - r->place[d]);
    reach2 += PetscSqr(MPM_MAX_STENCIL * grid->h[d]);
  }
  if (away2 > PetscSqr(r->reach + PetscSqrtReal(reach2))) return 1;
  distance = MPMRigidDistance(r, grid->dim, x, n);
  for (PetscInt d = 0; d < grid->dim; d++) h2 += PetscSqr(n[d] * grid->h[d]);
  if (h2 > 0) return ShareBefore(core->basis, distance / PetscSqrtReal(h2));
  return distance > 0 ? 1 : 0;
}

/* Does at the surfaces of rigid bodies what MPMNodesVolume does at pistons. */
PetscErrorCode MPMVolumesAfter(MPMCore *core, const MPMPhase *phase)
{
  const MPMGrid *grid = &core->grid;

  PetscFunctionBeginUser;
  (void)phase;
  MPM_FOR_OWN_ROWS(&core->exchange.patch, r)
  for (PetscInt i = r.first; i < r.last; i++) {
    PetscInt  ijk[3] = {r.ijk[0] + i, r.ijk[1], r.ijk[2]};
    PetscReal x[3], share = 1, *full = r.motion + i * MPM_MOTION_NC(grid->dim);

    for (PetscInt d = 0; d < grid->dim; d++) ijk[d] = MPMGridFold(grid, d, ijk[d]);
    MPMGridNodeAt(grid, ijk, x);
    for (PetscInt b = 0; b < core->rigids.n; b++) share *= ShareBeside(core, &core->rigids.body[b], x);
    if (share < 1) *full = share > 0 ? PetscMin(1, *full / (FULL * share)) : 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
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
