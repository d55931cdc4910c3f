/* names.c - which names of options are legal: those of the vocabulary, with the names that the scene declares; and
   which legal name is closest to one that is not. */
#include <strings.h>
#include "options/reader.h"

/* Options that PETSc reads by itself at its start or end, or for its DMs. Some are read late, so PETSc still counts
   them as unused when the names are checked. Options that would cut or number the grid in another way
   (-da_processors_x, -dm_vec_type, ...) are not among these, so that they are refused before there is a DM. */
static const char *const petsc[] = {"citations",    "get_total_flops", "log_all",           "log_view",
                                    "malloc_dump",  "malloc_view",     "memory_view",       "mpidump",
                                    "objects_dump", "options_left",    "options_view",      "skip_petscrc",
                                    "malloc_test",  "malloc_debug",    "no_signal_handler", "dm_view"};
/* How options of PETSc's solvers begin, which steps without inertia use. */
static const char *const solvers[] = {"snes_", "ksp_", "pc_", "mg_", "mat_"};
#define NUM(a) (sizeof a / sizeof a[0])

/* Finds the names that may take the place of <.> in this row; returns how many there are. */
static PetscInt Words(MPMOptions o, const MPMOptionRow *row, const char (**words)[MPM_NAME_LEN])
{
  const char *open = strchr(row->name, '<');

  *words = open && open[1] == 'm'   ? (const char(*)[MPM_NAME_LEN])o->materials
           : open && open[1] == 'b' ? (const char(*)[MPM_NAME_LEN])o->bodies
           : open && open[1] == 'l' ? (const char(*)[MPM_NAME_LEN])o->loads
           : open && open[1] == 'c' ? (const char(*)[MPM_NAME_LEN])o->contacts
           : open && open[1] == 'p' ? (const char(*)[MPM_NAME_LEN])o->probes
                                    : o->table->faces;
  if (!open) return 0;
  if (open[1] == 's') *words = (const char(*)[MPM_NAME_LEN])o->stages;
  if (open[1] == 's') return strchr(open + 1, '<') ? 0 : o->ns;
  if (open[1] == 'p') return o->np;
  if (open[1] == 'c') return o->nc;
  return open[1] == 'm' ? o->nm : open[1] == 'b' ? o->nb : open[1] == 'l' ? o->nl : open[1] == 'f' ? 2 * o->dim : 0;
}

