"""The studies in Python give the tables of those in C: errors, differences, orders and verdicts of convergence, errors
and what is said of trade, bounds of stability, on mms, bar, column and others on small grids.

usage: test_lab_same.py PEBBLE SOURCE MPIEXEC"""

import math
import os
import re
import subprocess

import check
import mpi

check.arguments(__doc__, 0)
LINES = r"^(order|limit|bias|verdict|note       the error|skipped) .*$"
BAR = [
    "-dim 1",
    "-grid_lower 0",
    "-grid_upper 1",
    "-grid_cells 8",
    "-bc_xmin_type fixed",
    "-bc_xmax_type fixed",
    "-materials m",
    "-material_m_model elastic",
    "-material_m_rho 1",
    "-material_m_E 1",
    "-material_m_nu 0",
    "-bodies b",
    "-body_b_shape box",
    "-body_b_lower 0",
    "-body_b_upper 1",
    "-body_b_material m",
    "-method_basis bspline2",
    "-method_update musl",
    "-method_transfer flip",
    "-dt_cfl 0.4",
    "-time_end 0.5",
]
DISKS = [
    "-dim 2",
    "-grid_lower 0,0",
    "-grid_upper 1,1",
    "-grid_cells 8,8",
    "-materials m,n",
    "-material_m_model neohookean",
    "-material_m_rho 1000",
    "-material_m_E 1e4",
    "-material_m_nu 0.3",
    "-material_n_model elastic",
    "-material_n_rho 300",
    "-material_n_E 1e4",
    "-material_n_nu 0.3",
    "-bodies hole,a,b",
    "-body_hole_material none",
    "-body_hole_shape box",
    "-body_hole_lower 0.2,0.2",
    "-body_hole_upper 0.4,0.3",
    "-body_a_cut hole",
    "-body_a_shape sphere",
    "-body_a_center 0.3,0.3",
    "-body_a_radius 0.2",
    "-body_a_material m",
    '-body_a_velocity "0.1*(x-0.3)+0.2,-0.1*(y-0.3)"',
    "-body_b_shape box",
    "-body_b_lower 0.6,0.6",
    "-body_b_upper 0.8,0.8",
    "-body_b_offset 0.01,0.02",
    "-body_b_material n",
    '-body_b_velocity "-0.2*(y-0.7),0.2*(x-0.7)"',
    "-method_basis bspline2",
    "-method_update musl",
    "-method_transfer flip",
    "-dt_cfl 0.4",
    "-time_end 0.05",
]
PERIODIC = [
    "-dim 1",
    "-grid_lower 0",
    "-grid_upper 1",
    "-grid_cells 8",
    "-bc_xmin_type periodic",
    "-bc_xmax_type periodic",
    *BAR[6:16],
    '-body_b_velocity "0.5+1e-4*sin(2*pi*x)"',
    *BAR[16:19],
    "-time_end 0.3",
    "-dt_size 0.0125",
]
SWINGS = ["-reference_type", "standing", "-reference_amplitude", "0.05"]
FREE = ["-body_b_velocity", "1e-4*pi*sin(pi*x)"]


def both(kind, name, scene, options, words, n=1, finest=False):
    """A study by C and by Python: rows and printed lines of each."""
    end = {"convergence": "study", "trade": "workprecision", "stability": "stability"}[kind]
    own = "workprecision" if kind == "trade" else kind
    path = check.write(f"{name}.opts", scene) if isinstance(scene, list) else scene
    old = (
        ["-study_type", own]
        + [word.replace("--", "-study_") for word in words]
        + ["-reference_type", "finest"] * finest
    )
    c = check.pebble(
        "-options_file",
        path,
        "-output_dir",
        check.folder(f"{name}_c"),
        "-output_name",
        "t",
        *options,
        *old,
        n=n,
        timeout=300,
    )
    words = [word if word != "--order_min" else "--order-min" for word in words]
    command = [
        os.path.join(check.source, "pebble-study"),
        kind,
        path,
        "--program",
        check.program,
        "--processes",
        str(n),
        *words,
        *options,
        "-output_dir",
        check.folder(f"{name}_p"),
        "-output_name",
        "t",
    ]
    p = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=600,
        env=mpi.ENVIRONMENT | os.environ | {"MPIEXEC": check.mpiexec},
    )
    check.need(
        c.status == p.returncode in (0, 3),
        f"{name}: exit status {c.status} of C, {p.returncode} of "
        f"Python\n{c.said[-500:]}{p.stdout[-500:]}{p.stderr[-2000:]}",
    )
    rows = [check.rows(os.path.join(f"{name}_{which}", f"t_{end}.csv")) for which in "cp"]
    lines = [
        [re.sub(r"/\S+\.opts:\d+: ", "", line[0]) for line in re.finditer(LINES, out, re.M)]
        for out in (c.out, p.stdout)
    ]
    check.that(
        lines[0] == lines[1],
        f"{name}: {len(lines[0])} lines, the same of both" + ("" if lines[0] == lines[1] else f"\n{lines}"),
    )
    return rows, c, p


def agree(a, b, digits):
    """Texts of numbers, to so many digits."""
    if not a or not b:
        return a == b
    return math.isclose(float(a), float(b), rel_tol=0.5 * 10 ** (1 - digits), abs_tol=0)


def convergence(name, scene, options, words, n=1, finest=False):
    (c, p), _, _ = both("convergence", name, scene, options, words, n, finest)
    p = [row for row in p if row["error"]]  # Python's has the finest run too
    what = list(c[0])[1]
    digits = {
        what: 15,
        "particles": 15,
        "steps": 15,
        "error": 5,
        "relative": 5,
        "difference": 9,
        "order": 5,
        "quantity": 15,
    }
    same = len(c) == len(p) and all(
        agree(a[column], b[column], number) for a, b in zip(c, p) for column, number in digits.items() if column in a
    )
    check.that(
        same and len(c) > 1,
        f"{name}: errors {' '.join(row['error'][:8] for row in p)}, orders {' '.join(row['order'] or '-' for row in p)}"
        + ("" if same else f"\n{c}\n{p}"),
    )


