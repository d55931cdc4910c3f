"""The largest stable steps of methods.

A probe is an elastic body in an empty periodic grid, in units in which cell size, density and wave speed are 1, with
velocities disturbed by 1e-6, so that the speed of waves is constant. A run has a fixed C = c dt/h. The strain energy
of a stable run stays below the energy of the disturbance, or nearly so; a run in which it exceeds LIMIT times that, or
which stops, is unstable; how fast its strain energy grows is told beside, as a run of other length is unstable from another
C on. Growth need not be monotone in C: C rises from the smallest step, and the first that is
unstable ends the search."""

import concurrent.futures
import csv
import math
import os
import time
from typing import NamedTuple

import numpy as np
import pebble_mpm as pebble

from . import methods, scene

LIMIT = 10.0  # largest strain energy of a stable run, in energies of the disturbance
DISTURBANCE = 1e-6  # of the velocity, in wave speeds
LADDER = [0.1 * k for k in range(1, 11)] + [1 + 0.2 * k for k in range(1, 9)]  # the C that are tried
MARGIN = 4  # empty cells on each side of a body
# Drift of a body that crosses cells, in wave speeds. Where the time from one crossing to the next, h/v, is half the
# period of a mode
# of the body, the crossings can feed the mode. A body of 32 cells has modes next to all of these.
SPEEDS = (0.08, 0.13, 0.1875, 0.5)
DIRECTION = (1, 0.7, 0.45)
NUMBERS = {"flip": 1.0, "damping_rate": 0.0, "affine_strain": 0.0, "order": 2}  # of a method, with what is usual
COLUMNS = (
    "basis,update,transfer,flip,damping_rate,affine_strain,order,ppc,rest,rest_unstable,rest_growth,crossing,crossing_unstable,"
    "crossing_speed,crossing_growth,block,block_unstable,block_speed,block_growth,disk,disk_unstable,disk_growth,table_rest,table_crossing,dt_cfl,margin,dim,steps,seconds,key"
).split(",")


