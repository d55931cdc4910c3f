"""The recipes of the developer's guide (docs/developer.md): what they name is there, and so are the files and the names
of the source that the other documents and the comments name; and the first four recipes, a law, a wall, a diagnostic and
an update scheme, are followed on a copy of the source, with no more lines and files than they say.

usage: test_recipes.py PEBBLE SOURCE MPIEXEC names
       test_recipes.py PEBBLE SOURCE MPIEXEC BUILD     (folder of the objects, of which a copy is brought up to date)
"""
import difflib
import glob
import os
import re
import resource
import shutil
import subprocess

import check

FOREIGN = {"e_log.c", "e_exp.c"}  # files of other projects that a comment names

# ---- The recipes. Each is a list of edits: a new file, or lines that go behind a line of a file.

LAW = [("src/physics/material.def", None, """\
MPM_MATERIAL(rubber, MPM_OBJECTIVE | MPM_HYPERELASTIC, "E nu", "F", "neo-Hookean solid whose pressure is lambda (J - 1)")
"""), ("src/physics/material_rubber.c", None, """\
/* material_rubber.c - W = mu/2 (tr b - 3 - 2 ln J) + lambda/2 (J - 1)^2,  tau = lambda J (J - 1) I + mu (b - I). */
#include "physics/law.h"

MPM_INLINE void rubber_stress(int dim, const MPMMaterial *m, const MPMParticleState *s, MPMReal *tau)
{
  const MPMReal J = MPMDet(dim, s->F), p = m->lambda * J * (J - 1.0);

  MPMLeftCauchyGreen(dim, s->F, tau);
  for (int k = 0; k < 6; k++) tau[k] = m->mu * (tau[k] - MPMSymUnit(3, k)) + p * MPMSymUnit(3, k);
}

MPM_INLINE MPMReal rubber_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = MPMDet(dim, s->F);
  MPMReal       b[6];

  MPMLeftCauchyGreen(dim, s->F, b);
  return 0.5 * m->mu * ((b[0] - 1.0) + (b[3] - 1.0) + (b[5] - 1.0) - 2.0 * MPMLog(J)) +
         0.5 * m->lambda * (J - 1.0) * (J - 1.0);
}

/* A plane wave along n has rho0 c^2 = lambda J^2 + mu (1 + n.b n), a shear wave mu n.b n; n.b n is below 1 and
   twice the sum of |b - I|. */
MPM_INLINE MPMReal rubber_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = MPMDet(dim, s->F);
  MPMReal       b[6], most = MPMAll(1);

  MPMLeftCauchyGreen(dim, s->F, b);
  for (int k = 0; k < 6; k++) most += 2.0 * MPMAbs(b[k] - MPMSymUnit(3, k));
  return (m->mu * most + MPMMax(MPMAll(0), m->mu + m->lambda * J * J)) / m->rho;
}

MPM_MATERIAL_DEFINE(rubber)
""")]

WALL = [("src/physics/wall.def", None, """\
MPM_WALL(drag, "mu", drag, drag, drag, "the velocity on the face decays as exp(-mu t)")
"""), ("src/physics/wall.c", "static PetscBool MPMWallApply_free", """\
static PetscBool MPMWallApply_drag(MPM_WALL_ARGUMENTS)
{
  for (PetscInt d = 0; d < at->dim; d++) v[d] *= 1 - PetscMin(1, f->mu * at->dt);
  return PETSC_FALSE;
}

""")]

