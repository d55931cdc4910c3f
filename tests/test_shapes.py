"""Shapes of bodies against tests of places that know nothing of Pebble's: places of particles by closed forms and winding
numbers; a box as polygon and as STL has the bits of the box; bodies that others cut; what loads see of them; the same
bits on any number of processes and after a restart; and the answers to shapes that are wrong.

usage: test_shapes.py PEBBLE SOURCE MPIEXEC
"""
import os
import re
import struct

import h5py
import numpy as np

import check

MATERIAL = ["-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e6", "-material_m_nu 0.3"]
H, PPC = 1 / 8, 2


def scene(name, dim, bodies, *more, cells=8):
    """Writes an options file with these bodies, {name: lines without their prefix}; all are of material m, unless they say it."""
    lines = [f"-dim {dim}", "-grid_lower " + ",".join(["0"] * dim), "-grid_upper " + ",".join(["1"] * dim), "-grid_cells " + ",".join([str(cells)] * dim), *MATERIAL,
             "-bodies " + ",".join(bodies), "-time_end 0.02", "-output_every 0", "-output_fields body", "-method_basis linear", *more]
    lines += ["-method_rim whole"] if any("shape file" not in words for words in bodies.values()) else []  # the particles are at the places of the lattice
    for body, words in bodies.items():
        lines += [f"-body_{body}_{word}" for word in words] + ([] if any(word.startswith("material") for word in words) else [f"-body_{body}_material m"])
    return check.write(name + ".opts", lines)


def run(name, *more, n=1):
    told = check.pebble("-options_file", name + ".opts", "-output_dir", ".", *more, n=n)
    check.need(told.good, f"{name}: status {told.status}: {told.err[:500]}")
    return told


def lattice(dim, cells=8):
    """All places of the lattice in the grid."""
    axis = (np.arange(PPC * cells) + 0.5) / (PPC * cells)
    return np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), -1).reshape(-1, dim)


def places(name, dim):
    """{number of a body: its places at the start}"""
    found = check.particles(name + ".h5", 0, ("x", "body"))
    return {int(b): found["x"][found["body"] == b][:, :dim] for b in np.unique(found["body"])}


def same(label, got, want):
    """The same places, in the order of the lattice."""
    wrong = got.shape != want.shape or not np.allclose(got, want, rtol=0, atol=1e-12)
    check.that(len(want) and not wrong, f"{label}: {len(got)} places, {len(want)} by the test")


# ---- Surfaces

def winding(polygon, x):
    """Winding numbers of places about a loop of vertices, by angles."""
    a, b = polygon[None] - x[:, None], np.roll(polygon, -1, 0)[None] - x[:, None]
    return np.round(np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(-1)).sum(1) / (2 * np.pi))


