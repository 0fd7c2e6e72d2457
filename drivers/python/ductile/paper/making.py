"""The report of a study in a directory, as `ductile report` makes it.

    making.py [-o FILE] [--no-films] DIRECTORY

Draws the figures into DIRECTORY/figures, shapes and films into the directories of the runs, writes
DIRECTORY/paper.json and DIRECTORY/report.html. What is newer than its run is not drawn again. The
exit code is 2 where the directory is not what it should be, packages are missing, or another process
makes the report or a film of one of the runs; 1 where a file could not be written.
"""
import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from .. import display, ending, files, films, pictures, rendering
from ..errors import DuctileError
from . import figures, report, results
from .study import METHODS, PAIRS, Study

REPORT = "report.html"
SCRIPT = Path(__file__).resolve().parents[2] / "report.py"
_MOST_AT_ONCE = 8  # processes that draw
_FILM_SIZE, _FILM_PICTURES, _FILM_FPS = (640, 240), 120, 15
_STRIP = 6  # shapes of a body


def make(directory, file=None, with_films=True, say=lambda text: None):
    """Makes the report of the study in a directory, and gives its Path.

    `say` is called with a line on what is done now and then. Raises DuctileError where there is no
    study, packages are missing, or another process makes it or a film of one of its runs; OSError
    where a file cannot be written.
    """
    directory = Path(directory)
    display.require(films.missing_packages() if with_films else [])
    study = Study(directory)
    held = os.open(directory, os.O_RDONLY)
    try:
        files.lock(held, f"{directory}: another process makes its report")
        return _make(directory, study, Path(file or directory / REPORT), with_films, say)
    finally:
        os.close(held)


def _make(directory, study, file, with_films, say):
    found = results.of(directory, results.settings_of(directory))
    report.validate(found)
    results.write(directory, found)
    say("drawing the figures")
    drawn = _figures(study, directory / "figures")
    media = _all_media(directory, _shown(study), with_films, say)
    return report.write(directory, found, drawn, media, file)


def _all_media(directory, cases, with_films, say):
    """{label: media of the case}, drawn by a process a core, each its share of the cases.

    The others' failures are left to this one, which in the end meets what they have not drawn.
    """
    shares = min(len(os.sched_getaffinity(0)), _MOST_AT_ONCE, len(cases)) if with_films else 1
    helpers = []
    try:
        for share in range(1, shares):
            helpers.append(subprocess.Popen(
                [sys.executable, SCRIPT, "--share", f"{share}/{shares}", "--", directory],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        for number, case in enumerate(cases):
            if number % 10 == 0:
                say(f"films and shapes: run {number + 1} of {len(cases)}")
            if number % max(shares, 1) == 0:
                _media(case, with_films)
        for helper in helpers:
            helper.wait()
    finally:
        for helper in helpers:  # they leave nothing half made
            helper.terminate()
        for helper in helpers:
            helper.wait()
    return {case.label: _media(case, with_films) for case in cases}


def _draw_share(directory, share):
    """What a process draws that _all_media() has started: every so many of the cases."""
    first, shares = map(int, share.split("/"))
    for case in _shown(Study(directory))[first::shares]:
        _media(case, True)


def _figures(study, folder):
    folder.mkdir(exist_ok=True)
    drawn = {}
    for name in figures.FIGURES:
        figure = figures.draw(study, name)
        if figure is None:
            continue
        file = folder / f"{name}.png"
        pictures.save(figure, file, "png")
        drawn[name] = {"file": file.resolve(), **figures.describe(study, name)}
    return drawn


def _shown(study):
    """The cases that the cells of the map show."""
    return [case for case in (study.pair(pair, x_lag, method) for pair in PAIRS
                              for x_lag in results.X_LAGS
                              for method in (METHODS if pair != "M3" else METHODS[:1]))
            if case is not None]


def _media(case, with_films):
    folder = case.run.directory.resolve()
    given = {"film": None, "poster": None, "trajectory": None, "shapes": None,
             "alt": _alt(case)}
    trajectory = folder / "trajectory.png"
    if not _is_new(trajectory, case):
        figure, _ = pictures.draw([folder])
        pictures.save(figure, trajectory, "png")
    given["trajectory"] = trajectory
    if not with_films or not films.frame_count(case.run):
        return given
    given["shapes"] = folder / "shapes.png"
    if not _is_new(given["shapes"], case):
        times = np.linspace(case.run.times[0], case.run.times[-1], _STRIP)
        strips = [rendering.shape_strip(case.run, body, times=times, size=(150, 150))
                  for body in case.run.bodies]
        _save(np.concatenate(strips), given["shapes"])
    given["film"], given["poster"] = folder / films.NAME, folder / "poster.png"
    if not (_is_new(given["film"], case) and _is_new(given["poster"], case)):
        times = case.run.times
        films.make(case.run, given["film"], fps=_FILM_FPS, size=_FILM_SIZE,
                   speed=max((times[-1] - times[0]) / _FILM_PICTURES, 1e-9) * _FILM_FPS)
        _save(rendering.image(case.run, -1, size=_FILM_SIZE), given["poster"])
    return given


def _is_new(file, case):
    """Whether a file has been made since the run's last row."""
    try:
        return file.stat().st_mtime >= (case.run.directory / "trajectory.csv").stat().st_mtime
    except OSError:
        return False


def _save(image, file):
    from matplotlib import image as images
    part = file.with_name(file.name + ".part")
    images.imsave(part, image, format="png")
    os.replace(part, file)


def _alt(case):
    bodies = case.run.bodies
    t = case.run.series(f"{bodies[0]}_x")[0]
    ends = ", ".join(f"the {'leading' if body == 'lead' else 'lagging'} body from x = "
                     f"{case.start(body):g} to {case.run.series(f'{body}_x')[1][-1]:.2f}"
                     for body in bodies)
    return (f"{case.label}: {ends} W, dz from 1 to {case.run.series('dz')[1][-1]:.2f} W, by t = "
            f"{t[-1]:.3g} W^2/nu")


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="report", description=__doc__.split("\n", 1)[0])
    parser.add_argument("directory", type=Path, metavar="DIRECTORY")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE")
    parser.add_argument("--no-films", action="store_true", help="draw neither films nor shapes")
    parser.add_argument("--share", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.share:
        return ending.code_of(lambda: _draw_share(options.directory, options.share), "the report")
    return ending.code_of(
        lambda: print(make(options.directory, options.output, not options.no_films,
                           lambda text: print(text, file=sys.stderr, flush=True))),
        "the report")


if __name__ == "__main__":
    sys.exit(main())
