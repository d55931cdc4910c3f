"""Set-ups in the notation of the reference states (tests/reference/golden.json), as options files of Pebble; and how the
tests run them and read their states.

A set-up is a dict: ndim, origin, h, ncells, basis, boundary, walls {"x-": kind}, order, flip, affine, gravity, consts,
bodies [lo, hi, b, offset, region, rho, material, velocity], bodyforce, dt, steps. Expressions are Python's, of x, y, z
(for forces: where a particle is), X, Y, Z (where it started), t, pi and the names in consts.
"""
import math
import re

import h5py
import numpy as np

import check

BASES = {"linear": "linear", "ugimp": "gimp", "cpgimp": "gimp", "quadratic": "bspline2", "cubic": "bspline3"}
GIMP_UPDATES = {"ugimp": "none", "cpgimp": "stretch"}
MODELS = {"neo": "neohookean", "linear": "elastic", "fluid": "fluid", "j2log": "vonmises", "dp": "druckerprager"}
WALLS = {"free": "free", "sticky": "fixed", "slip": "slip", "separate": "separate"}
# Components that the reference lists for dim 1, 2, 3: of the file's tensors (xx xy xz yx ...), and of the six of a stress.
F_PARTS = {1: [0], 2: [0, 1, 3, 4], 3: range(9)}
SYMMETRIC = [0, 1, 2, 4, 5, 8]  # xx xy xz yy yz zz of a tensor of the file
STRESS_PARTS = {1: [0, 3, 5], 2: [0, 1, 3, 5], 3: range(6)}


class Unsupported(Exception):
    """Pebble has nothing of the kind."""


def numbers(values):
    return ",".join(repr(float(value)) for value in values)


def expression(text, consts):
    """A Python expression as muParser reads it; never with a minus first, which an options file takes for an option."""
    text = str(text).replace("**", "^").replace(" ", "")
    text = f"({text})" if text.startswith("-") else text
    for python, parser in (("log", "ln"), ("arctan2", "atan2")):
        text = re.sub(rf"\b{python}\(", parser + "(", text)
    for name, value in (consts or {}).items():
        text = re.sub(rf"\b{name}\b", f"({float(value)!r})", text)
    return text


def evaluate(text, consts, **variables):
    """Its value, of numpy arrays."""
    names = {name: getattr(np, name) for name in ("sin", "cos", "sqrt", "log", "arctan2", "pi", "exp")}
    value = eval(text, {"__builtins__": {}}, {**names, **(consts or {}), **variables})  # our own tables, nobody's input
    return np.broadcast_to(value, np.shape(variables["X"] if "X" in variables else variables["x"])).astype(float)


def friction_angle(alpha):
    """Degrees, of alpha = sqrt(2/3) 2 sin(phi)/(3 - sin(phi))."""
    k = alpha / math.sqrt(2 / 3)
    return math.degrees(math.asin(3 * k / (2 + k)))


def shape(body):
    """Name and options of the shape of a body."""
    region = body.get("region", "").replace(" ", "")
    number = r"([0-9.]+)"
    disk = re.fullmatch(rf"\(x-{number}\)\*\*2\+\(y-{number}\)\*\*2<{number}", region)
    ring = re.fullmatch(rf"\(x\*x\+y\*y>{number}\*\*2\)&\(x\*x\+y\*y<{number}\*\*2\)", region)
    if not region:
        return {"shape": "box", "lower": numbers(body["lo"]), "upper": numbers(body["hi"])}
    if disk:
        x, y, square = map(float, disk.groups())
        return {"shape": "sphere", "center": numbers([x, y]), "radius": repr(math.sqrt(square))}
    if ring:
        return {"shape": "annulus", "center": "0,0", "inner_radius": ring.group(1), "radius": ring.group(2)}
    raise Unsupported(f"region {region}")


def material(kind):
    """Name and options of a material."""
    parts = dict(kind)
    lines = {"model": MODELS.get(parts.pop("kind"))}
    if not lines["model"] or parts.pop("d", 3) != 3 or parts.pop("vc", 1) != 1:
        raise Unsupported(f"material {kind}")
    for name, option in (("E", "E"), ("nu", "nu"), ("K", "K"), ("visc", "viscosity"), ("tension", "tension_cutoff"),
                         ("yield_stress", "yield"), ("hardening", "hardening")):
        if name in parts:
            lines[option] = repr(float(parts.pop(name)))
    if "gamma" in parts:
        lines.update(eos="tait", tait_gamma=repr(float(parts.pop("gamma"))))
    if "alpha" in parts:
        lines["friction_angle"] = repr(friction_angle(parts.pop("alpha")))
    if lines["model"] in ("fluid", "druckerprager"):  # in the reference volumes never relax, and fluids carry tension unless it is limited
        lines["relaxation"] = "0"
    if lines["model"] == "fluid":
        lines.setdefault("tension_cutoff", "inf")
    if parts:
        raise Unsupported(f"material {kind}")
    return lines


