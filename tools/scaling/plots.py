"""Figures of the tables of docs/data/scaling: docs/scaling-strong.png, -weak.png, -model.png."""
import csv
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

plt.rcParams.update({"font.size": 8, "axes.titlesize": 8, "axes.linewidth": 0.6, "legend.frameon": False})
WAYS = {("spatial", "direct"): ("C0", "spatial, direct"), ("spatial", "swarm"): ("C1", "spatial, swarm"),
        ("pool", ""): ("C2", "pool")}
CLASSES = {"closed form": dict(linestyle="-", marker="", linewidth=0.9),
           "critical path": dict(linestyle="", marker="o", markersize=4, markerfacecolor="none"),
           "measured": dict(linestyle="", marker="s", markersize=5)}


def read(folder, name):
    try:
        with open(os.path.join(folder, name + ".csv"), newline="") as file:
            return list(csv.DictReader(file))
    except OSError:
        return []


def panels(rows, quantity, path, what, limit):
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    if not scenes:
        return
    figure, axes = plt.subplots(1, len(scenes), figsize=(2.7 * len(scenes) + 0.5, 3.1), layout="constrained",
                                squeeze=False)
    for axis, scene in zip(axes[0], scenes):
        mine = [row for row in rows if row["scene"] == scene and row[quantity] and int(row["processes"]) <= limit]
        for (strategy, migrate), (color, label) in WAYS.items():
            for kind, style in CLASSES.items():
                points = sorted((int(row["processes"]), float(row[quantity])) for row in mine
                                if (row["strategy"], row["migrate"], row["class"]) == (strategy, migrate, kind))
                if points:
                    axis.plot(*zip(*points), color=color, label=f"{label}: {kind}", **style)
        axis.set_xscale("log", base=2)
        if quantity == "speedup":
            axis.set_yscale("log", base=2)
            most = max((int(row["processes"]) for row in mine), default=2)
            axis.plot((1, most), (1, most), color="0.7", linewidth=0.8, zorder=0)
            axis.set_ylim(0.1, 1.5 * most)
        else:
            axis.axhline(1, color="0.7", linewidth=0.8, zorder=0)
            axis.set_ylim(0, 1.15)
        axis.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%d"))
        axis.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
        one = next(row for row in rows if row["scene"] == scene)
        axis.set_title(f"{scene}: {one['dim']}-D {one['basis']} {one['update']}")
        axis.set_xlabel("processes")
    axes[0][0].set_ylabel(what)
    handles = {label: handle for axis in axes[0] for handle, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, fontsize=7)
    figure.savefig(path, dpi=130)
    plt.close(figure)
    print(f"written: {os.path.relpath(path)}")


def model(rows, path):
    if not rows:
        return
    names = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axis = plt.subplots(figsize=(7, 2.8), layout="constrained")
    axis.axhspan(0.85, 1.15, color="0.92")
    axis.axhline(1, color="0.6", linewidth=0.8)
    for processes, color in (("1", "C0"), ("2", "C1")):
        points = [(names.index(row["scene"]), float(row["ratio"])) for row in rows if row["processes"] == processes]
        axis.plot(*zip(*points), "s", color=color, markersize=4, label=f"{processes} process{'es' * (processes > '1')}")
    axis.set_xticks(range(len(names)), names, rotation=40, ha="right")
    axis.set_yscale("log")
    axis.set_yticks((0.5, 0.7, 0.85, 1, 1.15, 1.5, 2), ("0.5", "0.7", "0.85", "1", "1.15", "1.5", "2"))
    axis.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axis.set_ylabel("step: measured / predicted")
    axis.legend()
    figure.savefig(path, dpi=130)
    plt.close(figure)
    print(f"written: {os.path.relpath(path)}")


def draw(data, folder):
    rows = read(data, "runs")
    panels([row for row in rows if row["study"] == "strong"], "speedup", os.path.join(folder, "scaling-strong.png"),
           "speed-up", 1024)
    panels([row for row in rows if row["study"] == "weak" and row["strategy"] != "serial"], "efficiency",
           os.path.join(folder, "scaling-weak.png"), "weak efficiency", 1024)
    model(read(data, "validation"), os.path.join(folder, "scaling-model.png"))
