"""Draws the figures of docs/report.md. The marks show the class of the evidence: filled = measured, open = critical path, crosses =
simulated, both joined by dots, lines = closed form."""

import math
import os
import sys

try:
    import matplotlib
except ModuleNotFoundError as missing:
    sys.exit(f"report.py: {missing}; run it by `make report`")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

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
COLOURS = ["tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown", "tab:pink", "tab:olive"]
plt.rcParams.update(STYLE)


def mark(kind, colour):
    return {
        "measured": dict(marker="s", color=colour, linestyle="none", markersize=6),
        "critical path": dict(marker="o", color=colour, markerfacecolor="white", linestyle=":", linewidth=0.7),
        "simulated": dict(marker="x", color=colour, linestyle=":", linewidth=0.7),
        "emulated to injected": dict(color=colour, alpha=0.13, linewidth=0),
        "closed form": dict(color=colour, linestyle="--"),
        "closed form, as simulated": dict(color=colour),
    }[kind]


def ticks(axes, values):
    axes.set_xticks(values, [f"{v:,}".replace(",", " ") if v < 1e5 else f"$10^{{{len(str(v)) - 1}}}$" for v in values])
    axes.minorticks_off()


def finish(figure, path):
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)
    print(f"  {os.path.relpath(path)}")


def efficiency(path, titles, panels, floor=0, top=1.15, columns=2):
    """panels: a list of {label: [(kind, [(processes, efficiency)])]}."""
    rows = math.ceil(len(panels) / columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(7.6, 0.8 + 2.5 * rows), sharey=True, layout="constrained", squeeze=False
    )
    kinds, colours = [], {}
    for at, title, panel in zip(axes.flat, titles, panels):
        at.set_xscale("log", base=2)
        for label, curves in panel.items():
            colour = colours.setdefault(label, COLOURS[len(colours) % len(COLOURS)])
            for kind, points in curves:
                if kind not in kinds:
                    kinds.append(kind)
                if kind == "emulated to injected":
                    at.fill_between([p for p, _ in sorted(points)], *zip(*(y for _, y in sorted(points))), **mark(kind, colour))
                    continue
                at.semilogx(*zip(*sorted(points)), base=2, **mark(kind, colour))
        values = sorted({p for curves in panel.values() for _, points in curves for p, _ in points})
        ticks(at, [v for v in (1, 2, 4, 8, 16, 32, 128, 1024, 32768, 1000000) if values and v <= max(values)])
        if values and max(values) > 64:
            ticks(at, [v for v in (1, 8, 64, 1024, 32768, 1000000) if v <= max(values)])
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=title, xlabel="processes")
    for at in axes[:, 0]:
        at.set(ylabel="efficiency", ylim=(floor, top))
    for at in axes.flat[len(panels) :]:
        at.axis("off")
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour, label=label) for label, colour in colours.items()]
    for kind in kinds:
        handle = plt.Rectangle if kind == "emulated to injected" else plt.Line2D
        handles.append(handle(*([(0, 0), 1, 1] if handle is plt.Rectangle else [[], []]), label=kind, **mark(kind, "0.3")))
    if len(panels) < axes.size:
        axes.flat[-1].legend(handles=handles, fontsize=8, loc="center")
    else:
        figure.legend(handles=handles, fontsize=8, loc="outside lower center", ncols=4 if len(handles) > 5 else len(handles))
    finish(figure, path)


