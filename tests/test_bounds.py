"""The bounds of notes and warnings before the first step (src/advice/bounds.def), from both sides: a value before a
bound is not told of, and one beyond it is. The bounds are written here again.

usage: test_bounds.py PEBBLE SOURCE MPIEXEC
"""
import math
import re

import check

YEAR = 3.156e7
ELASTIC = {"model": "neohookean", "rho": 1000, "E": 1e6, "nu": 0.3}
SAND = {"model": "druckerprager", "rho": 2000, "E": 1e7, "nu": 0.3, "friction_angle": 30}
METAL = {"model": "vonmises", "rho": 2000, "E": 1e9, "nu": 0.3, "yield": 1e6}
SHOCK = {"model": "johnsoncook", "rho": 8960, "G": 47.7e9, "c0": 3940, "hugoniot_slope": 1.49, "gruneisen": 1.96,
         "yield": 9e7, "hardening": 2.92e8, "hardening_power": 0.31, "rate_factor": 0.025, "rate_reference": 1,
         "softening_power": 1.09, "melting": 1356, "temperature": 294, "specific_heat": 383}
APIC = {"method_basis": "bspline2", "method_update": "usl", "method_transfer": "apic"}


def dry(materials, body=None, **options):
    """What a dry run says of a row of bodies b0, b1, ..., each a cell or what `body` gives, and of its own material."""
    names, width = [f"m{k}" for k in range(len(materials))], len(materials) + 4
    given = {"dim": 2, "grid_lower": "0,0", "grid_upper": f"{width},4", "grid_cells": f"{width},4", "time_end": 1,
             "materials": ",".join(names), "bodies": ",".join("b" + name for name in names), "output_dir": "out",
             **options}
    for k, (name, material) in enumerate(zip(names, materials)):
        given.update({f"material_{name}_{key}": value for key, value in material.items()})
        shape = body or {"shape": "box", "lower": f"{k + 1},1", "upper": f"{k + 2},2"}
        given.update({f"body_b{name}_{key}": value for key, value in {**shape, "material": name}.items()})
    return check.pebble(*[word for key, value in given.items() for word in ("-" + key, str(value))], "-dry_run")


def both(what, said, pattern, before, beyond):
    """said(value) has a line of the pattern for the second value, and not for the first."""
    told = check.at_once(said, (before, beyond))
    check.need(told[0].status == 0, f"{what}: {told[0].said[-300:]}")
    found = [bool(re.search(pattern, run.said)) for run in told]
    words = [f"{value:.6g} {'is told of' if has else 'passes'}" for value, has in zip((before, beyond), found)]
    check.that(found == [False, True], f"{what}: {', '.join(words)}")


def materials():
    """A row is what is told, the material, its constant, a value before the bound, one beyond it. Two runs have all."""
    rows = [
        ("E 180 Pa: usual is", {**ELASTIC, "rho": 2000}, "E", 220, 180),
        ("E 10 Pa: usual is", {**ELASTIC, "E": 10}, "rho", 450, 550),
        ("kg/m^3: usual is", {**ELASTIC, "rho": 2}, "E", 1.0e6, 1.2e6),
        ("times -material", METAL, "yield", 1.1e14, 0.9e14),
        ("solids as dense have", {**ELASTIC, "E": 1e5}, "rho", 2250, 2750),
        ("degrees Celsius", SHOCK, "temperature", 77, 63),
        ("degrees Celsius", {**SHOCK, "temperature": 20}, "melting", 450, 550),
        ("is nearly incompressible", ELASTIC, "nu", 0.478, 0.482),
        ("presses it by", {**ELASTIC, "rho": 3e5}, "E", 3e5 / 0.45, 3e5 / 0.55)]
    for beyond in (0, 1):
        told = dry([{**material, key: values[beyond]} for _, material, key, *values in rows], gravity="0,-1", method_locking="none")
        check.need(told.status == 0, told.said[-500:])
        for k, (what, _, key, *values) in enumerate(rows):
            lines = [line for line in told.out.splitlines() if line.startswith(("note ", "warning ")) and what in line]
            found = [line for line in lines if re.search(rf"\bb?m{k}\b|_m{k}_", line)]
            check.that(len(found) == beyond, f"{key} = {values[beyond]:g}: {found or 'nothing'}")


def angles():
    """An angle is warned of where it acts as one more than 3 degrees larger."""
    told = dry([{**SAND, "friction_angle": angle} for angle in range(4, 24)])
    acts = [float(angle) for angle in re.findall(r"^friction +\w+ flows at (\S+) degrees", told.out, re.M)]
    found = re.findall(r"^warning +-material_m(\d+)_friction_angle \S+ fitted in triaxial", told.out, re.M)
    right = [str(k) for k, angle in enumerate(acts) if angle - (4 + k) > 3]
    check.that(len(acts) == 20 and found == right and 3 < len(right) < 17,
               f"of 20 angles {len(right)} act as one more than 3 degrees larger, and {len(found)} are warned of")


