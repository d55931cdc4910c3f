"""Contact between bodies (-contacts, -contact_mu): when it begins, how long it lasts, what it keeps; a block that slides;
bodies that are glued, that touch at the start; three bodies in a row; bodies that never meet have the bits of a run without contact. The bits are
the same on any number of processes, with a pool, after a restart and after retries.

usage: test_contact.py PEBBLE SOURCE MPIEXEC
"""
import re

import numpy as np

import check

check.arguments(__doc__, 0)
QUIET = "-output_format none -report_indicator false".split()


def words(values):
    return ",".join(repr(float(v)) for v in values)


def run(name, lines, *more, n=1):
    """Runs a scene of these lines with a line of the history for each step; returns it, and the run."""
    path = check.write(name + ".opts", lines)
    done = check.must("-options_file", path, *QUIET, "-history_every", 0, "-output_name", name, *more, n=n)
    return check.history(f"output/{name}.csv"), done


def boxes(dim, cells, h, materials, bodies, *more):
    """A grid of these cells of size h, of neo-Hookean materials {name: (rho, E, nu)} and boxes {name: (material, lower, upper, velocity)}."""
    lines = [f"-dim {dim}", "-grid_lower " + words([0] * dim), "-grid_upper " + words(c * h for c in cells), "-grid_cells " + ",".join(map(str, cells)),
             "-materials " + ",".join(materials), "-bodies " + ",".join(bodies), "-history_bodies all", *more]
    for name, (rho, E, nu) in materials.items():
        lines += [f"-material_{name}_model neohookean", f"-material_{name}_rho {rho}", f"-material_{name}_E {E}", f"-material_{name}_nu {nu}"]
    for name, (material, lower, upper, velocity) in bodies.items():
        lines += [f"-body_{name}_shape box", f"-body_{name}_material {material}", f"-body_{name}_lower {words(lower)}", f"-body_{name}_upper {words(upper)}",
                  f"-body_{name}_velocity {words(velocity)}"]
    return lines


def bars(n, lengths, speeds, gap=3.2, dim=1, axis=0):
    """Two bars of length 1 or so, density, modulus and wave speed 1, n cells a length; along x or y."""
    h, at = 1 / n, 6
    ends = [at * h, at * h + lengths[0], at * h + lengths[0] + gap * h, at * h + lengths[0] + gap * h + lengths[1]]
    cells = [round(ends[-1] / h) + at, 8]

    def turned(values):
        return values[:1] if dim == 1 else values if axis == 0 else values[::-1]

    bodies = {name: ("m", turned([ends[2 * k], 2 * h]), turned([ends[2 * k + 1], 6 * h]), turned([speeds[k], 0])) for k, name in enumerate("ab")}
    return boxes(dim, turned(cells), h, {"m": (1, 1, 0)}, bodies), gap * h / (speeds[0] - speeds[1])


def check_bars():
    """The first force, the duration 2 L/c, and velocities that are exchanged; the stress is rho c v."""
    v = 0.01
    for n, most, C in ((32, 0.06, 0.4), (32, 0.06, 0.8), (64, 0.04, 0.8)):
        lines, meet = bars(n, [1, 1], [v, -v])
        h, _ = run("bars", lines, "-time_end", meet + 2.6, "-contact_mu", 0, "-history_energy", "-dt_cfl", C)
        p, t = h["momentum_a_x"] / v, h["time"]
        on, off = t[np.nonzero(p < 1 - 1e-6)[0][0] - 1], t[np.nonzero(p < 0.98 * p[-1])[0][0]]
        energy = (h["kinetic_energy"] + h["strain_energy"]) / h["kinetic_energy"][0]
        check.that(abs(on - meet) < 0.03 and abs(off - on - 2) < 0.06 and 1 + p[-1] < most and energy.max() < 1 + 1e-9 and np.abs(h["momentum_x"]).max() < 1e-13,
                   f"bars, {n} cells, C = {C}: first force {on - meet:+.3f} after they meet, for {off - on:.3f}; back with {-p[-1]:.3f}; energy {energy[-1]:.3f}")
        check.fault(None if np.abs(h["energy_integration"]).max() < 1.25 * C / n * h["kinetic_energy"][0] else f"bars: the balance of energy is off by {np.abs(h['energy_integration']).max() / h['kinetic_energy'][0]:.4f}")
    lines, meet = bars(32, [1, 2], [v, 0])
    h, _ = run("unequal", lines, "-time_end", meet + 2.6, "-contact_mu", 0)
    a, b = h["momentum_a_x"][-1] / v, h["momentum_b_x"][-1] / v
    check.that(abs(a) < 0.06 and abs(b - 1) < 0.06, f"a bar meets a longer one at rest: it stops ({a:+.3f}), the longer one has its momentum ({b:.3f})")


