"""What a study compares: the displacement of the particles, or a column of the history."""

import re

import numpy as np

from .scene import Refused

UNITS = {
    r".*_energy|.*_work|energy_.*|work_.*": "J",
    r".*momentum_.*": "kg m/s",
    r"mass|lost_mass": "kg",
    r"time|dt": "s",
    r"reaction_.*": "N",
}
ENDS = {"end": lambda values: values[-1], "max": np.nanmax, "min": np.nanmin}


class Quantity:
    """--quantity column[:max|min|end], with --value if it is known. on: False: the displacement is compared."""

    def __init__(self, text, value):
        self.text, self.value, self.on = text, value, text is not None
        self.column, colon, self.end = (text or "").partition(":")
        if self.on and colon and self.end not in ENDS:
            raise Refused(f"--quantity {text}: choose :max, :min or :end")
        self.end = self.end or "end"
        self.unit = (
            next((unit for pattern, unit in UNITS.items() if re.fullmatch(pattern, self.column)), "")
            if self.on
            else "m"
        )

    def check(self, columns, options, same_grid):
        """Refuses a column that the history has not, or one of a particle with a number, which is another one on
        another grid."""
        if self.column not in columns:
            raise Refused(f"--quantity {self.column} is no column of the history: choose one of {'|'.join(columns)}")
        for probe in (options.get("probes") or "").split(","):
            if self.column.startswith(f"probe_{probe}_") and f"probe_{probe}_particle" in options and not same_grid:
                raise Refused(
                    f"--quantity {self.column} does not apply: on each grid another particle has the number of "
                    f"-probe_{probe}_particle; give the place, -probe_{probe}_follow"
                )

    def of(self, result):
        return float(ENDS[self.end](result.history[self.column]))
