"""pebble-study in the process of a test, which has the libraries already, and which starts the program as tests do.

    import studying
    studying.prepare()                                   # after check.arguments
    told = studying.study("convergence", "bar.opts", "--levels", "3")      # a check.Run, as of the command
"""
import contextlib
import io
import os
import sys

import check
import mpi

lab = end = None


def start(command, processes=1, timeout=None):
    """pebble_mpm.start as tests start the program."""
    return mpi.run(processes, command, timeout or check.TIMEOUT, check.mpiexec)


def prepare():
    global lab, end
    os.environ.update(mpi.ENVIRONMENT | dict(os.environ) | {"PEBBLE": check.program, "MPIEXEC": check.mpiexec})
    sys.path.insert(0, os.path.join(check.source, "lab"))
    import pebble_mpm
    import study

    pebble_mpm.start = start
    lab, end = study, study.Study.end


def study(kind, scene, *words, draws=False):
    """Most make no picture, which takes longer than their runs."""
    own, sys.argv = sys.argv, ["pebble-study", kind, scene, *words]
    lab.Study.end = end if draws else lambda study, path, no_plot="": None
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = lab.main()
        except SystemExit as ends:  # of argparse
            status = ends.code
    sys.argv = own
    return check.Run(status, out.getvalue(), err.getvalue())
