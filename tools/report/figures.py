"""Draws the figures of docs/report.md from docs/data. Colours show the strategy, marks and lines the class of the evidence."""

import os
import sys
from dataclasses import replace

import matplotlib

matplotlib.use("Agg")
import data  # noqa: E402 (after the choice of the backend)
import matplotlib.pyplot as plt  # noqa: E402
from data import BOXES, DIRECT, POOL, SCENES, WAYS  # noqa: E402

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


def efficiency(path, studies, names, columns, ticks, lines=None):
    """Efficiency against processes, a panel for each scene; lines: {scene: closed form of spatial decomposition}, for more processes."""
    figure, axes = plt.subplots(len(names) // columns, columns, figsize=(7.6, 1 + 2.4 * len(names) // columns), sharey=True, layout="constrained", squeeze=False)
    for at, s in zip(axes.flat, names):
        for kind, how, study in ((kind, how, study) for kind in MARKS for how in WAYS for study in studies):
            points = lines[s] if lines and (how, kind) == (DIRECT, "closed form") else data.efficiency(s, study, kind, how)
            at.plot(*zip(*sorted((p, e) for p, e in points.items() if p > 1)), color=plots.COLOURS[how], **MARKS[kind])
        at.set_xscale("log", base=2)
        at.set_xticks(ticks, [f"{v:,}".replace(",", " ") if v < 1e5 else f"$10^{{{len(str(v)) - 1}}}$" for v in ticks])
        at.minorticks_off()
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=SCENES[s].title, xlabel="processes", ylim=(0, 1.15))
    figure.supylabel("efficiency", fontsize="medium")
    handles = [plt.Rectangle((0, 0), 1, 1, color=plots.COLOURS[w], label=w) for w in WAYS]
    handles += [plt.Line2D([], [], color="0.3", label=label, **style) for label, style in MARKS.items()]
    figure.legend(handles=handles, fontsize=8, loc="outside lower center", ncols=4)
    plots.save(figure, path)


def pool(path):
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.2), sharey=True, layout="constrained")
    costs = [10 ** (k / 4) for k in range(21)]
    for at, s in zip(axes, BOXES):
        short, total = data.short(s), data.constants(s)["particles"]
        i = data.modelled(s, "strong", column="imbalance")
        dear = [replace(short, C=short.C + 1e-9 * t) for t in costs]
        for p, style in ((8, "--"), (32, "-")):
            at.loglog(costs, [d.speedup(total, p, i[p]) for d in dear], style, color=plots.COLOURS[DIRECT], label=f"{DIRECT}; {p} processes")
            at.loglog(costs, [d.pool(p) for d in dear], style, color=plots.COLOURS[POOL], label=f"{POOL}; {p} processes")
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=SCENES[s].title, xlabel="cost added to the law, ns a particle and step")
        at.set_yticks((1, 2, 4, 8, 16, 32), map(str, (1, 2, 4, 8, 16, 32)))
        at.minorticks_off()
    axes[0].set_ylabel("speed-up (closed form)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=8)
    plots.save(figure, path)


def draw(folder):
    lines = {s: {2**k: data.short(s).efficiency(data.WEAK, 2**k) for k in range(21)} for s in BOXES}
    with plt.style.context(["default", STYLE]):
        efficiency(os.path.join(folder, "report-strong.png"), ["strong"], list(SCENES), 3, data.PROCESSES)
        efficiency(os.path.join(folder, "report-weak.png"), ["weak", "weak-large"], BOXES, 2, (1, 8, 64, 1024, 32768, 1000000), lines)
        pool(os.path.join(folder, "report-pool.png"))
    plots.draw(os.path.join(data.FOLDER[0], "scaling"), folder)
