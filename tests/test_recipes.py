"""The recipes of the developer's guide (docs/developer.md): what they name is there, and so are the files and the names
of the source that the other documents and the comments name; and the recipes of laws, walls, diagnostics, quantities of
bodies, update schemes, transfers and warnings are followed on a copy of the source, with no more lines and files than
they say. What they make has true values, and warnings where there is something to warn of.

usage: test_recipes.py PEBBLE SOURCE MPIEXEC names
       test_recipes.py PEBBLE SOURCE MPIEXEC BUILD     (folder of the objects, of which a copy is brought up to date)
       test_recipes.py PEBBLE SOURCE MPIEXEC BUILD node    (the recipe of numbers of nodes, which compiles all objects anew:
                                                            with -O1, which takes less time and gives the same bits)
"""
import difflib
import glob
import os
import re
import resource
import shutil
import subprocess

import h5py
import numpy as np

import check

FOREIGN = {"e_log.c", "e_exp.c"}  # files of other projects that a comment names

# ---- The recipes. Each is a list of edits: a new file, lines that go before a line of a file or to its end, or another
# word in a line.

LAW = [("src/physics/material.def", None, """\
MPM_MATERIAL(rubber, MPM_OBJECTIVE | MPM_HYPERELASTIC, "E nu", "F", "neo-Hookean solid whose pressure is lambda (J - 1)")
"""), ("src/physics/material_rubber.c", None, """\
/* material_rubber.c - W = mu/2 (tr b - 3 - 2 ln J) + lambda/2 (J - 1)^2,  tau = lambda J (J - 1) I + mu (b - I). */
#include "physics/law.h"

MPM_INLINE void rubber_stress(int dim, const MPMMaterial *m, const MPMParticleState *s, MPMReal *tau)
{
  const MPMReal J = MPMParticleJ(dim, s), p = m->lambda * J * (J - 1.0);

  MPMParticleB(dim, s, tau);
  for (int k = 0; k < 6; k++) tau[k] = m->mu * (tau[k] - MPMSymUnit(3, k)) + p * MPMSymUnit(3, k);
}

MPM_INLINE MPMReal rubber_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = MPMParticleJ(dim, s);
  MPMReal       b[6];

  MPMParticleB(dim, s, b);
  return 0.5 * m->mu * ((b[0] - 1.0) + (b[3] - 1.0) + (b[5] - 1.0) - 2.0 * MPMLog(J)) +
         0.5 * m->lambda * (J - 1.0) * (J - 1.0);
}

/* A plane wave along n has rho0 c^2 = lambda J^2 + mu (1 + n.b n), a shear wave mu n.b n; n.b n is below 1 and
   twice the sum of |b - I|. */
MPM_INLINE MPMReal rubber_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = MPMParticleJ(dim, s);
  MPMReal       b[6], most = MPMAll(1);

  MPMParticleB(dim, s, b);
  for (int k = 0; k < 6; k++) most += 2.0 * MPMAbs(b[k] - MPMSymUnit(3, k));
  return (m->mu * most + MPMMax(MPMAll(0), m->mu + m->lambda * J * J)) / m->rho;
}

MPM_MATERIAL_DEFINE(rubber)
""")]

# A law that depends on the rate, whose particles have F only where something else reads it.
RATE = [("src/physics/material.def", None, """\
MPM_MATERIAL(maxwell, MPM_OBJECTIVE, "E nu rate_reference", "F|J be tau", "Hencky elasticity whose shear stress decays with rate_reference")
"""), ("src/physics/material_maxwell.c", None, """\
/* material_maxwell.c - viscoelastic solid: Hencky elasticity whose deviatoric strains decay as exp(-rate_reference t). */
#include "physics/material_hencky.h"

MPM_INLINE void maxwell_update(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L, MPMParticleState *s)
{
  const MPMReal keep = MPMExp(MPMAll(-dt * m->rate0));
  MPMReal       b[3], n[3][3], e[3], mean;

  MPMHenckyTrial(dim, m, dt, L, s);
  MPMHenckyStrain(dim, s->be, b, n, e);
  mean = (e[0] + e[1] + e[2]) / 3;
  for (int k = 0; k < 3; k++) e[k] = mean + keep * (e[k] - mean);
  MPMHenckySetStrain(dim, MPMNot(MPMNone()), e, n, s->be);
  MPMHenckyStress(dim, m, e, n, s->tau);
}

MPM_INLINE MPMReal maxwell_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  return MPMHenckyEnergy(dim, m, s);
}

/* More than that of Hencky's law, which is a bound of small elastic strains alone. */
MPM_INLINE MPMReal maxwell_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal most = MPMAll(0);

  for (int k = 0; k < 6; k++) most += MPMAbs(s->tau[k]);
  return MPMHenckySpeed2(dim, m, s) + 2.0 * most / m->rho;
}

MPM_MATERIAL_DEFINE_HISTORY(maxwell, NULL, MPM_BIT(J) | MPM_BIT(be) | MPM_BIT(tau))
""")]

WALL = [("src/physics/wall.def", None, """\
MPM_WALL(drag, "mu", 0, drag, drag, drag, "the velocity on the face decays as exp(-mu t)")
"""), ("src/physics/wall.c", "static PetscBool MPMWallApply_free", """\
static PetscBool MPMWallApply_drag(MPM_WALL_ARGUMENTS)
{
  for (PetscInt d = 0; d < at->dim; d++) v[d] *= MPMExp(-f->mu * at->dt);
  return PETSC_FALSE;
}

""")]

