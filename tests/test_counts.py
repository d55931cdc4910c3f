"""What a run says about itself: memory of a particle against the growth of the process, operations and bytes of the
phases against a count by hand.

usage: test_counts.py PEBBLE SOURCE MPIEXEC memory|flops
"""
import os
import re
import subprocess

import check
import launch
import mpi

MEMORY = 0.10  # largest part by which the memory of a particle may differ from what is printed
PRINTED = 0.012  # three digits each of ns per particle and of GFlop/s or GB/s
STEPS, BLOCK = 10, {2: (64, 32), 3: (20, 10)}  # whose operations are counted: cells a side of grid and block


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
            "-output_format", "none", "-report_indicator", "false", "-report_limits", "false",  # which take memory
            "-history_every", 1e9, "-output_dir", ".", "-output_name", "run"]


def largest(arguments):
    """A run's output and the largest memory of its process in bytes."""
    with launch.own_folder() as environment:
        process = subprocess.Popen([check.program, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
        out = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
    check.need(status == 0, f"status {status}: {out}")
    return mpi.keep(out)[0], 1024 * usage.ru_maxrss


def memory():
    """The same block on the same grid with few and with many particles: grid and program drop out of the difference."""
    for dim, cells, side, few, many in (2, 256, 120, 3, 8), (3, 40, 30, 2, 3):
        n, peak = [], []
        for ppc in few, many:
            # Fast enough that the storage is put in order on the way, too.
            out, most = largest(block(dim, cells, side, ppc, 100, steps=14))
            n.append((side * ppc) ** dim)
            peak.append(most)
        state, told = map(int, re.search(r"(\d+) B/particle, (\d+) with order", out).groups())
        slope = (peak[1] - peak[0]) / (n[1] - n[0])
        check.that(abs(slope - told) < MEMORY * told,
              f"{dim}-D: {slope:.1f} B a particle at the most, from {n[0]} and {n[1]}; printed {told}, of which state {state}")


# Operations of a particle, counted by hand from the equations: + - * / are 1 each, so a term of a sum is 2; a
# logarithm is 26.
# `basis`: the nodes of a stencil per axis, and the operations per axis of base, weights and slopes.
WEIGHTS = {
    "linear": (2, 1),           # 1 - s
    "bspline2": (3, 2           # base: floor(xi + 1/2) - 1
                 + 2 + 8 + 3),  # s; 1/2 (1/2 -+ s)^2, 3/4 - s^2; their slopes, 1/2 - s once more
    "bspline3": (4, 1           # base: floor(xi) - 1
                 + 2 + 1 + 4    # s, r = 1 - s; their squares and cubes
                 + 2 * 1 + 2 * 3   # s^3/6, r^3/6; 2/3 - s^2 + s^3/2, and of r
                 + 2 * 1 + 2 * 3),  # s^2/2, r^2/2; (3/2 s - 2) s, and of r
    "gimp": (3, 1               # base: floor(xi - l)
             + 2 + 1 + 2        # distances from the other two nodes; 1/(2 l); 1 - l, 1 + l
             # Every piece is formed for all particles. Both outer nodes: 1 - |s|; u = 1 + l - |s|; 1/2 u u/(2 l); slope u/(2 l).
             + 2 * (1 + 1 + 3 + 1)
             + 5 + 1 + 2),      # the middle one: 1 - (s s + l l)/(2 l); 1 - |s|; slope -2 s/(2 l)
}
EXTRA = {"linear": 1, "bspline2": 3, "bspline3": 3, "gimp": 2}  # nodes a side that a block of so many cells touches, more than cells


def by_hand(d, basis):
    """{phase: operations of a particle}, in d dimensions. Sums over a stencil are done by axes: what has no i is multiplied
    before the nodes of a row are visited (`rows`), what has neither i nor j before the rows of a plane (`planes`)."""
    ns, weights = WEIGHTS[basis]
    planes, rows, nodes = (0 if d == 2 else ns), ns ** (d - 1), ns ** d
    pairs = d * (d + 1) // 2              # entries of a symmetric tensor
    stencil = d * (6 + weights + ns)      # per axis: (x - lower)/h; xi - base; number of the cell; weights; slopes by h
    to_nodes = planes + rows + 2 * nodes  # of one sum: w_k Q for each plane, w_j w_k Q for each row, then a term a node
    momentum = d * to_nodes + d           # and m v itself
    determinant = {2: 3, 3: 3 * 3 + 5}[d]  # 3-D: three minors, three products and two sums of them
    cauchy_green = pairs * (2 * d - 1)    # F F^T: d products, d - 1 sums each
    stress = (26 + determinant + cauchy_green
              + 1 + pairs + 2 * d)        # lambda log J; mu (b - I) + lambda log J I: a product, on the diagonal two sums more
    # One force sum_e tau_e dphi/de: 3-D for each plane w_k tau_x, w_k tau_y and the term g_k tau_z; for each row w_j of these
    # two and the term g_j tau_y; at each node two terms. 2-D: two sums, each with a product for each row and a term a node.
    one_force = {2: 2 * rows + 4 * nodes, 3: 4 * planes + 4 * rows + 4 * nodes}[d]
    force = stress + {2: 3, 3: 9}[d] + d * one_force  # V0 tau, in 2-D of each entry once
    # One interpolated value: a term for each node, row, plane. Its gradient: the sums of a row with slopes along x; of a plane
    # both, and along y; then all three.
    value = 2 * (nodes + rows + planes)
    gradient = d * {2: 2 * (nodes + 2 * rows), 3: 2 * (nodes + 2 * rows + 3 * planes)}[d]
    alone = d * {2: 2 * nodes, 3: 2 * (nodes + rows)}[d]  # its sums with weights, if not there for the motion anyway
    motion = 2 * d * value + 8 * d        # velocities, accelerations; new v, its square, and dx
    update = (d * d * (2 * d + 1)         # F + dt L F
              + 2 * determinant           # J for the check, and for the speed
              + cauchy_green + d * d + 6)  # speed of waves: row sums of b; (mu b + mu + lambda/J)/rho
    commit = d * (1 + 3)                  # x + dx; the distance from the middle of the cell: dx/h, two sums
    return {
        "P2G": stencil + to_nodes + momentum + force,
        "P2G_MASS": stencil + to_nodes + momentum,
        "P2G_MOMENTUM": stencil + momentum,
        "P2G_FORCE": stencil + force,
        "G2P": stencil + motion + gradient + update + commit,
        "G2P_MOTION": stencil + motion + commit,
        "G2P_MOTION, held": stencil + motion,
        "G2P_STRESS": stencil + gradient + alone + update,
        "G2P_STRESS, commits": stencil + gradient + alone + update + commit,
    }


# Phases of a step: the count above, fields of a particle read and written, numbers of a node read and written (sums 8,
# motion 2 d).
PHASES = {
    "usl": [("P2G", "x cell v F", 2 * 8, 0), ("ADVANCE", "", 8, 1), ("G2P", "id x cell v F, x cell v F", 0, 1)],
    "usf": [("P2G_MASS", "x cell v", 2 * 8, 0), ("VELOCITY", "", 8, 1), ("G2P_STRESS", "id x cell F, F", 0, 1),
            ("P2G_FORCE", "x cell F", 2 * 8, 0), ("ADVANCE", "", 8, 1), ("G2P_MOTION", "id x cell v, x cell v", 0, 1)],
    "musl": [("P2G", "x cell v F", 2 * 8, 0), ("ADVANCE", "", 8, 1), ("G2P_MOTION, held", "x cell v, v dx", 0, 1),
             ("P2G_MOMENTUM", "x cell v", 2 * 8, 0), ("VELOCITY", "", 8, 1),
             ("G2P_STRESS, commits", "id x cell F dx, x cell F", 0, 1)],
}
# Dimension, basis, update: all updates, all bases in 2-D, and in 3-D but gimp.
CASES = [(2, "linear", "usl"), (2, "linear", "usf"), (2, "bspline2", "usl"), (2, "bspline3", "usf"), (2, "bspline2", "musl"),
         (2, "gimp", "usl"), (2, "gimp", "usf"), (3, "linear", "usl"), (3, "bspline2", "usl"), (3, "bspline2", "usf"),
         (3, "bspline3", "usl")]


def field_bytes(d, fields):
    size = {"id": 8, "x": 8 * d, "v": 8 * d, "F": 8 * d * d, "dx": 8 * d, "cell": 4}
    return sum(size[name] for name in fields.replace(",", " ").split())


def logged(path):
    """{event: (count, operations of all processes)} of the stage of the steps."""
    found = {}
    for row in check.rows(path):
        if row["Stage Name"] == "MPM steps":
            before = found.get(row["Event Name"], (0, 0))[1]
            found[row["Event Name"]] = (int(row["Count"]), before + float(row["FLOP"]))
    return found


def flops():
    """A block at rest, so that its nodes are known: log_view's operations, and the line of the speed."""
    for dim, basis, update in CASES:
        cells, side = BLOCK[dim]
        # With two particles a cell on an axis a domain of gimp ends on lines of the grid without rounding.
        ppc, more = (2, ["-method_gimp_update", "none"]) if basis == "gimp" else (3, [])
        particles, nodes = (ppc * side) ** dim, (side + EXTRA[basis]) ** dim
        hand, what = by_hand(dim, basis), f"{dim}-D {basis} {update}"
        hand_total = hand_bytes = 0
        for n in 1, 2:
            options = block(dim, cells, side, ppc, 0, basis, update, STEPS) + more
            out = check.must(*options, "-log_view", ":log.csv:ascii_csv", n=n).out
            events = logged("log.csv")
            for phase, fields, sums, motions in PHASES[update]:
                count, got = events[phase.split(",")[0]]
                if phase in hand:
                    right = particles * STEPS * hand[phase]
                elif n == 1:
                    right = nodes * STEPS * dim * (5 if phase == "ADVANCE" else 1)  # f/m + g, p/m + dt a; p/m
                else:
                    continue  # both processes visit the nodes beside the cut
                check.that(count == STEPS and abs(got - right) < 1e-5 * right,
                      f"{what} on {n}: {phase} {got:.0f} operations in {count} steps, by hand {right}")
                if n == 1:
                    hand_total += right
                    hand_bytes += STEPS * (particles * field_bytes(dim, fields) + nodes * 8 * (sums + motions * 2 * dim))
            if n == 1:
                ns, gflops, gbytes = map(float, re.search(r"^speed +([\d.e+-]+) ns.*, ([\d.e+-]+) GFlop/s, ([\d.e+-]+) GB/s", out, re.M).groups())
                for name, got, right in ("operations", gflops, hand_total), ("bytes", gbytes, hand_bytes):
                    got *= ns * particles * STEPS
                    check.that(abs(got - right) < PRINTED * right, f"{what}: speed line {got:.4g} {name}, by hand {right}")


(part,) = check.arguments(__doc__, 1)
{"memory": memory, "flops": flops}[part]()
check.end()
