/* vocabulary.c - the options of the program as a table, which the reading of options uses. Some values are rows of
   other tables: laws, shapes, walls, faces, bases, schemes, transfers, known solutions, ways to run, fields of
   snapshots. They are taken from those tables, so that none can be missing here. */
#include "run/mpm.h"

/* The names of a table, as "|a|b|c"; from the second character on, this is a list as options.def has it. */
#define MPM_MATERIAL(name, traits, parameters, state, what) "|" #name
static const char laws[] =
#include "physics/material.def"
    "";
#define MPM_REGION(name, solid, parameters, what) "|" #name
static const char shapes[] =
#include "physics/region.def"
    "";
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) "|" #name
static const char walls[] =
#include "physics/wall.def"
    "";
#define MPM_FACE(name) "|" #name
static const char sides[] = "all"
#include "physics/face.def"
                            "";
#define MPM_BASIS(name, nodes, layers, inertia, what) "|" #name
static const char bases[] =
#include "physics/basis.def"
    "";
#define MPM_SCHEME(name, keeps_increment, direct, what, ...) "|" #name
static const char schemes[] =
#include "step/scheme.def"
    "";
#define MPM_TRANSFER(name, flip, parts, rounds, bounds, what) "|" #name
static const char transfers[] =
#include "step/transfer.def"
    "";
#define MPM_PRESET_NAME(name, what, expect, collision, contact) "|" #name
#define MPM_PRESET(name, scenes, basis, stretch, update, transfer, strain, rate, cfl, ppc)
#define MPM_PRESET_TOTAL(name, scenes, basis, mass, rate, cfl, ppc)
static const char presets[] =
#include "run/preset.def"
    "";

#define MPM_IF_PETSC_TRUE(yes, no)  yes
#define MPM_IF_PETSC_FALSE(yes, no) no
#define MPM_EXCHANGE(name, chosen)  MPM_IF_##chosen("|" #name, "")
static const char strategies[] =
#include "parallel/exchange.def"
    "";
#define MPM_BALANCE(name, what) "|" #name
static const char balances[] =
#include "parallel/balance.def"
    "";

/* The words of fields of snapshots, separated by blanks. */
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads) word " "
static const char fields[] =
#include "results/diagnostics.def"
    "grid";
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads) word " "
static const char probe_fields[] =
#include "results/diagnostics.def"
    "";

#define MPM_BODY_QUANTITY(name, how, of, unit, nc, asked) " " #name
static const char body_quantities[] =
#include "results/measures.def"
    "";

/* Known solutions: those with a force of their own are values of -mms_type, the others of -reference_type. */
#define MPM_REFERENCE(name, manufactured, parameters, what) MPM_IF_##manufactured("|" #name, "")
static const char manufactured[] = "none"
#include "known/reference.def"
                                   "";
#define MPM_REFERENCE(name, manufactured, parameters, what) MPM_IF_##manufactured("", "|" #name)
static const char references[] = "none"
#include "known/reference.def"
                                 "|expression";

/* The digits of a number that has a name, for intervals whose end is the capacity of an array. */
#define MPM_DIGITS(number) MPM_QUOTED(number)
#define MPM_QUOTED(digits) #digits

static const MPMOptionRow rows[] = {
#define MPM_GROUP(title)                                      {NULL, MPM_LATER, "", "", "", title},
#define MPM_OPTION(name, type, allowed, unit, fallback, help) {name, MPM_##type, allowed, unit, fallback, help},
#include "run/options.def"
};

/* Words of other programs for these names: a whole name, or its end after a "_". */
static const char *const aliases[][2] = {
#define MPM_WORD(words, of, here)
#define MPM_ALIAS(words, end) {words, end},
#include "run/words.def"
};

/* What each law, shape and wall takes. */
static const MPMOptionValue choices[] = {
#define MPM_MATERIAL(name, traits, parameters, state, what) {"material_<m>_model", #name, parameters},
#include "physics/material.def"
#define MPM_REGION(name, solid, parameters, what) {"body_<b>_shape", #name, parameters},
#include "physics/region.def"
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) {"bc_<f>_type", #name, parameters},
#include "physics/wall.def"
};

/* What other programs have and this one has not, or calls otherwise. */
static const MPMOptionValue foreign[] = {
#define MPM_WORD(words, of, here) {of, words, here},
#define MPM_ALIAS(words, end)
#include "run/words.def"
};

const MPMVocabulary MPMOptionTable = {.n        = sizeof rows / sizeof rows[0],
                                      .row      = rows,
                                      .faces    = MPMFaceNames,
                                      .naliases = sizeof aliases / sizeof aliases[0],
                                      .aliases  = aliases,
                                      .nchoices = sizeof choices / sizeof choices[0],
                                      .choices  = choices,
                                      .nforeign = sizeof foreign / sizeof foreign[0],
                                      .foreign  = foreign};
