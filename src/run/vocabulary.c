/* vocabulary.c - the options of the program as a table, which the reading of options uses. Some values are rows of
   other tables: laws, shapes, walls, faces, bases, schemes, transfers, known solutions, ways to run, fields of
   snapshots. They are taken from those tables, so that none can be missing here. */
#include "run/mpm.h"

/* The names of a table, as "|a|b|c"; from the second character on, this is a list as options.def has it. */
#define MPM_MATERIAL(name, traits, parameters, state, what) "|" #name
static const char laws[] =
#include "physics/material.def"
    "";
#undef MPM_MATERIAL
#define MPM_REGION(name, solid, parameters, what) "|" #name
static const char shapes[] =
#include "physics/region.def"
    "";
#undef MPM_REGION
#define MPM_WALL(name, parameters, before, gradient, residual, what) "|" #name
static const char walls[] =
#include "physics/wall.def"
    "";
#undef MPM_WALL
#define MPM_FACE(name) "|" #name
static const char sides[] = "all"
#include "physics/face.def"
                            "";
#undef MPM_FACE
#define MPM_BASIS(name, nodes, layers, inertia, what) "|" #name
static const char bases[] =
#include "physics/basis.def"
    "";
#undef MPM_BASIS
#define MPM_BASIS(name, nodes, layers, inertia, what) #name ","
static const char study_bases[] =
#include "physics/basis.def"
    "gimp_stretch";
#undef MPM_BASIS
#define MPM_SCHEME(name, keeps_increment, what, ...) "|" #name
static const char schemes[] =
#include "step/scheme.def"
    "";
#undef MPM_SCHEME
#define MPM_TRANSFER(name, flip, parts, rounds, what) "|" #name
static const char transfers[] =
#include "step/transfer.def"
    "";
#undef MPM_TRANSFER
#define MPM_PRESET_NAME(name, what, expect) "|" #name
#define MPM_PRESET(name, elastic, basis, stretch, update, transfer, strain, rate, cfl, ppc)
static const char presets[] =
#include "run/preset.def"
    "";
#undef MPM_PRESET_NAME
#define MPM_PRESET_NAME(name, what, expect) "," #name
static const char study_presets[] =
#include "run/preset.def"
    "";
#undef MPM_PRESET_NAME
#undef MPM_PRESET

#define MPM_IF_PETSC_TRUE(yes, no)  yes
#define MPM_IF_PETSC_FALSE(yes, no) no
#define MPM_EXCHANGE(name, chosen)  MPM_IF_##chosen("|" #name, "")
static const char strategies[] =
#include "parallel/exchange.def"
    "";
#undef MPM_EXCHANGE
#define MPM_BALANCE(name, what) "|" #name
static const char balances[] =
#include "parallel/balance.def"
    "";
#undef MPM_BALANCE

/* The words of fields of snapshots, separated by blanks. */
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs) word " "
#define MPM_RUN_QUANTITY(name, unit, whole)
#define MPM_ENERGY_QUANTITY(name, uses)
#define MPM_LOST_QUANTITY(name, of, uses, unit, components, nc)
static const char fields[] =
#include "output/diagnostics.def"
    "grid";
static const char probe_fields[] =
#include "output/diagnostics.def"
    "";
#undef MPM_PARTICLE_QUANTITY
#undef MPM_RUN_QUANTITY
#undef MPM_ENERGY_QUANTITY
#undef MPM_LOST_QUANTITY

#define MPM_WALL_QUANTITY(name, unit, nc)
#define MPM_BODY_QUANTITY(name, how, of, unit, nc) " " #name
static const char body_quantities[] =
#include "output/measures.def"
    "";
#undef MPM_WALL_QUANTITY
#undef MPM_BODY_QUANTITY

/* Known solutions: those with a force of their own are values of -mms_type, the others of -reference_type. */
#define MPM_REFERENCE(name, manufactured, parameters, what) MPM_IF_##manufactured("|" #name, "")
static const char manufactured[] = "none"
#include "physics/reference.def"
                                   "";
