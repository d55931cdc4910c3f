/* unit_transfer.c - the kernels of transfer.h on small patches made by hand: every phase of every program that phases.c
   makes, in every dimension and basis, with walls and periodic. What is checked: each node and each particle against
   plain loops in long double, conservation of mass, momentum and (apic) angular momentum, affine fields, what xpic
   filters, and that bits depend neither on the number of lanes, nor on the order of storage, nor on how the grid is
   cut, with the messages of processes. Views hold just the fields that a phase declares, so a kernel that reads another
   one crashes here. Every number of lanes that the machine has is run: all are checked against the plain loops. */
#include "kernels/cell.h"
#include "kernels/transfer.h"
#include "particles/box.h"
#include "physics/wall.h"
#include "step/scheme.h"
#include "unit.h"
#include <sys/wait.h>
#include <unistd.h>

#define N           150 /* particles: two blocks and a part */
#define MAX_NODES   3000
#define MAX_BOXES   8
#define MAX_CELLS   8000
#define NC          (MPM_NODE_NC)
#define MAX_STENCIL (MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL) /* nodes of the widest stencil in 3-D */

typedef struct {
  PetscInt n;
#define dim                                                                    3 /* of which fields have the most components */
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) ctype name[(nc)*N];
#include "physics/fields.def"
#undef dim
} State;

typedef struct {
  MPMPatch  patch;
  State     own;
  MPMSpan   span[MAX_NODES];
  PetscInt  order[N], movers[N + 1], start[MAX_CELLS];
  PetscReal sum[MAX_NODES * NC], motion[MAX_NODES * NC]; /* sum: the records of the nodes, number by number */
  PetscReal met[MAX_NODES];
} Bench;

static MPMMaterial materials[8];
static MPMKind     kinds[8];
static PetscInt    nkinds, nmaterials;
static MPMWalls    walls;
static MPMCore     core; /* its needs, and the program that phases.c makes of a method */

/* ---- Widths: the tables of transfer.c, those that this processor can run, the widest first. */
typedef const MPMKernel Table[3][2];
#if defined(__x86_64__)
extern Table MPMKernels_8, MPMKernels_4;
#endif
extern Table MPMKernels_2;

static struct {
  PetscInt lanes;
  Table   *table;
} widths[3];
static int nwidths, width; /* of them, that Run takes */

static void FindWidths(void)
{
  const PetscInt most = MPMKernelWidth();

  CHECK(most == 8 || most == 4 || most == 2);
#if defined(__x86_64__)
  if (most >= 8) widths[nwidths].lanes = 8, widths[nwidths++].table = &MPMKernels_8;
  if (most >= 4) widths[nwidths].lanes = 4, widths[nwidths++].table = &MPMKernels_4;
#endif
  widths[nwidths].lanes = 2, widths[nwidths++].table = &MPMKernels_2;
  printf("lanes:");
  for (int w = 0; w < nwidths; w++) printf(" %d", (int)widths[w].lanes);
  printf("\n");
}

/* What a program that starts with this PEBBLE_VECTOR picks. Before MPI starts: it forks. */
static int Picked(const char *wish)
{
  int   status = 0;
  pid_t child;

  fflush(NULL);
  child = fork();
  if (!child) {
    if (wish)
      setenv("PEBBLE_VECTOR", wish, 1);
    else
      unsetenv("PEBBLE_VECTOR");
    _exit((int)MPMKernelWidth());
  }
  if (child > 0 && waitpid(child, &status, 0) != child) status = -1;
  CHECK(child > 0 && WIFEXITED(status));
  return WEXITSTATUS(status);
}

/* PEBBLE_VECTOR asks for fewer lanes, never for more than there are; what is no number of lanes asks for nothing. */
static void Wishes(void)
{
  static const char *const nothing[] = {"", "0", "1", "-4", "many", "8", "9", "64"};
  const int                most      = Picked(NULL);

  UnitContext("PEBBLE_VECTOR");
  for (size_t k = 0; k < sizeof nothing / sizeof nothing[0]; k++) CHECK_EQ(Picked(nothing[k]), most);
  CHECK_EQ(Picked("2"), 2);
  CHECK_EQ(Picked("3"), 2);
  CHECK_EQ(Picked("4"), PetscMin(4, most));
  CHECK_EQ(Picked("7"), PetscMin(4, most));
#if defined(__x86_64__)
  CHECK_EQ(most, !__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") ? 2
                 : !__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512dq") ||
                         !__builtin_cpu_supports("avx512vl") || !__builtin_cpu_supports("avx512bw")
                     ? 4
                     : 8);
#else
  CHECK_EQ(most, 2);
#endif
}

/* ---- Making of scenes */

/* The order of xpic and afmpm; 0: another transfer, and particles have no r. */
static void SetOrder(PetscInt order)
{
  core.params.order   = order;
  core.needs.residual = order ? PETSC_TRUE : PETSC_FALSE;
}

static void CopyParticle(int dim, const State *from, PetscInt p, State *to)
{
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  memcpy(to->name + to->n * (nc), from->name + p * (nc), (nc) * sizeof(ctype));
#include "physics/fields.def"
  to->n++;
}

static MPMView View(State *s, PetscInt fields, const MPMParams *par)
{
  MPMView view;

  memset(&view, 0, sizeof view);
  view.n = s->n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  view.name = fields & MPM_BIT(name) ? s->name : NULL;
#include "physics/fields.def"
  if (par->nkinds == 1) view.kind = NULL; /* fields that the scene has not */
  if (!core.grid.round) view.F33 = NULL;
  if (!core.needs.barred) view.bar = NULL;
  if (!core.needs.affine) view.C = NULL;
  if (!core.needs.stretched) view.l = NULL;
  if (!core.needs.residual) view.r = NULL;
  if (!core.needs.forced) view.b = NULL;
  return view;
}

/* Most axes end with a tile that is narrower than the others; several are too short to be cut. */
static MPMGrid Grid(int dim, MPMBasis basis, MPMWallBasis wall, int round)
{
  static const PetscInt cells[2][6] = {{23, 9, 5, 17, 4, 14}, {9, 7, 10, 5, 8, 6}};
  MPMGrid               g;

  memset(&g, 0, sizeof g);
  g.dim = dim;
  for (int d = 0; d < 3; d++) {
    const PetscInt n = cells[dim > 1][(round + d) % 6];

    g.cells[d]      = d < dim ? n : 0;
    g.lower[d]      = round % 2 ? 0.3 * d - 0.7 : -0.5;
    g.upper[d]      = g.lower[d] + (round % 2 ? 0.1 * n + 0.01 * d : 0.25 * n);
    g.h[d]          = d < dim ? (g.upper[d] - g.lower[d]) / n : 1;
    g.periodic[d]   = wall == MPM_WALL_BASIS_NONE && d < dim && d != 1; /* axis 1 keeps its walls */
    g.wall_basis[d] = g.periodic[d] ? MPM_WALL_BASIS_NONE : wall == MPM_WALL_BASIS_NONE ? MPM_WALL_BASIS_EXTRAP : wall;
  }
  MPMGridSetNodes(&g, basis);
  return g;
}

static const PetscReal *Widths(const State *s, PetscInt p, int dim)
{
  return core.needs.stretched ? s->l + p * dim : kinds[nkinds > 1 ? s->kind[p] : 0].l;
}

/* n particles: anywhere, on nodes, on edges and faces of cells, on walls; crowded: two thirds of them in one cell,
   which is more than a block. Ids in random order, with gaps. */
