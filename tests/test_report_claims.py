"""The claims of docs/report.md (tools/report/claims.py): all hold with the data of docs/data and stand in the text;
with falsified data each kind of them fails, and says which claim and both numbers.

usage: test_report_claims.py PEBBLE SOURCE MPIEXEC PREDICTOR
"""

import argparse
import csv
import os
import re
import shutil
import sys

import check

(predictor,) = check.arguments(__doc__, 1)
sys.path[:0] = [os.path.join(check.source, "tools", "report")]
import claims  # noqa: E402
import report  # noqa: E402

DATA = os.path.join(check.source, "docs", "data")
with open(os.path.join(check.source, "docs", "report.md")) as file:
    TEXT = file.read()


def made(folder):
    options = dict(
        pebble=check.program,
        calibrator="",
        predictor=os.path.abspath(predictor),
        mpiexec=check.mpiexec,
        data=folder,
        out=".",
        claims=True,
    )
    return report.Report(argparse.Namespace(**options))


def false(name, file, column, value, **row):
    """The claim fails once the column of the rows that have these values is another one."""
    folder = check.folder("data")
    shutil.copytree(DATA, folder, dirs_exist_ok=True)
    path = os.path.join(folder, file)
    with open(path, newline="") as f:
        rows = list(csv.DictReader(f))
    found = [r for r in rows if all(r[k] == str(v) for k, v in row.items())]
    check.need(found, f"{file} has no row with {row}")
    for r in found:
        r[column] = value
    with open(path, "w", newline="") as f:
        out = csv.DictWriter(f, rows[0])
        out.writeheader()
        out.writerows(rows)
    said = claims.fault(name, made(folder)) or "it holds"
    check.that(
        re.match(rf"claim {name} does not hold .*: \S+ (<|<=|>|>=|==) \S+ is false", said),
        f"{name}, falsified in {file}: {said[:150]}",
    )


# ---- The data as they are
whole = made(DATA)
check.that(len(claims.CLAIMS) > 30, f"{len(claims.CLAIMS)} claims")
text = claims.plain(TEXT)
for name in claims.CLAIMS:
    said = claims.fault(name, whole, text)
    check.that(not said, said or f"{name} holds")
check.that(not whole.missing, f"no data are missing: {whole.missing}")

# ---- Falsified data
runs = "scaling/runs.csv"
strong = dict(study="strong", strategy="spatial", migrate="direct")
false("spatial_ahead", runs, "efficiency", "0.1", scene="disks", processes=2, **{"class": "measured"}, **strong)
false(
    "spatial_ahead",
    "simulated/strong.csv",
    "efficiency",
    "0.01",
    scene="box3d",
    strategy="spatial",
    migrate="direct",
    mode="injected",
    ranks=8,
)
false(
    "pool_on_two",
    runs,
    "efficiency",
    "0.6",
    scene="dambreak",
    study="strong",
    strategy="pool",
    processes=2,
    **{"class": "measured"},
)
false("same_bits", runs, "digest", "0123456789abcdef", scene="box2d", processes=8, **{"class": "closed form"}, **strong)
false(
    "bytes_below",
    runs,
    "bytes_per_particle_step",
    "1e4",
    scene="disks3d",
    processes=32,
    **{"class": "critical path"},
    **strong,
)
false("closed_faster", runs, "seconds_per_step", "1", scene="box3d", processes=16, **{"class": "closed form"}, **strong)
false("injected_faster", "simulated/validate.csv", "injected_over_real", "1.2", strategy="spatial", ranks=2)
false("simulated_bits", "simulated/strong-large.csv", "same_as_real", "no", scene="disks", ranks=64)
false("weak_keeps", "simulated/weak-large.csv", "efficiency", "0.7", scene="box3d", ranks=512)
false("counts_equal", "scaling/counts.csv", "equal", "no", scene="box3d", strategy="pool", processes=8)
false("short_runs_inside", "scaling/validation.csv", "predicted", "1", processes=2)
false("users_on_two", "scaling/users.csv", "measured", "1", processes=1)
false("whole_runs_inside", "scaling/validation.csv", "predicted", "1")
false("linear_fails", "choosing.csv", "error", "0.01", problem="mms", method="lin musl flip", n=64)
false("short_stand_for_long", "scaling/lengths.csv", "seconds_per_step", "1", scene="box2d", processes=2, steps=400)
false("plain_slower", "bench/floor.csv", "min_ns", "1", group="seed", program="seed_serial")
false("tiles_gain", "tiles.csv", "after", "2", scene="two disks")

# ---- Falsified text
check.that(
    whole.said_all(["a claim"]) == 1 and whole.said_all([]) == 0, "a claim that does not hold makes the exit status 1"
)
said = claims.fault("same_bits", whole, text.replace("It was the same on all", "It was another one on all"))
check.that(said and "has no sentence" in said, f"a sentence that is not in the text: {said}")
empty = made(check.folder("empty"))
claims.wrong(empty)
check.that(len(empty.missing) > 20, f"without data {len(empty.missing)} claims say which are missing")
check.end()