def pool(path, panels):
    """panels: {title: {label: [(extra ns, speed-up)]}}"""
    figure, axes = plt.subplots(1, len(panels), figsize=(7.6, 3.2), sharey=True, layout="constrained", squeeze=False)
    for at, (title, lines) in zip(axes[0], panels.items()):
        for k, (label, points) in enumerate(lines.items()):
            colour = COLOURS[k // 2]  # one for each number of processes
            at.loglog(*zip(*points), color=colour, label=label, linestyle="--" if "spatial" in label else "-")
            at.annotate(label.split(",")[0], points[-1] if "pool" in label else points[0], (-4, -9) if "pool" in label else (4, 4),
                        textcoords="offset points", color=colour, fontsize=8, ha="right" if "pool" in label else "left")
        at.axhline(1, color="0.8", linewidth=0.6, zorder=0)
        at.set(title=title, xlabel="cost added to the law, ns a particle and step")
        at.minorticks_off()
    axes[0][0].set_ylabel("speed-up (closed form)")
    axes[0][0].set_yticks((1, 2, 4, 8, 16, 32), map(str, (1, 2, 4, 8, 16, 32)))
    axes[0][0].minorticks_off()  # those of the new ticks
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    finish(figure, path)


def messages(path, imbalance, size):
    """imbalance, size: {scene: [(kind, [(processes, value)])]}, in two panels."""
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.4), layout="constrained")
    titles = "imbalance: largest over mean number of particles", "bytes sent, a particle and step"
    for at, title, panel in zip(axes, titles, (imbalance, size)):
        for colour, shape, (label, curves) in zip(COLOURS, "os^DvP", panel.items()):
            style = {"counted": dict(marker=shape, markerfacecolor="white", linestyle=":", linewidth=0.7), "formula": dict(linewidth=1.2)}
            for kind, points in curves:
                at.semilogx(*zip(*sorted(points)), base=2, color=colour, **style[kind])
            at.plot([], [], color=colour, label=label, **style["counted"])
        at.set(title=title, xlabel="processes")
        ticks(at, sorted({p for curves in panel.values() for _, points in curves for p, _ in points}))
    handles, labels = axes[0].get_legend_handles_labels()
    handles.append(plt.Line2D([], [], color="0.3", linewidth=0.9))
    figure.legend(handles, [*labels, "by formula"], loc="outside lower center", ncols=4, fontsize=8, columnspacing=1)
    most = max(v for curves in size.values() for _, points in curves for _, v in points)
    axes[1].set_yscale("log")
    axes[1].set_ylim(top=6 * most)
    axes[1].text(2, 2 * most, "pool", fontsize=8)
    axes[1].text(0.97, 0.05, "spatial, direct", fontsize=8, ha="right", transform=axes[1].transAxes)
    finish(figure, path)


def shares(path, panels):
    """Draws where the time of a step goes. panels: {title: [(processes, {part: seconds})]}"""
    figure, axes = plt.subplots(1, len(panels), figsize=(7.6, 3.2), layout="constrained", squeeze=False)
    names = list(dict.fromkeys(name for bars in panels.values() for _, parts in bars for name in parts))
    for at, (title, bars) in zip(axes[0], panels.items()):
        below = [0.0] * len(bars)
        for k, name in enumerate(names):
            heights = [1e6 * parts.get(name, 0) for _, parts in bars]
            at.bar(range(len(bars)), heights, bottom=below, color=COLOURS[k % len(COLOURS)], label=name, width=0.7, edgecolor="white", linewidth=0.3)
            below = [a + b for a, b in zip(below, heights)]
        at.set_xticks(
            range(len(bars)),
            [f"{p:,}".replace(",", " ") if p < 1e5 else f"$10^{{{len(str(p)) - 1}}}$" for p, _ in bars],
            fontsize=8,
        )
        at.set(title=title, xlabel="processes", ylabel="µs a step (closed form)")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside right center", fontsize=8)  # in the sequence of the bars
    finish(figure, path)


def convergence(path, curves):
    """curves: {label: [(h, error)]}"""
    figure, axes = plt.subplots(figsize=(4.8, 3.4), layout="constrained")
    for k, (label, points) in enumerate(curves.items()):
        axes.loglog(*zip(*points), color=COLOURS[k], marker="os^D"[k % 4], label=label)
    sizes = sorted({h for points in curves.values() for h, _ in points})
    low = min(e for points in curves.values() for _, e in points)
    axes.plot(
        [sizes[0], sizes[-1]],
        [low, low * (sizes[-1] / sizes[0]) ** 2],
        color="0.55",
        linewidth=0.8,
        linestyle=":",
        label="second order",
    )
    axes.set_xticks(sizes, [f"1/{1 / h:g}" for h in sizes])
    axes.minorticks_off()
    axes.set(xlabel="cell size $h$ [m]", ylabel="rms error of the displacement [m]")
    axes.legend(fontsize=8)
    finish(figure, path)
