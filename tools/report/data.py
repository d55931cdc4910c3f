"""Reads what the report is made of: the CSV files of docs/data, as rows with numbers, and the calibrations of the
model."""

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
        self.folder, self.known = folder, {}

    def files(self, pattern):
        return sorted(glob.glob(os.path.join(self.folder, pattern)))

    def read(self, path):
        """The rows of a file, which is read once."""
        if path not in self.known:
            self.known[path] = rows(path)
        return self.known[path]

    def need(self, pattern, how):
        found = self.files(pattern)
        if not found:
            raise Missing(f"`docs/data/{pattern}` is missing: {how} writes it")
        return found

    def file(self, name):
        """The rows of one file."""
        return self.read(self.need(name, "`make scaling` or `make simulate`")[0])

    def scaling_file(self, name):
        return self.file(f"scaling/{name}.csv")

    def scaling(self):
        """Runs on 1 to 32 real processes."""
        out = []
        for path in self.need("scaling/*.csv", "`make scaling`"):
            for row in self.read(path):
                if "study" in row and row.get("class", "oversubscribed") != "oversubscribed" and row.get("processes"):
                    row["class"] = evidence(row["class"])
                    out.append(row)
        if not out:
            raise Missing("`docs/data/scaling/*.csv` has no runs: `make scaling` writes them")
        return out

    def simulated(self, name):
        return self.read(self.need(f"simulated/{name}.csv", "`make simulate`")[0])

    def costs(self):
        out = {}
        for row in self.simulated("costs"):
            out.setdefault(row["scene"], {})[row["name"]] = 1e-9 * row["ns"]
        return out

    def validation(self):
        """Rows with `predicted` and `measured` s a step."""
        return [{**r, "measured": r["seconds_per_step"]} for r in self.scaling_file("validation")]

    def model(self, name):
        return self.need(f"models/{name}.model", "`make report REPORT=calibrate`")[0]
