"""The pictures of runs: one run by itself, or several over each other.

Lateral positions against time, for a pair the axial distance, and for capsules the strain energy:
the layout of Fig. 6 of Patel & Stark, Soft Matter 17, 4804 (2021).
"""
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from . import files, parameters
from .errors import DuctileError
from .style import (BLACK, COLOURS, GREY, NAMES, PALE, STYLES, VERDICT_COLOURS, colours_of, grid,
                    margin_labels, zero_line)

WIDTH = 7.2
MOVES = 0.01  # from so much [W] on y is drawn


@dataclass
class Drawn:
    """A run as a picture sees it."""
    directory: Path
    data: dict
    summary: dict
    parameters: dict

    @property
    def bodies(self):
        return files.bodies_of(self.data)

    @property
    def name(self):
        # Runs that ended before summaries had parameters may have files of other names.
        return str(self.parameters.get("name") or self.summary.get("scenario")
                   or self.directory.resolve().name)

    @property
    def outcome(self):
        """Verdict, or how it failed; and the reason."""
        if self.summary.get("status") == "blew up":
            blow_up = self.summary.get("blow_up", {})
            return "blew up", f"at step {blow_up.get('step')}: {blow_up.get('reason', '')}"
        if self.summary.get("contact_reason"):
            return "contact", self.summary["contact_reason"]
        return self.summary.get("verdict"), self.summary.get("verdict_reason", "")

    def limit_of_x(self, body):
        """(value, error) [W] that the program extrapolates x to, or None. A summary of an older
        program has no error: then it is 0."""
        for own in self.summary.get("bodies", []):
            if own.get("name") == body and own.get("x_limit_W") is not None:
                return own["x_limit_W"], own.get("x_limit_error_W") or 0.0
        return None

    @property
    def limit_of_dz(self):
        """(value, error) [W] that the verdict extrapolates dz to, or None."""
        limit = self.summary.get("dz_limit_W")
        return None if limit is None else (limit, self.summary["dz_limit_error_W"])


def read(directory):
    """The run in a directory; what is not there yet, or cut off, is left out. Raises DuctileError
    where there is no trajectory."""
    directory = Path(directory)
    data, _ = files.read_trajectory(directory / files.RUN_FILE)
    if not files.bodies_of(data):
        raise DuctileError(f"{directory / files.RUN_FILE}: has no bodies to draw")

    def unless_broken(reader, *arguments):
        try:
            return reader(*arguments)
        except DuctileError:
            return {}
    summary = unless_broken(files.read_summary, directory)
    return Drawn(directory, data, summary, unless_broken(files.read_parameters, directory, summary))


def _moves(run, body):
    y = run.data.get(f"{body}_y")
    return y is not None and np.nanmax(y) - np.nanmin(y) > MOVES


def _panels(runs):
    """(kind, height) of each."""
    panels = [("x", 3.2)]
    if any(_moves(run, body) for run in runs for body in run.bodies):
        panels.append(("y", 1.5))
    if any("dz" in run.data for run in runs):
        panels.append(("dz", 2.6))
    if any(f"{body}_strain_energy" in run.data for run in runs for body in run.bodies):
        panels.append(("strain", 1.5))
    return panels


def _figure(panels, above=0.0):
    """A figure and its axes by kind; `above`, inches for what is above the panels beyond a few
    lines."""
    height = sum(height for _, height in panels) + 1.0 + above
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False,
                           gridspec_kw={"height_ratios": [height for _, height in panels]})[:, 0]
    for panel in axes:
        grid(panel)
    return figure, dict(zip((kind for kind, _ in panels), axes))


def _line(run, index, body, colours, several):
    """Colour and style: of one run colours and styles are bodies, of several colours are runs."""
    b = run.bodies.index(body)
    return {"color": colours[index] if several else COLOURS[b % len(COLOURS)],
            "linestyle": STYLES[b % len(STYLES)]}


