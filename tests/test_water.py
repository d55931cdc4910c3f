"""Water and sand whose volumes relax, with the default settings: what a splash leaves is water again, what rests stays at rest.

usage: test_water.py PEBBLE SOURCE MPIEXEC [WORDS]

WORDS: some, rest, bits, or all [CELLS...]: each scene with all presets on grids of so many cells in a metre, and in 3-D.
"""
import math

import numpy as np

import check

RHO, G = 1000, 9.81
words = check.arguments(__doc__, None)


def tank(cells, walls, *parts, size=(1, 1), K=1e6, g=G):
    """Water in a closed tank; the lines of an options file."""
    dim, text = len(size), lambda values: ",".join(f"{v:.12g}" for v in values)
    return [f"-dim {dim}", "-grid_lower " + text([0] * dim), "-grid_upper " + text(size), "-grid_h " + text([1 / cells] * dim), "-gravity " + text([0] * (dim - 1) + [-g]),
            *(f"-bc_{axis}{side}_type {walls}" for axis in "xyz"[:dim] for side in ("min", "max")), "-materials m", "-material_m_model fluid", f"-material_m_rho {RHO}",
            f"-material_m_K {K}", "-bodies b", "-body_b_material m", *parts, "-history_bodies b", "-history_body_quantities center", "-history_every 0.02"]


def box(lower, upper):
    text = lambda values: ",".join(f"{v:.12g}" for v in values)
    return ["-body_b_shape box", "-body_b_lower " + text(lower), "-body_b_upper " + text(upper)]


# Lines of a scene on so many cells; gravity; area or volume of the water, its depth at rest, and that area's floor; the time at
# which the run ends, and the time constant of the damping after it (of the second run, of 3 s), or of the whole run.
SCENES = {
    "dam break, closed": (lambda n: tank(n, "slip", *box([0, 0], [0.4, 0.8]), K=2e6), G, 0.32, 1, 3, 0.3),
    "dam break": (lambda n: tank(n, "separate", *box([0, 0], [0.4, 0.8])), G, 0.32, 1, 2.5, 0.3),
    "drop": (lambda n: tank(n, "separate", *box([0.25, 0.3], [0.75, 0.7]), g=10), 10, 0.2, 1, 6, None),
    "dam break, 3-D": (lambda n: tank(n, "separate", *box([0, 0, 0], [0.4, 0.4, 0.5]), size=(1, 0.4, 0.6)), G, 0.08, 0.4, 2, 0.3),
}


def probes(depth, h, size):
    """Places of probes: a cell above the floor, and in the middle of the depth."""
    at = [[x * size[0], *(0.5 * s for s in size[1:-1]), y] for x in (0.15, 0.4, 0.6, 0.85) for y in (h, depth / 2)]
    names = [f"p{k}" for k in range(len(at))]
    return at, ["-probes " + ",".join(names), *(f"-probe_{name}_at " + ",".join(f"{v:.12g}" for v in x) for name, x in zip(names, at)),
                *(f"-probe_{name}_fields stress" for name in names)]


def splash(scene, cells, *options, longest=1.0):
    """Runs a scene until it is at rest and checks what water then has to be."""
    lines, g, volume, floor, end, damped = SCENES[scene][0](cells), *SCENES[scene][1:]
    dim, h, depth = 3 if "3-D" in scene else 2, 1 / cells, volume / floor
    size = [float(v) for v in lines[2].split()[1].split(",")]
    at, more = probes(depth, h, size)
    name = f"{scene}, {cells} cells{', ' if options else ''}{' '.join(options)}"
    path = check.write("splash.opts", lines + more)
    words = ["-options_file", path, "-output_dir", ".", "-output_name", "splash", "-report_indicator", "false", *options]
    if damped:
        told = check.pebble(*words, "-time_end", end, "-output_format", "none", "-checkpoint_every", end, timeout=3000)
        if told.good:
            told = check.pebble(*words, "-time_end", end + 3 * longest, "-damping_time", damped, "-restart_file", "latest", "-output_every", 100, timeout=3000)
    else:
        told = check.pebble(*words, "-time_end", end * longest, "-damping_time", 0.5, "-output_every", 100, timeout=3000)
    if not told.good:
        return check.that(False, f"{name}: {told.err.strip()[-250:]}")
    found, rest = check.history("splash.csv"), check.particles("splash.h5")
    left = found["total_energy"] - found["external_work"]
    grown = (left - np.minimum.accumulate(left)).max() / abs(found["external_work"]).max()
    level = 2 * found[f"center_b_{'xyz'[dim - 1]}"][-1]
    p = -rest["stress"].reshape(len(rest["stress"]), -1)[:, [0, 4, 8]].mean(1)
    deep = rest["x"][:, dim - 1] < depth - 1.5 * h
    dead, space = (p[deep] <= 0).mean(), rest["volume"].sum() / volume
    probed = [-np.mean([found[f"probe_p{k}_stress_{c}"][-1] for c in ("xx", "yy", "zz")]) / (RHO * g * (depth - x[-1])) - 1 for k, x in enumerate(at)]
    worst = max(probed, key=abs)
    check.that(grown < 1e-3 and abs(level - depth) < max(0.01 * depth, h / 20) and abs(space - 1) < 0.01 and dead <= 0.02 and abs(worst) < 0.03,
               f"{name}: level {level:.4f} of {depth:.4f} ({(level / depth - 1) * 100:+.2f} %), volumes {space:.4f}, without pressure {dead:.3f}, pressure {worst * 100:+.1f} %, growth of energy {grown:.1e}")


if words[0] == "some":
    for scene in list(SCENES)[:3]:
        splash(scene, 20)
elif words[0] == "all":
    for cells in words[1:]:
        for preset in ("balanced", "fast", "accurate", "energy"):
            for scene in list(SCENES)[:3] if cells != "3-D" else list(SCENES)[3:]:
                splash(scene, int(cells) if cells != "3-D" else 20, "-method_preset", preset)
check.end()