class Probe(NamedTuple):
    """A box of `cells` on each axis, or a disk or ball of that diameter, which drifts with one of SPEEDS or, at rest, is
    at another place in its cells. A run makes --steps / share steps."""

    name: str
    dim: int
    cells: int
    share: int
    variants: range
    crossing: bool
    round: bool = False

    def scene(self, variant, C, steps, ppc):
        """The options of a run."""
        dim, side = self.dim, self.cells + 2 * MARGIN
        nu = 0.3 if dim > 1 else 0.0
        v, shift = (SPEEDS[variant], 0.0) if self.crossing else (0.0, 0.3 * variant)
        low = MARGIN + shift
        wave = (
            "6.62*x" + "+4.34*y" * (dim > 1) + "+3.1*z" * (dim > 2)
        )  # of about two particles, beside the longest of the body
        middle = low + self.cells / 2
        velocity = ",".join(
            f"{v * DIRECTION[d]:.17g}+{DISTURBANCE:g}*(sin(pi*({x}-{middle:g})/{self.cells:g})+cos({wave}+{d:g}))"
            for d, x in enumerate("xyz"[:dim])
        )
        faces = {f"bc_{axis}{end}_type": "periodic" for axis in "xyz"[:dim] for end in ("min", "max")}
        span = max(C, 1e-3) * max(1, steps // self.share)
        box = {"body_b_shape": "box", "body_b_lower": [low] * dim, "body_b_upper": [low + self.cells] * dim}
        disk = {"body_b_shape": "sphere", "body_b_center": [middle] * dim, "body_b_radius": 0.5 * self.cells}
        return faces | (disk if self.round else box) | {
            "dim": dim,
            "grid_lower": [0.0] * dim,
            "grid_upper": [float(side)] * dim,
            "grid_cells": [side] * dim,
            "materials": "m",
            "material_m_model": "elastic",
            "material_m_rho": 1,
            "material_m_E": (1 + nu) * (1 - 2 * nu) / (1 - nu),
            "material_m_nu": nu,
            "bodies": "b",
            "body_b_material": "m",
            "body_b_offset": [shift] * dim,
            "body_b_ppc": [ppc] * dim,
            "body_b_velocity": velocity,
            "dt_size": C or None,
            "time_end": span,
            "history_every": span / 100,
            "output_format": "none",
        }


def probes(dim, total=False):
    flat = dim < 3
    if total:  # no particle crosses a cell; at a rim particles are cut
        side, share, dim = (12, 8, 2) if flat else (6, 40, 3)
        return [
            Probe("rest", 1, 16, 4, range(2), False),
            Probe("block", dim, side, share, range(2), False),
            Probe("disk", dim, side, share, range(2), False, True),
        ]
    return [
        Probe("rest", 1 if flat else 3, 16 if flat else 6, 4 if flat else 16, range(2), False),
        Probe("crossing", 1, 32, 1, range(len(SPEEDS)), True),
        Probe("block", 2 if flat else 3, 12 if flat else 6, 8 if flat else 40, range(1, 3), True),
    ]


def search(stable_at):
    """(largest stable C, first unstable C or None) by the ladder, then half of its last step. stable_at(C): is it
    stable?"""
    stable = 0.0
    for C in LADDER:
        if stable_at(C):
            stable = C
            continue
        middle = (stable + C) / 2
        return (middle, C) if stable_at(middle) else (stable, middle)
    return stable, None


def growth(step, energy, floor):
    """How often the energy grows e-fold in 1,000 steps: the mean from where it last was below the floor to its first
    largest value; NaN if that is one row or none."""
    end = int(np.argmax(energy))
    below = np.flatnonzero(energy[:end] <= floor)
    start = below[-1] if below.size else 0
    if energy[start] <= 0 or step[end] <= step[start]:
        return math.nan
    return 1000 * math.log(energy[end] / energy[start]) / (step[end] - step[start])


def cells(number, form="g"):
    return "" if number is None else format(number, form)


class Method:
    """Basis and update, and a word of --transfer, which may have the share of FLIP or the order after a colon. Numbers
    are those of the scene if its transfer is the same, else those that the options give, or what is usual."""

    def __init__(self, basis, update, word, facts, options):
        self.basis, self.update = basis, update
        self.transfer, colon, number = word.partition(":")
        own = {"flip": facts.flip, "damping_rate": facts.rate, "affine_strain": facts.strain, "order": facts.order}
        value = {name: float(options.get(f"method_{name}") or usual) for name, usual in NUMBERS.items()}
        if self.transfer == facts.transfer:
            value = {name: usual if own[name] is None else own[name] for name, usual in NUMBERS.items()}
        if colon:
            value["order" if self.transfer in methods.ORDERS else "flip"] = float(number)
            value["damping_rate"] = 0.0
        takes = {
            "flip": self.transfer in methods.FLIPS and not value["damping_rate"] > 0,
            "damping_rate": self.transfer in methods.FLIPS and value["damping_rate"] > 0,
            "affine_strain": self.transfer == "aflip",
            "order": self.transfer in methods.ORDERS,
        }
        self.numbers = {name: value[name] if takes[name] else None for name in NUMBERS}
        if self.numbers["order"] is not None:
            self.numbers["order"] = int(self.numbers["order"])

    @property
    def name(self):
        return " ".join(
            [
                self.basis,
                self.update,
                self.transfer,
                *(
                    f"{name} {value:g}"
                    for name, value in self.numbers.items()
                    if value is not None and value != NUMBERS[name]
                ),
            ]
        )

    @property
    def options(self):
        stretch = self.basis == "gimp_stretch"
        return {
            "method_basis": "gimp" if stretch else self.basis,
            "method_gimp_update": "stretch" if stretch else None,
            "method_update": self.update,
            "method_transfer": self.transfer,
            **{f"method_{name}": value for name, value in self.numbers.items()},
        }

    def bounds(self):
        return methods.bounds(
            self.basis.removesuffix("_stretch"),
            self.update,
            self.transfer,
            self.numbers["flip"],
            self.numbers["damping_rate"],
            self.numbers["affine_strain"],
        )


class Total(Method):
    """A basis in the total frame, with the mass of the scene."""

    def __init__(self, basis, facts):
        self.basis, self.update, self.transfer = basis, facts.update, facts.transfer
        self.numbers = dict.fromkeys(NUMBERS) | {"order": facts.order}

    @property
    def name(self):
        return f"{self.basis} total mass_order {self.numbers['order']}"

    @property
    def options(self):
        return {"method_frame": "total", "method_basis": self.basis, "method_mass_order": self.numbers["order"]}

    def bounds(self):
        return (methods.total()[self.basis][self.numbers["order"] - 1],) * 2


class Stability:
    def __init__(self, study):
        self.study, words, facts = study, study.words, study.facts
        self.steps, self.dim = words.steps, facts.dim
        self.probes = probes(facts.dim, facts.total)
        self.ppc = scene.per_cell(study.options, facts, study.processes)[0][0]
        own = {
            "basis": "gimp_stretch" if facts.stretched else facts.basis,
            "update": facts.update,
            "transfer": facts.transfer,
        }
        if facts.total:
            for name in ("update", "transfer"):
                if getattr(words, name):
                    raise scene.Refused(f"--{name} does not apply: the scene is in the total frame, which has none")
            bases = methods.read_list("basis", words.basis or facts.basis, methods.names("method_basis"))
            self.methods = [Total(basis, facts) for basis in bases]
        lists = {} if facts.total else {
            "basis": methods.read_list("basis", words.basis or own["basis"], methods.bases()),
            "update": methods.read_list("update", words.update or own["update"], methods.names("method_update")),
            "transfer": methods.read_transfers(words.transfer or own["transfer"]),
        }
        self.methods = self.methods if facts.total else [
            Method(basis, update, transfer, facts, study.options)
            for basis in lists["basis"]
            for update in lists["update"]
            for transfer in lists["transfer"]
        ]
        self.place = {name: value for name, value in study.options.items() if name.startswith(("parallel_", "pool_"))}
        self.path = study.path("_stability.csv")
        self.jobs = max(1, (os.cpu_count() or 1) // study.processes)

    def grown(self, probe, variant, C, method):
        """(largest strain energy of a run in energies of the disturbance, infinite if the run stopped; its growth)."""
        options = probe.scene(variant, C, self.steps, self.ppc) | method.options | self.place
        result = scene.run(options, self.study.processes)
        if result.status == pebble.REFUSED:
            raise scene.Refused(result.line)
        strain, mass = result.history["strain_energy"], result.history["mass"][0]
        own = 0.5 * mass * probe.dim * DISTURBANCE**2
        finite = np.isfinite(strain)
        rate = growth(result.history["step"][finite], strain[finite], LIMIT * own)
        return math.inf if result.status or not finite[-1] else np.nanmax(strain) / own, rate

    def find(self, probe, method, pool):
        """(largest stable C, first unstable C or None, its drift, its growth) of a method: at each C all variants, first
        the one that was unstable last."""
        first, fastest = probe.variants[0], math.nan

        def stable_at(C):
            nonlocal first, fastest
            order = [
                probe.variants[(first - probe.variants[0] + k) % len(probe.variants)]
                for k in range(len(probe.variants))
            ]
            for variant, (grown, rate) in zip(order, pool.map(lambda variant: self.grown(probe, variant, C, method), order)):
                if not grown <= LIMIT:
                    first, fastest = variant, rate
                    return False
            return True

        return *search(stable_at), SPEEDS[first] if probe.crossing else None, fastest

    def measure(self, method, facts, pool):
        """The row of a method."""
        start = time.monotonic()
        found = {probe.name: self.find(probe, method, pool) for probe in self.probes}
        row = {
            "basis": method.basis,
            "update": method.update,
            "transfer": method.transfer,
            "ppc": self.ppc,
            "dim": max(2, self.dim),
            "steps": self.steps,
        }
        row |= {name: cells(value, ".6g") for name, value in method.numbers.items()}
        for name, (stable, unstable, speed, rate) in found.items():
            row |= {
                name: f"{stable:.4g}",
                f"{name}_unstable": cells(unstable, ".4g"),
                f"{name}_speed": cells(speed if unstable else None, ".4g"),
                f"{name}_growth": cells(rate if unstable and math.isfinite(rate) else None, ".3g"),
            }
        rest, crossing = method.bounds()
        least = min(stable for stable, *_ in found.values())
        return row | {
            "table_rest": f"{rest:.4g}",
            "table_crossing": f"{crossing:.4g}",
            "dt_cfl": f"{facts.cfl:.4g}",
            "margin": f"{least / facts.cfl:.3g}",
            "seconds": f"{time.monotonic() - start:.3g}",
        }

    def print_head(self):
        say = self.study.say
        say(
            f"study      stability: the largest c dt/h at which a disturbance of {DISTURBANCE:g} c does not grow "
            f"{LIMIT:g}-fold in energy"
        )
        for probe in self.probes:
            drift = f", drifts at {' '.join(f'{SPEEDS[v]:g}' for v in probe.variants)} c" if probe.crossing else ""
            say(
                f"           {'at rest' if probe.name == 'rest' else probe.name:<9} {probe.dim}-D, {probe.cells} "
                f"cells an axis, {max(1, self.steps // probe.share)} steps{drift}"
            )
        if not self.study.dry:
            say(
                f"{'method':<34}"
                + "".join(f" {'at rest' if probe.name == 'rest' else probe.name:>8}" for probe in self.probes)
                + f" {'by table':>10} {'dt_cfl':>7} "
                f"{'margin':>7} {'seconds':>8}"
            )

    def print_row(self, method, row):
        found = [probe.name for probe in self.probes]
        limits = "".join(
            f" {row[name] if row[name + '_unstable'] else '>=' + row[name]:>8}"
            for name in found
        )
        table = f"{float(row['table_rest']):.3g}, {float(row['table_crossing']):.3g}"
        self.study.say(
            f"{method.name:<34}{limits} {table:>10} {float(row['dt_cfl']):7.3g} {float(row['margin']):7.2g} "
            f"{float(row['seconds']):8.3g}"
        )
        grows = [f"{name} {row[name + '_growth']} at {row[name + '_unstable']}" for name in found if row.get(name + "_growth")]
        if grows:
            self.study.say(f"           grows e-fold in 1,000 steps, times: {', '.join(grows)}")

    def write(self, rows):
        with open(self.path + ".new", "w", newline="", encoding="utf-8") as file:
            out = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
            out.writeheader()
            out.writerows(rows)
        os.replace(self.path + ".new", self.path)

    def run(self):
        study, rows, taken = self.study, [], 0
        self.print_head()
        before = scene.read_table(self.path, COLUMNS[:3])
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            for method in self.methods:
                asked = self.probes[0].scene(0, 0, self.steps, self.ppc) | method.options | self.place
                facts = scene.Facts(
                    {name: pebble.word(value) for name, value in asked.items() if value is not None}, study.processes
                )
                key = scene.digits(method.options, self.steps, self.ppc, max(2, self.dim))
                taken += not facts.refused
                if facts.refused or study.dry:
                    study.say(f"{method.name:<34} {facts.refused or 'valid'}")
                    continue
                row = before.get(key) or self.measure(method, facts, pool) | {"key": key}
                rows.append(row)
                self.print_row(method, row)
                self.write(rows)
        if study.dry:
            study.say("dry run    the study is valid; no step was made")
        elif rows:
            study.say(f"results    {self.path}")
        if study.facts.viscosity:
            study.say(
                "note       -method_damping_viscosity is left out: what it does depends on the cells of the scene"
            )
        if not taken:
            study.complain("the program takes none of these methods; the lines above say why")
            return 2
        return 0