def check_turned():
    """The same along y as along x, but for the surface, which is found to 1e-6 of a spacing."""
    found = []
    for axis in (0, 1):
        lines, meet = bars(16, [1, 1], [0.01, -0.01], dim=2, axis=axis)
        h, _ = run("turned", lines, "-time_end", meet + 1, "-contact_mu", 0.2)
        found.append(h["center_a_" + "xy"[axis]])
    check.that(len(found[0]) == len(found[1]) and np.abs(found[0] - found[1]).max() < 1e-8, f"along y as along x: {np.abs(found[0] - found[1]).max():.1e}")


def slope(mu, *more, turn=(0.5, 3 ** 0.5 / 2), end=0.8, h=0.125):
    """A block on a floor, with gravity turned by 30 degrees; returns how far it comes by how far it should."""
    lines = boxes(2, [round(5 / h), round(1.5 / h)], h, {"m": (1000, 1e7, 0.3)}, {"floor": ("m", [0, 0], [5, 0.5], [0, 0]), "block": ("m", [1, 0.5], [2, 1], [0, 0])},
                  "-gravity " + words([10 * turn[0], -10 * turn[1]]), "-bc_ymin_type fixed", "-bc_xmin_type slip", "-bc_xmax_type slip", f"-time_end {end}")
    found, _ = run("slope", lines, *more, "-history_every", end)
    return (found["center_block_x"][-1] - 1.5) / (5 * end ** 2 * max(turn[0] - mu * turn[1], 1e-2)), found


def check_slope():
    for mu in (0, 0.3):
        share, _ = slope(mu, "-contact_mu", mu)
        check.that(abs(share - 1) < 0.03, f"a block slides on a floor with friction {mu}: {share:.4f} of the exact way")
    share, found = slope(0, "-contacts", "c", "-contact_c_stick", end=0.3)
    check.that(abs(found["center_block_x"][-1] - 1.5) < 0.01 * 0.225, f"with -contact_c_stick it moves by {found['center_block_x'][-1] - 1.5:.1e} m where it would slide 0.225 m")


def disks(*more, **how):
    return check.must("-options_file", check.scene("disks"), *QUIET, "-check_energy", 0, *more, **how)


def check_disks():
    """Momentum, and no force before the gap closes."""
    disks("-contact_mu", 0.3, "-history_bodies", "all", "-output_name", "disks", "-history_every", 0)
    h = check.history("output/disks.csv")
    p = np.hypot(h["momentum_disk1_x"], h["momentum_disk1_y"])
    on, meet = h["time"][np.nonzero(np.abs(p - p[0]) > 1e-9 * p[0])[0][0]], (0.6 * 2 ** 0.5 - 0.4) / (0.2 * 2 ** 0.5)
    change = np.abs(h["momentum_x"]).max() / p[0]
    check.that(abs(on - meet) < 0.06 and change < 1e-13, f"disks: first force {on - meet:+.3f} s after they meet, momentum changes by {change:.0e}")


def check_apart():
    """Bodies that never meet have the bits of a run without contact."""
    for update, transfer in (("usl", "aflip"), ("musl", "flip"), ("usf", "apic")):
        digests = {disks("-time_end", 0.3, "-method_update", update, "-method_transfer", transfer, *more).digest for more in ([], ["-contact_mu", 0.3])}
        check.that(len(digests) == 1, f"{update} {transfer}: as long as bodies do not meet, contact changes no bit")


