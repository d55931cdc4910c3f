"""The tables of scenes, of the machine, of PETSc's parts, and of orders of convergence."""

import math

import marks
from data import Missing
from words import scene, thousands

STEPS_OF = {"linear": "linear", "bspline2": "quadratic"}
ORDERS = {
    "lin usf flip": "linear, usf, flip (the assignment)",
    "lin musl flip": "linear, musl, flip",
    "bs2 musl flip": "quadratic spline, musl, flip",
    "bs2 usl flip": "quadratic spline, usl, flip",
    "bs3 usl aflip 1": "cubic spline, usl, aflip (the default)",
    "gimpS usl flip": "GIMP, stretched, usl, flip",
}


class Setting:
    def definitions(self):
        """{(scene, real or simulated): its row}"""
        out = {}
        for folder, kind in (("scaling", "real"), ("simulated", "simulated")):
            for r in self.data.file(f"{folder}/scenes.csv"):
                out[r["scene"], kind] = {k: str(v) for k, v in r.items()}
        return out

    def differing(self):
        """The scenes that are not the same in real and simulated runs."""
        found = self.definitions()
        return [s for s, kind in found if kind == "real" and found[s, "real"] != found.get((s, "simulated"))]

    def table_scenes(self):
        found, lines = self.definitions(), []
        for (name, kind), r in sorted(found.items(), key=lambda f: [s for s, _ in found].index(f[0][0])):
            same = found[name, "real"] == found.get((name, "simulated"))
            if same and kind == "simulated":
                continue
            what = f"{STEPS_OF[r['basis']]}, {r['update']}"
            sizes = self.sizes(name, "real" if same else kind)
            lines.append(
                [scene(name), "all" if same else kind, what, r["cells"].replace("x", " x "), sizes, r["motion"]]
            )
        return marks.markdown(
            [
                "scene",
                "runs",
                "basis, update",
                "cells, strong scaling",
                "particles: strong; weak on 1",
                "motion at the start",
            ],
            lines,
        )

    def sizes(self, name, kind):
        out = []
        for study in ("strong", "weak"):
            try:
                rows = self.real(study) if kind == "real" else self.simulated(study)
            except Missing:
                continue
            if found := [r["particles"] for r in rows if r["scene"] == name]:
                out.append(thousands(min(found)))
        return "; ".join(out)

    def table_machine(self):
        facts = [
            {r["name"]: r["value"] for r in self.data.file(f"{folder}/machine.csv")}
            for folder in ("scaling", "simulated")
        ]
        lines = [[name, *(f.get(name, "") for f in facts)] for name in dict.fromkeys((*facts[0], *facts[1]))]
        return marks.markdown(["", "real runs", "simulated runs, and real runs beside them"], lines)

    # ---- Orders of convergence
    def ladders(self):
        """{method: [(cells, relative error)]} of the manufactured solution, by the trade studies."""
        out = {}
        for r in self.data.file("choosing.csv"):
            if (r["problem"], str(r["ppc"]), str(r["cfl"])) == ("mms", "2", "0.4") and r["method"] in ORDERS:
                out.setdefault(r["method"], []).append((r["n"], r["error"]))
        if set(out) != set(ORDERS):
            raise Missing(
                "`docs/data/choosing.csv` lacks methods of the table of orders: `make studies STUDIES=all` writes it"
            )
        return {k: sorted(out[k]) for k in ORDERS}

    def orders(self, label):
        """The observed orders of convergence from each grid to the next."""
        points = self.ladders()[label]
        return [math.log2(a[1] / b[1]) for a, b in zip(points, points[1:])]

    def table_orders(self):
        lines = [
            [ORDERS[label], *(f"{100 * e:.2g} %" for _, e in points), *(f"{o:.1f}" for o in self.orders(label))]
            for label, points in self.ladders().items()
        ]
        cells = [n for n, _ in next(iter(self.ladders().values()))]
        return marks.markdown(
            ["method", *(f"{n} cells" for n in cells), *(f"order {a}-{b}" for a, b in zip(cells, cells[1:]))], lines
        )

    # ---- PETSc
    def table_petsc(self):
        """What parts of PETSc do in a step, what is bypassed and why, each with a measurement."""
        ratios = self.ratios_of_migration()
        least, most = (f(v for (_, kind, p), v in ratios.items() if (kind, p) == ("simulated", 32)) for f in (min, max))
        near, far = (f(v for (_, kind, p), v in ratios.items() if (kind, p) == ("measured", 2)) for f in (min, max))
        counted = {(r["scene"], r["strategy"], r["processes"], r["quantity"]): r["counted"] for r in self.counts()}
        ghosts = counted["box3d", "spatial", 32, "bytes of ADVANCE a step"]
        lines = [
            [
                "DMDA",
                (
                    "says which process owns a node, and which are its neighbours; two grids of the same nodes have the"
                    " sums and the motion"
                ),
                "its equal boxes, which leave processes idle where there is no body: we choose the cuts, between tiles",
                (
                    f"imbalance of the two disks on 32 processes {self.balances()['disks, 1024 x 1024 cells'][32]:.2f};"
                    f" with equal boxes {self.number_equal_boxes()}"
                ),
            ],
            [
                "DMSwarm",
                "stores all fields of the particles, as a basic swarm",
                (
                    "its own search of cells, which deletes or doubles particles on faces; the owner of a cell follows"
                    " from the cuts"
                ),
                "ten programs show the faults: [petsc.md](petsc.md)",
            ],
            [
                "DMSwarmMigrate",
                (
                    "`-parallel_migrate swarm`, the default: it sends particles to their owners in each step in which"
                    " one leaves its box"
                ),
                (
                    "`direct` bypasses it, with two messages an axis and no collective: the call makes 14 collectives,"
                    " 8 of them reductions (PETSc 3.26: 15 and 9)"
                ),
                (
                    f"step with it over step with `direct`: {near:.2f} to {far:.2f} on 2 processes, measured;"
                    f" {least:.2f} to {most:.2f} on 32, simulated"
                ),
            ],
            [
                "ghost update",
                (
                    "a PetscSF, made from the DMDA's scatter and restricted to ghost nodes, sends velocity and"
                    " acceleration of nodes"
                ),
                (
                    "DMLocalToLocal, which copies every own node onto itself; DMLocalToGlobal, whose sums depend on the"
                    " number of processes (`-parallel_sums roundoff` uses it)"
                ),
                (
                    "the copies took 3 % of a step ([developer's"
                    f" guide](developer.md#what-petsc-does-and-what-it-does-not)); {thousands(ghosts)} B a step for the"
                    " filled 3-D box on 32 processes, counted, equal to the formula"
                ),
            ],
            [
                "viewers, log",
                "nothing in a step; `-dm_view` shows both grids, `-log_view` has an event for each phase",
                (
                    "PETSc's HDF5 viewer: between steps, a PetscSF brings each field into the order of the particles'"
                    " numbers, and HDF5 writes it"
                ),
                "messages and reductions of this report are counted by `-log_view`",
            ],
        ]
        return marks.markdown(
            ["part of PETSc", "what it does in a step", "what is bypassed, and why", "measurement"], lines
        )
