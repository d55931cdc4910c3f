"""The arithmetic of studies, without a run: orders only where three runs agree, a limit with its uncertainty,
differences that do not fall; particles beside those of a finer lattice; the front, the time for an error, what a
setting loses; the ladder of steps; words.

usage: test_lab_units.py PEBBLE SOURCE MPIEXEC"""

import math
import os
import re
import sys

import numpy as np

import check

check.arguments(__doc__, 0)
sys.path.insert(0, os.path.join(check.source, "lab"))
import pebble_mpm as pebble  # noqa: E402 (after the path)
from pebble_study import front, limit, methods, scene, series, stability, trade  # noqa: E402


def near(a, b, tolerance=1e-12):
    return abs(a - b) <= tolerance * max(1, abs(b))


# ---- Orders, limits
def check_power(limit, c, p):
    """q = limit + c 2^(-p k): the order is found, and the limit, at once."""
    q = [limit + c * 2 ** (-p * k) for k in range(8)]
    d = list(np.diff(q))
    pairs = series.orders(d)
    good = pairs[0] is None and all(near(pair, p, 1e-6) for pair in pairs[1:])
    for n in range(1, 8):
        rest = series.rest(d[:n])
        good &= series.agree(pairs[:n]) == (n > 2) and (rest is not None) == (n > 1)
        if rest:
            good &= near(q[n] + rest[0], limit, 1e-6 * abs(c)) and abs(
                rest[1] - (0 if n > 2 else abs(rest[0]))
            ) <= 1e-6 * abs(c)
    check.that(good, f"{limit} + {c} 2^(-{p} k): the order, the limit and its uncertainty")


for numbers in ((0, 1, 2), (1.217, -0.3, 1), (-5, 1e-3, 3.5)):
    check_power(*numbers)
sand = np.diff([0.165, 0.135, 0.103, 0.070, 0.037, 0])  # of errors against the finest run, where dt was halved
pairs = series.orders(sand)
check.that(
    all(
        not series.falls(sand[:n])
        and series.rest(sand[:n]) is None
        and pairs[n - 1] < 0.1
        and not series.agree(pairs[:n])
        for n in range(2, 6)
    ),
    "differences of sand do not fall: no limit, no order",
)
rest = series.rest([1, -0.5, 0.25])
check.that(
    near(rest[0], 2 / 3 - 0.75) and near(rest[1], 0),
    "signs that alternate: 1/3 short of the limit of 1 - 0.5 + 0.25 - ...",
)
rest = series.rest([1, 0.5, 0.05])
check.that(
    not series.agree(series.orders([1, 0.5, 0.05])) and near(rest[0], 0.05 / 9) and near(rest[1], 0.05 - 0.05 / 9),
    "pairs of order 1 and 3.3",
)
check.that(
    series.orders([1, 0]) == [None, None] and series.rest([1, 0]) == (0, 0),
    "a difference of 0 has no order, and leaves nothing",
)
check.that(not series.agree(series.orders([4, 2, 1.5])), "orders 1 and 0.4 do not agree")
check.that(
    series.orders([1, math.inf, 1])[1:] == [None, None] and series.rest([]) is None and series.rest([1]) is None,
    "numbers that are not finite; none",
)
for off, same in ((0.29, True), (0.31, False)):
    check.that(
        series.agree([None, 1.0, 1.0 + off]) == same, f"orders that differ by {off}: {'one' if same else 'no'} order"
    )


# ---- Particles
def body(n, u, b=1.0, shift=0.0, keep=lambda X: np.ones(len(X), bool)):
    """n particles an axis of the unit box times b, with displacements u(X)."""
    axes = [(np.arange(k) + 0.5) / k * b + shift for k in n]
    X = np.stack([axis.ravel(order="F") for axis in np.meshgrid(*axes, indexing="ij")], -1)
    X = X[keep(X)]
    return series.Body(X, u(X))


def cubic(X):
    return np.stack(
        [X[:, 0] ** 3 - 2 * X[:, 0] + sum(X[:, d] ** 2 for d in range(1, X.shape[1])), *X[:, :-1].T * 0.5], -1
    )[:, : X.shape[1]]


free = np.array([np.inf] * 3)
for dim in (1, 2, 3):
    for fine in (2, 3):
        one, other = body([6] * dim, cubic), body([6 * fine] * dim, cubic)
        inside = abs(series.step_to(one, other, free[:dim], 4)[1] - 1) < 1e-9
        sums = series.step_to(one, other, free[:dim], 4)[0]
        check.that(
            inside.sum() >= 4**dim and abs(sums[inside]).max() < 1e-13,
            f"{dim}-D, {fine} times as fine: a cubic is found inside",
        )
