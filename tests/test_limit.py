"""pebble-study limit: the limits of a block, a cylinder, a footing and slopes beside those that are known; what the study
refuses, no limit, going on where it ended.

usage: test_limit.py PEBBLE SOURCE MPIEXEC PART

PART: command, the smallest scene; loose, a slope with hardly any cohesion on soft ground; or cylinder footing slopes, on two grids each."""

import math
import os
import re
import subprocess
import sys

import check
import studying

(part,) = check.arguments(__doc__, 1)
studying.prepare()


def box(name, upper, h, *more, shape=(), model=()):
    """The options of a body on smooth walls xmin and ymin, in plane strain."""
    lines = ["-dim 2", "-grid_lower 0,0", f"-grid_upper {upper}", f"-grid_h {h},{h}", "-bc_xmin_type slip", "-materials m", "-material_m_rho 2000", "-material_m_nu 0.3"]
    lines += [*model, "-bodies b", "-body_b_material m", "-body_b_ppc 2,2", *(shape or ["-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 1,1"]), "-time_end 1", *more]
    return check.write(f"{name}.opts", lines)


def clay(c, stiff):
    return ["-material_m_model vonmises", f"-material_m_yield {math.sqrt(3) * c}", f"-material_m_E {stiff}"]


def soil(c, phi, psi):
    return ["-material_m_model druckerprager", "-material_m_fit plane_strain", f"-material_m_cohesion {c}", f"-material_m_friction_angle {phi}",
            f"-material_m_dilation_angle {psi}", "-material_m_E 1e8"]  # fmt: skip


def pressed(face, value):
    return ["-loads q", "-load_q_body b", "-load_q_type pressure", f"-load_q_face {face}", f'-load_q_value "{value}"']


def polygon(vertices):
    return ["-body_b_shape polygon", f'-body_b_vertices "{vertices}"']


def study(scene, *words):
    return studying.study("limit", scene, *words)


def started(scene, *words):
    """The same as a user starts it."""
    words = [sys.executable, os.path.join(check.source, "lab", "study.py"), "limit", scene, *words]
    done = subprocess.run(words, capture_output=True, text=True, timeout=3000)
    return check.Run(done.returncode, done.stdout, done.stderr)


def factors(scene, *words):
    """On each grid, from the table; and the range that the study tells."""
    told = started(scene, "-output_dir", ".", *words)
    found = re.search(r"^limit +(\S+) to (\S+):", told.out, re.M)
    if told.status or not found:
        check.that(False, f"{scene}: {told.out[-600:]}{told.err[-600:]}")
        return [], (0, 0)
    return [float(row["factor"]) for row in check.rows(os.path.basename(scene).replace(".opts", "_limit.csv"))], (float(found[1]), float(found[2]))


def beside(name, found, known, allowed, whole=1):
    """allowed: below and above, as parts of what is known; whole: what a factor of 1 is, as `known` is told."""
    values, (low, high) = [whole * value for value in found[0]], (whole * end for end in found[1])
    offs = [value / known - 1 for value in values]
    check.that(
        bool(offs) and all(-allowed[0] <= off <= allowed[1] for off in offs),
        f"{name:<58} {' '.join(f'{value:.4f}' for value in values)}   known {known:.4f}, off by {' '.join(f'{100 * off:+.1f}' for off in offs)} %, "
        f"allowed -{100 * allowed[0]:g} to +{100 * allowed[1]:g} %",
    )
    check.that(low <= known <= high and high - low < 0.35 * known, f"{name:<58} the range has what is known: {low:.4g} to {high:.4g}")


def block(name, *more):
    return box(name, "1.5,1.5", 0.25, "-bc_ymin_type slip", *more, model=clay(1, 1e4))


