"""Values that are hardly meant are noted (src/advice/plausible.def, doubtful.txt; usual.def, from both sides), and no sensible scene gets a note: those of
options/, the starter problems of docs/trust.md, those of the tutorial and the README, sensible.txt, and inputs of other codes
(translated.txt), which also make a few steps.

usage: test_plausible.py PEBBLE SOURCE MPIEXEC doubtful|meant|usual|sensible
"""
import glob
import os
import re
import shlex
import sys

import check
from plain import SCENES, changed, rows

part, = check.arguments(__doc__, 1)

# The name of each row of plausible.def, and the pattern of its note
with open(os.path.join(check.source, "src", "advice", "plausible.def"), encoding="utf-8") as definition:
    ROWS = {name: ".*".join(map(re.escape, re.split(r"\{\w+\}", text)))
            for name, text in re.findall(r'^MPM_UNLIKELY\((\w+), .*"(.*)"\)$', definition.read(), re.M)}


def dry(given, name):
    words = [word for key, value in given.items() for word in ("-" + key, str(value))]
    return check.pebble(*words, "-dry_run", "-output_dir", "out", "-output_name", name)


def told(run):
    """The notes and warnings of a run."""
    return re.findall(r"^(?:note|warning) +(.*)", run.out, re.M)


def tables():
    """The tables over time that cases name: a ramp, a record that ends in a swing, one that ends at rest, a blow, a load that stays."""
    for name, lines in {"ramp": "0,0 1000,1", "swing": "0,1 0.01,-1 0.02,1 0.03,-1 0.04,1 0.05,-1", "still": "0,0 0.1,1 0.2,-1 0.3,0",
                        "blow": "0,0 0.04,1 0.08,0", "hold": "0,0 0.5,1"}.items():
        check.write(f"{name}.csv", lines.split())


# ---- Values that are hardly meant

def judge(case):
    """What is wrong with a case, or None; and the notes."""
    label, arguments, note = case
    run = dry(changed(arguments), "case")
    found = told(run) + run.lines * bool(run.status)
    if not any(re.fullmatch(note[1:], line) if note[0] == "~" else line == note for line in found):
        return f"{label}: exit status {run.status}, {found}, not {note}", found
    return None, found


def doubtful():
    tables()
    found = check.at_once(judge, rows("doubtful.txt"))
    for wrong, _ in found:
        check.fault(wrong)
    lines = [line for _, notes in found for line in notes]
    forgotten, meant = (check.pebble("-options_file", check.write("steps.opts", [f"-{key} \"{value}\"" for key, value in SCENES["balls"].items()] + file), "-dry_run", *command)
                        for file, command in ((["-time_max_steps 10"], []), ([], ["-time_max_steps", "10"])))
    note = next((line for line in told(forgotten) if re.fullmatch(r"-time_max_steps 10 ends the run at 0\.0\d+ of -time_end, 0\.2 s; leave it out if that is to be reached", line)), None)
    check.that(note is not None and not told(meant), "a small number of steps in a file is noted, on the command line it is not")
    lines += [note or ""]
    check.need(len(ROWS) > 40, f"plausible.def has {len(ROWS)} rows")
    for name, pattern in ROWS.items():
        check.fault(None if any(re.fullmatch(pattern, line) for line in lines) else f"no case prints the row {name}")
    two = check.pebble("-options_file", check.write("two.opts", [f"-{key} \"{value}\"" for key, value in {**SCENES["soil"], "material_m_cohesion": 9.81}.items()]),
                       "-dry_run", n=2)
    check.that(two.out.count("if kPa are meant, write 9.81e+03") == 1, "two processes note it once")
    one = told(dry(changed('clay -gravity 0,-981 -initial_stress "-900*9.81*(10-y),0,-1800*9.81*(10-y)"'), "one"))
    check.that(one == ["-gravity 0,-981: with densities in kg/m^3 lengths are in m; write 0,-9.81"], f"of gravity in another unit a stress in balance with the right one says nothing: {one}")


# ---- What the notes say was meant

NUMBER = r"[-+.\d][-+.\de]*"


def remedies(note):
    """What a note advises, as options: the value that was meant, the option left out, or other options with their values."""
    option = re.match(r"-(\w+)", note)
    if not option:
        return []
    found = [{option[1]: value} for value in re.findall(rf"write ((?:{NUMBER},)*{NUMBER})$", note)]
    found += [{option[1]: "none"}] * bool(re.search("; leave it out|, or leave it out|remove it$", note))
    return found + [{name: value} for name, value in re.findall(r"[;,] (?:or )?(?:write|choose|give|use) -(?!restart)(\w+) ([a-z0-9][\w.+-]*(?:,[\w.+-]+)*)(?=[;, ]|$)", note)]


