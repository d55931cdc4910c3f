#!/usr/bin/env python3
"""The deepest place of the tip of options/cantilever.opts by spectral elements, from which every method's error is
measured: TIP of problems.py. Prints it for several meshes, and with them where the tip comes to rest and how deep it falls
under 10 m/s^2, which tools/trust needs (a few minutes).

Elements of order p with the points of Gauss and Lobatto have a diagonal mass, so that steps are explicit. The tip is the mean
of u_y over the end X = 4. The clamped corners are singular, so the error falls like h^1.4 and less than the order allows:
four meshes of order 4 give -2.38201 -2.38696 -2.38871 -2.38941, one of order 6 gives -2.38945; the limit is
-2.3899 +- 0.0003. Other finite elements, of tests/reference/tables.json, found -2.3887. The tip rests at -1.2754
+- 0.0002 (-1.27059 -1.27361 -1.27471 -1.27514, order 6: -1.27516). Under 10 m/s^2 it falls to -3.796 +- 0.004 (-3.78402
-3.79354 -3.79564; finer meshes are turned inside out at the clamped corners).
"""
import numpy as np
from numpy.polynomial import legendre

E, NU, RHO, GRAVITY, LENGTH, END = 1e6, 0.3, 1050.0, 3.5, 4, 2.0
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))


def lobatto(p):
    """Points, weights and the matrix of derivatives on -1 .. 1."""
    c = np.zeros(p + 1)
    c[p] = 1
    x = np.concatenate([[-1], np.sort(legendre.legroots(legendre.legder(c))), [1]])
    P = legendre.legval(x, c)
    D = np.array([[P[i] / P[j] / (x[i] - x[j]) if i != j else 0 for j in range(p + 1)] for i in range(p + 1)])
    D[0, 0], D[p, p] = -p * (p + 1) / 4, p * (p + 1) / 4
    return x, 2 / (p * (p + 1) * P**2), D


def beam(ny, p, gravity=GRAVITY, end_time=END, damping=0.0):
    """The deepest place with ny elements across the beam, and the last one; damping in 1/s: its body force is -damping v."""
    h, (x, w, D), a = 1 / ny, lobatto(p), np.arange(p + 1)
    columns, rows = LENGTH * ny * p + 1, ny * p + 1
    ex, ey = (e.ravel()[:, None, None] for e in np.meshgrid(np.arange(LENGTH * ny), np.arange(ny), indexing="ij"))
    nodes = (ex * p + a[:, None]) * rows + ey * p + a
    weights = np.outer(w, w) * h * h / 4
    m = np.bincount(nodes.ravel(), np.broadcast_to(RHO * weights, nodes.shape).ravel(), columns * rows)
    end = np.zeros(rows)
    for k in range(ny):
        end[k * p:k * p + p + 1] += w * h / 2
    steps = int(np.ceil(end_time / (0.4 * (x[1] - x[0]) * h / 2 / np.sqrt((LAMBDA + 2 * MU) / RHO))))
    dt, u = end_time / steps, np.zeros((2, columns * rows))
    v, f, tips = np.zeros_like(u), np.zeros_like(u), []
    for k in range(steps):
        U = u[:, nodes]
        Ux, Uy = np.einsum("ai,keib->keab", D, U) * 2 / h, np.einsum("bi,keai->keab", D, U) * 2 / h
        F = np.array([[1 + Ux[0], Uy[0]], [Ux[1], 1 + Uy[1]]])
        J = F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]
        P = (MU * F + (LAMBDA * np.log(J) - MU) / J * np.array([[F[1, 1], -F[1, 0]], [-F[0, 1], F[0, 0]]])) * weights * 2 / h
        for d in range(2):
            force = -np.einsum("ia,eib->eab", D, P[d, 0]) - np.einsum("ib,eai->eab", D, P[d, 1])
            f[d] = np.bincount(nodes.ravel(), force.ravel(), columns * rows)
        f[1] -= m * gravity
        v += (f / m - damping * v) * dt * (0.5 if k == 0 else 1)  # v belongs to the middles of steps
        v[:, :rows] = 0
        u += v * dt
        tips.append(end @ u[1, -rows:])
    return min(tips), tips[-1]


if __name__ == "__main__":
    for ny, p in (1, 4), (2, 4), (4, 4), (8, 4), (4, 6):
        print(f"{LENGTH * ny} x {ny} elements of order {p}: {beam(ny, p)[0]:.5f} m, "
              f"at rest {beam(ny, p, GRAVITY, 8.0, 4.0)[1]:.5f} m", flush=True)
    for ny in 1, 2, 4:
        print(f"{LENGTH * ny} x {ny} elements of order 4, 10 m/s^2: {beam(ny, 4, 10.0, 1.25)[0]:.5f} m", flush=True)
