"""Right values of the starter problems: closed forms, and small integrations where there is none.
docs/materials.md has the laws."""
import math

import numpy as np


def root(f, low, high):
    """Of an f that rises or falls throughout and changes sign in between, by bisection."""
    sign = f(low) > 0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if (f(middle) > 0) == sign else (low, middle)
    return middle


def pulled(load, nu, sides):
    """Stretch of a neo-Hookean bar under a dead nominal stress of load x E. `sides` of its two directions across are
    free, the stretch along the others is 1. tau = lambda ln J + mu (b - 1) is 0 across free sides; P = tau/s along."""
    mu, lam = 1 / (2 * (1 + nu)), nu / ((1 + nu) * (1 - 2 * nu))

    def across(s):
        return root(lambda a: lam * math.log(s * a**sides) + mu * (a * a - 1), 1e-3, 10) if sides else 1

    def stress(s):
        return (lam * math.log(s * across(s)**sides) + mu * (s * s - 1)) / s
    return root(lambda s: stress(s) - load, 1, 4)


def hanging(weight, at):
    """How far below its clamp a place of a hanging bar is at rest, `at` above the free end before. Length 1, nu = 0,
    weight in E: the part below X loads the place X with weight X, and s - 1/s = 2 weight X."""
    X = np.linspace(at, 1, 2001)
    return float(np.trapezoid(weight * X + np.sqrt((weight * X)**2 + 1), X))


def hencky_pulled(load, nu):
    """Strain s - 1 in plane strain of a bar of the plastic laws, still elastic: load E = E ln(s)/(1 - nu^2)/s."""
    return root(lambda s: math.log(s) / (1 - nu * nu) / s - load, 1, 1.5) - 1


def column(weight, at):
    """Height at rest of the place `at` of a column of the plastic laws, still elastic, between smooth walls, both over
    its height H: ln(s)/s = -weight (1 - X), weight = rho g H/M, M = E (1 - nu)/((1 + nu)(1 - 2 nu))."""
    X = np.linspace(0, at, 401)
    return float(np.trapezoid([root(lambda s: math.log(s) / s + weight * (1 - x), 0.2, 1) for x in X], X))


class Hertz:
    """An elastic ball on a rigid wall: F = 4/3 E/(1 - nu^2) sqrt(R) d^1.5 (Johnson, Contact Mechanics, 11.4)."""

    def __init__(self, R, E, nu, rho, v):
        stiff, mass = E / (1 - nu * nu), 4 / 3 * math.pi * R**3 * rho
        deepest = (15 * mass * v * v / (16 * stiff * math.sqrt(R)))**0.4
        self.time, self.peak = 2.9432751 * deepest / v, 4 / 3 * stiff * math.sqrt(R) * deepest**1.5
        # The part of that time in which the impulse rises from 5 to 95 %, by the equation d'' = -5/4 d^1.5.
        d, u, dt, impulse = 0.0, 1.0, 1e-4, [0.0]
        while d >= 0:
            u -= 1.25 * d**1.5 * dt
            d += u * dt
            impulse.append(impulse[-1] + max(d, 0)**1.5)
        low, high = np.searchsorted(np.array(impulse) / impulse[-1], (0.05, 0.95))
        self.share = float(high - low) / len(impulse)


def sloshing(g, length, depth):
    """Period of the first small waves in a tank: w^2 = g k tanh(k depth), k = pi/length (Lamb, Hydrodynamics)."""
    k = math.pi / length
    return 2 * math.pi / math.sqrt(g * k * math.tanh(k * depth))