def helps(case):
    """What is wrong with a remedy, or None: with it the scene has the note no longer. A value that is a thousandth of a thousandth of
    the one that is meant gets the note again; then what that says helps. A refusal is of something else."""
    label, arguments, note, remedy = case
    given = changed(arguments)

    def words(line):
        return re.sub(NUMBER, "#", line)
    for _ in range(4):
        given |= remedy
        run = dry({key: value for key, value in given.items() if value != "none"}, "meant")
        again = [line for line in told(run) if words(line) == words(note)]
        if not again:
            return f"{label}: with {remedy}: {run.err.strip()}" if run.status and any(key in run.err for key in remedy) else None
        remedy = (remedies(again[0]) or [remedy])[0]
    return f"{label}: with {remedy}: still {again}"


def meant():
    tables()
    tried = [(label, arguments, note, remedy) for label, arguments, note in rows("doubtful.txt") if note[0] != "~" for remedy in remedies(note)]
    for wrong in check.at_once(helps, tried):
        check.fault(wrong)
    check.that(len(tried) > 75, f"{len(tried)} values that notes advise are without that note")


# ---- Numbers beside usual ones

# The scene of a row of usual.def, by the option and the materials that it is of, and what its values are divided by
WEIGHT, WATER = 1800 * 9.81 * 10, 1000 * 9.81
OF = {"SOIL": "soil -initial_stress none", "FLUID": "water -material_m_rho 1400", "WATER": "water", "DENSE": "metal -material_m_rho 3000", "METAL": "metal", "SOLID": "shock"}
BY = {"material_m_G": "shock", "material_m_K": "water", "material_m_cohesion": "soil -initial_stress none", "material_m_friction_angle": "soil -initial_stress none",
      "material_m_dilation_angle": "soil -initial_stress none -material_m_friction_angle 45", "material_m_k0": "soil -material_m_cohesion 1e6", "material_m_tait_gamma": "water",
      "material_m_hardening": "metal -material_m_yield 2e9", "material_m_melting": "shock -material_m_temperature 100",
      "material_m_softening_power": "shock -material_m_melting 1356", "contact_mu": "balls", "contact_k_mu": "balls -contacts k", "body_r_mu": "tool", "bc_ymin_mu": "clay -bc_ymin_type friction",
      "time_rest": "clay -damping_kinetic true", "check_energy": "balls", "check_momentum": "balls", "checkpoint_wall": "balls", "dt_cfl": "clay"}
BY |= {f"material_m_{name}": "shock" for name in ("c0", "hugoniot_slope", "gruneisen", "rate_factor", "rate_reference", "specific_heat")}
MODULUS = {"soil": 2e7, "clay": 2e7, "metal": 2.1e11, "shock": 47.7e9, "water weight": WATER}
WORDS = {"WEIGHT": "rho g H", "MODULUS": "times -material", "SHEAR": "shear waves", "HEAT": "c0^2"}
SCALE = {"SI": 1, "ONE": 1, "SHEAR": (47.7e9 / 8960) ** 0.5, "HEAT": 3940 ** 2 / 293}


def beside(row):
    """What is wrong with the notes on values a tenth beyond and before the bounds of a row, or None; how many were tried."""
    option, of, scale, *bounds = row
    option = option.replace("<m>", "m").replace("<c>", "k").replace("<b>", "r").replace("<f>", "ymin")
    scene = "water -gravity none -body_b_velocity 0,-1" if option.endswith("_K") and scale == "SI" else BY.get(option) or OF.get(of, "metal" if scale == "MODULUS" else "clay")
    by = SCALE.get(scale) or MODULUS.get(scene.split()[0] if scale == "MODULUS" else scene.split()[0] + " weight", WEIGHT)
    wrong, tried = [], 0
    for bound, factors in zip(bounds[:2], ((1.05, 0.95), (0.95, 1.05))):
        if bound == "PETSC_MAX_REAL" or float(bound) == 0 and option[-3:] != "_nu":
            continue
        for beyond, factor in enumerate(factors):
            value = float(bound) * by * factor if float(bound) else 0.01 - 0.02 * beyond
            run = dry({**changed(scene), option: f"{value:.6g}"}, f"usual_{option}")
            notes = [line for line in told(run) if line.startswith(f"-{option} ") and re.search(" have | has |usual is", line)
                     and (WORDS[scale] in line if scale in WORDS else " times " not in line)]
            if "outside the allowed range" in run.err:
                continue
            tried += 1
            if run.status or bool(notes) != bool(beyond):
                wrong.append(f"{scene} -{option} {value:.6g}: {notes} {run.err[:200]}")
    return "; ".join(wrong) or None, tried