SPONGE = [("src/physics/wall.def", None, """\
MPM_WALL(sponge, "rate layers", 0, free, sponge, free, "velocities decay near the wall, with the square of the distance from its last layer")
"""), ("src/physics/wall.c", "static PetscBool MPMWallApply_free", """\
static PetscBool MPMWallApply_sponge(MPM_WALL_ARGUMENTS)
{
  const PetscReal far  = PetscMax(0, at->distance) / (at->h * (PetscReal)(f->reach + 1));
  const PetscReal rate = f->rate * (1 - far) * (1 - far);

  for (PetscInt d = 0; d < at->dim; d++) v[d] *= 1 - PetscMin(1, rate * at->dt);
  return PETSC_FALSE;
}

"""), ("src/physics/wall.h", "  PetscInt  reach;", """\
  PetscReal rate; /* of a sponge, 1/s */
"""), ("src/scene/read_walls.c", '    {"mu", "bc_<f>_mu"', """\
    {"rate", "bc_<f>_rate", offsetof(MPMFace, rate), MPM_REAL},
    {"layers", "bc_<f>_layers", offsetof(MPMFace, reach), MPM_INT},
"""), ("src/run/options.def", 'MPM_OPTION("bc_<f>_mu"', """\
MPM_OPTION("bc_<f>_rate", REAL, "[0,inf)", "1/s", "required", "rate of decay on a wall of type sponge")
MPM_OPTION("bc_<f>_layers", INT, "[0,1000]", "", "required", "layers of nodes inside the grid that a sponge reaches")
""")]

# A wall that moves, and only along itself: the row says so, and everything else follows from it.
SHAKER = [("src/physics/wall.def", None, """\
MPM_WALL(shaker, "velocity", MPM_WALL_NORMAL | MPM_WALL_TANGENT | MPM_WALL_MOVES, shaker, shaker, fixed, "matter moves along the wall with it")
"""), ("src/physics/wall.c", "static PetscBool MPMWallApply_free", """\
static PetscBool MPMWallApply_shaker(MPM_WALL_ARGUMENTS)
{
  for (PetscInt d = 0; d < at->dim; d++) v[d] = d == at->axis ? 0 : f->velocity[d];
  return PETSC_TRUE;
}

""")]

DIAGNOSTIC = [("src/results/diagnostics.def", None, """\
MPM_PARTICLE_QUANTITY(spin, FIELD | COLUMN, "spin", "kg m^2/s", "", 1, PETSC_FALSE, 0, 0)
"""), ("src/results/diagnostics.c", "static void Fill_kinetic_energy", """\
static void Fill_spin(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscReal *x = v->x + 2 * p, *u = v->v + 2 * p;

  row[0] = KindOf(s, v, p)->m * (x[0] * u[1] - x[1] * u[0]);
}

""")]

# Fields that read F, which some laws can do without, and X, which most scenes do not have.
STRAIN = [("src/results/diagnostics.def", None, """\
MPM_PARTICLE_QUANTITY(strain, FIELD, "strain", "1", "", 1, PETSC_FALSE, 0, MPM_BIT(F))
"""), ("src/results/diagnostics.c", "static void Fill_stress", """\
static void Fill_strain(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  PetscReal F[9], all = 0;

  Fill_F(s, v, p, F);
  for (PetscInt k = 0; k < 9; k++) all += PetscSqr(F[k] - (k % 4 == 0));
  row[0] = PetscSqrtReal(all);
}

""")]
SHIFT = [("src/results/diagnostics.def", None, """\
MPM_PARTICLE_QUANTITY(shift, FIELD, "shift", "m", "x y z", 3, PETSC_FALSE, 0, MPM_BIT(X))
"""), ("src/results/diagnostics.c", "static void Fill_stress", """\
static void Fill_shift(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt dim = s->core->grid.dim;

  for (PetscInt d = 0; d < 3; d++) row[d] = d < dim ? v->x[p * dim + d] - v->X[p * dim + d] : 0;
}

""")]
MEASURE = [("src/results/measures.def", None, """\
MPM_BODY_QUANTITY(most_strain, MOST, strain, "1", 1, 0)
MPM_BODY_QUANTITY(mean_strain, MEAN, strain, "1", 1, 0)
MPM_BODY_QUANTITY(least_shift, LEAST, shift, "m", 3, 0)
MPM_BODY_QUANTITY(most_error, MOST, error_indicator, "1", 1, 0)
MPM_BODY_QUANTITY(median_strain, MEDIAN, strain, "1", 1, 1)
"""), ("src/results/bodies.c", "typedef enum { NUMBER,", ("LOST }", "LOST, MEDIAN }")),
           ("src/results/bodies.c", "  case LOST:", "  case MEDIAN: PetscCall(Extreme(&s, core, shown, &view, of, 1, 0.5, out)); break;\n")]

SCHEME = [("src/step/scheme.def", None, """\
MPM_SCHEME(twice, PETSC_FALSE, PETSC_TRUE, "as usl, in two transfers to the nodes", P2G_MASS, P2G_FORCE, ADVANCE, G2P)
""")]
# A scheme with a phase that no scheme had, which works over a share of the step.
HALVES = [("src/step/scheme.def", None, """\
MPM_SCHEME(usavg, PETSC_FALSE, PETSC_FALSE, "half of the stress before the advance, half after it", P2G_MASS, VELOCITY, G2P_STRESS_HALF, P2G_FORCE, ADVANCE, G2P_STRESS_HALF, G2P_MOTION)
"""), ("src/step/phases.c", "  [G2P_FILTER]        =", """\
  [G2P_STRESS_HALF]   = SHARE_TO_PARTICLES("G2P_STRESS", 0.5, MPM_G2P_STRESS, WHERE | B(id) | STATE, STATE),
"""), ("src/step/phases.c", "enum { P2G, P2G_MASS,", ("NUM_PHASES };", "G2P_STRESS_HALF, NUM_PHASES };"))]
TRANSFER = [("src/step/transfer.def", None, """\
MPM_TRANSFER(flap, -1, 0, MPM_NO_ROUNDS, MPM_BOUNDS_UNKNOWN, "as flip")
""")]
# Numbers of a node: a scalar and a vector in one line of the record, a tensor that needs another, and a scalar that is
# not summed with the masses, which no snapshot shows.
NODE = [("src/kernels/node.def", "/* clang-format on */", """\
MPM_NODE_SUM(room, 1, MPM_P2G_MASS, MPM_BIT(F), "room", "m^3", "volume of the particles as it is now")
MPM_NODE_SUM(stretch, dim, MPM_P2G_MASS, MPM_BIT(F), "stretch", "m^3", "V0 times the diagonal of F of the particles")
MPM_NODE_SUM(cauchy, 6, MPM_P2G_MASS, MPM_BIT(F), "cauchy", "m^3", "V0 F F^T of the particles")
MPM_NODE_SUM(apart, 1, MPM_P2G_FORCE, 0, "", "m^3", "V0 of the particles, with the forces")
"""), ("src/kernels/node_sums.h", "/* Sets the records of a block for line", """\
MPM_INLINE void Give_room(MPM_GIVE_ARGUMENTS)
{
  MPMReal F[9];

  MPMLoad(dim * dim, patch->particles.F, o, l, F);
  q[0] = MPMRead(&s->V0[l]) * MPMDet(dim, F);
}

MPM_INLINE void Give_stretch(MPM_GIVE_ARGUMENTS)
{
  MPMReal F[9];

  MPMLoad(dim * dim, patch->particles.F, o, l, F);
  for (int d = 0; d < dim; d++) q[d] = MPMRead(&s->V0[l]) * F[d * (dim + 1)];
}

MPM_INLINE void Give_cauchy(MPM_GIVE_ARGUMENTS)
{
  MPMReal F[9];

  MPMLoad(dim * dim, patch->particles.F, o, l, F);
  MPMLeftCauchyGreen(dim, F, q);
  for (int k = 0; k < 6; k++) q[k] *= MPMRead(&s->V0[l]);
}

MPM_INLINE void Give_apart(MPM_GIVE_ARGUMENTS)
{
  q[0] = MPMRead(&s->V0[l]);
}

""")]

