"""Draws docs/scaling-model.png from docs/data/scaling. `make scaling` and `make report` call it."""
import csv
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "savefig.dpi": 130}
# A strategy has the same colour in all figures of the report.
COLOURS = {"spatial, direct": "tab:blue", "spatial, DMSwarmMigrate": "tab:orange", "pool": "tab:green"}


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


def model(rows, path):
    if not rows:
        return
    names = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axis = plt.subplots(figsize=(7.6, 2.8), layout="constrained")
    axis.axhspan(0.85, 1.15, color="0.92")
    axis.axhline(1, color="0.6", linewidth=0.8)
    for processes, style in (("1", dict(color="C0", marker="s")), ("2", dict(color="C1", marker="D"))):
        points = [(names.index(row["scene"]), float(row["predicted"]) / float(row["measured"])) for row in rows
                  if row["processes"] == processes]
        axis.plot(*zip(*points), linestyle="", markersize=4, label=f"{processes} process{'es' * (processes > '1')}", **style)
    axis.set_xticks(range(len(names)), names, rotation=40, ha="right", rotation_mode="anchor")
    axis.set_yscale("log")
    far = [value for one in axis.lines for value in one.get_ydata()]
    axis.set_ylim(0.95 * min(0.75, *far), 1.05 * max(1.33, *far))
    axis.set_yticks((0.5, 0.67, 0.85, 1, 1.15, 1.5), ("0.5", "0.67", "0.85", "1", "1.15", "1.5"))
    axis.text(len(names) - 0.6, 1.135, "within 15 %", ha="right", va="top", fontsize=8, color="0.4")
    axis.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axis.set_ylabel("step of a whole run:\npredicted / measured")
    figure.legend(loc="outside upper center", ncols=2)
    save(figure, path)


def draw(data, folder):
    with plt.style.context(["default", STYLE]):
        model(read(data, "users"), os.path.join(folder, "scaling-model.png"))
