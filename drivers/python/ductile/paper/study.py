"""The runs of the study on disk: DIRECTORY/CAMPAIGN/cases/CASE, as `ductile campaign` makes them.

The campaigns are those of drivers/scenarios/paper/. How a case was computed is the part of its name
that says METHOD-NODES: "clean-36" or "paper-36".
"""
import functools
import re
from dataclasses import dataclass
from pathlib import Path

from .. import files
from ..errors import DuctileError
from ..runs import Run

METHODS = ("clean", "paper")
PAIRS = ("M1", "M2", "M3", "B1", "B2", "B3", "B4")
X_LAGS = (-0.4, -0.2, 0.0, 0.2, 0.4)
_LEAST = 14  # lines of a trajectory.csv that there is something to say of
_HOW = re.compile(r"(clean|paper)-(\d+)(?:_|$)")


@dataclass(frozen=True)
class Case:
    """A case of the study that has some rows.

    `method` is "clean", this program's own, or "paper", the paper's; `nodes` those across the
    channel. Rigid bodies are computed once: theirs are all "clean", and stand for both.
    """
    campaign: str
    name: str
    method: str
    nodes: int
    run: Run

    @functools.cached_property
    def summary(self):
        """summary.json, or {} where the run has not ended."""
        return files.read_summary(self.run.directory)

    @property
    def parameters(self):
        return self.run.parameters

    @property
    def label(self):
        """CAMPAIGN/CASE, by which it is found on disk and in the report."""
        return f"{self.campaign}/{self.name}"

    @property
    def ended(self):
        return bool(self.summary) and self.summary.get("status") not in ("interrupted", "walltime")

    def start(self, body, key="x"):
        """Where a body starts, in W."""
        return float(self.parameters[f"body.{body}.{key}"])


class Study:
    """All cases that have begun, of all campaigns in a directory."""

    def __init__(self, directory):
        """Raises DuctileError where there is no campaign in the directory."""
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise DuctileError(f"{directory}: no such directory")
        self.campaigns = sorted(path.parent.name
                                for path in self.directory.glob(f"*/{files.CAMPAIGN_FILE}"))
        if not self.campaigns:
            raise DuctileError(f"{directory}: holds no campaign of the study: compute it with  "
                               "./ductile.sh reproduce")

    @functools.cached_property
    def all_cases(self):
        found = []
        for campaign in self.campaigns:
            rows, _ = files.read_table(self.directory / campaign / files.CAMPAIGN_FILE)
            for row in rows:
                how = _HOW.search(row["case"])
                place = files.case_directory(self.directory / campaign, row["case"])
                if how and _has_samples(place / files.RUN_FILE):
                    found.append(Case(campaign, row["case"], how[1], int(how[2]), Run(place)))
        return found

    def cases(self, campaign, method=None, nodes=None, **starts):
        """Cases of a campaign, in its order, those of a method and of so many nodes alone where
        these are given, and of bodies that start at these x: cases("M2", lag=-0.2)."""
        return [case for case in self.all_cases
                if case.campaign == campaign and method in (None, case.method)
                and nodes in (None, case.nodes)
                and all(f"body.{body}.x" in case.parameters
                        and abs(case.start(body) - x) < 1e-9 for body, x in starts.items())]

    def pair(self, pair, x_lag, method, nodes=None):
        """A pair's case by a method, or None: on the coarsest lattice, which is the study's, unless
        `nodes` says another."""
        found = self.cases(pair, _method_of(pair, method), nodes, lag=x_lag)
        return self.coarsest(found)

    @staticmethod
    def coarsest(cases):
        """The case on the coarsest lattice, which is the study's own; finer ones are evidence."""
        return min(cases, key=lambda case: case.nodes, default=None)

    @staticmethod
    def finest(cases):
        """The case on the finest lattice."""
        return max(cases, key=lambda case: case.nodes, default=None)


def _has_samples(file):
    try:
        with file.open(encoding="utf-8") as lines:
            return sum(1 for _ in zip(range(_LEAST), lines)) == _LEAST
    except OSError:
        return False


def _method_of(pair, method):
    return "clean" if pair == "M3" else method
