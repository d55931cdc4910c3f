/* unit_transfer.c - the kernels of transfer.h on small patches made by hand: every phase of every integrator, in every
   dimension and basis. What is checked: conservation and moments, each node against plain loops in long double, linear
   fields, and that bits depend neither on the order of storage, nor on what is own and what is halo, nor on how the
   grid is cut. Views hold just the fields that a phase declares, so a kernel that reads another one crashes here.      */
#include "transfer.h"
#include "unit.h"

#define N         150 /* points: two blocks and a part */
#define MAX_NODES 4000
#define NC        (MPM_SUM_NC(3))

typedef struct {
  PetscInt n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) ctype name[9 * N];
#include "fields.def"
#undef MPM_FIELD
} State;

typedef struct {
  MPMPatch  patch;
  State     own, halo;
  PetscInt  order[N], own_order[N];
  PetscReal sum[MAX_NODES * NC], vel[MAX_NODES * NC];
  char      row[MAX_NODES];
} Bench;

static MPMMaterial materials[8];
static MPMKind     kinds[8];
static PetscInt    nkinds;
static MPMWall     walls[3][2];

/* ---- Making of scenes */
static void CopyPoint(int dim, const State *from, PetscInt p, State *to)
{
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) \
  memcpy(to->name + to->n * (nc), from->name + p * (nc), (nc) * sizeof(ctype));
#include "fields.def"
#undef MPM_FIELD
  to->n++;
}

static MPMView View(State *s, PetscInt fields, const MPMParams *par)
{
  MPMView view;

  memset(&view, 0, sizeof view);
  view.n = s->n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) view.name = fields & MPM_BIT(name) ? s->name : NULL;
#include "fields.def"
#undef MPM_FIELD
  if (par->nkinds == 1) view.kind = NULL; /* such a scene has no field kind */
  return view;
}

static MPMGrid Grid(int dim, MPMBasis basis, int odd)
{
  static const PetscInt cells[3] = {4, 3, 5};
  MPMGrid               g;

  memset(&g, 0, sizeof g);
  g.dim    = dim;
  for (int d = 0; d < 3; d++) {
    g.cells[d] = d < dim ? cells[d] : 0;
    g.lower[d] = odd ? 0.3 * d - 0.7 : -0.5;
    g.upper[d] = g.lower[d] + (odd ? 0.1 * cells[d] + 0.01 * d : 0.25 * cells[d]);
    g.h[d]     = d < dim ? (g.upper[d] - g.lower[d]) / cells[d] : 1;
  }
  MPMGridSetNodes(&g, basis);
  return g;
}

/* n points: anywhere, on nodes, on edges and faces of cells, on walls. Ids in random order, with gaps. */
static void Points(State *s, const MPMGrid *g, MPMBasis basis, int n)
{
  const int dim = (int)g->dim;

  memset(s, 0, sizeof *s);
  s->n = n;
  for (int p = 0; p < n; p++) {
    PetscReal *x = s->x + p * dim, xi[3];
    PetscInt   base[3];

    for (int d = 0; d < dim; d++) {
      const int where = p % 4 == 0 ? 1 : UnitInt(6); /* every fourth on a node, the others on one on some axes */
      x[d] = UnitReal(g->lower[d], g->upper[d]);
      if (where == 1) x[d] = g->lower[d] + UnitInt((int)g->cells[d] + 1) * g->h[d];
      if (where == 2) x[d] = UnitInt(2) ? g->lower[d] : g->upper[d];
      while (!MPMLocate(1, basis, &(MPMGrid){.cells = {g->cells[d]}, .lower = {g->lower[d]}, .upper = {g->upper[d]}, .h = {g->h[d]}}, x + d, xi, base)) x[d] = nextafter(x[d], g->lower[d] + g->h[d]);
      s->v[p * dim + d]  = UnitReal(-1, 1);
      s->dx[p * dim + d] = UnitReal(-0.3, 0.3) * g->h[d];
    }
    do
      for (int k = 0; k < dim * dim; k++) s->F[p * dim * dim + k] = (k % (dim + 1) == 0) + UnitReal(-0.3, 0.3);
    while (!(MPMDet(dim, s->F + p * dim * dim) > 0.3));
    s->kind[p] = UnitInt((int)nkinds);
    s->id[p]   = 7 * p + 3;
  }
  for (int p = n - 1; p > 0; p--) {
    const int        q = UnitInt(p + 1);
    const PetscInt64 t = s->id[p];
    s->id[p]           = s->id[q];
    s->id[q]           = t;
  }
}

