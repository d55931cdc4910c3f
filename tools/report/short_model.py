"""The short model of docs/model.md, of five constants; the formulas have its numbers. Times are in s."""

import math
from dataclasses import dataclass


@dataclass
class Short:
    """The constants: of a particle; of a step that has neighbours; of a particle of a face of a process's cube; of each
    doubling of the processes; of a particle, for the master of a pool."""

    dim: int
    C: float
    L: float
    B: float
    R: float
    M: float

    def parts(self, total, processes, imbalance=1.0):
        """Seconds of a step of spatial decomposition (7): work, latency, faces, reduction."""
        n = total / processes
        alone = processes == 1
        return imbalance * self.C * n, *((0, 0, 0) if alone else (self.L, self.B * n ** (1 - 1 / self.dim), self.R * math.log2(processes)))

    def speedup(self, total, processes, imbalance=1.0):
        """(8)"""
        return self.C * total / sum(self.parts(total, processes, imbalance))

    def efficiency(self, n, processes, imbalance=1.0):
        """That of n particles a process."""
        return self.speedup(n * processes, processes, imbalance) / processes

    def most(self, total):
        """The number of processes on which even cubes are fastest: there a tenth of a per mille more of them is as good."""
        return bisect(2.0, lambda p: sum(self.parts(total, 1.0001 * p)) >= sum(self.parts(total, p)))

    def least(self, efficiency, processes, imbalance=1.0):
        """The least number of particles a process for this efficiency (12), or infinity."""
        possible = 1 / efficiency > imbalance
        return bisect(1.0, lambda n: self.efficiency(n, processes, imbalance) >= efficiency) if possible else math.inf

    def pool(self, processes):
        """The speed-up of a pool (10)."""
        return min(self.C / self.M, (processes - 1) * self.C / (self.C + self.M)) if processes > 1 else 1.0


def bisect(low, reached):
    """The least number above `low` for which something is reached."""
    high = 1e18
    while high / low > 1 + 1e-9:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if reached(middle) else (middle, high)
    return high