def command():
    """Between smooth walls a block of clay in plane strain bears a pressure of 2 c."""
    scene = block("block", *pressed("ymax", "4*t"))
    words = ["--levels", "2", "--tolerance", "0.03", "-output_dir", "."]
    first = started(scene, *words)
    check.that(first.status == 0, f"the study ends well {first.err}")
    before = check.content("block_limit.csv")
    table = check.rows("block_limit.csv")
    check.that(
        len(table) == 2 and all(0.48 < float(row["holds"]) < float(row["fails"]) < 0.515 for row in table),
        f"a block of clay bears half of 4 c: {[(row['holds'], row['fails'], row['ends']) for row in table]}",
    )
    load = re.search(r"^ +load q is (\S+) N then$", first.out, re.M)
    check.that(load and abs(float(load[1]) - 2) < 0.06, f"its load is told: {load and load[0]}")
    check.that(re.search(r"^factor +0\.\d+ \+- .*^limit +0\.\d+ to 0\.\d+: .*^uncertain ", first.out, re.M | re.S), "factor, range, what is uncertain")
    check.that(check.content("block_limit.png").startswith(b"\x89PNG"), "it is drawn")
    again = study(scene, *words)
    check.that(
        again.status == 0 and len(re.findall("^known ", again.out, re.M)) == 2 and not re.search("^run ", again.out, re.M) and check.content("block_limit.csv") == before,
        "the same study again: no run is made, the table is the same",
    )
    weak = study(scene, *words, "-load_q_value", "t", "--reduce", "strength", "--levels", "1")
    table = check.rows("block_limit.csv")
    check.that(
        weak.status == 0 and 1.9 < float(table[0]["holds"]) < 2.06,
        f"at a pressure of c its strength can be divided by 2: {table[0]['holds']} {weak.err}",
    )
    fails = study(scene, "-snes_max_it", "2", "-snes_linesearch_type", "basic", "--levels", "1", "--tolerance", "0.1", "-output_dir", ".")
    check.that(
        re.search(r"^warning +grid 1: before it failed the body was only \S+ times as soft as at first: the solver may have failed", fails.out, re.M)
        and "limit      not found: at least" in fails.out,
        f"a failure of the solver is no limit: {fails.out[-900:]}{fails.err}",
    )
    bad = study(scene, "-load_q_value", "t", "--reduce", "strength", "-snes_max_it", "1", "-snes_linesearch_type", "basic", "--levels", "1", "-output_dir", ".")
    check.that(
        bad.status == 3 and len(re.findall("^run ", bad.out, re.M)) == 1 and re.match("no limit on grid 1: the solver failed with strength/1, where the body had hardly softened: .* out of balance", bad.err),
        f"where the solver fails at once no other strength is tried: {bad.out[-400:]}{bad.err}",
    )
    layers = block("layers", "-gravity 0,-1e-6", "-stages fill,wait", "-stage_fill_time 1", "-stage_fill_damping_time 0.1", "-stage_fill_time_rest 1e-3", "-stage_wait_time 1", "-stage_wait_material_m_yield 1.2",
                   "-stage_wait_damping_kinetic", *pressed("ymax", "min(1,t)"))  # fmt: skip
    layers = check.write("layers.opts", [line for line in check.content(layers).decode().splitlines() if not line.startswith("-time_end")])
    told = study(layers, "--reduce", "strength", "--levels", "1", "--tolerance", "0.05", "-output_dir", ".")
    table = check.rows("layers_limit.csv") if told.status == 0 else [{"holds": "nan"}]
    check.that(
        told.status == 0 and "stand aside in statics: -stage_fill_damping_time" in told.out.replace("-stage_fill_time_rest ", "") and 1.2 < float(table[0]["holds"]) < 1.45,
        f"of two stages the second, of clay of c = 0.69, decides: {table[0]['holds']} {told.out[-600:]}{told.err}",
    )
    told = study(layers, "--levels", "1")
    check.that(told.status == 2 and "--raise does not apply with -stages, whose loads do not grow in proportion to time" in told.err, told.err)
    pulls = study(scene, "-load_q_value", "-4*t", "--levels", "1", "--dry-run", "-output_dir", ".")
    check.that(re.search("^note +-load_q_value -4\\*t pulls .* a load that presses it has the other sign$", pulls.out, re.M), f"the sign of the load is told: {pulls.err}")
    none = study(scene, "-load_q_value", "t", "--levels", "1", "-output_dir", ".")
    check.that(
        none.status == 3 and none.err.strip() == "no limit on grid 1: the scene carries its whole load; let it grow further, in proportion to t",
        f"no limit: {none.err.strip()}",
    )
    loose = box("loose", "1.5,1.5", 0.25, "-bc_ymin_type separate", "-gravity 0,-1", model=clay(1, 1e4), shape=["-body_b_shape box", "-body_b_lower 0,0.5", "-body_b_upper 0.5,1"])
    none = study(loose, "--levels", "1", "-output_dir", ".")
    check.that(
        none.status == 3 and none.err.strip() == "no limit on grid 1: the scene does not carry a millionth of its load: nothing holds the body "
        "(-bc_<f>_type separate only pushes), or the load is that much too large",
        f"nothing holds: {none.err.strip()}",
    )
    heavy = block("heavy", "-gravity 0,-1e-3", "-damping_time 0.1", "-dt_cfl 0.3")
    told = study(heavy, "--raise", "gravity", "--dry-run")
    check.that(
        told.status == 0 and "note       of the scene these stand aside in statics: -damping_time -dt_cfl" in told.out and "dry run    the study is valid" in told.out,
        f"what belongs to motion stands aside: {told.out}{told.err}",
    )
    bent = study(block("bent", *pressed("ymax", "4*t^2")), "--dry-run")
    check.that("note       load q is not in proportion to time: 1 N at half of -time_end, at most 4 N; the factor is t/time_end" in bent.out, f"a load that bends: {bent.out}")
    told = study(block("noted", "-gravity 0,-1", "-material_m_hardening 1", "-method_basis gimp", "-gravity_ramp 0.5", "-acceleration 0,t"), "--dry-run", "-method_time", "static")
    check.that(
        told.status == 0 and all(text in told.out for text in ("gimp locks", "m hardens", "-gravity_ramp", "-acceleration")),
        f"notes: {told.out}{told.err}",
    )
    told = study(box("soil", "1.5,1.5", 0.25, "-bc_ymin_type slip", "-gravity 0,-1", model=[line for line in soil(1, 20, 0) if "fit" not in line]), "--dry-run")
    check.that("note       m is stronger in plane strain than its friction_angle says" in told.out, f"a cone that is stronger in plane strain: {told.out}{told.err}")
    elastic = ["-material_m_model elastic", "-material_m_E 1e4"]
    for path, words, line in (
        (heavy, ["--tolerance", "0"], "--tolerance 0.0 is outside the allowed range 0.0001 <= tolerance <= 0.5"),
        (heavy, ["--softer", "1"], "--softer 1.0 is outside the allowed range 2 <= softer <= 1000000.0"),
        (heavy, ["--steps", "200"], "--steps is of another study than limit"),
        (heavy, ["--raise", "gravity", "--reduce", "strength"], "--reduce does not apply with --raise: choose one of them"),
        (block("bare"), [], "the study needs something that can become too much: give the scene -loads or -gravity"),
        (scene, ["--raise", "gravity"], "--raise gravity does not apply: the scene has no -gravity"),
        (block("both", "-gravity 0,-1", *pressed("ymax", "t")), ["--raise", "gravity"], "--raise gravity does not apply to a scene with -loads: --raise load raises both"),
        (box("elastic", "1.5,1.5", 0.25, "-bc_ymin_type slip", "-gravity 0,-1", model=elastic), ["--reduce", "strength"],
         "--reduce strength does not apply: no material has the model vonmises or druckerprager"),
        (check.scene("cantilever"), ["--reduce", "strength"], "--reduce strength does not apply: no material has the model vonmises or druckerprager"),
        (heavy, ["-method_time", "euler"], "-method_time euler does not apply: a limit is looked for with -method_time static"),
        (heavy, ["-bc_xmin_type", "friction", "-bc_xmin_mu", "0.5"], "-bc_xmin_type"),
    ):  # fmt: skip
        told = study(path, *words)
        last = told.err.strip().splitlines()[-1:] or [""]
        check.that(told.status == 2 and line in last[0], f"{' '.join(words)}: {last[0]}")