def check_alone():
    """A body a few cells from another one, by whose side or over whose corner it moves, on a wall that waits for both, moves as it does
    alone, bit for bit, whether they store their nodes apart or together."""
    for basis in ("linear", "gimp", "bspline2", "bspline3"):
        found = {}
        for gap, up in [(0, 0)] + [(gap, up) for gap in (4.5, 6, 7, 8.5) for up in (0, gap)]:
            bodies = {"a": ("m", [5, 0.25], [9, 4.25], [0.4, -1]), "b": ("m", [9 + gap, 0.25 + up], [13 + gap, 4.25 + up], [-0.3, -1])}
            lines = boxes(2, [32, 24], 1, {"m": (1, 100, 0.3)}, bodies if gap else {"a": bodies["a"]}, "-bc_ymin_type separate", "-dt_size 0.02", "-time_end 1", f"-method_basis {basis}", "-method_transfer flip")
            found[gap, up] = run("alone", lines, *(["-contact_mu", 0.3] if gap else []))[0]
        alone = found.pop((0, 0))
        wrong = [at for at, one in found.items() if any((alone[key] != one[key]).any() for key in alone if "_a_" in key or key.endswith("_a"))]
        check.that(len(found) == 8 and not wrong, f"{basis}: a body some cells from another one moves as it does alone{f', not {wrong}' if wrong else ''}")


def nodes_stored(out):
    """How many nodes the memory has that a run tells before its first step."""
    particles = int(re.search(r" (\d+) particles", out).group(1))
    each, node, both = (float(number) for number in re.search(r", (\d+) with order and scratch, (\d+) B/node: ([\d.]+) MB", out).groups())
    return (1e6 * both - particles * each) / node


def check_places():
    """Nodes are stored as often as bodies are near each other; disks that meet, part and meet others, and that wait for a wall, on
    processes and in a pool that store them anew."""
    at = {"a": (0.15, 0.15, 0.1, 0.15, 0.05), "b": (0.5, 0.5, 0.1, 0, 0), "c": (0.8, 0.8, 0.08, -0.2, -0.15), "d": (0.2, 0.75, 0.1, 0.15, -0.1),
          "e": (0.8, 0.2, 0.1, -0.15, 0.05), "f": (0.5, 0.85, 0.06, 0.03, -0.1), "g": (0.63, 0.5, 0.02, -0.05, 0)}
    lines = boxes(2, [32, 32], 1 / 32, {"m": (1000, 1000, 0.3)}, {}, "-geometry plane_strain", "-gravity 0,-0.1", "-bc_ymin_type separate")
    lines = [line for line in lines if "-bodies" not in line and "history_bodies" not in line] + ["-bodies " + ",".join(at)]
    for name, (x, y, r, u, v) in at.items():
        lines += [f"-body_{name}_shape sphere", f"-body_{name}_center {x},{y}", f"-body_{name}_radius {r}", f"-body_{name}_material m", f"-body_{name}_velocity {u},{v}"]
    lines += ["-contacts most,top", "-contact_most_bodies a,b,d,e", "-contact_most_mu 0.3", "-contact_top_bodies b,c", "-contact_top_mu 0"]
    words = ["-options_file", check.write("places.opts", lines), *QUIET, "-time_end", 2]
    one = check.must(*words)
    others = {f"{n} processes": check.must(*words, "-parallel_balance", how, n=n).digest for n, how in ((2, "none"), (3, "auto"))}
    others["direct"] = check.must(*words, "-parallel_migrate", "direct", n=3).digest
    others["pool"] = check.must(*words, "-parallel_strategy", "pool", n=3).digest
    check.must(*words, "-time_max_steps", 150, "-checkpoint_every", 1e30)
    others["restart"] = check.must(*words, "-restart_file", "latest", n=2).digest
    wrong = [name for name, digest in others.items() if digest != one.digest]
    check.that(not wrong, f"disks that meet and part: the bits of one process also on {', '.join(others)}; not on {', '.join(wrong) or 'none'}")
    alone, apart = (nodes_stored(disks("-time_end", 0.01, *more).out) for more in ([], ["-contact_mu", 0.3]))
    near = nodes_stored(disks("-time_end", 0.01, "-contact_mu", 0.3, "-body_disk1_center", "0.36,0.36", "-body_disk2_center", "0.645,0.645").out)
    check.that(abs(apart / alone - 1) < 0.1 and 1.9 < near / alone < 4, f"nodes stored: {alone:.0f} without contact, {apart:.0f} of disks far apart, {near:.0f} near each other")