static void Permute(int dim, State *s)
{
  static State copy;
  PetscInt     from[N];

  copy = *s;
  for (int p = 0; p < s->n; p++) from[p] = p;
  for (int p = (int)s->n - 1; p > 0; p--) {
    const int      q = UnitInt(p + 1);
    const PetscInt t = from[p];
    from[p]          = from[q];
    from[q]          = t;
  }
  s->n = 0;
  for (int p = 0; p < copy.n; p++) CopyPoint(dim, &copy, from[p], s);
}

/* Sorts order by (cell, id), the slow and sure way. */
static void Sort(PetscInt n, PetscInt *order, const PetscInt *cell, const PetscInt64 *id)
{
  for (PetscInt q = 1; q < n; q++) {
    const PetscInt p = order[q];
    PetscInt       r = q;

    for (; r > 0 && (cell[order[r - 1]] > cell[p] || (cell[order[r - 1]] == cell[p] && id[order[r - 1]] > id[p])); r--) order[r] = order[r - 1];
    order[r] = p;
  }
}

/* The patch that owns the nodes own_lo .. own_lo + own_n - 1 (NULL: all), with all points that touch them; those of
   other cells, and a share of the others if told, lie in the halo view.                                              */
static void SetUp(Bench *b, const MPMGrid *g, MPMBasis basis, const State *s, const PetscInt *own_lo, const PetscInt *own_n, int share)
{
  const int  dim = (int)g->dim, reach = MPMBasisNodes(basis) - 1;
  MPMPatch  *patch = &b->patch;
  PetscInt   cell[N];
  PetscInt64 id[N];

  memset(b, 0, sizeof *b);
  patch->grid  = g;
  patch->basis = basis;
  for (int d = 0; d < 3; d++) {
    const PetscInt first = -g->layers[d], last = g->cells[d] + g->layers[d];

    patch->n[d] = patch->own_n[d] = 1;
    if (d >= dim) continue;
    patch->own_lo[d] = own_lo ? own_lo[d] : first;
    patch->own_n[d]  = own_lo ? own_n[d] : last - first + 1;
    patch->lo[d]     = PetscMax(first, patch->own_lo[d] - reach);
    patch->n[d]      = PetscMin(last, patch->own_lo[d] + patch->own_n[d] - 1 + reach) - patch->lo[d] + 1;
  }
  patch->sum = b->sum;
  patch->vel = b->vel;
  patch->row = b->row;
  memset(b->row, 1, sizeof b->row);
  for (int pass = 0; pass < 2; pass++) { /* own points, then those of the halo */
    uint64_t coin = 12345;

    for (PetscInt p = 0; p < s->n; p++) {
      PetscReal xi[3];
      PetscInt  base[3];
      int       own = 1, touches = 1;

      MPMLocate(dim, basis, g, s->x + p * dim, xi, base);
      for (int d = 0; d < dim; d++) {
        if (base[d] < patch->own_lo[d]) own = 0;
        if (base[d] < patch->own_lo[d] - reach) touches = 0;
        if (base[d] >= patch->own_lo[d] + patch->own_n[d]) own = touches = 0;
      }
      coin = coin * 6364136223846793005ULL + 1442695040888963407ULL;
      if (share && (coin >> 60) % 3 == 0) own = 0;
      if (!touches || own == pass) continue;
      CopyPoint(dim, s, p, pass ? &b->halo : &b->own);
      {
        const PetscInt q = b->own.n + b->halo.n - 1;

        cell[q] = MPMNodeIndex(dim, patch, base);
        id[q]   = s->id[p];
        if (!pass) b->own.cell[q] = cell[q];
        b->order[q] = q;
        if (!pass) b->own_order[q] = q;
      }
    }
  }
  patch->norder = b->own.n + b->halo.n;
  Sort(patch->norder, b->order, cell, id);
  Sort(b->own.n, b->own_order, cell, id);
  patch->order     = b->order;
  patch->own_order = b->own_order;
}

static MPMStatus Run(Bench *b, const MPMParams *par, const MPMPhase *phase)
{
  const MPMTransfer run = MPMTransferFind(b->patch.grid->dim, b->patch.basis, phase->parts);
  MPMStatus         status;

  MPMStatusReset(&status);
  b->patch.points = View(&b->own, phase->points_in | phase->points_out, par);
  b->patch.halo   = View(&b->halo, phase->points_in, par);
  CHECK(run != NULL);
  if (run) run(par, &b->patch, &status);
  return status;
}

