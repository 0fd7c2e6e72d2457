"""Runs and campaigns as objects, with their tables as pandas' DataFrames."""
import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from . import files
from .errors import DuctileError

# The paper's four types of a pair (Fig. 3 of Patel & Stark, Soft Matter 17, 4804, 2021), by the
# program's verdict, whose rules doc/verdict.md has.
FOUR_TYPES = {
    "stable": "stable pair",
    "damped": "stable pair with damped oscillations",
    "bounded": "stable pair with bounded oscillations",
    "unstable": "unstable pair",
}


def four_way(verdict):
    """The paper's name of a verdict of the program; None for "undecided" and for no verdict."""
    if verdict is None or pd.isna(verdict) or verdict in ("", "undecided"):
        return None
    if verdict not in FOUR_TYPES:
        raise DuctileError(f"'{verdict}' is no verdict: they are {', '.join(FOUR_TYPES)}, "
                           "undecided")
    return FOUR_TYPES[verdict]


@dataclass(frozen=True)
class Surface:
    """A body's surface at one instant.

    `vertices` [W], shape (n, 3), in the frame of trajectory.csv, z not wrapped; `triangles`, shape
    (m, 3), indices of vertices, counterclockwise from outside; `velocity` [nu/W] and `force` (of
    the body on the fluid, by vertex [rho nu^2]), shape (n, 3), or None where the frame has none.
    The arrays are the caller's.
    """
    time: float
    vertices: np.ndarray
    triangles: np.ndarray
    velocity: np.ndarray | None
    force: np.ndarray | None


class Run:
    """What is in the directory of a run, read when it is first asked for.

    A run that goes on, or that has died, is as good as one that has ended, but for its summary.
    """

    def __init__(self, directory):
        """Raises DuctileError if that is no directory of a run."""
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise DuctileError(f"{directory}: no such directory")
        if not (self.directory / files.RUN_FILE).exists():
            raise DuctileError(f"{directory}: has no {files.RUN_FILE}, and so no run")

    def __repr__(self):
        return f"<ductile run {self.directory}>"

    @functools.cached_property
    def _columns(self):
        return files.read_trajectory(self.directory / files.RUN_FILE)

    @functools.cached_property
    def table(self):
        """trajectory.csv as a DataFrame: a row a sample, columns "t", "lead_x", ... without units.

        A last line that a crash has cut off is left out. Units: `units`, and attrs["units"].
        """
        columns, units = self._columns
        table = pd.DataFrame(columns)
        table.attrs["units"] = dict(units)
        return table

    @property
    def units(self):
        """{column: unit} of the table."""
        return dict(self._columns[1])

    @property
    def bodies(self):
        """The names of the bodies, in the scenario's order."""
        return files.bodies_of(self._columns[0])

    @functools.cached_property
    def summary(self):
        """summary.json as a dict. Raises DuctileError where there is none (yet)."""
        file = self.directory / "summary.json"
        if not file.exists():
            raise DuctileError(f"{file}: not there: the run goes on, or has been killed")
        return files.read_json(file)

    @functools.cached_property
    def parameters(self):
        """All keys of the scenario by their --set names: {"channel.nodes": 36, ...}."""
        return files.read_parameters(self.directory)

    @property
    def four_way(self):
        """The paper's type of the pair, by the program's verdict; None while undecided.

        Raises DuctileError where there is no verdict: without a summary, or of no pair.
        """
        if "verdict" not in self.summary:
            raise DuctileError(f"{self.directory}: has no verdict, which only pairs get")
        return four_way(self.summary["verdict"])

    def series(self, column):
        """Times and values of a column, as arrays. Raises DuctileError if it is not there."""
        columns = self._columns[0]
        if column not in columns:
            raise DuctileError(f"{self.directory / files.RUN_FILE}: has no column {column}")
        return columns["t"].copy(), columns[column].copy()

    def _frames(self):
        import h5py  # takes its time to load
        file = self.directory / "run.h5"
        if not file.exists():
            raise DuctileError(f"{file}: not there: the run wrote no surfaces")
        try:
            return h5py.File(file, "r")
        except OSError as error:
            raise DuctileError(f"{file}: cannot be read: {error}") from None

    @functools.cached_property
    def times(self):
        """Times [W^2/nu] of the frames with the bodies' surfaces."""
        with self._frames() as file:
            return np.array([self._frame(file, n).attrs["time"]
                             for n in range(len(file["frames"]))])

    def _frame(self, file, number):
        names = sorted(file["frames"])
        if not -len(names) <= number < len(names):
            raise DuctileError(f"{self.directory}: has no frame {number}: there are {len(names)}")
        try:
            return file["frames"][names[number]]
        except (KeyError, OSError):
            raise DuctileError(f"{self.directory / 'frames' / names[number]}.h5: missing, or "
                               "cannot be read") from None

    def surfaces(self, frame):
        """The surface of every body in a frame (-1: the last): {name: Surface}."""
        with self._frames() as file:
            group = self._frame(file, frame)
            return {body: self._surface(file, group, body) for body in file["bodies"]}

    @staticmethod
    def _surface(file, group, body):
        own = group[body]
        vertices = own["position"][...]
        vertices[:, 2] += own.attrs["z_offset"]
        given = {name: own[name][...] if name in own else None for name in ("velocity", "force")}
        return Surface(float(group.attrs["time"]), vertices,
                       file[f"bodies/{body}/triangles"][...], **given)


def read_run(directory):
    """The run in a directory, as a Run. Raises DuctileError if there is none."""
    return Run(directory)


class Campaign:
    """What is in the directory of a campaign."""

    def __init__(self, directory):
        """Raises DuctileError if that is no directory of a campaign."""
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise DuctileError(f"{directory}: no such directory")
        if not (self.directory / files.CAMPAIGN_FILE).exists():
            raise DuctileError(f"{directory}: has no {files.CAMPAIGN_FILE}, and so no campaign")

    def __repr__(self):
        return f"<ductile campaign {self.directory}>"

    @functools.cached_property
    def table(self):
        """campaign.csv as a DataFrame: a row a case, of which "case" is the name.

        Columns in which all that is given are numbers hold numbers, NaN where none is given.
        """
        rows, names = files.read_table(self.directory / files.CAMPAIGN_FILE)
        table = pd.DataFrame(rows, columns=names).replace("", np.nan)
        for name in names:
            if name != "case":
                table[name] = pd.to_numeric(table[name], errors="ignore")
        return table

    @property
    def axes(self):
        """The columns of the table that were swept, by their --set names."""
        return files.read_axes(self.directory, list(self.table.columns))

    @property
    def cases(self):
        """The names of the cases."""
        return list(self.table["case"])

    def run(self, case):
        """The run of a case. Raises DuctileError if the campaign has none, or it has not begun."""
        if case not in self.cases:
            raise DuctileError(f"{self.directory}: has no case {case}")
        return Run(files.case_directory(self.directory, case))


def read_campaign(directory):
    """The campaign in a directory, as a Campaign. Raises DuctileError if there is none."""
    return Campaign(directory)