def method(spec):
    """Options of the scheme."""
    basis, boundary, flip = spec["basis"], spec["boundary"], spec.get("flip", 1.0)
    lines = {"basis": BASES[basis], "update": spec["order"]}
    if basis in GIMP_UPDATES:
        lines["gimp_update"] = GIMP_UPDATES[basis]
    elif basis != "linear":
        if boundary not in ("extrap", "steffen"):
            raise Unsupported(f"splines with boundary {boundary}")
        lines["wall_basis"] = boundary
    affine = spec.get("affine", "none")
    if affine == "tpic" and basis in ("quadratic", "cubic") or affine not in ("none", "apic", "tpic"):
        raise Unsupported(f"{affine} with {basis}")
    lines["transfer"] = "flip" if affine == "none" else "apic"
    if affine != "none" and basis in ("quadratic", "cubic") and boundary == "extrap":
        lines["wall_inertia"] = "uniform"  # as that implementation has it
    if affine == "none":
        lines["flip"] = repr(float(flip))
    elif flip:
        raise Unsupported(f"{affine} with FLIP {flip}")
    return lines


def options(spec, title="reference", output_every=1e9, history_every=1e9):
    """The text of the options file."""
    if spec.get("damp") or spec.get("fixed_nodes") or spec.get("jdet") or spec.get("mass_cut"):
        raise Unsupported("damping, fixed nodes, jdet or mass_cut")
    dim, cells, h = spec["ndim"], np.array(spec["ncells"]), np.array(spec["h"], float)
    lower, consts = np.array(spec["origin"], float), spec.get("consts")
    lines = [f"-scene_title \"{title}\"", f"-dim {dim}", f"-grid_lower {numbers(lower)}",
             f"-grid_upper {numbers(lower + cells * h)}", f"-grid_cells {','.join(map(str, cells))}",
             f"-gravity {numbers(spec.get('gravity', [0] * dim))}", f"-dt_size {float(spec['dt'])!r}",
             f"-time_end {1e6 * float(spec['dt'])!r}", f"-time_max_steps {spec['steps']}",
             f"-output_every {float(output_every)!r}", f"-history_every {float(history_every)!r}"]
    lines += [f"-method_{name} {value}" for name, value in method(spec).items()]
    lines += [f"-bc_{face[0]}{'min' if face[1] == '-' else 'max'}_type {WALLS[kind]}" for face, kind in spec["walls"].items()]
    if spec.get("bodyforce"):
        lines.append(f"-acceleration \"{', '.join(expression(part, consts) for part in spec['bodyforce'])}\"")
    names = [f"b{k}" for k in range(len(spec["bodies"]))]
    lines += ["-materials " + ",".join("m" + name for name in names), "-bodies " + ",".join(names)]
    for name, body in zip(names, spec["bodies"]):
        ppc = h / body["b"]
        assert np.allclose(ppc, ppc.round(), rtol=1e-12, atol=0)
        lines.append(f"-material_m{name}_rho {float(body['rho'])!r}")
        lines += [f"-material_m{name}_{option} {value}" for option, value in material(body["material"]).items()]
        lines += [f"-body_{name}_{option} {value}" for option, value in shape(body).items()]
        lines += [f"-body_{name}_ppc {','.join(str(int(n)) for n in ppc.round())}",
                  f"-body_{name}_offset {numbers(body.get('offset', [0] * dim))}", f"-body_{name}_material m{name}",
                  f"-body_{name}_velocity \"{', '.join(expression(part, consts) for part in body['velocity'])}\""]
    return "\n".join(lines) + "\n"


def simulate(name, text, *extra):
    """Runs pebble on an options file of this text; its exit status and what it said."""
    path = check.write(name + ".opts", text)
    result = check.pebble("-options_file", path, "-output_dir", ".", "-output_name", name, "-check_law", "warn", "-check_parting", "warn", *extra, timeout=900)
    return result.status, result.said


def history(name):
    """{step: {column: value}}"""
    return {int(row["step"]): {key: float(value) for key, value in row.items()} for row in check.rows(name + ".csv")}


def state(file, step, dim):
    """Particles of a snapshot in the order of their ids, with the reference's components."""
    particles = file[f"step_{step:06d}/particles"]
    order = np.argsort(particles["id"][:])
    assert (particles["id"][:][order] == np.arange(len(order))).all()
    columns = {"x": range(dim), "v": range(dim), "F": F_PARTS[dim]}
    found = {key: particles[key][:][order][:, list(part)] for key, part in columns.items() if key in particles}
    found["stress"] = particles["stress"][:][order][:, SYMMETRIC]
    found["sig"], found["V"] = found["stress"][:, list(STRESS_PARTS[dim])], particles["volume"][:][order][:, None]
    found["body"] = particles["body"][:][order] if "body" in particles else np.zeros(len(order), int)
    return found


def snapshot(name, step, dim):
    with h5py.File(name + ".h5") as file:
        return state(file, step, dim)