def _draw_lateral(axes, runs, colours, axis):
    zero_line(axes)
    several = len(runs) > 1
    largest = 0.0
    for index, run in enumerate(runs):
        t = run.data["t"]
        for body in run.bodies:
            values = run.data[f"{body}_{axis}"]
            style = _line(run, index, body, colours, several)
            axes.plot(t, values, linewidth=1.8 if axis == "x" and not several else 1.4,
                      label=NAMES.get(body, body), **style)
            if axis == "x":
                axes.plot(t[0], values[0], "o", color=style["color"], markersize=4, clip_on=False)
            if len(values[np.isfinite(values)]):
                largest = max(largest, np.nanmax(np.abs(values)))
    axes.set_ylabel(("lateral position  " if axis == "x" else "") + f"${axis}/W$")
    if axis == "x" and largest < 1:
        for low, high in ((-1.12, -1), (1, 1.12)):
            axes.axhspan(low, high, facecolor="#dddddd", edgecolor="#888888", hatch="////",
                         linewidth=0)
            axes.axhline(np.sign(low) * 1, color=BLACK, linewidth=1.2)
        axes.set_ylim(-1.12, 1.12)
    elif axis == "y":
        axes.set_ylim(*(1.15 * np.array(axes.get_ylim())))


def _draw_distance(axes, runs, colours):
    low, high = 0.0, 1.5
    for index, run in enumerate(runs):
        dz = run.data.get("dz")
        if dz is None:
            continue
        axes.plot(run.data["t"], dz, color=colours[index] if len(runs) > 1 else BLACK,
                  linewidth=1.8 if len(runs) == 1 else 1.4)
        low, high = min(low, np.nanmin(dz)), max(high, np.nanmax(dz))
    limits = [run.limit_of_dz for run in runs if run.limit_of_dz]
    high = max([high] + [value for value, _ in limits])
    axes.set_ylabel(r"axial distance  $\Delta z/W$")
    axes.set_ylim(low - (0.08 * (high - low) if low < 0 else 0), low + 1.15 * (high - low))
    if low < 0:
        zero_line(axes)


def _draw_strain(axes, runs, colours):
    highest = 0.0
    for index, run in enumerate(runs):
        for body in run.bodies:
            values = run.data.get(f"{body}_strain_energy")
            if values is None:
                continue
            if np.any(np.isfinite(values)):
                highest = max(highest, np.nanmax(values))
            axes.plot(run.data["t"], 1e3 * values, linewidth=1.2,
                      **_line(run, index, body, colours, len(runs) > 1))
    axes.set_ylabel("strain energy\n" + r"$10^3\,E_s/k_s a^2$")
    axes.set_ylim(0, 1.15e3 * highest if highest > 0 else 1)


def _draw(panels, runs, colours):
    for kind, axes in panels.items():
        if kind in ("x", "y"):
            _draw_lateral(axes, runs, colours, kind)
        elif kind == "dz":
            _draw_distance(axes, runs, colours)
        else:
            _draw_strain(axes, runs, colours)
    bottom = list(panels.values())[-1]
    bottom.set_xlabel(r"time  $t\,\nu/W^2$")
    begin, end = (pick(run.data["t"][n] for run in runs) for pick, n in ((min, 0), (max, -1)))
    if end > begin:
        bottom.set_xlim(begin, end)


def _with_error(value, error):
    """A limit as a short text."""
    if not error > 0:
        return f"{value:.3f}".replace("-", "\N{MINUS SIGN}")
    digits = int(np.clip(np.ceil(-np.log10(error / 1.5)), 1, 4))  # 0.012, but 0.03
    return f"{value:.{digits}f} ± {error:.{digits}f}".replace("-", "\N{MINUS SIGN}")


def _say_limits(panels, run):
    """Where the program extrapolates x and dz to, or else where one of them ends."""
    entries = []
    for b, body in enumerate(run.bodies):
        limit = run.limit_of_x(body)
        if limit is not None and len(run.bodies) <= len(COLOURS):
            entries.append((*limit, "→ " + _with_error(*limit), COLOURS[b]))
    x = run.data[f"{run.bodies[0]}_x"][-1]
    if not entries and len(run.bodies) == 1 and np.isfinite(x):
        entries.append((x, None, _with_error(x, 0), BLACK))
    margin_labels(panels["x"], entries)
    if "dz" not in panels:
        return
    limit, dz = run.limit_of_dz, run.data["dz"][-1]
    if limit is not None:
        margin_labels(panels["dz"], [(*limit, "→ " + _with_error(*limit), BLACK)])
    elif np.isfinite(dz):
        margin_labels(panels["dz"], [(dz, None, f"{dz:.2f}".replace("-", "\N{MINUS SIGN}"), BLACK)])


