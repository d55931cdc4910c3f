"""What a series of numbers says, each of a run twice as fine as the one before: an order of convergence, where the
series goes, and how far it still is from there. And how the particles of a run are compared with those of a finer one.
Nothing here starts a run."""

import math

import numpy as np

FALLS = 1.1  # a series converges if its differences fall at least by this factor from run to run
BAND = 0.3  # an order is one if those of the last two pairs differ by this at most


def orders(values):
    """Of each pair, that from run k - 1 to run k; None where there is none."""
    found = [None]
    for before, now in zip(map(abs, values), map(abs, values[1:])):
        found.append(math.log2(before / now) if now > 0 and before > 0 and math.isfinite(now + before) else None)
    return found[: len(values)]


def agree(pairs):
    """Whether the last two pairs fall, and their orders differ by BAND at most."""
    if len(pairs) < 3 or None in pairs[-2:] or min(pairs[-2:]) < math.log2(FALLS):
        return False
    return abs(pairs[-1] - pairs[-2]) <= BAND


def falls(values):
    """Whether the last number is smaller than the one before by a tenth at least."""
    return len(values) > 1 and FALLS * abs(values[-1]) <= abs(values[-2])


def rest(differences):
    """How far differences still lead if they go on as they do, and by how much that is uncertain: the change that the
    pair before makes to it, or all of it where there is no such pair. None if they do not fall. (Richardson's
    extrapolation.)"""
    if not falls(differences):
        return None

    def after(pair, last):
        return 0.0 if pair[1] == 0 else last / (pair[0] / pair[1] - 1)

    last = differences[-1]
    far = after(differences[-2:], last)
    if len(differences) > 2 and falls(differences[:-1]):
        return far, abs(far - after(differences[-3:-1], last))
    return far, abs(far)


# ---- Particles


class Body:
    """The particles of a body: X and u [n, dim], where they started and their displacements, m, NaN for those that left
    the grid, which are not kept; m [n] or one for all: their masses, kg; places [n, dim]: of the lattice, m, X if None;
    thin: the spacing of their lattice on an axis on which there is one."""

    def __init__(self, X, u, m=1.0, places=None, thin=(1.0, 1.0, 1.0)):
        X, u = np.asarray(X, float), np.asarray(u, float)
        places = X if places is None else np.asarray(places, float)
        self.first, self.b = places.min(0), np.array([spacing(*axis) for axis in zip(places.T, thin)])
        there = ~np.isnan(u).any(1)
        self.X, self.u, self.m = X[there], u[there], np.broadcast_to(m, len(X))[there]
        self.at = np.rint((places[there] - self.first) / self.b).astype(int)  # numbers of their places


def spacing(coordinates, thin=1.0):
    """Of a lattice with these coordinates on an axis; thin if all are the same."""
    some = np.unique(coordinates)
    gaps = np.diff(some)
    gaps = gaps[gaps > 1e-6 * (some[-1] - some[0])]  # but for rounding
    return gaps.min() if len(gaps) else thin


def weights(t, points):
    """[points, n] of the polynomial through `points` (2, 4) neighbours, at t in [0,1) between the two in the middle."""
    nodes, x = np.arange(points), t + (1 if points == 4 else 0)
    return np.array([np.prod([(x - j) / (i - j) for j in nodes if j != i], axis=0) for i in nodes])


def step_to(coarse, fine, length, points):
    """[n, dim] mean of u_fine - u over the fine particles around each coarse one, times the sum of their weights; and
    that sum [n], 1 if all of them are there. length: of the periodic axes, infinite for others."""
    dim = coarse.X.shape[1]
    there = np.full(fine.at.max(0) + 1, -1)
    there[tuple(fine.at.T)] = np.arange(len(fine.at))
    place = (coarse.X - fine.first) / fine.b  # on the fine lattice, whose particles are at whole numbers
    left = np.floor(place + 1e-6).astype(int)
    t = np.maximum(0, place - left)
    t[t < 1e-6] = 0
    each = [weights(t[:, d], points) for d in range(dim)]
    total, sums = np.zeros(len(place)), np.zeros(coarse.u.shape)
    for corner in np.ndindex(*[points] * dim):
        at = left + np.array(corner) - (1 if points == 4 else 0)
        inside = ((at >= 0) & (at < there.shape)).all(1)
        q = np.where(inside, there[tuple(np.clip(at, 0, np.array(there.shape) - 1).T)], -1)
        weight = np.prod([each[d][corner[d]] for d in range(dim)], axis=0) * (q >= 0)
        step = fine.u[q] - coarse.u
        with np.errstate(invalid="ignore"):
            wrapped = step - length * np.floor(step / length + 0.5)
        step = np.where(np.isfinite(length), wrapped, step)  # across a periodic face if that is shorter
        total += weight
        sums += weight[:, None] * step
    return sums, total


def compare(coarse, fine, length):
    """(difference, size) of two runs, m: the root of the mass-weighted mean over the coarse particles of |u -
    u_fine|^2, where they started, and that of |u_fine|^2. coarse, fine: lists of Body. By cubic interpolation, linear
    at the edge of a body."""
    d2 = u2 = mass = 0.0
    for one, other in zip(coarse, fine):
        sums, total = step_to(one, other, length, 4)
        edge = abs(total - 1) > 1e-9
        if edge.any():
            linear, its = step_to(one, other, length, 2)
            sums[edge], total[edge] = linear[edge], its[edge]
        some = total >= 1e-9  # at a curved edge the finer lattice may have no particle here
        e = sums[some] / total[some, None]
        d2 += math.fsum(one.m[some] * (e**2).sum(1))
        u2 += math.fsum(one.m[some] * ((one.u[some] + e) ** 2).sum(1))
        mass += math.fsum(one.m[some])
    return math.sqrt(d2 / mass), math.sqrt(u2 / mass)
