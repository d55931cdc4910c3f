"""What a transfer loses, against the laws of docs/method.md: the damping of a wave in each step or in time, the rotation of a
free disk, and what -method_damping_viscosity and -method_damping_rate leave when dt changes. And the presets of
-method_preset: each is what its line `preset` says, options beside it count, and the default is balanced.

usage: test_damping.py PEBBLE SOURCE MPIEXEC
"""
import math
import re

import numpy as np

import check

check.arguments(__doc__, 0)
LOSS = {"bspline2": 1 / 4, "bspline3": 1 / 3, "linear": 3 / 16, "gimp": 3 / 16}  # q over (k h)^2


def wave(name, cells, C, method, periods=6):
    """Amplitude damping per step of a standing wave, k h = 2 pi/cells, in a periodic bar."""
    h, k = 1 / cells, 2 * math.pi
    path = check.write(name + ".opts", [
        "-dim 1", "-grid_lower 0", "-grid_upper 1", f"-grid_cells {cells}", "-bc_xmin_type periodic", "-bc_xmax_type periodic",
        "-materials m", "-material_m_model elastic", "-material_m_rho 1", "-material_m_E 1", "-material_m_nu 0",
        "-bodies b", "-body_b_shape box", "-body_b_lower 0", "-body_b_upper 1", "-body_b_ppc 2", "-body_b_material m",
        '-body_b_velocity "1e-6*sin(2*pi*x)"', f"-dt_size {C * h!r}", f"-time_end {periods}", "-history_every 0"])
    check.must("-options_file", path, "-output_format", "none", *method.split())
    rows = check.history("output/" + name + ".csv")
    total = rows["kinetic_energy"] + rows["strain_energy"]
    half = int(0.5 / (C * h))  # the energy oscillates twice in a period: means over half periods
    first, last = total[1:1 + half].mean(), total[-half:].mean()
    steps = len(total) - 1 - half
    return math.log(first / last) / 2 / steps


def check_laws():
    """What transfers lose (docs/method.md): flip a, usl, pic and xpic; the frequency of the wave is k, since c = 1."""
    cells = 16
    kh = 2 * math.pi / cells
    for basis, loss in LOSS.items():
        q = loss * kh**2
        for C in (0.4, 0.1):
            usl = (kh * C)**2 * q / 2
            cases = [("usl flip", "-method_update usl -method_transfer flip", usl, 0.1),
                     ("musl flip .99", "-method_update musl -method_transfer flip -method_flip 0.99", 0.01 * q / 2, 0.1)]
            if basis.startswith("bspline"):
                cases.append(("musl xpic 2", "-method_update musl -method_transfer xpic -method_order 2", q**2 / 2, 0.1))
            for what, method, law, within in cases:
                if basis == "linear" and "usl" in what:
                    continue  # the same law; the program warns of the method
                found = wave("wave", cells, C, f"-method_basis {basis} {method}")
                check.that(abs(found / law - 1) <= within, f"{basis} {what}, C = {C}: damping of a step {found:.3g}, law {law:.3g}")
        lossless = wave("wave", cells, 0.4, f"-method_basis {basis} -method_update musl -method_transfer flip", periods=30)
        check.that(abs(lossless) < 2e-6, f"{basis} musl flip: damping of a step {lossless:.1g}")


def check_rate():
    """Damping by viscosity or by rate: the loss in a time is that of the law, and does not depend on dt."""
    cells, k = 16, 2 * math.pi
    for basis in LOSS:
        for C in (0.4, 0.1, 0.04):
            found = wave("wave", cells, C, f"-method_basis {basis} -method_update musl -method_transfer flip -method_damping_viscosity 1e-3")
            law = 1e-3 * k**2 / 2 * C / cells  # velocities decay by nu k^2, the amplitude by half of that
            check.that(abs(found / law - 1) <= 0.1, f"{basis}, viscosity, C = {C}: damping of a step {found:.3g}, law {law:.3g}")
    losses = [wave("wave", cells, C, f"-method_basis bspline2 -method_update musl -method_transfer flip -method_damping_rate 0.05") / C for C in (0.4, 0.1)]
    check.that(abs(losses[0] / losses[1] - 1) <= 0.1, f"rate: damping in a time {losses[0]:.4g} and {losses[1]:.4g}")


def spin(method, turns=3):
    """Angular momentum of the particles of a free disk of 8 cells across after some turns, over that of the start."""
    path = check.write("spin.opts", [
        "-dim 2", "-grid_lower -.5,-.5", "-grid_upper .5,.5", "-grid_cells 16,16", "-materials m", "-material_m_model neohookean",
        "-material_m_rho 1000", "-material_m_E 1e4", "-material_m_nu .3", "-bodies b", "-body_b_shape sphere", "-body_b_center 0,0",
        "-body_b_radius .25", "-body_b_material m", '-body_b_velocity "0-y,x"', f"-time_end {2 * math.pi * turns}", "-output_every 100"])
    run = check.must("-options_file", path, *method.split())
    momenta = []
    for which in (0, -1):
        found = check.particles("output/spin.h5", which, ("x", "v", "mass"))
        x, v = found["x"], found["v"]
        momenta.append((found["mass"] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])).sum())
    return momenta[1] / momenta[0], run.out