def solid_angle(triangles, x):
    """Winding numbers about a surface, by the solid angles of its triangles (Van Oosterom and Strackee 1983)."""
    a, b, c = (triangles[None, :, k] - x[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    top = (a * np.cross(b, c)).sum(-1)
    return np.round(np.arctan2(top, la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb).sum(1) / (2 * np.pi))


def torus(n=14, m=9, R=0.24, r=0.11):
    """Triangles of a torus around 0, turned a little."""
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    p = np.stack([(R + r * np.cos(v)) * np.cos(u), (R + r * np.cos(v)) * np.sin(u), r * np.sin(v)], -1)
    p = (p @ np.array([[0.8, 0.36, 0.48], [0, 0.8, -0.6], [-0.6, 0.48, 0.64]])).astype("f4").astype(float)
    q, s, t = np.roll(p, -1, 0), np.roll(p, -1, 1), np.roll(np.roll(p, -1, 0), -1, 1)
    return np.concatenate([np.stack([p, q, t], 2), np.stack([p, t, s], 2)]).reshape(-1, 3, 3)


def box(lower, upper):
    """Triangles of a box."""
    found = []
    for axis in range(3):
        for side in range(2):
            corners = np.array([[lower, upper][side] if d == axis else None for d in range(3)], dtype=object)
            quad = []
            for bits in ((0, 0), (1, 0), (1, 1), (0, 1)):
                others = iter(bits)
                quad.append([corners[d][d] if d == axis else (lower, upper)[next(others)][d] for d in range(3)])
            found += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    return np.array(found, dtype=float)


def ascii_stl(path, triangles):
    text = "solid shape\n"
    for t in triangles:
        text += "facet normal 0 0 0\n outer loop\n" + "".join(f"  vertex {float(v[0])!r} {float(v[1])!r} {float(v[2])!r}\n" for v in t) + " endloop\nendfacet\n"
    return check.write(path, text + "endsolid shape\n")


def binary_stl(path, triangles):
    with open(path, "wb") as file:
        file.write(b"solid is what a binary file may begin with too".ljust(80) + struct.pack("<I", len(triangles)))
        for t in triangles:
            file.write(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0))
    return path


# ---- Places

def check_solids():
    """Bodies in 3-D, some cut: places, processes, restart."""
    ring, x = torus(), lattice(3)
    ascii_stl("ring.stl", ring)
    binary_stl("ring_mm.stl", 1000 * ring)
    axis, ball = np.array([1, -2, 2]) / 3, ((x - [0.7, 0.3, 0.4])**2).sum(1) < 0.3**2
    along = (x - [0.3, 0.7, 0.6]) @ axis
    rod = (abs(along) < 0.25) & (((x - [0.3, 0.7, 0.6] - along[:, None] * axis)**2).sum(1) < 0.2**2)
    below = (x - [0.5, 0.5, 0.1]) @ [0.1, 0.2, 1] < 0
    wave = np.sin(6 * x[:, 0]) + np.cos(5 * x[:, 1]) + x[:, 2] - 1.2
    donut = solid_angle(ring + [0.6, 0.55, 0.5], x) != 0
    bodies = {"rod": ["shape cylinder", "center 0.3,0.7,0.6", "axis 1,-2,2", "radius 0.2", "length 0.5", "cut donut,ball"],
              "ball": ["shape sphere", "center 0.7,0.3,0.4", "radius 0.3", "material none", "cut below"],
              "below": ["shape halfspace", "point 0.5,0.5,0.1", "normal 0.2,0.4,2"],
              "wave": ["shape expression", 'expression "sin(6*x)+cos(5*y)+z-1.2"', "within ball", "cut donut", "lower 0,0,0.25", "upper 1,1,1"],
              "donut": ["shape stl", "file ring.stl", "shift 0.6,0.55,0.5", "velocity 0,0,-1"]}
    scene("solids", 3, bodies)
    told = run("solids", "-checkpoint_every", 0.006)
    ball &= ~below
    wants = {"rod": rod & ~donut & ~ball, "below": below, "wave": (wave > 0) & (x[:, 2] >= 0.25) & ball & ~donut, "donut": donut}
    for number, (name, inside) in enumerate(wants.items()):
        same(f"{name} of {len(wants)} solids", places("solids", 3).get(number, np.zeros((0, 3))), x[inside])
    for n, strategy in ((3, "spatial"), (3, "pool")):
        other = run("solids", "-parallel_strategy", strategy, "-output_name", strategy, n=n)
        check.that(told.digest and other.digest == told.digest, f"solids: {strategy} on {n} processes: {other.digest} against {told.digest}")
    kept = sorted(name for name in os.listdir(".") if name.startswith("solids-checkpoint-"))
    check.need(kept, "solids: there is no checkpoint")
    again = run("solids", "-restart_file", kept[0], "-output_name", "again", n=2)
    check.that(again.digest == told.digest, f"solids: from {kept[0]}: {again.digest} against {told.digest}")
    ascii_stl("ring.stl", ring + [0, 0, 0.001])
    told = check.pebble("-options_file", "solids.opts", "-output_dir", ".", "-restart_file", kept[0], "-output_name", "again")
    check.that(told.status == 2 and "what -body_<b>_file names has changed" in told.err, f"solids: a restart with another file is refused: {told.err.strip()}")
    bodies["donut"][1:3] = ["file ring_mm.stl", "scale 0.001", "shift 0.6,0.55,0.5"]
    scene("binary", 3, bodies)
    run("binary", "-time_max_steps", 1)
    same("donut of a binary file in mm", places("binary", 3)[3], x[donut])


def check_polygons():
    """A star with a hole and an island, in the plane and as a prism; by an option and by a file."""
    turns, x = 2 * np.pi * np.arange(14) / 14, lattice(2, 32)
    star = np.round(0.5 + np.where(np.arange(14) % 2, 0.25, 0.48)[:, None] * np.stack([np.cos(turns), np.sin(turns)], 1), 4)
    loops = [star, np.array([[0.4, 0.4], [0.6, 0.4], [0.6, 0.61], [0.4, 0.6]]), np.array([[0.45, 0.45], [0.45, 0.53], [0.55, 0.5]])]
    inside = sum(abs(winding(loop, x)) for loop in loops) % 2 == 1
    text = " ; ".join(" ".join(f"{a},{b}" for a, b in loop) for loop in loops)
    check.write("corners.csv", "# a star\nx, y\n" + "\n\n".join("\n".join(f"{a}, {b}" for a, b in loop) for loop in loops) + "\n")
    os.makedirs("elsewhere", exist_ok=True)
    scene("star", 2, {"b": ["shape polygon", f'vertices "{text}"']}, cells=32)
    scene("star_file", 2, {"b": ["shape polygon", "file corners.csv"]}, cells=32)
    told = run("star", "-time_max_steps", 4)
    same("star", places("star", 2)[0], x[inside])
    other = check.pebble("-options_file", "../star_file.opts", "-output_dir", ".", "-time_max_steps", 4, cwd="elsewhere")
    check.that(told.digest and other.digest == told.digest, f"star from a file next to its options file: {other.digest} {other.err.strip()}")
    scene("prism", 3, {"b": ["shape polygon", "file corners.csv", "lower 0,0.3,0.2", "upper 1,1,0.6"]})
    run("prism", "-time_max_steps", 1)
    y = lattice(3)
    keep = (sum(abs(winding(loop, y[:, :2])) for loop in loops) % 2 == 1) & (y[:, 1] >= 0.3) & (y[:, 2] >= 0.2) & (y[:, 2] < 0.6)
    same("prism", places("prism", 3)[0], y[keep])


def check_boxes():
    """The places of a lattice lie on the faces of these boxes, which are half-open however they are told."""
    lower, upper = [0.1875, 0.25, 0.0625], [0.6875, 0.625, 0.8125]
    ascii_stl("box.stl", box(lower, upper))
    corners = " ".join(f"{(lower, upper)[i][0]},{(lower, upper)[j][1]}" for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    text = [",".join(map(str, corner)) for corner in (lower, upper)]
    shapes = {"box": ["shape box", "lower " + text[0], "upper " + text[1]],
              "stl": ["shape stl", "file box.stl"],
              "polygon": ["shape polygon", f'vertices "{corners}"', f"lower 0,0,{lower[2]}", f"upper 1,1,{upper[2]}"],
              "expression": ["shape expression", 'expression "' + "*".join(f"({q}>={a})*({q}<{b})" for q, a, b in zip("xyz", lower, upper)) + '"'],
              "within": ["shape halfspace", "point 0,0,0.8125", "normal 0,0,1", "within t"]}
    digests = {}
    for name, words in shapes.items():
        tool = {"t": ["shape stl", "file box.stl", "material none"]} if name == "within" else {}
        scene("as_" + name, 3, {"b": words + ["offset 0.03125,0.03125,0.03125", "velocity 1,2,y"], **tool})
        digests[name] = run("as_" + name, "-time_max_steps", 3).digest
    check.that(digests["box"] and len(set(digests.values())) == 1, f"a box by {' '.join(digests)}: {' '.join(map(str, digests.values()))}")


def check_loads():
    """A load acts on the surface of a body that is cut: on both faces of a slot, but not on the tool's."""
    slot = ["shape box", "lower 0.25,0.25", "upper 0.5,0.75", "material none"]
    scene("slot", 2, {"b": ["shape box", "lower 0.125,0.125", "upper 0.875,0.625", "cut slot"], "slot": slot}, "-loads l", "-load_l_body b", "-load_l_type pressure", "-load_l_value 1")
    area = run("slot", "-time_max_steps", 1).find(r"area along each axis \(([^)]*)\)")
    check.that(area == "1.75, 1.5", f"area of a block with a slot: {area}, by hand 2 (0.5 + 0.375), 2 0.75")


def check_files():
    """Particles of a file: those of a disk have the bits of the disk; volumes, materials and F of each; processes, restart."""
    x = lattice(2)
    disk = x[((x - [0.5, 0.6])**2).sum(1) < 0.3**2]
    table = np.concatenate([disk, np.full((len(disk), 1), 0.1), disk[:, :1]], 1)
    check.write("disk_points.csv", "# a disk\n\nx, y, vx, vy\n" + "\n".join(", ".join(repr(float(v)) for v in row) for row in table) + "\n")
    floor = ["shape box", "lower 0,0", "upper 1,0.125"]
    scene("as_disk", 2, {"floor": floor, "b": ["shape sphere", "center 0.5,0.6", "radius 0.3", 'velocity "0.1,x"']}, "-gravity 0,-9.81")
    scene("as_points", 2, {"b": ["shape file", "file disk_points.csv", "ppc 2,2"], "floor": floor}, "-gravity 0,-9.81")
    want, told = run("as_disk").digest, run("as_points")
    check.that(want and told.digest == want, f"particles of a file that are a disk: {told.digest} against {want}")
    check.write("mixed_points.csv", "material;Fxx;Fxy;Fyx;Fyy;y;x;volume\n" + "".join(f"{'mn'[k % 2]};1.01;0.02;0;0.99;{p[1]!r};{p[0]!r};{0.0001 * (8 + k % 3)}\n" for k, p in enumerate(disk.tolist())))
    other = [line.replace("_m_", "_n_") for line in MATERIAL[1:]]
    scene("mixed", 2, {"b": ["shape file", "file mixed_points.csv", "velocity 0,-1"]}, *other, "-materials m,n", "-material_n_rho 3000", "-method_basis gimp", "-method_gimp_update stretch", cells=16)
    text = [line for line in open("mixed.opts").read().splitlines() if line not in ("-materials m", "-material_n_rho 1000", "-method_basis linear")]
    check.write("mixed.opts", text)
    mixed = run("mixed", "-checkpoint_every", 0.004, "-history_every", 0)
    history, count = check.history("mixed.csv"), np.arange(len(disk))
    mass = (np.where(count % 2, 3000, 1000) * 0.0001 * (8 + count % 3)).sum()
    check.that(abs(history["mass"][0] - mass) < 1e-9 * mass and history["strain_energy"][0] > 0, f"mixed: mass {history['mass'][0]}, {mass} by volumes and densities; strained at the start")
    with h5py.File("mixed_points.h5", "w") as file:
        file["x"], file["volume"], file["material"] = disk, 0.0001 * (8 + count % 3), count % 2
        file["F"] = np.tile(np.array([[1.01, 0.02], [0, 0.99]]), (len(disk), 1, 1))
    # -rerun from another folder, where the path of the file, which began at the options file, leads nowhere
    os.makedirs("elsewhere", exist_ok=True)
    os.replace("disk_points.csv", "elsewhere/disk_points.csv")
    os.replace("as_points.opts", "elsewhere/as_points.opts")
    first = check.pebble("-options_file", "elsewhere/as_points.opts", "-output_dir", ".", "-output_name", "first")
    again = check.pebble("-rerun", "first.h5", "-output_dir", ".", "-output_name", "again")
    check.that(first.digest == told.digest and again.digest == told.digest, f"a file beside the options file: {first.digest}, repeated by -rerun: {again.digest} {again.err.strip()[-200:]}")
    os.replace("elsewhere/disk_points.csv", "disk_points.csv")
    os.replace("elsewhere/as_points.opts", "as_points.opts")
    serials = {"as_points": told, "mixed": mixed}
    got = run("mixed", "-body_b_file", os.path.abspath("mixed_points.h5"), "-output_name", "other", n=2)
    check.that(got.digest == mixed.digest, f"mixed, from HDF5 on 2 processes: {got.digest} against {mixed.digest}")
    for name, strategy in (("as_points", "spatial"), ("mixed", "pool")):
        got = run(name, "-parallel_strategy", strategy, "-output_name", "other", n=3)
        check.that(got.digest == serials[name].digest, f"{name}: {strategy} on 3 processes: {got.digest} against {serials[name].digest}")
    kept = sorted(file for file in os.listdir(".") if file.startswith("mixed-checkpoint-"))
    check.need(kept, "mixed: there is no checkpoint")
    got = run("mixed", "-restart_file", kept[0], "-output_name", "again")
    check.that(got.digest == mixed.digest, f"mixed: from {kept[0]}: {got.digest} against {mixed.digest}")


def check_marks():
    """Files as other programs write them are read, or refused for what they are: byte-order marks, blanks, ends of lines, quotes."""
    x = lattice(2)
    disk = x[((x - [0.5, 0.6])**2).sum(1) < 0.3**2].tolist()
    rows = "x,y,volume\n" + "".join(f"{a!r},{b!r},{1 / 256!r}\n" for a, b in disk)
    corners = "x,y\n0.1,0.1\n0.7,0.2\n0.3,0.8\n\n0.3,0.3\n0.35,0.3\n0.3,0.4\n"
    ascii_stl("plain.stl", box([0.2, 0.2, 0.2], [0.6, 0.6, 0.6]))
    triangles = open("plain.stl").read()
    scene("table", 2, {"b": ["shape file"]})
    scene("outline", 2, {"b": ["shape polygon"]})
    scene("solid", 3, {"b": ["shape stl"]})
    wide = "is text in UTF-16; save it as UTF-8"
    for name, text, ends in (("table", rows, ".csv"), ("outline", corners, ".csv"), ("solid", triangles, ".stl")):
        ways = {"plain": text.encode(), "mark": b"\xef\xbb\xbf" + text.encode(), "blanks": b"\n \t\n  " + text.encode(), "crlf": text.replace("\n", "\r\n").encode(),
                "utf16": text.encode("utf-16"), "utf16be": text.encode("utf-16-be"), "cr": text.replace("\n", "\r").encode()}
        if name == "table":
            ways |= {"quotes": "".join(",".join(f'"{word}"' for word in line.split(",")) + "\n" for line in text.splitlines()).encode(), "zero": text[:-4].encode() + b"\0" + text[-4:].encode(),
                     "tabs": text.replace(",", "\t").encode(), "semicolons": text.replace(",", "; ").encode(), "comments": ("  # of a disk\n" + text).encode()}
        digests = {}
        for way, data in ways.items():
            path = f"{name}_{way}{ends}"
            with open(path, "wb") as file:
                file.write(data)
            told = check.pebble("-options_file", name + ".opts", "-body_b_file", path, "-output_dir", ".", "-time_max_steps", 2, n=2 if way in ("mark", "crlf") and name == "table" else 1)
            why = {"utf16": wide, "utf16be": wide, "zero": "it is no text"}.get(way) or (way == "cr" and name == "table" and "lines end with CR alone; save it with lines that end with LF")
            if why:
                check.that(told.status == 2 and f"-body_b_file" in told.err and path in told.err and why in told.err and "\n" not in told.err.strip(), f"{path} is refused for what it is: {told.err.strip()}")
            else:
                digests[way] = told.digest
        check.that(None not in digests.values() and len(set(digests.values())) == 1, f"{name}: the same body {' '.join(digests)}: {set(digests.values())}")


def warned(told):
    """Its warnings, but for those of the method."""
    return [line[11:] for line in told.out.splitlines() if line.startswith("warning ") and " amplifies noise " not in line]


def check_tables():
    """Tables with too much matter are warned of, on any number of processes; a table that fills its cells is not."""
    x = lattice(2, 16)
    x = x[(abs(x - 0.5) < 0.25).all(1)]
    size = 1 / 32**2
    scene("table", 2, {"b": ["shape file"]}, "-report_indicator false", cells=16)

    def answer(name, rows, n=1, *more):
        check.write(f"t_{name}.csv", "x,y,volume\n" + "".join(f"{a!r},{b!r},{v!r}\n" for a, b, v in rows))
        return warned(run("table", "-body_b_file", f"t_{name}.csv", "-time_max_steps", 1, *more, n=n))

    good = [(a, b, size) for a, b in x.tolist()]
    some = np.random.default_rng(1)
    moved = [(a + d, b + e, size) for (a, b), (d, e) in zip(x.tolist(), (0.3 / 32 * (some.random((len(x), 2)) - 0.5)).tolist())]
    check.that(not answer("good", good) and not answer("moved", moved), "a table that is a lattice, or nearly one, gets no warning")
    place = "{} of the {} particles of b lie at the place of another one, or nearer than a quarter of their size, the first is number {} of t_{}.csv: matter is there twice"
    cases = {"twice": (good + good, [place.format(2 * len(x), 2 * len(x), 1, "twice"), f"the particles of b have a volume of {2 * len(x) * size:.3g} m^2 together, and the 64 cells in which they lie "
                                     f"{len(x) * size:.3g}; see the column volume of t_twice.csv, and its unit"]),
             "one": (good + [(good[40][0] + 0.2 / 32, good[40][1], size)], [place.format(2, len(x) + 1, 41, "one")]),
             "same": (1000 * [(0.52, 0.52, 0.0025)], [place.format(1000, 1000, 1, "same"),
                                                      "the particles of b have a volume of 2.5 m^2 together, more than the grid, 1; see the column volume of t_same.csv, and its unit"]),
             "mm": ([(a, b, 1e6 * size) for a, b in x.tolist()],
                    [f"the particles of b have a volume of {1e6 * len(x) * size:.3g} m^2 together, more than the grid, 1; see the column volume of t_mm.csv, and its unit",
                     f"{len(x)} of the {len(x)} particles of b are larger than 2 cells, the largest has {1e6 / 4:.3g}: they leave gaps; give more and smaller ones, or larger cells"]),
             "mm2": ([(a, b, 1e-6 * size) for a, b in x.tolist()],
                     [f"the particles of b have a volume of {1e-6 * len(x) * size:.3g} m^2 together, 1e-06 of that of the cells in which they lie; see the column volume of t_mm2.csv, and its unit"]),
             "few": ([(0.3, 0.3, 0.01), (0.45, 0.3, 0.01)], ["the particles of b have a volume of 0.02 m^2 together, and the 2 cells in which they lie 0.00781; see the column volume of t_few.csv, and its unit",
                                                             "2 of the 2 particles of b are larger than 2 cells, the largest has 2.56: they leave gaps; give more and smaller ones, or larger cells"])}
    for name, (rows, want) in cases.items():
        got = answer(name, rows)
        check.that(got == want, f"table {name}: {got} {want if got != want else ''}")
    for more in (["-parallel_strategy", "spatial"], ["-parallel_strategy", "pool"]):
        got = answer("twice", cases["twice"][0], 3, *more)
        check.that([line for line in got if "particles of b" in line] == cases["twice"][1], f"the same with {more[-1]} on 3 processes")
    with h5py.File("t_twice.h5", "w") as file:
        file["x"], file["volume"] = np.array([row[:2] for row in cases["twice"][0]]), np.full(2 * len(x), size)
    got = warned(run("table", "-body_b_file", "t_twice.h5", "-time_max_steps", 1))
    check.that(got == [line.replace(".csv", ".h5") for line in cases["twice"][1]], f"the same from HDF5: {got}")


def check_thin():
    """Bodies that the lattice misses, or fills badly, are told with numbers and a remedy, which helps."""
    ascii_stl("plate.stl", box([0.2, 0.2, 0.3], [0.6, 0.6, 0.312]))
    ascii_stl("plate_mm.stl", 1000 * box([0.2, 0.2, 0.2], [0.6, 0.6, 0.6]))
    ascii_stl("plate_km.stl", 1e-3 * box([0.2, 0.2, 0.2], [0.6, 0.6, 0.6]) + 0.5)
    scene("deep", 3, {"b": ["shape stl"]})
    scene("flat", 2, {"b": ["shape box"]})
    bounds = ["-body_b_lower", "0.1,0.1", "-body_b_upper"]
    cases = [("flat", bounds + ["0.7,0.12"], 2, "body b has no particles: no place (i+1/2) h/ppc + offset lies in it; along y it is 0.02 m, and its particles are 0.0625 m apart; "),
             ("flat", ["-body_b_lower", "0.1,0.15", "-body_b_upper", "0.7,0.18"], 0, "the particles of b have a volume of 0.0352 m^2, and its shape 0.018: along y it is 0.03 m, and its particles are 0.0625 m apart; "),
             ("flat", ["-body_b_shape", "sphere", "-body_b_center", "0.5,0.5", "-body_b_radius", "0.04"], 2, "body b has no particles: no place"),
             ("flat", ["-body_b_shape", "expression", "-body_b_expression", "0.012-abs(y-0.4-0.5*(x-0.5))"], 0, "the particles of b have a volume of "),
             ("deep", ["-body_b_file", "plate.stl"], 2, "body b has no particles: no place (i+1/2) h/ppc + offset lies in it; along z it is 0.012 m, and its particles are 0.0625 m apart; ")]
    for name, words, status, want in cases:
        told = check.pebble("-options_file", name + ".opts", *words, "-dry_run")
        ppc = re.search(r"use more of them per cell \(-body_b_ppc ([\d,]+)\)", told.said)
        check.that(told.status == status and want in told.said and ppc, f"{name} {words[-1]}: {told.said.splitlines()[-1] if status else warned(told)}")
        again = check.pebble("-options_file", name + ".opts", *words, "-dry_run", "-body_b_ppc", ppc[1] if ppc else "1")
        check.that(again.status == 0 and not warned(again), f"with -body_b_ppc {ppc and ppc[1]} there is neither a refusal nor a warning: {again.said.splitlines()[-1]}")
    thin = check.pebble("-options_file", "flat.opts", *bounds, "0.9,0.1000001", "-dry_run")
    check.that(thin.status == 2 and "use smaller cells" in thin.err, f"a body that no number of particles resolves: {thin.err.strip()}")
    for name, want, cure in (("plate_mm", "body b lies outside of the grid: it reaches from x = 200 to 600, the grid from 0 to 1; if its file is in mm, give -body_b_scale 0.001", ["-body_b_scale", "0.001"]),
                             ("plate_km", "is the unit of its file another one (-body_b_scale)?", ["-body_b_scale", "1000", "-body_b_shift", "-500,-500,-500"])):
        told = check.pebble("-options_file", "deep.opts", "-body_b_file", name + ".stl", "-dry_run")
        check.that(told.status == 2 and want in told.err, f"{name}: {told.err.strip()}")
        told = check.pebble("-options_file", "deep.opts", "-body_b_file", name + ".stl", "-dry_run", *cure)
        check.that(told.status == 0 and "343 particles" in told.out, f"{name} with {cure[0]}: {told.find('([0-9]+ particles)')}")
    told = check.pebble("-options_file", "deep.opts", "-body_b_file", "plate.stl", "-body_b_shift", "3,0,0", "-dry_run")
    check.that(told.status == 2 and "; -body_b_scale and -body_b_shift change its size and place" in told.err, f"outside of the grid: {told.err.strip()}")
    told = check.pebble("-options_file", "flat.opts", "-body_b_shape", "sphere", "-body_b_center", "1.03,0.5", "-body_b_radius", "0.02", "-dry_run")
    check.that(told.status == 2 and "body b lies outside of the grid: it reaches from x = 1.01 to 1.05" in told.err, f"a small ball beside the grid: {told.err.strip()}")


# ---- Refusals

def check_refusals():
    good = box([0.2, 0.2, 0.2], [0.6, 0.6, 0.6])
    ascii_stl("good.stl", good)
    ascii_stl("hole.stl", good[1:])
    ascii_stl("twice.stl", np.concatenate([good, good[:1]]))
    ascii_stl("line.stl", np.concatenate([good, [[[0, 0, 0], [0.2, 0.2, 0.2], [0, 0, 0]]]]))
    text = open("good.stl").read()
    check.write("cut.stl", text[:len(text) // 2])
    check.write("word.stl", text.replace("vertex 0.6", "vertex 0,6", 1))
    check.write("no.stl", "facet\n")
    check.write("behind.stl", text + "the end\n")
    check.write("within.stl", text[:text.index("outer")])
    check.write("empty.stl", "solid none\nendsolid none\n")
    ascii_stl("lines.stl", np.zeros((4, 3, 3)))
    binary_stl("inf.stl", np.where(np.arange(9 * len(good)).reshape(good.shape) == 30, np.inf, good))
    check.write("heading.csv", "x,y\n")
    check.write("eight.csv", "0.5,0.5\n1,0\n1,1\n0.5,0.5\n0,0\n0,1\n")
    check.write("zero.csv", "0.1,0.1\n0.5,0.1\0\n0.5,0.5\n")
    check.write("bad.csv", "x,y\n0.1,0.1\n0.5 0.1\n0.5,high\n")
    check.write("few.csv", "0.1,0.1\n0.5,0.1\n0.1,0.1\n")
    scene("flat", 2, {"b": ["shape polygon"]})
    scene("deep", 3, {"b": ["shape stl"]})
    scene("thin", 1, {"b": ["material m"]})
    scene("both", 2, {"a": ["shape box", "lower 0,0", "upper 1,1"], "b": ["shape file", "ppc 2,2"]})
    scene("tools", 2, {"a": ["shape box", "lower 0,0", "upper 1,1", "material none"]})
    scene("cut", 2, {"a": ["shape box", "lower 0,0", "upper 1,1"], "b": ["shape sphere", "center 0.5,0.5", "radius 0.2"], "c": ["shape sphere", "center 0.5,0.5", "radius 0.1"]})
    shape = "-body_b_shape"
    scene("points", 2, {"b": ["shape file", "ppc 2,2"]}, "-loads l", "-load_l_type pressure", "-load_l_value 1", "-load_l_body b")
    scene("lines", 2, {"b": ["shape file"]})
    for name, lines in {"colour": "x,y,colour\n0.5,0.5,1\n", "twice": "x,y,x\n0.5,0.5,1\n", "part": "x,y,vx\n0.5,0.5,1\n", "head": "x,y\n", "short": "x,y,volume\n0.5,0.5,1\n#\n0.5,0.6\n",
                        "word": "x,y,volume\n0.5,0.5,one\n", "none": "x,y,volume\n0.5,0.5,0\n", "flip": "x,y,volume,Fxx,Fxy,Fyx,Fyy\n0.5,0.5,1,1,0,0,-1\n",
                        "far": "x,y,volume,Fxx,Fxy,Fyx,Fyy\n0.5,0.5,1,1e-200,0,0,1e200\n",
                        "steel": "x,y,volume,material\n0.5,0.5,1,m\n0.5,0.5,1,steel\n", "out": "x,y,volume\n0.5,1.5,1\n", "lattice": "x,y\n0.5,0.5\n", "moving": "x,y,vx,vy,volume\n0.5,0.5,1,1,1\n",
                        "strained": "x,y,volume,Fxx,Fxy,Fyx,Fyy\n0.5,0.5,1,1,0,0,1\n", "nan": "x,y,volume\n0.5,nan,1\n",
                        "volumes": "x,y,volume\n" + "".join(f"0.5,0.5,{k}\n" for k in range(1, 65538))}.items():
        check.write(f"p_{name}.csv", lines)

    for name, sets in {"bare": {"v": 2}, "rows": {"x": (3, 2), "v": (4, 2)}, "wide": {"x": (3, 3)}, "minus": {"x": (3, 2), "volume": (3,)}, "kind": {"x": (3, 2), "volume": (3,), "material": (3,)}}.items():
        with h5py.File(f"p_{name}.h5", "w") as file:
            for set_, size in sets.items():
                file[set_] = np.full(size, 0.5 if name != "minus" or set_ == "x" else -1.0) if set_ != "material" else np.array([0, 1, 0])
    with h5py.File("p_text.h5", "w") as file:
        file["x"] = np.array([[b"a", b"b"]])

    def points(name):
        return ["-body_b_file", f"p_{name}.csv"]
    cases = [
        ("flat", [], "-body_b_vertices is required (corners of a polygon, \"x,y x,y x,y\"), or -body_b_file"),
        ("flat", ["-body_b_vertices", "0,0 1,0"], "-body_b_vertices: loop 1 has 2 vertices, a loop needs 3"),
        ("flat", ["-body_b_vertices", "0,0 1,0 1;0,1"], "-body_b_vertices: vertex 3 has no two numbers x,y before ';0,1'; write \"x,y x,y x,y\", and ; between loops"),
        ("flat", ["-body_b_vertices", "0,0 1,1 1,0 0,1"], "-body_b_vertices: edge 1 of loop 1, from 0,0 to 1,1, crosses edge 3 of loop 1, from 1,0 to 0,1"),
        ("flat", ["-body_b_vertices", "0,0 1,1 1,0 1,1"], "-body_b_vertices: loop 1 turns back on itself at vertex 3, 1,0"),
        ("flat", ["-body_b_vertices", "0,0 1,1 1,0 0,0.8"], "-body_b_vertices: edge 1 of loop 1, from 0,0 to 1,1, crosses edge 3 of loop 1, from 1,0 to 0,0.8"),
        ("flat", ["-body_b_vertices", "0,0 1,0 1,1; 0.5,0.1 0.9,0.1 0.5,0.7"], "-body_b_vertices: edge 3 of loop 1, from 1,1 to 0,0, crosses edge 2 of loop 2, from 0.9,0.1 to 0.5,0.7"),
        ("flat", ["-body_b_vertices", "0,0 1,0 1,0 1,1"], "-body_b_vertices: vertices 2 and 3 of loop 1 are both 1,0"),
        ("flat", ["-body_b_vertices", "0,0 1,0 0.5,0 0.5,1"], "-body_b_vertices: loop 1 turns back on itself at vertex 2, 1,0"),
        ("flat", ["-body_b_vertices", "0,0 1,0 1,1", "-body_b_file", "few.csv"], "-body_b_vertices and -body_b_file exclude each other"),
        ("flat", ["-body_b_file", "bad.csv"], "-body_b_file bad.csv:4: a vertex is two numbers x,y, and this line has something else at 'high'"),
        ("flat", ["-body_b_file", "few.csv"], "-body_b_file few.csv: loop 1 has 2 vertices, a loop needs 3"),
        ("flat", ["-body_b_file", "none.csv"], "-body_b_file: cannot read none.csv: No such file or directory"),
        ("flat", ["-body_b_vertices", "0,0 1,0 1,2"], "body b lies outside of the grid"),
        ("flat", ["-body_b_file", "heading.csv"], "-body_b_file heading.csv: it has no vertices"),
        ("flat", ["-body_b_file", "eight.csv"], "-body_b_file eight.csv: loop 1 has no area"),
        ("flat", ["-body_b_file", "zero.csv"], "-body_b_file: zero.csv is no text"),
        ("flat", ["-body_b_vertices", "0,0 0.5,0 0,0.5", "-body_b_lower", "0.6,0.6"], "-body_b_vertices: nothing of it lies between -body_b_lower and -body_b_upper"),
        ("flat", [shape, "box"], "-body_b_lower is required (lower corner of a box)"),
        ("thin", [shape, "cylinder"], "-body_b_shape cylinder needs -dim 3: in 1-D a body is a box"),
        ("thin", [shape, "polygon"], "-body_b_shape polygon needs -dim 2 or 3: in 1-D a body is a box"),
        ("flat", [shape, "cylinder"], "-body_b_shape cylinder needs -dim 3: in 2-D a disk is a sphere, and its side view a box"),
        ("flat", [shape, "stl", "-body_b_file", "good.stl"], "-body_b_shape stl needs -dim 3: choose polygon in 2-D, box in 1-D"),
        ("flat", [shape, "halfspace", "-body_b_point", "0,0", "-body_b_normal", "0,0"], "-body_b_normal is 0, which is no direction"),
        ("flat", [shape, "expression"], "-body_b_expression is required (a formula of x, y, z; the body of shape expression is where it is positive)"),
        ("flat", [shape, "expression", "-body_b_expression", "x+"], "-body_b_expression x+:"),
        ("flat", [shape, "expression", "-body_b_expression", "x,y"], "-body_b_expression has 2 components, it needs 1"),
        ("flat", [shape, "expression", "-body_b_expression", "0/0"], "body b has no particles: nothing is inside of its shape"),
        ("deep", [], "-body_b_file is required (an STL file)"),
        ("deep", ["-body_b_file", "none.stl"], "-body_b_file: cannot read none.stl: No such file or directory"),
        ("deep", ["-body_b_file", "."], "-body_b_file: cannot read .: it is not a file"),
        ("deep", ["-body_b_file", "hole.stl"], "-body_b_file hole.stl is not closed: 3 edges belong to one facet only, such as that from 0.2,0.2,0.2 to 0.2,0.6,0.2;"),
        ("deep", ["-body_b_file", "twice.stl"], "-body_b_file twice.stl: 3 edges belong to more than two facets, such as that from 0.2,0.2,0.2 to 0.2,0.6,0.2, to 3;"),
        ("deep", ["-body_b_file", "cut.stl"], "-body_b_file cut.stl:44: 'f' where facet or endsolid should be"),
        ("deep", ["-body_b_file", "behind.stl"], "-body_b_file behind.stl:87: 'the' where solid or the end of the file should be"),
        ("deep", ["-body_b_file", "within.stl"], "-body_b_file within.stl:3: the file ends within a facet"),
        ("deep", ["-body_b_file", "empty.stl"], "-body_b_file empty.stl has no facets"),
        ("deep", ["-body_b_file", "lines.stl"], "-body_b_file lines.stl: all of its facets have two equal corners"),
        ("deep", ["-body_b_file", "inf.stl"], "-body_b_file inf.stl: a corner of facet 4 is not finite"),
        ("deep", ["-body_b_file", "word.stl"], "-body_b_file word.stl:18: '0,6' is not a number"),
        ("deep", ["-body_b_file", "no.stl"], "-body_b_file no.stl is no STL file"),
        ("deep", ["-body_b_file", "good.stl", "-body_b_scale", "1000"], "body b lies outside of the grid: it reaches from x = 200 to 600"),
        ("deep", ["-body_b_file", "good.stl", "-body_b_vertices", "0,0"], "-body_b_vertices does not apply: shape stl takes file scale shift"),
        ("lines", [], "-body_b_file is required (a CSV file of particles)"),
        ("lines", points("colour"), "-body_b_file p_colour.csv:1: 'colour' is no column: there are x, vx, Fxx and so on for 2-D, volume, material"),
        ("lines", points("twice"), "-body_b_file p_twice.csv:1: column x is there twice"),
        ("lines", points("part"), "-body_b_file p_part.csv:1: the first line names the columns;"),
        ("lines", points("head") + ["-body_b_ppc", "2,2"], "-body_b_file p_head.csv: it has no particles"),
        ("lines", points("short"), "-body_b_file p_short.csv:4: it has 2 values, the heading 3 columns"),
        ("lines", points("word"), "-body_b_file p_word.csv:2: 'one' is not a number"),
        ("lines", points("none"), "-body_b_file p_none.csv:2: volume 0 is not above 0"),
        ("lines", points("flip"), "-body_b_file p_flip.csv:2: det F = -1 is not above 0"),
        ("lines", points("far"), "-body_b_file p_far.csv:2: F is too far from 1"),
        ("lines", points("nan"), "-body_b_file p_nan.csv:2: a value is not finite"),
        ("lines", points("volumes"), "-body_b_file p_volumes.csv: its particles have more than 65536 volumes; round them"),
        ("lines", points("strained") + ["-material_m_model", "druckerprager", "-material_m_friction_angle", "30"],
         "-body_b_file p_strained.csv: F of m does not apply: the stress of this material depends on its history"),
        ("lines", points("steel"), "-body_b_file p_steel.csv:3: material steel is not declared"),
        ("lines", points("out"), "body b lies outside of the grid: its particle at y = 1.5"),
        ("lines", points("lattice"), "-body_b_file p_lattice.csv has no column volume: add one, or give -body_b_ppc"),
        ("lines", points("moving") + ["-body_b_velocity", "1,1"], "-body_b_velocity does not apply: p_moving.csv has velocities"),
        ("lines", points("moving") + ["-body_b_offset", "0,0"], "-body_b_offset "),
        ("lines", points("moving") + ["-initial_stress", "k0"], "-initial_stress does not apply: body b has shape file, where columns Fxx"),
        ("lines", points("moving") + ["-body_b_deformation", "1,0,0,1"], "-body_b_deformation does not apply: body b has shape file"),
        ("lines", ["-body_b_file", "p_bare.h5"], "-body_b_file p_bare.h5: it has no dataset x"),
        ("lines", ["-body_b_file", "p_text.h5", "-body_b_ppc", "2,2"], ": dataset x cannot be read as numbers"),
        ("lines", ["-body_b_file", "p_rows.h5"], "-body_b_file p_rows.h5: x has 3 rows, v 4"),
        ("lines", ["-body_b_file", "p_wide.h5"], "-body_b_file p_wide.h5: dataset x has not 2 numbers a particle"),
        ("lines", ["-body_b_file", "p_minus.h5"], "-body_b_file p_minus.h5, particle 1: volume -1 is not above 0"),
        ("lines", ["-body_b_file", "p_kind.h5"], "-body_b_file p_kind.h5, particle 2: its material is none of the 1 of -materials"),
        ("points", points("lattice"), "-load_l_body b does not apply: particles from a file have no known surface; use -load_l_type force or -acceleration"),
        ("cut", ["-body_a_cut", "d"], "-body_a_cut d: there is no such body"),
        ("cut", ["-body_a_cut", "a"], "-body_a_cut a: a body cannot cut itself"),
        ("cut", ["-body_a_cut", "b,b"], "-body_a_cut names b, which -body_a_cut or -body_a_within has named before"),
        ("cut", ["-body_a_cut", "b", "-body_b_within", "c", "-body_c_cut", "a"], "-body_a_cut: the shape of a would depend on itself, through the bodies that it names"),
        ("cut", ["-body_a_within", "a"], "-body_a_within a: a body cannot lie within itself"),
        ("both", points("lattice") + ["-body_a_cut", "b"], "-body_a_cut b does not apply: b has particles from a file, but no shape"),
        ("cut", ["-body_b_cut", "a"], "body b has no particles: nothing is inside of its shape, once others have cut it"),
        ("cut", ["-body_b_material", "none"], "-body_b_material none: no -body_<b>_cut and no -body_<b>_within names b; remove it"),
        ("cut", ["-body_b_material", "none", "-body_a_cut", "b", "-body_b_velocity", "1,1"], "-body_b_velocity "),
        ("tools", [], "-bodies: all are of material none; a scene needs particles"),
    ]

    def answer(case):
        name, words, want = case
        told = check.pebble("-options_file", name + ".opts", *words, "-dry_run")
        return told.status, told.err.strip()
    for (name, words, want), (status, err) in zip(cases, check.at_once(answer, cases)):
        check.fault(None if status == 2 and want in err and "\n" not in err else f"{name} {' '.join(words)}: status {status}\n  {err}\n  not {want}")
    told = check.pebble("-options_file", "deep.opts", "-body_b_file", "line.stl", "-dry_run")
    check.that(told.status == 0, f"a facet with two equal corners is left out: {told.err.strip()}")


check.arguments(__doc__, 0)
check_solids()
check_polygons()
check_boxes()
check_loads()
check_files()
check_marks()
check_tables()
check_thin()
check_refusals()
check.end()