#undef MPM_REFERENCE
#define MPM_REFERENCE(name, manufactured, parameters, what) MPM_IF_##manufactured("", "|" #name)
static const char references[] = "none"
#include "physics/reference.def"
                                 "|expression|finest";
#undef MPM_REFERENCE

/* The digits of a number that has a name, for intervals whose end is the capacity of an array. */
#define MPM_DIGITS(number) MPM_QUOTED(number)
#define MPM_QUOTED(digits) #digits

static const MPMOptionRow rows[] = {
#define MPM_GROUP(title)                                      {NULL, MPM_LATER, "", "", "", title},
#define MPM_OPTION(name, type, allowed, unit, fallback, help) {name, MPM_##type, allowed, unit, fallback, help},
#include "run/options.def"
#undef MPM_GROUP
#undef MPM_OPTION
};

/* Words of other programs for these names: a whole name, or its end after a "_". */
static const char *const aliases[][2] = {
    {"youngs", "E"},
    {"young", "E"},
    {"youngs_modulus", "E"},
    {"modulus", "E"},
    {"poisson", "nu"},
    {"poissons_ratio", "nu"},
    {"poisson_ratio", "nu"},
    {"density", "rho"},
    {"type", "model"},
    {"type", "shape"},
    {"law", "model"},
    {"particles", "ppc"},
    {"position", "center"},
    {"centre", "center"},
    {"min", "lower"},
    {"max", "upper"},
    {"v", "velocity"},
    {"vel", "velocity"},
    {"scheme", "update"},
    {"scheme", "method_update"},
    {"shape_function", "basis"},
    {"dt", "dt_size"},
    {"timestep", "dt_size"},
    {"time_step", "dt_size"},
    {"steps", "max_steps"},
    {"steps", "time_max_steps"},
    {"max_steps", "time_max_steps"},
    {"t_end", "time_end"},
    {"tend", "time_end"},
    {"end_time", "time_end"},
    {"final_time", "time_end"},
    {"cfl_number", "cfl"},
    {"courant", "dt_cfl"},
    {"interval", "every"},
    {"g", "gravity"},
    {"restart", "restart_file"},
    {"restart_from", "restart_file"},
    {"resume", "restart_file"},
    {"continue", "restart_file"},
    {"checkpoint", "checkpoint_every"},
    {"checkpoint_interval", "checkpoint_every"},
    {"bulk_modulus", "K"},
    {"yield_stress", "yield"},
    {"phi", "friction_angle"},
    {"friction", "friction_angle"},
    {"friction", "mu"},
    {"nsteps", "time_max_steps"},
    {"outdir", "output_dir"},
    {"output", "output_dir"},
};

/* What each law, shape and wall takes. */
static const MPMOptionValue choices[] = {
#define MPM_MATERIAL(name, traits, parameters, state, what) {"material_<m>_model", #name, parameters},
#include "physics/material.def"
#undef MPM_MATERIAL
#define MPM_REGION(name, solid, parameters, what) {"body_<b>_shape", #name, parameters},
#include "physics/region.def"
#undef MPM_REGION
#define MPM_WALL(name, parameters, before, gradient, residual, what) {"bc_<f>_type", #name, parameters},
#include "physics/wall.def"
#undef MPM_WALL
};

/* Laws that other programs have, and the nearest one here. */
static const MPMOptionValue foreign[] = {
    {"material_<m>_model", "tresca",
     "the nearest is vonmises, which has the undrained strength c_u if yield is sqrt(3) c_u in plane strain, 2 c_u in "
     "triaxial compression"},
    {"material_<m>_model", "mohrcoulomb",
     "the nearest is druckerprager, which has the strength of this friction_angle and cohesion in plane strain with "
     "fit plane_strain, in triaxial compression with fit triaxial"},
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
