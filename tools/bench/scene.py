"""Describes the work that `make bench` times, once: Pebble's options and the particles of the peers are made from it.

The scene is a body of neo-Hookean material, in plane strain in 2-D, in the middle of a box that is about twice as wide. Its left
half moves at +2 m/s along x, its right half at -2 m/s, and all of it drifts along the diagonal by 5 % of a cell a step. With
the linear basis the halves move at 1e-3 m/s only: there usl is unstable when particles under stress cross cells, and the
work is the same. E = 1e6 Pa, nu = 0.3, rho = 1000 kg/m^3, dt = 0.2 h/c. The lattice of particles is shifted by a part of a
cell, so that particles cross cells at different steps along each axis. Domains of GIMP keep their size, as in the bare kernels.
"""
import json
import math
import sys
import time

import numpy as np

E, NU, RHO = 1e6, 0.3, 1000.0
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
SPEED = math.sqrt((LAMBDA + 2 * MU) / RHO)
HALF, HALF_LINEAR, DRIFT = 2.0, 1e-3, 0.05
OFFSET = (0.137, 0.071, 0.203)


class Scene:
    """`grid` is the size of the box and `body` that of the body, in cells along each axis."""

    def __init__(self, dim, particles, per_axis, drift=True):
        """per_axis: particles a cell along each axis. Without drift it is the body of examples/seed_serial.c (2-D)."""
        self.dim, self.per_axis = dim, tuple(per_axis)
        self.ppc = math.prod(self.per_axis)
        self.body = max(4, round((particles / self.ppc) ** (1 / dim)))
        if not drift:
            self.body -= self.body % 2
        # In 3-D the empty part of a box twice as wide would be 7/8 of its nodes.
        self.grid = 2 * self.body if dim < 3 else math.ceil(1.6 * self.body) + 4
        self.h = 1 / self.grid
        self.dt = 0.2 * self.h / SPEED
        start = (self.grid - self.body) // 2 if not drift else max(2, (self.grid - self.body) // 4)
        self.offset = [o * drift * self.h for o in OFFSET[:dim]]
        self.lower = [start * self.h + o for o in self.offset]
        self.upper = [x + self.body * self.h for x in self.lower]
        self.middle = self.lower[0] + 0.5 * self.body * self.h
        self.drift = DRIFT * self.h / self.dt / math.sqrt(dim) if drift else 0.0
        self.particles, self.volume = self.body**dim * self.ppc, self.h**dim / self.ppc
        # Steps until the body comes near the wall.
        self.room = int((self.grid - start - self.body - 3) * self.h / ((self.drift + HALF) * self.dt))

    def half(self, basis):
        """Speed of the halves, m/s."""
        return HALF_LINEAR if basis == "linear" and self.drift else HALF

    def options(self, basis, update, steps, half=None):
        def row(values):
            return ",".join(format(v, ".17g") for v in values)

        half = half or self.half(basis)
        first = f"{self.drift:.17g} + (x < {self.middle:.17g} ? {half} : -{half})"
        return "\n".join([
            f"-dim {self.dim}", f"-grid_lower {row([0] * self.dim)}", f"-grid_upper {row([1] * self.dim)}", f"-grid_cells {row([self.grid] * self.dim)}",
            "-materials m", "-material_m_model neohookean", f"-material_m_rho {RHO}", f"-material_m_E {E}",
            f"-material_m_nu {NU}", "-bodies b", "-body_b_shape box", f"-body_b_lower {row(self.lower)}",
            f"-body_b_upper {row(self.upper)}", f"-body_b_ppc {row(self.per_axis)}",
            f"-body_b_offset {row(self.offset)}", "-body_b_material m",
            f"-body_b_velocity \"{', '.join([first] + [format(self.drift, '.17g')] * (self.dim - 1))}\"",
            f"-method_basis {basis}", *(["-method_gimp_update none"] if basis == "gimp" else []),
            f"-method_update {update}", "-method_transfer flip", f"-dt_size {self.dt:.17g}",
            "-time_end 1e6", f"-time_max_steps {steps}", "-history_every 1e9", ""])  # fmt: skip

    def arrays(self, half=HALF):
        """Arrays x and v [N, dim] of the particles, in the order of cells (the last axis runs fastest)."""
        axes = [(np.arange(self.body * p) + 0.5) / p + low * self.grid for p, low in zip(self.per_axis, self.lower)]
        x = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, self.dim)
        cell = np.zeros(len(x), np.int64)
        for axis in range(self.dim):
            cell = cell * self.grid + np.floor(x[:, axis] - 0.5).astype(np.int64)
        x = x[np.argsort(cell, kind="stable")] * self.h
        v = np.full_like(x, self.drift)
        v[:, 0] += np.where(x[:, 0] < self.middle, half, -half)
        return x, v


def serve(make):
    """Of the scripts of the peers, peer_<name>.py SCHEME DIM PARTICLES PER_AXIS...: make(scene, scheme) returns reset(x, v),
    steps(n) and state() -> v, grid_mass(). A peer prints a line when it is compiled and ready. Then, for each line "STEPS" on
    standard input, it starts the scene anew, runs one step that is not timed, times the steps after it, and prints a line of
    JSON. So a peer compiles once and waits while others run."""
    scheme, dim, particles, *per_axis = sys.argv[1:]
    scene = Scene(int(dim), float(particles), map(int, per_axis))
    x, v = scene.arrays()
    mass = RHO * scene.volume
    reset, steps, state, grid_mass = make(scene, scheme)
    reset(x, v)
    steps(2)
    print(json.dumps({"particles": len(x)}), flush=True)
    for line in sys.stdin:
        n = int(line)
        reset(x, v)
        steps(1)
        start = time.perf_counter()
        steps(n - 1)
        seconds = time.perf_counter() - start
        new = state()
        print(json.dumps({
            "ns": 1e9 * seconds / max(n - 1, 1) / len(x), "kinetic": float(0.5 * mass * np.sum(new * new)),
            "mass": mass * len(x), "grid_mass": grid_mass(), "momentum": (mass * new.sum(axis=0)).tolist(),
            "momentum_start": (mass * v.sum(axis=0)).tolist()}), flush=True)  # fmt: skip
