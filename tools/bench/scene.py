"""Describes the work that `make bench` times, once: Pebble's options and the particles of the peers are made from it.

The scene is a body of neo-Hookean material, in plane strain in 2-D, in the middle of a box that is about twice as wide. Its left
half moves at +2 m/s along x, its right half at -2 m/s, and all of it drifts along the diagonal by 5 % of a cell a step. With
the linear basis the halves move at 1e-3 m/s only: there usl is unstable when particles under stress cross cells, and the
work is the same. E = 1e6 Pa, nu = 0.3, rho = 1000 kg/m^3, dt = 0.2 h/c. The lattice of particles is shifted by a part of a
cell, so that particles cross cells at different steps along each axis. Domains of GIMP keep their size, as in the bare kernels.
"""
import math

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
        self.start = (self.grid - self.body) // 2 if not drift else max(2, (self.grid - self.body) // 4)
        self.offset = [o if drift else 0.0 for o in OFFSET[:dim]]
        self.drift = DRIFT * self.h / self.dt / math.sqrt(dim) if drift else 0.0
        self.particles = self.body ** dim * self.ppc

    def lower(self):
        return [(self.start + o) * self.h for o in self.offset]

    def upper(self):
        return [x + self.body * self.h for x in self.lower()]

    def middle(self):
        return self.lower()[0] + 0.5 * self.body * self.h

    def room(self):
        """Steps until the body comes near the wall."""
        left = self.grid - self.start - self.body - 3
        speed = (self.drift + HALF) * self.dt / self.h
        return int(left / speed)

    def half(self, basis):
        """Speed of the halves, m/s."""
        return HALF_LINEAR if basis == "linear" and self.drift else HALF

    def bare(self, basis, steps, half=None):
        """The scene as arguments of bare.c."""
        values = dict(dim=self.dim, basis=basis, grid=self.grid, body=self.body, per_axis=self.per_axis[0], start=self.start,
                      drift=self.drift, half=half or self.half(basis), E=E, nu=NU, rho=RHO, dt=self.dt, steps=steps)
        values.update((f"offset_{d}", o) for d, o in enumerate(self.offset))
        return [f"{name}={format(v, '.17g') if isinstance(v, float) else v}" for name, v in values.items()]

    def options(self, basis, update, steps, half=None):
        def row(values):
            return ",".join(format(v, ".17g") for v in values)

        def same(value):
            return ",".join([str(value)] * self.dim)

        half = half or self.half(basis)
        first = f"{self.drift:.17g} + (x < {self.middle():.17g} ? {half} : -{half})"
        return "\n".join([
            f"-dim {self.dim}", f"-grid_lower {same(0)}", f"-grid_upper {same(1)}", f"-grid_cells {same(self.grid)}",
            "-materials m", "-material_m_model neohookean", f"-material_m_rho {RHO}", f"-material_m_E {E}",
            f"-material_m_nu {NU}", "-bodies b", "-body_b_shape box", f"-body_b_lower {row(self.lower())}",
            f"-body_b_upper {row(self.upper())}", f"-body_b_ppc {','.join(map(str, self.per_axis))}",
            f"-body_b_offset {row(o * self.h for o in self.offset)}", "-body_b_material m",
            f"-body_b_velocity \"{', '.join([first] + [format(self.drift, '.17g')] * (self.dim - 1))}\"",
            f"-method_basis {basis}", *(["-method_gimp_update none"] if basis == "gimp" else []),
            f"-method_update {update}", "-method_transfer flip", f"-dt_size {self.dt:.17g}",
            "-time_end 1e6", f"-time_max_steps {steps}", "-history_every 1e9", ""])

    def arrays(self):
        """NumPy arrays x and v [N, dim] of the particles, in the order of cells (the last axis runs fastest), and a particle's volume."""
        import numpy as np
        axes = [(np.arange(self.body * p) + 0.5) / p + self.start + o for p, o in zip(self.per_axis, self.offset)]
        x = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, self.dim)
        cell = np.zeros(len(x), np.int64)
        for axis in range(self.dim):
            cell = cell * self.grid + np.floor(x[:, axis] - 0.5).astype(np.int64)
        x = x[np.argsort(cell, kind="stable")] * self.h
        v = np.full_like(x, self.drift)
        v[:, 0] += np.where(x[:, 0] < self.middle(), HALF, -HALF)
        return x, v, self.h ** self.dim / self.ppc