def cylinder():
    """2/sqrt(3) ln(b/a) of the yield stress, for b/a = 2; a quarter, whose rim is made of steps."""
    ring = ["-body_b_shape expression", "-body_b_lower 0,0", "-body_b_upper 2,2", '-body_b_expression "min(x*x+y*y-1,4-x*x-y*y)"']
    scene = box("cylinder", "2.5,2.5", 0.125, "-bc_ymin_type slip", *pressed("all", "t*(X*X+Y*Y<2.25)"), shape=ring, model=clay(1 / math.sqrt(3), 1e3))
    beside("thick cylinder, 8 and 16 cells thick, p/yield", factors(scene, "--levels", "2"), 2 / math.sqrt(3) * math.log(2), (0.04, 0.02))


def footing():
    """Prandtl's 2 + pi, on half a footing of half width 1."""
    scene = box("footing", "6,3.5", 0.25, "-bc_xmax_type slip", "-bc_ymin_type fixed", *pressed("ymax", "8*t*(X<1)"), shape=["-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 6,3"],
                model=clay(1, 1e3))  # fmt: skip
    beside("strip footing, 4 and 8 cells in half its width, q/c", factors(scene, "--levels", "2"), 2 + math.pi, (0.025, 0.02), 8)


def slopes():
    """Slopes 10 m high with 10 and 20 cells in their height, the last with 16 and 32."""
    held = ["-bc_ymin_type fixed", "-gravity 0,-10"]
    gentle = box("gentle", "32,11", 1, *held, shape=polygon("0,0 32,0 12,10 0,10"), model=soil(10e3, 20, 0))
    beside("2:1, phi 20, c/(rho g H) 0.05 (Griffiths and Lane 1999)", factors(gentle, "--reduce", "strength", "--levels", "2"), 1.4, (0.05, 0.05))
    steep = box("steep", "30,16", 1, *held, "-bc_xmax_type slip", shape=polygon("0,0 30,0 30,5 20,5 14.2265,15 0,15"), model=clay(200e3 / 5.24, 2e7))
    beside("60 degrees, undrained: rho g H/c over 5.24 (Taylor 1937)", factors(steep, "--raise", "gravity", "--levels", "2"), 1, (0.05, 0.05))
    dilates = box("dilates", "35,16.25", 0.625, *held, "-bc_xmax_type slip", shape=polygon("0,0 35,0 35,5 25,5 15,15 0,15"), model=soil(12.38e3, 20, 20))
    beside("45 degrees, phi = psi = 20 (Dawson, Roth and Drescher 1999)", factors(dilates, "--reduce", "strength", "--levels", "2"), 1, (0.05, 0.05))