static PetscInt Nodes(const MPMPatch *patch)
{
  return patch->n[0] * patch->n[1] * patch->n[2];
}

/* Node c of the arrays of the patch. */
static void NodeOf(const MPMPatch *patch, PetscInt c, PetscInt ijk[3])
{
  for (int d = 0; d < 3; d++) {
    ijk[d] = c % patch->n[d] + patch->lo[d];
    c /= patch->n[d];
  }
}

static int Components(int dim, PetscInt parts, int *c0)
{
  *c0 = parts & MPM_P2G_MASS ? 0 : parts & MPM_P2G_MOMENTUM ? 1 : 1 + dim;
  return parts & MPM_P2G_FORCE ? MPM_SUM_NC(dim) : 1 + dim;
}

/* ---- Points to nodes */

/* Each node by plain loops over all points, and the totals. */
static void CheckSums(const Bench *b, const State *s, const MPMParams *par, PetscInt parts)
{
  static long double ref[MAX_NODES * NC], size[MAX_NODES * NC];
  const MPMPatch    *patch = &b->patch;
  const MPMGrid     *g     = patch->grid;
  const int          dim = (int)g->dim, nc = MPM_SUM_NC(dim), ns = MPMBasisNodes(patch->basis);
  int                c0, c1 = Components(dim, parts, &c0);
  long double        total[NC] = {0}, points[NC] = {0}, sizes[NC] = {0}, xm[3] = {0}, xmp[3] = {0}, virial[9] = {0}, virialp[9] = {0}, force = 0, stress = 0, mass = 0;

  memset(ref, 0, sizeof ref);
  memset(size, 0, sizeof size);
  for (PetscInt p = 0; p < s->n; p++) {
    const MPMKind     *k = par->kinds + (par->nkinds > 1 ? s->kind[p] : 0);
    const MPMMaterial *m = par->materials + k->material;
    PetscReal          F[9 * MPM_BLOCK], tau[6 * MPM_BLOCK], w[3][MPM_MAX_STENCIL], grad[3][MPM_MAX_STENCIL];
    PetscInt           base[3] = {0};

    for (int c = 0; c < dim * dim; c++) F[c * MPM_BLOCK] = s->F[p * dim * dim + c];
    m->type->law->stress[dim - 1](m, 1, F, tau);
    for (int d = 0; d < dim; d++) {
      const PetscReal xi = (s->x[p * dim + d] - g->lower[d]) / g->h[d];
      base[d]            = MPMBasisBase(patch->basis, xi, g->cells[d]);
      MPMBasisWeights(patch->basis, xi, base[d], g->cells[d], w[d], grad[d]);
    }
    for (int a = 0; a < MPMStencilSize(dim, patch->basis); a++) {
      const int      i[3]   = {a % ns, a / ns % ns, a / ns / ns};
      const PetscInt ijk[3] = {base[0] + i[0], base[1] + i[1], base[2] + i[2]}, at = MPMNodeIndex(dim, patch, ijk) * nc;
      long double    phi = 1, dphi[3], term[NC];

      for (int d = 0; d < dim; d++) {
        phi *= w[d][i[d]];
        dphi[d] = 1;
        for (int e = 0; e < dim; e++) dphi[d] *= e == d ? (long double)grad[e][i[e]] / g->h[e] : w[e][i[e]];
      }
      term[0] = phi * k->m;
      for (int d = 0; d < dim; d++) {
        term[1 + d]       = phi * k->m * s->v[p * dim + d];
        term[1 + dim + d] = 0;
        for (int e = 0; e < dim; e++) {
          const long double f = (long double)-k->V0 * tau[MPMSymIndex(d, e) * MPM_BLOCK] * dphi[e];
          term[1 + dim + d] += f;
          size[at + 1 + dim + d] += fabsl(f);
          force += fabsl(f);
        }
      }
      for (int c = 0; c < nc; c++) {
        ref[at + c] += term[c];
        if (c < 1 + dim) size[at + c] += fabsl(term[c]);
      }
    }
    mass += k->m;
    points[0] += k->m;
    sizes[0] += k->m;
    for (int d = 0; d < dim; d++) {
      points[1 + d] += (long double)k->m * s->v[p * dim + d];
      sizes[1 + d] += fabsl((long double)k->m * s->v[p * dim + d]);
      xmp[d] += (long double)k->m * (s->x[p * dim + d] - g->lower[d]);
      for (int e = 0; e < dim; e++) {
        virialp[d * dim + e] -= (long double)k->V0 * tau[MPMSymIndex(d, e) * MPM_BLOCK];
        stress += fabsl((long double)k->V0 * tau[MPMSymIndex(d, e) * MPM_BLOCK]);
      }
    }
  }
  for (PetscInt c = 0; c < Nodes(patch); c++) {
    PetscInt ijk[3];

    NodeOf(patch, c, ijk);
    for (int k = 0; k < nc; k++) {
      const PetscReal value = b->sum[c * nc + k];

      if (k < c0 || k >= c1) {
        CHECK_EQ(value, -777); /* not asked for: untouched */
        continue;
      }
      total[k] += value;
      CHECK_LE(fabsl(value - ref[c * nc + k]), 1e-14L * size[c * nc + k]);
    }
    for (int d = 0; d < dim; d++) {
      if (parts & MPM_P2G_MASS) xm[d] += (long double)b->sum[c * nc] * ijk[d] * g->h[d];
      if (parts & MPM_P2G_FORCE)
        for (int e = 0; e < dim; e++) virial[d * dim + e] += (long double)b->sum[c * nc + 1 + dim + d] * ijk[e] * g->h[e];
    }
  }
  for (int k = c0; k < PetscMin(c1, 1 + dim); k++) CHECK_LE(fabsl(total[k] - points[k]), 1e-14L * sizes[k]); /* mass, momentum */
  for (int d = 0; d < dim; d++) {
    if (parts & MPM_P2G_MASS) CHECK_LE(fabsl(xm[d] - xmp[d]), 1e-14L * mass * (g->upper[d] - g->lower[d])); /* centre of mass */
    if (parts & MPM_P2G_FORCE) {
      CHECK_LE(fabsl(total[1 + dim + d]), 1e-13L * force); /* no force from within */
      /* sum f (x) x = - sum V sig, hence no torque either; the stress makes all of the force */
      for (int e = 0; e < dim; e++) CHECK_LE(fabsl(virial[d * dim + e] - virialp[d * dim + e]), 1e-13L * (stress + force * (g->upper[e] - g->lower[e])));
    }
  }
}

