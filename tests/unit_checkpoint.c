/* unit_checkpoint.c - what is written to a checkpoint is read back bit by bit, with any fields and any numbers; and a file
   that is not exactly what was written is refused: bits flipped, bytes lost, added, moved, doubled or overwritten.
   MUTATIONS in the environment: how many such files are tried (2000). */
#include "unit.h"

#include <petscsys.h>
#include <sys/stat.h>
#include <unistd.h>
#include "restart/checkpoint.h"
#include "unit_particles.h"

#if defined(PETSC_HAVE_HDF5)

#define N    41
#define MOST 400

typedef struct {
  PetscReal  real[MOST], other;
  PetscInt   whole[3], empty;
  PetscInt64 wide[2];
  PetscBool  yes;
  char       text[64];
  MPMSum     sum[2];
  PetscInt   undone;
} Things;

static void List(Things *t, PetscInt n, MPMVariables *v)
{
  const MPMVariable table[] = {
      {"real", MPM_VARIABLE_REAL, n, t->real, MPM_KEPT},
      {"other", MPM_VARIABLE_REAL, 1, &t->other, MPM_KEPT | MPM_UNDONE},
      {"whole", MPM_VARIABLE_INT, 3, t->whole, MPM_KEPT},
      {"empty", MPM_VARIABLE_INT, 0, &t->empty, MPM_KEPT},
      {"missing", MPM_VARIABLE_INT, 5, NULL, MPM_KEPT},
      {"wide", MPM_VARIABLE_INT64, 2, t->wide, MPM_KEPT},
      {"yes", MPM_VARIABLE_BOOL, 1, &t->yes, MPM_KEPT | MPM_UNDONE},
      {"text", MPM_VARIABLE_TEXT, 64, t->text, MPM_KEPT},
      {"sum", MPM_VARIABLE_SUM, 2, t->sum, MPM_KEPT | MPM_UNDONE},
      {"undone", MPM_VARIABLE_BYTES, sizeof t->undone, &t->undone, MPM_UNDONE},
  };

  v->n = (PetscInt)(sizeof table / sizeof table[0]);
  memcpy(v->row, table, sizeof table);
}

static void Fill(Things *t)
{
  const PetscReal odd[] = {-0.0, 5e-324, PETSC_MAX_REAL, -1e-310, INFINITY, NAN, 0.1};

  memset(t, 0, sizeof *t);
  for (int k = 0; k < MOST; k++) t->real[k] = k < 7 ? odd[k] : UnitReal(-1, 1);
  t->other    = UnitReal(-1, 1);
  t->whole[0] = -1;
  t->whole[1] = PETSC_MAX_INT;
  t->whole[2] = UnitInt(1000);
  t->wide[0]  = INT64_MIN;
  t->wide[1]  = INT64_MAX;
  t->yes      = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  for (int k = 0; k < 20; k++) MPMSumAdd(&t->sum[k % 2], ldexp(UnitReal(-1, 1), UnitInt(100) - 50));
  t->undone = UnitInt(1000);
  (void)snprintf(t->text, sizeof t->text, "%.*s", UnitInt(60),
                 "a text, with \"quotes\", 'blanks' and\nlines; it is long enough");
}

