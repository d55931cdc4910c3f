"""Every method of -method_*: each basis with each update and transfer runs in 1-D, 2-D and 3-D, with the same digest on
one process, on three and in a pool of three; so do all walls, materials, numbers of particles per cell and particles
exactly on nodes, faces and walls. A free body keeps its momentum. What does not go together is refused.

usage: test_methods.py PEBBLE SOURCE MPIEXEC some|all

some: fewer combinations, in which every basis, transfer, update, wall, material and way to place particles occurs, alone
and in parallel. all: every combination.
"""
import itertools
import re

import numpy as np

import check

MATERIALS = {
    "neohookean": "-model neohookean -rho 1000 -E 1e4 -nu 0.3",
    "elastic": "-model elastic -rho 1000 -E 1e4 -nu 0.3",
    "tait": "-model fluid -rho 1000 -K 1e4",
    "water": "-model fluid -rho 1000 -K 1e4 -eos linear -tension_cutoff 0",
    "honey": "-model fluid -rho 1000 -K 1e4 -viscosity 5",
    "vonmises": "-model vonmises -rho 1000 -E 1e4 -nu 0.3 -yield 50 -hardening 100",
    "johnsoncook": "-model johnsoncook -rho 1000 -G 4e3 -c0 3 -hugoniot_slope 1.4 -gruneisen 1.5 -yield 30 -hardening 60 -hardening_power 0.4 -rate_factor 0.02 -melting 900 -specific_heat 1e-2",
    "druckerprager": "-model druckerprager -rho 1000 -E 1e4 -nu 0.3 -friction_angle 30 -cohesion 10",
}
BASES = {
    "linear": "-method_basis linear", "gimp": "-method_basis gimp -method_gimp_update none", "cpgimp": "-method_basis gimp -method_gimp_update stretch",
    "bspline2": "-method_basis bspline2", "bspline3": "-method_basis bspline3",
    "steffen2": "-method_basis bspline2 -method_wall_basis steffen", "steffen3": "-method_basis bspline3 -method_wall_basis steffen",
}
TRANSFERS = {"flip": "-method_transfer flip -method_flip 0.95", "pic": "-method_transfer pic", "apic": "-method_transfer apic",
             "aflip": "-method_transfer aflip -method_affine_strain 0.5 -method_damping_rate 0.2", "xpic": "-method_transfer xpic -method_order 3",
             "afmpm": "-method_transfer afmpm -method_order 3"}
UPDATES = ("usf", "usl", "musl")
WALLS = {"free": "", "fixed": "", "slip": "", "separate": "", "friction": "_mu 0.3", "moving": "_velocity", "piston": "_velocity"}
VELOCITY = {1: "0.3+0.2*sin(2*pi*x)", 2: "0.3-0.5*(y-0.5)+0.2*sin(2*pi*x), -0.2+0.5*(x-0.5)",
            3: "0.3-0.5*(y-0.5)+0.2*sin(2*pi*z), -0.2+0.5*(x-0.5), 0.1+0.3*(x-0.5)"}
CELLS = {1: 12, 2: 12, 3: 12}  # three processes need a tile of 4 nodes each
FACES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")

(extent,) = check.arguments(__doc__, 1)
FULL = {"some": False, "all": True}[extent]
runs = compared = 0


def turn(k, n):
    """All, or every n-th of what is counted by k."""
    return FULL or k % n == 0


def seldom(basis, transfer):
    """afmpm is apic and phases of xpic: two bases are enough for some."""
    return not FULL and transfer == "afmpm" and basis not in ("cpgimp", "bspline2")


def every(value, dim):
    return ",".join([str(value)] * dim)


def scene(dim, materials=("neohookean", "tait"), lower=0.3, upper=0.7, ppc=2, offset=0.0, velocity=None, faces="", steps=8, extra="", cells=None):
    """An options file: a block of one or two materials side by side. Returns arguments."""
    names = [f"b{k}" for k in range(len(materials))]
    middle = round(0.5 * (lower + upper), 6)
    lines = [f"-dim {dim}", f"-grid_lower {every(0, dim)}", f"-grid_upper {every(1, dim)}", f"-grid_cells {every(cells or CELLS[dim], dim)}",
             "-materials " + ",".join("m" + name for name in names), "-bodies " + ",".join(names), f"-time_max_steps {steps}",
             "-time_end 1e3", "-dt_size 0.005", "-history_every 0", "-output_every 1e9"]
    for k, (name, material) in enumerate(zip(names, materials)):
        lines += [f"-material_m{name}_" + option for option in MATERIALS[material].lstrip("-").split(" -")]
        lo, hi = [lower] * dim, [upper] * dim
        if len(names) > 1:
            (hi if k == 0 else lo)[0] = middle
        lines += [f"-body_{name}_{option}" for option in ("shape box", "lower " + ",".join(map(str, lo)), "upper " + ",".join(map(str, hi)),
                  f"ppc {every(ppc, dim)}", f"offset {every(offset, dim)}", f"material m{name}", f'velocity "{velocity or VELOCITY[dim]}"')]
    return ["-options_file", check.write(f"scene{runs}.opts", lines + [faces, extra])]


