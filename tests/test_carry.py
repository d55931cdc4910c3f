"""A run carries and sends only what its scene needs. The fields of particles by law and method; -method_carry all, with
every field, has the same digest; the volume ratio that plastic laws keep in place of F; numbers of a node in messages.

usage: test_carry.py PEBBLE SOURCE MPIEXEC
"""
import numpy as np

import check

STEPS = 12
SOLID = ["-material_m_E", 1e6, "-material_m_nu", 0.3]
LAWS = {
    "elastic": SOLID, "neohookean": SOLID, "vonmises": [*SOLID, "-material_m_yield", 1e3],
    "johnsoncook": ["-material_m_G", 4e5, "-material_m_c0", 30, "-material_m_hugoniot_slope", 1.4, "-material_m_gruneisen", 1.5, "-material_m_yield", 1e3,
                    "-material_m_specific_heat", 1],
    "druckerprager": [*SOLID, "-material_m_friction_angle", 30], "fluid": ["-material_m_K", 1e6],
}
SHOWN = ["-output_fields", "velocity"]  # snapshots without F


def block(law, *more, dim=2, steps=0):
    """Options of a block that turns and flies through a grid, of this law."""
    every = lambda value: ",".join([str(value)] * dim)
    velocity = ",".join(["0.6+40*(0.5-y)", "0.2+40*(x-0.5)", "0.1"][:dim]) if dim > 1 else "0.6+sin(9*x)"
    return ["-dim", dim, "-grid_lower", every(0), "-grid_upper", every(1), "-grid_cells", every(24 if dim < 3 else 12),
            "-materials", "m", "-material_m_model", law, "-material_m_rho", 1000, *LAWS[law], "-bodies", "b", "-body_b_shape", "box",
            "-body_b_lower", every(0.3), "-body_b_upper", every(0.7), "-body_b_material", "m", "-body_b_velocity", velocity,
            "-method_basis", "bspline2", "-method_transfer", "flip", "-method_update", "usl", "-time_end", 1, "-time_max_steps", steps,
            "-output_every", 9, "-output_dir", ".", *more]


def fields(law, *more):
    run = check.must(*block(law, *more), "-dry_run")
    return run.find(r"^fields +((?:[A-Za-z]+ )+) *\d+ B"), [int(run.find(p)) for p in (r"(\d+) B/particle", r"(\d+) with order")]


def sent(dim, *more):
    """Bytes of the messages of a step of a block on 2 processes: {event: bytes}."""
    name = f"log{dim}{len(more)}.csv"
    check.must(*block("neohookean", "-method_update", "musl", "-body_b_velocity", ",".join(["0"] * dim), *more, dim=dim, steps=STEPS), "-log_view", f":{name}:ascii_csv", n=2)
    found = {}
    for row in check.rows(name):
        if row["Stage Name"] == "MPM steps" and row["Rank"]:
            found[row["Event Name"]] = found.get(row["Event Name"], 0) + float(row["Message Length"]) / STEPS
    return found


check.arguments(__doc__, 0)

# ---- The fields of the state, and the bytes with scratch: a number has 8, cell, kind and the depth below a side 4; order
# and rank are 12.
PLAIN, MORE = 8 * (1 + 2 + 2), 4 + 12
load = ["-loads", "l", "-load_l_body", "b", "-load_l_type"]
for law, more, names, numbers, scratch in [
        ("elastic", [], "F", 4, 0),
        ("neohookean", [], "F", 4, 0),
        ("neohookean", SHOWN, "F", 4, 0),
        ("neohookean", ["-method_update", "musl"], "F", 4, 16),
        ("neohookean", ["-method_transfer", "apic"], "F C", 8, 0),
        ("neohookean", ["-method_transfer", "xpic"], "F", 4, 16),
        ("neohookean", ["-acceleration", "0,x"], "F", 4, 32),
        ("neohookean", ["-method_basis", "gimp", "-method_gimp_update", "stretch"], "F", 4, 16),
        ("fluid", [], "J", 1, 0),
        ("fluid", ["-material_m_viscosity", 1], "J tau", 5, 0),
        ("vonmises", [], "F be ep tau", 13, 0),
        ("vonmises", SHOWN, "J be ep tau", 10, 0),
        ("vonmises", [*SHOWN, *load, "traction", "-load_l_value", "1,0"], "F be ep tau", 13, 80),
        ("vonmises", [*SHOWN, *load, "pressure", "-load_l_value", "1"], "F be ep tau", 13, 80),
        ("vonmises", [*SHOWN, "-method_basis", "gimp", "-method_gimp_update", "stretch"], "F be ep tau", 13, 16),
        ("johnsoncook", [], "F be ep theta tau", 14, 0),
        ("johnsoncook", SHOWN, "J be ep theta tau", 11, 0),
        ("druckerprager", SHOWN, "J be vc tau", 10, 0),
        ("druckerprager", ["-output_fields", "F"], "F be vc tau", 13, 0)]:
    got, bytes = fields(law, *more)
    want = f"id x v {names} ", [PLAIN + 8 * numbers, PLAIN + 8 * numbers + scratch + MORE]
    check.that((got, bytes) == want, f"{law} {' '.join(map(str, more))}: {got}{bytes}")