WARNING = [("src/advice/bounds.def", None, """\
MPM_BOUND(tall, 40, "of its width", "a grid that is higher is warned of", "judgement")
"""), ("src/advice/doubts.c", "/* Prints the warnings and notes before", """\
static PetscErrorCode WarnTall(const MPMCore *core)
{
  const MPMGrid *grid = &core->grid;

  PetscFunctionBeginUser;
  if (grid->dim > 1 && grid->cells[1] > MPM_BOUND_tall * grid->cells[0])
    PetscCall(MPMWarn(&core->print, "the grid is tall"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

"""), ("src/advice/doubts.c", "  if (shift > MPM_BOUND_shift_warned)", """\
  PetscCall(WarnTall(core));
""")]


def follow(name, edits, files, functions, rows=1):
    """Does the edits; checks how many files they change or add, and that these get rows of tables, so many functions,
    and nothing else."""
    lines = {}
    for path, before, text in edits:
        old = check.content(path).decode().splitlines(True) if os.path.exists(path) else []
        places = [k for k, line in enumerate(old) if before and line.startswith(before)]
        check.need(not before or len(places) == 1, f"{name}: {path} has {len(places)} lines that begin with '{before}'")
        if isinstance(text, tuple):
            new = [line.replace(*text) if k in places else line for k, line in enumerate(old)]
        else:
            end = next((k for k, line in enumerate(old) if line.startswith("#undef") and path.endswith(".def")), len(old))  # of the rows of a table
            at = places[0] if before else end
            new = old[:at] + text.splitlines(True) + old[at:]
        check.write(path, "".join(new))
        lines.setdefault(path, []).extend(line[2:] for line in difflib.ndiff(old, new) if line[0] == "+")
    made = sum(len(re.findall(r"^(?:static|MPM_INLINE) [^;=]*\)$", "".join(added), re.M))
               for path, added in lines.items() if "/material_" not in path)
    check.that(len(lines) == files and made == functions, f"{name}: {sum(map(len, lines.values()))} lines in {len(lines)} files, {made} functions: "
               + ", ".join(f"{os.path.basename(path)} {len(added)}" for path, added in lines.items()))
    table = edits[0][0]
    check.that(len(lines[table]) == rows or not table.endswith(".def"), f"{name}: {rows} in {os.path.basename(table)}")


def build(folder, *targets):
    """make, as a user starts it, in the copy. Its objects are those of the build under test: make compiles what changed."""
    compiler = os.path.basename(folder).removesuffix("-debug")
    words = ([] if compiler == "mpicc" else [f"CC={compiler}"]) + (["DEBUG=1"] if folder.endswith("-debug") else [])
    done = subprocess.run(["make", "-j2", *words, f"BUILD={folder}", "PEBBLE=pebble", *targets], capture_output=True, text=True)
    check.need(done.returncode == 0 and "warning" not in done.stderr, f"make {' '.join(targets)}: {done.stdout[-1000:]}{done.stderr[-3000:]}")
    return re.findall(r"^  CC +\[\d+/\d+\] \S+/(\S+)\.o$", done.stdout, re.M)


def copy(objects):
    """A tree with the source, the makefile and the objects; their times stay."""
    shutil.rmtree("copy", ignore_errors=True)
    os.makedirs("copy/tests")
    os.chdir("copy")
    shutil.copytree(os.path.join(check.source, "src"), "src")
    shutil.copy2(os.path.join(check.source, "makefile"), "makefile")
    for name in ("unit.h", "unit_material.c", "unit_tangent.c"):
        shutil.copy2(os.path.join(check.source, "tests", name), os.path.join("tests", name))
    folder = os.path.join("build", os.path.basename(os.path.normpath(objects)))
    shutil.copytree(objects, folder, ignore=lambda path, names: [name for name in names if name in ("tests", "pebble", "quadrature") or name.startswith("unit_")])
    return folder


def disks(name, *options, n=1):
    """A short run of two disks that nothing checks for conservation."""
    options = ["-options_file", check.scene("disks"), "-check_energy", "0", "-check_momentum", "0", "-time_end", "0.3", "-output_name", name, *options]
    run = check.must(*options, n=n)
    return run, check.history(f"output/{name}.csv")


def use_law():
    run, history = disks("rubber", "-material_soft_model", "rubber", "-check_momentum", "1e-12", "-time_end", "3")
    energy = history["kinetic_energy"] + history["strain_energy"]
    check.that(run.good and "rubber" in run.out and history["strain_energy"].max() > 0.1 * energy[0] and abs(energy / energy[0] - 1).max() < 0.05,
               f"two disks of rubber collide: momentum is kept, energy changes by {abs(energy / energy[0] - 1).max():.3f}, strain energy reaches {history['strain_energy'].max() / energy[0]:.2f} of it")
    for unit in ("unit_material", "unit_tangent"):
        run = check.run([os.path.join(folder_of_objects, unit)])
        check.that(run.status == 0 and re.search(r"^\d+ checks, 0 failed$", run.out, re.M), f"{unit} takes the law up: {(run.out + run.err).strip()[-300:]}")


