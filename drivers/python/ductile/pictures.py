"""Pictures of results, as `ductile plot` and the end of every run draw them.

    pictures.py [-o FILE] [--format png|pdf|svg] [--map] [--quiet] DIRECTORY ...

One directory of a run gives DIRECTORY/trajectory.FORMAT, one of a comparison
DIRECTORY/compare.FORMAT, one of a campaign DIRECTORY/overlay.FORMAT with its cases over each other,
or, with --map, DIRECTORY/map.FORMAT with what came of each. Several directories are drawn over each
other into overlay.FORMAT. The exit code is 2 where the directories are not what they should be.
"""
import argparse
import os
import sys
from pathlib import Path

import matplotlib

from . import comparisons, files, maps, trajectories
from .errors import DuctileError
from .style import SETTINGS

FORMATS = ("png", "pdf", "svg")


def kind_of(directory):
    """"run", "campaign" or "comparison". Raises DuctileError for other directories."""
    directory = Path(directory)
    if not directory.is_dir():
        raise DuctileError(f"{directory}: no such directory")
    for kind, file in (("campaign", files.CAMPAIGN_FILE), ("comparison", files.COMPARISON_FILE),
                       ("run", files.RUN_FILE)):
        if (directory / file).exists():
            return kind
    raise DuctileError(f"{directory}: holds neither a run ({files.RUN_FILE}) nor a campaign "
                       f"({files.CAMPAIGN_FILE}) nor a comparison ({files.COMPARISON_FILE})")


def _runs_of(directory):
    """The runs in a directory of a run, or of a campaign as far as they have begun."""
    kind = kind_of(directory)
    if kind == "comparison":
        raise DuctileError(f"{directory}: holds a comparison, which has a picture of its own")
    if kind == "run":
        return [trajectories.read(directory)]
    rows, _ = files.read_table(Path(directory) / files.CAMPAIGN_FILE)
    runs = []
    for row in rows:
        case = files.case_directory(directory, row["case"])
        if (case / files.RUN_FILE).exists():
            try:
                runs.append(trajectories.read(case))
            except DuctileError:  # its first sample is still to come
                continue
    if not runs:
        raise DuctileError(f"{directory}: no case of the campaign has samples yet")
    return runs


def draw(directories, as_map=False):
    """The picture of some directories, as a matplotlib Figure, and the name of its file, without
    its ending. Raises DuctileError."""
    directories = [Path(directory) for directory in directories]
    first = directories[0]
    with matplotlib.rc_context(SETTINGS):
        if as_map:
            if len(directories) > 1 or kind_of(first) != "campaign":
                raise DuctileError(f"{first}: a map is drawn of one campaign "
                                   f"({files.CAMPAIGN_FILE})")
            return maps.draw(first), first / "map"
        if len(directories) > 1:
            runs = [run for directory in directories for run in _runs_of(directory)]
            return trajectories.draw_overlay(runs), Path("overlay")
        kind = kind_of(first)
        if kind == "comparison":
            return comparisons.draw(first), first / "compare"
        runs = _runs_of(first)
        if kind == "run":
            return trajectories.draw_run(runs[0]), first / "trajectory"
        _, names = files.read_table(first / files.CAMPAIGN_FILE)
        axes = files.read_axes(first, names)
        return trajectories.draw_overlay(runs, first.resolve().name, axes), first / "overlay"


def save(figure, file, form):
    """Writes the picture beside its place, and puts it there when it is whole."""
    part = file.with_name(file.name + ".part")
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(part, format=form, dpi=150)
    os.replace(part, file)


def chosen_format(file, form):
    """The format of a picture: as given, or that of the file's ending, or png."""
    ending = file.suffix[1:].lower() if file is not None else ""
    if form is None:
        if file is not None and ending not in FORMATS:
            raise DuctileError(f"{file}: must end in .{', .'.join(FORMATS[:-1])} or "
                               f".{FORMATS[-1]}, or --format must say what it is to be")
        return ending or FORMATS[0]
    if ending in FORMATS and ending != form:
        raise DuctileError(f"{file}: is to be {form}, by --format, and ends in .{ending}")
    return form


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="pictures", description=__doc__.split("\n", 1)[0])
    parser.add_argument("directories", nargs="+", metavar="DIRECTORY")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE")
    parser.add_argument("--format", choices=FORMATS)
    parser.add_argument("--map", action="store_true")
    parser.add_argument("--quiet", action="store_true", help="do not print where the picture is")
    options = parser.parse_args(arguments)
    try:
        form = chosen_format(options.output, options.format)
        figure, usual = draw(options.directories, options.map)
        file = options.output or usual.with_name(f"{usual.name}.{form}")
        save(figure, file, form)
    except DuctileError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{str(error.filename or 'the picture').removesuffix('.part')}: "
              f"{error.strerror or error}", file=sys.stderr)
        return 1
    if not options.quiet:
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
