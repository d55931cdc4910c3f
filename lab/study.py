#!/usr/bin/env python3
"""Studies of a scene: what runs it many times.

  pebble-study convergence my.opts    a series of runs, each twice as fine as the one before: errors, differences, orders
  pebble-study trade my.opts          error, time and memory of methods on a series of grids, and the cheapest setting
                                      for an error
  pebble-study stability my.opts      the largest stable time steps of methods, at rest and where particles cross cells
  pebble-study limit my.opts          how much load, gravity, or loss of strength a body bears, by static runs on several
                                      grids

Options of the study have two dashes, those of Pebble one: they replace options of the scene. A study that was
interrupted goes on with the same command: runs that its table has are not made again."""

import argparse
import os
import signal
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, HERE)
try:
    import pebble_mpm as pebble
    from pebble_study import scene
    from pebble_study.convergence import Convergence
    from pebble_study.limit import Limit, static
    from pebble_study.quantity import Quantity
    from pebble_study.stability import Stability
    from pebble_study.trade import Trade
except ModuleNotFoundError as missing:
    if (missing.name or "").startswith("pebble"):
        raise
    sys.exit(
        f"pebble-study: {missing}; it needs the Python packages h5py, matplotlib and numpy: install Debian's "
        "python3-h5py and python3-matplotlib, or "
        "activate a virtual environment and install those of "
        f"{os.path.normpath(os.path.join(HERE, '..', 'tools', 'requirements.txt'))} with pip"
    )


class Study:
    """What all studies share: the scene and its options, the folder of the results, and where lines go."""

    def __init__(self, words, pebbles):
        self.words, self.processes, self.warned = words, words.processes, set()
        if words.program:
            if not (os.path.isfile(words.program) and os.access(words.program, os.X_OK)):
                raise scene.Refused(f"--program {words.program}: there is no such program")
            os.environ["PEBBLE"] = os.path.abspath(words.program)
        given = ["-options_file", words.scene, *pebbles]
        self.options, self.aside = (
            static(given, self.processes) if words.study == "limit" else (scene.database(given, self.processes), [])
        )
        self.dry = words.dry_run or "-dry_run" in pebbles
        if "time_max_steps" in self.options:
            raise scene.Refused("-time_max_steps does not apply: the runs of a study end at the same time, -time_end")
        for name in ("checkpoint_every", "checkpoint_steps", "restart_file"):
            if name in self.options:
                raise scene.Refused(
                    f"-{name} does not apply: the runs of a study begin at their start and write no checkpoints"
                )
        for name in scene.bodies(self.options):
            if self.options.get(f"body_{name}_shape") == "file":
                raise scene.Refused(
                    f"a study does not apply: the particles of {name} come from a file, and cannot be made finer"
                )
        self.facts = scene.Facts(self.options, self.processes)
        if self.facts.refused:
            raise scene.Refused(self.facts.refused)
        self.known = any(self.options.get(name, "none") != "none" for name in ("mms_type", "reference_type"))
        self.folder = self.options.get("output_dir", "output")
        self.name = self.options.get("output_name") or os.path.splitext(os.path.basename(words.scene))[0]
        self.facts.title = self.options.get("scene_title") or self.name
        self.quantity = Quantity(getattr(words, "quantity", None), getattr(words, "value", None))
        if self.quantity.on:
            self.quantity.check(
                scene.begun(self.options, self.processes)[1], self.options, getattr(words, "vary", "") == "dt"
            )
        elif getattr(words, "value", None) is not None:
            raise scene.Refused("--value does not apply: it is that of --quantity")
        if not self.dry:
            try:
                os.makedirs(self.folder, exist_ok=True)
            except OSError as fault:
                raise scene.Refused(f"-output_dir {self.folder}: {fault.strerror}") from None

    def path(self, end):
        return os.path.join(self.folder, self.name + end)

    def say(self, line):
        print(line.rstrip(), flush=True)

    def warn(self, result):
        """Says what a run warned of, each text once."""
        for text in result.warnings:
            if text not in self.warned:
                self.warned.add(text)
                self.say(f"warning    {text}")

    def complain(self, line):
        print(line, file=sys.stderr, flush=True)

    def end(self, path, no_plot=""):
        """Names the table, and draws it where matplotlib is there."""
        self.say(f"results    {path}")
        if no_plot:
            self.say(f"           no picture of it: {no_plot}")
            return
        plot = os.path.join(HERE, "..", "tools", "plot.py")
        drawn = pebble.subprocess.run([sys.executable, plot, path], capture_output=True, text=True)
        picture = path.removesuffix(".csv") + ".png"
        self.say(
            f"           {picture}"
            if drawn.returncode == 0
            else f"           not drawn: {(drawn.stderr.strip().splitlines() or ['?'])[-1]}"
        )


