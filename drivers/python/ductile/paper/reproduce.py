"""The paper's study by one command: computes it, then draws, judges and reports it.

    reproduce.py --program FILE [--quick | --paper] [--method clean|paper] [-o DIR] [--no-films]
                 [--finer] [--ranks N] [--at-once N]

The campaigns of drivers/scenarios/paper are run in one queue, the cases of one size: 24 to 40 nodes
across the channel with --quick, 36 by default, 90 with --paper. With --finer those pairs of the
default study whose verdict is not the paper's are then computed at 48 nodes as well. All of it goes
on where it was interrupted when the same command is given again. The exit code is that of `ductile
campaign`, or that of the report.
"""
import argparse
import shlex
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

from .. import ending
from ..errors import DuctileError
from . import making, results
from .study import METHODS, Study

CAMPAIGNS = Path(__file__).resolve().parents[3] / "scenarios" / "paper"
# Nodes across the channel, with the ends of the names of the cases that have them: of most
# campaigns, and of those that have others. A biconcave cell that starts at x = 0.4 takes 34 nodes,
# its rim being 0.12 W from the wall.
_NEAR, _FAR = ("x_-0.2", "x_0", "x_0.2"), ("x_-0.4", "x_0.4")
SIZES = {
    "quick": {"": {24: ("",)}, "B1": {24: _NEAR, 34: _FAR}, "B2": {24: _NEAR, 34: _FAR},
              "cells": {24: ("x_0.2",)}, "diagonal": {40: ("",)}},
    "default": {"": {36: ("",)}, "diagonal": {60: ("",)}, "released": {36: ("",), 60: ("",)}},
    "paper": {"": {90: ("",)}, "M3": {75: ("",)}, "rigid": {75: ("",)}, "rectangular": {75: ("",)},
              "diagonal": {120: ("",)}},
}
FINER = 48  # nodes across, with --finer
_CODES_OF_A_RESULT = (0, 1)  # of `ductile campaign`: some cases may have failed


class _Interrupted(Exception):
    """A campaign has ended otherwise than by its own end."""
    def __init__(self, code):
        super().__init__(code)
        self.code = code


def campaign_files():
    """The campaigns of the study. Raises DuctileError where they are not."""
    found = sorted(CAMPAIGNS.glob("*.toml"))
    if not found:
        raise DuctileError(f"{CAMPAIGNS}: holds no campaign of the study")
    return found


def patterns(size, methods):
    """What --only of `ductile campaign` is told, for a size and some methods."""
    found = []
    for file in campaign_files():
        campaign = tomllib.loads(file.read_text(encoding="utf-8"))
        known = campaign["axis"][0]["names"]
        own = methods if any(name.startswith("paper-") for name in known) else METHODS[:1]
        # Where a campaign has several scenarios, those come first in the names of its cases. Rigid
        # bodies have one method, which goes by the name of the clean one.
        before = "*_" if isinstance(campaign["scenario"], list) else ""
        found += [f"{file.stem}/{before}{method}-{nodes}*{end}"
                  for nodes, ends in SIZES[size].get(file.stem, SIZES[size][""]).items()
                  for end in ends for method in own if f"{method}-{nodes}" in known]
    return found


