"""Where the energy of a run goes, by terms (-history_energy); angular momentum; the work of loads; the indicator of the
error of the stress.

usage: test_balance.py PEBBLE SOURCE MPIEXEC
"""
import numpy as np

import check

TERMS = ["energy_gravity", "load_work", "energy_walls", "energy_friction", "energy_volumes", "energy_transfer", "energy_laws", "energy_lag", "energy_integration"]


def run(name, scene, *more, n=1, energy=True):
    """A run of a scene of options/, or of a file of these lines, and its history."""
    path = check.scene(scene) if isinstance(scene, str) else check.write(name + ".opts", scene)
    words = [str(word) for word in more] + (["-history_energy"] if energy else [])
    told = check.must("-options_file", path, "-output_dir", ".", "-output_name", name, "-output_format", "none", *words, n=n)
    return told, check.history(name + ".csv")


def terms(history):
    """The terms of each line; what the scene has no column for is 0."""
    return {name.split("_", 1)[1] if name != "load_work" else "loads": np.array(history[name]) if name in history else 0 * np.array(history["time"])
            for name in TERMS}


def change(history):
    total = np.array(history["total_energy"])
    return total - total[0]


def size(history):
    return np.abs(np.array(history["total_energy"])).max()


def sums_up(what, history):
    wrong = np.abs(sum(terms(history).values()) - change(history)).max() / size(history)
    check.fault(None if wrong < 1e-12 else f"{what}: the terms differ from the change of energy by {wrong:.1e} of it")


def largest(history, name):
    return np.abs(terms(history)[name]).max() / size(history)


def check_integration():
    """A bar: FLIP loses nothing by usf, and by musl hardly more than that its particles move between two mappings; what is left falls
    with dt."""
    for update in ("usf", "usl", "musl"):
        left = []
        for cfl in (0.4, 0.2, 0.1):
            _, history = run("bar", "bar", "-method_basis", "bspline2", "-method_update", update, "-time_end", 0.48, "-dt_cfl", cfl, "-check_energy", 0)
            sums_up(f"bar, {update}", history)
            left.append(largest(history, "integration"))
        check.that(left[0] < 0.012 and left[1] < 0.6 * left[0] and left[2] < 0.6 * left[1],
                   f"bar, {update}: integration is {left[0]:.5f}, {left[1]:.5f}, {left[2]:.5f} of the energy for C = 0.4, 0.2, 0.1")
        lost = terms(history)["transfer"][-1] / size(history)
        check.that(-0.01 < lost < -1e-7 if update == "usl" else abs(lost) < (1e-12 if update == "usf" else 1e-6), f"bar, {update}: FLIP loses {-lost:.1e} of the energy")


def check_transfer():
    """What the other transfers lose is what the energy loses."""
    for name, words, least in (("pic", ["pic"], 0.3), ("mixed", ["flip", "-method_flip", "0.9"], 0.03), ("xpic", ["xpic", "-method_order", "2"], 1e-3), ("apic", ["apic"], 5e-4)):
        for update in ("usf", "usl", "musl"):
            _, history = run(name, "bar", "-method_basis", "bspline2", "-method_update", update, "-time_end", 0.48, "-dt_cfl", 0.05, "-check_energy", 0, "-method_transfer", *words)
            sums_up(f"{name}, {update}", history)
            transfer, lost = terms(history)["transfer"][-1] / size(history), change(history)[-1] / size(history)
            check.that(transfer < -least and abs(transfer - lost) < 1e-3,
                       f"{name}, {update}: transfer takes {-transfer:.5f} of the energy, which loses {-lost:.5f}")


def check_friction():
    """A block slides: friction takes mu m g s, and about what it takes from the momentum times the velocity of the whole block;
    the foot is a little slower than that. Its momentum falls by mu m g t, whatever the step is."""
    for update, most, all_cfl in (("musl", 0.0003, (0.4, 0.1)), ("usl", 0.0003, (0.4, 0.1)), ("usf", 0.02, (0.4, 0.1))):
        for cfl in all_cfl:
            _, history = run("friction", "friction", "-method_basis", "bspline2", "-method_update", update, "-method_transfer", "flip", "-time_end", 0.6, "-history_every", 0, "-dt_cfl", cfl)
            sums_up(f"friction, {update}", history)
            time, v = np.array(history["time"]), np.array(history["momentum_x"]) / np.array(history["mass"])
            mean, mass = (v[1:] + v[:-1]) / 2, history["mass"][0]
            took, weight, drag = -terms(history)["friction"][-1], 0.3 * mass * 10 * np.sum(mean * np.diff(time)), -mass * np.sum(mean * np.diff(v))
            slows = (v[0] - v[-1]) / (3 * time[-1])
            check.that(abs(took / weight - 1) < 0.011 and abs(took / drag - 1) < 0.016 and abs(slows - 1) < 0.02 and largest(history, "integration") < most,
                       f"friction, {update}, C = {cfl}: takes {took:.1f} J; mu m g s is {weight:.1f} J, momentum lost times velocity {drag:.1f} J; slows down by {slows:.4f} mu g; integration {largest(history, 'integration'):.5f}")


