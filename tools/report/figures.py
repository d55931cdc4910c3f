"""Draws the figures of docs/report.md from docs/data. Colours show the strategy, marks and lines the class of the evidence."""

import os
import sys
from collections import defaultdict
from dataclasses import replace

import matplotlib

matplotlib.use("Agg")
import data  # noqa: E402 (after the choice of the backend)
import matplotlib.pyplot as plt  # noqa: E402
from data import BOXES, DIRECT, POOL, SCENES, title  # noqa: E402

sys.path.insert(0, os.path.join(data.ROOT, "tools", "scaling"))
import plots  # noqa: E402

MARKS = {
    "measured": dict(marker="s", linestyle="none", markersize=6),
    "critical path": dict(marker="o", markerfacecolor="white", linestyle=":", linewidth=0.7),
    "injected simulation": dict(marker="x", linestyle=":", linewidth=0.7),
    "emulated simulation": dict(marker="+", markersize=7, linestyle=":", linewidth=0.7),
    "closed form": dict(linestyle="-"),
}
STYLE = plots.STYLE | {"font.size": 9.5, "mathtext.fontset": "cm", "lines.linewidth": 1.2, "lines.markersize": 4.5}


def ticks(axes, values):
    axes.set_xticks(values, [f"{v:,}".replace(",", " ") if v < 1e5 else f"$10^{{{len(str(v)) - 1}}}$" for v in values])
    axes.minorticks_off()


def legend(figure, marks, ways):
    handles = [plt.Rectangle((0, 0), 1, 1, color=plots.COLOURS[w], label=w) for w in ways]
    handles += [plt.Line2D([], [], color="0.3", label=label, **style) for label, style in marks.items()]
    figure.legend(handles=handles, fontsize=8, loc="outside lower center", ncols=4)


def efficiency(path, panels, most, columns):
    """panels: {title: [(way, class, {processes: efficiency})]}"""
    lines = -(-len(panels) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(7.6, 1 + 2.4 * lines), sharey=True, layout="constrained", squeeze=False)
    for at, (name, curves) in zip(axes.flat, panels.items()):
        for how, kind, points in curves:
            at.plot(*zip(*sorted(points.items())), color=plots.COLOURS[how], **MARKS[kind])
        at.set_xscale("log", base=2)
        ticks(at, [v for v in ((1, 2, 4, 8, 16, 32) if most == 32 else (1, 8, 64, 1024, 32768, 1000000)) if v <= most])
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=name, xlabel="processes", ylim=(0, 1.15))
    for at in axes[:, 0]:
        at.set(ylabel="efficiency")
    legend(figure, MARKS, data.WAYS)
    plots.save(figure, path)


def curves(study, scene):
    """What is known of a scene: [(way, class, {processes: efficiency})], the closed form last."""
    for kind in ("measured", "critical path", "injected simulation", "emulated simulation", "closed form"):
        for how in data.WAYS:
            points = {p: e for p, e in data.efficiency(scene, study, kind, how).items() if p > 1}
            if kind == "injected simulation" and study == "weak":
                points |= {p: e for p, e in data.efficiency(scene, "weak-large", kind, how).items() if p > 1}
            if points:
                yield how, kind, points


def strong(path):
    efficiency(path, {title(s): list(curves("strong", s)) for s in SCENES}, 32, 3)


def weak(path):
    panels = {}
    for s in BOXES:
        line = {2**k: data.short(s).efficiency(data.WEAK, 2**k) for k in range(21)}
        known = [c for c in curves("weak", s) if c[:2] != (DIRECT, "closed form")]
        panels[f"{title(s)}, 16 384 particles a process"] = [*known, (DIRECT, "closed form", line)]
    efficiency(path, panels, 1000000, 2)


def pool(path):
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.2), sharey=True, layout="constrained")
    costs = [10 ** (k / 4) for k in range(21)]
    for at, s in zip(axes, BOXES):
        short, total = data.short(s), data.constants(s)["particles"]
        i = data.modelled(s, "strong", "spatial direct", "imbalance")
        dear = [replace(short, C=short.C + 1e-9 * t) for t in costs]
        for p, style in ((8, "--"), (32, "-")):
            at.loglog(costs, [d.speedup(total, p, i[p]) for d in dear], style, color=plots.COLOURS[DIRECT], label=f"{DIRECT}; {p} processes")
            at.loglog(costs, [d.pool(p) for d in dear], style, color=plots.COLOURS[POOL], label=f"{POOL}; {p} processes")
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=title(s), xlabel="cost added to the law, ns a particle and step")
        at.set_yticks((1, 2, 4, 8, 16, 32), map(str, (1, 2, 4, 8, 16, 32)))
        at.minorticks_off()
    axes[0].set_ylabel("speed-up (closed form)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    plots.save(figure, path)


def messages(path):
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.6), layout="constrained")
    marks = {title(s): dict(marker=m, markerfacecolor="white", linewidth=0) for s, m in zip(SCENES, "os^DvP")}
    for at, column, ways in ((axes[0], "imbalance", [DIRECT]), (axes[1], "bytes_per_particle_step", [DIRECT, POOL])):
        lines = defaultdict(list)
        for r in data.runs("strong", "critical path"):
            if r["way"] in ways:
                lines[r["scene"], r["way"]].append((r["processes"], r[column]))
        for (s, how), points in lines.items():
            at.semilogx(*zip(*sorted(points)), base=2, color=plots.COLOURS[how], **(marks[title(s)] | {"linewidth": 0.7}))
        ticks(at, [2, 4, 8, 16, 32])
        at.set(xlabel="processes")
    axes[0].set(title="imbalance: largest over mean number of particles")
    axes[1].set(title="bytes sent, a particle and step", yscale="log")
    legend(figure, marks, [DIRECT, POOL])
    plots.save(figure, path)


def draw(folder):
    with plt.style.context(["default", STYLE]):
        for make in (strong, weak, pool, messages):
            make(os.path.join(folder, f"report-{make.__name__}.png"))
    plots.draw(os.path.join(data.FOLDER[0], "scaling"), folder)
