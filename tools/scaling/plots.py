"""Draws the tables of docs/data/scaling: docs/scaling-strong.png, -weak.png, -model.png. `make scaling` and `make report` call it."""
import csv
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "savefig.dpi": 130}
# A strategy has the same colour in all figures, also those of the report.
COLOURS = {"spatial, direct": "tab:blue", "spatial, DMSwarmMigrate": "tab:orange", "pool": "tab:green"}
WAYS = {key: (COLOURS[label], label) for key, label in zip((("spatial", "direct"), ("spatial", "swarm"), ("pool", "")), COLOURS)}
# Measured squares are the largest and lie below, so that those of the critical path are seen on them.
CLASSES = {"closed form": dict(linestyle="-", linewidth=1.2),
           "measured": dict(linestyle="", marker="s", markersize=6),
           "critical path": dict(linestyle=":", linewidth=0.7, marker="o", markersize=4, markerfacecolor="white")}
COLUMNS = 3


def read(folder, name):
    try:
        with open(os.path.join(folder, name + ".csv"), newline="") as file:
            return list(csv.DictReader(file))
    except OSError:
        return []


def save(figure, path):
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)
    print(f"  {os.path.relpath(path)}")


def panels(rows, quantity, path, what):
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    if not scenes:
        return
    lines = -(-len(scenes) // COLUMNS)
    figure, axes = plt.subplots(lines, COLUMNS, figsize=(7.6, 0.7 + 2.6 * lines), sharey=True, layout="constrained",
                                squeeze=False)
    for axis in axes.flat[len(scenes):]:
        axis.axis("off")
    most = max(int(row["processes"]) for row in rows)
    for axis, scene in zip(axes.flat, scenes):
        mine = [row for row in rows if row["scene"] == scene and row[quantity]]
        for (strategy, migrate), (color, _) in WAYS.items():
            for kind, style in CLASSES.items():
                points = sorted((int(row["processes"]), float(row[quantity])) for row in mine
                                if (row["strategy"], row["migrate"], row["class"]) == (strategy, migrate, kind))
                if points:
                    axis.plot(*zip(*points), color=color, **style)
        axis.set_xscale("log", base=2)
        if quantity == "speedup":
            axis.set_yscale("log", base=2)
            axis.plot((1, most), (1, most), color="0.7", linewidth=0.8, zorder=0)
            axis.set_ylim(0.1, 1.5 * most)
            axis.set_yticks([4**k for k in range(-1, 6) if 4**k <= most])
        else:
            axis.axhline(1, color="0.7", linewidth=0.8, zorder=0)
            axis.set_ylim(0, 1.15)
        axis.set_xticks([p for k in range(11) if (p := 2**k) <= most and (most <= 64 or k % 2 == 0)])
        axis.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%d"))
        axis.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
        one = next(row for row in rows if row["scene"] == scene)
        axis.set_title(f"{scene}: {one['dim']}-D {one['basis']} {one['update']}")
        axis.set_xlabel("processes")
    for axis in axes[:, 0]:
        axis.set_ylabel(what)
    handles = [plt.Rectangle((0, 0), 1, 1, color=color, label=label) for way, (color, label) in WAYS.items()
               if any((row["strategy"], row["migrate"]) == way for row in rows)]
    handles += [plt.Line2D([], [], color="0.3", label=kind, **style) for kind, style in CLASSES.items()]
    if len(scenes) < axes.size:
        axes.flat[-1].legend(handles=handles, loc="center")
    else:
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    save(figure, path)


def model(rows, path):
    if not rows:
        return
    names = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axis = plt.subplots(figsize=(7.6, 2.8), layout="constrained")
    axis.axhspan(0.85, 1.15, color="0.92")
    axis.axhline(1, color="0.6", linewidth=0.8)
    for processes, style in (("1", dict(color="C0", marker="s")), ("2", dict(color="C1", marker="D"))):
        points = [(names.index(row["scene"]), float(row["predicted"]) / float(row["seconds_per_step"])) for row in rows
                  if row["processes"] == processes]
        axis.plot(*zip(*points), linestyle="", markersize=4, label=f"{processes} process{'es' * (processes > '1')}", **style)
    axis.set_xticks(range(len(names)), names, rotation=40, ha="right", rotation_mode="anchor")
    axis.set_yscale("log")
    far = [value for one in axis.lines for value in one.get_ydata()]
    axis.set_ylim(0.95 * min(0.75, *far), 1.05 * max(1.33, *far))
    axis.set_yticks((0.75, 0.85, 1, 1.15, 1.33), ("0.75", "0.85", "1", "1.15", "1.33"))
    axis.text(len(names) - 0.6, 1.135, "within 15 %", ha="right", va="top", fontsize=8, color="0.4")
    axis.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axis.set_ylabel("step: predicted / measured")
    figure.legend(loc="outside upper center", ncols=2)
    save(figure, path)


def draw(data, folder):
    with plt.style.context(["default", STYLE]):
        rows = read(data, "runs")
        panels([row for row in rows if row["study"] == "strong"], "speedup", os.path.join(folder, "scaling-strong.png"),
               "speed-up")
        panels([row for row in rows if row["study"] == "weak" and row["strategy"] != "serial"], "efficiency",
               os.path.join(folder, "scaling-weak.png"), "weak efficiency")
        model(read(data, "validation"), os.path.join(folder, "scaling-model.png"))