/* Makes particles with any fields, and a core that has nothing else. */
static PetscErrorCode Make(MPMCore *core, MPMScene *scene, PetscInt64 id[], PetscBool all)
{
  MPMNeeds needs = UnitNeeds();
  MPMView  view;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(core, sizeof *core));
  PetscCall(PetscMemzero(scene, sizeof *scene));
  needs.all           = all;
  core->comm          = PETSC_COMM_SELF;
  core->exchange.data = PETSC_COMM_SELF;
  core->grid.dim      = 1 + UnitInt(3);
  PetscCall(MPMParticlesLayout(&core->particles, core->grid.dim, &needs));
  PetscCall(MPMParticlesCreate(&core->particles, PETSC_COMM_SELF));
  PetscCall(MPMParticlesSetSize(&core->particles, N));
  core->particles.total = N;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id) | MPM_BIT(x), &view));
  for (PetscInt p = 0; p < N; p++) {
    id[p] = view.id[p] = 7 * p;
    for (PetscInt d = 0; d < core->grid.dim; d++) view.x[p * core->grid.dim + d] = UnitReal(0, 1);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id) | MPM_BIT(x), &view));
  PetscCall(UnitRows(&core->particles, id, 1, MPM_SWARM, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes particles and things, spoils them, reads them again, and compares. */
static PetscErrorCode RoundTrip(const char path[], PetscBool all)
{
  MPMCore      core;
  MPMScene     scene;
  MPMVariables kept;
  Things       was, is;
  PetscInt64   id[N];
  PetscInt     n = UnitInt(MOST);
  PetscReal    bytes;
  char         fault[MPM_TEXT_LEN], names[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Make(&core, &scene, id, all));
  Fill(&was);
  List(&was, n, &kept);
  PetscCall(MPMCheckpointWrite(path, &core, &scene, &kept, &bytes, fault));
  CHECK(!fault[0]);
  PetscCall(MPMCheckpointCheck(path, PETSC_COMM_SELF, fault));
  UnitContext("%s", fault);
  CHECK(!fault[0]);
  is = was;
  memset(is.real, 0, (size_t)n * sizeof *is.real);
  is.other = is.whole[0] = is.whole[1] = is.whole[2] = 0;
  is.wide[0] = is.wide[1] = 0;
  is.yes                  = !is.yes;
  memset(is.text, 0, sizeof is.text);
  memset(is.sum, 0x55, sizeof is.sum);
  List(&is, n, &kept);
  PetscCall(MPMCheckpointRead(path, PETSC_COMM_SELF, &kept, fault));
  UnitContext("%s", fault);
  CHECK(!fault[0]);
  CHECK_SAME(is.real, was.real, sizeof was.real);
  CHECK_SAME(&is.other, &was.other, sizeof was.other);
  CHECK_SAME(is.whole, was.whole, sizeof was.whole);
  CHECK_SAME(is.wide, was.wide, sizeof was.wide);
  CHECK(is.yes == was.yes);
  CHECK(!strcmp(is.text, was.text));
  for (int k = 0; k < 2; k++) CHECK_EQ(MPMSumValue(&is.sum[k]), MPMSumValue(&was.sum[k]));
  kept.row[0].n = n + 1; /* another program's list */
  PetscCall(MPMCheckpointRead(path, PETSC_COMM_SELF, &kept, fault));
  CHECK(fault[0]);
  PetscCall(MPMCheckpointFields(path, PETSC_COMM_SELF, names));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *rows;

    CHECK(MPMListHas(names, MPMFields[f].name) == (core.particles.present[f] && MPMCheckpointHasField(f)));
    if (!core.particles.present[f] || !MPMCheckpointHasField(f)) continue;
    PetscCall(MPMParticlesGetField(&core.particles, f, &rows));
    if (f != MPM_FIELD_INDEX_x) memset(rows, 0xaa, N * (size_t)core.particles.bytes[f]);
    PetscCall(MPMCheckpointRows(path, &core.particles, f, 0, 17, rows));
    PetscCall(MPMCheckpointRows(path, &core.particles, f, 17, N - 17, (char *)rows + 17 * core.particles.bytes[f]));
    PetscCall(MPMParticlesRestoreField(&core.particles, f));
  }
  PetscCall(UnitRows(&core.particles, id, 1, MPM_SWARM, PETSC_TRUE));
  PetscCall(MPMParticlesDestroy(&core.particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static size_t Read(const char path[], char **data)
{
  FILE  *f = fopen(path, "rb");
  size_t n, read;

  (void)fseek(f, 0, SEEK_END);
  n     = (size_t)ftell(f);
  *data = malloc(2 * n);
  rewind(f);
  read = fread(*data, 1, n, f);
  CHECK_EQ(read, n);
  (void)fclose(f);
  return n;
}

/* Changes the n bytes, for which there is room twice; returns how many there are then. */
static size_t Mutate(char *data, size_t n)
{
  const size_t at = UnitBits() % n, to = UnitBits() % n, m = 1 + UnitBits() % 64,
               most = PetscMin(m, n - PetscMax(at, to));

  switch (UnitInt(9)) {
  case 0:
    data[at] ^= (char)(1 << UnitInt(8));
    return n;
  case 1:
    data[at % 512] ^= (char)(1 << UnitInt(8));
    return n; /* of the user block */
  case 2:
    memset(data + at, UnitInt(256), most);
    return n;
  case 3:
    memmove(data + to, data + at, most);
    return n;
  case 4:
    return at;
  case 5:
    return n - PetscMin(n - 1, m);
  case 6:
    memcpy(data + n, data + at, n - at);
    return 2 * n - at; /* doubled from there on */
  case 7:
    memmove(data + at, data + at + most, n - at - most);
    return n - most;
  default:
    for (size_t k = 0; k < most; k++) data[at + k] = (char)UnitBits();
    return n;
  }
}

static PetscErrorCode Mutations(const char path[], long wanted)
{
  char  *good, *bad, fault[MPM_TEXT_LEN];
  size_t n    = Read(path, &good);
  long   same = 0, refused = 0;

  PetscFunctionBeginUser;
  bad = malloc(2 * n);
  for (long k = 0; k < wanted; k++) {
    size_t length;
    FILE  *f = fopen("mutated.h5", "wb");

    memcpy(bad, good, n);
    length = Mutate(bad, n);
    (void)fwrite(bad, 1, length, f);
    (void)fclose(f);
    PetscCall(MPMCheckpointCheck("mutated.h5", PETSC_COMM_SELF, fault));
    UnitContext("mutation %ld, %zu bytes", k, length);
    if (length == n && !memcmp(bad, good, n))
      same++;
    else {
      CHECK(fault[0]);
      refused += fault[0] ? 1 : 0;
    }
  }
  printf("figures    checkpoints: %ld mutated files of %zu bytes, %ld of them the same as before, %ld refused\n",
         wanted, n, same, refused);
  free(good);
  free(bad);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void)
{
  const char *wanted = getenv("MUTATIONS");

  PetscFunctionBeginUser;
  for (int k = 0; k < 40; k++) PetscCall(RoundTrip("round.h5", k == 39 ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(Mutations("round.h5", wanted ? atol(wanted) : 2000));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
static PetscErrorCode Run(void)
{
  CHECK(1);
  return PETSC_SUCCESS;
}
#endif

/* What a step that is undone puts back, and nothing else. */
static PetscErrorCode PutBack(void)
{
  MPMVariables v;
  Things       was, is;
  char        *copy;

  PetscFunctionBeginUser;
  Fill(&was);
  is = was;
  List(&is, MOST, &v);
  PetscCall(MPMVariablesSave(&v, &copy));
  memset(&is, 0x55, sizeof is);
  PetscCall(MPMVariablesPutBack(&v, copy));
  PetscCall(PetscFree(copy));
  CHECK_SAME(&is.other, &was.other, sizeof was.other);
  CHECK_SAME(&is.yes, &was.yes, sizeof was.yes);
  CHECK_SAME(is.sum, was.sum, sizeof was.sum);
  CHECK_EQ(is.undone, was.undone);
  CHECK_EQ(is.whole[2], 0x55555555);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(Run());
  PetscCall(PutBack());
  PetscCall(PetscFinalize());
  return UnitEnd();
}