def _heading(axes, title, verdict, lines):
    """Above a panel: a title, the verdict at the right, and small lines under them."""
    pad = 8 + 12.5 * len(lines)
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold", pad=pad)
    if verdict:
        axes.set_title(verdict, loc="right", fontsize=11, fontweight="bold", pad=pad,
                       color=VERDICT_COLOURS.get(verdict, "#D55E00"))
    for n, (line, colour) in enumerate(reversed(lines)):
        axes.annotate(line, (0, 1), xycoords="axes fraction", textcoords="offset points",
                      xytext=(0, 5 + 12.5 * n), fontsize=8.5, color=colour, va="bottom",
                      annotation_clip=False)


def draw_run(run):
    """The picture of one run, as a matplotlib Figure."""
    figure, panels = _figure(_panels([run]))
    _draw(panels, [run], [BLACK])
    if len(run.bodies) > 1:
        panels["x"].legend(loc="upper right", bbox_to_anchor=(1, 0.94),
                           ncol=min(len(run.bodies), 6), handlelength=2.6, columnspacing=1.4)
    verdict, reason = run.outcome
    lines = [(line, BLACK) for line in parameters.wrapped(parameters.headline(run.parameters), 98)]
    lines += [(line, GREY) for line in textwrap.wrap(reason.replace("+-", "±"), 98, max_lines=2,
                                                     placeholder=" ...")]
    _heading(panels["x"], run.name, verdict, lines)
    figure.align_ylabels(list(panels.values()))
    _say_limits(panels, run)
    return figure


def told_apart(runs, keys=None):
    """What tells each of several runs from the others: labels, and the values of the keys that do,
    a dict for each run. By default all keys that differ; without any the directories' names."""
    if keys:
        values = [{key: run.parameters.get(key) for key in keys} for run in runs]
    else:
        values = parameters.differences([run.parameters for run in runs])
    labels = [", ".join(parameters.said(*item) for item in value.items()) for value in values]
    if "" in labels or len(set(labels)) < len(runs):
        return [run.directory.resolve().name for run in runs], [{} for _ in runs]
    return labels, values


def draw_overlay(runs, title=None, keys=None):
    """The picture of several runs over each other: colours are runs, line styles are bodies; the
    legend has what differs between their parameters, or those `keys`. A matplotlib Figure."""
    labels, values = told_apart(runs, keys)
    values = [tuple(value.values()) for value in values]
    if all(len(value) == 1 and isinstance(value[0], (int, float)) for value in values):
        order = sorted(range(len(runs)), key=lambda n: values[n])
        runs, labels = [runs[n] for n in order], [labels[n] for n in order]
    colours = colours_of(len(runs))
    handles = []
    for run, label, colour in zip(runs, labels, colours):
        outcome = run.outcome[0]
        handles.append(Line2D([], [], color=colour, linewidth=1.8,
                              label=label + (f": {outcome}" if outcome else "")))
    widest = max(parameters.length(handle.get_label()) for handle in handles)
    columns = int(np.clip(100 // (widest + 9), 1, 4))
    rows = -(-len(runs) // columns)
    figure, panels = _figure(_panels(runs), above=13.2 * max(rows - 2, 0) / 72)
    _draw(panels, runs, colours)
    legend = panels["x"].legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1),
                                ncol=columns, fontsize=8.5, handlelength=1.8, columnspacing=1.4,
                                labelspacing=0.3, borderaxespad=0.3)
    if len(runs[0].bodies) > 1:
        panels["x"].add_artist(legend)
        panels["x"].legend(
            handles=[Line2D([], [], color=GREY, linestyle=STYLES[b % len(STYLES)], linewidth=1.4,
                            label=NAMES.get(body, body))
                     for b, body in enumerate(runs[0].bodies[:len(STYLES)])],
            loc="upper right", bbox_to_anchor=(1, 0.94), ncol=4, handlelength=2.6)
    common = [text for text in parameters.headline(runs[0].parameters)
              if all(text in parameters.headline(run.parameters) for run in runs)]
    names = list(dict.fromkeys(run.name for run in runs))
    lines = parameters.wrapped(common, 98)
    panels["x"].set_title(title or ", ".join(names[:6]) + (" ..." if len(names) > 6 else ""),
                          loc="left", fontsize=11, fontweight="bold",
                          pad=14 + 13.8 * rows + 12.5 * len(lines))
    for n, line in enumerate(reversed(lines)):
        panels["x"].annotate(line, (0, 1), xycoords="axes fraction", textcoords="offset points",
                             xytext=(0, 10 + 13.8 * rows + 12.5 * n), fontsize=8.5, va="bottom",
                             annotation_clip=False)
    figure.align_ylabels(list(panels.values()))
    return figure