one, other = body([4, 4], lambda X: 0 * X), body([8, 8], lambda X: 0 * X + [3e-3, 4e-3])
check.that(
    all(near(a, 5e-3) for a in series.compare([one], [other], free[:2])),
    "a difference of (3, 4) mm everywhere is 5 mm; the size is that of the finer one",
)
heavy = body([4, 4], lambda X: 0 * X)
heavy.m *= 3
difference = series.compare([one, heavy], [other, body([8, 8], lambda X: 0 * X)], free[:2])[0]
check.that(near(difference, 5e-3 / 2), "by mass: a quarter of it is 5 mm off")
some = body([4, 4], lambda X: (X[:, :1] > 0.5) * [3e-3, 4e-3])
some.m[some.X[:, 0] < 0.5] = 3
difference = series.compare([some], [body([8, 8], lambda X: 0 * X)], free[:2])[0]
check.that(near(difference, 5e-3 / 2), "by the masses of the particles: a quarter of the mass is 5 mm off")
beside = body([8, 8], lambda X: X)
moved = 0.04 * np.sin(np.arange(128)).reshape(64, 2)
sums, total = series.step_to(series.Body(beside.X + moved, beside.u, places=beside.X), beside, free[:2], 4)
inside = abs(total - 1) < 1e-9
check.that(
    inside.sum() >= 16 and abs(sums - moved)[inside].max() < 1e-13,
    "particles beside their places of the lattice are compared where they start",
)
one = series.Body(beside.X + moved, beside.u, places=beside.X)
check.that((one.b == 0.125).all() and (one.at == beside.at).all(), "their places are those of the lattice")
disk = lambda X: ((X - 0.5) ** 2).sum(1) < 0.2  # noqa: E731
difference, size = series.compare(
    [body([9, 9], lambda X: 0 * X, keep=disk)], [body([18, 18], lambda X: 0 * X + [3e-3, 4e-3], keep=disk)], free[:2]
)
check.that(near(difference, 5e-3) and near(size, 5e-3), "a disk: to its edge, where neighbours are missing")
around = series.compare([body([4], lambda X: X * 0 + 0.4)], [body([8], lambda X: X * 0 - 0.5)], np.array([1.0]))[0]
check.that(near(around, 0.1), "through a periodic face: 0.1, not 0.9")
check.that(
    near(series.spacing(np.repeat([0.1, 0.35, 0.6, 0.6 + 1e-15], 3)), 0.25)
    and series.spacing(np.array([2.0, 2.0])) == 1,
    "the spacing of a lattice, but for rounding",
)


# ---- Time and error
def run(seconds, error, setting="a", note="", status="ok", most=None):
    return {
        "setting": setting,
        "seconds_min": seconds,
        "seconds_max": most or seconds,
        "error": error,
        "status": status,
        "note": note,
    }


runs = [
    run(1, 0.5),
    run(4, 0.25),
    run(2, 0.5),
    run(2, 0.1),
    run(0.1, 0.01, note="steps too long"),
    run(0.5, math.nan, status="stopped"),
    run(3, 0.1),
]
front.mark(runs)
check.that([one["front"] for one in runs] == [1, 0, 0, 1, 0, 0, 0], f"the front: {[one['front'] for one in runs]}")
front.mark(runs, 0.6)
check.that(
    [one["front"] for one in runs] == [1, 0, 0, 0, 0, 0, 0], "of runs below the floor the fastest is on the front alone"
)
grids = [run(1, 0.4, most=1.1), run(4, 0.1, most=4.8)]
check.that(
    near(front.time_to(grids, 0.2)[0], 2) and near(front.time_to(grids, 0.2)[1], 1.2),
    "the time for half the error lies between, by logarithms; the larger spread counts",
)
check.that(
    near(front.time_to(grids, 0.4)[0], 1)
    and near(front.time_to(grids, 0.5)[0], 1)
    and front.time_to(grids, 0.05) is None,
    "at a grid; before the first; not reached",
)
best = front.fastest([grids, [run(0.5, 0.2, "b", note="steps too long")], [run(1.5, 0.2, "c", most=1.8)]], 0.2)
check.that(best == (1.5, 1.2), f"the fastest setting whose steps are stable: {best}")
check.that(
    np.allclose(front.loss(grids, best, 0.2), (4 / 3, 4 / 3 / 1.2, 4 / 3 * 1.2))
    and front.loss(grids, best, 0.01) is None,
    "what a setting loses, with its spread; it does not reach it",
)
check.that(
    front.cheapest(runs, 0.3)["seconds_min"] == 2 and front.cheapest(runs, 0.01) is None,
    "the cheapest run for an error",
)
check.that(
    [trade.time_words(s) for s in (3.14159, 119, 600, 9000, 1e6)]
    == ["3.14 seconds", "119 seconds", "10 minutes", "2.5 hours", "12 days"],
    "times in words",
)