static void Particles(State *s, const MPMGrid *g, int n, int crowded)
{
  const int dim = (int)g->dim;

  memset(s, 0, sizeof *s);
  s->n = n;
  for (int p = 0; p < n; p++) {
    s->kind[p] = UnitInt((int)nkinds);
    s->id[p]   = 7 * p + 3;
    for (int d = 0; d < dim; d++) {
      PetscReal *x     = s->x + p * dim + d;
      const int  where = p % 4 == 0 ? 1 : UnitInt(6); /* every fourth on a node, the others on one on some axes */

      *x = UnitReal(g->lower[d], g->upper[d]);
      if (where == 1) *x = g->lower[d] + UnitInt((int)g->cells[d] + 1) * g->h[d];
      if (where == 2) *x = UnitInt(2) ? g->lower[d] : g->upper[d];
      if (crowded && p % 3) *x = g->lower[d] + UnitReal(1.05, 1.45) * g->h[d];
      *x = PetscMax(g->lower[d], PetscMin(g->upper[d], *x));
      if (g->periodic[d] && *x >= g->upper[d]) *x = g->lower[d];
      s->v[p * dim + d]  = UnitReal(-1, 1);
      s->r[p * dim + d]  = UnitReal(-1, 1);
      s->b[p * dim + d]  = UnitReal(-1, 1);
      s->dx[p * dim + d] = UnitReal(-0.3, 0.3) * g->h[d];
      s->l[p * dim + d]  = UnitInt(4) ? UnitReal(0.05, 0.5) : 0.5;
    }
    do
      for (int k = 0; k < dim * dim; k++) s->F[p * dim * dim + k] = (k % (dim + 1) == 0) + UnitReal(-0.3, 0.3);
    while (!(MPMDet(dim, s->F + p * dim * dim) > 0.3));
    for (int k = 0; k < dim * dim; k++) s->C[p * dim * dim + k] = UnitReal(-2, 2);
    for (int k = 0; k < MPM_SYM_NC(dim); k++) {
      s->be[p * MPM_SYM_NC(dim) + k]  = MPMSymUnit(dim, k) + UnitReal(-0.05, 0.05);
      s->tau[p * MPM_SYM_NC(dim) + k] = UnitReal(-1e3, 1e3);
    }
    s->J[p]  = UnitReal(0.8, 1.2);
    s->ep[p] = UnitReal(0, 0.1);
    s->vc[p] = UnitReal(0, 0.1);
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
  for (int p = 0; p < copy.n; p++) CopyParticle(dim, &copy, from[p], s);
}

/* Sorts order by (cell, id), the slow and sure way. */
static void Sort(PetscInt n, PetscInt *order, const PetscInt *cell, const PetscInt64 *id)
{
  for (PetscInt q = 1; q < n; q++) {
    const PetscInt p = order[q];
    PetscInt       r = q;

    for (; r > 0 && (cell[order[r - 1]] > cell[p] || (cell[order[r - 1]] == cell[p] && id[order[r - 1]] > id[p])); r--)
      order[r] = order[r - 1];
    order[r] = p;
  }
}

/* The number of node ijk in the arrays of the patch, and of the cell whose base it is. */
static PetscInt NodeIndex(const MPMPatch *patch, const PetscInt ijk[3])
{
  return ((ijk[2] - patch->lo[2]) * patch->n[1] + ijk[1] - patch->lo[1]) * patch->n[0] + ijk[0] - patch->lo[0];
}

static PetscInt CellOf(const MPMPatch *patch, const PetscInt base[3])
{
  const PetscInt at[3] = {base[0] - patch->own_lo[0], base[1] - patch->own_lo[1], base[2] - patch->own_lo[2]};

  return MPMTileCell((int)patch->grid->dim, &patch->tiles, at);
}

static int Mine(const MPMPatch *patch, const PetscInt ijk[])
{
  for (int d = 0; d < 3; d++)
    if (ijk[d] < patch->own_lo[d] || ijk[d] >= patch->own_lo[d] + patch->own_n[d]) return 0;
  return 1;
}

static PetscInt Nodes(const MPMPatch *patch)
{
  return patch->n[0] * patch->n[1] * patch->n[2];
}

/* The bytes of an array of a bench that a patch needs, and one node beyond them, which nothing may write. */
static size_t Used(const MPMPatch *patch)
{
  return (size_t)((Nodes(patch) + 1) * NC) * sizeof(PetscReal);
}

/* How an axis is cut: box k of p begins at node edge[k], counted from the grid's first. */
typedef struct {
  PetscInt p[3], edge[3][MAX_BOXES + 1];
} Cuts;

/* The patch that owns box r of the grid (no cuts: all nodes), with its particles. alone: sends no sums of tiles. */
static void SetUp(Bench *b, const MPMGrid *g, MPMBasis basis, const State *s, const Cuts *cuts, PetscInt r,
                  PetscBool alone)
{
  const int dim = (int)g->dim, reach = MPMBasisNodes(basis) - 1;
  MPMPatch *patch = &b->patch;
  PetscInt  cells;

  memset(b, 0, offsetof(Bench, sum));
  patch->grid  = g;
  patch->basis = basis;
  for (int d = 0; d < 3; d++) {
    const PetscInt first = -g->layers[d], last = first + g->nodes[d] - 1,
                   *edge = cuts ? cuts->edge[d] + r % cuts->p[d] : NULL;

    patch->n[d] = patch->own_n[d] = 1;
    if (d >= dim) continue;
    patch->own_lo[d] = first + (cuts ? edge[0] : 0);
    patch->own_n[d]  = cuts ? edge[1] - edge[0] : g->nodes[d];
    r /= cuts ? cuts->p[d] : 1;
    patch->lo[d] = patch->own_lo[d] - reach;
    patch->n[d]  = patch->own_n[d] + 2 * reach;
    if (g->periodic[d]) continue;
    patch->lo[d] = PetscMax(first, patch->own_lo[d] - reach);
    patch->n[d]  = PetscMin(last, patch->own_lo[d] + patch->own_n[d] - 1 + reach) - patch->lo[d] + 1;
  }
  patch->node        = (MPMNode *)b->sum;
  patch->motion      = b->motion;
  patch->tiles.lines = 1;
  patch->value.met   = b->met;
  patch->span        = b->span;
  patch->order       = b->order;
  patch->movers      = b->movers;
  for (int k = 0; k <= N; k++) b->movers[k] = -9;
  memset(b->sum, 0, Used(patch));
  memset(b->motion, 0, Used(patch));
  PetscCallAbort(PETSC_COMM_SELF, MPMTilesSetUp(patch, alone));
  cells = MPMTilesCells(patch);
  PetscCheckAbort(cells < MAX_CELLS, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no room for so many cells");
  for (PetscInt p = 0; p < s->n; p++) {
    const PetscInt q = b->own.n;
    PetscReal      xi[3];
    PetscInt       base[3] = {0};

    CHECK(MPMLocate(dim, basis, g, 0, s->x + p * dim, Widths(s, p, dim), xi, base));
    if (!Mine(patch, base)) continue;
    CopyParticle(dim, s, p, &b->own);
    b->order[q]    = q;
    b->own.cell[q] = CellOf(patch, base);
    CHECK(b->own.cell[q] >= 0 && b->own.cell[q] < cells);
    b->start[b->own.cell[q] + 1]++;
  }
  Sort(b->own.n, b->order, b->own.cell, b->own.id);
  for (PetscInt k = 0; k < cells; k++) b->start[k + 1] += b->start[k];
  PetscCallAbort(PETSC_COMM_SELF, MPMTilesAssign(patch, PETSC_FALSE, b->start));
}

static void Destroy(Bench *b)
{
  PetscCallAbort(PETSC_COMM_SELF, MPMTilesDestroy(&b->patch));
}

static int ToParticles(const MPMPhase *phase)
{
  return phase->parts & (MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT | MPM_G2P_FILTER) ? 1 : 0;
}

/* Runs the kernel of a phase. pass: the tiles that particles to nodes are for. */
static MPMStatus Run(Bench *b, const MPMParams *par, const MPMPhase *phase, MPMPass pass)
{
  const PetscInt  parts = phase->parts | (pass == MPM_PASS_EARLY  ? MPM_P2G_EARLY
                                          : pass == MPM_PASS_LATE ? MPM_P2G_LATE
                                                                  : 0);
  const MPMKernel found = MPMKernelFind(b->patch.grid->dim, b->patch.basis, parts);
  const MPMKernel run   = (*widths[width].table)[b->patch.grid->dim - 1][ToParticles(phase)];
  MPMStatus       status;

  MPMStatusReset(&status);
  b->patch.particles = View(&b->own, phase->particles_in | phase->particles_out, par);
  CHECK(run != NULL && found != NULL);
  if (widths[width].lanes == MPMKernelWidth()) CHECK(run == found);
  if (run) run(par, &b->patch, parts, &status);
  return status;
}

/* Node c of the arrays of the patch. */
static void NodeOf(const MPMPatch *patch, PetscInt c, PetscInt ijk[3])
{
  for (int d = 0; d < 3; d++) {
    ijk[d] = c % patch->n[d] + patch->lo[d];
    c /= patch->n[d];
  }
}

/* The same node in a patch of all nodes, through periodic faces. */
static PetscInt SameNode(const MPMPatch *patch, PetscInt c, const MPMPatch *all)
{
  const MPMGrid *g = patch->grid;
  PetscInt       ijk[3];

  NodeOf(patch, c, ijk);
  for (int d = 0; d < g->dim; d++)
    if (g->periodic[d]) ijk[d] = (ijk[d] + g->cells[d]) % g->cells[d];
  return NodeIndex(all, ijk);
}

/* Do these parts make component k of a node's sums? */
static int Asked(int dim, PetscInt parts, int k)
{
  if (k == 0) return parts & MPM_P2G_MASS ? 1 : 0;
  if (k <= dim) return parts & MPM_P2G_MOMENTUM ? 1 : 0;
  return k >= MPM_NODE_force && k < MPM_NODE_force + dim && parts & MPM_P2G_FORCE ? 1 : 0;
}

/* Nodes of a stencil. */
static int StencilSize(int dim, MPMBasis basis)
{
  int size = 1;

  for (int d = 0; d < dim; d++) size *= MPMBasisNodes(basis);
  return size;
}

/* Node a of the stencil of particle p: its number in a patch of all nodes, its weight, gradient, and way from the
 * particle. */
typedef struct {
  PetscInt    at;
  long double phi, dphi[3], way[3];
} Node;

static void Stencil(const MPMPatch *patch, const State *s, PetscInt p, Node nodes[])
{
  const MPMGrid   *g   = patch->grid;
  const int        dim = (int)g->dim, ns = MPMBasisNodes(patch->basis);
  const PetscReal *l = Widths(s, p, dim);
  PetscReal        xi[3], w[3][MPM_MAX_STENCIL], grad[3][MPM_MAX_STENCIL];
  PetscInt         base[3] = {0};

  for (int d = 0; d < dim; d++) {
    xi[d]   = PetscMin((s->x[p * dim + d] - g->lower[d]) / g->h[d], (PetscReal)g->cells[d]);
    base[d] = MPMBasisBase(patch->basis, &xi[d], l[d], g->cells[d], g->periodic[d], g->wall_basis[d]);
    MPMBasisWeights(patch->basis, xi[d], l[d], base[d], g->cells[d], g->wall_basis[d], w[d], grad[d]);
  }
  for (int a = 0; a < StencilSize(dim, patch->basis); a++) {
    const int i[3]   = {a % ns, a / ns % ns, a / ns / ns};
    PetscInt  ijk[3] = {base[0] + i[0], base[1] + i[1], base[2] + i[2]};
    Node     *node   = nodes + a;

    node->phi = 1;
    for (int d = 0; d < dim; d++) {
      node->way[d] = ((long double)ijk[d] - xi[d]) * g->h[d];
      node->phi *= w[d][i[d]];
      node->dphi[d] = 1;
      for (int e = 0; e < dim; e++) node->dphi[d] *= e == d ? (long double)grad[e][i[e]] / g->h[e] : w[e][i[e]];
      if (g->periodic[d]) ijk[d] %= g->cells[d];
    }
    node->at = NodeIndex(patch, ijk);
  }
}

static const MPMKind *KindOf(const MPMParams *par, const State *s, PetscInt p)
{
  return par->kinds + (par->nkinds > 1 ? s->kind[p] : 0);
}

/* The material state of a particle as a block of one, as far as its law has it. */
static void Block(int dim, const State *s, PetscInt p, MPMBlock *b)
{
#define BLOCK_ROW(name, rows)                                                                                          \
  for (int k = 0; k < MPMComponents_##name(dim); k++) b->name[k][0] = s->name[p * MPMComponents_##name(dim) + k];
  MPM_MATERIAL_FIELDS(BLOCK_ROW)
#undef BLOCK_ROW
}

/* ---- Particles to nodes */

/* Each node by plain loops over all particles, and the totals. */
static void CheckSums(const Bench *b, const State *s, const MPMParams *par, PetscInt parts)
{
  static long double ref[MAX_NODES * NC], size[MAX_NODES * NC];
  const MPMPatch    *patch = &b->patch;
  const MPMGrid     *g     = patch->grid;
  const int          dim = (int)g->dim, nc = MPM_NODE_NC;
  long double        total[NC] = {0}, particles[NC] = {0}, sizes[NC] = {0};
  static Node        nodes[MAX_STENCIL];

  memset(ref, 0, (size_t)(Nodes(patch) * nc) * sizeof *ref);
  memset(size, 0, (size_t)(Nodes(patch) * nc) * sizeof *size);
  for (PetscInt p = 0; p < s->n; p++) {
    const MPMKind     *k = KindOf(par, s, p);
    const MPMMaterial *m = par->materials + k->material;
    MPMBlock           block;

    Block(dim, s, p, &block);
    if (!(m->state & MPM_BIT(tau))) m->type->law->stress[dim - 1](m, 0, 1, &block);
    Stencil(patch, s, p, nodes);
    for (int a = 0; a < StencilSize(dim, patch->basis); a++)
      for (int d = 0; d < dim; d++) {
        const long double phi = nodes[a].phi, f[3] = {d == 0 ? phi * k->m : 0};
        long double      *r = ref + nodes[a].at * nc, *z = size + nodes[a].at * nc,
                    v = parts & MPM_RESIDUAL ? s->r[p * dim + d] : s->v[p * dim + d], vs = fabsl(v);

        r[0] += f[0];
        z[0] += f[0];
        for (int e = 0; e < dim && (parts & MPM_AFFINE); e++) {
          v += s->C[(p * dim + d) * dim + e] * nodes[a].way[e];
          vs += fabsl(s->C[(p * dim + d) * dim + e]) * 4 * g->h[e];
        }
        r[1 + d] += phi * k->m * v;
        z[1 + d] += phi * k->m * vs;
        if (core.needs.forced) {
          r[MPM_NODE_force + d] += phi * k->m * s->b[p * dim + d];
          z[MPM_NODE_force + d] += fabsl(phi * k->m * s->b[p * dim + d]);
        }
        for (int e = 0; e < dim; e++) {
          const long double force = -(long double)k->V0 * block.tau[MPMSymPart(dim, d, e)][0] * nodes[a].dphi[e];
          r[MPM_NODE_force + d] += force;
          z[MPM_NODE_force + d] += fabsl(force);
          sizes[MPM_NODE_force + d] += fabsl(force);
        }
      }
    particles[0] += k->m;
    sizes[0] += k->m;
    for (int d = 0; d < dim; d++) {
      const long double v = parts & MPM_RESIDUAL ? s->r[p * dim + d] : s->v[p * dim + d];
      particles[1 + d] += k->m * v;
      sizes[1 + d] += k->m * (fabsl(v) + (parts & MPM_AFFINE ? 4 : 0));
      if (core.needs.forced) particles[MPM_NODE_force + d] += (long double)k->m * s->b[p * dim + d];
      sizes[MPM_NODE_force + d] += k->m;
    }
  }
  for (PetscInt c = 0; c < Nodes(patch); c++) {
    PetscInt ijk[3];

    NodeOf(patch, c, ijk);
    for (int k = 0; k < nc; k++) {
      const PetscReal value = b->sum[c * nc + k];

      if (!Asked(dim, parts, k)) {
        CHECK(value == -777 || (parts & 7) == 7); /* not asked for: untouched, but what pads a record of all */
        continue;
      }
      if (!Mine(patch, ijk)) continue;
      total[k] += value;
      CHECK_LE(fabsl(value - ref[c * nc + k]), 2e-14L * size[c * nc + k]);
    }
  }
  for (int k = 0; k < nc; k++) /* C carries no momentum where the basis is linearly complete; force: that of b */
    if (Asked(dim, parts, k) &&
        (!(parts & MPM_AFFINE) || k < 1 || k > dim || g->wall_basis[0] != MPM_WALL_BASIS_STEFFEN))
      CHECK_LE(fabsl(total[k] - particles[k]), 2e-14L * sizes[k]);
}

/* What kernels have to set, or must not touch, holds -777; the sums of tiles no number. */
static void Spoil(Bench *b)
{
  const MPMTiles *t    = &b->patch.tiles;
  const size_t    size = MPMTileNodes(b->patch.grid->dim, b->patch.basis) * MPM_NODE_NC * sizeof(PetscReal);

  for (PetscInt k = 0; k < Nodes(&b->patch) * MPM_NODE_NC; k++) b->sum[k] = -777;
  memset(t->scratch, 0xff, (t->room + (size_t)t->n[0]) * size);
}

/* Zeroes what the parts make of all nodes, or of those out of the spans, to which only zeros were added. */
static void Zero(Bench *b, PetscInt parts, int all)
{
  const MPMPatch *patch = &b->patch;
  const int       dim   = (int)patch->grid->dim;

  for (PetscInt c = 0; c < Nodes(patch); c++) {
    const MPMSpan *span = &patch->span[c / patch->n[0]];
    PetscReal     *sum  = b->sum + c * MPM_NODE_NC;
    PetscInt       ijk[3];

    NodeOf(patch, c, ijk);
    if (!all && Mine(patch, ijk) && span->first <= c % patch->n[0] && c % patch->n[0] < span->last) continue;
    for (int k = 0; k < MPM_NODE_NC; k++) {
      CHECK(sum[k] == -777 || sum[k] == 0);
      if (Asked(dim, parts, k)) sum[k] = 0;
    }
  }
}

/* The kept tiles have their sums: makes the others, and adds all up to nodes. alone: also to those above. */
static void Add(Bench *b, const MPMParams *par, const MPMPhase *phase, int alone)
{
  const PetscInt end = Nodes(&b->patch) * MPM_NODE_NC;

  if (alone) Zero(b, phase->parts, 1);
  MPMTilesWrap(&b->patch);
  MPMTilesFindSpans(&b->patch);
  (void)Run(b, par, phase, MPM_PASS_MAIN);
  for (PetscInt k = 0; k < NC; k++) CHECK_EQ(b->sum[end + k], 0); /* behind the last node */
  if (!alone) Zero(b, phase->parts, 0);
}

/* Runs a phase on a patch of all nodes. */
static MPMStatus Sweep(Bench *b, const MPMParams *par, const MPMPhase *phase)
{
  MPMStatus status;

  if (ToParticles(phase)) return Run(b, par, phase, MPM_PASS_MAIN);
  Spoil(b);
  status = Run(b, par, phase, MPM_PASS_EARLY);
  Add(b, par, phase, 0);
  return status;
}

/* The message that the patch `to` gets from the one below it, `toward` it. */
static void Send(const Bench *from, Bench *to, const int toward[3], PetscInt parts)
{
  static char  message[1 << 20];
  const size_t room = MPMTilesBytes(&from->patch, toward, parts, PETSC_TRUE);
  size_t       bytes;

  CHECK_EQ(MPMTilesBytes(&to->patch, toward, parts, PETSC_FALSE), room);
  CHECK_LE(room + MPM_LINE, sizeof message);
  memset(message, 'x', room + MPM_LINE);
  bytes = MPMTilesPack(&from->patch, toward, parts, message);
  CHECK_LE(bytes, room);
  for (size_t k = bytes; k < bytes + MPM_LINE; k++) CHECK_EQ(message[k], 'x');
  MPMTilesUnpack(&to->patch, toward, parts, message);
  CHECK_LE(to->patch.tiles.nslots, (PetscInt)to->patch.tiles.room);
}

/* ---- Nodes to particles */

/* Copies the node values of the own nodes of a periodic axis to their images, as an exchange does. */
static void Images(Bench *b)
{
  const MPMPatch *patch = &b->patch;
  const PetscInt  vc    = MPM_MOTION_NC(patch->grid->dim);

  for (PetscInt n = 0; n < Nodes(patch); n++)
    memmove(b->motion + n * vc, b->motion + SameNode(patch, n, patch) * vc, (size_t)vc * sizeof(PetscReal));
}

static void Worse(MPMBad *bad, PetscInt64 *id, MPMBad now, PetscInt64 whose)
{
  if (*bad != MPM_OK && (*bad < now || (*bad == now && *id < whose))) return;
  *bad = now;
  *id  = whose;
}

/* Every particle of a patch of all particles by plain loops over its nodes; status. */
static MPMStatus CheckParticlesMoved(Bench *b, const MPMParams *par, const MPMPhase *phase)
{
  static State    before;
  static Node     nodes[MAX_STENCIL];
  const MPMPatch *patch = &b->patch;
  const MPMGrid  *g     = patch->grid;
  const int       dim = (int)g->dim, inertia = MPMBasisInertia(patch->basis), vc = MPM_MOTION_NC(dim);
  const PetscInt  parts    = phase->parts;
  const PetscBool filtered = core.needs.residual && (phase->particles_in & MPM_BIT(r)) ? PETSC_TRUE : PETSC_FALSE;
  MPMStatus       status;
  MPMBad          bad = MPM_OK;
  PetscInt64      id = -1, moved = 0;
  PetscInt        nmovers = 0;
  PetscReal       v2 = 0, c2 = 0;

  before = b->own;
  status = Run(b, par, phase, MPM_PASS_MAIN);
  for (PetscInt p = 0; p < b->own.n; p++) {
    const MPMMaterial *m = par->materials + KindOf(par, &before, p)->material;
    const PetscReal   *v = b->own.v + p * dim, *x = b->own.x + p * dim, *F = b->own.F + p * dim * dim;
    long double        vn[3] = {0}, an[3] = {0}, G[9] = {0}, C[9] = {0}, D[3] = {0}, dx[3], size = 0, steep = 0;
    PetscReal          wave, speed = 0, xi[3], l[3];
    PetscInt           base[3] = {0};
    MPMBlock           block;

    Stencil(patch, &before, p, nodes);
    for (int a = 0; a < StencilSize(dim, patch->basis); a++)
      for (int d = 0; d < dim; d++) {
        const PetscReal *node = b->motion + nodes[a].at * vc;

        vn[d] += nodes[a].phi * node[d];
        an[d] += nodes[a].phi * node[dim + d];
        size += fabsl(nodes[a].phi * node[d]) + fabsl(nodes[a].phi * node[dim + d]);
        for (int e = 0; e < dim; e++) {
          G[d * dim + e] += node[d] * nodes[a].dphi[e];
          steep += fabsl(node[d] * nodes[a].dphi[e]);
          C[d * dim + e] += inertia ? nodes[a].phi * node[d] * nodes[a].way[e] : 0;
        }
        D[d] += nodes[a].phi * nodes[a].way[d] * nodes[a].way[d];
      }
    for (int d = 0; d < dim; d++) /* uniform, steffen: one constant everywhere; else D is 0 on the wall itself */
      for (int e = 0; e < dim; e++) {
        if (!par->own_inertia || g->wall_basis[e] == MPM_WALL_BASIS_STEFFEN)
          D[e] = (long double)g->h[e] * g->h[e] / PetscMax(inertia, 1);
        C[d * dim + e] = inertia && D[e] > 0 ? C[d * dim + e] / D[e] : G[d * dim + e];
      }
    size = 1e-14L * (size + 1);
    CHECK_EQ(b->own.id[p], before.id[p]);
    for (int d = 0; d < dim; d++) {
      const PetscReal v0 = before.v[p * dim + d], r0 = before.r[p * dim + d];
      long double     now = par->flip * (v0 + par->kick * an[d]) + (1 - par->flip) * vn[d];

      if (filtered) now = v0 - r0 + par->kick * an[d];
      dx[d] = parts & MPM_G2P_MOTION ? par->dt * (filtered ? now : vn[d]) : before.dx[p * dim + d];
      if (parts & MPM_G2P_MOTION)
        CHECK_LE(fabsl(v[d] - now), size);
      else
        CHECK_EQ(v[d], v0);
      if (parts & MPM_G2P_FILTER)
        CHECK_LE(fabsl(b->own.r[p * dim + d] - ((parts & MPM_RESIDUAL ? r0 : v0) - vn[d])), size);
      else
        CHECK_EQ(b->own.r[p * dim + d], r0);
      if ((parts & MPM_G2P_MOTION) && !(parts & MPM_G2P_COMMIT)) CHECK_LE(fabsl(b->own.dx[p * dim + d] - dx[d]), size);
      if (!(parts & MPM_G2P_COMMIT))
        CHECK_EQ(x[d], before.x[p * dim + d]);
      else {
        long double away = fabsl(x[d] - (before.x[p * dim + d] + dx[d]));

        if (g->periodic[d]) away = fminl(away, fabsl(away - (g->upper[d] - g->lower[d])));
        if (g->periodic[d]) CHECK(x[d] >= g->lower[d] && x[d] < g->upper[d]);
        CHECK_LE(away, size);
      }
      speed += v[d] * v[d];
    }
    for (int k = 0; k < dim * dim; k++)
      if (parts & MPM_AFFINE) { /* the rotation, and a share of the strain rate */
        const long double turned = C[k % dim * dim + k / dim];

        CHECK_LE(fabsl(b->own.C[p * dim * dim + k] - ((C[k] - turned) + par->strain * (C[k] + turned)) / 2),
                 4e-14L * (steep + 1));
      } else
        CHECK_EQ(b->own.C[p * dim * dim + k], before.C[p * dim * dim + k]);
    for (int d = 0; d < dim; d++)
      for (int e = 0; e < dim; e++) { /* F = (I + dt L) F0 */
        long double f = before.F[(p * dim + d) * dim + e];

        for (int k = 0; k < dim; k++) f += par->dt * G[d * dim + k] * before.F[(p * dim + k) * dim + e];
        if ((parts & MPM_G2P_STRESS) && (m->state & MPM_BIT(F)))
          CHECK_LE(fabsl(F[d * dim + e] - f), 4e-14L * (par->dt * steep + 2));
        else
          CHECK_EQ(F[d * dim + e], before.F[(p * dim + d) * dim + e]);
      }
    if (parts & MPM_G2P_STRESS) {
      PetscReal J;

      Block(dim, &b->own, p, &block);
      J = m->state & MPM_BIT(F) ? MPMDet(dim, F) : block.J[0][0];
      m->type->law->speed2[dim - 1](m, 0, 1, &block, &wave);
      c2 = PetscMax(c2, wave);
      if (!(J > 0 && J < PETSC_MAX_REAL)) Worse(&bad, &id, MPM_BAD_J, b->own.id[p]);
#define CHECK_KEPT(name, rows) /* what a law does not list is left alone */                                            \
  if (!(m->state & MPM_BIT(name)))                                                                                     \
    CHECK_SAME(b->own.name + p * MPMComponents_##name(dim), before.name + p * MPMComponents_##name(dim),               \
               (size_t)MPMComponents_##name(dim) * sizeof(PetscReal));
      MPM_MATERIAL_FIELDS(CHECK_KEPT)
#undef CHECK_KEPT
      if (m->type->law->update[dim - 1] && J > 0) { /* and what it lists, it gets */
        MPMBlock     again;
        MPMComponent L[9];

        Block(dim, &before, p, &again);
        for (int k = 0; k < dim * dim; k++) {
          again.F[k][0] = F[k];
          L[k][0]       = (PetscReal)G[k];
        }
        m->type->law->update[dim - 1](m, par->dt, L, 0, 1, &again);
#define CHECK_UPDATED(name, rows)                                                                                      \
  for (int k = 0; k < MPMComponents_##name(dim) && (m->state & MPM_BIT(name)); k++)                                    \
    CHECK_NEAR(again.name[k][0], block.name[k][0],                                                                     \
               1e-9 * (1 + fabs(block.name[k][0]) + (MPM_BIT(name) == MPM_BIT(tau) ? m->E + m->K : 0)));
        MPM_MATERIAL_FIELDS(CHECK_UPDATED)
#undef CHECK_UPDATED
      }
    }
    v2 = PetscMax(v2, speed);
    if (!(parts & MPM_G2P_COMMIT)) {
      CHECK_EQ(b->own.cell[p], before.cell[p]);
      continue;
    }
    if (core.needs.stretched) {
      PetscReal V[3];

      MPMStretch(dim, F, V);
      for (int d = 0; d < dim; d++) {
        l[d] = par->kinds[par->nkinds > 1 ? before.kind[p] : 0].l[d] * V[d];
        if (!(l[d] <= 0.5)) Worse(&bad, &id, MPM_TOO_WIDE, b->own.id[p]);
        l[d] = PetscMin(l[d], 0.5);
        CHECK_EQ(b->own.l[p * dim + d], l[d]);
      }
    }
    if (MPMLocate(dim, patch->basis, g, 0, x, Widths(&b->own, p, dim), xi, base)) {
      CHECK_EQ(b->own.cell[p], CellOf(patch, base));
      moved += CellOf(patch, base) != before.cell[p];
    } else {
      CHECK(b->own.cell[p] < 0);
      moved++;
      Worse(&bad, &id, MPM_LEFT_GRID, b->own.id[p]);
    }
  }
  CHECK_EQ(status.bad, bad);
  if (bad != MPM_OK) CHECK_EQ(status.id, id);
  CHECK_EQ(status.moved, moved);
  if (parts & MPM_G2P_MOTION) CHECK_EQ(status.v2, v2);
  if (parts & MPM_G2P_STRESS) CHECK(status.c2 == c2 || !(c2 < PETSC_MAX_REAL));
  for (PetscInt q = 0; q < b->own.n && (parts & MPM_G2P_COMMIT); q++) { /* those that moved, in order */
    const PetscInt p = patch->order[q];

    if (b->own.cell[p] != before.cell[p]) CHECK_EQ(b->movers[nmovers], b->own.cell[p] < 0 ? -1 - q : q);
    nmovers += b->own.cell[p] != before.cell[p];
  }
  CHECK_EQ(patch->nmovers, nmovers);
  CHECK_EQ(b->movers[nmovers], -9);
  return status;
}

/* Own particles of b have the bits of the particles of the same id in ref. The cell is a number of the patch: left out.
 */
static void CheckParticles(const Bench *b, const Bench *ref)
{
  const int dim = (int)b->patch.grid->dim;
  PetscInt  at[7 * N + 7];

  for (PetscInt p = 0; p < ref->own.n; p++) at[ref->own.id[p]] = p;
  for (PetscInt p = 0; p < b->own.n; p++) {
    const PetscInt q = at[b->own.id[p]];
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (MPM_FIELD_INDEX_##name != MPM_FIELD_INDEX_cell)                                                                  \
    CHECK_SAME(b->own.name + p * (nc), ref->own.name + q * (nc), (nc) * sizeof(ctype));
#include "physics/fields.def"
  }
}

/* ---- Bits */

/* After a commit, particles of a box that are not its own any more have negative cells. */
static void CheckCells(const Bench *b, MPMStatus status, const MPMPhase *phase)
{
  const int  dim  = (int)b->patch.grid->dim;
  PetscInt64 left = 0;

  for (PetscInt p = 0; p < b->own.n && (phase->parts & MPM_G2P_COMMIT); p++) {
    const PetscReal *x = b->own.x + p * dim, *l = Widths(&b->own, p, dim);
    PetscReal        xi[3];
    PetscInt         base[3] = {0};
    const int in = MPMLocate(dim, b->patch.basis, b->patch.grid, 0, x, l, xi, base), mine = in && Mine(&b->patch, base);

    left += in && !mine; /* a leaver goes to another patch; outside the grid there is none */
    CHECK(mine ? b->own.cell[p] == CellOf(&b->patch, base) : b->own.cell[p] < 0);
  }
  CHECK_EQ(status.left, left);
}

/* The next number of lanes, for a run that need not be of all. */
static void NextWidth(void)
{
  width = (width + 1) % nwidths;
}

/* The own nodes of b have the bits of those of ref, a patch of all nodes. */
static void CheckNodes(const Bench *b, const Bench *ref, PetscInt parts)
{
  const int dim = (int)b->patch.grid->dim, nc = MPM_NODE_NC;

  for (PetscInt c = 0; c < Nodes(&b->patch); c++) {
    PetscInt ijk[3];

    NodeOf(&b->patch, c, ijk);
    for (int k = 0; k < nc && Mine(&b->patch, ijk); k++)
      if (Asked(dim, parts, k))
        CHECK_SAME(b->sum + c * nc + k, ref->sum + NodeIndex(&ref->patch, ijk) * nc + k, sizeof(PetscReal));
  }
}

/* Axis `which` into as many boxes as can be; if there is no such axis all into two. Returns how many boxes. */
static PetscInt Cut(const MPMGrid *g, MPMBasis basis, int which, Cuts *cuts)
{
  for (int d = 0; d < 3; d++) {
    const PetscInt most = PetscMin(MAX_BOXES, g->nodes[d] / MPMTileEdge(basis));

    cuts->p[d] = which == d ? PetscMax(1, most) : which == g->dim && most > 1 ? 2 : 1;
    for (PetscInt k = 0; k < cuts->p[d]; k++) cuts->edge[d][k] = k * MPMTileEdge(basis);
    if (which == g->dim && most > 1) cuts->edge[d][1] *= 1 + UnitInt((int)most - 1);
    cuts->edge[d][cuts->p[d]] = g->nodes[d];
  }
  return cuts->p[0] * cuts->p[1] * cuts->p[2];
}

/* All messages that there are between the boxes. */
static void SendAll(Bench part[], const MPMGrid *g, const Cuts *cuts, PetscInt parts)
{
  const PetscInt *p = cuts->p, boxes = p[0] * p[1] * p[2];

  for (PetscInt r = boxes; r < boxes << g->dim; r++) {
    const PetscInt me[3] = {r % boxes % p[0], r % boxes / p[0] % p[1], r % boxes / p[0] / p[1]};
    int            toward[3], there = 1;
    PetscInt       from = 0;

    for (int d = 2; d >= 0; d--) {
      toward[d] = r / boxes >> d & 1;
      if (toward[d] && (p[d] == 1 || (me[d] == 0 && !g->periodic[d]))) there = 0;
      from = from * p[d] + (me[d] + p[d] - toward[d]) % p[d];
    }
    if (there) Send(&part[from], &part[r % boxes], toward, parts);
  }
}

/* Moves the sums of all tiles of a box to those of the patch of all nodes. */
static void Hand(const Bench *b, const Bench *all, PetscInt parts)
{
  static char     message[MAX_STENCIL * 8 * NC * sizeof(PetscReal)];
  const MPMTiles *t = &b->patch.tiles, *to = &all->patch.tiles;

  for (PetscInt tile = 0; tile < t->n[0] * t->n[1] * t->n[2]; tile++) {
    PetscInt at[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])}, slot;

    if (t->slot[tile] == MPM_TILE_EMPTY) continue;
    for (int d = 0; d < 3; d++)
      at[d] += to->below[d] - t->below[d] + (b->patch.own_lo[d] - all->patch.own_lo[d]) / MPMTileEdge(b->patch.basis);
    slot = to->slot[(at[2] * to->n[1] + at[1]) * to->n[0] + at[0]];
    CHECK(slot >= 0 && slot < to->n_own);
    if (slot < 0) continue;
    CHECK_LE(MPMTilesCopy(&b->patch, t->slot[tile], parts, PETSC_TRUE, message), sizeof message);
    MPMTilesCopy(&all->patch, slot, parts, PETSC_FALSE, message);
  }
}

/* Boxes that no messages of tiles go between: workers of a pool, whose tiles the master adds up, and as
   -parallel_sums roundoff, which adds up what each has at its nodes and those above. */
static void CheckAlone(const MPMGrid *g, MPMBasis basis, const State *s, const MPMParams *par, const MPMPhase *phase,
                       const Cuts *cuts, const Bench *ref)
{
  static Bench   b, master, total;
  const PetscInt nc = MPM_NODE_NC;

  SetUp(&master, g, basis, s, NULL, 0, PETSC_FALSE);
  PetscCallAbort(PETSC_COMM_SELF, MPMTilesAssign(&master.patch, PETSC_TRUE, master.start));
  for (int k = 0; k < MPM_NUM_PASSES; k++) CHECK(master.patch.tiles.nruns[k] == 0);
  Spoil(&master);
  total = *ref;
  for (PetscInt k = 0; k < Nodes(&ref->patch) * nc; k++)
    total.sum[k] = Asked((int)g->dim, phase->parts, (int)(k % nc)) ? 0 : -777;
  for (PetscInt r = 0; r < cuts->p[0] * cuts->p[1] * cuts->p[2]; r++) {
    MPMTiles *t = &b.patch.tiles;

    SetUp(&b, g, basis, s, cuts, r, PETSC_TRUE);
    Spoil(&b);
    NextWidth();
    (void)Run(&b, par, phase, MPM_PASS_EARLY);
    Add(&b, par, phase, 1);
    for (PetscInt k = 0; k < Nodes(&b.patch) * nc; k++)
      if (Asked((int)g->dim, phase->parts, (int)(k % nc)))
        total.sum[SameNode(&b.patch, k / nc, &ref->patch) * nc + k % nc] += b.sum[k];
    PetscCallAbort(PETSC_COMM_SELF, MPMTilesAssign(&b.patch, PETSC_TRUE, b.start));
    t->runs[MPM_PASS_EARLY][0] = (MPMRange){0, b.own.n, 0};
    t->nruns[MPM_PASS_EARLY]   = b.own.n > 0;
    NextWidth();
    (void)Run(&b, par, phase, MPM_PASS_EARLY);
    Hand(&b, &master, phase->parts);
    Destroy(&b);
  }
  NextWidth();
  Add(&master, par, phase, 0);
  CheckNodes(&master, ref, phase->parts);
  CheckSums(&total, s, par, phase->parts);
  Destroy(&master);
}

/* One phase on the whole grid (ref) and then stored otherwise, and on boxes of the grid; each with another number of
   lanes. */
static void CheckBits(const MPMGrid *g, MPMBasis basis, const State *s, const MPMParams *par, const MPMPhase *phase,
                      const char *what)
{
  static Bench   ref, b, part[MAX_BOXES];
  static State   other;
  const int      dim = (int)g->dim, to_particles = ToParticles(phase);
  const PetscInt vc = MPM_MOTION_NC(dim);

  SetUp(&ref, g, basis, s, NULL, 0, PETSC_FALSE);
  for (PetscInt k = 0; k < Nodes(&ref.patch) * vc; k++) ref.motion[k] = UnitReal(-0.2, 0.2);
  Images(&ref);
  NextWidth();
  Sweep(&ref, par, phase);
  UnitContext("%s, stored in another order", what);
  other = *s;
  Permute(dim, &other);
  SetUp(&b, g, basis, &other, NULL, 0, PETSC_FALSE);
  memcpy(b.motion, ref.motion, Used(&b.patch));
  NextWidth();
  Sweep(&b, par, phase);
  if (to_particles)
    CheckParticles(&b, &ref);
  else
    CHECK_SAME(b.sum, ref.sum, Used(&b.patch));
  Destroy(&b);
  for (int cut = 0; cut <= dim; cut++) {
    Cuts           cuts;
    const PetscInt boxes = Cut(g, basis, cut, &cuts);
    PetscInt       own   = 0;

    UnitContext("%s, cut %d into %dx%dx%d", what, cut, (int)cuts.p[0], (int)cuts.p[1], (int)cuts.p[2]);
    for (PetscInt r = 0; r < boxes; r++) {
      SetUp(&part[r], g, basis, &other, &cuts, r, PETSC_FALSE);
      own += part[r].own.n;
      for (PetscInt c = 0; c < Nodes(&part[r].patch); c++)
        memcpy(part[r].motion + c * vc, ref.motion + SameNode(&part[r].patch, c, &ref.patch) * vc,
               vc * sizeof(PetscReal));
      NextWidth();
      Spoil(&part[r]);
      CheckCells(&part[r], Run(&part[r], par, phase, to_particles ? MPM_PASS_MAIN : MPM_PASS_EARLY), phase);
      NextWidth();
      if (!to_particles) (void)Run(&part[r], par, phase, MPM_PASS_LATE);
      if (to_particles) CheckParticles(&part[r], &ref);
    }
    CHECK_EQ(own, s->n); /* every particle has one owner */
    if (!to_particles) SendAll(part, g, &cuts, phase->parts);
    for (PetscInt r = 0; r < boxes; r++) {
      NextWidth();
      if (!to_particles) {
        Add(&part[r], par, phase, 0);
        CheckNodes(&part[r], &ref, phase->parts);
      }
      Destroy(&part[r]);
    }
    if (!to_particles && cut == dim) CheckAlone(g, basis, &other, par, phase, &cuts, &ref);
  }
  Destroy(&ref);
}

static void Divide(Bench *b)
{
  const int dim = (int)b->patch.grid->dim;

  for (PetscInt c = 0; c < Nodes(&b->patch); c++)
    for (int d = 0; d < dim; d++) {
      const PetscReal *sum                        = b->sum + c * MPM_NODE_NC;
      b->motion[c * MPM_MOTION_NC(dim) + d]       = sum[0] > 0 ? sum[1 + d] / sum[0] : 0;
      b->motion[c * MPM_MOTION_NC(dim) + dim + d] = 0;
    }
  Images(b);
}

/* apic: v = A x + c comes back from the grid as it went, and C = A too, near walls as well; angular momentum of the nodes
   is that of the particles, with C by the inertia of each particle. */
static void Affine(int dim, MPMBasis basis)
{
  static const MPMPhase to   = {.parts = MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_AFFINE, .particles_in = -1},
                        from = {.parts = MPM_G2P_MOTION | MPM_AFFINE, .particles_in = -1, .particles_out = -1};
  static Bench b;
  static State s, before;
  const int    inertia = MPMBasisInertia(basis);
  MPMParams    par     = {.dt          = 0.125,
                          .kick        = 0.1875,
                          .flip        = 0,
                          .strain      = 1,
                          .kinds       = kinds,
                          .nkinds      = nkinds,
                          .materials   = materials,
                          .nmaterials  = nmaterials,
                          .own_inertia = PETSC_TRUE};
  MPMGrid      g       = Grid(dim, basis, MPM_WALL_BASIS_EXTRAP, 1);
  PetscReal    A[9], c[3];

  core.needs.affine = PETSC_TRUE;
  UnitContext("affine field, dim %d, basis %d", dim, (int)basis);
  for (int d = 0; d < 3; d++) { /* more cells, so that there is an interior */
    if (d >= dim) continue;
    g.upper[d] = g.lower[d] + 7 * g.h[d];
    g.cells[d] = 7;
  }
  MPMGridSetNodes(&g, basis);
  for (int k = 0; k < 9; k++) A[k] = UnitReal(-1, 1);
  for (int d = 0; d < 3; d++) c[d] = UnitReal(-1, 1);
  Particles(&s, &g, N, 0);
  for (PetscInt p = 0; p < N; p++)
    for (int d = 0; d < dim; d++) {
      if (!(p % 3) && inertia) s.x[p * dim + d] = g.lower[d] + UnitInt(7) * g.h[d]; /* some lie on the walls */
      if (p % 3 == 1 && inertia) s.x[p * dim + d] = UnitReal(g.lower[d], g.lower[d] + g.h[d]);
      s.v[p * dim + d] = c[d];
    }
  for (PetscInt p = 0; p < N; p++)
    for (int d = 0; d < dim; d++)
      for (int e = 0; e < dim; e++) {
        s.v[p * dim + d] += A[d * dim + e] * s.x[p * dim + e];
        s.C[(p * dim + d) * dim + e] = A[d * dim + e];
      }
  SetUp(&b, &g, basis, &s, NULL, 0, PETSC_FALSE);
  Sweep(&b, &par, &to);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < d && inertia; e++) {
      long double nodes = 0, particles = 0;

      for (PetscInt n = 0; n < Nodes(&b.patch); n++) {
        PetscInt ijk[3];

        NodeOf(&b.patch, n, ijk);
        nodes += (g.lower[d] + ijk[d] * (long double)g.h[d]) * b.sum[n * MPM_NODE_NC + 1 + e] -
                 (g.lower[e] + ijk[e] * (long double)g.h[e]) * b.sum[n * MPM_NODE_NC + 1 + d];
      }
      for (PetscInt p = 0; p < N; p++) {
        static Node stencil[MAX_STENCIL];
        long double D[3] = {0}; /* sum phi (x_i - x)^2 */

        Stencil(&b.patch, &s, p, stencil);
        for (int a = 0; a < StencilSize(dim, basis); a++)
          for (int k = 0; k < dim; k++) D[k] += stencil[a].phi * stencil[a].way[k] * stencil[a].way[k];
        particles += KindOf(&par, &s, p)->m *
                     ((long double)s.x[p * dim + d] * s.v[p * dim + e] -
                      (long double)s.x[p * dim + e] * s.v[p * dim + d] + A[e * dim + d] * D[d] - A[d * dim + e] * D[e]);
      }
      CHECK_LE(fabsl(nodes - particles), 1e-13L * N * 2);
    }
  Divide(&b);
  for (PetscInt n = 0; n < Nodes(&b.patch);
       n++) { /* nodes without mass: the round trip needs none of them but on edges of support */
    PetscInt ijk[3];

    NodeOf(&b.patch, n, ijk);
    for (int d = 0; d < dim; d++) {
      long double v = c[d];

      for (int e = 0; e < dim; e++) v += A[d * dim + e] * (g.lower[e] + ijk[e] * (long double)g.h[e]);
      if (b.sum[n * MPM_NODE_NC] > 1e-9) CHECK_NEAR(b.motion[n * MPM_MOTION_NC(dim) + d], v, 1e-13);
      if (b.sum[n * MPM_NODE_NC] <= 1e-9) b.motion[n * MPM_MOTION_NC(dim) + d] = (PetscReal)v;
    }
  }
  before = b.own;
  Sweep(&b, &par, &from);
  for (PetscInt k = 0; k < N * dim; k++) CHECK_NEAR(b.own.v[k], before.v[k], 1e-14);
  for (PetscInt k = 0; k < N * dim * dim; k++) CHECK_NEAR(b.own.C[k], before.C[k], 1e-12);
  Destroy(&b);
}

/* xpic: what the grid takes up fully, a constant, leaves nothing; each order leaves less, in the norm of mass; order 1
   is pic. */
static void Filter(int dim, MPMBasis basis, MPMWallBasis wall)
{
  static const MPMPhase first  = {.parts = MPM_P2G_MASS | MPM_P2G_MOMENTUM, .particles_in = -1},
                        again  = {.parts = MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_RESIDUAL, .particles_in = -1},
                        filter = {.parts = MPM_G2P_FILTER, .particles_in = -1, .particles_out = -1},
                        more   = {.parts = MPM_G2P_FILTER | MPM_RESIDUAL, .particles_in = -1, .particles_out = -1},
                        move   = {.parts = MPM_G2P_MOTION, .particles_in = -1, .particles_out = -1};
  static Bench  b;
  static State  s, after;
  MPMParams     par = {.dt         = 0.125,
                       .kick       = 0.1875,
                       .flip       = 0,
                       .strain     = 1,
                       .kinds      = kinds,
                       .nkinds     = nkinds,
                       .materials  = materials,
                       .nmaterials = nmaterials};
  const MPMGrid g   = Grid(dim, basis, wall, 0);

  SetOrder(1);
  Particles(&s, &g, N, 0);
  for (int constant = 0; constant < 2; constant++) {
    long double last = INFINITY;

    UnitContext("filter, dim %d, basis %d, wall form %d, %s", dim, (int)basis, (int)wall,
                constant ? "a constant" : "any v");
    for (PetscInt k = 0; k < N * dim && constant; k++) s.v[k] = 0.3 + k % dim;
    SetUp(&b, &g, basis, &s, NULL, 0, PETSC_FALSE);
    for (int order = 1; order <= 6; order++) {
      long double norm = 0;

      Sweep(&b, &par, order == 1 ? &first : &again);
      Divide(&b);
      Sweep(&b, &par, order == 1 ? &filter : &more);
      for (PetscInt p = 0; p < N; p++)
        for (int d = 0; d < dim; d++) {
          norm += KindOf(&par, &b.own, p)->m * (long double)b.own.r[p * dim + d] * b.own.r[p * dim + d];
          if (constant) CHECK_NEAR(b.own.r[p * dim + d], 0, 1e-14);
        }
      if (!constant) CHECK_LE(norm, last * (1 + 1e-14L));
      last = norm;
      if (order > 1) continue;
      for (PetscInt k = 0; k < Nodes(&b.patch); k++) /* an acceleration, in step with the velocity */
        for (int d = 0; d < dim; d++) {
          PetscReal *node = b.motion + k * MPM_MOTION_NC(dim);

          node[dim + d] = sin(node[d] * 7);
          node[d] += par.kick * node[dim + d];
        }
      after = b.own;
      Sweep(&b, &par, &move);
      SetOrder(0);
      for (PetscInt k = 0; k < N * dim; k++) {
        const PetscReal v = b.own.v[k], dx = b.own.dx[k];
        b.own.v[k]  = after.v[k];
        after.v[k]  = v;
        after.dx[k] = dx;
      }
      Sweep(&b, &par, &move); /* pic */
      for (PetscInt k = 0; k < N * dim; k++) {
        CHECK_NEAR(b.own.v[k], after.v[k], 1e-14);
        CHECK_NEAR(b.own.dx[k], after.dx[k], 1e-14);
      }
      SetOrder(1);
      memcpy(b.own.v, s.v, sizeof s.v);
      {
        State *own = &b.own; /* storage order is that of s: no halo was taken out of it */
        CHECK_SAME(own->id, s.id, N * sizeof s.id[0]);
      }
    }
    Destroy(&b);
  }
}

/* afmpm: each correction reduces what is missing in M v = p + dt m a, with the full mass matrix M, in the norm of 1/m;
   where the velocity is one constant and a is 0, nothing is missing and nothing changes. */
static void Correction(int dim, MPMBasis basis)
{
  static const MPMPhase to     = {.parts = MPM_P2G_MASS | MPM_P2G_MOMENTUM, .particles_in = -1},
                        filter = {.parts = MPM_G2P_FILTER, .particles_in = -1, .particles_out = -1},
                        again  = {.parts = MPM_P2G_MOMENTUM | MPM_RESIDUAL, .particles_in = -1};
  static Bench  b;
  static State  s;
  static Node   nodes[MAX_STENCIL];
  const MPMGrid g   = Grid(dim, basis, MPM_WALL_BASIS_EXTRAP, 0);
  MPMParams     par = {.dt         = 0.125,
                       .kick       = 0.1875,
                       .flip       = 0,
                       .strain     = 1,
                       .kinds      = kinds,
                       .nkinds     = nkinds,
                       .materials  = materials,
                       .nmaterials = nmaterials,
                       .walls      = &walls};

  for (int constant = 0; constant < 2; constant++) {
    static long double missing[3 * MAX_NODES];
    long double        start = 0, last = INFINITY;

    UnitContext("correction, dim %d, basis %d, %s", dim, (int)basis, constant ? "a constant" : "any v");
    SetOrder(3);
    Particles(&s, &g, N, 0);
    for (PetscInt k = 0; k < N * dim && constant; k++) s.v[k] = 0.3 + k % dim;
    SetUp(&b, &g, basis, &s, NULL, 0, PETSC_FALSE);
    Sweep(&b, &par, &to);
    Divide(&b);
    for (PetscInt k = 0; k < Nodes(&b.patch); k++)
      for (int d = 0; d < dim; d++) {
        const PetscReal m = b.sum[k * NC], a = constant || !(m > 0) ? 0 : sin((double)k + d);

        b.motion[k * MPM_MOTION_NC(dim) + dim + d] = a;
        b.motion[k * MPM_MOTION_NC(dim) + d] += par.kick * a;
      }
    for (int order = 1; order <= 8; order++) {
      long double norm = 0;

      for (PetscInt k = 0; k < Nodes(&b.patch); k++)
        for (int d = 0; d < dim; d++) missing[k * dim + d] = 0;
      for (PetscInt p = 0; p < N; p++) {
        long double r[3];

        Stencil(&b.patch, &b.own, p, nodes);
        for (int d = 0; d < dim; d++) {
          r[d] = b.own.v[p * dim + d];
          for (int n = 0; n < StencilSize(dim, basis); n++)
            r[d] -= nodes[n].phi * b.motion[nodes[n].at * MPM_MOTION_NC(dim) + d];
          for (int n = 0; n < StencilSize(dim, basis); n++)
            missing[nodes[n].at * dim + d] += KindOf(&par, &b.own, p)->m * nodes[n].phi * r[d];
        }
      }
      for (PetscInt k = 0; k < Nodes(&b.patch); k++)
        for (int d = 0; d < dim; d++) {
          const PetscReal  *motion = b.motion + k * MPM_MOTION_NC(dim);
          const long double m = b.sum[k * NC], all = missing[k * dim + d] + m * par.kick * motion[dim + d];

          if (m > 0) norm += all * all / m;
          if (constant && m > 1e-9) CHECK_NEAR(motion[d], 0.3 + d, 1e-12);
        }
      if (!constant) CHECK_LE(norm, last * (1 + 1e-12L));
      if (order == 1) start = norm;
      last = norm;
      Sweep(&b, &par, &filter);
      Sweep(&b, &par, &again);
      MPM_FOR_OWN_ROWS(&b.patch, rows) MPMNodesCorrect(&par, &b.patch, &rows);
    }
    if (!constant) CHECK_LE(last, 0.2L * start);
    Destroy(&b);
  }
  SetOrder(0);
}

/* A position on the upper face is in the grid, in its last cell, with weights that are none of them negative, for every
   number of cells, though (upper - lower)/h need not be a whole number in floating point.                            */
static void UpperWall(MPMBasis basis)
{
  static const PetscReal lengths[] = {1, 0.7, 2.5, 3, 0.1};

  for (PetscInt cells = 4; cells <= 500; cells++)
    for (int k = 0; k < 5; k++) {
      MPMGrid         g     = {.dim        = 1,
                               .cells      = {cells},
                               .upper      = {lengths[k]},
                               .h          = {lengths[k] / (PetscReal)cells},
                               .wall_basis = {MPM_WALL_BASIS_EXTRAP}};
      const PetscReal l     = 0.25;
      PetscReal       xi[3] = {0}, w[MPM_MAX_STENCIL], grad[MPM_MAX_STENCIL], inside = UnitStep((PetscReal)cells, -1);
      PetscInt        base[3] = {0}, last = MPMBasisBase(basis, &inside, l, cells, PETSC_FALSE, MPM_WALL_BASIS_EXTRAP);

      UnitContext("upper wall: grid 0 .. %g of %d cells, basis %d", lengths[k], (int)cells, (int)basis);
      CHECK(MPMLocate(1, basis, &g, 0, g.upper, &l, xi, base));
      CHECK_EQ(base[0], last);
      if (base[0] != last) continue;
      MPMBasisWeights(basis, xi[0], l, base[0], cells, MPM_WALL_BASIS_EXTRAP, w, grad);
      for (int i = 0; i < MPMBasisNodes(basis); i++) CHECK_GE(w[i], 0);
    }
}

static void TestPhase(int dim, MPMBasis basis, MPMWallBasis wall, const MPMPhase *phase, const char *method)
{
  static const int numbers[] = {N, 1, MPM_STAGED, MPM_STAGED + 1, N, MPM_STAGED - 1}; /* the fifth is crowded */
  static Bench     start, b, first;
  static State     s;
  MPMStatus        status, found;
  MPMParams        par = {.dt         = 0.125,
                          .kick       = 0.1875,
                          .flip       = 1,
                          .strain     = 1,
                          .order      = core.params.order,
                          .kinds      = kinds,
                          .nkinds     = nkinds,
                          .materials  = materials,
                          .nmaterials = nmaterials,
                          .walls      = &walls};

  CHECK(MPMKernelFlops(dim, basis, phase->parts) > 0);
  for (int round = 0; round < 6; round++) {
    const MPMGrid g = Grid(dim, basis, wall, round);
    char          what[160];

    snprintf(what, sizeof what, "%s %s, dim %d, basis %d, wall form %d, %d particles", method, phase->name, dim,
             (int)basis, (int)wall, numbers[round]);
    UnitContext("%s", what);
    par.flip        = round == 0 ? 1 : round == 1 ? 0 : 0.9;
    par.strain      = round == 2 ? 0.25 : 1;
    par.own_inertia = round % 2 ? PETSC_FALSE : PETSC_TRUE;
    Particles(&s, &g, numbers[round], round == 4);
    SetUp(&b, &g, basis, &s, NULL, 0, PETSC_FALSE);
    if (phase->kind != MPM_PARTICLES_TO_NODES) {
      const PetscReal size = round ? 0.05 : 0.6;

      for (PetscInt k = 0; k < Nodes(&b.patch) * MPM_MOTION_NC(dim); k++) b.motion[k] = UnitReal(-size, size);
      Images(&b);
    }
    start = b;
    for (width = 0; width < nwidths; width++) {
      UnitContext("%s, %d lanes", what, (int)widths[width].lanes);
      b = start; /* the pointers of its patch are into b */
      if (phase->kind == MPM_PARTICLES_TO_NODES) {
        status = Sweep(&b, &par, phase);
        CheckSums(&b, &s, &par, phase->parts);
      } else
        status = CheckParticlesMoved(&b, &par, phase);
      if (!width) first = b, found = status;
      CHECK_SAME(&b.own, &first.own, sizeof b.own); /* the same bits with any number of lanes */
      CHECK_SAME(b.sum, first.sum, sizeof b.sum);
      CHECK_SAME(b.span, first.span, sizeof b.span);
      CHECK_SAME(b.motion, start.motion, sizeof b.motion);
      CHECK_SAME(b.movers, first.movers, sizeof b.movers);
      CHECK(status.bad == found.bad && status.id == found.id && status.moved == found.moved &&
            status.left == found.left);
      CHECK_SAME(&status.v2, &found.v2, sizeof status.v2);
      CHECK_SAME(&status.c2, &found.c2, sizeof status.c2);
      CHECK_SAME(&status.J, &found.J, sizeof status.J);
      CHECK_SAME(status.x, found.x, sizeof status.x);
    }
    width = 0;
    Destroy(&b);
    CheckBits(&g, basis, &s, &par, phase, what);
  }
}

/* Does a transfer make the same programs as a row of the table before it? */
static int Again(const MPMTransfer *transfer)
{
  for (const MPMTransfer *t = MPMTransfers; t < transfer; t++)
    if (t->parts == transfer->parts && t->rounds == transfer->rounds) return 1;
  return 0;
}

/* Was a phase tested that differs in its name at most, in this dimension and basis and with these walls? Many programs
   have the same. */
static int Tested(int dim, MPMBasis basis, MPMWallBasis wall, const MPMPhase *phase)
{
  static struct {
    PetscInt  what[12];
    PetscReal share;
  } tested[128];
  static int      ntested, place = -1;
  const MPMNeeds *needs    = &core.needs;
  const PetscInt  what[12] = {phase->kind,   phase->parts,     phase->particles_in, phase->particles_out,
                              needs->affine, needs->forced,    needs->stretched,    needs->residual,
                              needs->barred, core.params.order};
  const int       here     = (dim * 8 + (int)basis) * 8 + (int)wall;

  if (place != here) ntested = 0;
  place = here;
  for (int k = 0; k < ntested; k++)
    if (!memcmp(tested[k].what, what, sizeof what) && tested[k].share == phase->share) return 1;
  CHECK(ntested < 128);
  memcpy(tested[ntested].what, what, sizeof what);
  tested[ntested++].share = phase->share;
  return 0;
}

/* Every phase of the program of a scheme and a transfer; forced: with body forces; stretched: cpGIMP. */
static PetscErrorCode TestMethod(int dim, MPMBasis basis, MPMWallBasis wall, const MPMMethod *m, PetscBool forced,
                                 PetscBool stretched)
{
  char method[96];

  PetscFunctionBeginUser;
  SetOrder(m->transfer->rounds != MPM_NO_ROUNDS ? 3 : 0);
  core.needs.affine    = m->transfer->parts & MPM_AFFINE ? PETSC_TRUE : PETSC_FALSE;
  core.needs.forced    = forced;
  core.needs.stretched = stretched;
  PetscCall(MPMStepSetUp(&core, m));
  snprintf(method, sizeof method, "%s %s%s%s", m->scheme->name, m->transfer->name, forced ? " with forces" : "",
           stretched ? " cpgimp" : "");
  for (PetscInt k = 0; k < core.nprogram; k++)
    if (core.program[k]->kind != MPM_NODES && !Tested(dim, basis, wall, core.program[k]))
      TestPhase(dim, basis, wall, core.program[k], method);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every scheme with every transfer that makes another program, and with the first with forces, and cpgimp. */
static PetscErrorCode TestMethods(int dim, MPMBasis basis, MPMWallBasis wall)
{
  PetscFunctionBeginUser;
  for (const MPMScheme *scheme = MPMSchemes; scheme->name; scheme++) {
    for (const MPMTransfer *transfer = MPMTransfers; transfer->name; transfer++) {
      const MPMMethod m = {scheme, transfer, 0, 0, 0};

      if (!Again(transfer)) PetscCall(TestMethod(dim, basis, wall, &m, PETSC_FALSE, PETSC_FALSE));
    }
    {
      const MPMMethod m = {scheme, MPMTransfers, 0, 0, 0};

      CHECK(!MPMTransfers[0].parts && MPMTransfers[0].rounds == MPM_NO_ROUNDS); /* flip */
      PetscCall(TestMethod(dim, basis, wall, &m, PETSC_TRUE, PETSC_FALSE));
      if (basis == MPM_BASIS_gimp) PetscCall(TestMethod(dim, basis, wall, &m, PETSC_FALSE, PETSC_TRUE));
    }
  }
  core.needs.affine = core.needs.forced = core.needs.stretched = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The constants of johnsoncook: elastic as E and nu say. */
static void Shock(MPMMaterial *m)
{
  const PetscReal K = m->E / (3 * (1 - 2 * m->nu));

  m->c0        = PetscSqrtReal(K / m->rho);
  m->shear     = m->E / (2 * (1 + m->nu));
  m->slope     = 1.2;
  m->gruneisen = 1.9;
  m->heat      = 2e-5 * K / m->rho;
  m->share     = 0.9;
  m->power = m->softening = m->rate0 = 1;
  m->temperature                     = 300;
  m->melting                         = -1;
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  Wishes();
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  FindWidths();
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++) { /* a kind a material, the first has two */
    MPMMaterial *m = &materials[nmaterials];

    *m = (MPMMaterial){.type      = type,
                       .rho       = 1000 + 100 * nkinds,
                       .E         = 3e4,
                       .nu        = 0.3,
                       .K         = 2e4,
                       .viscosity = 5,
                       .gamma     = 7,
                       .tension   = -1,
                       .yield     = 300,
                       .hardening = 100,
                       .friction  = 30,
                       .cohesion  = 10};
    if (!strcmp(type->name, "johnsoncook")) Shock(m);
    CHECK(MPMMaterialSetUp(m) == NULL);
    for (int k = 0; k < (nmaterials ? 1 : 2); k++)
      kinds[nkinds++] = (MPMKind){.material = nmaterials,
                                  .m        = UnitReal(1, 2),
                                  .V0       = UnitReal(1e-3, 2e-3),
                                  .l        = {UnitReal(0.1, 0.5), 0.25, UnitReal(0.1, 0.3)}};
    nmaterials++;
  }
  core.params.kinds     = kinds;
  core.params.nkinds    = nkinds;
  core.params.materials = materials;
  for (int b = 0; b < MPM_NUM_BASES; b++) {
    UpperWall((MPMBasis)b);
    for (int dim = 1; dim <= 3; dim++) {
      for (int wall = 0; wall < 3; wall++) {
        if (wall == 2 && !MPMBasisIsSpline((MPMBasis)b)) continue;
        PetscCall(TestMethods(dim, (MPMBasis)b, (MPMWallBasis)wall));
        for (width = 0; width < nwidths; width++) Filter(dim, (MPMBasis)b, (MPMWallBasis)wall);
        width = 0;
        SetOrder(0);
      }
      Correction(dim, (MPMBasis)b);
      for (width = 0; width < nwidths; width++) Affine(dim, (MPMBasis)b);
      width             = 0;
      core.needs.affine = PETSC_FALSE;
    }
  }
  PetscCall(PetscFinalize());
  return UnitEnd();
}
