#!/usr/bin/python3
"""Draws trajectory.png from the trajectory.csv (and summary.json, if there) of a run directory.

Lateral positions of all bodies against time, for a pair their axial distance, and for capsules
their strain energy: the layout of Fig. 6 of Patel & Stark, Soft Matter 17, 4804 (2021).

usage: plot_trajectory.py DIRECTORY
"""
import json
import re
import sys
import textwrap
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Okabe & Ito's palette, told apart with every common colour vision; line styles tell them apart in
# grey.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
STYLES = ["-", (0, (5, 1.5)), (0, (1, 1)), "-."]
BLACK = "#222222"
VERDICT_COLOURS = {"stable": "#009E73", "damped": "#0072B2", "bounded": "#CC79A7",
                   "unstable": "#D55E00", "undecided": "#666666"}
NAMES = {"lead": "leading", "lag": "lagging"}

plt.rcParams.update({
    "font.size": 10, "font.family": "DejaVu Sans", "axes.edgecolor": BLACK,
    "axes.labelcolor": BLACK, "xtick.color": BLACK, "ytick.color": BLACK, "axes.linewidth": 0.8,
    "xtick.direction": "in", "ytick.direction": "in", "xtick.top": True, "ytick.right": True,
    "legend.frameon": False, "lines.linewidth": 1.8, "mathtext.fontset": "dejavusans",
})


def read_trajectory(file):
    """Returns {column name without its unit: values}; a line cut off by a crash is left out."""
    with open(file, encoding="utf-8") as lines:
        names = [re.sub(r"\[.*\]$", "", column) for column in next(lines).rstrip("\n").split(",")]
        rows = [line.split(",") for line in lines if line.endswith("\n")]
    rows = [[float(value) for value in row] for row in rows if len(row) == len(names)]
    if not rows:
        raise ValueError(f"{file} holds no samples")
    return dict(zip(names, np.array(rows).T))


def read_summary(file):
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def annotate_end(axes, t, values):
    axes.annotate(f"{values[-1]:.2f}", (t[-1], values[-1]), textcoords="offset points",
                  xytext=(5, 0), ha="left", va="center", color=BLACK, fontsize=9,
                  annotation_clip=False)


def draw_lateral(axes, t, data, bodies):
    positions = np.concatenate([data[f"{body}_x"] for body in bodies])
    axes.axhline(0, color="#999999", linewidth=0.8, linestyle=(0, (6, 4)), zorder=0)
    for i, body in enumerate(bodies):
        axes.plot(t, data[f"{body}_x"], color=COLOURS[i % len(COLOURS)],
                  linestyle=STYLES[i % len(STYLES)], label=NAMES.get(body, body))
        axes.plot(t[0], data[f"{body}_x"][0], "o", color=COLOURS[i % len(COLOURS)], markersize=4,
                  clip_on=False)
    axes.set_ylabel(r"lateral position  $x/W$")
    if np.nanmax(np.abs(positions)) < 1:
        for low, high in ((-1.12, -1), (1, 1.12)):
            axes.axhspan(low, high, facecolor="#dddddd", edgecolor="#888888", hatch="////",
                         linewidth=0)
            axes.axhline(np.sign(low) * 1, color=BLACK, linewidth=1.2)
        axes.set_ylim(-1.12, 1.12)
    if len(bodies) == 1:
        annotate_end(axes, t, data[f"{bodies[0]}_x"])
    else:
        axes.legend(loc="upper right", bbox_to_anchor=(1, 0.94), ncol=min(len(bodies), 6),
                    handlelength=2.6, columnspacing=1.4)


def draw_distance(axes, t, dz):
    axes.plot(t, dz, color=BLACK)
    axes.set_ylabel(r"axial distance  $\Delta z/W$")
    low, high = min(0.0, np.nanmin(dz)), np.nanmax(dz)
    axes.set_ylim(low - (0.08 * (high - low) if low < 0 else 0), low + 1.15 * max(high - low, 1.5))
    if low < 0:
        axes.axhline(0, color="#999999", linewidth=0.8, linestyle=(0, (6, 4)), zorder=0)
    annotate_end(axes, t, dz)


def draw_strain(axes, t, data, bodies, capsules):
    highest = 0.0
    for i, body in enumerate(bodies):
        if body not in capsules:
            continue
        values = data[f"{body}_strain_energy"]
        highest = max(highest, np.nanmax(values))
        axes.plot(t, 1e3 * values, color=COLOURS[i % len(COLOURS)],
                  linestyle=STYLES[i % len(STYLES)], linewidth=1.4)
    axes.set_ylabel("strain energy\n" + r"$10^3\,E_s/k_s a^2$")
    axes.set_ylim(0, 1.15e3 * highest if highest > 0 else 1)


def describe(summary, directory):
    """Title of the figure, and the verdict with its reason."""
    title = summary.get("scenario") or directory.resolve().name
    verdict = summary.get("verdict")
    reason = summary.get("verdict_reason", "")
    if summary.get("status") == "blew up":
        blow_up = summary.get("blow_up", {})
        return title, "blew up", f"at step {blow_up.get('step')}: {blow_up.get('reason', '')}"
    return title, verdict, reason


def main(directory):
    data = read_trajectory(directory / "trajectory.csv")
    summary = read_summary(directory / "summary.json")
    bodies = [name[:-2] for name in data if name.endswith("_x")]
    capsules = [body for body in bodies if f"{body}_strain_energy" in data]
    t = data["t"]

    heights = [3.2] + ([2.6] if "dz" in data else []) + ([1.5] if capsules else [])
    figure, axes = plt.subplots(len(heights), 1, sharex=True, squeeze=False,
                                figsize=(7.2, sum(heights) + 1.0), layout="constrained",
                                gridspec_kw={"height_ratios": heights})
    panels = iter(axes[:, 0])
    draw_lateral(next(panels), t, data, bodies)
    if "dz" in data:
        draw_distance(next(panels), t, data["dz"])
    if capsules:
        draw_strain(next(panels), t, data, bodies, capsules)
    axes[-1, 0].set_xlabel(r"time  $t\,\nu/W^2$")
    if t[-1] > t[0]:
        axes[-1, 0].set_xlim(t[0], t[-1])
    for panel in axes[:, 0]:
        panel.grid(color="#e6e6e6", linewidth=0.6)
        panel.set_axisbelow(True)
    figure.align_ylabels(axes[:, 0])

    title, verdict, reason = describe(summary, directory)
    top = axes[0, 0]
    reason = "\n".join(textwrap.wrap(reason, 100, max_lines=2, placeholder=" ..."))
    pad = 8 + 13 * len(reason.splitlines())
    top.set_title(title, loc="left", fontsize=11, fontweight="bold", color=BLACK, pad=pad)
    if verdict:
        top.set_title(verdict, loc="right", fontsize=11, fontweight="bold", pad=pad,
                      color=VERDICT_COLOURS.get(verdict, "#D55E00"))
    top.annotate(reason, (0, 1), xycoords="axes fraction", textcoords="offset points",
                 xytext=(0, 5), fontsize=8.5, color="#555555", va="bottom", linespacing=1.3)
    figure.savefig(directory / "trajectory.png", dpi=150)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        main(Path(sys.argv[1]))
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"plot_trajectory.py: {error}")