# ---- Steps
tried = []


def bound(limit):
    return lambda C: tried.append(C) or C <= limit + 1e-12


for last, expected in (
    (0.0, (0.0, 0.05)),
    (0.05, (0.05, 0.1)),
    (0.73, (0.7, 0.75)),
    (0.77, (0.75, 0.8)),
    (1.0, (1.0, 1.1)),
    (1.15, (1.1, 1.2)),
    (2.6, (2.6, None)),
):
    found = stability.search(bound(last))
    check.that(
        all(a == b or near(a, b) for a, b in zip(found, expected)), f"a method that is stable to {last}: {found}"
    )
check.that(max(tried) <= 2.6 + 1e-12, "no C is above 2.6")
count = []
stability.search(lambda C: count.append(C) or round(C, 9) not in (0.3,))
check.that(np.allclose(count, [0.1, 0.2, 0.3, 0.25]), "the first C that is unstable ends the search")

# ---- Limits
for true, start in ((1.4, 1.0), (0.07, 1.0), (1.4, 1.4), (17.0, 1.0), (1.0, 1.0), (0.999, 1.0)):
    asked = []
    low, high = limit.bracket(lambda F: asked.append(F) or F <= true, start, 1.2, 0.01)
    check.that(
        low <= true < high and high - low <= 0.01 * 0.5 * (low + high) and len(asked) == len(set(asked)) <= 16,
        f"a body that bears {true}, from {start}: {low:g} to {high:g} after {len(asked)} runs",
    )
for always, told in ((True, "still holds"), (False, "does not hold")):
    try:
        limit.bracket(lambda F: always, 1.0, 1.2, 0.01)
        check.that(False, "a limit that is not there")
    except limit.NoLimit as none:
        check.that(told in str(none), f"no limit: {none}")
for brackets, low, high, why in (
    ([(1.0, 1.02)], 1.0, 1.02, "one grid"),
    ([(1.2, 1.21), (1.195, 1.205)], 1.165, 1.235, "a third grid"),
    ([(1.39, 1.41), (1.19, 1.21)], 0.59, 1.81, "a third grid"),
    ([(1.79, 1.81), (1.39, 1.41), (1.19, 1.21)], 0.79, 1.61, "Richardson"),
    ([(2.0, 2.0), (1.2, 1.2), (1.19, 1.21)], 1.18, 1.22, "Richardson"),
    ([(1.3, 1.3), (1.2, 1.2), (1.1, 1.1)], 0.8, 1.4, "do not fall"),
    ([(1.2, 1.2), (1.1, 1.1), (1.3, 1.3)], 0.7, 1.9, "do not fall"),
    ([(2.6, 2.6), (1.8, 1.8), (1.4, 1.4), (1.2, 1.2)], 1.0, 1.4, "Richardson"),
):
    found = limit.estimate(brackets)
    check.that(
        near(found[0], low) and near(found[1], high * (1 + limit.EARLY)) and why in found[2],
        f"{len(brackets)} grids: {found[0]:g} to {found[1]:g}, {found[2]}",
    )
check.that(
    np.allclose(limit.softness([0.1, 0.2, 0.25], [1e-3, 1e-3, 1e-2]), [1, 1, 20])
    and len(limit.softness([], [])) == 0
    and np.isnan(limit.softness([1.0], [0.0])).all(),
    "the softness of steps, of no steps, where nothing moves",
)
ends = [
    limit.read_end(times, soft, failed, 20)
    for times, soft, failed in (
        ([0.5, 1.0], [1, 2], None),
        ([0.5, 0.7], [1, 2], 0.8),
        ([0.5, 0.7, 1.0], [1, 30, 5], None),
        ([0.5, 0.7], [1, 21], 0.8),
    )
]
check.that(
    ends == [(1.0, None, 2), (0.7, 0.8, 2), (0.5, 0.7, 1), (0.5, 0.7, 1)] and limit.read_end([], [], 0.1, 20)[:2] == (0.0, 0.1),
    f"a run holds, finds no equilibrium, flows and comes to rest again, flows before that: {ends}",
)
times, steps = [0.1, 0.2, 0.3], [0.01, 0.02, 0.2]
found = [
    limit.slides(*case).tolist()
    for case in (
        (times, steps, limit.softness(times, steps), 5.0),
        (times, steps, limit.softness(times, steps), 10.0),  # not far for its size
        (times, [0.1, 0.2, 0.3], [1, 2, 3], 1.0),  # far, but it hardly yields more than at first
        ([0.5, 1.0, 1.5, 2.0], [0.01, 0.01, 0.3, 0.01], [1, 1, 1, 0.1], 5.0, [1.0, 2.0]),  # as a stage begins
        ([0.5, 1.0, 1.5, 2.0], [0.01, 0.01, 0.05, 0.01], [1, 1, 1, 0.1], 5.0, [1.0, 2.0]),
        ([], [], [], math.inf),
    )
]
check.that(
    found == [[False, False, True], [False] * 3, [False] * 3, [False, False, True, False], [False] * 4, []]
    and limit.read_end([0.5, 0.7, 1.0], [1, 9, 5], None, 20, [False, True, False])[:2] == (0.5, 0.7),
    f"a body slides where it goes far for its size: {found}",
)
far = np.zeros((300, 3))
far[:3, 1] = 1, 2, 3
check.that(
    near(limit.moved(np.zeros((300, 3)), far), 2) and near(limit.moved(far[:5], far[:5] + 1), math.sqrt(3)),
    "the hundredth that moves most, one particle at least",
)
for line in ("no equilibrium was found at t=0.25 s: after 25", "no equilibrium was found near the last one, at t=0.2 s: that at t=0.25 s has displacement"):
    check.that(re.search(limit.FAILED, line)[1] == "0.25", f"where it failed: {line}")
