"""The map of a campaign: what came of each case, over one swept key or two."""
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from . import files, parameters
from .errors import DuctileError
from .style import GREY, VERDICT_COLOURS

# A sign for each verdict, which tells them apart in grey too.
_SIGNS = {"stable": "o", "damped": "s", "bounded": "D", "unstable": "X", "undecided": "P"}

# The states of cases whose runs have come to an end of their own, with which a verdict stands.
_ENDS = ("decided", "finished", "stopped at dz", "time limit")


def _number(text):
    try:
        return float(text)
    except ValueError:
        return None


def _places(rows, axis):
    """The values of an axis in their order, of numbers the rising one."""
    values = list(dict.fromkeys(row[axis] for row in rows))
    if all(_number(value) is not None for value in values):
        values.sort(key=_number)
    return values


def _said(text):
    value = _number(text)
    return text if value is None else parameters.number(value)


def _axis_label(key):
    name, unit = parameters.called(key)
    return f"{name}  [{unit}]" if unit else name


def draw(directory):
    """The map of the campaign in a directory, as a matplotlib Figure. Raises DuctileError."""
    rows, names = files.read_table(Path(directory) / files.CAMPAIGN_FILE)
    axes_names = files.read_axes(directory, names)
    if not 1 <= len(axes_names) <= 2:
        raise DuctileError(f"{directory}: a map has one or two axes, and the campaign sweeps "
                           f"{len(axes_names)} keys")
    if not rows:
        raise DuctileError(f"{directory}: the campaign has no cases")
    across = _places(rows, axes_names[0])
    up = _places(rows, axes_names[1]) if len(axes_names) == 2 else [""]
    size = (1.7 + 1.15 * max(len(across), 4), 1.75 + 0.95 * len(up))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots()
    taken = {}
    for row in rows:
        at = (across.index(row[axes_names[0]]),
              up.index(row[axes_names[1]]) if len(axes_names) == 2 else 0)
        if at in taken:
            raise DuctileError(f"{directory}: cases {taken[at]} and {row['case']} are at the same "
                               "place of the map")
        taken[at] = row["case"]
        _draw_case(axes, row, *at)
    axes.set_xlim(-0.5, len(across) - 0.5)
    axes.set_ylim(-0.5, len(up) - 0.5)
    axes.set_xticks(range(len(across)), [_said(value) for value in across])
    axes.set_xlabel(_axis_label(axes_names[0]))
    if len(axes_names) == 2:
        axes.set_yticks(range(len(up)), [_said(value) for value in up])
        axes.set_ylabel(_axis_label(axes_names[1]))
    else:
        axes.set_yticks([])
    axes.tick_params(length=0, top=False, right=False)
    axes.set_title(Path(directory).resolve().name, loc="left", fontsize=11, fontweight="bold")
    return figure


def _draw_case(axes, row, x, y):
    """A cell: the verdict's colour and sign, its name, and dz; of a run that has not come to its own
    end, as one that blew up or came to a contact, its state."""
    state = row.get("state", "")
    verdict = row.get("verdict", "") if state in _ENDS else ""
    colour = VERDICT_COLOURS.get(verdict, "#bbbbbb")
    axes.add_patch(Rectangle((x - 0.47, y - 0.46), 0.94, 0.92, facecolor=colour, alpha=0.22,
                             edgecolor="none", zorder=1))
    if verdict in _SIGNS:
        axes.plot(x, y + 0.2, marker=_SIGNS[verdict], markersize=8, color=colour, zorder=3,
                  linestyle="none")
    axes.text(x, y - 0.07, verdict or state or "-", ha="center", va="center",
              fontsize=9, color=colour if verdict in VERDICT_COLOURS else GREY, fontweight="bold")
    dz = _number(row.get("dz", "")) if verdict else None
    if dz is not None:
        axes.text(x, y - 0.3, f"$\\Delta z$ = {parameters.number(round(dz, 2))}", ha="center",
                  va="center", fontsize=8, color=GREY)