def check_spin():
    """The transfers that keep rotation do; the others say what does."""
    for method, least in (("", 0.965), ("-dt_cfl 0.4", 0.98), ("-method_basis bspline2 -method_update usl -method_transfer aflip", 0.98),
                          ("-method_basis bspline2 -method_update usl -method_transfer apic", 0.92)):
        kept, out = spin(method)
        check.that(kept >= least and "slows down the spin" not in out, f"spin with {method or 'the default'}: {kept:.3f} kept, at least {least}")
    kept, out = spin("-method_basis bspline2 -method_update usl -method_transfer flip")
    check.that(kept < 0.9 and re.search(r"^warning .* slows down the spin of body b .*-method_transfer aflip", out, re.M), f"spin with flip: {kept:.3f} kept, and it is said")


def plain(scene, *lines):
    """Options of a few steps of a scene without those of its method, in which these lines replace others."""
    left = ("-method_", "-dt_", *(line.split()[0] for line in lines))
    with open(check.scene(scene), encoding="utf-8") as file:
        kept = [line for line in file.read().splitlines() if not line.startswith(left)]
    return ["-options_file", check.write(scene + ".opts", kept + list(lines)), "-time_max_steps", "5", "-output_format", "none"]


def check_presets():
    """The line `preset` names the options that make the same run; options beside a preset count."""
    base = plain("ring", "-grid_cells 24,24")
    digests = {}
    for preset in ("fast", "balanced", "accurate", "energy", "solid"):
        run = check.must(*base, "-method_preset", preset)
        line = run.find(rf"^preset +{preset}: (-.*)$")
        again = check.must(*base, *line.split())
        digests[preset] = run.digest
        check.that(run.digest == again.digest, f"preset {preset}: {line}")
        check.that(not re.search("^warning", run.out, re.M), f"preset {preset}: no warning")
        pool = check.must(*base, "-method_preset", preset, "-parallel_strategy", "pool", n=3)
        check.that(pool.digest == run.digest, f"preset {preset}: the same bits with the pool on 3")
    check.that(check.must(*base).digest == digests["balanced"] and len(set(digests.values())) == 5, "the default is balanced, and the presets differ")
    run = check.must(*base, "-method_preset", "accurate", "-method_basis", "bspline2", "-dt_cfl", "0.3")
    check.that(re.search(r"^preset +accurate: -method_basis bspline2 .*-dt_cfl 0.3$", run.out, re.M), "options beside a preset count")
    # remedies that a method of one's own does not have are in the line
    for scene, lines, preset, remedies in [
            ("dambreak", [], "balanced", "-method_light_nodes 0.1 -material_water_relaxation 1"), ("dambreak", [], "fast", "-material_water_relaxation 1"),
            ("taylor", ["-grid_cells 6,6,21"], "balanced", "-method_light_nodes 0.1 -method_locking fbar -method_lock_share 0.8"),
            ("granular_column", ["-time_end 0.2"], "accurate", "-material_rods_relaxation 0.25")]:
        base = [*plain(scene, *lines), "-time_max_steps", "30"]
        run = check.must(*base, "-method_preset", preset)
        line = run.find(rf"^preset +{preset}: (-.*)$")
        own = line.split(" -method_light")[0]
        check.that(remedies in line and check.must(*base, *line.split()).digest == run.digest, f"{scene}, preset {preset}: {line}")
        check.that(check.must(*base, *own.split()).digest != run.digest, f"{scene}: without the remedies another run")


def check_warnings():
    """Settings that were measured to be unstable or wrong are named at the start, with one that works."""
    base = ["-options_file", check.scene("pressure"), "-time_end", "100", "-dry_run", "-output_format", "none", "-output_dir", "."]
    for words, said in (
            ("-method_basis gimp -method_gimp_update none -method_update usl -method_transfer flip -dt_cfl .8", "is stable up to dt = .* expect the run to blow up"),
            ("-method_basis bspline2 -method_update musl -method_transfer flip -dt_cfl .4", "amplifies noise where particles cross cells.*-method_update usl"),
            ("-method_basis bspline2 -method_update musl -method_transfer xpic -dt_cfl .4", "wrong by 50 to 95 %.*-method_update usl"),
            ("-method_basis gimp -method_update musl -method_transfer apic -dt_cfl .2", "changes the state at rest under loads.*use usl"),
            ("-method_basis bspline2 -method_update usl -method_transfer pic -dt_cfl .4", "stops all motion.*aflip"),
            ("-method_basis bspline2 -method_update usl -method_transfer apic -dt_cfl .01", "loses energy in each step"),
            ("-method_basis linear -method_update usl -method_transfer flip", "unstable where particles cross cells.*; use -method_basis bspline2")):
        run = check.must(*base, *words.split())
        check.that(re.search(rf"^warning +\w+ with \w+ .*{said}", run.out, re.M), f"{words}: warned of")
    run = check.must(*base, *"-method_basis bspline2 -method_update usl -method_transfer aflip".split())
    check.that(not re.search("^warning", run.out, re.M), "a good method: no warning")


check_laws()
check_rate()
check_spin()
check_presets()
check_warnings()
check.end()