/* Returns whether `given` is this row's name, with a name that the scene has declared so far in the place of <.>. */
static PetscBool Matches(MPMOptions o, const MPMOptionRow *row, const char given[])
{
  const char(*words)[MPM_NAME_LEN];
  const char    *open = strchr(row->name, '<');
  const PetscInt n    = Words(o, row, &words);
  char           full[MPM_FULL_LEN];

  if (!open) return !strcasecmp(row->name, given);
  if (strncasecmp(row->name, given, (size_t)(open - row->name))) return PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) {
    MPMOptionsFullName(row->name, words[k], full);
    if (!strcasecmp(full, given)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns the row of an option name, or NULL. */
static const MPMOptionRow *Find(MPMOptions o, const char given[])
{
  for (size_t r = 0; r < o->table->n; r++)
    if (o->table->row[r].name && Matches(o, &o->table->row[r], given)) return &o->table->row[r];
  given = MPMOptionsOfStage(o, given);
  return given ? Find(o, given) : NULL;
}

/* --- The closest name --------------------------------------------------------------------------------------------- */

/* Returns whether `name` ends with _ and `tail`. */
static PetscBool EndsWith(const char name[], const char tail[])
{
  const size_t n = strlen(name), nt = strlen(tail);

  return n > nt && name[n - nt - 1] == '_' && !strcasecmp(name + n - nt, tail);
}

/* Makes `candidate` the closest name if it is closer to `given` than those before. */
static void Consider(const char given[], const char candidate[], int *best, char nearest[MPM_FULL_LEN])
{
  const int d = EndsWith(candidate, given)
                    ? 1
                    : MPMOptionsDistance(given, candidate); /* "basis" is close to method_basis */

  if (d >= *best) return;
  *best = d;
  (void)snprintf(nearest, MPM_FULL_LEN, "%s", candidate);
}

/* Finds the model, shape or type that does not take the option `full` of this row, though another one does; *choice is
   NULL if there is none, or nothing legal is chosen. */
static PetscErrorCode FindRefusing(MPMOptions o, const MPMOptionRow *row, const char full[],
                                   const MPMOptionValue **choice)
{
  const char  *open = strchr(row->name, '<'), *end = open ? open + 4 : NULL, *by = NULL;
  const size_t head = open ? (size_t)(open - row->name) : 0;
  char         word[MPM_NAME_LEN], chosen[MPM_FULL_LEN], dashed[MPM_FULL_LEN + 1], value[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  *choice = NULL;
  for (size_t k = 0; k < o->table->nchoices && open; k++)
    if (!strncmp(o->table->choices[k].row, row->name, head + 4) && MPMListHas(o->table->choices[k].text, end))
      by = o->table->choices[k].row;
  if (!by) PetscFunctionReturn(PETSC_SUCCESS); /* it does not depend on a choice */
  (void)snprintf(word, sizeof word, "%.*s", (int)(strlen(full) - head - strlen(end) - 1), full + head);
  MPMOptionsFullName(by, word, chosen);
  (void)snprintf(dashed, sizeof dashed, "-%s", chosen);
  PetscCall(PetscOptionsGetString(NULL, NULL, dashed, value, sizeof value, NULL));
  for (size_t k = 0; k < o->table->nchoices; k++) {
    const MPMOptionValue *one = &o->table->choices[k];

    if (!strcmp(one->row, by) && !strcasecmp(value, one->value) && !MPMListHas(one->text, end)) *choice = one;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the legal name for which `given` is another program's word, if there are several one that the chosen model, shape
   or type takes; returns false if there is none. */
static PetscBool FromAlias(MPMOptions o, const char given[], char nearest[MPM_FULL_LEN])
{
  PetscBool found = PETSC_FALSE;

  for (size_t k = 0; k < o->table->naliases; k++)
    for (const char *tail = given; tail; tail = strchr(tail, '_') ? strchr(tail, '_') + 1 : NULL) {
      const MPMOptionRow   *row;
      const MPMOptionValue *refusing = NULL;
      char                  name[MPM_FULL_LEN];

      if (!MPMOptionsHasWord(o->table->aliases[k][0], tail, strlen(tail))) continue;
      (void)snprintf(name, MPM_FULL_LEN, "%.*s%s", (int)(tail - given), given, o->table->aliases[k][1]);
      row = Find(o, name);
      if (!row || row->type == MPM_MOVED || FindRefusing(o, row, name, &refusing)) continue;
      if (!found || !refusing) (void)snprintf(nearest, MPM_FULL_LEN, "%s", name);
      if (!refusing) return PETSC_TRUE;
      found = PETSC_TRUE;
    }
  return found;
}

/* Finds the legal name that is closest to `given`, or "" if none is close. */
static void Nearest(MPMOptions o, const char given[], char nearest[MPM_FULL_LEN])
{
  const char *rest = strchr(given, '_');
  int         best = 1 + PetscMax(2, (int)strlen(given) / 4);

  if (FromAlias(o, given, nearest)) return;
  nearest[0] = 0;
  for (size_t r = 0; r < o->table->n; r++) {
    const MPMOptionRow *row = &o->table->row[r];
    const char(*words)[MPM_NAME_LEN];
    char           word[MPM_FULL_LEN];
    const PetscInt n = row->name ? Words(o, row, &words) : 0;

    if (!row->name || row->type == MPM_LATER || row->type == MPM_MOVED) continue;
    if (!strchr(row->name, '<')) Consider(given, row->name, &best, nearest);
    for (PetscInt k = 0; k < n; k++) {
      MPMOptionsFullName(row->name, words[k], word);
      Consider(given, word, &best, nearest);
      if (rest && !strcasecmp(rest + 1, word + strcspn(row->name, "<")) && best > 0) { /* the option of another group */
        (void)snprintf(nearest, MPM_FULL_LEN, "%s", word);
        best = 0;
      }
    }
  }
  for (size_t k = 0; k < NUM(petsc); k++) Consider(given, petsc[k], &best, nearest);
}

/* --- The names that were given ------------------------------------------------------------------------------------ */

PetscBool MPMOptionsIsOfSolver(const char name[])
{
  for (size_t k = 0; k < NUM(solvers); k++)
    if (!strncasecmp(solvers[k], name, strlen(solvers[k]))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether PETSc reads this option by itself. */
static PetscBool IsPetscs(const char given[])
{
  char      time[MPM_NAME_LEN] = "";
  PetscBool set;

  for (size_t k = 0; k < NUM(petsc); k++)
    if (!strcasecmp(petsc[k], given)) return PETSC_TRUE;
  if (PetscOptionsGetString(NULL, NULL, "-method_time", time, sizeof time, &set) || !set || !strcmp(time, "explicit"))
    return PETSC_FALSE;
  return MPMOptionsIsOfSolver(given);
}

/* Returns whether `given` begins as an option of a material, body, load, probe or face does, with a name and a word. */
static PetscBool IsOfName(MPMOptions o, const char given[])
{
  for (size_t r = 0; r < o->table->n; r++) {
    const char *open = o->table->row[r].name ? strchr(o->table->row[r].name, '<') : NULL;

    if (open && strchr("mblcpf", open[1]) &&
        !strncasecmp(o->table->row[r].name, given, (size_t)(open - o->table->row[r].name)) &&
        strchr(given + (open - o->table->row[r].name), '_'))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static const char face[] = "a face of the grid";

/* Writes what is meant by a name of a face that the grid does not have, or returns PETSC_FALSE. */
static PetscBool Side(MPMOptions o, const char name[], char hint[], size_t len)
{
  const char *side = MPMOptionsForeignValue(o->table, "load_<l>_face", name);
  const char(*faces)[MPM_NAME_LEN];

  for (size_t r = 0; r < o->table->n && !side; r++) {
    const MPMOptionRow *row = &o->table->row[r];
    const PetscInt      n = row->name && strstr(row->name, "<f>") && strchr("yz", name[0]) ? Words(o, row, &faces) : 0;

    if (!n || (strcmp(name + 1, "min") && strcmp(name + 1, "max"))) continue;
    (void)snprintf(hint, len, "; the last axis is %c, with the faces %s and %s", faces[n - 1][0], faces[n - 2],
                   faces[n - 1]);
    return PETSC_TRUE;
  }
  if (side) (void)snprintf(hint, len, "; %s", side);
  return (PetscBool)(side != NULL);
}

/* Would `given` be legal with another name in the place of <m>, <b> ...? Sets name to it, *list to what declares it. */
static PetscBool IsUndeclared(MPMOptions o, const char given[], char name[MPM_NAME_LEN], const char **list)
{
  for (size_t r = 0; r < o->table->n; r++) {
    const MPMOptionRow *row  = &o->table->row[r];
    const char         *open = row->name ? strchr(row->name, '<') : NULL;
    const size_t        head = open ? (size_t)(open - row->name) : 0, n = strlen(given);

    if (!open || !strchr("mblcpf", open[1]) || strncasecmp(row->name, given, head)) continue;
    if (!EndsWith(given, open + 4) || n <= head + strlen(open + 3)) continue;
    (void)snprintf(name, MPM_NAME_LEN, "%.*s", (int)PetscMin(n - head - strlen(open + 3), MPM_NAME_LEN - 1),
                   given + head);
    *list = open[1] == 'm'   ? "among -materials"
            : open[1] == 'b' ? "among -bodies"
            : open[1] == 'l' ? "among -loads"
            : open[1] == 'c' ? "among -contacts"
            : open[1] == 'p' ? "among -probes"
                             : face;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Checks the models, shapes and types of the material, body, face or load that `given` names. A wrong one is reported
   before `given`, which may be an option of the right one. */
static PetscErrorCode CheckChoices(MPMOptions o, const char given[])
{
  PetscFunctionBeginUser;
  for (size_t r = 0; r < o->table->n; r++) {
    const MPMOptionRow *row = &o->table->row[r];
    const char(*words)[MPM_NAME_LEN];
    const PetscInt n = row->name && row->type == MPM_ENUM ? Words(o, row, &words) : 0;

    for (PetscInt k = 0; k < n; k++) {
      char         full[MPM_FULL_LEN], dashed[MPM_FULL_LEN + 1], ignored[MPM_NAME_LEN];
      const size_t head = strcspn(row->name, "<") + strlen(words[k]) + 1; /* body_disk1_ of body_<b>_shape */
      PetscBool    set;

      MPMOptionsFullName(row->name, words[k], full);
      (void)snprintf(dashed, sizeof dashed, "-%s", full);
      PetscCall(PetscOptionsHasName(NULL, NULL, dashed, &set));
      if (set && !strncasecmp(full, given, head)) PetscCall(MPMOptionsEnum(o, row->name, words[k], ignored, NULL));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -dm_view writes to standard output: each DM that wrote to a file or a window would take the place of the one before.
   */
static void CheckView(MPMOptions o, const char name[], const char value[])
{
  if (strcasecmp(name, "dm_view") || !value || !value[0] || !strcmp(value, "::ascii_info_detail")) return;
  MPMOptionsFail(o, "-dm_view %.*s: it takes no value, or ::ascii_info_detail, which adds the bytes of the particles",
                 MPM_NAME_LEN, value);
}

/* Returns what follows the name of a material, body, load ... in an option: a body may be called rigid. */
static const char *OwnWords(MPMOptions o, const char given[])
{
  for (size_t r = 0; r < o->table->n; r++) {
    const MPMOptionRow *row = &o->table->row[r];
    const char(*words)[MPM_NAME_LEN];
    const PetscInt n    = row->name ? Words(o, row, &words) : 0;
    const size_t   head = row->name ? strcspn(row->name, "<") : 0;

    for (PetscInt k = 0; k < n; k++)
      if (!strncasecmp(row->name, given, head) && !strncasecmp(words[k], given + head, strlen(words[k])) &&
          given[head + strlen(words[k])] == '_')
        return given + head + strlen(words[k]) + 1;
  }
  return given;
}

/* Refuses a name that is not in the vocabulary. Where the closest option is one that the chosen model, shape or type
   does not take, the message says what it takes. */
static PetscErrorCode Refuse(MPMOptions o, const char given[])
{
  char nearest[MPM_FULL_LEN] = "", alias[MPM_FULL_LEN], name[MPM_NAME_LEN], why[MPM_FULL_LEN] = "",
       hint[MPM_TEXT_LEN / 2] = "; pebble -help lists them";
  const MPMOptionRow   *row;
  const MPMOptionValue *choice = NULL;
  const char *list, *foreign = MPMOptionsForeign(o->table, OwnWords(o, given)), *of = MPMOptionsOfStage(o, given);

  PetscFunctionBeginUser;
  if (of) Nearest(o, of, nearest);
  if (of && FromAlias(o, given, alias)) (void)snprintf(nearest, sizeof nearest, "%s", alias + (of - given));
  if (MPMOptionsRefuseOfStage(o, given, nearest)) PetscFunctionReturn(PETSC_SUCCESS);
  Nearest(o, given, nearest);
  if (foreign && !(o->nb && IsUndeclared(o, given, name, &list)) && !FromAlias(o, given, alias) &&
      MPMOptionsDistance(given, nearest) > 1) {
    MPMOptionsFail(o, "-%.*s is not an option of this scene; %s", MPM_FULL_LEN, given, foreign);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  row = nearest[0] ? Find(o, nearest) : NULL; /* NULL also for an option of PETSc */
  if (row) PetscCall(FindRefusing(o, row, nearest, &choice));
  if (choice)
    (void)snprintf(hint, sizeof hint, "; %s %s takes %s%s", strchr(choice->row, '>') + 2, choice->value,
                   choice->text[0] ? choice->text : "no such option",
                   strstr(choice->row, "<m>") ? ", besides rho and k0" : "");
  else if (nearest[0])
    (void)snprintf(hint, sizeof hint, "; did you mean -%s ?", nearest);
  if (o->nb && IsUndeclared(o, given, name, &list)) {
    (void)snprintf(why, sizeof why, " (%s is not %s)", name, list);
    if (!(list == face && Side(o, name, hint, sizeof hint)) && MPMOptionsDistance(given, nearest) > 1) hint[0] = 0;
  }
  MPMOptionsFail(o, "-%.*s is not an option of this scene%s%s", MPM_FULL_LEN, given, why, hint);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses two names that make the same option: body "x" with _inner_radius, and body "x_inner" with _radius. */
static void RefuseTwins(MPMOptions o, char kind, const char x[], const char y[])
{
  char full[MPM_FULL_LEN], other[MPM_FULL_LEN];

  for (size_t r = 0; r < o->table->n * o->table->n; r++) {
    const char *one = o->table->row[r / o->table->n].name, *two = o->table->row[r % o->table->n].name;

    if (!one || !two || !strchr(one, '<') || !strchr(two, '<')) continue;
    if (strchr(one, '<')[1] != kind || strchr(two, '<')[1] != kind) continue;
    MPMOptionsFullName(one, x, full);
    MPMOptionsFullName(two, y, other);
    if (!strcasecmp(full, other)) MPMOptionsFail(o, "-%s could be of %s and of %s; rename one of them", full, x, y);
  }
}

/* Refuses pairs of the n names that may make the same option. */
static void RefuseAmbiguous(MPMOptions o, char kind, PetscInt n, char (*names)[MPM_NAME_LEN])
{
  for (PetscInt x = 0; x < n; x++)
    for (PetscInt y = 0; y < n; y++) {
      const size_t len = strlen(names[x]);

      if (!strncasecmp(names[x], names[y], len) && names[y][len] == '_') RefuseTwins(o, kind, names[x], names[y]);
    }
}

/* Returns whether `given` is a misspelt name of a list of names, a model, shape or type that is not given. It explains why
   other names are not legal. */
static PetscBool IsChoice(MPMOptions o, const char given[])
{
  char                nearest[MPM_FULL_LEN], dashed[MPM_FULL_LEN + 1];
  const MPMOptionRow *row;
  PetscBool           set;

  if (Find(o, given) || IsPetscs(given)) return PETSC_FALSE;
  Nearest(o, given, nearest);
  row = nearest[0] ? Find(o, nearest) : NULL;
  if (!row || !(row->type == MPM_NAMES || (row->type == MPM_ENUM && strchr(row->name, '<')))) return PETSC_FALSE;
  (void)snprintf(dashed, sizeof dashed, "-%s", nearest);
  return !(PetscOptionsHasName(NULL, NULL, dashed, &set) || set);
}

void MPMOptionsDeclareOthers(MPMOptions o, PetscInt np, char (*probes)[MPM_NAME_LEN], PetscInt nc,
                             char (*contacts)[MPM_NAME_LEN])
{
  o->np       = np;
  o->probes   = probes;
  o->nc       = nc;
  o->contacts = contacts;
}

/* Takes the names that the scene declares, then refuses every given option that is not in the vocabulary or not built
   yet. If the declarations themselves had a fault (nm = nb = 0), options of materials, bodies, loads and faces pass.
   Another name that is not legal is then reported instead, as it explains more: -matrials soft, rather than "-materials
   is required". Not collective. */
PetscErrorCode MPMOptionsDeclare(MPMOptions o, PetscInt dim, PetscInt nm, char (*materials)[MPM_NAME_LEN], PetscInt nb,
                                 char (*bodies)[MPM_NAME_LEN], PetscInt nl, char (*loads)[MPM_NAME_LEN])
{
  PetscInt n;
  char   **names, **values, fault[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  o->dim       = dim;
  o->nm        = nm;
  o->nb        = nb;
  o->materials = materials;
  o->bodies    = bodies;
  o->nl        = nl;
  o->loads     = loads;
  PetscCall(PetscStrncpy(fault, o->error, sizeof fault));
  o->error[0] = 0;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n && !o->error[0] && o->nb; k++)
    if (IsChoice(o, names[k])) PetscCall(Refuse(o, names[k]));
  for (PetscInt k = 0; k < n && !o->error[0]; k++) {
    const MPMOptionRow *row = Find(o, names[k]);

    CheckView(o, names[k], values[k]);
    if (IsPetscs(names[k])) continue;
    if (fault[0] && (IsOfName(o, names[k]) || !strncasecmp(names[k], "stage_", 6))) continue;
    if (!row) {
      PetscCall(CheckChoices(o, names[k]));
      PetscCall(Refuse(o, names[k]));
    } else if (row->type == MPM_LATER)
      MPMOptionsFail(o, "-%.*s is not built yet (%s)", MPM_FULL_LEN, names[k], row->help);
    else if (row->type == MPM_MOVED)
      MPMOptionsFail(o, "-%.*s is no option: %s", MPM_FULL_LEN, names[k], row->help);
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  if (fault[0] && !o->error[0]) PetscCall(PetscStrncpy(o->error, fault, sizeof o->error));
  RefuseAmbiguous(o, 'm', nm, materials);
  RefuseAmbiguous(o, 'b', nb, bodies);
  RefuseAmbiguous(o, 'l', nl, loads);
  RefuseAmbiguous(o, 'p', o->np, o->probes);
  RefuseAmbiguous(o, 'c', o->nc, o->contacts);
  o->materials = o->bodies = o->loads = o->probes = o->contacts = NULL; /* the caller owns them */
  o->nm = o->nb = o->nl = o->np = o->nc = o->ns = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options of the vocabulary that were given but that nothing in this scene asked for. Not collective. */
PetscErrorCode MPMOptionsFinish(MPMOptions o)
{
  PetscInt n;
  char   **names, **values;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n; k++) {
    PetscBool asked = (PetscBool)(IsPetscs(names[k]) || !strncasecmp(names[k], "stage_", 6)); /* run/stages.c */

    for (PetscInt a = 0; a < o->nasked; a++)
      if (!strcasecmp(o->asked[a], names[k])) asked = PETSC_TRUE;
    if (!asked && !strncasecmp(names[k], "source_", 7) && strrchr(names[k], '_') > names[k] + 7)
      MPMOptionsFail(o, "-%s does not apply: %.*s is not among -sources", names[k],
                     (int)(strrchr(names[k], '_') - names[k] - 7), names[k] + 7);
    if (!asked) MPMOptionsFail(o, "-%s has no effect in this scene; remove it", names[k]);
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}