# ---- Everything is carried, and nothing changes.
for name, more in [("bar", []), ("pressure", []), ("taylor", []), *(("mms", ["-method_transfer", transfer]) for transfer in ("apic", "aflip", "afmpm", "xpic"))]:
    needed, every = ([check.must("-options_file", check.scene(name), "-time_max_steps", STEPS, "-output_every", 9, "-output_dir", ".",
                                 "-method_carry", carry, *more) for carry in ("needed", "all")])
    check.that(needed.digest == every.digest is not None, f"{name} {' '.join(more)}: all is carried, digest {every.digest}")
    check.that("F kind J be ep vc theta tau C " in every.out, f"{name}: {every.find('^(fields.*)')}")
# Sand, and beside it a fluid and a solid, in one row of tiles, so that blocks of particles have several laws.
mixed = [*block("druckerprager", *SHOWN, steps=STEPS), "-materials", "m,f,s", "-material_f_model", "fluid", "-material_f_rho", 900,
         "-material_f_K", 1e6, "-material_s_model", "neohookean", "-material_s_rho", 800, "-material_s_E", 1e6, "-material_s_nu", 0.3,
         "-bodies", "b,f,s"]
for body, where in ("f", "0.1,0.3 0.3,0.7"), ("s", "0.7,0.3 0.9,0.7"):
    lower, upper = where.split()
    mixed += [f"-body_{body}_shape", "box", f"-body_{body}_lower", lower, f"-body_{body}_upper", upper, f"-body_{body}_material", body]
alone = check.must(*mixed)
check.that("id x v F kind J be vc tau " in alone.out, f"three laws: {alone.find('^(fields.*)')}")
for n, more in (1, []), (3, []), (3, ["-parallel_strategy", "pool"]):
    found = check.must(*mixed, "-method_carry", "all", *more, n=n).digest
    check.that(found == alone.digest, f"three laws with all fields on {n}{' '.join(['', *more])}: {found}, {alone.digest} without")

# ---- What plastic laws keep in place of F is its determinant; the motion does not depend on it.
for law, dim in ("vonmises", 3), ("johnsoncook", 2), ("druckerprager", 2), ("vonmises", 1):
    states = []
    for shown in "velocity,stress,volume,F", "velocity,stress,volume":
        check.must(*block(law, "-output_fields", shown, "-output_name", law, dim=dim, steps=20))
        with check.h5py.File(f"{law}.h5") as file:
            states.append({key: value[()] for key, value in file["step_000020/particles"].items()})
    F, J = states
    check.that("F" in F and "F" not in J and all(np.array_equal(F[k], J[k]) for k in ("x", "v")), f"{law} in {dim}-D: the same x and v without F")
    ratio = F["volume"] / F["volume"][0]
    check.that(np.ptp(ratio) > 1e-3 and np.allclose(F["volume"], J["volume"], rtol=1e-13, atol=0), f"{law} in {dim}-D: J is det F")
    check.that(np.allclose(F["stress"], J["stress"], rtol=1e-13, atol=0), f"{law} in {dim}-D: the same stress")

# ---- Numbers of a node that are sent, 8 if all are: of P2G mass, momentum and force, of P2G_MOMENTUM momentum; to ghosts
# velocity and acceleration, then velocity alone.
every = sent(2, "-method_carry", "all")
for dim in 1, 2:
    needed = sent(dim)
    tiles = 16  # bytes, one for each tile of the side rounded up to 8; both sides count
    ratio = (needed["P2G"] - tiles) / (needed["P2G_MOMENTUM"] - tiles)
    check.that(abs(ratio - (1 + 2 * dim) / dim) < 1e-9, f"{dim}-D: P2G sends {dim * ratio:.4g} numbers a node, P2G_MOMENTUM {dim}")
for event, numbers, whole in ("P2G", 5, 8), ("P2G_MOMENTUM", 2, 8), ("SFBcastBegin", 6, 8):
    ratio = (needed[event] - tiles * (event[0] == "P")) / (every[event] - tiles * (event[0] == "P"))
    check.that(abs(ratio - numbers / whole) < 1e-9, f"2-D: {event} sends {whole * ratio:.4g} of {whole} numbers a node")
check.end()
