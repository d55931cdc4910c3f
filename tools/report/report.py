#!/usr/bin/env python3
"""Makes the tables and figures of docs/report.md anew from docs/data, docs/report.html and, where Chromium is
installed, docs/report.pdf from that: `make report`.

The tables stand between the lines <!-- table NAME --> and <!-- end -->; the function table_NAME makes them. Numbers
in the text are <!-- number NAME -->...<!-- end -->; number_NAME makes them. Sentences that compare numbers are in
claims.py, which checks them. Where data are missing or a claim does not hold, the program says so and ends with
status 1.

    report.py                  tables, figures and pages from the data in the repository (runs Pebble for a few seconds)
    report.py --calibrate      first measures docs/data/models/*.model anew on this machine (minutes, alone)
    report.py --claims         only checks the claims, and writes nothing
"""

import argparse
import os
import re
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools"), os.path.join(ROOT, "tools", "scaling")]
import claims  # noqa: E402 (after the path)
import claims_first  # noqa: E402, F401 (adds its claims)
import claims_results  # noqa: E402, F401
import marks  # noqa: E402
import plots  # noqa: E402
from data import Missing  # noqa: E402
from drawings import Drawings  # noqa: E402
from evidence import Evidence  # noqa: E402
from goals import Goals  # noqa: E402
from numbers_of import Numbers  # noqa: E402
from predictions import Predictions  # noqa: E402
from results import Results  # noqa: E402
from setting import Setting  # noqa: E402


class Report(Setting, Goals, Results, Predictions, Numbers, Drawings, Evidence):
    def number(self, name):
        make = getattr(self, f"number_{name}", None)
        if not make:
            sys.exit(f"report.py: docs/report.md has a number {name} that nothing makes")
        try:
            return make()
        except Missing as m:
            self.note(f"number {name}", str(m))
            return "(no data)"

    def run(self):
        path = os.path.join(ROOT, "docs", "report.md")
        with open(path) as f:
            text = f.read()
        wrong = claims.wrong(self, text)
        if self.args.claims:
            return self.said_all(wrong)
        for name in marks.names(text):
            make = getattr(self, f"table_{name}", None)
            if not make:
                sys.exit(f"report.py: docs/report.md has a table {name} that nothing makes")
            try:
                block = make()
            except Missing as m:
                self.note(f"table {name}", str(m))
                block = f"*No data: {m}.*"
            text = marks.renew(text, name, block)
        text = marks.numbers(text, self.number)
        for name in re.findall(r"\]\(report-(\w+)\.png\)", text):
            try:
                getattr(self, f"figure_{name}")()
            except Missing as m:
                self.note(f"figure {name}", str(m))
        plots.draw(os.path.join(self.args.data, "scaling"), self.args.out)
        with open(os.path.join(self.args.out, "report.md"), "w") as f:
            f.write(text)
        print(f"  {os.path.relpath(os.path.join(self.args.out, 'report.md'))}")
        try:
            import page
        except ModuleNotFoundError as missing:
            sys.exit(f"report.py: {missing}; run it by `make report`")
        page.write(text, self.args.out, os.path.join(self.args.out, "report.html"))
        page.print_pdf(os.path.join(self.args.out, "report.html"), os.path.join(self.args.out, "report.pdf"))
        return self.said_all(wrong + captions(text))

    def said_all(self, wrong):
        for line in [f"{where}: {what}" for where, what in self.missing] + wrong:
            print(f"report.py: {line}", file=sys.stderr)
        return 1 if self.missing or wrong else 0


def captions(text):
    """What is wrong with the numbers of tables and figures: each has a caption with the next number."""
    out = []
    for what, place in (("Table", r"^\|(?:.*)\n\| ---"), ("Figure", r"^!\[")):
        found = [int(n) for n in re.findall(rf"^\*\*{what} (\d+)\.\*\*", text, re.M)]
        if found != list(range(1, len(re.findall(place, text, re.M)) + 1)):
            out.append(
                f"{what.lower()}s of docs/report.md: captions have the numbers {found}, there are"
                f" {len(re.findall(place, text, re.M))}"
            )
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"), type=os.path.abspath)
    parser.add_argument("--calibrator", default=os.path.join(ROOT, "build", "mpicc", "calibrate"), type=os.path.abspath)
    parser.add_argument("--predictor", default=os.path.join(ROOT, "build", "mpicc", "predict"), type=os.path.abspath)
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--data", default=os.path.join(ROOT, "docs", "data"), help="folder of the CSV files")
    parser.add_argument("--out", default=os.path.join(ROOT, "docs"), help="where the report and its figures go")
    parser.add_argument("--claims", action="store_true", help="only check the claims")
    parser.add_argument("--calibrate", nargs="?", type=int, const=6, metavar="REPEATS")
    args = parser.parse_args()
    report = Report(args)
    if args.calibrate:
        report.calibrate(args.calibrate)
    return report.run()


if __name__ == "__main__":
    sys.exit(main())
