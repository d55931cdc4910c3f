#!/usr/bin/env python3
"""Draws a run as a movie: every snapshot of FILE.h5 is a frame, drawn as tools/plot.py draws it, with the same colours in all.

The name of the movie decides what it is: .mp4 needs ffmpeg; .gif and .webp need nothing else. Without --out it is FILE.mp4 where
there is ffmpeg, else FILE.gif. More frames: a smaller -output_every in the scene.
"""
import argparse
import os
import shutil
import subprocess
import sys

import drawing
from drawing import STYLE, fail, np, plt
from matplotlib.animation import FFMpegWriter, PillowWriter

REMEDY = "install it (apt-get install ffmpeg) or give a name that ends in .gif"
WRITERS = {".mp4": FFMpegWriter, ".gif": PillowWriter, ".webp": PillowWriter}


def make(run, out, fps, dpi):
    """Writes a frame for each snapshot of the run."""
    aspect = drawing.aspect_of(run)
    width = min(6.4, 4.8 / aspect)
    page = np.array([max(width, 3.2) + 1.4, width * aspect + 0.8])
    page = 2 * np.ceil(page * dpi / 2) / dpi  # an even number of pixels, which MP4 needs
    figure = plt.figure(figsize=page, layout="constrained")
    axes = figure.subplots()
    colour, extend = drawing.colours(run)
    if run["dim"] > 1 and run["label"] != "band":
        figure.colorbar(colour, ax=axes, label=run["label"], extend=extend, shrink=0.9, pad=0.02, aspect=30)
    figure.suptitle(drawing.title_of(run, page[0], 10), fontsize=10)
    writer = WRITERS[os.path.splitext(out)[1]](fps=fps)
    with writer.saving(figure, out, dpi):
        for k, snapshot in enumerate(run["snapshots"]):
            axes.clear()
            drawing.draw_snapshot(axes, run, snapshot, colour)
            drawing.name_axes(axes, run)
            if k == 0:
                figure.canvas.draw()
                figure.set_layout_engine("none")  # the frames must not move
            writer.grab_frame()
    plt.close(figure)


def parser_of():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5")
    parser.add_argument("-o", "--out", metavar="MOVIE", help="FILE.mp4, .gif or .webp (default: beside FILE.h5)")
    parser.add_argument("--fps", metavar="N", help="frames a second (default: so many that the movie takes about 6 seconds, 4 to 25)")
    parser.add_argument("--dpi", metavar="N", default="100", help="pixels an inch: how large the frames are (default: 100)")
    drawing.add_arguments(parser)
    return parser


def main():
    arguments = drawing.parse(parser_of(), sys.argv[1:])
    ffmpeg = shutil.which("ffmpeg") is not None
    out = arguments.out or os.path.splitext(arguments.file)[0] + (".mp4" if ffmpeg else ".gif")
    kind = os.path.splitext(out)[1]
    if kind not in WRITERS:
        fail(f"--out {out}: its name must end in {', '.join(WRITERS)}")
    if kind == ".mp4" and not ffmpeg:
        fail(f"--out {out}: there is no ffmpeg; {REMEDY}")
    fps = None if arguments.fps is None else drawing.numbers_of("--fps", arguments.fps, 1)[0]
    dpi = drawing.numbers_of("--dpi", arguments.dpi, 1)[0]
    if fps is not None and not 0 < fps <= 60:
        fail(f"--fps {arguments.fps}: give a number above 0, at most 60")
    if not 20 <= dpi <= 600:
        fail(f"--dpi {arguments.dpi}: give a number from 20 to 600")
    run = drawing.read_run(arguments.file, arguments.field, count=None, **drawing.view_of(arguments))
    frames = len(run["snapshots"])
    fps = fps or float(np.clip(round(frames / 6), 4, 25))
    plt.rcParams.update(STYLE)
    try:
        make(run, out, fps, dpi)
    except (OSError, ValueError, subprocess.CalledProcessError) as error:
        fail(f"cannot write {out}: {error}")
    without = "" if arguments.out or ffmpeg else f"; there is no ffmpeg for MP4: {REMEDY.split(' or ')[0]}"
    print(f"{out}   {frames} frames, {frames / fps:.3g} s{without}")


if __name__ == "__main__":
    main()
