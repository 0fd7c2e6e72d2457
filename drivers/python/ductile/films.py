"""Films of runs, as `ductile film` makes them.

    films.py [-o FILE] [--colour body|speed|force|x] [--fps N] [--size WxH] [--from T] [--to T]
             [--speed S] DIRECTORY

The directory of a run gives DIRECTORY/film.mp4, that of a campaign such a film in the directory of
each of its runs that has frames. The exit code is 2 where the directory is not what it should be,
packages are missing, or another process makes the film; 1 where a film could not be written.
"""
import argparse
import contextlib
import errno
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from . import display, ending, files, rendering
from .errors import DuctileError
from .runs import Run

NAME = "film.mp4"
FPS = 20
SIZE = (800, 300)
QUALITY = 20  # x264's constant rate factor
MOST = 20000  # pictures of a film


def missing_packages():
    """Debian's packages that films take and that are not here, as a list of names."""
    return display.missing_packages() + ([] if shutil.which("ffmpeg") else ["ffmpeg"])


def available():
    """Whether films can be made here: if VTK, Xvfb and ffmpeg are installed."""
    return not missing_packages()


def frame_count(run):
    """How many frames a run has; 0 where it wrote none."""
    return len(run.times) if (run.directory / "run.h5").exists() else 0


def _require_frames(run):
    if frame_count(run):
        return
    try:
        every = run.parameters.get("output.surfaces_every", 0)
    except DuctileError:
        every = 0
    raise DuctileError(f"{run.directory}: has no frames" + (
        " yet" if every else ": the run was made with output.surfaces_every = 0"))


def chosen_frames(run, fps=FPS, start=None, end=None, speed=None):
    """The numbers of the run's frames that a film shows, one for each of its pictures.

    Those from `start` to `end` [W^2/nu], each once; with a `speed`, so many W^2/nu a second, the
    nearest to each picture's time. Raises DuctileError where there are none.
    """
    if not 0 < fps <= 240:
        raise DuctileError(f"fps {fps:g}: must be above 0, at most 240")
    if speed is not None and not 0 < speed < np.inf:
        raise DuctileError(f"speed {speed:g}: must be above 0")
    _require_frames(run)
    times = run.times
    low, high = times[0] if start is None else start, times[-1] if end is None else end
    # As they are written and typed: with the time step's error.
    slack = 1e-6 * max(1.0, abs(times[-1]))
    within = np.flatnonzero((times >= low - slack) & (times <= high + slack))
    if not len(within):
        raise DuctileError(f"{run.directory}: has no frames from t = {low:g} to {high:g}: they go "
                           f"from {times[0]:g} to {times[-1]:g}")
    if speed is None:
        frames = within.tolist()
    else:
        begin, step = times[within[0]], speed / fps
        count = (times[within[-1]] - begin) / step
        if count > MOST:
            raise DuctileError(f"speed {speed:g}: the film would have more than {MOST} pictures")
        shown = begin + step * np.arange(int(count + 1e-6) + 1)
        frames = [int(within[np.argmin(np.abs(times[within] - time))]) for time in shown]
    if len(frames) > MOST:
        raise DuctileError(f"{run.directory}: the film would have more than {MOST} pictures")
    return frames


def _encoder(part, fps, size, said):
    """ffmpeg, which takes RGB pictures one after the other and writes the film."""
    width, height = size
    return subprocess.Popen(
        ["ffmpeg", "-v", "error", "-nostdin", "-y",
         "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:.6g}",
         "-i", "pipe:0",
         "-vf", "scale=out_color_matrix=bt709:out_range=tv", "-c:v", "libx264", "-preset", "medium",
         "-tune", "animation", "-crf", str(QUALITY), "-pix_fmt", "yuv420p",
         "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709",
         "-movflags", "+faststart", "-f", "mp4", f"file:{part}"],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said, start_new_session=True)


def _write(pictures, file, fps, size):
    """Writes the film beside its place, and puts it there when it is whole. Raises OSError, and
    DuctileError if another process is at it."""
    part = file.with_name(file.name + ".part")
    # Says what is wrong with the place better than ffmpeg does, and keeps others from writing there.
    with open(part, "ab") as held, tempfile.TemporaryFile() as said:
        files.lock(held, f"{file}: another process is making it")
        encoder = _encoder(part, fps, size, said)
        try:
            try:
                for picture in pictures:
                    encoder.stdin.write(picture.tobytes())
                encoder.stdin.close()
            except BrokenPipeError:
                pass
            if encoder.wait() != 0:
                said.seek(0)
                lines = said.read().decode(errors="replace").strip().splitlines()
                raise OSError(errno.EIO, f"ffmpeg: {lines[-1] if lines else 'failed'}", str(file))
            os.replace(part, file)
        except BaseException:
            encoder.kill()
            encoder.wait()
            with contextlib.suppress(OSError):
                encoder.stdin.close()
            part.unlink(missing_ok=True)
            raise