def check_range():
    """The second of two bodies that are near each other, without touching, stores the nodes around it alone. They follow it, also where it
    passes many of its tiles in a step: it moves as it does alone, bit for bit, and so does the other one, which strikes a wall."""
    for basis, gap in (("linear", 1.5), ("bspline3", 3.5)):
        for speed, end in ((20, 4), (2000, 0.04)):
            bodies = {"tall": ("m", [8, 0.25], [12, 94.25], [0, -1]), "small": ("m", [12 + gap, 6], [16 + gap, 10], [0, speed])}
            more = ["-bc_ymin_type separate", "-dt_size 0.02", f"-time_end {end}", f"-method_basis {basis}", "-method_transfer flip"]
            for first, second in (("tall", "small"), ("small", "tall")):
                alone = [run(name, boxes(2, [24, 100], 1, {"m": (1, 100, 0.3)}, {name: bodies[name]}, *more))[0] for name in (first, second)]
                lines = boxes(2, [24, 100], 1, {"m": (1, 100, 0.3)}, {name: bodies[name] for name in (first, second)}, *more)
                both, done = run("range", lines, "-contact_mu", 0.3)
                others = [run("range", lines, "-contact_mu", 0.3, *how, n=3)[1].digest for how in ([], ["-parallel_strategy", "pool"])] if basis == "linear" else []
                wrong = [key for h, name in zip(alone, (first, second)) for key in h if key.endswith("_" + name) or f"_{name}_" in key if (h[key] != both[key]).any()]
                stored = nodes_stored(done.out) / nodes_stored(run("one", lines, "-time_max_steps", 1)[1].out)
                check.that(not wrong and stored < 1.5 + (second == "tall") and set(others) <= {done.digest},
                           f"{basis}, {speed * 0.02:g} cells a step, {second} second: {stored:.2f} times the nodes, and both bodies move as alone{f', not {wrong}' if wrong else ''}")


def check_glued():
    """Bodies in no contact move as one, as without contact; those in contact part."""
    lines = boxes(2, [24, 16], 0.1, {"m": (1000, 1e5, 0.3)},
                  {"a": ("m", [0.4, 0.4], [1, 1.2], [0.1, 0]), "b": ("m", [1, 0.4], [1.6, 1.2], [-0.1, 0.05]), "c": ("m", [1.9, 0.4], [2.1, 1.2], [0, 0])}, "-time_end 0.1")
    for light, most in ((0, 1e-12), (0.1, 1e-6)):
        alone, _ = run("alone", lines, "-method_light_nodes", light)
        glued, _ = run("glued", lines, "-method_light_nodes", light, "-contacts", "k", "-contact_k_bodies", "b,c")
        off = max(np.abs(alone["center_" + at] - glued["center_" + at]).max() for at in ("a_x", "a_y", "b_x", "b_y"))
        check.that(len(alone["time"]) == len(glued["time"]) and off < most, f"bodies that no contact names move as one, light nodes {light}: centres differ by {off:.0e} m")
    apart, _ = run("apart", lines, "-contacts", "k", "-body_b_velocity", "0.3,0", "-body_a_velocity", "0,0", "-time_end", 0.2)
    check.that(apart["center_a_x"][-1] - 0.7 < 0.002 < apart["center_b_x"][-1] - 1.3, "bodies that touch at the start part freely")


def check_beside():
    """Bodies that meet along another axis than that of the normal that is given are warned of; along that axis there is no warning."""
    told = {}
    for axis in "xy":
        lines, meet = bars(16, [1, 1], [0.05, -0.05], dim=2)
        done = run("beside", lines, "-time_end", meet + 2, "-contacts", "c", "-contact_c_normal", axis)[1]
        told[axis] = done.find(rf"seen at t=\S+ s: along {axis} \(-contact_c_normal\) the bodies of contact c overlap by (\S+) cells near \S+ \S+, and pass through each other there; leave out -contact_c_normal")
    check.that(told["y"] and not told["x"], f"bodies that meet along x, with the normal along y: an overlap of {told['y']} cells is warned of, along x of {told['x']}")