def walls(dim, types):
    """Options of faces: one type for all, or one a face."""
    lines = []
    for k, face in enumerate(FACES[:2 * dim]):
        kind = types if isinstance(types, str) else types[k % len(types)]
        lines.append(f"-bc_{face}_type {kind}")
        if kind == "friction":
            lines.append(f"-bc_{face}_mu 0.3")
        if kind == "piston":
            lines.append(f"-bc_{face}_velocity 0")
        if kind == "moving":
            lines.append(f"-bc_{face}_velocity " + ",".join("0.1" if d == (k // 2 + 1) % dim and dim > 1 else "0" for d in range(dim)))
    return "\n".join(lines)


def run(n, arguments, *more, name="run"):
    global runs
    runs += 1
    return check.pebble(*arguments, *more, "-output_dir", ".", "-output_name", name, n=n)


def same(what, arguments, method, parallel=True, status=0, strategies=("spatial", "pool")):
    """Runs; on three processes and in a pool of three the same (some: on one of these, by turns)."""
    global compared
    words = method.split()
    if parallel and not FULL:
        compared += 1
        strategies = strategies[compared % len(strategies):][:1]
    first = run(1, arguments, *words)
    if not check.that(first.status == status and (status or first.digest), f"{what}: exit status {first.status}, digest {first.digest}"):
        print(" ".join(arguments + words), first.out[-600:], first.err[-600:], sep="\n")
        return
    for strategy in strategies if parallel else ():
        other = run(3, arguments, *words, "-parallel_strategy", strategy, *(["-pool_cells", "3"] if strategy == "pool" else []))
        equal = (other.status, other.digest) == (first.status, first.digest)
        if not check.that(equal, f"{what}: {strategy} on 3: exit status {other.status}, digest {other.digest}"):
            print(" ".join(arguments + words), other.out[-600:], other.err[-600:], sep="\n")


def momentum(arguments, method):
    """Largest change of the momentum over sum m|v| of the start."""
    told = run(1, arguments, *method.split(), name="flight")
    if told.status:
        print(told.out[-500:], told.err[-500:])
        return np.inf
    rows = check.rows("flight.csv")
    p = np.array([[float(row[key]) for key in row if key.startswith("momentum_")] for row in rows])
    return np.abs(p - p[0]).max() / (float(rows[0]["mass"]) * 0.5)


def check_methods():
    """Every basis x update x transfer; a third of them, in which each pair occurs, in parallel (some: only this third)."""
    for (b, basis), (t, transfer), (u, update) in itertools.product(enumerate(BASES), enumerate(TRANSFERS), enumerate(UPDATES)):
        method = f"{BASES[basis]} {TRANSFERS[transfer]} -method_update {update}"
        pair = (2 * b + t + u) % 3 == 0
        if not (FULL or pair) or seldom(basis, transfer):
            continue
        materials = ("neohookean", "elastic") if basis == "cpgimp" else ("neohookean", "honey")
        same(f"2-D {basis} {transfer} {update}", scene(2, materials, offset=0.013), method, parallel=pair)
        if pair and turn(b + t, 3):
            same(f"1-D {basis} {transfer} {update}", scene(1, materials, offset=0.013), method, parallel=(3 * t + u) % 4 == 0)
            same(f"3-D {basis} {transfer} {update}", scene(3, materials, steps=4), method, parallel=(3 * t + u) % 4 == 1)


def check_periodic():
    """Through periodic faces on one axis and on all; bodies that lie across the face."""
    for b, ((basis, method), transfer) in enumerate(zip(BASES.items(), itertools.cycle(TRANSFERS))):
        materials = ("neohookean", "elastic") if basis == "cpgimp" else ("neohookean", "tait")
        for k, (dim, faces) in enumerate(((2, walls(2, "periodic")), (2, walls(2, ("periodic", "periodic", "fixed", "slip"))), (3, walls(3, ("periodic", "periodic", "slip", "separate", "periodic", "periodic"))), (1, walls(1, "periodic")))):
            if not turn(b + k, 2):
                continue
            # closed in on all sides, so that nothing leaves
            where = dict(lower=0.05, upper=0.95, offset=0.004, velocity=",".join(["0.7", "0.02*sin(2*pi*x)", "-0.4"][:dim]), faces=faces, steps=15)
            same(f"periodic {dim}-D {basis} {transfer}" + (", walls too" if "fixed" in faces or "slip" in faces else ""),
                 scene(dim, materials, **where), f"{method} {TRANSFERS[transfer]}")
            if dim == 2 and "fixed" not in faces:
                change = momentum(scene(dim, materials, **where), f"{method} {TRANSFERS[transfer]}")
                check.that(change < 1e-12, f"periodic {dim}-D {basis} {transfer}: momentum changes by {change:.1e}")


def check_walls():
    for w, kind in enumerate(WALLS):
        for b, ((basis, method), transfer) in enumerate(zip(BASES.items(), itertools.cycle(TRANSFERS))):
            if not turn(w + b, 4):
                continue
            open_ = kind == "free"
            place = dict(lower=0.3, upper=0.7) if open_ else dict(lower=0.0, upper=1.0)
            arguments = scene(2, ("neohookean",), **place, velocity="0.2*sin(2*pi*x), -0.2*sin(2*pi*y)", faces=walls(2, kind), extra="-gravity 0,-1")
            same(f"walls {kind} {basis} {transfer}", arguments, f"{method} {TRANSFERS[transfer]}", parallel=transfer != "pic")
    arguments = scene(3, ("neohookean",), lower=0.0, upper=1.0, velocity="0.2*sin(2*pi*x), -0.2*sin(2*pi*y), 0.1", steps=4,
                      faces=walls(3, ("fixed", "slip", "friction", "separate", "moving", "slip")))
    for b, (basis, method) in enumerate(BASES.items()):
        if turn(b, 3):
            same(f"walls of all kinds in 3-D {basis}", arguments, method, parallel=basis in ("linear", "gimp", "bspline2", "bspline3", "steffen2", "steffen3"))


def check_materials():
    for m, material in enumerate(MATERIALS):
        for dim in (1, 2, 3):
            if turn(m + dim, 2):
                same(f"material {material} {dim}-D", scene(dim, (material, "neohookean"), faces=walls(dim, "slip"), lower=0.0, upper=1.0, steps=6), "", parallel=dim > 1)
        for update, transfer in (("usf", "apic"), ("usl", "flip")):
            same(f"material {material} {update} {transfer}", scene(2, (material,)), f"-method_update {update} {TRANSFERS[transfer]}", parallel=False)
            change = momentum(scene(2, (material,)), f"-method_update {update} {TRANSFERS[transfer]}")
            check.that(change < 1e-13, f"material {material} {update} {transfer}: momentum changes by {change:.1e}")


def check_particles():
    """1 to 64 particles per cell and axis; particles on nodes, faces and walls. With b = h/ppc, an offset of b/2 puts
    particles on every grid line."""
    for b, (basis, method) in enumerate(BASES.items()):
        for k, (ppc, where) in enumerate(itertools.product((1, 2, 3, 8), ("as they are", "on lines"))):
            if turn(b + k, 3) and (ppc, basis) != (1, "cpgimp"):  # refused
                h = 1.0 / 12
                offset = 0 if where == "as they are" else h / ppc / 2
                arguments = scene(2, ("neohookean",), lower=0.25, upper=0.75, ppc=ppc, offset=offset, cells=12, steps=5, velocity="0.1, 0.05")
                same(f"{ppc} particles per cell, {where}, {basis}", arguments, method, parallel=ppc in (1, 3) and basis != "steffen3")
        if not turn(b, 2):
            continue
        arguments = scene(2, ("neohookean",), lower=0.0, upper=1.01, ppc=2, offset=0.25 / 12, cells=12, steps=5, velocity="0*x, 0*x", faces=walls(2, "slip"))
        same(f"particles on walls, {basis}", arguments, method + " -method_rim whole")
        x = check.particles("run.h5")["x"]
        check.that(x.min() == 0 and x.max() == 1, f"particles on walls, {basis}: they lie from {x.min()} to {x.max()}")
        same(f"64 particles per cell, 1-D, {basis}", scene(1, ("neohookean",), ppc=64), method)


def check_flight():
    for (b, basis), (t, transfer), (u, update) in itertools.product(enumerate(BASES), enumerate(TRANSFERS), enumerate(UPDATES)):
        if not turn(2 * b + t + u, 3) or seldom(basis, transfer) or (basis == "linear" and transfer in ("aflip", "afmpm")):
            continue  # with hats these are unstable, and warned of
        method = BASES[basis]
        change = momentum(scene(2, ("neohookean", "elastic"), offset=0.013, steps=30), f"{method} {TRANSFERS[transfer]} -method_update {update}")
        limit = 1e-12 if transfer in ("apic", "xpic", "pic", "afmpm") else 1e-13
        check.that(change < limit, f"flight {basis} {transfer} {update}: momentum changes by {change:.1e} of m|v|")


def refused(arguments, status, pattern):
    told = run(1, arguments)
    check.that(told.status == status and re.search(pattern, told.said), f"refused with {status}: {pattern}: {told.status}, {(told.err or told.out).strip().splitlines()[-1:]}")


def check_refusals():
    for basis in ("linear", "gimp"):
        refused(scene(2, extra=f"-method_basis {basis}\n-method_wall_basis steffen"), 2, f"(?:^|: )-method_wall_basis does not apply: .* -method_basis is {basis}")
    for transfer in ("flip", "pic", "apic"):
        refused(scene(2, extra=f"-method_transfer {transfer}\n-method_order 3"), 2, "(?:^|: )-method_order does not apply")
    for transfer in ("pic", "apic", "xpic", "afmpm"):
        refused(scene(2, extra=f"-method_transfer {transfer}\n-method_flip 0.5"), 2, "(?:^|: )-method_flip does not apply")
    refused(scene(2, extra="-method_basis bspline2\n-method_gimp_update stretch"), 2, "(?:^|: )-method_gimp_update does not apply")
    refused(scene(2, extra="-method_basis gimp\n-method_gimp_update stretch"), 2, "(?:^|: )-method_gimp_update stretch does not apply: material mb1 .* no deformation gradient")
    refused(scene(2, extra="-method_transfer xpic\n-method_order 17"), 2, "method_order")
    for basis, least in (("bspline2", 3), ("bspline3", 4)):
        refused(scene(2, cells=least - 1, extra=f"-method_basis {basis}"), 2, f"(?:^|: )-grid_cells: {least - 1} on axis x are too few .* {basis}")
        same(f"{least} cells, {basis}", scene(2, cells=least, extra=f"-method_basis {basis}"), "", strategies=("pool",))  # too few to cut
    for basis, least in (("gimp", 3), ("bspline2", 3), ("bspline3", 4)):
        refused(scene(2, cells=least - 1, faces=walls(2, "periodic"), extra=f"-method_basis {basis}"), 2, "(?:^|: )-grid_cells: .* too few")
        same(f"{least} periodic cells, {basis}", scene(2, cells=least, faces=walls(2, "periodic"), extra=f"-method_basis {basis}"), "", strategies=("pool",))
    same("1 cell, linear", scene(2, cells=1, lower=0.0, upper=1.0, velocity="0*x, 0*x", extra="-method_basis linear"), "", parallel=False)
    same("1 cell, gimp", scene(2, cells=1, lower=0.0, upper=1.0, velocity="0*x, 0*x", extra="-method_basis gimp"), "", parallel=False)
    # stretched apart: half-width 1/2 is the limit, which a domain of a whole cell has at the start
    refused(scene(2, ("neohookean",), ppc=1, extra="-method_basis gimp\n-method_gimp_update stretch"), 2, "(?:^|: )-body_b0_ppc 1 does not apply: .* choose 2 or more")
    pull = dict(velocity="20*(x-0.5), 0*y", steps=50)
    refused(scene(2, ("neohookean",), **pull, extra="-method_basis gimp\n-method_gimp_update stretch"), 3, r"the domain of particle \d+ of \w+ at \(.*\) is stretched to 1\.\d+ cells, gimp allows 1 at most; .*; use a spline")
    same("gimp stretched too far, everywhere", scene(2, ("neohookean",), **pull, extra="-method_basis gimp\n-method_gimp_update stretch"), "", status=3)


for part in (check_refusals, check_particles, check_methods, check_periodic, check_walls, check_materials, check_flight):
    part()
print(f"{runs} runs")
check.end()
