/* output_fields.c - what a snapshot holds of the particles: the table of fields, and how each row is filled. A new
   field is a function and a row here. */
#include "mpm.h"

static const MPMKind *KindOf(MPM mpm, const MPMView *v, PetscInt p)
{
  return &mpm->scene.kinds[v->kind ? v->kind[p] : 0];
}

static const MPMMaterial *MaterialOf(MPM mpm, const MPMView *v, PetscInt p)
{
  return &mpm->scene.materials[KindOf(mpm, v, p)->material];
}

/* Volume over that of the start. */
static PetscReal Jacobian(MPM mpm, const MPMView *v, PetscInt p)
{
  const PetscInt dim = mpm->grid.dim;

  return MaterialOf(mpm, v, p)->state & MPM_BIT(F) ? MPMDet((int)dim, v->F + p * dim * dim) : v->J[p];
}

static void FillId(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  (void)mpm;
  row[0] = (PetscReal)v->id[p]; /* exact below 2^53 */
}

static void FillX(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  for (PetscInt d = 0; d < 3; d++) row[d] = d < mpm->grid.dim ? v->x[p * mpm->grid.dim + d] : 0;
}

static void FillV(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  for (PetscInt d = 0; d < 3; d++) row[d] = d < mpm->grid.dim ? v->v[p * mpm->grid.dim + d] : 0;
}

/* Materials without F carry J: then F shows the same volume, J^(1/dim) I. */
static void FillF(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt dim = mpm->grid.dim;

  if (!(MaterialOf(mpm, v, p)->state & MPM_BIT(F))) {
    for (PetscInt k = 0; k < 9; k++) row[k] = k % 4 ? 0 : k / 4 < dim ? PetscPowReal(v->J[p], 1 / (PetscReal)dim) : 1;
    return;
  }
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) row[3 * d + e] = d < dim && e < dim ? v->F[(p * dim + d) * dim + e] : d == e;
}

/* Cauchy stress, sig = tau/J. */
static void FillStress(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt     dim = mpm->grid.dim;
  const MPMMaterial *m   = MaterialOf(mpm, v, p);
  MPMBlock           b;

  MPMParticlesState(dim, v, p, &b);
  if (!(m->state & MPM_BIT(tau))) m->type->law->stress[dim - 1](m, 0, 1, &b);
  for (PetscInt k = 0; k < MPM_STRESS_NC; k++) row[k] = 0;
  for (PetscInt k = 0; k < MPM_SYM_NC(dim); k++) row[MPMSymPlace((int)dim, (int)k)] = b.tau[k][0] / Jacobian(mpm, v, p);
}

static void FillVolume(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = KindOf(mpm, v, p)->V0 * Jacobian(mpm, v, p);
}

/* Equivalent plastic strain; 0 of materials without. */
static void FillPlastic(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = MaterialOf(mpm, v, p)->state & MPM_BIT(ep) ? v->ep[p] : 0;
}

static void FillBody(MPM mpm, const MPMView *v, PetscInt p, PetscReal row[])
{
  PetscInt b = 0;

  while (v->id[p] >= mpm->scene.bodies[b].first + mpm->scene.bodies[b].n) b++;
  row[0] = b;
}

const MPMOutputField MPMOutputFields[] = {
    {"id", NULL, "1", "", 1, PETSC_TRUE, 0, FillId},
    {"x", NULL, "m", "x y z", 3, PETSC_FALSE, 0, FillX},
    {"v", "velocity", "m/s", "x y z", 3, PETSC_FALSE, 0, FillV},
    {"F", "F", "1", "xx xy xz yx yy yz zx zy zz", 9, PETSC_FALSE, 0, FillF},
    {"stress", "stress", "Pa", "xx xy xz yy yz zz", 6, PETSC_FALSE, 0, FillStress},
    {"volume", "volume", "m^3", "", 1, PETSC_FALSE, 0, FillVolume},
    {"plastic_strain", "plastic", "1", "", 1, PETSC_FALSE, MPM_BIT(ep), FillPlastic},
    {"body", "body", "1", "", 1, PETSC_TRUE, 0, FillBody},
    {NULL, NULL, NULL, NULL, 0, PETSC_FALSE, 0, NULL},
};

/* Reads -output_fields a,b,...: words of the table, and grid. set: was it given? */
PetscErrorCode MPMOutputReadFields(MPM mpm, MPMOptions o, PetscBool *set)
{
  char     text[MPM_TEXT_LEN] = "", *save = NULL;
  PetscInt has = 0; /* fields that a material of the scene carries */

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++) has |= mpm->scene.materials[k].state;
  mpm->output.fields = -1;
  for (PetscInt f = 0; MPMOutputFields[f].name; f++)
    if (MPMOutputFields[f].needs & ~has) mpm->output.fields &= ~(1 << f);
  PetscCall(MPMOptionsString(o, "output_fields", NULL, text, set));
  if (!*set || !strcmp(text, "all")) PetscFunctionReturn(PETSC_SUCCESS);
  mpm->output.fields = 3; /* id, x */
  for (char *w = strtok_r(text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    PetscInt f = 0;

    while (MPMOutputFields[f].name && (!MPMOutputFields[f].option || strcmp(MPMOutputFields[f].option, w))) f++;
    if (!MPMOutputFields[f].name && strcmp(w, "grid"))
      MPMOptionsFail(o, "-output_fields %s: choose among all, or a list of velocity,F,stress,volume,plastic,body,grid",
                     w);
    if (MPMOutputFields[f].name && (MPMOutputFields[f].needs & ~has))
      MPMOptionsFail(o, "-output_fields %s: no material of this scene has it", w);
    mpm->output.fields |= MPMOutputFields[f].name ? 1 << f : MPM_OUTPUT_GRID;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
