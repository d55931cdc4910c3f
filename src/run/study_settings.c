/* study_settings.c - the settings that a work-precision study compares: every combination of its lists that the program
   takes, and the scene's own. */
#include "run/study_work.h"

/* Returns the row of a transfer. */
static const MPMTransfer *Transfer(const char name[])
{
  const MPMTransfer *t = MPMTransfers;

  while (t->name && strcmp(t->name, name)) t++;
  return t;
}

/* Options that belong to one method and would be refused or wrong with another. */
static const char *const of_one[] = {"-method_flip", "-method_order", "-method_gimp_update", "-method_affine_strain",
                                     "-method_damping_rate"};

/* Replaces all of the method by a preset, with its particles and its time step. */
static PetscErrorCode SetPreset(MPMChanges *c, MPM base, const char preset[])
{
  static const char *const chosen[] = {"-method_basis", "-method_update", "-method_transfer", "-method_wall_basis"};
  char                     name[2 * MPM_NAME_LEN];

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof of_one / sizeof of_one[0]; k++) PetscCall(MPMChangesClear(c, of_one[k]));
  for (size_t k = 0; k < sizeof chosen / sizeof chosen[0]; k++) PetscCall(MPMChangesClear(c, chosen[k]));
  for (PetscInt k = 0; k < base->scene.nbodies; k++) {
    (void)snprintf(name, sizeof name, "-body_%s_ppc", base->scene.bodies[k].name);
    PetscCall(MPMChangesClear(c, name));
  }
  PetscCall(MPMChangesClear(c, "-dt_cfl"));
  PetscCall(MPMChangesSet(c, "-method_preset", "%s", preset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the method by that of a setting. What belongs to another method is cleared. */
static PetscErrorCode SetMethod(MPMChanges *c, const MPMSetting *s)
{
  const char *const under  = strchr(s->basis, '_'); /* gimp_stretch: the basis, and the update of its domains */
  PetscBool         spline = PETSC_FALSE, domains;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof of_one / sizeof of_one[0]; k++) PetscCall(MPMChangesClear(c, of_one[k]));
  for (PetscInt b = 0; b < MPM_NUM_BASES; b++)
    if (!strcmp(MPMBasisNames[b], s->basis)) spline = MPMBasisIsSpline((MPMBasis)b);
  domains = under || !strcmp(s->basis, MPMBasisNames[MPM_BASIS_gimp]) ? PETSC_TRUE : PETSC_FALSE;
  if (!spline) PetscCall(MPMChangesClear(c, "-method_wall_basis"));
  PetscCall(MPMChangesSet(c, "-method_basis", "%.*s", (int)(under ? under - s->basis : MPM_NAME_LEN), s->basis));
  if (domains) PetscCall(MPMChangesSet(c, "-method_gimp_update", "%s", under ? under + 1 : "none"));
  PetscCall(MPMChangesSet(c, "-method_update", "%s", s->update));
  PetscCall(MPMChangesSet(c, "-method_transfer", "%s", s->transfer));
  if (s->number[0])
    PetscCall(MPMChangesSet(c, Transfer(s->transfer)->rounds != MPM_NO_ROUNDS ? "-method_order" : "-method_flip", "%s",
                            s->number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSettingApply(MPMChanges *c, MPM base, const MPMSetting *s, PetscInt level)
{
  char name[2 * MPM_NAME_LEN], list[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMChangesOfStudy(c, base, base->scene.name));
  PetscCall(MPMChangesRefine(c, base, level - base->study.coarser));
  if (s->basis[0]) PetscCall(SetMethod(c, s));
  if (s->preset[0]) PetscCall(SetPreset(c, base, s->preset));
  for (PetscInt d = 0; d < base->core.grid.dim; d++)
    (void)snprintf(list + strlen(list), sizeof list - strlen(list), "%s%" PetscInt_FMT, d ? "," : "", s->ppc);
  for (PetscInt k = 0; s->ppc > 0 && k < base->scene.nbodies; k++) {
    (void)snprintf(name, sizeof name, "-body_%s_ppc", base->scene.bodies[k].name);
    PetscCall(MPMChangesSet(c, name, "%s", list));
  }
  if (s->cfl > 0) PetscCall(MPMChangesSet(c, "-dt_cfl", "%.17g", (double)s->cfl));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options of a setting on the scene's grid. */
static PetscErrorCode TryOut(MPM base, const MPMSetting *s, MPMStudyResult *r)
{
  MPMChanges c = {0};

  PetscFunctionBeginUser;
  PetscCall(MPMSettingApply(&c, base, s, 0));
  PetscCall(MPMStudyMake(base, MPM_STUDY_DRY, r, NULL));
  PetscCall(MPMChangesUndo(&c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether two results are of the same method, particles and step. */
static PetscBool Same(const MPMStudyResult *a, const MPMStudyResult *b)
{
  return a->basis == b->basis && a->stretched == b->stretched && a->scheme == b->scheme && a->transfer == b->transfer &&
         a->flip == b->flip && a->strain == b->strain && a->rate == b->rate && a->order == b->order &&
         a->particles == b->particles && a->cfl == b->cfl && a->fixed == b->fixed;
}

/* Sets a setting to combination k of the lists. */
static void Combine(const MPMStudy *st, PetscInt k, MPMSetting *s)
{
  const PetscInt nppc = PetscMax(1, st->ppc.n), ncfl = PetscMax(1, st->cfl.n);
  const PetscInt cfl = k % ncfl, ppc = k / ncfl % nppc, transfer = k / (ncfl * nppc) % st->transfers.n;
  const PetscInt update = k / (ncfl * nppc * st->transfers.n) % st->updates.n;
  const char    *colon  = strchr(st->transfers.word[transfer], ':');

  memset(s, 0, sizeof *s);
  s->preset = "";
  s->basis  = st->bases.word[k / (ncfl * nppc * st->transfers.n * st->updates.n)];
  s->update = st->updates.word[update];
  (void)snprintf(s->transfer, sizeof s->transfer, "%.*s", (int)strcspn(st->transfers.word[transfer], ":"),
                 st->transfers.word[transfer]);
  if (colon) (void)snprintf(s->number, sizeof s->number, "%s", colon + 1);
  if (st->ppc.n) s->ppc = (PetscInt)strtol(st->ppc.word[ppc], NULL, 10);
  if (st->cfl.n) s->cfl = strtod(st->cfl.word[cfl], NULL);
  (void)snprintf(s->name, sizeof s->name, "%s %s %s", s->basis, s->update, st->transfers.word[transfer]);
  if (st->ppc.n)
    (void)snprintf(s->name + strlen(s->name), sizeof s->name - strlen(s->name), ", %s ppc", st->ppc.word[ppc]);
  if (st->cfl.n)
    (void)snprintf(s->name + strlen(s->name), sizeof s->name - strlen(s->name), ", cfl %s", st->cfl.word[cfl]);
}

PetscErrorCode MPMSettingsCreate(MPM base, PetscInt *n, MPMSetting **settings)
{
  const MPMStudy *st  = &base->study;
  const PetscInt  all = st->bases.n * st->updates.n * st->transfers.n * PetscMax(1, st->ppc.n) * PetscMax(1, st->cfl.n);
  MPMSetting scene    = {.own = PETSC_TRUE, .name = "the scene's own setting", .preset = "", .basis = "", .update = ""};
  PetscBool  found    = PETSC_FALSE;
  MPMStudyResult own, r;

  PetscFunctionBeginUser;
  *n = 0;
  PetscCall(PetscMalloc1(all + st->presets.n + 1, settings));
  PetscCall(TryOut(base, &scene, &own));
  if (own.refused[0]) { /* on a coarser grid */
    PetscCall(PetscFPrintf(base->core.comm, stderr, "-study_coarser: the coarsest run: %s\n", own.refused));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < all + st->presets.n; k++) {
    MPMSetting *s = *settings + *n;

    if (k < all)
      Combine(st, k, s);
    else {
      if (!strcmp(st->presets.word[k - all], "none")) continue;
      *s        = scene;
      s->preset = st->presets.word[k - all];
      (void)snprintf(s->name, sizeof s->name, "preset %s", s->preset);
    }
    PetscCall(TryOut(base, s, &r));
    s->own = !r.refused[0] && Same(&r, &own) ? PETSC_TRUE : PETSC_FALSE;
    if (r.refused[0] || (r.wrong[0] && !s->own)) {
      PetscCall(MPMPrint(&base->core.print, "skipped    %s: %s\n", s->name, r.refused[0] ? r.refused : r.wrong));
      continue;
    }
    if (s->own && found) continue; /* flip and flip:1 */
    if (s->own) found = PETSC_TRUE;
    (*n)++;
  }
  if (own.wrong[0]) PetscCall(MPMPrint(&base->core.print, "warning    the scene's own setting: %s\n", own.wrong));
  if (!found) (*settings)[(*n)++] = scene;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends to a text. */
static void Append(char text[MPM_TEXT_LEN], const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
static void Append(char text[MPM_TEXT_LEN], const char format[], ...)
{
  const size_t n = strlen(text);
  va_list      args;

  va_start(args, format);
  (void)vsnprintf(text + n, MPM_TEXT_LEN - n, format, args);
  va_end(args);
}

PetscErrorCode MPMSettingOptions(MPM base, const MPMSetting *s, const MPMStudyResult *r, char text[MPM_TEXT_LEN])
{
  const PetscInt dim = base->core.grid.dim;
  PetscBool      by_size;

  PetscFunctionBeginUser;
  text[0] = 0;
  Append(text, "-method_basis %s", MPMBasisNames[r->basis]);
  if (r->basis == MPM_BASIS_gimp) Append(text, " -method_gimp_update %s", r->stretched ? "stretch" : "none");
  Append(text, " -method_update %s -method_transfer %s", MPMSchemes[r->scheme].name, MPMTransfers[r->transfer].name);
  if (MPMTransfers[r->transfer].flip < 0 && MPMTransfers[r->transfer].parts & MPM_AFFINE)
    Append(text, " -method_affine_strain %g", (double)r->strain);
  if (MPMTransfers[r->transfer].flip < 0 && !(r->viscosity > 0))
    Append(text, r->rate > 0 ? " -method_damping_rate %g" : " -method_flip %g",
           (double)(r->rate > 0 ? r->rate : r->flip));
  if (MPMTransfers[r->transfer].rounds != MPM_NO_ROUNDS) Append(text, " -method_order %" PetscInt_FMT, r->order);
  PetscCall(PetscOptionsHasName(NULL, NULL, "-grid_h", &by_size));
  for (PetscInt d = 0; d < dim; d++) {
    Append(text, "%s", d ? "," : by_size ? " -grid_h " : " -grid_cells ");
    if (by_size)
      Append(text, "%.17g",
             (double)(base->core.grid.h[d] * (PetscReal)base->core.grid.cells[d] / (PetscReal)r->cells[d]));
    else
      Append(text, "%" PetscInt_FMT, r->cells[d]);
  }
  for (PetscInt k = 0; (s->ppc > 0 || s->preset[0]) && k < base->scene.nbodies; k++)
    for (PetscInt d = 0; d < dim; d++)
      Append(text, d ? ",%.0s%" PetscInt_FMT : " -body_%s_ppc %" PetscInt_FMT, base->scene.bodies[k].name,
             s->ppc > 0 ? s->ppc : (PetscInt)r->ppc);
  Append(text, r->fixed > 0 ? " -dt_size %.10g" : " -dt_cfl %.10g", (double)(r->fixed > 0 ? r->fixed : r->cfl));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the bytes of a text to a hash (FNV-1a). */
static void Hash(uint64_t *hash, const char text[])
{
  for (; *text; text++) *hash = (*hash ^ (unsigned char)*text) * 0x100000001b3ULL;
}

PetscErrorCode MPMSettingKey(MPM base, const MPMSetting *s, PetscInt level, const char with[], char key[17])
{
  static const char *const elsewhere[] = {"-options_file", "-output_dir", "-dry_run", "-log_view", "-options_left"};
  uint64_t                 hash        = 0xcbf29ce484222325ULL;
  MPMChanges               c           = {0};
  PetscMPIInt              size;
  char                    *options, processes[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(base->core.comm, &size));
  PetscCall(MPMSettingApply(&c, base, s, level));
  for (size_t k = 0; k < sizeof elsewhere / sizeof elsewhere[0]; k++) PetscCall(MPMChangesClear(&c, elsewhere[k]));
  PetscCall(MPMOptionsText(&options));
  PetscCall(MPMChangesUndo(&c));
  (void)snprintf(processes, sizeof processes, " %d ", size);
  Hash(&hash, options);
  Hash(&hash, MPMVersionGit);
  Hash(&hash, processes);
  Hash(&hash, with);
  PetscCall(PetscFree(options));
  (void)snprintf(key, 17, "%016llx", (unsigned long long)hash);
  PetscFunctionReturn(PETSC_SUCCESS);
}
