/* unit_options.c - the readers of options: a value that is given comes out as it is, one that is not is the default of
   the table, where that is a value, and else what the caller had. The vocabulary is one of this test's own. */
#include "options/options.h"
#include "unit.h"

static const MPMOptionRow rows[] = {
    {NULL, MPM_LATER, "", "", "", "a group"},
    {"real", MPM_REAL, "[0,10]", "", "2.5", "a number"},
    {"real_told", MPM_REAL, "[0,10]", "", "h/2", "a number"},
    {"whole", MPM_INT, "[0,100]", "", "16", "a whole number"},
    {"whole_told", MPM_INT, "[0,100]", "", "no limit", "a whole number"},
    {"yes", MPM_BOOL, "", "", "true", "a truth"},
    {"no", MPM_BOOL, "", "", "false", "a truth"},
    {"choice", MPM_ENUM, "a|b|c d", "", "b", "a choice"},
    {"choice_told", MPM_ENUM, "a|b|c d", "", "b in 2-D", "a choice"},
    {"text", MPM_TEXT, "", "", "word", "a text"},
    {"text_told", MPM_TEXT, "", "", "the file's name", "a text"},
    {"reals", MPM_REALS, "(-inf,inf)", "", "0.5", "numbers"},
    {"reals_told", MPM_REALS, "(-inf,inf)", "", "as the box", "numbers"},
    {"wholes", MPM_INTS, "[1,64]", "", "2", "whole numbers"},
    {"wholes_told", MPM_INTS, "[1,64]", "", "or others", "whole numbers"},
    {"none", MPM_NAMES, "", "", "none", "names"},
    {"part_<b>_whole", MPM_INT, "[0,100]", "", "7", "a whole number of a part"},
};
static const MPMVocabulary table = {sizeof rows / sizeof rows[0], rows};

static MPMOptions Open(void)
{
  MPMOptions o;

  PetscCallAbort(PETSC_COMM_SELF, MPMOptionsCreate(&table, &o));
  PetscCallAbort(PETSC_COMM_SELF, MPMOptionsDeclare(o, 2, 0, NULL, 0, NULL, 0, NULL));
  return o;
}

#define READ(call) PetscCallAbort(PETSC_COMM_SELF, call)

/* What is read when nothing is given. */
static void Defaults(void)
{
  MPMOptions o    = Open();
  PetscReal  real = -1, told = -1, reals[3] = {-1, -1, -1}, reals_told[3] = {-1, -1, -1};
  PetscInt   whole = -1, whole_told = -1, part = -1, wholes[3] = {-1, -1, -1}, wholes_told[3] = {-1, -1, -1}, n = -1;
  PetscBool  yes = PETSC_FALSE, no = PETSC_TRUE, set[9];
  char       choice[MPM_NAME_LEN] = "", choice_told[MPM_NAME_LEN] = "kept", text[MPM_TEXT_LEN] = "",
       text_told[MPM_TEXT_LEN] = "kept", (*names)[MPM_NAME_LEN];

  UnitContext("defaults");
  READ(MPMOptionsReal(o, "real", NULL, &real, &set[0]));
  READ(MPMOptionsReal(o, "real_told", NULL, &told, NULL));
  READ(MPMOptionsInt(o, "whole", NULL, &whole, &set[1]));
  READ(MPMOptionsInt(o, "whole_told", NULL, &whole_told, NULL));
  READ(MPMOptionsInt(o, "part_<b>_whole", "x", &part, &set[2]));
  READ(MPMOptionsBool(o, "yes", NULL, &yes));
  READ(MPMOptionsBool(o, "no", NULL, &no));
  READ(MPMOptionsEnum(o, "choice", NULL, choice, &set[3]));
  READ(MPMOptionsEnum(o, "choice_told", NULL, choice_told, NULL));
  READ(MPMOptionsString(o, "text", NULL, text, &set[4]));
  READ(MPMOptionsString(o, "text_told", NULL, text_told, NULL));
  READ(MPMOptionsReals(o, "reals", NULL, reals, &set[5]));
  READ(MPMOptionsReals(o, "reals_told", NULL, reals_told, NULL));
  READ(MPMOptionsInts(o, "wholes", NULL, wholes, &set[6]));
  READ(MPMOptionsInts(o, "wholes_told", NULL, wholes_told, NULL));
  READ(MPMOptionsNames(o, "none", &n, &names));
  CHECK(!MPMOptionsError(o));
  CHECK_EQ(real, 2.5);
  CHECK_EQ(told, -1);
  CHECK_EQ(whole, 16);
  CHECK_EQ(whole_told, -1);
  CHECK_EQ(part, 7);
  CHECK_EQ(yes, PETSC_TRUE);
  CHECK_EQ(no, PETSC_FALSE);
  CHECK(!strcmp(choice, "b"));
  CHECK(!strcmp(choice_told, "kept"));
  CHECK(!strcmp(text, "word"));
  CHECK(!strcmp(text_told, "kept"));
  for (int d = 0; d < 3; d++) {
    CHECK_EQ(reals[d], d < 2 ? 0.5 : -1);
    CHECK_EQ(reals_told[d], -1);
    CHECK_EQ(wholes[d], d < 2 ? 2 : -1);
    CHECK_EQ(wholes_told[d], -1);
  }
  CHECK_EQ(n, 0);
  for (int k = 0; k < 7; k++) CHECK_EQ(set[k], PETSC_FALSE);
  READ(MPMOptionsDestroy(&o));
}

/* What is given comes before the default. */
static void Values(void)
{
  MPMOptions o;
  PetscReal  real, reals[3];
  PetscInt   whole, part, wholes[3];
  PetscBool  yes, set[6];
  char       choice[MPM_NAME_LEN], text[MPM_TEXT_LEN];

  UnitContext("values");
  READ(PetscOptionsInsertString(NULL, "-real 3 -whole 5 -part_x_whole 8 -yes false -choice C -text other -reals 1,-2 "
                                      "-wholes 3,4"));
  READ(MPMOptionsCreate(&table, &o));
  {
    char bodies[1][MPM_NAME_LEN] = {"x"};

    READ(MPMOptionsDeclare(o, 2, 0, NULL, 1, bodies, 0, NULL));
  }
  READ(MPMOptionsReal(o, "real", NULL, &real, &set[0]));
  READ(MPMOptionsInt(o, "whole", NULL, &whole, &set[1]));
  READ(MPMOptionsInt(o, "part_<b>_whole", "x", &part, &set[2]));
  READ(MPMOptionsBool(o, "yes", NULL, &yes));
  READ(MPMOptionsEnum(o, "choice", NULL, choice, &set[3]));
  READ(MPMOptionsString(o, "text", NULL, text, &set[4]));
  READ(MPMOptionsReals(o, "reals", NULL, reals, &set[5]));
  READ(MPMOptionsInts(o, "wholes", NULL, wholes, NULL));
  CHECK(!MPMOptionsError(o));
  CHECK_EQ(real, 3);
  CHECK_EQ(whole, 5);
  CHECK_EQ(part, 8);
  CHECK_EQ(yes, PETSC_FALSE);
  CHECK(!strcmp(choice, "c"));
  CHECK(!strcmp(text, "other"));
  CHECK_EQ(reals[0], 1);
  CHECK_EQ(reals[1], -2);
  CHECK_EQ(wholes[0], 3);
  CHECK_EQ(wholes[1], 4);
  for (int k = 0; k < 6; k++) CHECK_EQ(set[k], PETSC_TRUE);
  READ(MPMOptionsDestroy(&o));
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  Defaults();
  Values();
  PetscCall(PetscFinalize());
  return UnitEnd();
}