def check_film():
    """A film of a viscous fluid runs down a plate to which it sticks: the mean velocity, beside that of the series of a film that starts."""
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,2", "-grid_h 0.1,0.1", "-bc_xmin_type periodic", "-bc_xmax_type periodic", "-bc_ymin_type fixed", "-acceleration 0.5,-10", "-materials w,s", "-material_w_model fluid",
             "-material_w_rho 1000", "-material_w_K 1e6", "-material_w_viscosity 100", "-material_s_model neohookean", "-material_s_rho 1000", "-material_s_E 1e6", "-material_s_nu 0.3", "-bodies plate,pool", "-body_plate_shape box",
             "-body_plate_lower 0,0", "-body_plate_upper 1,0.5", "-body_plate_material s", "-body_pool_shape box", "-body_pool_lower 0,0.5", "-body_pool_upper 1,1.5", "-body_pool_material w", "-history_bodies pool", "-time_end 3"]
    found, _ = run("film", lines, "-contacts", "c", "-contact_c_bodies", "plate,pool", "-contact_c_stick")
    waves = (np.arange(200) + 0.5) * np.pi
    mean, exact = found["momentum_pool_x"][-1] / found["mass_pool"][-1], (10 / waves ** 4 * (1 - np.exp(-0.3 * waves ** 2))).sum()
    check.that(abs(mean / exact - 1) < 0.2, f"a film sticks to a plate, 10 cells high: mean velocity {mean:.3f} m/s, exact {exact:.3f}")


def check_touching():
    """Bodies that touch at the start begin without force: on a line of the grid and beside one, level, inclined and round."""
    low, shapes = "-body_a_shape box|-body_a_lower 0.4,0.2", {}
    for at in (0.8, 0.83):
        shapes[f"boxes at {at}"] = low + f"|-body_a_upper 1.6,{at}|-body_b_shape box|-body_b_lower 0.6,{at}|-body_b_upper 1.2,1.4"
    shapes["a disk on a box"] = low + "|-body_a_upper 1.6,0.83|-body_b_shape sphere|-body_b_center 1,1.13|-body_b_radius 0.3"
    shapes["along a slope"] = '-body_a_shape polygon|-body_a_vertices "0.2,0.2 1.5,0.2 1.5,0.9 0.2,0.5"|-body_b_shape polygon|-body_b_vertices "0.2,0.5 1.5,0.9 1.5,1.6 0.2,1.2"'
    lines = boxes(2, [20, 20], 0.1, {"m": (1000, 1e6, 0.3)}, {"a": ("m", [0, 0], [1, 1], [0, 0]), "b": ("m", [0, 0], [1, 1], [0, 0])}, "-time_end 0.05")
    lines = [line for line in lines if not re.match("-body_._(shape|lower|upper)", line)]
    energy = {(name, more[0]): run("touch", lines + shape.split("|"), *more)[0]["kinetic_energy"].max() for name, shape in shapes.items() for more in (["-contact_mu", 0.3], ["-contacts", "c", "-contact_c_stick"])}
    check.that(not any(energy.values()), f"bodies that touch at the start stay at rest: {', '.join(shapes)}")


def check_stack():
    """Three blocks on each other at rest, which touch at the start, weigh what they weigh."""
    bodies = {name: ("m", [0.4, 0.5 * k], [1.2, 0.5 * (k + 1)], [0, 0]) for k, name in enumerate("abc")}
    lines = boxes(2, [16, 18], 0.1, {"m": (1000, 1e6, 0)}, bodies, "-gravity 0,-10", "-bc_ymin_type separate", "-history_walls ymin", "-damping_kinetic", "-time_end 1.2")
    h, _ = run("stack", lines, "-contact_mu", 0.3)
    late = h["time"] > 0.9
    load, low = h["reaction_ymin_y"][late].mean() / 12e3, h["lower_c_y"][-1]
    check.that(abs(load - 1) < 0.02 and abs(low - 1 + 0.01) < 0.006, f"a stack of three blocks: {load:.4f} of its weight on the floor, its top one at {low:.4f} m")


