"""The figure of docs/choosing.md: error against cost, a panel a problem, a curve a method."""
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
from methods import COLOURS, LINES, MARKERS, SHOWN  # noqa: E402
from problems import MAIN, PROBLEMS, ROOT  # noqa: E402

STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
         "legend.frameon": False, "savefig.dpi": 110, "lines.linewidth": 0.9, "lines.markersize": 3.5}


def draw(results):
    plt.rcParams.update(STYLE)
    names = [name for name, m in results.methods.items() if (m.margin or name in SHOWN) and any(key[0] == name for key in results.rows)]
    figure, panels = plt.subplots(4, 3, figsize=(9, 10.5), layout="constrained")
    panels, lines = panels.ravel(), {}
    for axes, problem in zip(panels, MAIN):
        p = PROBLEMS[problem]
        for name in names:
            basis, update, transfer = name.split()[:3]
            points = results.curve(name, problem)
            if points:
                lines[name], = axes.loglog(*zip(*points), color=COLOURS[basis], marker=MARKERS[update], linestyle=next(line for key, line in LINES.items() if transfer.startswith(key)),
                                           markerfacecolor=COLOURS[basis] if results.methods[name].margin else "white")
        axes.set_title(f"{problem}: {p.about}")
        axes.axhline(p.floor, color="0.7", linewidth=0.6, linestyle=":", zorder=0)
        axes.set_ylim(top=1)
    for axes in panels[len(MAIN):]:
        axes.axis("off")
    figure.supxlabel("cost: steps x particles x time of the method's step (quadratic splines, usl, FLIP: 1)", fontsize=9)
    figure.supylabel("relative error", fontsize=9)
    # What the parts of a name are, instead of all names: colours, marks and lines that occur.
    parts = [name.split()[:3] for name in lines]
    key = [plt.Line2D([], [], color=colour, linewidth=4, label=basis) for basis, colour in COLOURS.items() if any(basis == p[0] for p in parts)]
    key += [plt.Line2D([], [], color="0.3", linestyle="none", marker=mark, markersize=5, label=update)
            for update, mark in MARKERS.items() if any(update == p[1] for p in parts)]
    key += [plt.Line2D([], [], color="0.3", marker="o", markersize=5, markerfacecolor="white", linestyle="none", label="hollow: no margin where\nparticles cross cells")]
    key += [plt.Line2D([], [], color="0.3", linestyle=line, label=transfer, linewidth=1.3)
            for transfer, line in LINES.items() if any(p[2].startswith(transfer) for p in parts)]
    key += [plt.Line2D([], [], color="0.7", linewidth=1, linestyle=":", label="grey: floor of the regret")]
    legend = panels[len(MAIN)].legend(handles=key, loc="upper left", ncols=2, fontsize=9, title="names of methods: basis, update, transfer", title_fontsize=9,
                                      alignment="left")
    legend.set_in_layout(False)
    figure.savefig(os.path.join(ROOT, "docs", "choosing-errors.png"), metadata={"Software": None})
    plt.close(figure)
