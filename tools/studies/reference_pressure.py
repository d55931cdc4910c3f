#!/usr/bin/env python3
"""The ring of options/pressure.opts along its radius alone: explicit finite elements of one dimension, from which every
method's error is measured. Writes docs/data/pressure_reference.csv, R and u in m at t = 1 s, the limit of two meshes.

The ring is symmetric, so u depends on R alone. With F_r = 1 + u', F_t = 1 + u/R, J = F_r F_t and
P_a = mu (F_a - 1/F_a) + lambda ln J/F_a the balance is rho R u_tt = (R P_r)' - P_t; the pressure p pushes the inner rim
with p (a + u(a)) per radian.
"""
import csv
import os

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
E, NU, RHO, A, B = 1e6, 0.3, 1000.0, 0.5, 1.0
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))


def load(t):
    return 1e4 * ((1 - np.cos(np.pi * t / 0.8)) / 2 if t < 0.8 else 1.0)


def ring(elements):
    R = np.linspace(A, B, elements + 1)
    h = (B - A) / elements
    middle = (R[1:] + R[:-1]) / 2
    m = np.zeros(elements + 1)
    m[1:] += RHO * middle * h / 2
    m[:-1] += RHO * middle * h / 2
    steps = int(np.ceil(1 / (0.4 * h / np.sqrt((LAMBDA + 2 * MU) / RHO))))
    dt = 1 / steps
    u, v, f = np.zeros_like(R), np.zeros_like(R), np.zeros_like(R)
    for k in range(steps):
        Fr, Ft = 1 + np.diff(u) / h, 1 + (u[1:] + u[:-1]) / 2 / middle
        log = LAMBDA * np.log(Fr * Ft)
        Pr, Pt = MU * (Fr - 1 / Fr) + log / Fr, MU * (Ft - 1 / Ft) + log / Ft
        f[:] = 0
        f[1:] -= Pr * middle + Pt * h / 2
        f[:-1] += Pr * middle - Pt * h / 2
        f[0] += load(k * dt) * (A + u[0])
        v += f / m * dt * (0.5 if k == 0 else 1)  # v belongs to the middles of steps
        u += v * dt
    return R, u


def main():
    R, coarse = ring(100)
    fine = ring(200)[1][::2]
    u = fine + (fine - coarse) / 3
    print(f"u({A}) = {u[0]:.6g} m, two meshes differ by {np.abs(fine - coarse).max() / u.max():.1e} of it")
    with open(os.path.join(ROOT, "docs", "data", "pressure_reference.csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([["R", "u"], *([f"{a:.4f}", f"{b:.9g}"] for a, b in zip(R, u))])


if __name__ == "__main__":
    main()