def warned(run):
    """What a run warns of and notes, without numbers."""
    return sorted(re.sub(r"[\d.e+-]+", "#", line) for line in run.out.splitlines() if line.startswith(("warning", "note ")))


def use_rate():
    E, nu, rate, dt = 1e4, 0.3, 300, 1e-3
    block = ["-dim", "2", "-grid_lower", "0,0", "-grid_upper", "1,1", "-grid_cells", "10,10", "-materials", "m", "-material_m_model", "maxwell", "-material_m_rho", "1000",
             "-material_m_E", str(E), "-material_m_nu", str(nu), "-material_m_rate_reference", str(rate), "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", "0.3,0.3",
             "-body_b_upper", "0.7,0.7", "-body_b_material", "m", "-dt_size", str(dt)]
    fast = ["-body_b_velocity", "30*x+60*y,-20*x+5*y", "-time_end", str(dt)]
    check.must(*block, *fast, "-output_fields", "F,stress", "-output_name", "both")
    check.must(*block, *fast, "-output_fields", "stress", "-output_name", "stress")
    both, alone = check.particles("output/both.h5"), check.particles("output/stress.h5")
    F = both["F"].reshape(-1, 3, 3)
    b, n = np.linalg.eigh(F @ F.transpose(0, 2, 1))
    e = np.log(b) / 2
    mean = e.mean(axis=1, keepdims=True)
    e = mean + np.exp(-rate * dt) * (e - mean)
    lame, mu = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    tau = lame * e.sum(axis=1, keepdims=True) + 2 * mu * e
    right = np.einsum("pik,pk,pjk->pij", n, tau, n).reshape(-1, 9) / np.linalg.det(F)[:, None]
    for what, found in (("with F", both["stress"]), ("without F", alone["stress"])):
        wrong = abs(found.reshape(-1, 9) - right).max() / abs(right).max()
        check.that(wrong < 1e-11 and abs(right).max() > 100, f"maxwell {what}: the stress after a step differs by {wrong:.1e} of it from exp(-rate dt) of Hencky's")
    run = check.must(*block, "-body_b_velocity", "0.6*(x-0.5)+1.2*(y-0.5),0.1*(y-0.5)-0.4*x", "-time_end", "0.2", "-history_bodies", "b", "-history_body_quantities", "dissipation", "-history_energy", "-output_format", "none", "-output_name", "heat")
    history = check.history("output/heat.csv")
    heat = history["dissipation_b"][-1]
    check.that(heat > 0.01 * history["total_energy"][0] and abs(heat + history["energy_laws"][-1]) < 1e-10 * heat,
               f"what it dissipates, {heat:.4g} J, is what the law took")
    check.that(not any("unstable" in line or "apart" in line for line in warned(run)), f"warnings: {warned(run)}")


def use_wall():
    free, _ = disks("free")
    still, _ = disks("still", "-bc_xmax_type", "drag", "-bc_xmax_mu", "0")
    check.that(still.digest == free.digest, "a drag of 0 changes no bit")
    _, history = disks("drag", "-bc_xmax_type", "drag", "-bc_xmax_mu", "20")
    drag = history["total_energy"]
    check.that((drag[1:] <= drag[:-1]).all() and drag[-1] < 0.999 * drag[0], f"drag: the energy falls to {drag[-1] / drag[0]:.4f} of what it was")


LAWS = {"neohookean": "-material_m_E 1e5 -material_m_nu 0.3", "fluid": "-material_m_K 1e5", "druckerprager": "-material_m_E 1e6 -material_m_nu 0.3 -material_m_friction_angle 35",
        "vonmises": "-material_m_E 1e6 -material_m_nu 0.3 -material_m_yield 1e4"}


def open_faces():
    """Walls that do nothing are no walls: the same bits and warnings as with free faces, with the default methods."""
    for law, constants in LAWS.items():
        for more in ([], ["-method_basis", "gimp", "-method_update", "musl", "-method_transfer", "xpic"], ["-method_preset", "energy"]):
            block = ["-dim", "2", "-gravity", "0,-10", "-grid_lower", "0,0", "-grid_upper", "1,1", "-grid_cells", "12,12", "-materials", "m", "-material_m_model", law,
                     "-material_m_rho", "1000", *constants.split(), "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", "0,0", "-body_b_upper", "0.5,0.5",
                     "-body_b_material", "m", "-body_b_velocity", "-1,0", "-bc_ymin_type", "slip", "-particles_leave", "delete", "-time_end", "0.06", "-output_format", "none",
                     "-output_name", "open", *more]
            faces = {"free": []}
            faces["drag"] = [word for f in ("xmin", "xmax") for word in (f"-bc_{f}_type", "drag", f"-bc_{f}_mu", "0")]
            faces["sponge"] = [word for f in ("xmin", "xmax") for word in (f"-bc_{f}_type", "sponge", f"-bc_{f}_rate", "0", f"-bc_{f}_layers", "3")]
            runs = dict(zip(faces, check.at_once(lambda f: check.must(*block[:-1 - len(more)], f"open_{f}", *more, *faces[f]), faces)))
            lost = runs["free"].find(r"(particles .*left.*)")
            for wall in ("drag", "sponge"):
                same = runs[wall].digest == runs["free"].digest and warned(runs[wall]) == warned(runs["free"])
                check.that(same, f"{law} {' '.join(more)}: a {wall} that does nothing is no wall, {runs[wall].digest} {lost or ''}"
                           + ("" if same else f" {set(warned(runs[wall])) ^ set(warned(runs['free']))}"))


