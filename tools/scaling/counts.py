"""Compares the messages of a step by formula, for a body that fills its grid and whose particles are where they were put, with what
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


def ghosts(scene, cells, grid):
    """Nodes above the boxes of processes, summed over all."""
    reach = STENCIL[scene.basis] - 1
    return product(scene.dim, lambda d: reach * (grid[d] - 1), lambda d: cells[d] + 1)


def parts(cells, count, reach):
    """Cuts an axis evenly at multiples of a tile's edge. Yields for each part the widths of its tiles, and how many of them have
    particles."""
    edge = 2 * reach if reach < 2 else 4
    bins = (cells + 1) // edge
    cuts = [edge * (bins * k // count) for k in range(count)] + [cells + 1]
    for a, b in zip(cuts, cuts[1:]):
        widths = [min(edge, b - at) for at in range(a, b, edge)]
        yield widths, sum(at + a <= cells - reach for at in range(0, b - a, edge))


def sums(scene, cells, grid, numbers, room):
    """Bytes of the sums of tiles that processes send, all together: a byte for each tile of the side, rounded up to words of 8, then
    `numbers` sums for each node that the receiver owns of tiles with particles. With `room` all tiles of the side count, since
    the receiver makes room for all."""
    reach, total = STENCIL[scene.basis] - 1, 0
    axes = [list(parts(c, p, reach)) for c, p in zip(cells, grid)]
    for where in itertools.product(*(range(p) for p in grid)):
        for toward in itertools.product((0, 1), repeat=scene.dim):
            if not any(toward) or any(o and k + 1 == p for o, k, p in zip(toward, where, grid)):
                continue
            tiles, nodes = 1, 1
            for axis, o, k in zip(axes, toward, where):
                widths, full = axis[k]
                own = sum(widths)
                tiles *= 1 if o else len(widths)
                nodes *= reach if o else sum(min(w + reach, own - widths[0] * n) for n, w in enumerate(widths[:None if room else full]))
            total += (tiles + 7) // 8 * 8 + nodes * numbers * 8
    return total


def rows(scene, run):
    """(what, counted, by formula) of a run of a box in which no particle crosses a cell."""
    dim, steps, cells = scene.dim, run.steps, scene.cells(scene.strong)
    event = lambda name: run.events.get(name, runs.Event(0, 0, 0, 0))
    if run.strategy == "pool":
        # A patch of 16 nodes an axis is sent, and answered, if the stencil of a particle can start in it.
        patches = math.prod((c + 1 - STENCIL[scene.basis]) // 16 + 1 for c in cells)
        yield "messages of P2G a step", event("P2G").messages / steps, 2 * patches
        yield "messages of G2P a step", event("G2P").messages / steps, 2 * patches
        return
    pairs = product(dim, lambda d: run.grid[d] - 1, lambda d: run.grid[d])
    yield "messages of P2G a step", event("P2G").messages / steps, pairs
    yield "messages of ADVANCE a step", event("ADVANCE").messages / steps, pairs
    yield "messages of SETTLE a step", event("SETTLE").messages / steps, 0
    # PETSc counts a receive by the room that was made for it.
    yield ("bytes of P2G a step", event("P2G").bytes / steps,
           sum(sums(scene, cells, run.grid, 1 + 2 * dim, room) for room in (False, True)) / 2)
    yield "bytes of ADVANCE a step", event("ADVANCE").bytes / steps, ghosts(scene, cells, run.grid) * 16 * dim
    yield "reductions a step", event("summary").reductions / steps, 1


def equal(what, counted, formula):
    return abs(counted - formula) <= (2e-5 * formula if what.startswith("bytes") else 0)


def check(args, scene, processes, strategies=("spatial", "pool"), steps=3):
    """Runs a box for a few steps, in which no particle crosses a cell; returns rows for counts.csv."""
    result = []
    for strategy in strategies:
        run = runs.Run(args, scene.options(), processes, strategy, "direct", steps, None)
        for what, counted, formula in rows(scene, run):
            result.append(dict(scene=scene.name, dim=scene.dim, basis=scene.basis, update=scene.update,
                               strategy=strategy, processes=processes, grid="x".join(map(str, run.grid)),
                               particles=run.particles, quantity=what, counted=f"{counted:.10g}",
                               formula=f"{formula:.10g}", equal="yes" if equal(what, counted, formula) else "no"))
    return result