/* Runs a phase to nodes on zeroed sums; what it is not asked for holds -777. */
static void RunSums(Bench *b, const MPMParams *par, const MPMPhase *phase)
{
  const int dim = (int)b->patch.grid->dim, nc = MPM_SUM_NC(dim);
  int       c0, c1 = Components(dim, phase->parts, &c0);

  for (PetscInt c = 0; c < Nodes(&b->patch); c++)
    for (int k = 0; k < nc; k++) b->sum[c * nc + k] = k < c0 || k >= c1 ? -777 : 0;
  Run(b, par, phase);
}

/* ---- Nodes to points */

typedef struct {
  PetscReal A[9], b[3], C[9], c[3]; /* v = A x + b, a = C x + c */
} Fields;

static void SetFields(Bench *b, const Fields *f)
{
  const MPMPatch *patch = &b->patch;
  const MPMGrid  *g     = patch->grid;
  const int       dim   = (int)g->dim;

  for (PetscInt n = 0; n < Nodes(patch); n++) {
    PetscReal *v = b->vel + n * MPM_VEL_NC(dim);
    PetscInt   ijk[3];

    NodeOf(patch, n, ijk);
    for (int d = 0; d < dim; d++) {
      long double vd = f->b[d], ad = f->c[d];
      for (int e = 0; e < dim; e++) {
        const long double x = g->lower[e] + (long double)ijk[e] * g->h[e];
        vd += f->A[d * dim + e] * x;
        ad += f->C[d * dim + e] * x;
      }
      v[d]       = (PetscReal)vd;
      v[dim + d] = (PetscReal)ad;
    }
  }
}

static void RandomFields(Fields *f, PetscReal size)
{
  for (int k = 0; k < 9; k++) {
    f->A[k] = UnitReal(-size, size);
    f->C[k] = UnitReal(-1, 1);
  }
  for (int d = 0; d < 3; d++) {
    f->b[d] = UnitReal(-0.1, 0.1);
    f->c[d] = UnitReal(-1, 1);
  }
}

