"""What is made of the runs of a work-precision study: which of them no other beats, how long a setting takes to reach
an error, and what one loses against another. Nothing here starts a run.

A run is a dict with numbers (NaN: none): setting, error (a part of the solution's size), seconds_min and seconds_max
of its repeats, status and note. `floor`: errors below it say nothing, since the references differ by that much."""

import math


def counts(run):
    """Whether it came to its end and has an error."""
    return run["status"] == "ok" and run["error"] >= 0 and run["seconds_min"] > 0


def stable(run):
    """Whether it may be recommended: the steps of its method are not too long for particles that cross cells."""
    return counts(run) and not run["note"]


def mark(runs, floor=0.0):
    """Sets run["front"], 1 for each stable run that no other stable one beats in both time and error."""
    place = [(run["seconds_min"], max(run["error"], floor)) for run in runs]
    for run, (t, e) in zip(runs, place):
        better = any(stable(other) and s <= t and f <= e and (s < t or f < e) for other, (s, f) in zip(runs, place))
        run["front"] = 1 if stable(run) and not better else 0


def time_to(runs, error):
    """(seconds, spread) that a setting takes to reach an error, between two of its grids by their logarithms, and the
    largest part by which repeats differ there; None if it does not reach it. runs: of this setting, from the coarsest
    grid on."""
    before = None
    for run in filter(counts, runs):
        if run["error"] > error:
            before = run
            continue
        spread = run["seconds_max"] / run["seconds_min"]
        if before is None or run["error"] <= 0:
            return run["seconds_min"], spread
        spread = max(spread, before["seconds_max"] / before["seconds_min"])
        part = math.log(before["error"] / error) / math.log(before["error"] / run["error"])
        return before["seconds_min"] * (run["seconds_min"] / before["seconds_min"]) ** part, spread
    return None


def fastest(settings, error):
    """(seconds, spread) of the setting that reaches an error in the shortest time, of those whose runs are all stable;
    None if none does. settings: lists of runs."""
    found = [time_to(runs, error) for runs in settings if all(stable(run) for run in runs if counts(run))]
    return min((one for one in found if one), default=None, key=lambda one: one[0])


def cheapest(runs, error):
    """The stable run with the least time of those with at most this error; None."""
    return min(
        (run for run in runs if stable(run) and run["error"] <= error), default=None, key=lambda run: run["seconds_min"]
    )


def loss(own, best, error):
    """(times, least, most) as long as the best that a setting takes for an error, by the spread of the repeats; None:
    it does not reach it. Regret is this number less 1. own: its runs; best: what fastest gives."""
    mine = time_to(own, error)
    return mine and (mine[0] / best[0], mine[0] / best[0] / best[1], mine[0] / best[0] * mine[1])
