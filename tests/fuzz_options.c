/* fuzz_options.c - libFuzzer's harness of all that reads options (make fuzz, tests/fuzz.py): options files, YAML files,
   arguments, names, numbers and expressions, up to a scene that is read. The first character of an input chooses how it
   comes: F an options file, Y a YAML file, A arguments, one a line, other ones lines that override those of a small scene.
   A fault that is reported as one line is right; an error of PETSc once the options are read, a second line, and whatever
   the sanitizers find are not. */
#include <ctype.h>
#include <unistd.h>
#include <sanitizer/lsan_interface.h>
#include "run/mpm.h"
#include "options/reader.h"

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n);

static const char scene[] = "-dim 2 -grid_lower 0,0 -grid_upper 1,1 -grid_cells 8,8 -materials m -material_m_model "
                            "neohookean -material_m_rho 1 -material_m_E 1 -material_m_nu 0.3 -bodies b -body_b_shape "
                            "box -body_b_lower 0,0 -body_b_upper 0.5,0.5 -body_b_material m -time_end 1";
static PetscBool  faults; /* may PETSc report faults? */

/* Keeps an error of PETSc in what it reads itself; any other is a defect. */
static PetscErrorCode Handle(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                             PetscErrorType type, const char *text, void *context)
{
  (void)comm, (void)type, (void)context;
  if (faults) return code;
  fprintf(stderr, "%s:%d: %s: %s\n", file, line, function, text ? text : "");
  abort();
}

/* Stops at a message that is not one line. */
static void CheckLine(const char text[])
{
  for (const char *c = text; *c; c++)
    if (*c == '\n' && c[1]) {
      fprintf(stderr, "not one line: %s\n", text);
      abort();
    }
}

/* Returns whether the particles of the scene are so few that they may be counted. */
static PetscBool IsSmall(MPM mpm)
{
  const MPMGrid *grid = &mpm->core.grid;
  PetscReal      all  = 0;

  for (PetscInt k = 0; k < mpm->scene.nbodies; k++) {
    PetscReal lower[3], upper[3], n = 1;

    MPMRegionBounds(&mpm->scene.bodies[k].region, grid->dim, lower, upper);
    for (PetscInt d = 0; d < grid->dim; d++)
      n *= 2 + (upper[d] - lower[d]) / grid->h[d] * (PetscReal)mpm->scene.bodies[k].ppc[d];
    all += n;
  }
  return all < 5000 ? PETSC_TRUE : PETSC_FALSE;
}

/* Reads a scene from PETSc's options. */
static PetscErrorCode Read(void)
{
  MPM        mpm;
  MPMOptions o;
  char      *text;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsText(&text));
  PetscCall(PetscFree(text));
  PetscCall(MPMCreate(PETSC_COMM_SELF, &mpm));
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &o));
  PetscCall(MPMReadOptions(mpm, o));
  if (!MPMOptionsError(o) && IsSmall(mpm)) PetscCall(MPMSceneCountParticles(&mpm->scene, &mpm->core, o));
  if (!MPMOptionsError(o) && mpm->scene.rows) PetscCall(MPMDoubtsRefuse(&mpm->core, &mpm->scene, &mpm->time, o));
  if (MPMOptionsError(o)) CheckLine(MPMOptionsError(o));
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives PETSc the options of a file. Returns whether it takes them. */
static PetscBool TakeFile(const uint8_t *data, size_t n, PetscBool yaml, PetscBool more)
{
  const char    *path                = yaml ? "scene.yaml" : "scene.opts";
  FILE          *file                = fopen(path, "w");
  char           error[MPM_TEXT_LEN] = "";
  PetscErrorCode code;

  if (!file || fwrite(data, 1, n, file) != n || fclose(file)) abort();
  MPMOptionsCheckFile(path, 0, error, sizeof error);
  CheckLine(error);
  if (error[0]) return PETSC_FALSE;
  faults = PETSC_TRUE;
  __lsan_disable(); /* after a fault PETSc does not free what it read */
  if (more) (void)PetscOptionsInsertString(NULL, scene);
  code = yaml ? PetscOptionsInsertFileYAML(PETSC_COMM_SELF, NULL, path, PETSC_TRUE)
              : PetscOptionsInsertFile(PETSC_COMM_SELF, NULL, path, PETSC_TRUE);
  __lsan_enable();
  faults = PETSC_FALSE;
  return code ? PETSC_FALSE : PETSC_TRUE;
}

/* Gives PETSc arguments, one a line. Returns whether it takes them: it then looks at them until it takes other ones. */
static PetscBool TakeArguments(const uint8_t *data, size_t n)
{
  static char   *kept, **kept_argv;
  char          *text = calloc(n + 1, 1), **argv = calloc(n + 2, sizeof *argv), **given = argv, *save = NULL;
  int            argc = 1, status;
  PetscErrorCode code;
  static char    name[] = "pebble";

  if (!argv || !text) abort();
  memcpy(text, data, n);
  argv[0] = name;
  for (char *word = strtok_r(text, "\n", &save); word; word = strtok_r(NULL, "\n", &save)) argv[argc++] = word;
  if (MPMOptionsStart(&MPMOptionTable, argc, argv, &status)) {
    free(argv);
    free(text);
    return PETSC_FALSE;
  }
  faults = PETSC_TRUE;
  __lsan_disable();
  code = PetscOptionsInsert(NULL, &argc, &given, NULL);
  __lsan_enable();
  faults = PETSC_FALSE;
  free(kept_argv);
  free(kept);
  kept_argv = argv;
  kept      = text;
  return code ? PETSC_FALSE : PETSC_TRUE;
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  static char name[] = "fuzz", handler[] = "-no_signal_handler",
              *words[] = {name, handler, NULL}; /* PETSc keeps them */
  char **given         = words;
  int    n             = 2;

  (void)argc, (void)argv;
  __lsan_disable(); /* what MPI never frees */
  if (PetscInitialize(&n, &given, NULL, NULL) || PetscPushErrorHandler(Handle, NULL)) abort();
  __lsan_enable();
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
  PetscBool taken;

  if (!n) return 0;
  faults = PETSC_TRUE; /* a level that is still pushed after a fault */
  (void)PetscOptionsClear(NULL);
  faults = PETSC_FALSE;
  MPMOptionsForget();
  if (data[0] == 'A')
    taken = TakeArguments(data + 1, n - 1);
  else
    taken = TakeFile(data + 1, n - 1, data[0] == 'Y' ? PETSC_TRUE : PETSC_FALSE,
                     data[0] == 'Y' || data[0] == 'F' ? PETSC_FALSE : PETSC_TRUE);
  if (taken && Read()) abort();
  return 0;
}
