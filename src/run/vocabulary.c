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
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) "|" #name
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
#define MPM_SCHEME(name, keeps_increment, direct, what, ...) "|" #name
static const char schemes[] =
#include "step/scheme.def"
    "";
#undef MPM_SCHEME
#define MPM_TRANSFER(name, flip, parts, rounds, bounds, what) "|" #name
static const char transfers[] =
#include "step/transfer.def"
    "";
#undef MPM_TRANSFER
#define MPM_PRESET_NAME(name, what, expect, collision, contact) "|" #name
#define MPM_PRESET(name, scenes, basis, stretch, update, transfer, strain, rate, cfl, ppc)
#define MPM_PRESET_TOTAL(name, scenes, basis, mass, rate, cfl, ppc)
static const char presets[] =
#include "run/preset.def"
    "";
#undef MPM_PRESET_NAME
#undef MPM_PRESET
#undef MPM_PRESET_TOTAL

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
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads) word " "
#define MPM_RUN_QUANTITY(name, unit, whole)
#define MPM_ENERGY_QUANTITY(name, uses)
#define MPM_STATIC_QUANTITY(name, unit, whole)
#define MPM_ASKED_QUANTITY(name, uses, whole)
#define MPM_LOST_QUANTITY(name, of, uses, unit, components, nc)
static const char fields[] =
#include "results/diagnostics.def"
    "grid";
static const char probe_fields[] =
#include "results/diagnostics.def"
    "";
#undef MPM_PARTICLE_QUANTITY
#undef MPM_RUN_QUANTITY
#undef MPM_ENERGY_QUANTITY
#undef MPM_STATIC_QUANTITY
#undef MPM_ASKED_QUANTITY
#undef MPM_LOST_QUANTITY

#define MPM_WALL_QUANTITY(name, unit, nc)
#define MPM_RIGID_QUANTITY(name, unit, nc, axial)
#define MPM_BODY_QUANTITY(name, how, of, unit, nc, asked) " " #name
static const char body_quantities[] =
#include "results/measures.def"
    "";
#undef MPM_WALL_QUANTITY
#undef MPM_RIGID_QUANTITY
#undef MPM_BODY_QUANTITY

/* Known solutions: those with a force of their own are values of -mms_type, the others of -reference_type. */
#define MPM_REFERENCE(name, manufactured, parameters, what) MPM_IF_##manufactured("|" #name, "")
static const char manufactured[] = "none"
#include "known/reference.def"
                                   "";
#undef MPM_REFERENCE
#define MPM_REFERENCE(name, manufactured, parameters, what) MPM_IF_##manufactured("", "|" #name)
static const char references[] = "none"
#include "known/reference.def"
                                 "|expression";
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
    {"vx", "velocity"},
    {"vy", "velocity"},
    {"vz", "velocity"},
    {"speed", "velocity"},
    {"initial_velocity", "velocity"},
    {"c", "cohesion"},
    {"psi", "dilation_angle"},
    {"dilatancy", "dilation_angle"},
    {"sigy", "yield"},
    {"gravity_y", "gravity"},
    {"tssfac", "dt_cfl"},
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
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) {"bc_<f>_type", #name, parameters},
#include "physics/wall.def"
#undef MPM_WALL
};

/* What other programs have and this one has not: values of options, with the nearest one here, and words in names of
   options (row ""), with what there is instead. */
static const MPMOptionValue foreign[] = {
    {"material_<m>_model", "tresca",
     "the nearest is vonmises, which has the undrained strength c_u if yield is sqrt(3) c_u in plane strain, 2 c_u in "
     "triaxial compression"},
    {"material_<m>_model", "mohrcoulomb",
     "the nearest is druckerprager, which has the strength of this friction_angle and cohesion in plane strain with "
     "fit plane_strain, in triaxial compression with fit triaxial"},
    {"material_<m>_model", "rigid", "no body is rigid; give it a modulus 10 to 100 times that of the others"},
    {"material_<m>_model", "plastickinematic", "the nearest is vonmises, whose hardening is isotropic"},
    {"material_<m>_model", "camclay", "the nearest is druckerprager, which does not harden"},
    {"material_<m>_model", "linear", "linear elasticity is elastic, for small strains and small rotations"},
    {"material_<m>_model", "hyperelastic", "it is neohookean"},
    {"material_<m>_model", "plastic", "of metals it is vonmises, of soils druckerprager"},
    {"material_<m>_model", "water", "it is fluid"},
    {"reference_type", "finest", "pebble-study convergence compares with the finest run where no solution is known"},
    {"body_<b>_shape", "rectangle", "it is box"},
    {"body_<b>_shape", "cuboid", "it is box"},
    {"body_<b>_shape", "circle", "it is sphere, in 2-D a disk"},
    {"body_<b>_shape", "disk", "it is sphere, in 2-D a disk"},
    {"body_<b>_shape", "ball", "it is sphere"},
    {"bc_<f>_type", "rigidwall", "it is separate, or with friction friction"},
    {"bc_<f>_type", "symmetry", "it is slip"},
    {"bc_<f>_type", "roller", "it is slip"},
    {"bc_<f>_type", "encastre", "it is fixed"},
    {"load_<l>_face", "top", "it is the upper side of the last axis, ymax in 2-D and zmax in 3-D"},
    {"load_<l>_face", "bottom", "it is the lower side of the last axis, ymin in 2-D and zmin in 3-D"},
    {"geometry", "plane_stress", "there is none; a plate of a few cells in 3-D has it"},
    {"", "contact",
     "bodies meet, slide and part with -contact_mu, or by -contacts and its -contact_<c>_bodies, _mu, _stick, _normal"},
    {"", "rigid", "bodies are rigid with -body_<b>_rigid fixed, moving or free"},
    {"", "omega", "a body that turns has -body_<b>_velocity \"0-w*y, w*x\""},
    {"", "motion",
     "bodies move by -body_<b>_velocity at the start and by forces; walls move as they are told (piston)"},
    {"", "hourglass", "there are no hourglass modes of elements; noise of particles is in docs/choosing.md"},
    {"", "mass_scaling", "there is none; a lower modulus has longer steps too"},
    {"", "damage", "no law fails; matter that parts stops the run (-check_parting)"},
    {"", "erosion", "no law fails; matter that parts stops the run (-check_parting)"},
    {"", "failure", "no law fails; matter that parts stops the run (-check_parting)"},
    {"", "failure_strain", "no law fails; matter that parts stops the run (-check_parting)"},
    {"", "implicit", "steps are explicit; a run settles to rest with -damping_time or -damping_kinetic"},
    {"", "static", "steps are explicit; a run settles to rest with -damping_time or -damping_kinetic"},
    {"", "pore", "there is no pore water; stresses are total ones"},
    {"", "pore_pressure", "there is no pore water; stresses are total ones"},
    {"", "water_table", "there is no pore water; stresses are total ones"},
    {"", "permeability", "there is no pore water; stresses are total ones"},
    {"", "strength_factor", "strengths are the same all the time; runs with smaller ones find a factor of safety"},
    {"", "units", "any set of units that go together, such as SI; -dry_run shows masses and wave speeds"},
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
