"""Reads what the report is made of: the CSV files of docs/data, as rows with numbers, and the calibrations of the model."""

import csv
import glob
import os

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))


class Missing(Exception):
    """Data that a table needs are missing; the message says which, and how to get them."""


def value(text):
    try:
        number = float(text)
        return int(number) if number.is_integer() and "." not in text and "e" not in text.lower() else number
    except (TypeError, ValueError):
        return text


def rows(path):
    with open(path, newline="") as f:
        return [{k: value(v) for k, v in row.items()} for row in csv.DictReader(f)]


def evidence(text):
    """The class of a number, in the words of the report."""
    text = str(text).lower().replace("_", " ")
    for word, name in (
        ("measure", "measured"),
        ("wall", "measured"),
        ("path", "critical path"),
        ("simul", "simulated"),
        ("inject", "simulated"),
        ("closed", "closed form"),
        ("model", "closed form"),
        ("predict", "closed form"),
    ):
        if word in text:
            return name
    raise ValueError(f"class {text!r} of a number is none of measured, critical path, simulated, closed form")


class Data:
    def __init__(self, folder):
        self.folder = folder

    def files(self, pattern):
        return sorted(glob.glob(os.path.join(self.folder, pattern)))

    def need(self, pattern, how):
        found = self.files(pattern)
        if not found:
            raise Missing(f"`docs/data/{pattern}` is missing: {how} writes it")
        return found

    def scaling(self):
        """Runs on 1 to 32 real processes."""
        out = []
        for path in self.need("scaling/*.csv", "`make scaling`"):
            for row in rows(path):
                if "study" in row and row.get("class", "oversubscribed") != "oversubscribed" and row.get("processes"):
                    row["class"] = evidence(row["class"])
                    out.append(row)
        if not out:
            raise Missing("`docs/data/scaling/*.csv` has no runs: `make scaling` writes them")
        return out

    def simulated(self, name):
        return rows(self.need(f"simulated/{name}.csv", "`make simulate`")[0])

    def phases(self):
        """Processor time of each phase, of the runs of scaling()."""
        return rows(self.need("scaling/phases.csv", "`make scaling`")[0])

    def costs(self):
        out = {}
        for row in self.simulated("costs"):
            out.setdefault(row["scene"], {})[row["name"]] = 1e-9 * row["ns"]
        return out

    def validation(self):
        """Rows with `predicted` and `measured` s a step."""
        out = []
        for path in self.files("scaling/*.csv") + self.files("validation/*.csv") + self.files("*.csv"):
            for row in rows(path):
                names = {k.lower(): k for k in row if k}
                predicted = next((names[k] for k in names if "predict" in k), None)
                measured = next((names[k] for k in names if k.startswith("measured") or k == "seconds_per_step"), None)
                if (
                    predicted
                    and measured
                    and isinstance(row[predicted], (int, float))
                    and isinstance(row[measured], (int, float))
                ):
                    out.append({**row, "predicted": row[predicted], "measured": row[measured]})
        if not out:
            raise Missing("no file `docs/data/scaling/*.csv` has columns `predicted` and `measured`: `make scaling` writes it")
        return out

    def model(self, name):
        return self.need(f"models/{name}.model", "`make report REPORT=calibrate`")[0]