def check_piston():
    """The reaction of a piston at rest beside a body of two cells is the force that another piston presses through it."""
    lines = boxes(2, [16, 24], 0.125, {"m": (1000, 1e6, 0)}, {"a": ("m", [0.5, 0], [1.5, 0.25], [0, 0]), "b": ("m", [0.5, 0.25], [1.5, 1.25], [0, 0])},
                  "-bc_ymin_type piston", "-bc_ymin_velocity 0", "-bc_ymax_type piston", "-bc_ymax_velocity -0.1", "-bc_ymax_distance 1.75", "-damping_time 0.05",
                  "-time_end 0.3", "-history_walls ymin,ymax")
    h, _ = run("piston", lines, "-contact_mu", 0.3, "-history_every", 0.05)
    alone, _ = run("alone_piston", lines, "-history_every", 0.05)
    share = h["reaction_ymin_y"][-1] / alone["reaction_ymin_y"][-1]
    check.that(abs(share - 1) < 0.01, f"the reaction of a piston beside contact is {share:.4f} of that without contact")


def check_many():
    """Contact of many pairs is told in one line; more bodies than there may be are refused."""
    for n, status, line in ((5, 0, "contact    of 2 more pairs of bodies"), (33, 2, "-contact_mu: 33 bodies have nodes of their own, 32 are allowed; let bodies that do not part from each other be one body\n"), (-33, 2, "-contacts: 33 bodies have nodes of their own, 32 are allowed; let bodies that do not part from each other be one body, or out of contacts")):
        how, n = ["-contact_mu", 0] if n > 0 else ["-contacts", "c"], abs(n)
        lines = boxes(1, [4 * n], 1, {"m": (1, 1, 0)}, {f"b{k}": ("m", [4 * k + 1], [4 * k + 3], [0]) for k in range(n)}, "-time_end 0.01")
        done = check.pebble("-options_file", check.write("many.opts", lines), *QUIET, *how)
        check.that(done.status == status and line in done.said, f"{n} bodies: {line}")


def check_files():
    """Bodies of shape file in contact: those that overlap are refused, with names and place, those that touch are not."""
    for gap, status in ((0, 0), (-0.07, 2)):
        for name, x in (("a", 0.4), ("b", 1.2 + gap)):
            check.write(name + ".csv", ["x,y"] + [f"{x + 0.05 + 0.1 * i!r},{0.45 + 0.1 * j!r}" for i in range(8) for j in range(4)])
        lines = boxes(2, [16, 8], 0.2, {"m": (1000, 1e5, 0.3)}, {"a": ("m", [0.4, 0.4], [1.2, 0.8], [0, 0]), "b": ("m", [1.2, 0.4], [2, 0.8], [0, 0])}, "-time_end 0.01")
        lines = [line for line in lines if not re.match("-body_._(shape|lower|upper|velocity)", line)] + [f"-body_{name}_{word}" for name in "ab" for word in ("shape file", f"file {name}.csv", "ppc 2,2")]
        for n in (1, 2):
            done = check.pebble("-options_file", check.write("files.opts", lines), *QUIET, "-contact_mu", 0.2, n=n)
            said = re.search(r"-bodies: particles of a and b overlap at \(1\.1\d*, 0\.45\); bodies in contact must not overlap at the start: move one", done.err)
            check.that(done.status == status and bool(said) == bool(status), f"bodies of files {'that overlap are refused' if status else 'that touch are not refused'}, {n} processes: {done.err.strip()[-150:]}")


def check_rubs():
    """A coefficient of friction that no surfaces have is noted."""
    for value, line in ((30, r"-contact_mu 30: usual is 0\.02 to 1\.5; if it is an angle in degrees, write 0\.577"),
                        (1000, r"-contact_mu 1000: usual is 0\.02 to 1\.5"), (1.5, None)):
        done = disks("-contact_mu", value, "-time_max_steps", 1)
        check.that(re.search(line, done.out) if line else "usual is" not in done.out, f"friction {value}: {line or 'no note'}")