soil = {"materials": "a,b,c", "material_a_model": "vonmises", "material_a_yield": "6", "material_b_model": "druckerprager", "material_b_cohesion": "3"}
soil |= {"material_b_friction_angle": "45", "material_b_dilation_angle": "30", "material_c_model": "elastic"}
weak = limit.weakened(scene.Options(soil), 2.0)
check.that(
    [float(weak[f"material_{name}"]) for name in ("a_yield", "b_cohesion")] == [3, 1.5]
    and near(math.tan(math.radians(float(weak["material_b_friction_angle"]))), 0.5)
    and weak["material_b_dilation_angle"] == weak["material_b_friction_angle"]
    and limit.weakened(scene.Options(soil), 1.5)["material_b_dilation_angle"] == "30",
    "strength divided by 2; dilation is at most friction",
)

# ---- Words, tables
check.that(
    pebble.words(
        {"a": True, "b": (1, 2.5), "c": None, "d": 0.1, "e": np.float64(1) / 3, "f": "x*2", "g": np.array([8, 8])}
    )
    == ["-a", "true", "-b", "1,2.5", "-d", "0.1", "-e", "0.3333333333333333", "-f", "x*2", "-g", "8,8"],
    "values as the program reads them",
)
check.that(
    scene.text_of(math.nan, "g") == scene.text_of(None, "g") == ""
    and scene.text_of(2.0, "d") == "2"
    and scene.text_of(0.1, "r") == "0.1",
    "numbers in tables",
)
defined = check.content(os.path.join(check.source, "src", "step", "transfer.def")).decode()
rows = re.findall(r"^MPM_TRANSFER\((\w+), (-?\d+), \w+, (\w+),", defined, re.M)
check.that(
    {name for name, flip, _ in rows if flip == "-1"} == set(methods.FLIPS)
    and {name for name, _, rounds in rows if rounds != "MPM_NO_ROUNDS"} == set(methods.ORDERS),
    "transfers with -method_flip and with -method_order are those of transfer.def",
)
check.that(
    methods.bounds("bspline2", "usl", "flip") == (0.75, 0.75)
    and methods.bounds("linear", "musl", "flip", 0.99) == (1.4, 0.1)
    and methods.bounds("gimp", "usl", "aflip", strain=0.5) == (0.55, 0.3)
    and methods.bounds("bspline2", "usl", "afmpm") == (0.6, 0.6),
    "bounds are those of stable.def",
)
for text, wrong in (
    ("", "is empty"),
    ("usl,last", "last: choose a list of usf usl"),
    ("usl," * 33, "at most 32 words"),
):
    try:
        methods.read_list("update", text, ["usf", "usl"])
        check.that(False, f"--update {text[:20]} is refused")
    except scene.Refused as refused:
        check.that(wrong in str(refused), f"--update {text[:20]}: {refused}")
step = np.arange(0, 2001, 20)
energy = 1e-3 + np.exp(0.02 * (step - 1000))
rates = [stability.growth(step, e, 10.0) for e in (energy, np.minimum(energy, 1e6), energy[::-1])]
check.that(
    near(rates[0], 20, 1e-2) and near(rates[1], 20, 0.05) and np.isnan(rates[2]),
    f"growth in 1,000 steps: {rates}; the second grows no more in the end, the third falls",
)
check.that(
    [probe.dim for probe in stability.probes(3)] == [3, 1, 3] and [probe.dim for probe in stability.probes(2)] == [1, 1, 2],
    "in 3-D a block is at rest too: its bound is the lowest",
)
check.end()
