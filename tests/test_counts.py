"""What a run says about itself: memory of a point against the growth of the process, operations and bytes of the phases
against a count by hand.

usage: test_counts.py PEBBLE SOURCE MPIEXEC memory|flops
"""
import csv
import os
import re
import subprocess
import sys

import mpi

MEMORY = 0.10  # largest part by which the memory of a point may differ from what is printed
PRINTED = 0.012  # three digits each of ns per point and of GFlop/s or GB/s
STEPS, CELLS, SIDE = 20, 64, 32  # of the block whose operations are counted: SIDE x SIDE cells, 3 x 3 points each
POINTS = SIDE ** 2 * 9
failures = 0


def check(condition, what):
    global failures
    failures += not condition
    print("ok  " if condition else "FAIL", what, flush=True)


def block(dim, cells, side, ppc, velocity, basis="bspline2", update="usl", steps=3):
    """Options of a block of side^dim cells in a grid of cells^dim, with its faces on lines of the grid."""
    every = lambda value: ",".join([str(value)] * dim)
    first = (cells - side) // 2
    return ["-dim", dim, "-grid_lower", every(0), "-grid_upper", every(1), "-grid_cells", every(cells),
            "-materials", "m", "-material_m_model", "neohookean", "-material_m_rho", 1000, "-material_m_E", 1e6,
            "-material_m_nu", 0.3, "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", every(first / cells),
            "-body_b_upper", every((first + side) / cells), "-body_b_ppc", every(ppc), "-body_b_material", "m",
            "-body_b_velocity", every(velocity), "-method_basis", basis, "-method_update", update,
            "-method_transfer", "flip", "-dt_size", 0.1 / cells / 37, "-time_end", 1e9, "-time_max_steps", steps,
            "-output_format", "none", "-history_every", 1e9, "-output_dir", ".", "-output_name", "run"]