SPONGE = [("src/physics/wall.def", None, """\
MPM_WALL(sponge, "rate layers", sponge, sponge, sponge, "velocities decay near the wall, most on it")
"""), ("src/physics/wall.c", "static PetscBool MPMWallApply_free", """\
static PetscBool MPMWallApply_sponge(MPM_WALL_ARGUMENTS)
{
  const PetscReal rate = f->rate / (1 + PetscMax(0, at->distance));

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

DIAGNOSTIC = [("src/output/diagnostics.def", None, """\
MPM_PARTICLE_QUANTITY(spin, FIELD | COLUMN, "spin", "kg m^2/s", "", 1, PETSC_FALSE, 0)
"""), ("src/output/diagnostics.c", "static void Fill_kinetic_energy", """\
static void Fill_spin(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscReal *x = v->x + 2 * p, *u = v->v + 2 * p;

  row[0] = KindOf(s, v, p)->m * (x[0] * u[1] - x[1] * u[0]);
}

""")]

SCHEME = [("src/step/scheme.def", None, """\
MPM_SCHEME(twice, PETSC_FALSE, "as usl, in two transfers to the nodes", P2G_MASS, P2G_FORCE, ADVANCE, G2P)
""")]


def follow(name, edits, files, functions):
    """Does the edits; checks how many files they change or add, and that these get rows of tables, so many functions,
    and nothing else."""
    lines = {}
    for path, before, text in edits:
        old = check.content(path).decode().splitlines(True) if os.path.exists(path) else []
        places = [k for k, line in enumerate(old) if before and line.startswith(before)]
        check.need(not before or len(places) == 1, f"{name}: {path} has {len(places)} lines that begin with '{before}'")
        new = old[:places[0]] + text.splitlines(True) + old[places[0]:] if before else old + text.splitlines(True)
        check.write(path, "".join(new))
        lines[path] = [line[2:] for line in difflib.ndiff(old, new) if line[0] in "+-"]
    made = sum(len(re.findall(r"^(?:static|MPM_INLINE) [^;=]*\)$", "".join(added), re.M))
               for path, added in lines.items() if path != "src/physics/material_rubber.c")
    rows = {path: len(added) for path, added in lines.items() if path.endswith(".def")}
    check.that(len(lines) == files and made == functions, f"{name}: {sum(map(len, lines.values()))} lines in {len(lines)} files, {made} functions: "
               + ", ".join(f"{os.path.basename(path)} {len(added)}" for path, added in lines.items()))
    table = edits[0][0]
    check.that(rows[table] == 1, f"{name}: one row in {os.path.basename(table)}")


def build(folder, *targets):
    """make, as a user starts it, in the copy. Its objects are those of the build under test: make compiles what changed."""
    compiler = os.path.basename(folder).removesuffix("-debug")
    words = ([] if compiler == "mpicc" else [f"CC={compiler}"]) + (["DEBUG=1"] if folder.endswith("-debug") else [])
    done = subprocess.run(["make", "-j2", *words, f"BUILD={folder}", "PEBBLE=pebble", *targets], capture_output=True, text=True)
    check.need(done.returncode == 0 and "warning" not in done.stderr, f"make {' '.join(targets)}: {done.stdout[-1000:]}{done.stderr[-3000:]}")
    return re.findall(r"^  CC +\S+/(\S+)\.o$", done.stdout, re.M)


def copy(objects):
    """A tree with the source, the makefile and the objects; their times stay."""
    shutil.rmtree("copy", ignore_errors=True)
    os.makedirs("copy/tests")
    os.chdir("copy")
    shutil.copytree(os.path.join(check.source, "src"), "src")
    shutil.copy2(os.path.join(check.source, "makefile"), "makefile")
    for name in ("unit.h", "unit_material.c"):
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
    run = check.run([os.path.join(folder_of_objects, "unit_material")])
    check.that(run.status == 0 and re.search(r"^\d+ checks, 0 failed$", run.out, re.M), f"the unit test takes the law up: {(run.out + run.err).strip()[-300:]}")


def use_wall():
    free, _ = disks("free")
    still, _ = disks("still", "-bc_xmax_type", "drag", "-bc_xmax_mu", "0")
    check.that(still.digest == free.digest, "a drag of 0 changes no bit")
    _, history = disks("drag", "-bc_xmax_type", "drag", "-bc_xmax_mu", "20")
    drag = history["total_energy"]
    check.that((drag[1:] <= drag[:-1]).all() and drag[-1] < 0.999 * drag[0], f"drag: the energy falls to {drag[-1] / drag[0]:.4f} of what it was")


def use_sponge():
    def sponge(name, layers, rate=5, n=1, **more):
        return disks(name, "-bc_xmax_type", "sponge", "-bc_xmax_rate", str(rate), "-bc_xmax_layers", str(layers), *more.get("options", []), n=n)
    free, _ = disks("free")
    check.that(sponge("rate0", 4, rate=0)[0].digest == free.digest, "a sponge of rate 0 changes no bit")
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


def use_diagnostic():
    run, history = disks("spin", "-output_fields", "velocity,spin")
    check.that(run.good and abs(history["spin"]).max() < 1e-14, f"spin is conserved, 0: at most {abs(history['spin']).max():.1e} kg m^2/s")
    run, history = disks("turn", "-body_disk1_center", "0.35,0.35", "-body_disk1_velocity", "-(y-0.35),x-0.35", "-output_fields", "spin")
    for which in (0, -1):
        column, field = history["spin"][which], check.particles("output/turn.h5", which, ["id", "spin"])["spin"].sum()
        check.that(abs(field / column - 1) < 1e-12 and abs(column) > 0.1, f"spin of a disk that turns: the column, {column:.6f} kg m^2/s, is the sum of the field, {field:.6f}")


def use_scheme():
    usl, _ = disks("usl", "-method_update", "usl", "-report_phases")
    run, _ = disks("twice", "-method_update", "twice", "-report_phases")
    check.that(run.digest == usl.digest and run.find(r"(P2G_FORCE)") and not usl.find(r"(P2G_FORCE)"), f"two transfers in place of one: the bits of usl, {run.digest}")


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
    paths = "\n".join(tree("src", "tests", "tools", "docs", "options") + ["makefile", "README.md"])
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
    (objects,) = check.arguments(__doc__, 1)
    if objects == "names":
        names()
        documents()
        check.end()
    objects = os.path.abspath(objects)
    folder_of_objects = copy(objects)
    follow("law", LAW, files=2, functions=0)
    follow("wall without a new parameter", WALL, files=2, functions=1)
    follow("wall with two new parameters", SPONGE, files=5, functions=1)
    follow("diagnostic", DIAGNOSTIC, files=2, functions=1)
    follow("update scheme", SCHEME, files=1, functions=0)
    compiled = build(folder_of_objects, "pebble", os.path.join(folder_of_objects, "unit_material"))
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"     {len(compiled)} objects compiled in {used.ru_utime + used.ru_stime:.0f} s of processor time", flush=True)
    check.that(not [name for name in compiled if name.startswith(("kernels/", "base/")) and name != "base/version"], "no kernel of particles is compiled anew")
    check.program = os.path.abspath("pebble")
    said = check.must("-help").out
    for option, value in (("material_<m>_model", "rubber"), ("bc_<f>_type", "drag"), ("bc_<f>_type", "sponge"), ("method_update", "twice"), ("output_fields", "spin")):
        check.that(re.search(rf"^  -{option} .*\b{value}\b", said, re.M), f"-help lists {value} at -{option}")
    for part in (use_law, use_wall, use_sponge, use_diagnostic, use_scheme):
        part()
    check.end()