def loose():
    """ACADS' slope EX1(a), 2:1 with c/(rho g H) = 0.015, whose factor of safety is 1: the ground is so soft that a slope that slid comes to rest
    before it has yielded 30 times as much as at first. Of the stages of a cut all happens in the first step."""
    sand = [line.replace("1e8", "1e7") for line in soil(3000, 19.6, 0)]
    scene = box("loose", "45,17", 1, "-bc_xmax_type slip", "-bc_ymin_type fixed", "-gravity 0,-10", shape=polygon("0,0 45,0 45,15 28,15 8,5 0,5"), model=sand)
    told = study(scene, "--reduce", "strength", "--levels", "1", "--tolerance", "0.05", "-output_dir", ".")
    table = check.rows("loose_limit.csv") if told.status == 0 else [{"holds": "nan", "fails": "nan", "ends": told.err}]
    holds, fails = (float(table[0][name]) for name in ("holds", "fails"))
    check.that(0.95 < holds < fails < 1.08 and table[0]["ends"] == "slide", f"a slope of c/(rho g H) = 0.015 holds with its strength over {holds:g}, and does not over {fails:g}; known 1")
    ways = re.findall(r"^run +grid 1: strength/(\S+) .*; moved (\S+) m; ", told.out, re.M)
    check.that(float(dict(ways)["1"]) < float(dict(ways)["1.2"]) and "note       grid 1: the body counts as failed since it slides far" in told.out, f"how far it moved is told: {ways}")


{"command": command, "loose": loose, "cylinder": cylinder, "footing": footing, "slopes": slopes}[part]()
check.end()