/* A linear field on the nodes of a patch of all points: exact v, displacement, gradient; status. */
static void CheckLinear(Bench *b, const State *before, const MPMParams *par, const MPMPhase *phase, const Fields *f)
{
  const MPMGrid  *g      = b->patch.grid;
  const int       dim    = (int)g->dim;
  const PetscInt  parts  = phase->parts;
  const MPMStatus status = Run(b, par, phase);
  PetscReal       v2 = 0, c2 = 0;
  PetscInt64      moved = 0, bad = -1;

  for (PetscInt p = 0; p < b->own.n; p++) {
    const PetscReal *x0 = before->x + p * dim, *v0 = before->v + p * dim, *F0 = before->F + p * dim * dim;
    const PetscReal *F  = b->own.F + p * dim * dim, *v = b->own.v + p * dim;
    PetscReal        dx[3], xi[3], speed = 0, wave, block[9 * MPM_BLOCK];
    PetscInt         base[3];

    CHECK_EQ(b->own.id[p], before->id[p]);
    for (int d = 0; d < dim; d++) {
      PetscReal vx = f->b[d], ax = f->c[d];

      for (int e = 0; e < dim; e++) {
        vx += f->A[d * dim + e] * x0[e];
        ax += f->C[d * dim + e] * x0[e];
      }
      dx[d] = parts & MPM_G2P_MOTION ? par->dt * vx : before->dx[p * dim + d];
      if (parts & MPM_G2P_MOTION) CHECK_NEAR(v[d], par->flip * (v0[d] + par->dt * ax) + (1 - par->flip) * vx, 1e-14);
      else CHECK_EQ(v[d], v0[d]);
      if (parts & MPM_G2P_COMMIT) CHECK_NEAR(b->own.x[p * dim + d], x0[d] + dx[d], 1e-15);
      else CHECK_EQ(b->own.x[p * dim + d], x0[d]);
      if ((parts & MPM_G2P_MOTION) && !(parts & MPM_G2P_COMMIT)) CHECK_NEAR(b->own.dx[p * dim + d], dx[d], 1e-15);
      speed += v[d] * v[d];
    }
    for (int d = 0; d < dim; d++)
      for (int e = 0; e < dim; e++) { /* F = (I + dt A) F0; with F0 = I this is L itself */
        PetscReal s = F0[d * dim + e];

        for (int k = 0; k < dim; k++) s += par->dt * f->A[d * dim + k] * F0[k * dim + e];
        if (parts & MPM_G2P_STRESS) CHECK_NEAR(F[d * dim + e], s, 1e-12 * par->dt);
        else CHECK_EQ(F[d * dim + e], F0[d * dim + e]);
      }
    if (parts & MPM_G2P_STRESS) {
      const MPMMaterial *m = par->materials + par->kinds[par->nkinds > 1 ? before->kind[p] : 0].material;

      for (int k = 0; k < dim * dim; k++) block[k * MPM_BLOCK] = F[k];
      m->type->law->speed2[dim - 1](m, 1, block, &wave);
      c2 = PetscMax(c2, wave);
      if (!(MPMDet(dim, F) > 0) && (bad < 0 || b->own.id[p] < bad)) bad = b->own.id[p];
    }
    v2 = PetscMax(v2, speed);
    if (parts & MPM_G2P_COMMIT) {
      if (MPMLocate(dim, b->patch.basis, g, b->own.x + p * dim, xi, base)) {
        CHECK_EQ(b->own.cell[p], MPMNodeIndex(dim, &b->patch, base));
        moved += MPMNodeIndex(dim, &b->patch, base) != before->cell[p];
      } else {
        CHECK(b->own.cell[p] < 0);
        moved++;
        if (bad < 0 || b->own.id[p] < bad) bad = b->own.id[p];
      }
    } else CHECK_EQ(b->own.cell[p], before->cell[p]);
  }
  CHECK_EQ(status.bad != MPM_OK, bad >= 0);
  if (bad >= 0) CHECK_EQ(status.id, bad); /* the smallest id of all that went wrong */
  CHECK_EQ(status.moved, moved);
  if (parts & MPM_G2P_MOTION) CHECK_EQ(status.v2, v2);
  if (parts & MPM_G2P_STRESS) CHECK_EQ(status.c2, c2);
}