def trade(name, scene, options, words, finest=False):
    (c, p), _, _ = both("trade", name, scene, options, words, finest=finest)
    texts = [
        "study",
        "basis",
        "gimp_update",
        "update",
        "transfer",
        "flip",
        "order",
        "strain",
        "rate",
        "ppc",
        "cells",
        "cfl",
        "h",
        "particles",
        "steps",
        "status",
        "note",
        "repeats",
    ]
    same = (
        len(c) == len(p)
        and all(a[column] == b[column] for a, b in zip(c, p) for column in texts)
        and all(
            agree(a["error"], b["error"], 5) and math.isclose(float(a["memory"]), float(b["memory"]), rel_tol=0.1)
            for a, b in zip(c, p)
        )
    )
    check.that(
        same and len(c) > 1,
        f"{name}: {len(c)} rows, errors {' '.join(row['error'][:6] or '-' for row in p)}"
        + (
            ""
            if same
            else "\n".join(
                f"{column} {a[column]} {b[column]}"
                for a, b in zip(c, p)
                for column in a
                if column != "key" and a[column] != b[column]
            )
        ),
    )


def stability(name, scene, options, words):
    (c, p), _, _ = both("stability", name, scene, options, words)
    same = len(c) == len(p) and all(a[column] == b[column] for a, b in zip(c, p) for column in a if column != "seconds")
    check.that(
        same and c,
        f"{name}: "
        + "; ".join(
            f"{row['basis']} {row['update']} {row['transfer']}: {row['rest']} {row['crossing']} {row['block']}, "
            f"margin {row['margin']}"
            for row in p
        )
        + ("" if same else f"\n{c}\n{p}"),
    )


mms, bar, column = (check.scene(name) for name in ("mms", "bar", "column"))
TIP = [
    "-reference_type",
    "expression",
    "-reference_displacement",
    "0.1/(5*pi)*sin(pi/2*X)*sin(5*pi*t)",
    "-time_end",
    "0.1",
]
COARSE = ["-grid_upper", "2.5,1.25", "-grid_cells", "10,5", "-time_end", "0.3"]
convergence("mms", mms, ["-grid_cells", "8,8"], ["--levels", "3"])
convergence("mms2", mms, ["-grid_cells", "8,8"], ["--levels", "2", "--order_min", "3"], n=2)
convergence(
    "mmsbar",
    [line for line in BAR if "elastic" not in line and "time_end" not in line and "nu 0" not in line]
    + ["-material_m_model neohookean", "-material_m_nu 0", "-time_end 0.3", "-mms_type bar", "-mms_amplitude 0.01"],
    [],
    ["--levels", "3"],
)  # it starts displaced
convergence("bar", bar, [*TIP, "-grid_upper", "1.125", "-grid_cells", "9"], ["--levels", "4"])
convergence("bar_dt", bar, TIP, ["--levels", "3", "--vary", "dt"])
convergence(
    "bar_energy", bar, ["-time_end", "0.1"], ["--levels", "4", "--vary", "dt", "--quantity", "strain_energy:max"]
)
convergence(
    "bar_value",
    bar,
    ["-time_end", "0.1"],
    ["--levels", "3", "--vary", "dt", "--quantity", "strain_energy:max", "--value", "0.0025"],
)
convergence("bar_ppc", BAR, SWINGS, ["--levels", "3", "--vary", "ppc"])
convergence("column", column, COARSE, ["--levels", "4"], finest=True)
convergence("disks", DISKS, [], ["--levels", "3"], finest=True)
convergence("periodic", PERIODIC, [], ["--levels", "4"], finest=True)
LISTS = [
    "--levels",
    "2",
    "--repeats",
    "1",
    "--basis",
    "bspline2,gimp_stretch",
    "--update",
    "usl,musl",
    "--transfer",
    "flip:0.99,apic,xpic:3",
    "--preset",
]
trade("trade_mms", mms, ["-grid_cells", "8,8", "-time_end", "0.0049"], [*LISTS, "accurate"])
trade(
    "trade_bar",
    bar,
    [*TIP, "-grid_upper", "1.125", "-grid_cells", "18"],
    [
        "--levels",
        "2",
        "--repeats",
        "1",
        "--basis",
        "linear,bspline3",
        "--update",
        "usf,musl",
        "--transfer",
        "flip,aflip",
        "--preset",
        "none",
        "--ppc",
        "3",
        "--cfl",
        "0.2,0.4",
        "--coarser",
        "1",
    ],
)
trade(
    "trade_column",
    column,
    COARSE,
    [
        "--levels",
        "2",
        "--repeats",
        "2",
        "--basis",
        "gimp,bspline2,gimp_stretch,bspline3",
        "--update",
        "usl",
        "--transfer",
        "flip",
        "--preset",
        "balanced",
    ],
    finest=True,
)
trade(
    "trade_energy",
    BAR,
    FREE,
    [
        "--levels",
        "2",
        "--repeats",
        "1",
        "--basis",
        "bspline2,bspline3",
        "--update",
        "usl",
        "--transfer",
        "flip",
        "--preset",
        "none",
        "--quantity",
        "strain_energy:max",
    ],
)
stability("stability_mms", mms, [], ["--steps", "200"])
stability("stability_bar", bar, [], ["--steps", "400", "--basis", "gimp", "--update", "usl", "--transfer", "flip:0.9"])
check.end()
