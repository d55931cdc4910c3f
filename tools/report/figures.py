"""Draws the figures of docs/report.md. Colours show the strategy, marks and lines the class of the evidence."""

import math
import os
import sys

try:
    import matplotlib
except ModuleNotFoundError as missing:
    sys.exit(f"report.py: {missing}; run it by `make report`")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
from plots import COLOURS  # noqa: E402

STYLE = {
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.frameon": False,
    "savefig.dpi": 130,
    "mathtext.fontset": "cm",
    "lines.linewidth": 1.2,
    "lines.markersize": 4.5,
}
plt.rcParams.update(STYLE)


def mark(kind, colour):
    return {
        "measured": dict(marker="s", color=colour, linestyle="none", markersize=6),
        "critical path": dict(marker="o", color=colour, markerfacecolor="white", linestyle=":", linewidth=0.7),
        "injected simulation": dict(marker="x", color=colour, linestyle=":", linewidth=0.7),
        "emulated simulation": dict(marker="+", markersize=7, color=colour, linestyle=":", linewidth=0.7),
        "closed form": dict(color=colour),
    }[kind]


def ticks(axes, values):
    axes.set_xticks(values, [f"{v:,}".replace(",", " ") if v < 1e5 else f"$10^{{{len(str(v)) - 1}}}$" for v in values])
    axes.minorticks_off()


def finish(figure, path):
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)
    print(f"  {os.path.relpath(path)}")


def efficiency(path, titles, panels, columns=2):
    """panels: a list of {strategy: [(class, [(processes, efficiency)])]}."""
    rows = math.ceil(len(panels) / columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(7.6, 1 + 2.4 * rows), sharey=True, layout="constrained", squeeze=False
    )
    for at, title, panel in zip(axes.flat, titles, panels):
        at.set_xscale("log", base=2)
        for label, curves in panel.items():
            for kind, points in curves:
                at.plot(*zip(*sorted(points)), **mark(kind, COLOURS[label]))
        most = max(p for curves in panel.values() for _, points in curves for p, _ in points)
        ticks(at, [v for v in ((1, 8, 64, 1024, 32768, 1000000) if most > 64 else (1, 2, 4, 8, 16, 32)) if v <= most])
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=title, xlabel="processes")
    for at in axes[:, 0]:
        at.set(ylabel="efficiency", ylim=(0, 1.15))
    for at in axes.flat[len(panels) :]:
        at.axis("off")
    used = {(label, kind) for panel in panels for label, curves in panel.items() for kind, _ in curves}
    handles = [
        plt.Rectangle((0, 0), 1, 1, color=colour, label=label)
        for label, colour in COLOURS.items()
        if any(label == u for u, _ in used)
    ]
    kinds = ("measured", "critical path", "injected simulation", "emulated simulation", "closed form")
    handles += [
        plt.Line2D([], [], label=kind, **mark(kind, "0.3")) for kind in kinds if any(kind == u for _, u in used)
    ]
    figure.legend(handles=handles, fontsize=8, loc="outside lower center", ncols=4)
    finish(figure, path)


def pool(path, panels):
    """panels: {title: {(strategy, processes): [(extra ns, speed-up)]}}"""
    figure, axes = plt.subplots(1, len(panels), figsize=(7.6, 3.2), sharey=True, layout="constrained", squeeze=False)
    for at, (title, lines) in zip(axes[0], panels.items()):
        for (label, p), points in lines.items():
            at.loglog(
                *zip(*points), color=COLOURS[label], label=f"{label}; {p} processes", linestyle="--" if p == 8 else "-"
            )
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=title, xlabel="cost added to the law, ns a particle and step")
        at.minorticks_off()
    axes[0][0].set_ylabel("speed-up (closed form)")
    axes[0][0].set_yticks((1, 2, 4, 8, 16, 32), map(str, (1, 2, 4, 8, 16, 32)))
    axes[0][0].minorticks_off()  # those of the new ticks
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    finish(figure, path)


def messages(path, imbalance, size):
    """imbalance, size: {(scene, strategy): [(processes, value)]}, in two panels."""
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.6), layout="constrained")
    shapes = dict(zip(dict.fromkeys(scene for scene, _ in size), "os^DvP"))
    titles = "imbalance: largest over mean number of particles", "bytes sent, a particle and step"
    for at, title, panel in zip(axes, titles, (imbalance, size)):
        for (scene, strategy), points in panel.items():
            style = dict(color=COLOURS[strategy], marker=shapes[scene], markerfacecolor="white", linewidth=0.7)
            at.semilogx(*zip(*sorted(points)), base=2, **style)
        at.set(title=title, xlabel="processes")
        ticks(at, sorted({p for points in panel.values() for p, _ in points}))
    axes[1].set_yscale("log")
    strategies = dict.fromkeys(strategy for _, strategy in size)
    handles = [plt.Rectangle((0, 0), 1, 1, color=COLOURS[s], label=s) for s in strategies]
    handles += [
        plt.Line2D([], [], color="0.3", marker=m, markerfacecolor="white", linewidth=0, label=s)
        for s, m in shapes.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8, columnspacing=1)
    finish(figure, path)