def body(model, *more, velocity="0*x,0*x", walls=(), dt=1e-3, end=0.2, grid="1,1", cells="16,16", lower="0,0", upper="1,1"):
    return ["-dim 2", "-grid_lower 0,0", f"-grid_upper {grid}", f"-grid_cells {cells}", "-materials m", f"-material_m_model {model}", "-material_m_rho 1000", "-bodies b",
            "-body_b_shape box", f"-body_b_lower {lower}", f"-body_b_upper {upper}", "-body_b_material m", f'-body_b_velocity "{velocity}"', f"-time_end {end}", f"-dt_size {dt}",
            "-method_basis bspline2", "-method_update musl", "-method_transfer flip", *(f"-bc_{face}_type {wall}" for face, wall in walls), *more]


PERIODIC = [(face, "periodic") for face in ("xmin", "xmax", "ymin", "ymax")]
SOLID = ["-material_m_E 1e5", "-material_m_nu 0.3"]


def check_laws():
    """A metal without hardening dissipates its yield stress times the plastic strain; a viscous fluid in shear all that its motion
    loses; small-strain elasticity at large rotation is not conservative, and the terms say so."""
    metal = body("vonmises", *SOLID, "-material_m_yield 1e3", velocity="sin(2*pi*y),0*x", walls=PERIODIC, dt=5e-4)
    told = check.must("-options_file", check.write("metal.opts", metal), "-output_dir", ".", "-output_every", "1", "-history_energy")
    history, particles = check.history("metal.csv"), check.particles("metal.h5")
    sums_up("metal", history)
    plastic = 1e3 * np.sum(particles["plastic_strain"]) / len(particles["id"])
    took = -terms(history)["laws"][-1]
    check.that(told.good and plastic > 0.3 * size(history) and abs(took / plastic - 1) < 0.01 and largest(history, "integration") < 0.005,
               f"metal: laws take {took:.4f} J, yield stress times plastic strain is {plastic:.4f} J; integration {largest(history, 'integration'):.4f}")
    # All heat stays in W, so the laws take the share of plastic work that is no heat; without that share nothing.
    for share in (0.5, 1.0):
        hot = body("johnsoncook", "-material_m_G 4e4", "-material_m_c0 10", "-material_m_hugoniot_slope 1.4", "-material_m_gruneisen 1.5", "-material_m_yield 1e3",
                   "-material_m_specific_heat 1", f"-material_m_heating_share {share}", velocity="sin(2*pi*y),0*x", walls=PERIODIC, dt=5e-4)
        told = check.must("-options_file", check.write("hot.opts", hot), "-output_dir", ".", "-output_every", "1", "-history_energy")
        history, particles = check.history("hot.csv"), check.particles("hot.h5")
        sums_up(f"hot metal {share:g}", history)
        plastic = 1e3 * np.sum(particles["plastic_strain"]) / len(particles["id"])
        took = -terms(history)["laws"][-1]
        check.that(told.good and plastic > 0.3 * size(history) and abs(took - (1 - share) * plastic) < 0.01 * plastic,
                   f"hot metal, share of heat {share:g}: laws take {took:.4f} J of {plastic:.4f} J of plastic work")
    _, history = run("fluid", body("fluid", "-material_m_K 1e5", "-material_m_viscosity 50", velocity="0.1*sin(2*pi*y),0*x", walls=PERIODIC, dt=5e-4))
    sums_up("fluid", history)
    lost, took = -change(history)[-1], -terms(history)["laws"][-1]
    check.that(lost > 0.3 * size(history) and abs(took / lost - 1) < 0.02, f"fluid: viscosity takes {took:.5f} J of {lost:.5f} J lost")
    _, history = run("column", "column", "-time_end", 0.3)
    sums_up("sand", history)
    base = history["external_work"][-1]
    took, left = terms(history)["laws"][-1] / base, np.abs(terms(history)["integration"]).max() / base
    check.that(took < -0.2 and left < 0.003, f"sand: laws take {-took:.3f} of the work of gravity, integration {left:.4f}")