/* The same v everywhere: v of all points as PIC has it, and F is as it was. */
static void CheckRigid(Bench *b, const MPMGrid *g, MPMBasis basis, State *s, const MPMParams *par, const MPMPhase *phase)
{
  const int dim = (int)g->dim;
  Fields    f;

  memset(&f, 0, sizeof f);
  for (int d = 0; d < dim; d++) f.b[d] = UnitReal(-0.3, 0.3) * g->h[d] / par->dt;
  for (PetscInt p = 0; p < s->n; p++)
    for (int k = 0; k < dim * dim; k++) s->F[p * dim * dim + k] = k % (dim + 1) == 0;
  SetUp(b, g, basis, s, NULL, NULL, 0);
  SetFields(b, &f);
  Run(b, par, phase);
  for (PetscInt p = 0; p < b->own.n; p++)
    for (int k = 0; k < dim * dim; k++) CHECK_NEAR(b->own.F[p * dim * dim + k], k % (dim + 1) == 0, 1e-15);
}

/* Own points of b have the bits of the points of the same id in ref. The cell is a number of the patch: left out. */
static void CheckPoints(const Bench *b, const Bench *ref)
{
  const int dim = (int)b->patch.grid->dim;
  PetscInt  at[7 * N + 7];

  for (PetscInt p = 0; p < ref->own.n; p++) at[ref->own.id[p]] = p;
  for (PetscInt p = 0; p < b->own.n; p++) {
    const PetscInt q = at[b->own.id[p]];
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) \
  if (MPM_FIELD_INDEX_##name != MPM_FIELD_INDEX_cell) CHECK_SAME(b->own.name + p * (nc), ref->own.name + q * (nc), (nc) * sizeof(ctype));
#include "fields.def"
#undef MPM_FIELD
  }
}

/* After a commit `cell` names the cell if it is the patch's own, else it is negative; the latter are counted. */
static void CheckCells(const Bench *b, const MPMPhase *phase, MPMStatus status)
{
  const int  dim  = (int)b->patch.grid->dim;
  PetscInt64 left = 0;

  if (!(phase->parts & MPM_G2P_COMMIT)) return;
  for (PetscInt p = 0; p < b->own.n; p++) {
    PetscReal xi[3];
    PetscInt  base[3];
    int       own = MPMLocate(dim, b->patch.basis, b->patch.grid, b->own.x + p * dim, xi, base);

    for (int d = 0; d < dim && own; d++)
      if (base[d] < b->patch.own_lo[d] || base[d] > b->patch.own_lo[d] + b->patch.own_n[d] - 1) own = 0;
    left += !own;
    if (own) CHECK_EQ(b->own.cell[p], MPMNodeIndex(dim, &b->patch, base));
    else CHECK(b->own.cell[p] < 0);
  }
  CHECK_EQ(status.left, left);
}

/* ---- Bits */