def _run(program, words):
    """Runs the program; what ends this one ends it, with checkpoints. Gives its exit code."""
    told = []
    child = None

    def end(number, frame):
        told.append(number)
        if child is not None:
            child.send_signal(signal.SIGTERM)
    before = {number: signal.signal(number, end)
              for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    try:
        child = subprocess.Popen([program, *words], start_new_session=True)
        if told:  # while it was being started
            child.send_signal(signal.SIGTERM)
        return child.wait()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Reproduction:
    def __init__(self, options):
        self.program, self.size, self.with_films = options.program, options.size, options.films
        self.with_finer = options.finer
        self.methods = METHODS if options.method is None else (options.method,)
        self.directory = options.output or Path("runs") / f"reproduce-{self.size}"
        self.words = [word for name in ("ranks", "at_once") if getattr(options, name)
                      for word in (f"--{name.replace('_', '-')}", getattr(options, name))]
        self.begun = time.monotonic()
        note = self.directory / "reproduce.json"
        known = results.settings_of(self.directory) if note.exists() else {}
        if known.get("size", self.size) != self.size:
            raise DuctileError(f"{self.directory}: holds the {known['size']} study: choose another "
                               "directory with -o")
        self.before = float(known.get("duration_s") or 0)
        self.commands = known.get("commands", [])
        command = shlex.join(["./ductile.sh", "reproduce", *options.given])
        if command not in self.commands:
            self.commands = [*self.commands, command]

    def _note(self):
        version = subprocess.run([self.program, "--version"], capture_output=True, text=True,
                                 check=True).stdout.split()[1]
        self.directory.mkdir(parents=True, exist_ok=True)
        results.write_json(self.directory / "reproduce.json", {
            "version": version, "size": self.size,
            "commands": self.commands,
            "duration_s": round(self.before + time.monotonic() - self.begun, 1)})

    def _campaign(self, only):
        words = ["campaign", *map(str, campaign_files()), "-o", str(self.directory), *self.words]
        code = _run(self.program, words + [f"--only={pattern}" for pattern in only])
        self._note()
        if code not in _CODES_OF_A_RESULT:
            raise _Interrupted(code)
        return code

    def finer(self):
        """Patterns of the pairs that are computed on a finer lattice."""
        return [f"{case.campaign}/{case.name.replace(f'-{case.nodes}', f'-{FINER}', 1)}"
                for case in results.finer_wanted(Study(self.directory), self.methods)]

    def run(self):
        """Computes and reports; gives the exit code."""
        self._note()
        code = self._campaign(patterns(self.size, self.methods))
        more = self.finer() if self.with_finer else []
        if more:
            _say(f"{len(more)} pairs are not as in the paper: they are computed at {FINER} nodes "
                 "too")
            code = max(code, self._campaign(more))
        self._note()
        before = signal.signal(signal.SIGTERM, ending.exit_by)
        file = making.make(self.directory, with_films=self.with_films, say=_say)
        signal.signal(signal.SIGTERM, before)
        print(_summary(results.read(self.directory)))
        print(f"report in {file}")
        return code


def _summary(found):
    lines = [f"{'':4}" + "".join(f"{x_lag:>22g}" for x_lag in results.X_LAGS)]
    for pair in results.PAIRS:
        cells = []
        for entry in (entry for entry in found["map"] if entry["pair"] == pair):
            ours = [run["verdict"] if run else "-" for run in entry["ours"].values()]
            mark = {"same": "", "differs": " *", "undecided": " ?", "missing": ""}
            cells.append(" / ".join(dict.fromkeys(ours if pair != "M3" else ours[:1]))
                         + mark[entry["outcome"]])
        lines.append(f"{pair:4}" + "".join(f"{cell:>22}" for cell in cells))
    for method, counts in found["counts"].items():
        lines.append(f"{method}: {counts['same']} of 35 as in the paper, {counts['differs']} not, "
                     f"{counts['undecided']} undecided, {counts['missing']} not computed")
    return "\n".join(lines)


def _say(text):
    print(text, file=sys.stderr, flush=True)


def main(arguments=None):
    parser = argparse.ArgumentParser(
        prog="ductile.sh reproduce",
        description="Computes the study of Patel & Stark, Soft Matter 17, 4804 (2021), and lays "
                    "it beside the paper. The same command goes on after an interruption.")
    parser.add_argument("--program", required=True, help=argparse.SUPPRESS)
    sizes = parser.add_mutually_exclusive_group()
    sizes.add_argument("--quick", dest="size", action="store_const", const="quick",
                       help="on lattices of 24 to 40 nodes")
    sizes.add_argument("--paper", dest="size", action="store_const", const="paper",
                       help="on the paper's lattices, of 75 to 120 nodes: for a large machine")
    parser.add_argument("--method", choices=METHODS,
                        help="one method alone: clean, this program's, or paper, the paper's")
    parser.add_argument("--finer", action="store_true",
                        help=f"the pairs whose verdict is not the paper's at {FINER} nodes too")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR",
                        help="runs/reproduce-SIZE by default")
    parser.add_argument("--no-films", dest="films", action="store_false",
                        help="draw neither films nor shapes")
    parser.add_argument("--ranks", metavar="N", help="of each run")
    parser.add_argument("--at-once", metavar="N", help="runs side by side")
    options = parser.parse_args(arguments)
    options.size = options.size or "default"
    if options.finer and options.size != "default":
        parser.error(f"--finer is for the default study alone, not --{options.size}")
    given = sys.argv[1:] if arguments is None else list(arguments)
    at = given.index("--program") if "--program" in given else len(given)
    options.given = given[:at] + given[at + 2:]
    try:
        return _Reproduction(options).run()
    except _Interrupted as interrupted:
        if interrupted.code != 2:  # which is wrong input
            _say("the same command goes on from here")
        return interrupted.code if interrupted.code > 0 else 128 - interrupted.code
    except DuctileError as error:
        _say(error)
        return 2
    except subprocess.CalledProcessError as error:
        _say(f"{error.cmd[0]} --version: exit code {error.returncode}")
        return 1
    except OSError as error:
        _say(f"{error.filename or 'reproduce'}: {error.strerror or error}")
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
