"""Messages of a step by formula, for a body that fills its grid and whose points are where they were put, beside what
-log_view counted. Times play no part, so each number must be exact (bytes: to the six digits that are printed)."""
import itertools
import math

import runs

STENCIL = {"linear": 2, "bspline2": 3, "bspline3": 4}  # nodes an axis; with walls none lies beyond the grid


def product(dim, of_cut, of_rest):
    """Sum over the directions to upper neighbours (sides and corners) of the product over axes d of of_cut(d) where
    the direction leaves the box and of_rest(d) where it does not."""
    return sum(math.prod(of_cut(d) if off else of_rest(d) for d, off in enumerate(o))
               for o in itertools.product((0, 1), repeat=dim) if any(o))


def spatial(scene, cells, ppc, grid):
    """Of usl, per step: pairs of neighbours, halo points, ghost nodes; summed over all processes."""
    reach = STENCIL[scene.basis] - 1
    pairs = product(scene.dim, lambda d: grid[d] - 1, lambda d: grid[d])
    per_axis = round(ppc ** (1 / scene.dim))
    halo = product(scene.dim, lambda d: reach * (grid[d] - 1) * per_axis, lambda d: cells[d] * per_axis)
    ghosts = product(scene.dim, lambda d: reach * (grid[d] - 1), lambda d: cells[d] + 1)
    return pairs, halo, ghosts


def rows(scene, run):
    """(what, counted, by formula) of a run of a box that no point crosses cells in."""
    dim, steps, cells = scene.dim, run.steps, scene.cells(scene.strong)
    event = lambda name: run.events.get(name, runs.Event(0, 0, 0, 0))
    if run.strategy == "pool":
        # A patch of 16 nodes an axis is sent, and answered, if it gets a point: for sums to nodes if a stencil reaches
        # it, else if one starts in it.
        patches = lambda last: math.prod(last(c) // 16 + 1 for c in cells)
        yield "messages of P2G a step", event("P2G").messages / steps, 2 * patches(lambda c: c)
        yield ("messages of G2P a step", event("G2P").messages / steps,
               2 * patches(lambda c: c + 1 - STENCIL[scene.basis]))
        return
    pairs, halo, ghosts = spatial(scene, cells, 2 ** dim, run.grid)
    yield "messages of P2G a step", event("P2G").messages / steps, pairs
    yield "messages of ADVANCE a step", event("ADVANCE").messages / steps, pairs
    yield "messages of SETTLE a step", event("SETTLE").messages / steps, pairs
    yield "bytes of P2G a step", event("P2G").bytes / steps, halo * (8 * dim + 8 * dim * dim)
    yield "bytes of SETTLE a step", event("SETTLE").bytes / steps, halo * (8 + 8 * dim)
    yield "bytes of ADVANCE a step", event("ADVANCE").bytes / steps, ghosts * 16 * dim
    yield "reductions a step", event("summary").reductions / steps, 1


def equal(what, counted, formula):
    return abs(counted - formula) <= (2e-5 * formula if what.startswith("bytes") else 0)


def check(args, scene, processes, strategies=("spatial", "pool"), steps=3):
    """Runs a box for a few steps, in which no point crosses a cell; returns rows for counts.csv."""
    model = runs.calibrate(args, scene.name, 2, scene.options())
    result = []
    for strategy in strategies:
        run = runs.Run(args, scene.options(), processes, strategy, "direct", steps, model)
        for what, counted, formula in rows(scene, run):
            result.append(dict(scene=scene.name, dim=scene.dim, basis=scene.basis, update=scene.update,
                               strategy=strategy, processes=processes, grid="x".join(map(str, run.grid)),
                               particles=run.particles, quantity=what, counted=f"{counted:.10g}",
                               formula=f"{formula:.10g}", equal="yes" if equal(what, counted, formula) else "no"))
    return result