def usual():
    with open(os.path.join(check.source, "src", "advice", "usual.def"), encoding="utf-8") as file:
        table = re.findall(r'^MPM_USUAL\("([^"]+)", (\w+), (\w+), (\S+), (\S+), ', file.read(), re.M)
    found = check.at_once(beside, table)
    for wrong, _ in found:
        check.fault(wrong)
    check.that(len(table) > 30 and all(tried for _, tried in found), f"{sum(tried for _, tried in found)} values beside the bounds of {len(table)} rows")


# ---- Sensible scenes

def translated(text):
    """The options of a scene of translated.txt, whose comment says how they are written."""
    given = {}
    for part in text.split(" ; "):
        word, *words = shlex.split(part)
        groups = {"mat": ("material", "materials", ["model"]), "body": ("body", "bodies", ["shape"]), "wall": ("bc", None, ["type"]), "load": ("load", "loads", ["body", "type"])}
        if word == "grid":
            given |= {"dim": len(words[0].split(",")), "grid_lower": words[0], "grid_upper": words[1], "grid_h": ",".join([words[2]] * len(words[0].split(",")))}
        elif word in groups:
            group, names, keys = groups[word]
            name, values = words[0], dict(zip(keys, words[1:])) | dict(pair.split("=", 1) for pair in words[1 + len(keys):])
            if names:
                given[names] = ",".join(filter(None, [given.get(names), name]))
            if word == "body" and "rigid" not in values:
                values = {"material": given["materials"].split(",")[0]} | values
            given |= {f"{group}_{name}_{key}": value for key, value in values.items()}
        else:
            given |= dict([shlex.split(part)[0].split("=", 1)])
    return given


def scenes():
    """Name and options of each."""
    for name, given in SCENES.items():
        yield name, [word for key, value in given.items() for word in ("-" + key, str(value))]
    tables()
    for label, arguments in rows("sensible.txt"):
        yield label, [word for key, value in changed(arguments).items() for word in ("-" + key, str(value).replace("table(", f"table({os.getcwd()}/"))]
    for label, text in rows("translated.txt"):
        yield label, [word for key, value in translated(text).items() for word in ("-" + key, str(value))]
    for path in sorted(glob.glob(os.path.join(check.source, "options", "*.opts"))):
        yield os.path.basename(path), ["-options_file", path]
    sys.path[:0] = [os.path.join(check.source, "tools", "trust")]
    from starters import STARTERS
    for name, starter in STARTERS.items():
        yield name, shlex.split(starter.scene(starter.grids[0]), comments=True)
    for page in ("README.md", "docs/tutorial.md"):
        with open(os.path.join(check.source, page), encoding="utf-8") as file:
            blocks = [block for block in re.findall(r"^```\n(.*?)^```$", file.read(), re.M | re.S) if "-dim " in block and "-time_end " in block]
        check.need(blocks, f"{page} has scenes")
        for k, block in enumerate(blocks):
            yield f"{page} {k}", ["-options_file", check.write(f"page{k}{os.path.basename(page)}.opts", block)]


TRANSLATED = dict(rows("translated.txt"))


def silent(one):
    name, words = one
    run = check.pebble(*words, "-dry_run", "-output_dir", "out", "-output_name", "sensible", cwd=check.source if "-options_file" not in words else None)
    notes = re.findall(r"^note +(.*)", run.out, re.M) + [line for line in told(run) if re.match("load .* is 0 ", line) or any(re.fullmatch(row, line) for row in ROWS.values())]
    if run.status or not run.out or notes:
        return f"{name}: exit status {run.status}, {notes} {run.err[:300]}"
    if name in TRANSLATED:
        run = check.pebble(*words, "-time_max_steps", 3, "-output_dir", f"steps{hash(name)}", "-output_format", "none", "-checkpoint_every", 0)
        if run.status:
            return f"{name}, three steps: exit status {run.status}, {run.err[:300]}"
    return None


if part == "doubtful":
    doubtful()
elif part == "meant":
    meant()
elif part == "usual":
    usual()
else:
    found = check.at_once(silent, scenes())
    for wrong in found:
        check.fault(wrong)
    check.that(len(found) > 120, f"{len(found)} sensible scenes get no note")
check.end()