/* One phase on the whole grid (ref) and then otherwise: stored otherwise, half as halo, the grid cut in two. */
static void CheckBits(const MPMGrid *g, MPMBasis basis, const State *s, const MPMParams *par, const MPMPhase *phase, const char *what)
{
  static Bench   ref, b;
  static State   other;
  const int      dim = (int)g->dim, to_nodes = phase->kind == MPM_POINTS_TO_NODES;
  const PetscInt sc = MPM_SUM_NC(dim), vc = MPM_VEL_NC(dim);

  SetUp(&ref, g, basis, s, NULL, NULL, 0);
  for (PetscInt k = 0; k < Nodes(&ref.patch) * vc; k++) ref.vel[k] = UnitReal(-0.2, 0.2);
  if (to_nodes) RunSums(&ref, par, phase);
  else Run(&ref, par, phase);

  UnitContext("%s, stored in another order", what);
  other = *s;
  Permute(dim, &other);
  SetUp(&b, g, basis, &other, NULL, NULL, 0);
  memcpy(b.vel, ref.vel, sizeof b.vel);
  if (to_nodes) {
    RunSums(&b, par, phase);
    CHECK_SAME(b.sum, ref.sum, Nodes(&ref.patch) * sc * sizeof(PetscReal));
  } else {
    Run(&b, par, phase);
    CheckPoints(&b, &ref);
  }

  if (to_nodes) {
    UnitContext("%s, a third in the halo view", what);
    SetUp(&b, g, basis, &other, NULL, NULL, 1);
    CHECK(s->n < 10 || (b.own.n && b.halo.n));
    RunSums(&b, par, phase);
    CHECK_SAME(b.sum, ref.sum, Nodes(&ref.patch) * sc * sizeof(PetscReal));
  }

  for (int axis = 0; axis < dim; axis++)
    for (PetscInt cut = 1; cut < ref.patch.n[axis]; cut++) {
      PetscInt own = 0;

      for (int side = 0; side < 2; side++) {
        PetscInt lo[3], n[3];

        for (int d = 0; d < 3; d++) {
          lo[d] = ref.patch.own_lo[d];
          n[d]  = ref.patch.own_n[d];
        }
        if (side) lo[axis] += cut;
        n[axis] = side ? n[axis] - cut : cut;
        UnitContext("%s, cut on axis %d after %d nodes, side %d", what, axis, (int)cut, side);
        SetUp(&b, g, basis, &other, lo, n, 0);
        own += b.own.n;
        for (PetscInt c = 0; c < Nodes(&b.patch); c++) {
          PetscInt ijk[3];

          NodeOf(&b.patch, c, ijk);
          memcpy(b.vel + c * vc, ref.vel + MPMNodeIndex(dim, &ref.patch, ijk) * vc, vc * sizeof(PetscReal));
        }
        if (!to_nodes) {
          CheckCells(&b, phase, Run(&b, par, phase));
          CheckPoints(&b, &ref);
          continue;
        }
        RunSums(&b, par, phase);
        for (PetscInt c = 0; c < Nodes(&b.patch); c++) {
          PetscInt ijk[3], mine = 1;

          NodeOf(&b.patch, c, ijk);
          for (int d = 0; d < dim; d++)
            if (ijk[d] < lo[d] || ijk[d] >= lo[d] + n[d]) mine = 0;
          if (mine) CHECK_SAME(b.sum + c * sc, ref.sum + MPMNodeIndex(dim, &ref.patch, ijk) * sc, sc * sizeof(PetscReal));
        }
      }
      CHECK_EQ(own, s->n); /* every point has one owner */
    }
}

/* Two kinds of the same material, and two copies of it, make no difference to the bits. */
static void CheckKinds(const MPMGrid *g, MPMBasis basis, const State *s, const MPMParams *par, const MPMPhase *phase)
{
  static Bench      one, two;
  const MPMMaterial copies[2] = {materials[0], materials[0]};
  const MPMKind     same[2]   = {{0, kinds[0].m, kinds[0].V0}, {1, kinds[0].m, kinds[0].V0}};
  MPMParams         a = *par, c = *par;
  MPMStatus         sa, sc;
  static State      state;

  state = *s;
  for (PetscInt p = 0; p < state.n; p++) state.kind[p] = UnitInt(2);
  a.nkinds    = 1;
  c.nkinds    = 2;
  c.kinds     = same;
  c.materials = copies;
  SetUp(&one, g, basis, &state, NULL, NULL, 0);
  for (PetscInt k = 0; k < Nodes(&one.patch) * MPM_VEL_NC(g->dim); k++) one.vel[k] = UnitReal(-0.2, 0.2);
  two = one;
  two.patch.order     = two.order;
  two.patch.own_order = two.own_order;
  two.patch.sum       = two.sum;
  two.patch.vel       = two.vel;
  sa                  = Run(&one, &a, phase);
  sc                  = Run(&two, &c, phase);
  CHECK_SAME(one.sum, two.sum, sizeof one.sum);
  CheckPoints(&two, &one);
  CHECK(sa.c2 == sc.c2 && sa.v2 == sc.v2 && sa.bad == sc.bad && sa.id == sc.id && sa.moved == sc.moved);
}

/* A position on the upper face is in the grid, in its last cell, with weights that are none of them negative, for every
   number of cells, though (upper - lower)/h need not be a whole number in floating point.                            */
static void UpperWall(MPMBasis basis)
{
  static const PetscReal lengths[] = {1, 0.7, 2.5, 3, 0.1};

  for (PetscInt cells = 1; cells <= 500; cells++)
    for (int k = 0; k < 5; k++) {
      MPMGrid   g = {.dim = 1, .cells = {cells}, .upper = {lengths[k]}, .h = {lengths[k] / (PetscReal)cells}};
      PetscReal xi[3] = {0}, w[MPM_MAX_STENCIL], grad[MPM_MAX_STENCIL];
      PetscInt  base[3] = {0};

      UnitContext("upper wall: grid 0 .. %g of %d cells, basis %d", lengths[k], (int)cells, (int)basis);
      CHECK(MPMLocate(1, basis, &g, g.upper, xi, base));
      CHECK_EQ(base[0], MPMBasisBase(basis, UnitStep((PetscReal)cells, -1), cells));
      if (base[0] != MPMBasisBase(basis, UnitStep((PetscReal)cells, -1), cells)) continue;
      MPMBasisWeights(basis, xi[0], base[0], cells, w, grad);
      for (int i = 0; i < MPMBasisNodes(basis); i++) CHECK_GE(w[i], 0);
    }
}

