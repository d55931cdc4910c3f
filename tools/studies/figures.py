"""The figure of docs/choosing.md: error against cost, a panel a problem, a curve a method."""
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
from methods import COLOURS, LINES, MARKERS, SHOWN  # noqa: E402
from problems import MAIN, PROBLEMS, ROOT  # noqa: E402

STYLE = {"font.size": 8, "axes.titlesize": 8, "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
         "legend.frameon": False, "savefig.dpi": 110, "lines.linewidth": 1.1, "lines.markersize": 3}


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
    figure.supxlabel("cost: steps x particles x time of the method's step (quadratic splines, usl, FLIP: 1)", fontsize=8)
    figure.supylabel("relative error", fontsize=8)
    legend = panels[len(MAIN)].legend(lines.values(), lines, loc="upper left", ncols=2, fontsize=6.5,
                                      title="hollow: no margin where particles cross cells\ndotted: floor of the regret", title_fontsize=6.5, alignment="left")
    legend.set_in_layout(False)
    figure.savefig(os.path.join(ROOT, "docs", "choosing-errors.png"), metadata={"Software": None})
    plt.close(figure)
