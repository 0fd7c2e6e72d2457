"""The picture of a directory of `ductile compare`.

Lateral positions of all bodies, their difference to the run with the first integrator, the volume
error of capsules, and what a step costs, part by part.
"""
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator

from . import files
from .errors import DuctileError
from .style import BLACK, COLOURS, FAILED, NAMES, STYLES, grid, zero_line

# Away from the colours of the integrators; the membrane's part, which they differ in, stands out.
PARTS = {"fluid": "#C3CBD6", "interpolation": "#8797AD", "bodies": "#4B2E63",
         "spreading": "#A58BBF", "rest": "#E9E9E9"}


def colour(i):
    """The first integrator is the reference, and black."""
    return BLACK if i == 0 else COLOURS[(i - 1) % len(COLOURS)]


def line(i, runs):
    """The style of a run among others that lie on it: the later, the thinner."""
    if i == 0:
        return {"color": BLACK, "linewidth": 5, "alpha": 0.22, "solid_capstyle": "butt"}
    return {"color": colour(i), "linewidth": np.linspace(2.8, 1.2, len(runs))[i - 1]}


def read_runs(directory, comparison):
    """Adds to each run its trajectory, as "data"."""
    for run in comparison["runs"]:
        run["data"], _ = files.read_trajectory(directory / run["directory"] / files.RUN_FILE)
    return comparison["runs"]


def bodies_of(run):
    return files.bodies_of(run["data"])


def mark_end(axes, run, values, i):
    """Where a run blew up."""
    if run["status"] == "blew up":
        axes.plot(run["data"]["t"][-1], values[-1], "x", color=colour(i), markersize=7,
                  markeredgewidth=1.8, clip_on=False, zorder=5)


def draw_lateral(axes, runs):
    for i, run in enumerate(runs):
        for b, body in enumerate(bodies_of(run)):
            x = run["data"][f"{body}_x"]
            axes.plot(run["data"]["t"], x, linestyle=STYLES[b % len(STYLES)] if i else "-",
                      **line(i, runs))
            mark_end(axes, run, x, i)
    zero_line(axes)
    axes.set_ylabel(r"lateral position  $x/W$")


def draw_difference(axes, runs):
    reference = runs[0]["data"]
    largest, until = 0, 0
    for i, run in enumerate(runs[1:], 1):
        t = run["data"]["t"]
        both = t <= reference["t"][-1]
        until = max(until, t[both][-1])
        for b, body in enumerate(bodies_of(run)):
            there = np.interp(t[both], reference["t"], reference[f"{body}_x"])
            apart = np.abs(run["data"][f"{body}_x"][both] - there)
            shown = apart > 0
            largest = max(largest, apart.max(initial=0))
            axes.plot(t[both][shown], apart[shown], color=colour(i),
                      linestyle=STYLES[b % len(STYLES)], linewidth=1.4)
    axes.set_ylabel(r"difference  $|x - x_{\mathrm{ref}}|/W$")
    if largest > 0:
        axes.set_yscale("log")
        top = 10 ** np.ceil(np.log10(2 * largest))
        axes.set_ylim(1e-4 * top, top)
        axes.yaxis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=50))
    else:
        axes.set_yticks([])
        axes.text(0.5, 0.5, "none" if until > 0 else "no time in common", color="#666666",
                  transform=axes.transAxes, ha="center")


def draw_volume(axes, runs):
    for i, run in enumerate(runs):
        for b, body in enumerate(bodies_of(run)):
            error = run["data"].get(f"{body}_volume_error")
            if error is None:
                continue
            axes.plot(run["data"]["t"], 100 * error,
                      linestyle=STYLES[b % len(STYLES)] if i else "-", **line(i, runs))
            mark_end(axes, run, 100 * error, i)
    zero_line(axes)
    axes.set_ylabel("volume error  [%]")