def largest(pebble, arguments):
    """A run's output and the largest memory of its process in bytes."""
    process = subprocess.Popen([pebble, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    out = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{out}\nFAIL: status {status}")
    return out, 1024 * usage.ru_maxrss


def memory(pebble):
    """The same block on the same grid with few and with many points: grid and program drop out of the difference."""
    for dim, cells, side, few, many in (2, 256, 120, 3, 8), (3, 40, 30, 2, 3):
        n, peak = [], []
        for ppc in few, many:
            # Fast enough that the storage is put in order on the way, too.
            out, most = largest(pebble, block(dim, cells, side, ppc, 100, steps=14))
            n.append((side * ppc) ** dim)
            peak.append(most)
        state, told = map(int, re.search(r"(\d+) B/particle, (\d+) with order", out).groups())
        slope = (peak[1] - peak[0]) / (n[1] - n[0])
        check(abs(slope - told) < MEMORY * told,
              f"{dim}-D: {slope:.1f} B a particle at the most, from {n[0]} and {n[1]}; printed {told}, of which state {state}")


# Operations of a point in 2-D, counted by hand from the equations; + - * / are 1 each, a logarithm 26. `basis` has the
# nodes of a stencil per axis (ns) and the operations for its weights and slopes.
WEIGHTS = {"linear": (2, 1), "bspline2": (3, 13)}


def by_hand(basis):
    """{phase: operations of a point}"""
    ns, weights = WEIGHTS[basis]
    nodes = ns * ns
    stencil = 2 * (6 + weights + ns)   # per axis: coordinate, floor, base; weights; slopes by h
    products = ns + 2 * nodes          # of one sum: w_j Q for each row, then a product and a sum for each node
    mass_momentum = 3 * products + 2   # m, m vx, m vy; and m v itself
    stress = (26                       # log J
              + 3                      # J = det F
              + 3 * 3                  # F F^T: 3 parts of 2 products and 1 sum
              + 2 * 2 + 4)             # mu (F F^T - I) + lambda log J I, and its factors
    force = (stress + 4                # V0 tau
             + 2 * (3 * ns + 2 * nodes)  # two forces: rows of both slopes, then as above
             + 2 * 2 * nodes)          # the slope along x has a product of its own
    motion = 4 * 2 * (nodes + ns) + 16  # two velocities, two accelerations; new v and dx: 8 per axis
    gradient = 2 * 2 * (nodes + 2 * ns)  # two velocities by x and y
    update = (4 * 5                    # F + dt L F: 4 parts
              + 2 * 3 + 3 * 3 + 4 + 6)  # J before and after; speed of waves
    commit = 2 * (1 + 6 + 2)           # x + dx; the new cell
    return {
        "P2G": stencil + mass_momentum + force,
        "G2P": stencil + motion + gradient + update + commit,
        "P2G_MASS": stencil + mass_momentum,
        "P2G_FORCE": stencil + force,
        "G2P_STRESS": stencil + gradient + 2 * 2 * nodes + update,  # the rows of velocities are not those of the motion
        "G2P_MOTION": stencil + motion + commit,
    }


# Bytes of a point, read and written: id 8, x 16, v 16, F 32, cell 4; of a node: sums 64, motion 32.
BYTES = {
    "P2G": (16 + 4 + 16 + 32, 2 * 64), "ADVANCE": (0, 64 + 32), "G2P": ((8 + 16 + 4 + 16 + 32) + (16 + 4 + 16 + 32), 32),
    "P2G_MASS": (16 + 4 + 16, 2 * 64), "VELOCITY": (0, 64 + 32), "G2P_STRESS": ((8 + 16 + 4 + 32) + 32, 32),
    "P2G_FORCE": (16 + 4 + 32, 2 * 64), "G2P_MOTION": ((8 + 16 + 4 + 16) + (16 + 4 + 16), 32),
}
PHASES = {"usl": ("P2G", "ADVANCE", "G2P"),
          "usf": ("P2G_MASS", "VELOCITY", "G2P_STRESS", "P2G_FORCE", "ADVANCE", "G2P_MOTION")}


def logged(path):
    """{event: (count, operations of all processes)} of the stage of the steps."""
    found = {}
    with open(path) as file:
        for row in csv.DictReader(file):
            if row["Stage Name"] == "MPM steps":
                before = found.get(row["Event Name"], (0, 0))[1]
                found[row["Event Name"]] = (int(row["Count"]), before + float(row["FLOP"]))
    return found


def flops(pebble, mpiexec):
    """A block at rest, so that its nodes are known: log_view's operations, and the line of the speed."""
    for basis, update in ("linear", "usl"), ("bspline2", "usl"), ("linear", "usf"):
        nodes = (SIDE + 1 if basis == "linear" else SIDE + 3) ** 2  # that points touch
        hand = by_hand(basis)
        hand_total = hand_bytes = 0
        for n in 1, 2:
            status, out, err = mpi.run(n, [pebble, *block(2, CELLS, SIDE, 3, 0, basis, update, STEPS), "-log_view", ":log.csv:ascii_csv"], mpiexec=mpiexec)
            if status:
                sys.exit(f"{out}{err}\nFAIL: status {status}")
            events = logged("log.csv")
            for phase in PHASES[update]:
                count, got = events[phase]
                if phase in hand:
                    right = POINTS * STEPS * hand[phase]
                elif n == 1:
                    right = nodes * STEPS * 2 * (5 if phase == "ADVANCE" else 1)  # f/m + g, v + dt a; p/m
                else:
                    continue  # both processes visit the nodes beside the cut
                check(count == STEPS and abs(got - right) < 1e-5 * right,
                      f"{basis} {update} on {n}: {phase} {got:.0f} operations in {count} steps, by hand {right}")
                if n == 1:
                    hand_total += right
                    hand_bytes += STEPS * (POINTS * BYTES[phase][0] + nodes * BYTES[phase][1])
            if n == 1:
                ns, gflops, gbytes = map(float, re.search(r"^speed +([\d.e+-]+) ns.*, ([\d.e+-]+) GFlop/s, ([\d.e+-]+) GB/s", out, re.M).groups())
                for name, got, right in ("operations", gflops, hand_total), ("bytes", gbytes, hand_bytes):
                    got *= ns * POINTS * STEPS
                    check(abs(got - right) < PRINTED * right, f"{basis} {update}: speed line {got:.4g} {name}, by hand {right}")


if sys.argv[4] == "memory":
    memory(sys.argv[1])
else:
    flops(sys.argv[1], sys.argv[3])
print(f"{failures} failed")
sys.exit(failures != 0)