def parser_of():
    parser = argparse.ArgumentParser(
        prog="pebble-study",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        usage="pebble-study trade|convergence|stability|limit my.opts [--option value ...] [-pebble_option value ...]",
    )
    parser.add_argument("study", choices=["trade", "convergence", "stability", "limit"])
    parser.add_argument("scene", help="options file of the scene")
    parser.add_argument("--processes", type=int, default=1, metavar="N", help="processes of each run (1)")
    parser.add_argument(
        "--program", metavar="PATH", help="the program (the one of this folder or installation, or of PATH)"
    )
    parser.add_argument("--dry-run", action="store_true", help="check all options, list the runs, make no step")
    parser.add_argument(
        "--levels",
        type=int,
        metavar="N",
        help="convergence, trade, limit: grids, each twice as fine as the one before (4; limit: 3)",
    )
    several = parser.add_argument_group("convergence and trade")
    several.add_argument(
        "--quantity",
        metavar="COLUMN[:max|min|end]",
        help="what is compared instead of the displacement: a column of the history",
    )
    several.add_argument(
        "--value", type=float, metavar="X", help="the known value of --quantity; else the finest run has it"
    )
    one = parser.add_argument_group("convergence")
    one.add_argument(
        "--vary",
        choices=["grid", "dt", "ppc"],
        default="grid",
        help="what is refined: cells and time step, the time step alone, or particles per cell",
    )
    one.add_argument(
        "--order-min", type=float, metavar="P", help="exit status 3 if the order of the last pair is smaller"
    )
    many = parser.add_argument_group("trade and stability")
    many.add_argument(
        "--basis",
        metavar="LIST",
        help="values of -method_basis, or gimp_stretch (trade: all that the program has; stability: the scene's)",
    )
    many.add_argument("--update", metavar="LIST", help="values of -method_update (usl,musl; the scene's)")
    many.add_argument(
        "--transfer",
        metavar="LIST",
        help="values of -method_transfer, with :number for -method_flip or -method_order, as in flip:0.99 "
        "(flip,apic,aflip; the scene's)",
    )
    work = parser.add_argument_group("trade")
    work.add_argument(
        "--preset",
        metavar="LIST",
        help="values of -method_preset, each with its particles and, without --cfl, its -dt_cfl; or none (all); without --basis, --update, --transfer and --ppc only two methods are beside them",
    )
    work.add_argument("--ppc", metavar="LIST", help="particles per cell and axis (the scene's)")
    work.add_argument("--cfl", metavar="LIST", help="values of -dt_cfl (the scene's)")
    work.add_argument(
        "--coarser",
        type=int,
        default=0,
        metavar="N",
        help="the first grid has cells 2^N times as large as those of the scene (0)",
    )
    work.add_argument(
        "--repeats",
        type=int,
        default=2,
        metavar="N",
        help="how often each run is made, to see how much its time varies (2)",
    )
    last = parser.add_argument_group("stability")
    last.add_argument(
        "--steps",
        type=int,
        default=20000,
        metavar="N",
        help="steps of a run; a body at rest and blocks make a part of them, which the study prints (20000)",
    )
    fall = parser.add_argument_group("limit")
    fall.add_argument(
        "--raise",
        dest="raised",
        choices=["load", "gravity"],
        help="what grows until the body fails: all that grows in the scene, to its -time_end (load); or gravity, as far "
        "as it takes",
    )
    fall.add_argument(
        "--reduce",
        choices=["strength"],
        help="instead, the strength is divided by a factor: cohesion and tan(friction_angle) of druckerprager, yield of "
        "vonmises",
    )
    fall.add_argument(
        "--tolerance", type=float, default=0.01, metavar="X", help="width of the bracket of the factor, as a part (0.01)"
    )
    fall.add_argument(
        "--softer",
        type=float,
        default=30,
        metavar="N",
        help="the body flows, and has failed, where it yields more than N times as much as at first for an equal part of "
        "the load (30); also where no equilibrium is found",
    )
    return parser