def use_sponge():
    def sponge(name, layers, rate=5, n=1, **more):
        return disks(name, "-bc_xmax_type", "sponge", "-bc_xmax_rate", str(rate), "-bc_xmax_layers", str(layers), *more.get("options", []), n=n)
    left = {}
    for layers in (0, 4, 8):
        energy = sponge(f"layers{layers}", layers)[1]["total_energy"]
        left[layers] = energy[-1] / energy[0]
        check.fault(None if (energy[1:] <= energy[:-1]).all() else f"sponge of {layers} layers: the energy grows")
    check.that(1 > left[0] > left[4] > left[8], f"a sponge of 0, 4 and 8 layers leaves {left[0]:.4f}, {left[4]:.4f} and {left[8]:.4f} of the energy")
    away = ["-body_disk2_center", "0.5,0.75"]  # x up to 0.7 at the start, 0.67 at the end; its nodes up to 0.75
    check.that(sponge("away", 4, options=away)[0].digest == disks("away_free", *away)[0].digest, "what the sponge does not reach moves as without it, to the bit")
    serial = sponge("one", 8)[0].digest
    check.that(serial == sponge("two", 8, n=2)[0].digest == sponge("pool", 8, n=3, options=["-parallel_strategy", "pool"])[0].digest,
               "the same bits on 2 processes and by a pool of 3")
    for cells in (20, 40):  # the profile in layers, at two resolutions: its force in the first step, in which nothing else acts
        _, history = sponge("force", 5, options=["-grid_cells", f"{cells},{cells}", "-history_walls", "xmax", "-history_every", "0", "-time_max_steps", "1", "-output_fields", "velocity,grid"])
        with h5py.File("output/force.h5") as file:
            mass = check.group(file, 0)["grid"]["mass"][:].reshape(cells + 1, cells + 1)
        layer = np.arange(cells, -1, -1)
        rates = np.where(layer <= 5, 5 * (1 - layer / 6) ** 2, 0)
        right = 0.1 * (mass * rates).sum()  # the disk there has the velocity -0.1
        check.that(abs(history["reaction_xmax_x"][1] / right - 1) < 1e-9 and right > 1e-3, f"the force of a sponge on {cells} cells: {history['reaction_xmax_x'][1]:.6g} N, {right:.6g} N by hand")


def use_shaker():
    runs = [disks(kind, "-bc_xmin_type", kind, "-bc_xmin_velocity", "0,0.1*cos(20*t)", "-history_walls", "xmin", "-history_energy") for kind in ("moving", "shaker")]
    (one, h1), (two, h2) = runs
    check.that(one.digest == two.digest and warned(one) == warned(two) and (h1["work_xmin"] == h2["work_xmin"]).all() and h1["work_xmin"][-1] != 0,
               f"a wall that oscillates along itself: motion and work, {h2['work_xmin'][-1]:.4g} J, are those of a moving wall with this velocity")


def use_diagnostic():
    run, history = disks("spin", "-output_fields", "velocity,spin")
    check.that(run.good and abs(history["spin"]).max() < 1e-14, f"spin is conserved, 0: at most {abs(history['spin']).max():.1e} kg m^2/s")
    run, history = disks("turn", "-body_disk1_center", "0.35,0.35", "-body_disk1_velocity", "-(y-0.35),x-0.35", "-output_fields", "spin")
    for which in (0, -1):
        column, field = history["spin"][which], check.particles("output/turn.h5", which, ["id", "spin"])["spin"].sum()
        check.that(abs(field / column - 1) < 1e-12 and abs(column) > 0.1, f"spin of a disk that turns: the column, {column:.6f} kg m^2/s, is the sum of the field, {field:.6f}")


METALS = """-dim 2 -gravity 0,-10 -grid_lower 0,0 -grid_upper 3,1.5 -grid_cells 24,12 -materials steel,soil -material_steel_model vonmises -material_steel_rho 1000
-material_steel_E 1e6 -material_steel_nu 0.3 -material_steel_yield 2e4 -material_soil_model druckerprager -material_soil_rho 1000 -material_soil_E 1e6 -material_soil_nu 0.3
-material_soil_friction_angle 30 -bodies left,right -body_left_shape box -body_left_lower 0.5,0.125 -body_left_upper 1,1 -body_left_material steel -body_left_velocity 0.1,-2
-body_right_shape box -body_right_lower 2,0.125 -body_right_upper 2.5,1 -body_right_material soil -body_right_velocity 0,-2 -bc_ymin_type slip -time_end 0.06
-history_every 0.02 -method_basis bspline2 -method_update usl -method_transfer flip""".split()