def check_told():
    """Where bodies lie apart and no contact names them, a run says what they will do: along an axis, along a diagonal in 2-D and 3-D, at
    rest under gravity; where they touch, or have a contact, it says nothing of it."""
    for dim, at, more, said in ((2, (0.6, 0.2), "", True), (2, (0.5, 0.5), "", True), (3, (0.46, 0.46, 0.46), "", True), (2, (0.2, 0.6), "-gravity 0,-10", True), (2, (0.4, 0.2), "", False),
                                (2, (0.6, 0.2), "-contact_mu 0", False)):
        text = lambda values: ",".join(map(str, values))
        lines = [f"-dim {dim}", "-grid_lower " + text([0] * dim), "-grid_upper " + text([1] * dim), "-grid_cells " + text([20] * dim), "-materials m", "-material_m_model neohookean", "-material_m_rho 1000",
                 "-material_m_E 1e4", "-material_m_nu 0.3", "-bodies a,b", "-time_end 1", *more.split("\n")]
        for name, center in (("a", [0.2] * dim), ("b", at)):
            lines += [f"-body_{name}_shape sphere", f"-body_{name}_center " + text(center), f"-body_{name}_radius 0.1", f"-body_{name}_material m"]
        done = check.must("-options_file", check.write("told.opts", lines), "-dry_run")
        check.that(("contact    none: where a and b meet" in done.out) == said, f"balls at 0.2 and {at} {more}: it is {'' if said else 'not '}said that they will stick")


def check_presets():
    """What a collision loses, as the line of the preset says it, without contact and with it: disks 8 cells across, along a diagonal and
    along x."""
    for preset in ("fast", "balanced", "accurate", "energy"):
        lost = {}
        for mu in (None, 0.3):
            for name, more in ("diagonal", []), ("x", ["-body_disk1_center", "0.203,0.5", "-body_disk2_center", "0.797,0.5", "-body_disk1_velocity", "0.14142,0",
                                                       "-body_disk2_velocity", "-0.14142,0", "-time_end", 1.8]):
                path = check.write("own.opts", [line for line in open(check.scene("disks")).read().split("\n") if not line.startswith(("-method_", "-dt_cfl", "-check_energy"))])
                done = check.must("-options_file", path, *QUIET, "-method_preset", preset, *(["-contact_mu", mu] if mu else []), *more)
                h = check.history("output/own.csv")
                lost[mu, name] = 1 - (h["kinetic_energy"] + h["strain_energy"])[-1] / h["kinetic_energy"][0]
            said = [float(number) for number in re.search(r"a collision loses (?:less than )?([\d.]+)(?: to ([\d.]+))? % of its energy", done.out).groups() if number]
            worst, along = 100 * lost[mu, "diagonal"], 100 * lost[mu, "x"]
            good = abs(worst - said[-1]) < 2 and (not mu or said[0] - 1 < along < said[1])
            check.that(good, f"{preset}, {'with' if mu else 'without'} contact: a collision loses {worst:.2f} %, along x {along:.2f} %; the program says {said}")


def check_equal():
    """The same bits on any number of processes, with pool, both migrations, less lanes, after restart and retries."""
    words = ["-contact_mu", 0.3, "-time_end", 2.2, "-body_disk1_velocity", "0.12,0.08"]
    one = disks(*words).digest
    others = {f"{n} processes": disks(*words, n=n).digest for n in (2, 3, 4)}
    others["pool"] = disks(*words, "-parallel_strategy", "pool", n=3).digest
    others["direct"] = disks(*words, "-parallel_migrate", "direct", n=3).digest
    others["2 lanes"] = disks(*words, lanes=2).digest
    disks(*words, "-time_max_steps", 120, "-checkpoint_every", 1e30, n=2)
    others["restart"] = disks(*words, "-restart_file", "latest", n=3).digest
    wrong = [name for name, digest in others.items() if digest != one]
    check.that(not wrong, f"the bits of one process also on {', '.join(others)}; not on {', '.join(wrong) or 'none'}")
    hasty = ["-options_file", check.scene("disks_contact"), *QUIET, "-dt_cfl", 1.35, "-check_state", "retry", "-history_energy", "-check_energy", 0.01, "-time_end", 0.8]
    tried = [check.must(*hasty, *more, n=n) for n, more in ((1, []), (3, []), (3, ["-parallel_strategy", "pool"]))]
    undone = tried[0].find(r"^retries +(\d+) tries")
    check.that(undone and int(undone) > 0 and len({done.digest for done in tried}) == 1, f"the same bits on 1 and 3 processes and in the pool with {undone} steps undone where disks meet")


check_bars()
check_turned()
check_slope()
check_disks()
check_apart()
check_alone()
check_places()
check_range()
check_glued()
check_beside()
check_film()
check_touching()
check_stack()
check_piston()
check_many()
check_files()
check_rubs()
check_told()
check_presets()
check_equal()
check.end()