static void TestPhase(int dim, MPMBasis basis, const MPMPhase *phase, const char *integrator)
{
  static const int numbers[] = {N, 1, MPM_BLOCK - 1, MPM_BLOCK, MPM_BLOCK + 1, N};
  static Bench     b;
  static State     s, before;
  MPMParams        par = {.dt = 0.125, .flip = 1, .kinds = kinds, .nkinds = nkinds, .materials = materials, .walls = walls};

  UnitContext("%s %s, dim %d, basis %d", integrator, phase->name, dim, (int)basis);
  CHECK(MPMTransferFind(dim, basis, phase->parts) != NULL);
  CHECK(MPMTransferFlops(dim, basis, phase->parts) > 0);
  if (!MPMTransferFind(dim, basis, phase->parts)) return;
  for (int round = 0; round < 6; round++) {
    const MPMGrid g = Grid(dim, basis, round % 2);
    char          what[128];
    Fields        f;

    snprintf(what, sizeof what, "%s %s, dim %d, basis %d, %d points", integrator, phase->name, dim, (int)basis, numbers[round]);
    UnitContext("%s", what);
    par.flip = round < 2 ? 1 : round < 4 ? 0 : 0.9;
    Points(&s, &g, basis, numbers[round]);
    SetUp(&b, &g, basis, &s, NULL, NULL, 0);
    if (phase->kind == MPM_POINTS_TO_NODES) {
      RunSums(&b, &par, phase);
      CheckSums(&b, &s, &par, phase->parts);
    } else {
      for (int kind = 0; kind < 3; kind++) {
        UnitContext("%s, %s", what, kind == 0 ? "F = I" : kind == 1 ? "any F" : "det F turns negative");
        RandomFields(&f, 0.5);
        for (int d = 0; d < dim; d++)
          if (kind == 2) f.A[d * (dim + 1)] -= (d == 0 ? 20 : 0); /* 1 + dt A < 0 on one axis */
        SetUp(&b, &g, basis, &s, NULL, NULL, 0);
        if (kind == 0)
          for (PetscInt p = 0; p < b.own.n; p++)
            for (int k = 0; k < dim * dim; k++) b.own.F[p * dim * dim + k] = k % (dim + 1) == 0;
        SetFields(&b, &f);
        before = b.own;
        CheckLinear(&b, &before, &par, phase, &f);
      }
      UnitContext("%s, rigid translation", what);
      before = s;
      CheckRigid(&b, &g, basis, &before, &par, phase);
    }
    UnitContext("%s, kinds", what);
    CheckKinds(&g, basis, &s, &par, phase);
    CheckBits(&g, basis, &s, &par, phase, what);
  }
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name && nkinds < 6; type++) /* two kinds a material */
    for (int k = 0; k < 2; k++, nkinds++) {
      MPMMaterial *m = &materials[nkinds / 2];

      m->type       = type;
      m->rho        = 1000 + 100 * nkinds;
      m->E          = 3e4;
      m->nu         = 0.3;
      kinds[nkinds] = (MPMKind){.material = nkinds / 2, .m = UnitReal(1, 2), .V0 = UnitReal(1e-3, 2e-3)};
      MPMMaterialSetUp(m);
    }
  for (int b = 0; b < MPM_NUM_BASES; b++) {
    UpperWall((MPMBasis)b);
    for (int dim = 1; dim <= 3; dim++)
      for (int i = 0; MPMIntegrators[i]; i++)
        for (int k = 0; k < MPM_MAX_PHASES && MPMIntegrators[i]->phases[k]; k++)
          if (MPMIntegrators[i]->phases[k]->kind != MPM_NODES) TestPhase(dim, (MPMBasis)b, MPMIntegrators[i]->phases[k], MPMIntegrators[i]->name);
  }
  PetscCall(PetscFinalize());
  return UnitEnd();
}