def draw_cost(axes, runs, bodies_part):
    for row, run in enumerate(runs):
        cost = run.get("cost_per_step_ms")
        if cost is None:
            axes.text(0, row, " no step was done", va="center", color=FAILED)
            continue
        left = 0
        for part, face in PARTS.items():
            axes.barh(row, cost[part], left=left, height=0.62, color=face, edgecolor="white",
                      linewidth=0.6)
            left += cost[part]
        reference = runs[0].get("cost_per_step_ms")
        times = f"  \u00d7 {cost['step'] / reference['step']:.2f}" if reference and row else ""
        axes.annotate(f"{cost['step']:#.3g} ms{times}", (left, row), textcoords="offset points",
                      xytext=(4, 0), va="center", fontsize=9, color=BLACK)
    axes.set_yticks(range(len(runs)), [run["integrator"] for run in runs])
    for i, label in enumerate(axes.get_yticklabels()):
        label.set_color(colour(i))
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    axes.set_xlabel("wall time of a step  [ms]")
    axes.set_xlim(0, 1.18 * axes.get_xlim()[1])
    labels = [bodies_part if part == "bodies" else part for part in PARTS]
    axes.legend([Rectangle((0, 0), 1, 1, color=face) for face in PARTS.values()], labels,
                loc="lower center", bbox_to_anchor=(0.5, 1), ncol=len(PARTS), handlelength=1,
                handleheight=1, columnspacing=1.4)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.tick_params(top=False, right=False)


def key(axes, runs):
    """Above the panel. Colours are integrators, line styles are bodies."""
    handles, labels = [], []
    for i, run in enumerate(runs):
        remarks = ["reference"] if i == 0 else []
        remarks += ["blew up"] if run["status"] == "blew up" else []
        handles.append(Line2D([], [], **line(i, runs)))
        labels.append(run["integrator"] + (f" ({', '.join(remarks)})" if remarks else ""))
    bodies = bodies_of(runs[0])
    if len(bodies) > 1:
        for b, body in enumerate(bodies[:len(STYLES)]):
            handles.append(Line2D([], [], color="#666666", linestyle=STYLES[b], linewidth=1.4))
            labels.append(NAMES.get(body, body))
    axes.legend(handles, labels, loc="lower left", bbox_to_anchor=(0, 1), ncol=3, handlelength=2.6,
                columnspacing=1.6, borderaxespad=0.3)


def draw(directory):
    """The picture of the comparison in a directory, as a matplotlib Figure. Raises DuctileError."""
    file = Path(directory) / files.COMPARISON_FILE
    comparison = files.read_json(file)
    try:
        return _drawn(comparison, read_runs(Path(directory), comparison))
    except KeyError as error:
        raise DuctileError(f"{file}: has no {error}") from None


def _drawn(comparison, runs):
    figure = Figure(figsize=(7.2, 8.4 + 0.32 * len(runs)), layout="constrained")
    places = figure.add_gridspec(4, 1, height_ratios=[2.4, 1.9, 1.7, 0.5 + 0.4 * len(runs)])
    lateral = figure.add_subplot(places[0])
    panels = [lateral] + [figure.add_subplot(places[n], sharex=lateral) for n in (1, 2)]
    draw_lateral(panels[0], runs)
    draw_difference(panels[1], runs)
    draw_volume(panels[2], runs)
    for panel in panels:
        grid(panel)
    for panel in panels[:2]:
        panel.tick_params(labelbottom=False)
    end = max(run["time_W2_over_nu"] for run in runs)
    if end > 0:
        lateral.set_xlim(0, end)
    panels[2].set_xlabel(r"time  $t\,\nu/W^2$")
    figure.align_ylabels(panels)
    costs = figure.add_subplot(places[3])
    draw_cost(costs, runs, comparison["bodies_part"])
    key(lateral, runs)
    for panel, letter in zip(panels + [costs], "abcd"):
        panel.text(-0.2, 1 if letter != "d" else 1.1, letter, transform=panel.transAxes, va="top",
                   fontsize=12, fontweight="bold")
    figure.suptitle(comparison["scenario"], fontsize=11, fontweight="bold", color=BLACK)
    return figure
