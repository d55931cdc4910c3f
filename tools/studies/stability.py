#!/usr/bin/env python3
"""Measures the largest stable time steps of the methods below with `pebble-study stability`, one method at a time, and
writes docs/data/stability.csv; a method that the file has already is not measured again. table() makes of it the table
"Largest stable steps" of docs/choosing-data.md.
"""
import argparse
import csv
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
DATA = os.path.join(ROOT, "docs", "data")
sys.path[:0] = [os.path.join(ROOT, "tools"), os.path.dirname(os.path.abspath(__file__))]
import marks  # noqa: E402 (after the path)
import methods as compare  # noqa: E402

STEPS = 40000
# The scene only lends its law and its number of particles to the study, which has bodies of its own.
SCENE = ("-dim 1 -grid_lower 0 -grid_upper 1 -grid_cells 8 -materials m -material_m_model elastic -material_m_rho 1 -material_m_E 1 "
         "-material_m_nu 0 -bodies b -body_b_shape box -body_b_lower 0 -body_b_upper 1 -body_b_material m -time_end 1")
BASES = {"linear": "-method_basis linear", "gimp": "-method_basis gimp -method_gimp_update none",
         "gimp_stretch": "-method_basis gimp -method_gimp_update stretch", "bspline2": "-method_basis bspline2",
         "bspline3": "-method_basis bspline3"}
AFLIP = ["aflip -method_affine_strain 0", "aflip -method_affine_strain 0.5", "aflip -method_affine_strain 1",
         "aflip -method_affine_strain 1 -method_damping_rate 0.25"]


def methods():
    """Name and options of each method, those that matter most first."""
    lists = [(("gimp_stretch", "bspline2", "bspline3"), "usl", ["flip", *AFLIP, "apic"]),
             (("bspline2", "gimp_stretch", "bspline3", "linear"), "musl", ["flip"]),
             (("bspline2", "gimp_stretch", "bspline3"), "usl", ["flip -method_flip 0.99"]),
             (("bspline2", "gimp_stretch", "bspline3", "linear"), "musl", ["flip -method_flip 0.99", "aflip -method_affine_strain 1", "apic"]),
             (("linear",), "usl", ["flip", "apic"]),
             (("gimp",), "usl", ["flip", "aflip -method_affine_strain 0", "apic"]),
             (("linear", "gimp_stretch", "bspline2", "bspline3"), "usf", ["flip", "apic"]),
             (("bspline2", "gimp_stretch", "bspline3"), "usl", ["afmpm", "xpic -method_order 2", "xpic -method_order 5"])]
    for bases, update, transfers in lists:
        for transfer in transfers:
            for basis in bases:
                words = transfer.split()
                name = " ".join([basis, update, words[0], *(f"{key.removeprefix('-method_')} {value}" for key, value in zip(words[1::2], words[2::2]))])
                yield name, f"{BASES[basis]} -method_update {update} -method_transfer {transfer}"


def read(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def measure(pebble, options):
    """The row of a method."""
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "bar.opts")
        with open(scene, "w") as file:
            file.write(SCENE.replace(" -", "\n-") + "\n")
        command = [sys.executable, os.path.join(ROOT, "lab", "study.py"), "stability", scene, "--program", pebble, "--steps", str(STEPS), *options.split(), "-output_dir", folder]
        run = subprocess.run(command, capture_output=True, text=True)
        rows = read(os.path.join(folder, "bar_stability.csv"))
        if run.returncode or len(rows) != 1:
            raise RuntimeError(f"{' '.join(command)}: exit status {run.returncode}, {len(rows)} rows: {run.stdout[-500:]}{run.stderr}")
        return {name: value for name, value in rows[0].items() if name != "key"}


def limit(row, probe):
    """The largest stable C of a probe."""
    return f"≥ {row[probe]}" if not row[probe + "_unstable"] else "none" if float(row[probe]) == 0 else row[probe]


def program(row):
    """What the program goes by for the method of a row: its bounds at rest and crossing, and its default of -dt_cfl."""
    numbers = {"flip": "flip", "damping_rate": "damping_rate", "affine_strain": "affine_strain"}
    basis = row["basis"].removesuffix("_stretch")
    options = f"-method_basis {basis} -method_update {row['update']} -method_transfer {row['transfer']}" + "".join(
        f" -method_{name} {row[column]}" for column, name in numbers.items() if row[column])
    affine = "rest affine" if row["transfer"] in ("apic", "aflip") else "rest flip"
    crossing = compare.bound(options)
    rest = crossing if row["transfer"] == "afmpm" else compare.BOUNDS[basis, row["update"]][affine]
    return rest, crossing, compare.own_cfl(options)


def table(_=None, path=os.path.join(DATA, "stability.csv")):
    """The table of docs/choosing-data.md: largest stable C at rest and where particles cross cells, what the program goes by, its
    default of -dt_cfl, and how far that is from the smallest of them."""
    lines = []
    for row in read(path):
        rest, crossing, cfl = program(row)
        least = min(float(row[column]) for column in ("rest", "crossing", "block"))
        lines.append([row["method"], limit(row, "rest"), limit(row, "crossing"), limit(row, "block"), f"{rest:g}, {crossing:g}", f"{cfl:g}", f"{least / cfl:.2f}"])
    return marks.markdown(["method", "at rest", "bar that crosses cells", "block that crosses cells", "`stable.def`", "default `-dt_cfl`", "margin"], lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--data", default=DATA, help="the folder of stability.csv")
    parser.add_argument("--only", default="", help="only methods whose name has this in it")
    parser.add_argument("--jobs", help="not used: a study makes one run after the other")
    parser.add_argument("--print", action="store_true", help="print the table, measure nothing")
    arguments = parser.parse_args()
    path = os.path.join(arguments.data, "stability.csv")
    if arguments.print:
        print(table(path=path))
        return
    os.makedirs(arguments.data, exist_ok=True)
    there = {row["method"] for row in read(path)}
    for name, options in methods():
        if name in there or arguments.only not in name:
            continue
        row = {"method": name, **measure(os.path.abspath(arguments.pebble), options)}
        new = not os.path.exists(path)
        with open(path, "a", newline="") as file:
            writer = csv.DictWriter(file, list(row), lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerow(row)
        print(name, row["rest"], row["crossing"], row["block"], f"{row['seconds']} s", flush=True)


if __name__ == "__main__":
    main()