def gravity():
    light = [{**ELASTIC, "rho": 2, "E": 1e5}]
    for what, pattern, before, beyond in (("the earth's, upward: at least 9.7", "points upward", 9.65, 9.75),
                                          ("the earth's, upward: at most 10.01", "points upward", 10.02, 10),
                                          ("in SI units: at least 9.7", r"kg/m\^3: usual is", -9.65, -9.75),
                                          ("in SI units: below 9.9", r"kg/m\^3: usual is", -9.95, -9.85)):
        both(f"gravity, {what}", lambda g: dry(light, gravity=f"0,{g}"), pattern, before, beyond)


def runs():
    """Steps, the time that they take, and how far the lattice is from the origin."""
    steps, second = re.search(r"^predict +(\S+) steps of (\S+) s", dry([ELASTIC]).out, re.M).groups()
    steps, second = float(steps), float(second)
    both("steps of a run", lambda n: dry([ELASTIC], time_end=(n - 0.5) / steps), "the run makes only", 20, 19)
    both("years", lambda t: dry([ELASTIC], time_end=t * YEAR / steps / second), "the run would take about", 0.9, 1.1)
    both("steps of a fixed dt", lambda n: dry([ELASTIC], dt_size=1e-6, time_end=n * 2147.483647),
         "a run makes 2147483647", 0.999, 1.001)

    def far(shift):
        h, L = 1e-3, 4e-3
        x = math.sqrt(shift * L * h / 2 / 2.0 ** -52)  # shift = eps x^2 / (L b), with b = h/2
        body = {"shape": "box", "lower": f"{x - 2 * h},{h}", "upper": f"{x - h},{2 * h}", "ppc": "2,2"}
        return dry([ELASTIC], body, grid_lower=f"{x - L:.17g},0", grid_upper=f"{x:.17g},{L}", grid_cells="4,4")
    both("shift of the lattice", far, "are large beside cells", 0.9e-4, 1.1e-4)
    both("shift of the lattice, refused", far, "are too large for cells", 0.09, 0.11)


def points():
    def table(name, *lines):
        return dry([ELASTIC], {"shape": "file", "file": check.write(f"{name}.csv", ["x,y,volume", *lines])})

    def lattice(volume):
        return [f"{x},{y},{volume}" for x in (1.25, 1.75) for y in (1.25, 1.75)]
    both("particles at one place", lambda a: table(f"near{a}", *lattice(0.16), f"{1.25 + a * 0.4},1.25,0.16"),
         "lie at the place of another one", 0.275, 0.225)
    both("large particles", lambda a: table(f"large{a}", f"1.5,1.5,{a}"), "are larger than 2 cells", 1.9, 2.1)
    both("full cells", lambda a: table(f"full{a}", *lattice(a / 4)), "cells in which they lie", 1.005, 1.015)


def methods():
    both("stiffness of two bodies", lambda ratio: dry([ELASTIC, {**ELASTIC, "E": 1e6 * ratio}], **APIC),
         "those of the stiffest body", 900, 1100)
    both("short steps", lambda C: dry([ELASTIC], dt_cfl=C, **APIC), "in each step, however short", 0.055, 0.045)
    both("c dt/h beside |v|", lambda C: dry([ELASTIC], dt_size=C / (math.sqrt(1e3 * 0.7 / 1.3 / 0.4) + 20),
                                            body_bm0_velocity="20,0", **{**APIC, "method_update": "musl"}),
         r"h/\(c\+\|v\|\), above 1", 0.95, 1.05)

    def spin(part, end=0.1, transfer="flip", drift=0):
        """A cell that spins and grows: the square of its moment is this part of the most that it can be."""
        s = math.sqrt(1 / part - 1)
        velocity = f"{drift}+{s}*(x-1.5)-(y-1.5),(x-1.5)+{s}*(y-1.5)"
        return dry([ELASTIC], body_bm0_velocity=velocity, time_end=end, **{**APIC, "method_transfer": transfer})
    both("spin", spin, "slows down the spin", 0.225, 0.275)
    both("turns", lambda n: spin(1, 2 * math.pi * n, "aflip"), "in 100 turns", 18, 22)
    # of four particles, half a cell from each other, the mean square of the velocity by spin is 1/8
    both("spin beside drift", lambda part: spin(1, drift=math.sqrt((1 / part - 1) / 8)), "slows down the spin",
         0.9e-6, 1.1e-6)
    sand = dry([SAND], {"shape": "box", "lower": "0,0", "upper": "1,3"}, gravity="0,-9.81", bc_ymin_type="fixed",
               bc_xmin_type="slip")
    nu = sand.find(r"-method_damping_viscosity (\S+) \(docs")
    check.that(nu == f"{3.2e-3 * math.sqrt(9.81 * 27):.1g}", f"the viscosity that is advised for sand 3 m high: {nu}")


check.arguments(__doc__, 0)
for part in (materials, angles, gravity, runs, points, methods):
    part()
check.end()