def use_fields():
    """What reads F and X has true values wherever it is shown, also alone, and for laws that need no F."""
    body = ["-history_bodies", "all", "-history_body_quantities", "most_strain,mean_strain,median_strain,least_shift,most_error"]
    runs = {"all": ["-output_fields", "strain,shift,F,error_indicator"], "alone": ["-output_fields", "strain"], "shift": ["-output_fields", "shift"],
            "bodies": ["-output_format", "none", *body], "probe": ["-output_format", "none", "-probes", "p", "-probe_p_particle", "7", "-probe_p_fields", "strain,shift"],
            "two": ["-output_format", "none", *body]}
    done = dict(zip(runs, check.at_once(lambda name: check.must(*METALS, *runs[name], "-output_name", name, n=2 if name == "two" else 1), runs)))
    found = check.particles("output/all.h5")
    strain = np.linalg.norm(found["F"].reshape(-1, 9) - np.eye(3).reshape(9), axis=1)
    moved = found["x"] - check.particles("output/all.h5", 0)["x"]
    check.that(strain.max() > 0.05 and abs(found["strain"] - strain).max() < 1e-14 and abs(found["shift"] - moved).max() < 1e-14 and abs(moved).max() > 0.05,
               f"strain, up to {strain.max():.4f}, and shift of all particles")
    for name, word in (("alone", "strain"), ("shift", "shift")):
        check.that((check.particles(f"output/{name}.h5")[word] == found[word]).all(), f"{word} alone is the same")
    history = check.history("output/bodies.csv")
    first = 0
    for name in ("left", "right"):
        n = int(check.must(*METALS, "-dry_run").find(rf"body +{name}.*?(\d+) particles") or 0) or len(strain) // 2
        part = slice(first, first + n)
        first += n
        values = {f"most_strain_{name}": strain[part].max(), f"mean_strain_{name}": strain[part].mean(), f"median_strain_{name}": np.sort(strain[part])[(n - 1) // 2], f"least_shift_{name}_x": moved[part, 0].min(),
                  f"least_shift_{name}_y": moved[part, 1].min(), f"most_error_{name}": found["error_indicator"][part].max()}
        for column, right in values.items():
            check.that(abs(history[column][-1] - right) < 1e-13 * (1 + abs(right)), f"{column}: {history[column][-1]:.6g}, {right:.6g} by hand")
    check.that(check.content("output/two.csv") == check.content("output/bodies.csv"), "the same on 2 processes")
    history = check.history("output/probe.csv")
    check.that(abs(history["probe_p_strain"][-1] - strain[7]) < 1e-14 and abs(history["probe_p_shift_y"][-1] - moved[7, 1]) < 1e-14, "the same in a probe")
    check.that(all(warned(run) == warned(done["all"]) for run in done.values()), "no warning comes from what is shown")


def unknown(run, what):
    notes = re.findall(r"^note +it has not been measured up to which time step \w+ with (.*?) is stable", run.out, re.M)
    wrong = re.findall(r"^.*(?:unstable|blow up|do not trust|amplifies|slows down).*$", run.out, re.M)
    check.that(notes == [what] and not wrong, f"{what}: a note that its steps were not measured, once, and no warning of them {notes} {wrong}")


def use_scheme():
    usl, of_usl = disks("usl", "-method_update", "usl", "-report_phases", "-history_energy")
    run, history = disks("twice", "-method_update", "twice", "-report_phases", "-history_energy")
    check.that(run.digest == usl.digest and run.find(r"(P2G_FORCE)") and not usl.find(r"(P2G_FORCE)"), f"two transfers in place of one: the bits of usl, {run.digest}")
    check.that(all((history[key] == of_usl[key]).all() for key in history), "and its energies, term by term")
    check.that(re.search("unstable", usl.out), "usl with linear functions is warned of")
    unknown(run, "twice and flip")
    preset, _ = disks("preset", "-method_update", "twice", "-method_basis", "bspline2")
    unknown(preset, "twice and flip")


def use_halves():
    dt = 0.002
    one = ["-body_disk1_velocity", "3*x+6*y,-2*x+0.5*y", "-body_disk1_center", "0.45,0.45", "-body_disk1_radius", "0.4", "-body_disk2_center", "0.9,0.9", "-body_disk2_radius", "0.05", "-dt_size", str(dt), "-time_end", str(dt), "-output_fields", "F", "-method_basis", "bspline2"]
    L = np.array([[3, 6], [-2, 0.5]])
    for update, right in (("usl", np.eye(2) + dt * L), ("usavg", (np.eye(2) + dt / 2 * L) @ (np.eye(2) + dt / 2 * L))):
        disks("step", "-method_update", update, *one)
        found = check.particles("output/step.h5")
        inner = np.hypot(*(check.particles("output/step.h5", 0)["x"][:, :2] - 0.45).T) < 0.03
        wrong = abs(found["F"].reshape(-1, 3, 3)[inner, :2, :2] - right).max()
        check.that(inner.sum() > 10 and wrong < 1e-12, f"{update}: F after a step inside a body differs from that of two halves or one whole by {wrong:.1e}")
    last = {}
    for update in ("usl", "usavg", "usf"):
        run, history = disks(update, "-method_update", update, "-method_basis", "bspline2", "-time_end", "3")
        last[update] = history["total_energy"][-1]
        if update == "usavg":
            unknown(run, "usavg and flip")
            same = [disks("many", "-method_update", update, "-method_basis", "bspline2", "-time_end", "3", *more, n=n)[0].digest for n, more in ((2, []), (3, ["-parallel_strategy", "pool"]))]
            check.that(same == [run.digest] * 2, "usavg: the same bits on 2 processes and by a pool")
    check.that(last["usl"] < last["usavg"] < last["usf"], "the energy with half of the stress before and half after the advance lies between: " + ", ".join(f"{key} {value:.4f}" for key, value in last.items()))


def use_transfer():
    flip, _ = disks("flip")
    run, _ = disks("flap", "-method_transfer", "flap")
    check.that(run.digest == flip.digest, f"a transfer with the share of flip: its bits, {run.digest}")
    unknown(run, "usf and flap")


def hats(x, lower, h, cells):
    """The nodes of linear functions at positions x, [n][2^dim], and their weights."""
    dim = len(cells)
    at = (x - lower) / h
    base = np.minimum(np.floor(at).astype(int), np.array(cells) - 1)
    node, weight = [], []
    for corner in np.ndindex(*(2,) * dim):
        phi = np.prod(np.where(np.array(corner) == 1, at - base, 1 - (at - base)), axis=1)
        ijk = base + corner
        node.append(np.ravel_multi_index(tuple(ijk.T[::-1]), tuple(c + 1 for c in cells[::-1])))
        weight.append(phi)
    return np.array(node), np.array(weight)


def sums_by_hand(found, lower, h, cells):
    """What the recipe's numbers of nodes have to be, [nodes][1 + 3 + 6]: sums over the particles of a snapshot."""
    dim = len(cells)
    F = found["F"].reshape(-1, 3, 3)
    J = np.linalg.det(F)
    b = F @ F.transpose(0, 2, 1)
    rows, columns = np.triu_indices(3)
    diagonal = np.einsum("pkk->pk", F) * (np.arange(3) < dim)
    given = (found["volume"] / J)[:, None] * np.hstack([J[:, None], diagonal, b[:, rows, columns]])
    sums = np.zeros((np.prod(np.array(cells) + 1), 10))
    for node, weight in zip(*hats(found["x"][:, :dim], lower, h, cells)):
        np.add.at(sums, node, weight[:, None] * given)
    return sums, abs(J - 1).max()


def use_node():
    ways = {"on one process": {}, "on 2": {"n": 2}, "on 3": {"n": 3, "more": ["-parallel_strategy", "spatial"]}, "by a pool": {"n": 3, "more": ["-parallel_strategy", "pool"]},
            "with -method_carry all": {"n": 2, "more": ["-method_carry", "all"]}, "with roundoff": {"n": 3, "more": ["-parallel_sums", "roundoff"]},
            "4 lanes": {"lanes": 4}, "2 lanes": {"lanes": 2}}
    for scene, steps, update in (("disks", 8, "usf"), ("disks", 8, "musl"), ("disks3d", 8, "usl")):
        text = check.content(check.scene(scene)).decode()
        lower, upper, cells = (np.array(re.search(rf"^-grid_{word} (\S+)", text, re.M)[1].split(","), float) for word in ("lower", "upper", "cells"))
        moving = ["-body_disk1_velocity", "2*x,-y"] if scene == "disks" else ["-body_ball1_velocity", "2*x,-y,z+x"]
        for way, how in ways.items():
            run = check.must("-options_file", check.scene(scene), "-time_max_steps", str(steps), "-method_update", update, "-method_basis", "linear", "-output_fields", "F,volume,grid",
                             "-output_name", "node", *moving, *how.get("more", []), n=how.get("n", 1), lanes=how.get("lanes"))
            with h5py.File("output/node.h5") as file:
                grid = {name: values[()] for name, values in check.group(file)["grid"].items()}
            right, changed = sums_by_hand(check.particles("output/node.h5"), lower, (upper - lower) / cells, [int(c) for c in cells])
            found = np.hstack([grid[name].reshape(len(right), -1) for name in ("room", "stretch", "cauchy")])
            wrong = abs(found - right).max() / right[:, 0].max()
            check.that(wrong < 1e-12 and changed > 1e-4, f"{scene}, {update}, {way}: the numbers of the nodes differ by {wrong:.1e} from sums by hand; volumes changed by up to {changed:.1e}")
            if way == "on one process":
                digest, alone = run.digest, grid
            elif way != "with roundoff":
                check.that(run.digest == digest and all((grid[name] == alone[name]).all() for name in grid), f"{scene}, {update}, {way}: {', '.join(grid)} have the same bits")
    said = check.must("-options_file", check.scene("disks"), "-time_max_steps", "1", "-dm_view").out
    check.that("\nUnknowns of a node of more sums: room stretch_x stretch_y stretch_z none none none none\n" in said and " cauchy_0 cauchy_1" in said, "-dm_view names them")
    text = check.content("output/node.grid.xdmf").decode()
    check.that(all(f'Name="{name}" AttributeType="{kind}"' in text for name, kind in (("mass", "Scalar"), ("room", "Scalar"), ("v", "Vector"), ("stretch", "Vector"), ("cauchy", "Tensor6"))), "the XDMF file has them")


def use_warning():
    for cells, expected in ((160, 0), (161, 1)):
        block = ["-dim", "2", "-grid_lower", "0,0", "-grid_upper", f"0.04,{cells / 100}", "-grid_cells", f"4,{cells}", "-materials", "m", "-material_m_model", "neohookean", "-material_m_rho", "1000",
                 "-material_m_E", "1e4", "-material_m_nu", "0.3", "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", "0,0.4", "-body_b_upper", "0.04,0.6",
                 "-body_b_material", "m", "-time_max_steps", "1", "-time_end", "1", "-output_format", "none", "-bc_xmin_type", "slip", "-bc_xmax_type", "slip"]
        found = check.must(*block).out.count("warning    the grid is tall\n")
        check.that(found == expected, f"a grid of 4 x {cells} cells: warned of {found} times")


# ---- Names in the guide, in the other documents and in comments

def guide():
    text = check.content(os.path.join(check.source, "docs", "developer.md")).decode()
    return re.search(r"^## Recipes$(.*?)^## ", text, re.M | re.S)[1]


def missing(words):
    """Words in backticks that name nothing: no file, no target of the makefile, no option, nothing in the source."""
    paths = [path for end in ("c", "h", "def") for path in glob.glob(os.path.join(check.source, "src", "*", f"*.{end}"))]
    source = "\n".join(check.content(path).decode() for path in paths)
    lost = []
    for word in words:
        pattern = re.sub(r"<\w+>", r"\\w+", re.escape(word.partition("(")[0]))
        if word.startswith("make "):
            found = re.search(rf"^{word[5:].split()[0]}:", check.content(os.path.join(check.source, "makefile")).decode(), re.M)
        elif re.search(r"\.(c|h|def|py|md)$", word):
            found = any(re.fullmatch(pattern if word[0] != "." else rf".*{pattern}", os.path.relpath(path, start)) for start in (check.source, os.path.join(check.source, "src"))
                        for path in glob.glob(os.path.join(start, "*", "*")) + glob.glob(os.path.join(start, "*", "*", "*.py")))
        elif word.startswith("unit_"):
            found = os.path.exists(os.path.join(check.source, "tests", word + ".c"))
        elif "<" in word or word.startswith("-"):
            found = f'"{word.lstrip("-")}"' in source or re.search(rf"\b{pattern}\b", source)
        else:
            parts = re.findall(r"[A-Za-z_]\w*", re.sub(r'"[^"]*"', "", word))
            found = parts and all(re.search(rf"\b{name}\b", source) for name in parts)
        if not found:
            lost.append(word)
    return lost


def names():
    words = sorted(set(re.findall(r"`([^`]+)`", guide())))
    check.need(len(words) > 50, f"{len(words)} names in the recipes")
    lost = missing(words)
    check.that(not lost, f"{len(words)} names in the recipes, of which the source does not have: {lost}")
    rows = re.findall(r"^MPM_BOUND\((\w+),", read("src/advice/bounds.def"), re.M)
    source = "".join(read(path) for path in tree("src/advice") if path.endswith((".c", ".h")))
    unused = [row for row in rows if not re.search(rf"\bMPM_BOUND_{row}\b", source)]
    check.that(len(rows) > 40 and not unused, f"{len(rows)} bounds of warnings, which nothing uses: {unused}")
    wrong = ["MPMWallsOfResidual", "src/nosuch.c", "physics/nosuch_<name>.c", "Nosuch_<name>", "-nosuch_<m>_E", "unit_nosuch", "make nosuch",
             "MPMOptionsReal(o, nosuch)", ".nosuch.c", '"nosuch"', "1 + 2"]
    found = missing(wrong)
    check.that(found == wrong, f"of {len(wrong)} names that are not there {len(found)} are noticed")


def read(path):
    return check.content(os.path.join(check.source, path)).decode()


def tree(*folders):
    """Files and folders below these folders of the source."""
    paths = [path for folder in folders for path in glob.glob(f"{folder}/**", root_dir=check.source, recursive=True)]
    return [path.rstrip("/") for path in paths if "__pycache__" not in path]


def words_of(path, text):
    """What may name files and functions: of a document what stands in backticks, of a program the words of its comments."""
    if path.endswith(".md"):
        text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
        text = re.sub(r"file `[\w.-]+`(?=[^`]*:\n)", "", text)  # a file that the reader writes
        parts = [part for paragraph in re.split(r"\n\s*\n", text) for part in re.findall(r"`([^`]+)`", paragraph)]
    elif path.endswith(".py"):
        parts = re.findall(r"(?:^|\s)#.*", text, re.M) + re.findall(r'"""(.*?)"""', text, re.S)
    elif path.endswith((".c", ".h", ".def")):
        parts = re.findall(r"/\*.*?\*/", text, re.S)
    else:
        parts = re.findall(r"(?:^|\s)#.*", text, re.M)
    return [word for part in parts for word in re.findall(r"[\w./*<>-]+", part)]


def stale(path, text, paths, source):
    """The words that name a file, a folder or a function, but none of the source. <name> and * stand for any word, and the
    first folders of a path may be left out."""
    lost = []
    for word in dict.fromkeys(words_of(path, text)):
        word = word.strip(".").removeprefix("./") if word[:1] != "." or "/" in word else word
        pattern = re.sub(r"<\w+>|\\\*", r"\\w+", re.escape(word.rstrip("/")))
        if word in FOREIGN or re.fullmatch(r"<[\w/]+\.h>", word):  # the latter are headers of the system
            continue
        if re.search(r"\w>?\.(c|h|def|py)$", word) or path.endswith(".md") and re.match(r"(src|tests|tools|docs)/", word):
            found = re.search(rf"(^|/){pattern}$", paths, re.M)
        elif path.endswith(".md") and word.startswith("MPM"):
            found = re.search(rf"\b{pattern}\b", source)
        else:
            continue
        if not found:
            lost.append(word)
    return lost


def documents():
    paths = "\n".join(tree("src", "examples", "lab", "tests", "tools", "docs", "options") + ["makefile", "README.md"])
    source = "\n".join(read(path) for path in tree("src", "tests", "tools") if path.endswith((".c", ".h", ".def")))
    looked = ["makefile", "README.md"] + [path for path in tree("docs") if path.endswith(".md")] + \
             [path for path in tree("src", "tools") if path.endswith((".c", ".h", ".def", ".py"))]
    for path in looked:
        lost = stale(path, read(path), paths, source)
        check.fault(f"{path} names what is not there: {' '.join(lost)}" if lost else None)
    check.that(len(looked) > 100, f"names in the documents and comments of {len(looked)} files")
    for path, wrong in (("x.md", ["src/nosuch.c", "nosuch.h", "step/nosuch_<name>.def", "tests/nosuch", "MPMNoSuch"]), ("x.c", ["step/nosuch.c", "nosuch.h"]),
                        ("x.py", ["nosuch.py", "tools/nosuch.py"]), ("makefile", ["tests/nosuch.py"])):
        text = {"x.md": "`{}`", "x.c": "/* {} */", "x.py": '"""{}"""', "makefile": "# {}"}[path].format(" ".join(wrong))
        check.that(stale(path, text, paths, source) == wrong, f"names that are not there are noticed in {path}")


if __name__ == "__main__":
    objects, *words = check.arguments(__doc__, None)
    if objects == "names":
        names()
        documents()
        check.end()
    objects = os.path.abspath(objects)
    folder_of_objects = copy(objects)
    if words == ["node"]:
        before = check.must("-options_file", check.scene("disks"), "-time_max_steps", "60", "-output_format", "none").digest
        follow("numbers of a node", NODE, files=2, functions=4, rows=4)
        build(folder_of_objects, "pebble", "CFLAGS=-O1")
        check.program = os.path.abspath("pebble")
        after = check.must("-options_file", check.scene("disks"), "-time_max_steps", "60", "-output_format", "none").digest
        check.that(after == before, f"they change no bit of the particles: {after}")
        use_node()
        check.end()
    follow("law", LAW, files=2, functions=0)
    follow("law with history", RATE, files=2, functions=0)
    follow("wall without a new parameter", WALL, files=2, functions=1)
    follow("wall with two new parameters", SPONGE, files=5, functions=1)
    follow("wall that moves", SHAKER, files=2, functions=1)
    follow("diagnostic", DIAGNOSTIC, files=2, functions=1)
    follow("field that reads F", STRAIN, files=2, functions=1)
    follow("field that reads X", SHIFT, files=2, functions=1)
    follow("quantities of a body", MEASURE, files=2, functions=0, rows=5)
    follow("update scheme", SCHEME, files=1, functions=0)
    follow("update scheme with a new phase", HALVES, files=2, functions=0)
    follow("transfer", TRANSFER, files=1, functions=0)
    follow("warning", WARNING, files=2, functions=1)
    compiled = build(folder_of_objects, "pebble", *(os.path.join(folder_of_objects, unit) for unit in ("unit_material", "unit_tangent")))
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"     {len(compiled)} objects compiled in {used.ru_utime + used.ru_stime:.0f} s of processor time", flush=True)
    check.that(not [name for name in compiled if re.match(r"kernels/(transfer|fbar|volume|rare)|base/(?!version)", name)], "no kernel of particles is compiled anew")
    check.program = os.path.abspath("pebble")
    said = check.must("-help").out
    for option, value in (("material_<m>_model", "rubber"), ("bc_<f>_type", "drag"), ("bc_<f>_type", "sponge"), ("method_update", "twice"), ("method_update", "usavg"),
                          ("method_transfer", "flap"), ("output_fields", "spin"), ("material_<m>_model", "maxwell"), ("history_body_quantities", "most_strain")):
        check.that(re.search(rf"^  -{option} .*\b{value}\b", said, re.M), f"-help lists {value} at -{option}")
    for part in (use_law, use_rate, use_wall, open_faces, use_sponge, use_shaker, use_diagnostic, use_fields, use_scheme, use_halves, use_transfer, use_warning):
        part()
    check.end()