def check_walls():
    """A wall that slides drags a body along: its work is what the body gains."""
    walls = [("ymin", "fixed"), ("ymax", "moving"), ("xmin", "periodic"), ("xmax", "periodic")]
    for words in (["flip"], ["apic"]):
        for update in ("usf", "usl", "musl"):
            scene = body("neohookean", *SOLID, "-bc_ymax_velocity 1,0", walls=walls, dt=2e-4, end=0.05)
            _, history = run("walls", scene, "-method_update", update, "-method_transfer", *words)
            sums_up(f"walls, {words[0]}, {update}", history)
            part = terms(history)
            check.that(part["walls"][-1] > 0.5 * size(history) and abs(part["walls"][-1] + part["transfer"][-1] - change(history)[-1]) < 0.05 * size(history),
                       f"walls, {words[0]}, {update}: they give {part['walls'][-1]:.3f} J, the energy grows by {change(history)[-1]:.3f} J, transfer {part['transfer'][-1]:.3f} J")


def check_loads():
    """The work of a load is followed in every run, and its error falls with dt."""
    left = []
    for dt in (4e-4, 2e-4, 1e-4):
        scene = body("neohookean", *SOLID, "-loads push", "-load_push_body b", "-load_push_face xmax", "-load_push_type traction", '-load_push_value "-2e3*(1-cos(40*t)),5e2"',
                     walls=[("xmin", "fixed")], dt=dt, end=0.1, upper="0.5,0.5")
        _, alone = run("alone", scene, "-check_energy", 0.1, energy=False)
        _, history = run("load", scene)
        check.fault(None if np.array_equal(alone["load_work"], history["load_work"]) and "energy_laws" not in alone else "load: another work with -history_energy")
        sums_up("load", history)
        left.append(np.abs(np.array(alone["energy_residual"])).max() / np.abs(np.array(alone["load_work"])).max())
    check.that(left[0] < 0.05 and left[1] < 0.6 * left[0] and left[2] < 0.6 * left[1], f"load: its work is the gain of energy but for {left[0]:.4f}, {left[1]:.4f}, {left[2]:.4f}")
    left = []
    for cfl in (0.4, 0.2):
        _, history = run("mms", "mms", "-time_end", 0.002, "-dt_cfl", cfl)
        left.append(largest(history, "integration"))
        check.fault(None if np.abs(history["load_work"]).max() > 0.2 * size(history) else "body force: does no work")
    check.that(left[0] < 0.05 and left[1] < 0.6 * left[0], f"body force: integration is {left[0]:.4f}, {left[1]:.4f} of the energy for C = 0.4, 0.2")
    told, history = run("mms", "mms", "-time_end", 0.002, energy=False)
    check.that("load_work" not in history, "the work of a body force is followed with -history_energy alone")


def check_rotation():
    """A disk turns freely: APIC keeps its angular momentum, of which a part is in C; that of FLIP is sum m x x v."""
    disk = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 16,16", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e6", "-material_m_nu 0.3",
            "-bodies b", "-body_b_shape sphere", "-body_b_center 0.5,0.5", "-body_b_radius 0.25", "-body_b_material m", '-body_b_velocity "0.5-y,x-0.5"', "-time_end 0.5", "-output_every 1", "-method_rim whole"]
    path = check.write("disk.opts", disk)
    kept = {}
    for basis in ("bspline2", "bspline3", "gimp"):
        for transfer in ("apic", "flip", "pic"):
            told = check.must("-options_file", path, "-output_dir", ".", "-method_basis", basis, "-method_transfer", transfer)
            spin = np.array(check.history("disk.csv")["angular_momentum_z"])
            kept[basis, transfer] = np.abs(spin / spin[0] - 1).max()
            of = check.particles("disk.h5")
            plain = np.sum(1000 * (1 / 32) ** 2 * (of["x"][:, 0] * of["v"][:, 1] - of["x"][:, 1] * of["v"][:, 0]))
            same = abs(plain - spin[-1]) / abs(spin[-1] if transfer != "pic" else spin[0])  # pic leaves rounding errors of it
            check.fault(None if told.good and (same < 1e-12 if transfer != "apic" else same > 1e-3) else f"{basis}, {transfer}: {plain} of x x v, {spin[-1]} in the history")
    check.that(max(kept[basis, "apic"] for basis in ("bspline2", "bspline3")) < 1e-12 < 1e-3 < kept["bspline2", "pic"],
               f"angular momentum: apic loses {kept['bspline2', 'apic']:.1e} and {kept['bspline3', 'apic']:.1e}, flip {kept['bspline2', 'flip']:.1e}, pic {kept['bspline2', 'pic']:.1e}")
    check.that(1e-6 < kept["gimp", "apic"] < kept["gimp", "pic"], f"with gimp apic loses {kept['gimp', 'apic']:.1e} and pic {kept['gimp', 'pic']:.1e}")