BELONGS = {
    "levels": "ctl",
    "quantity": "ct",
    "value": "ct",
    "vary": "c",
    "order_min": "c",
    "basis": "ts",
    "update": "ts",
    "transfer": "ts",
    "steps": "s",
    "preset": "t",
    "ppc": "t",
    "cfl": "t",
    "coarser": "t",
    "repeats": "t",
    "raised": "l",
    "reduce": "l",
    "tolerance": "l",
    "softer": "l",
}
RANGES = {
    "levels": (2, 12),
    "steps": (100, 10000000),
    "coarser": (0, 10),
    "repeats": (1, 100),
    "processes": (1, 1000000),
    "tolerance": (1e-4, 0.5),
    "softer": (2, 1e6),
}


def read_words(argv):
    """The words of the study, and those of Pebble: a name with one dash and the value behind it."""
    own, pebbles, k = [], [], 0
    while k < len(argv):
        word, following = argv[k], argv[k + 1] if k + 1 < len(argv) else None
        if word in ("-h", "-help", "--help"):
            own.append("--help")
        elif word.startswith("-") and not word.startswith("--"):
            pebbles.append(word)
            if (
                following is not None
                and not following.startswith("--")
                and (not following.startswith("-") or following[1:2].isdigit() or following[1:2] == ".")
            ):
                pebbles.append(following)
                k += 1
        else:
            own.append(word)
            if word.startswith("--") and following is not None and following[:1] == "-" and following[1:2].isdigit():
                own[-1] += "=" + following
                k += 1
        k += 1
    parser = parser_of()
    words = parser.parse_args(own)
    for name, studies in BELONGS.items():
        if getattr(words, name) != parser.get_default(name) and words.study[0] not in studies:
            parser.error(f"--{name.replace('_', '-').replace('raised', 'raise')} is of another study than {words.study}")
    for word in pebbles:
        if word[:1] == "-" and word != "-dry_run" and hasattr(words, word[1:].replace("-", "_")):
            parser.error(f"{word} is an option of the study: write it with two dashes, -{word}")
    limit = words.study == "limit"
    words.levels = words.levels if words.levels is not None else 3 if limit else 4
    for name, (least, most) in RANGES.items():
        least = 1 if limit and name == "levels" else least
        if not least <= getattr(words, name) <= most:
            parser.error(f"--{name} {getattr(words, name)} is outside the allowed range {least} <= {name} <= {most}")
    return words, pebbles


def interrupted(*_):
    raise KeyboardInterrupt


def main():
    words, pebbles = read_words(sys.argv[1:])
    signal.signal(signal.SIGTERM, interrupted)
    try:
        study = Study(words, pebbles)
        return {"convergence": Convergence, "limit": Limit, "stability": Stability, "trade": Trade}[words.study](study).run()
    except (scene.Refused, FileNotFoundError) as refused:
        print(refused, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted by a signal; the same command goes on with the runs that are left", file=sys.stderr)
        return 3


if __name__ == "__main__":
    sys.exit(main())