def make(run, file, colour="body", fps=FPS, size=SIZE, start=None, end=None, speed=None,
         view="raised", markers=True):
    """Makes a film of a run: H.264 in MP4. Gives the number of its pictures.

    `fps`: pictures a second. `size`: width and height in pixels, even numbers. `start`, `end`
    [W^2/nu] and `speed` [W^2/nu a second]: see chosen_frames. `colour`, `view` and `markers`: see
    rendering.Scene. Films that are made one after the other share a window.

    Raises DuctileError where the run has no such frames or no such field, for numbers and names
    that cannot be, where packages are missing, and if another process makes it; OSError where the file cannot be written.
    """
    file = Path(file)
    if file.suffix.lower() != ".mp4":
        raise DuctileError(f"{file}: must end in .mp4")
    if len(size) != 2 or any(n % 2 for n in size):
        raise DuctileError(f"size {'x'.join(map(str, size))}: width and height must be even")
    frames = chosen_frames(run, fps, start, end, speed)
    display.require(missing_packages())
    scene = rendering.Scene(run, sorted(set(frames)), size, colour, view, markers)

    def pictures():
        shown = last = None
        for frame in frames:
            if frame != shown:
                shown, last = frame, scene.image(frame)
            yield last
    _write(pictures(), file, fps, size)
    return len(frames)


def _runs_of(directory):
    """The runs in a directory of a run, or those of a campaign that have begun."""
    directory = Path(directory)
    if not directory.is_dir():
        raise DuctileError(f"{directory}: no such directory")
    if not (directory / files.CAMPAIGN_FILE).exists():
        if not (directory / files.RUN_FILE).exists():
            raise DuctileError(f"{directory}: holds neither a run ({files.RUN_FILE}) nor a "
                               f"campaign ({files.CAMPAIGN_FILE})")
        return [Run(directory)], False
    rows, _ = files.read_table(directory / files.CAMPAIGN_FILE)
    cases = [files.case_directory(directory, row["case"]) for row in rows]
    return [Run(case) for case in cases if (case / files.RUN_FILE).exists()], True


def make_all(directory, file=None, said=None, **options):
    """A film of the run in a directory, or of each run of a campaign that has frames.

    `file`: of a run's film; by default, and of a campaign's runs always, film.mp4 in the run's
    directory. `said`: is called with the name of each file when that is there. Options are
    make()'s. A run of a campaign of which no film can be made does not keep the others from theirs.
    Raises DuctileError and OSError as make() does, in the end.
    """
    runs, campaign = _runs_of(directory)
    if campaign and file is not None:
        raise DuctileError(f"{directory}: holds a campaign, whose films go into its runs' "
                           f"directories, and not into {file}")
    display.require(missing_packages())
    if campaign:
        runs = [run for run in runs if (run.directory / "run.h5").exists()]
        if not runs:
            raise DuctileError(f"{directory}: no run of the campaign has frames: they are made "
                               "with output.surfaces_every above 0")
    failed = []
    for run in runs:
        own = run.directory / NAME if file is None else Path(file)
        try:
            make(run, own, **options)
        except (DuctileError, OSError) as error:
            if not campaign:
                raise
            failed.append(error)
            continue
        if said is not None:
            said(own)
    if len(failed) == 1 or (failed and len(failed) == len(runs)):
        raise failed[0]
    if failed:
        raise DuctileError(f"{failed[0]}; of {len(failed)} runs in all there is no film")


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise DuctileError(message)


def _size(text):
    try:
        width, height = map(int, text.split("x"))
    except ValueError:
        raise DuctileError(f"size '{text}': must be like 800x300, in pixels") from None
    return width, height


def _options(arguments):
    parser = _Parser(prog="films", description=__doc__.split("\n", 1)[0])
    parser.add_argument("directory", type=Path, metavar="DIRECTORY")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE")
    parser.add_argument("--colour", default="body", metavar="|".join(rendering.COLOUR_BY))
    parser.add_argument("--fps", type=float, default=FPS, metavar="N")
    parser.add_argument("--size", default="x".join(map(str, SIZE)), metavar="WxH")
    parser.add_argument("--from", dest="start", type=float, metavar="T", help="W^2/nu")
    parser.add_argument("--to", dest="end", type=float, metavar="T", help="W^2/nu")
    parser.add_argument("--speed", type=float, metavar="S", help="W^2/nu a second")
    return parser.parse_args(arguments)


def main(arguments=None):
    def work():
        options = _options(arguments)
        make_all(options.directory, options.output, lambda file: print(file, flush=True),
                 colour=options.colour, fps=options.fps, size=_size(options.size),
                 start=options.start, end=options.end, speed=options.speed)
    return ending.code_of(work, "the film")


if __name__ == "__main__":
    sys.exit(main())