def check_same():
    """The same bytes of the history on any number of processes and by the pool, and no bit of the state changes."""
    walls = ["-bc_ymin_type", "friction", "-bc_ymin_mu", "0.3", "-gravity", "0,-10"]
    loads = ["-loads", "push", "-load_push_body", "disk1", "-load_push_type", "pressure", "-load_push_value", "10*t", "-acceleration", "0.1*y,0*x"]
    for update, transfer in (("usf", "apic"), ("musl", "flip"), ("usf", "flip")):
        words = ["-time_end", "0.05", "-history_every", "0.005", "-check_energy", "0", "-check_momentum", "0", "-material_soft_model", "elastic", "-body_disk1_center", "0.25,0.25", *walls, *loads,
                 "-method_update", update, "-method_transfer", transfer]
        plain, _ = run("plain", "disks", *words, energy=False)
        serial, _ = run("serial", "disks", *words)
        check.fault(None if plain.digest == serial.digest else f"{update}, {transfer}: -history_energy changes the state")
        printed = serial.find(r"(indicator .*)")
        check.fault(None if printed and serial.find(r"^  (integration +\S+)") else f"{update}, {transfer}: no indicator or no terms are printed")
        for n, strategy in ((3, "spatial"), (3, "pool")):
            other, _ = run("other", "disks", *words, "-parallel_strategy", strategy, n=n)
            check.that(check.content("other.csv") == check.content("serial.csv") and other.digest == serial.digest and other.find(r"(indicator .*)") == printed,
                       f"{update}, {transfer}: the same terms and indicator by {strategy} on {n} processes")


def check_indicator():
    """It falls with h, and is larger where the stress is wrong."""
    jumps = []
    for cells in (8, 16, 32):
        told = check.must("-options_file", check.scene("mms"), "-grid_cells", f"{cells},{cells}", "-time_end", "0.002", "-output_dir", ".", "-output_every", "1", "-output_fields", "stress,volume,error_indicator")
        jumps.append(float(told.find(r"^indicator  stress jumps by (\S+) %")))
        of = check.particles("mms.h5")
        own = np.sqrt(np.average(of["error_indicator"] ** 2, weights=of["volume"]))
        check.fault(None if abs(100 * own / jumps[-1] - 1) < 0.01 else f"the field has {100 * own:.3g} %, the line {jumps[-1]} %")
    check.that(jumps[1] < 0.6 * jumps[0] and jumps[2] < 0.6 * jumps[1], f"indicator: {jumps[0]}, {jumps[1]}, {jumps[2]} % for 8, 16, 32 cells")
    # Particles are numbered with x in the outer loop. The axes swing by u_a = A sin(2 pi X_a) sin(pi c t + pi a), c = 100 m/s.
    told = check.must("-options_file", check.scene("mms"), "-method_update", "musl", "-method_transfer", "flip", "-dt_cfl", "0.4", "-output_dir", ".",
                      "-output_every", "1", "-output_fields", "stress,error_indicator", "-time_end", "0.01")
    of, amplitude = check.particles("mms.h5"), float(dict(line.split(None, 1) for line in open(check.scene("mms")) if line.startswith("-mms"))["-mms_amplitude"])
    n = round(len(of["id"]) ** 0.5)
    at = (np.indices((n, n)).reshape(2, -1) + 0.5) / n
    swing = np.sin(np.pi * 100 * 0.01 + np.pi * np.arange(2))[:, None]
    F = 1 + 2 * np.pi * amplitude * np.cos(2 * np.pi * at) * swing
    J, E, nu = F[0] * F[1], 1e7, 0.3
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    error = np.hypot(*(of["stress"][:, [0, 4]].T - (lam * np.log(J) + mu * (F * F - 1)) / J))
    rank = [np.argsort(np.argsort(values)) for values in (error, of["error_indicator"])]
    check.that(np.corrcoef(*rank)[0, 1] > 0.4, f"indicator: its rank correlation with the true error of the stress is {np.corrcoef(*rank)[0, 1]:.2f}")


check.arguments(__doc__, 0)
for part in (check_integration, check_transfer, check_friction, check_laws, check_walls, check_loads, check_rotation, check_same, check_indicator):
    part()
check.end()
