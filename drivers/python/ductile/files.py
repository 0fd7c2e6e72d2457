"""The files of runs and campaigns, as plain arrays and dicts: with numpy, and nothing slower.

The objects that users hold are in runs.py; pictures are drawn from these.
"""
import csv
import fcntl
import json
import re
from pathlib import Path

import numpy as np

from .errors import DuctileError

# What identifies each kind of directory.
RUN_FILE = "trajectory.csv"
CAMPAIGN_FILE = "campaign.csv"
COMPARISON_FILE = "compare.json"


def lock(opened, said):
    """Keeps an open file, or a descriptor, from other processes until it is closed. Raises
    DuctileError with what is `said` if one has it; a file system without locks keeps nobody out."""
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise DuctileError(said) from None
    except OSError:
        pass


def read_text(file):
    """The text of a file. Raises DuctileError."""
    try:
        return Path(file).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise DuctileError(f"{file}: no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise DuctileError(f"{file}: cannot be read: {error}") from None


def read_json(file):
    """The object in a JSON file. Raises DuctileError."""
    text = read_text(file)
    try:
        value = json.loads(text)
    except ValueError as error:
        raise DuctileError(f"{file}: is no JSON: {error}") from None
    if not isinstance(value, dict):
        raise DuctileError(f"{file}: holds no JSON object")
    return value


def read_trajectory(file):
    """Columns and units of a trajectory.csv: two dicts by the columns' names without units.

    The columns are arrays of doubles, as long as there are whole lines: one that a crash has cut
    off, which has no end of line, is left out. Raises DuctileError.
    """
    text = read_text(file)
    lines = text[:text.rfind("\n") + 1].splitlines()
    if not lines:
        raise DuctileError(f"{file}: holds no whole line")
    columns = [re.fullmatch(r"([^\[\]]+)(?:\[(.*)\])?", name) for name in lines[0].split(",")]
    if not all(columns) or columns[0][1] != "t":
        raise DuctileError(f"{file}: its first line is not the header of a trajectory")
    names = [column[1] for column in columns]
    if len(lines) == 1:
        raise DuctileError(f"{file}: holds no samples")
    try:
        values = np.loadtxt(lines[1:], delimiter=",", ndmin=2)
    except ValueError as error:
        raise DuctileError(f"{file}: {error}") from None
    if values.shape[1] != len(names):
        raise DuctileError(f"{file}: has {values.shape[1]} numbers a line under {len(names)} names")
    return dict(zip(names, values.T)), {c[1]: c[2] or "" for c in columns}


def bodies_of(columns):
    """The names of the bodies of a trajectory, in the scenario's order."""
    return [name[:-2] for name in columns if name.endswith("_x")
            and f"{name[:-2]}_vx" in columns]


def read_table(file):
    """The rows of a campaign.csv as dicts of strings, and the names of its columns without units.

    A last line without an end is left out. Raises DuctileError.
    """
    text = read_text(file)
    rows = list(csv.reader(text[:text.rfind("\n") + 1].splitlines()))
    if not rows:
        raise DuctileError(f"{file}: holds no whole line")
    names = [re.sub(r"\[[^\]]*\]$", "", name) for name in rows[0]]
    if "case" not in names:
        raise DuctileError(f"{file}: has no column 'case'")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(names):
            raise DuctileError(
                f"{file}: line {number} has {len(row)} fields under {len(names)} names")
    return [dict(zip(names, row)) for row in rows[1:]], names


def read_axes(directory, names):
    """The columns of a campaign that were swept, by its campaign.json. Raises DuctileError."""
    file = Path(directory) / "campaign.json"
    axes = read_json(file).get("axes")
    if not isinstance(axes, list) or not all(isinstance(axis, str) for axis in axes):
        raise DuctileError(f"{file}: has no list \"axes\" of the swept columns")
    for axis in axes:
        if axis not in names:
            raise DuctileError(f"{file}: names the axis {axis}, which {CAMPAIGN_FILE} has not")
    return axes


def case_directory(directory, case):
    return Path(directory) / "cases" / case


def read_summary(directory):
    """summary.json of a run, or {} where there is none (yet): the run goes on, or was killed."""
    file = Path(directory) / "summary.json"
    return read_json(file) if file.exists() else {}


def read_parameters(directory, summary=None):
    """The flat dict of a run's scenario: {"channel.nodes": 36, "body.lag.x": -0.2, ...}.

    From summary.json where that has it, else from scenario.toml. Raises DuctileError.
    """
    summary = read_summary(directory) if summary is None else summary
    if isinstance(summary.get("parameters"), dict):
        return summary["parameters"]
    import tomllib  # not needed where there is a summary
    file = Path(directory) / "scenario.toml"
    try:
        return flattened(tomllib.loads(read_text(file)))
    except tomllib.TOMLDecodeError as error:
        raise DuctileError(f"{file}: is no TOML: {error}") from None


def flattened(scenario):
    """A scenario's tables as one flat dict of --set's keys; of bodies body.NAME.key."""
    flat = {}
    for key, value in scenario.items():
        if key == "body":
            for number, body in enumerate(value, 1):
                name = body.get("name", f"body{number}")
                flat.update({f"body.{name}.{k}": v for k, v in body.items() if k != "name"})
        elif isinstance(value, dict):
            flat.update({f"{key}.{k}": v for k, v in value.items()})
        else:
            flat[key] = value
    return flat
