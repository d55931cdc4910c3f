"""Words and numbers as the report prints them."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
import scenes  # noqa: E402 (after the path)

PROCESSES = (1, 2, 4, 8, 16, 32)
MANY = 1e5  # particles from which on a scene is large


def scene(name):
    return scenes.SCENES[name].title if name in scenes.SCENES else str(name)


def group(rows, key):
    out = {}
    for row in rows:
        out.setdefault(key(row), []).append(row)
    return out


def two(x):
    return "" if x is None or x == "" else f"{x:.2f}"


def three(x):
    return f"{x:.3g}"


def seconds(t):
    return f"{1e6 * t:.0f} µs" if t < 9.995e-4 else f"{1e3 * t:.3g} ms"


def thousands(n):
    return f"{int(n):,}".replace(",", " ")


def span(values):
    """The least and the largest, or the only one."""
    return " to ".join(dict.fromkeys((f"{min(values):.2f}", f"{max(values):.2f}")))


def inside(ratios, low, high):
    """How many of these ratios are inside the bounds."""
    return sum(low <= q <= high for q in ratios)


def names(words):
    """a, b and c."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last
