"""The figures of the paper, drawn from the runs of the study.

    figure = draw(study, "fig6")          a matplotlib Figure, or None where the study has no data
    texts = describe(study, "fig6")       {"title", "caption", "alt"}

Axes, panels and conventions are the paper's; its numbers, as far as its text states them, are thin
dashed grey lines with small labels. Where both methods have been computed both are drawn: "clean",
this program's own, and "paper", the paper's. What has not been computed is left out. All numbers
are those of quantities.py.
"""
import functools
from collections.abc import Callable
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import MaxNLocator, MultipleLocator

from .. import style
from ..errors import DuctileError
from ..maps import _SIGNS as SIGNS
from ..style import BLACK, COLOURS, GREY, PALE, STYLES, VERDICT_COLOURS
from . import quantities
from .quantities import STATED
from .study import METHODS, PAIRS, X_LAGS

# Widths of one and two columns of the journal [inches].
ONE, TWO = 3.27, 6.73
SETTINGS = style.SETTINGS | {
    "font.size": 7.5, "axes.titlesize": 8, "axes.labelsize": 8, "xtick.labelsize": 7,
    "ytick.labelsize": 7, "legend.fontsize": 7, "axes.linewidth": 0.6, "lines.linewidth": 1.2,
    "lines.markersize": 4.5, "xtick.major.size": 2.5, "ytick.major.size": 2.5,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5, "xtick.minor.width": 0.5, "ytick.minor.width": 0.5,
    "legend.handlelength": 2.6, "legend.columnspacing": 1.2, "legend.borderaxespad": 0.3,
}
SMALL = 6.0

TIME, DISTANCE = r"$t\;\,[W^2/\nu]$", r"$\Delta z\;\,[W]$"
X, X_LEAD, X_LAG = r"$x\;\,[W]$", r"$x_\mathrm{lead}\;\,[W]$", r"$x_\mathrm{lag}\;\,[W]$"
METHOD_NAMES = {"clean": "by the clean method", "paper": "by the paper's method"}
METHOD_STYLES = {"clean": STYLES[0], "paper": STYLES[1]}

# Where the lagging body starts: a colour and a line style each, dark for the centre.
LAGS = {-0.4: (COLOURS[0], (0, (6, 1.2))), -0.2: (COLOURS[5], (0, (1.2, 0.9))),
        0.0: (BLACK, "-"), 0.2: (COLOURS[4], (0, (5, 1, 1, 1))),
        0.4: (COLOURS[1], (0, (5, 1, 1, 1, 1, 1)))}
PAIR_SIGNS = {"M1": (COLOURS[0], "o"), "M2": (COLOURS[1], "s"), "M3": (BLACK, "D"),
              "B1": (COLOURS[2], "^"), "B2": (COLOURS[3], "v"), "B3": (COLOURS[4], "P"),
              "B4": (COLOURS[5], "X")}
KIND_NAMES = {"sphere-La10": "La = 10", "sphere-La100": "La = 100", "rigid": "rigid",
              "biconcave-La10": "La = 10", "biconcave-La100": "La = 100"}
PAIR_NAMES = {"M1": "M1: La = 10", "M2": "M2: La = 100", "M3": "M3: rigid",
              "B1": "B1: La = 10, cell lags", "B2": "B2: La = 100, cell lags",
              "B3": "B3: La = 10, 100", "B4": "B4: La = 100, 10"}
EARLY = 40.0  # up to this time [W^2/nu] M2 is drawn where an inset shows what comes later

_memory = functools.lru_cache(maxsize=256)


@_memory
def _found(function, study, method):
    """What a function of quantities.py finds, once for picture and words."""
    return function(study, method)


# ------------------------------------------------------------------------------------------------
# Words


def _number(value, digits=6):
    return f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")


def said(quantity):
    """A Quantity in words: "1.17 ± 0.02", or "none"."""
    if not quantity.known:
        return "none"
    value, error = quantity.value.value, quantity.value.error
    digits = 4 if not error > 0 else int(np.clip(np.ceil(-np.log10(error / 1.5)), 0, 4))
    value = round(value, digits) + 0.0  # never minus zero
    if error < 0.5 * 10.0**-digits:
        return f"{value:.{digits}f}".replace("-", "\N{MINUS SIGN}")
    return f"{value:.{digits}f} ± {error:.{digits}f}".replace("-", "\N{MINUS SIGN}")


def _range(values, form="g"):
    """"36", or "24 to 36"."""
    values = sorted(set(values))
    ends = [format(value, form).replace("-", "\N{MINUS SIGN}") for value in (values[0], values[-1])]
    return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


def _and(texts):
    texts = list(texts)
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


def _membranes(cases, key):
    return [float(case.parameters[f"body.{body}.{key}"]) for case in cases
            for body in case.run.bodies
            if case.parameters.get(f"body.{body}.kind", "capsule") == "capsule"
            and f"body.{body}.{key}" in case.parameters]


def _how(cases):
    """Sentences that say how cases were computed: lattice, mobility and mesh of each method."""
    cases = [case for case in cases if case]
    if not cases:
        return ""
    text = f"Computed with {_range(case.nodes for case in cases)} nodes across the channel"
    parts = []
    for method in METHODS:
        own = [case for case in cases if case.method == method]
        mobilities, edges = _membranes(own, "mobility"), _membranes(own, "edge")
        if mobilities:
            name = "clean" if method == "clean" else "the paper's method"
            parts.append(f"{name}: membrane mobility {_range(mobilities)}"
                         + (f" and edges of {_range(edges)} lattice spacings" if edges else ""))
    return f"{text}; {'; '.join(parts)}." if parts else f"{text}."


def _is_half(case):
    """Whether half of the channel was computed, in which nothing leaves the plane y = 0."""
    return case.parameters.get("channel.symmetry") == "y"


def _methods_drawn(cases):
    """"both methods", or the one."""
    own = [method for method in METHODS
           if any(case and case.method == method and _membranes([case], "mobility")
                  for case in cases)]
    if len(own) == 2:
        return "both methods"
    return {"clean": "the clean method alone", "paper": "the paper's method alone"}.get(
        own[0] if own else "", "rigid bodies alone")


UNITS = "Lengths are in W, half the channel's width, times in W²/ν."
DASHED = "Dashed grey lines are what the paper's text states."


# ------------------------------------------------------------------------------------------------
# Parts of pictures


def _stated(axes, value, text):
    """A number of the paper: a thin dashed grey line at a height, with a small label on it where it
    covers the least of the lines that are drawn. Limits must be set."""
    axes.axhline(value, color=PALE, linewidth=0.7, linestyle=(0, (4, 2.5)), zorder=1,
                 gid="stated")
    if not text:
        return
    low, high = axes.get_ylim()
    size = axes.get_window_extent().size * 72 / axes.figure.dpi
    wide, tall = 0.56 * SMALL * len(text) / size[0], 1.35 * SMALL / size[1]
    height, points = (value - low) / (high - low), _lines_of(axes)
    best = None
    for at in (0.985, 0.015, 0.5, 0.75, 0.25):
        for above in (True, False):
            left = {0.985: at - wide, 0.015: at}.get(at, at - wide / 2)
            bottom = height if above else height - tall
            inside = ((points[:, 0] > left) & (points[:, 0] < left + wide)
                      & (points[:, 1] > bottom) & (points[:, 1] < bottom + tall)).sum()
            outside = bottom < 0.01 or bottom + tall > 0.99
            score = (outside, int(inside))
            if best is None or score < best[0]:
                best = score, at, above
    _, at, above = best
    axes.annotate(text, (at, value), xycoords=("axes fraction", "data"), fontsize=SMALL,
                  xytext=(0, 1.0 if above else -1.4), textcoords="offset points", color=GREY,
                  ha={0.985: "right", 0.015: "left"}.get(at, "center"),
                  va="bottom" if above else "top", zorder=6, gid="stated")


def _labels_of(axes):
    """The places of the labels of _stated(), in axes fractions: points along each, (n, 2)."""
    points = [np.empty((0, 2))]
    low, high = axes.get_ylim()
    size = axes.get_window_extent().size * 72 / axes.figure.dpi
    for text in axes.texts:
        if text.get_gid() == "stated":
            wide = 0.56 * SMALL * len(text.get_text()) / size[0]
            at, value = text.xy
            left = at - {"left": 0, "center": 0.5, "right": 1}[text.get_ha()] * wide
            side = 1 if text.get_va() == "bottom" else -1
            for up in (0.2, 0.7, 1.2):
                height = (value - low) / (high - low) + side * up * SMALL / size[1]
                points.append(np.column_stack([np.linspace(left, left + wide, 40),
                                               np.full(40, height)]))
    return np.concatenate(points)


def _letter(axes, text, name=""):
    axes.set_title(f"$\\bf{{({text})}}$  {name}" if text else name, loc="left", pad=3.5)


def _lines_of(axes):
    """The data of an axes' lines, in axes fractions, closely spaced: an array (n, 2)."""
    points = [np.empty((0, 2))]
    for line in axes.lines:
        if line.get_transform() != axes.transData or line.get_gid() == "stated":
            continue
        at = axes.transAxes.inverted().transform(axes.transData.transform(line.get_xydata()))
        at = at[np.all(np.isfinite(at), axis=1)]
        if len(at) > 1:
            fine = np.linspace(0, len(at) - 1, 20 * len(at) if len(at) < 50 else 2 * len(at))
            at = np.column_stack([np.interp(fine, np.arange(len(at)), at[:, k]) for k in (0, 1)])
        points.append(at)
    return np.concatenate(points)


def _free_place(axes, width, height, left=0.0, below=0.0):
    """The lower left corner, in axes fractions, of a box of that size in which the fewest points of
    the axes' lines and labels lie, with so much more at its left and below for its own labels."""
    points, labels = _lines_of(axes), _labels_of(axes)

    def inside(points, x, y):
        return int(((points[:, 0] > x - left) & (points[:, 0] < x + width + 0.01)
                    & (points[:, 1] > y - below) & (points[:, 1] < y + height + 0.05)).sum())
    best = None
    for x in np.linspace(0.02 + left, 0.98 - width, 24):
        for y in np.linspace(0.03 + below, 0.96 - height, 24):
            middle = np.abs([x - left, 0.98 - width - x, y - below, 0.96 - height - y]).min()
            score = (inside(points, x, y) + 10000 * inside(labels, x, y), round(middle, 2))
            if best is None or score < best[0]:
                best = score, (x, y)
    return best[1]


def _inset(axes, width, height, left=0.08, below=0.1):
    """Axes inside of others, where they cover the least of their lines, for what is drawn small."""
    x, y = _free_place(axes, width, height, left, below)
    inset = axes.inset_axes([x, y, width, height], zorder=7)
    inset.tick_params(labelsize=5.5, length=1.6, pad=1.2, width=0.5)
    inset.patch.set_alpha(0.9)
    for spine in inset.spines.values():
        spine.set_linewidth(0.5)
    return inset


def _limits(values, least, pad=0.06):
    """Limits that hold `least`, a pair, and all values, with a margin beyond those."""
    low, high = least
    values = np.concatenate([np.ravel(value) for value in values]) if values else np.array([])
    values = values[np.isfinite(values)]
    if len(values):
        margin = pad * max(np.ptp(values), high - low)
        low = min(low, values.min() - margin) if values.min() < low else low
        high = max(high, values.max() + margin) if values.max() > high else high
    return low, high


def _label_inside(inset, text):
    """The name of a small panel's vertical axis, where it takes no room."""
    inset.set_ylabel(text, fontsize=SMALL, rotation=0)
    inset.yaxis.set_label_coords(0.07, 0.62)


def _lag_legend(figure, x_lags, **where):
    handles = [Line2D([], [], color=LAGS[x][0], linestyle=LAGS[x][1], label=_number(x))
               for x in x_lags]
    figure.legend(handles=handles, title=None, ncol=len(handles), **where)


def _legend_beside(figure, handles, columns, below=False, **more):
    """A legend above all panels of a figure with constrained layout, or below them."""
    rows = -(-len(handles) // columns)
    height = (10.5 * rows + 3) / 72 / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, height if below else 0, 1, 1 - height))
    figure.legend(handles=handles, ncol=columns, labelspacing=0.25, borderpad=0.1,
                  loc="lower center" if below else "upper center", **more)


# ------------------------------------------------------------------------------------------------
# Fig. 3: the four types

_EXAMPLES = {"stable": [("M1", -0.2), ("M1", 0.0)], "damped": [("M2", 0.0)],
             "bounded": [("B1", 0.2), ("B1", 0.4)], "unstable": [("B3", 0.4), ("B3", 0.2)]}


def _examples(study):
    """A case of each type, {verdict: case}: the one that the paper shows if ours is of the type."""
    found = {}
    for verdict, first in _EXAMPLES.items():
        places = first + [(pair, x) for pair in PAIRS for x in X_LAGS if (pair, x) not in first]
        for method in METHODS:
            for pair, x_lag in places:
                case = study.pair(pair, x_lag, method)
                if verdict not in found and case and (
                        quantities.class_of(case, pair, x_lag).verdict == verdict):
                    found[verdict] = case
    return found


def _called(case):
    """"M2, x_lag = 0"."""
    return f"{case.campaign}, $x_\\mathrm{{lag}}$ = {_number(case.start('lag'))}"


def _draw_types(_study, examples):
    figure = Figure(figsize=(ONE, 2.6), layout="constrained")
    axes = figure.subplots()
    drawn, latest = [], 0.0
    for style_of, (verdict, case) in zip(STYLES, examples.items()):
        t, dz = case.run.series("dz")
        axes.plot(t, dz, color=VERDICT_COLOURS[verdict], linestyle=style_of, zorder=3,
                  label=f"{verdict}: {_called(case)}"
                  + (", the paper's method" if case.method == "paper" else ""))
        drawn.append(dz)
        latest = max(latest, t[-1])
    axes.set(xlim=(0, latest), ylim=_limits(drawn, (0, 11)), xlabel=TIME, ylabel=DISTANCE)
    _stated(axes, STATED["dz stop"].value, "paper: stops at 10")
    _legend_beside(figure, axes.get_legend_handles_labels()[0], 1)
    return figure


def _describe_types(_study, examples):
    kinds = [f"{verdict} ({case.campaign}, x_lag = {_number(case.start('lag'))}"
             + (", the paper's method)" if case.method == "paper" else ")")
             for verdict, case in examples.items()]
    missing = [verdict for verdict in _EXAMPLES if verdict not in examples]
    caption = (f"The axial distance Δz of one pair of each type against time: {_and(kinds)}. "
               + (f"No pair that was computed is {' or '.join(missing)}. " if missing else "")
               + f"{UNITS} {_how(examples.values())}")
    ends = []
    for verdict, case in examples.items():
        t, dz = case.run.series("dz")
        ends.append(f"the {verdict} one is at {dz[-1]:.2f} at t = {t[-1]:.0f}")
    return caption, f"Curves of Δz against time, one for each type: {'; '.join(ends)}."


# ------------------------------------------------------------------------------------------------
# Fig. 4: the map

_MARKS = {"the paper": -0.28, "clean": 0.0, "paper": 0.28}


def _all_classes(study):
    found = {method: _found(quantities.classes, study, method) for method in METHODS}
    return found if any(own.case for classes in found.values() for own in classes.values()) else {}


def _draw_map(_study, found):
    figure = Figure(figsize=(5.0, 4.15), layout="constrained")
    axes = figure.subplots()
    for row, pair in enumerate(PAIRS):
        for column, x_lag in enumerate(X_LAGS):
            _draw_cell(axes, column, len(PAIRS) - 1 - row, pair,
                       quantities.paper_class(pair, x_lag),
                       {method: found[method][pair, x_lag] for method in METHODS})
    for column in range(len(X_LAGS)):
        for name, shift in (("paper", -0.28), ("clean", 0.0), ("pure", 0.28)):
            axes.text(column + shift, len(PAIRS) - 0.42, name, ha="center", va="bottom",
                      fontsize=SMALL, color=GREY)
    axes.set(xlim=(-0.5, len(X_LAGS) - 0.5), ylim=(-0.52, len(PAIRS) - 0.2),
             xlabel=X_LAG)
    axes.set_xticks(range(len(X_LAGS)), [_number(x) for x in X_LAGS])
    axes.set_yticks(range(len(PAIRS)), PAIRS[::-1])
    axes.tick_params(length=0)
    handles = [Line2D([], [], linestyle="none", marker=SIGNS[verdict], markersize=5.5,
                      color=VERDICT_COLOURS[verdict], label=verdict) for verdict in SIGNS]
    handles.append(Line2D([], [], linestyle="none", marker="$-$", color=PALE, markersize=5,
                          label="not computed"))
    handles.append(Patch(facecolor="none", edgecolor=BLACK, linewidth=0.9,
                         label="not the paper's"))
    _legend_beside(figure, handles, 4, below=True, handlelength=1.4)
    return figure


def _draw_cell(axes, x, y, pair, paper, ours):
    """A cell: the paper's class, behind it as a colour too, and ours by both methods, with a frame
    where they are another."""
    axes.add_patch(Rectangle((x - 0.47, y - 0.44), 0.94, 0.88, linewidth=0, zorder=1, alpha=0.16,
                             facecolor=VERDICT_COLOURS[paper]))
    marks = {"the paper": paper} | {method: own.verdict for method, own in ours.items()}
    if pair == "M3":  # rigid bodies: one mark stands for both methods
        marks.pop("paper")
    for name, verdict in marks.items():
        at = x + (0.14 if pair == "M3" and name == "clean" else _MARKS[name])
        if verdict is None:
            axes.plot(at, y, marker="$-$", color=PALE, markersize=5, linestyle="none", zorder=3)
            continue
        axes.plot(at, y, marker=SIGNS[verdict], color=VERDICT_COLOURS[verdict], markersize=6,
                  linestyle="none", zorder=3, markeredgewidth=0)
        if name != "the paper" and ours[name].agrees is False:
            axes.add_patch(Rectangle((at - 0.125, y - 0.29), 0.25, 0.58, fill=False, zorder=4,
                                     edgecolor=BLACK, linewidth=0.9))


def _agreement(classes):
    """(agree, differ, undecided, missing) of a method."""
    agrees = [own.agrees for own in classes.values()]
    missing = sum(own.verdict is None for own in classes.values())
    return (agrees.count(True), agrees.count(False), agrees.count(None) - missing, missing)


def _describe_map(study, found):
    texts, differing = [], []
    for method, name in (("clean", "clean method"), ("paper", "paper's method")):
        agree, differ, undecided, missing = _agreement(found[method])
        texts.append(f"by the {name} {agree} of {len(found[method])} pairs are of the paper's "
                     f"class, {differ} of another, {undecided} undecided, {missing} not computed")
        others = [f"{pair} {_number(x)} ({own.verdict}, the paper: {own.paper})"
                  for (pair, x), own in found[method].items() if own.agrees is False]
        if others:
            differing.append(f"by the {name} {_and(others)}")
    cases = [study.pair(pair, x, method)
             for pair in PAIRS for x in X_LAGS for method in METHODS]
    caption = ("Classes of the pairs M1 to B4 over the start of the lagging body, the leading one "
               "starting at 0.2. In each cell, from the left: the paper's class (Fig. 4, which is "
               "the cell's colour too), ours by the clean method and ours by the paper's (pure); "
               "rigid bodies (M3) are computed once. A frame says that the "
               "class does not count as the paper's: of a stable pair it may swing before it "
               f"rests, of a bounded one it may come to rest. {_how(cases)}")
    alt = f"A map of 7 pairs by 5 starts: {'; '.join(texts)}."
    if differing:
        alt += f" Other than the paper's are {'; '.join(differing)}."
    return caption, alt


# ------------------------------------------------------------------------------------------------
# Figs. 5 and 9: single bodies

_SPHERES = {"sphere-La10": (COLOURS[0], STYLES[0]), "sphere-La100": (COLOURS[1], STYLES[1]),
            "rigid": (BLACK, STYLES[2])}
_CELLS = {"biconcave-La10": (COLOURS[0], STYLES[0]), "biconcave-La100": (COLOURS[1], STYLES[1])}


def _singles(study, kinds):
    """{method: {(kind, start): case}}, of the methods that have more than rigid bodies, which count
    for both, or else of the first."""
    cases = {method: {(name, start): case for name in kinds for start in quantities.STARTS
                      if (case := quantities.single_case(study, name, start, method))}
             for method in METHODS}
    soft = [method for method in METHODS if any(name != "rigid" for name, _ in cases[method])]
    return {method: cases[method]
            for method in soft or [method for method in METHODS if cases[method]][:1]}


def _draw_singles(cases, kinds, draw_inset):
    methods = list(cases)
    figure = Figure(figsize=(TWO if len(methods) > 1 else 0.6 * TWO, 2.6), layout="constrained")
    panels = figure.subplots(1, len(methods), sharey=True, squeeze=False)[0]
    drawn, latest = [], 0.0
    for letter, axes, method in zip("ab", panels, methods):
        for (name, start), case in cases[method].items():
            colour, line = kinds[name]
            t, x = case.run.series(f"{case.run.bodies[0]}_x")
            axes.plot(t, x, color=colour, linestyle=line, zorder=3)
            axes.plot(t[0], x[0], "o", color=colour, markersize=3, clip_on=False, zorder=4)
            drawn.append(x)
            latest = max(latest, t[-1])
        _letter(axes, letter if len(methods) > 1 else "", METHOD_NAMES[method])
        axes.set_xlabel(TIME)
    low, high = _limits(drawn, (-0.05, 0.5))
    panels[0].set_ylabel(X)
    for axes, method in zip(panels, methods):
        # Room above for legend and inset.
        axes.set(xlim=(0, latest), ylim=(low, high + 0.16))
        for value in sorted({STATED[name].value for name, _ in cases[method]}):
            near = "near " if value == STATED["rigid"].value else ""
            _stated(axes, value, f"paper: {near}{_number(value)}" if value else "paper: centre")
    handles = [Line2D([], [], color=colour, linestyle=line, label=KIND_NAMES[name])
               for name, (colour, line) in kinds.items()
               if any(name == kind for own in cases.values() for kind, _ in own)]
    _legend_beside(figure, handles, 3)
    for axes, method in zip(panels, methods):
        draw_inset(axes, cases[method])
    return figure


def _draw_sections(axes, cases):
    """The outlines of soft bodies at the end of the runs, side by side, in the upper right."""
    outlines = {}
    for (name, _), case in cases.items():
        if name in outlines or name == "rigid":
            continue
        try:
            _, centre, loops = quantities.outline(case)
        except (DuctileError, KeyError):
            continue
        outlines[name] = [loop[:, [2, 0]] - centre[[2, 0]] for loop in loops]
    if not outlines:
        return
    inset = axes.inset_axes([0.70, 0.78, 0.28, 0.2])
    for n, (name, loops) in enumerate(outlines.items()):
        colour, line = _SPHERES[name]
        for loop in loops:
            inset.fill(loop[:, 0] + 1.1 * n, loop[:, 1], facecolor=colour, alpha=0.2, linewidth=0)
            inset.plot(loop[:, 0] + 1.1 * n, loop[:, 1], color=colour, linewidth=0.9,
                       linestyle=line)
        inset.text(1.1 * n, 0, name.split("La")[1], fontsize=SMALL, va="center", ha="center")
    inset.set(xlim=(-0.5, 1.1 * len(outlines) - 0.6), ylim=(-0.5, 0.5), aspect="equal",
              anchor="E")
    inset.set_axis_off()


def _draw_lift_off(axes, cases):
    """How far the soft cells leave the plane y = 0, against time."""
    own = {key: case for key, case in cases.items()
           if key[0] == "biconcave-La10" and not _is_half(case)}
    if not own:
        return
    inset = axes.inset_axes([0.62, 0.78, 0.365, 0.2])
    for (name, start), case in own.items():
        t, y = case.run.series(f"{case.run.bodies[0]}_y")
        inset.plot(t, y, color=_CELLS[name][0], linewidth=0.7,
                   linestyle="-" if start == 0.2 else STYLES[2])
    inset.tick_params(labelsize=5.5, length=1.6, pad=1.2, width=0.5, labelbottom=False)
    inset.set_xlim(*axes.get_xlim())
    _label_inside(inset, "$y$")
    inset.locator_params(axis="y", nbins=3)


def _describe_singles(study, cases, what, inset):
    ends = []
    for method in cases:
        found = _found(quantities.single_equilibria, study, method)
        own = []
        for (name, start), case in cases[method].items():
            x = found[name, start]
            last = case.run.series(f"{case.run.bodies[0]}_x")
            where = (f"settles at {said(x)}" if x.known
                     else f"is at {_number(last[1][-1], 3)} at t = {last[0][-1]:.0f}")
            if x.known and x.swing and x.swing > 0.01:
                where += f", swinging by ±{x.swing:.2f}"
            own.append(f"{KIND_NAMES[name]} from {start:g} {where}")
        ends.append(f"{METHOD_NAMES[method].capitalize()}: {'; '.join(own)}")
    used = [case for own in cases.values() for case in own.values()]
    caption = (f"The lateral position x of {what} against time, in the midplane y = 0, from the "
               f"starts x = 0.2 and 0.4, by {_methods_drawn(used)}. {inset} {DASHED} {UNITS} "
               f"{_how(used)}")
    return caption, f"Curves of x against time. {'. '.join(ends)}."


# ------------------------------------------------------------------------------------------------
# Figs. 6 and 11: pairs

# Numbers of the paper's text: lateral positions and distances, with their labels.
_STATED_X = {"M1": [(0, "paper: 0")], "M3": [(0.4, "near 0.4"), (-0.4, "near \N{MINUS SIGN}0.4")],
             "M2": [(0.3, "paper: 0.3"), (0, "paper: 0"), (-0.3, "\N{MINUS SIGN}0.3")],
             "B1": [(0, "paper: 0")], "B2": [(0.3, "paper: 0.3"), (0, ""),
                                             (-0.3, "\N{MINUS SIGN}0.3")],
             "B3": [(0, "paper: 0")], "B4": [(0, "paper: 0")]}
_STATED_DZ = {"M2": [(1, "paper: 1")], "B4": [(1, "paper: 1")]}


def _cases_of(study, pairs):
    """{method: {pair: {x_lag: case}}}, of those that there are."""
    found = {}
    for method in METHODS:
        own = {pair: {x_lag: case for x_lag in X_LAGS
                      if (case := study.pair(pair, x_lag, method))} for pair in pairs}
        if method == "paper":
            own = {pair: cases for pair, cases in own.items() if pair != "M3"}
        if any(own.values()):
            found[method] = own
    return found


# Heights [inches]: of the rows, and of what is between two blocks of them.
_ROWS, _BETWEEN = (1.0, 1.3, 1.12), 0.66
# Of panels of positions: what they show, and with room for an inset above.
_PLACES, _PLACES_AND_INSET = (-0.58, 0.58), (-0.58, 1.14)


def _draw_pairs(found, pairs):
    block = sum(_ROWS)
    height = 0.92 + block * len(found) + _BETWEEN * (len(found) - 1)
    figure = Figure(figsize=(TWO, height))
    used = [x for x in X_LAGS if any(x in cases for own in found.values()
                                     for cases in own.values())]
    figure.text(0.085, 1 - 0.14 / height, r"$x_\mathrm{lag}$ at the start:", va="center")
    _lag_legend(figure, used, loc="center", bbox_to_anchor=(0.60, 1 - 0.14 / height))
    everything = {pair: [case for own in found.values() for case in own.get(pair, {}).values()]
                  for pair in pairs}
    top = height - 0.50
    for number, (method, own) in enumerate(found.items()):
        grid = figure.add_gridspec(3, len(pairs), left=0.085, right=0.982, wspace=0.20,
                                   hspace=0.07, top=top / height, bottom=(top - block) / height,
                                   height_ratios=_ROWS)
        figure.text(0.012, (top + 0.21) / height, f"({'ab'[number]})", fontweight="bold",
                    fontsize=8, va="center")
        figure.text(0.085, (top + 0.21) / height, METHOD_NAMES[method], fontsize=8, va="center",
                    color=GREY)
        for column, pair in enumerate(pairs):
            if pair in own:
                panels = [figure.add_subplot(grid[row, column]) for row in range(3)]
                _draw_pair(panels, pair, own[pair], everything[pair], column == 0,
                           len(pairs) > 3)
            elif column == len(pairs) - 1 and everything[pair]:
                blank = figure.add_subplot(grid[1, column])
                blank.set_axis_off()
                blank.text(0.5, 0.5, "rigid bodies have\nno membrane: (a)", ha="center",
                           va="center", color=GREY, transform=blank.transAxes)
        top -= block + _BETWEEN
    return figure


def _draw_pair(panels, pair, cases, everything, first, narrow):
    """A column: x_lead, x_lag and dz against time; `everything` gives the limits."""
    long = cases.get(0.0) if pair == "M2" else None
    later = long is not None and long.run.series("dz")[0][-1] > 1.25 * EARLY
    latest = max([case.run.series("dz")[0][-1] for case in everything], default=EARLY)
    if pair == "M2":
        latest = min(latest, EARLY)
    for row, (axes, column) in enumerate(zip(panels, ("lead_x", "lag_x", "dz"))):
        drawn = [case.run.series(column)[1][case.run.series(column)[0] <= latest]
                 for case in everything]
        for x_lag, case in cases.items():
            t, values = case.run.series(column)
            axes.plot(t, values, color=LAGS[x_lag][0], linestyle=LAGS[x_lag][1], zorder=3)
        if row < 2:
            axes.set_ylim(*_limits(drawn, _PLACES if row == 0 else _PLACES_AND_INSET))
            axes.yaxis.set_major_locator(MultipleLocator(0.4))
            axes.yaxis.set_minor_locator(MultipleLocator(0.2))
        else:
            axes.set_ylim(*_limits(drawn, (0, 2.4), 0.09))
            axes.yaxis.set_major_locator(MaxNLocator(5, integer=True, steps=[1, 2, 5, 10]))
        axes.set_xlim(0, latest)
        axes.xaxis.set_major_locator(MaxNLocator(4 if narrow else 5, steps=[1, 2, 2.5, 5, 10]))
        axes.tick_params(labelbottom=row == 2, labelleft=first or row == 2)
        if first:
            axes.set_ylabel((X_LEAD, X_LAG, DISTANCE)[row])
            axes.yaxis.set_label_coords(-0.31 if narrow else -0.24, 0.5)
        if cases:
            _state(axes, pair, row)
        else:
            axes.text(0.5, 0.5, "not computed", ha="center", va="center", color=GREY,
                      transform=axes.transAxes)
        if later:
            _draw_later(axes, long, column)
        elif pair == "B1" and row == 1:
            _draw_lift_offs(axes, cases)
    panels[0].set_title(PAIR_NAMES[pair], pad=3, fontsize=7.5, loc="right")
    panels[2].set_xlabel(TIME)


def _state(axes, pair, row):
    if row < 2:
        for value, text in _STATED_X[pair]:
            if row == 1 or value >= 0:
                _stated(axes, value, text)
        return
    if axes.get_ylim()[1] > STATED["dz stop"].value:
        _stated(axes, STATED["dz stop"].value, "paper: stops at 10")
    for value, text in _STATED_DZ.get(pair, []):
        _stated(axes, value, text)


def _draw_later(axes, case, column):
    """M2 from x_lag = 0 at later times."""
    t, values = case.run.series(column)
    late = t >= 0.5 * EARLY
    inset = _inset(axes, 0.44, 0.32, left=0.15, below=0.12)
    inset.plot(t[late], values[late], color=LAGS[0.0][0], linestyle=LAGS[0.0][1], linewidth=0.7)
    inset.set_xlim(t[late][0], t[-1])
    inset.locator_params(axis="both", nbins=3)
    inset.margins(y=0.15)


def _draw_lift_offs(axes, cases):
    """y of the cells of B1 against time."""
    own = {x: case for x, case in cases.items() if not _is_half(case)}
    if not own:
        return
    inset = _inset(axes, 0.46, 0.30, left=0.22, below=0.12)
    for x_lag, case in own.items():
        t, y = case.run.series("lag_y")
        inset.plot(t, y, color=LAGS[x_lag][0], linestyle=LAGS[x_lag][1], linewidth=0.7)
    inset.set_xlim(0, axes.get_xlim()[1])
    _label_inside(inset, "$y$")
    inset.locator_params(axis="both", nbins=3)


def _describe_pairs(found, pairs, more):
    ends = []
    for method, own in found.items():
        for pair, cases in own.items():
            lasts = [f"{_number(x)}: {case.run.series('dz')[1][-1]:.2f} "
                     f"(t = {case.run.series('dz')[0][-1]:.0f}, "
                     f"{quantities.class_of(case, pair, x).verdict or 'still running'})"
                     for x, case in cases.items()]
            if lasts:
                ends.append(f"{pair} {METHOD_NAMES[method]}: {', '.join(lasts)}")
    used = [case for own in found.values() for cases in own.values() for case in cases.values()]
    blocks = ("Block (a) is by the clean method, block (b) by the paper's. "
              if len(found) > 1 else f"Shown is {_methods_drawn(used)}. ")
    caption = (f"Lateral positions of the leading and the lagging body and their axial distance "
               f"Δz against time, for the pairs {_and(pairs)}, five starts x_lag and x_lead = 0.2. "
               f"{blocks}{more} {DASHED} {UNITS} {_how(used)}")
    return caption, ("Columns of panels with x_lead, x_lag and Δz against time; Δz at the end by "
                     f"x_lag is, for {'; '.join(ends)}.")


# ------------------------------------------------------------------------------------------------
# Fig. 7: migration times

_WAYS = {"slower": 10, "faster": 11}  # carets that stand on their place, up and down
_BODIES = {"lead": ("leading", COLOURS[0], "o", -1), "lag": ("lagging", COLOURS[1], "s", 1)}


def _migrations(study):
    """{method: migration_ratios()}, if there is any."""
    found = {method: _found(quantities.migration_ratios, study, method) for method in METHODS}
    return found if any(_has_ratios(own) for own in found.values()) else {}


def _has_ratios(ratios):
    return any(own.ratio.known for both in ratios.values() for own in both.values())


def _draw_migration(_study, found):
    known = {method: own for method, own in found.items() if _has_ratios(own)}
    figure = Figure(figsize=(ONE, 2.7), layout="constrained")
    axes = figure.subplots()
    values = []
    for shift, (method, own) in zip((0.0, 0.022) if len(known) > 1 else (0,), known.items()):
        for body, (_, colour, sign, side) in _BODIES.items():
            points = [(x + 0.012 * side + shift * side, both[body].ratio.value)
                      for x, both in own.items() if both[body].ratio.known]
            if not points:
                continue
            x, y = [at for at, _ in points], [value.value for _, value in points]
            axes.errorbar(x, y, [value.error for _, value in points], marker=sign, color=colour,
                          linestyle=METHOD_STYLES[method], linewidth=0.8, zorder=3,
                          markerfacecolor=colour if method == "clean" else "white",
                          elinewidth=0.8, capsize=1.6)
            values += [np.array(y) + [value.error for _, value in points],
                       np.array(y) - [value.error for _, value in points]]
    low, high = _limits(values, (0.8, 1.2), 0.12)
    axes.set(xlim=(-0.5, 0.5), ylim=(low, high), xlabel=X_LAG,
             ylabel=r"$t^\mathrm{m}_\mathrm{pair}\,/\,t^\mathrm{m}_\mathrm{single}$")
    axes.set_xticks(X_LAGS, [_number(x) for x in X_LAGS])
    _stated(axes, 1, "")
    # On which side of 1 the paper says that each point is.
    for body, places in quantities.MIGRATES.items():
        for x, way in places.items():
            axes.plot(x + 0.05 * _BODIES[body][3], 1, marker=_WAYS[way], markersize=5,
                      color=_BODIES[body][1], alpha=0.7, zorder=1, linestyle="none",
                      markeredgewidth=0, gid="stated")
    handles = [Line2D([], [], color=colour, marker=sign, linestyle="none", label=name)
               for name, colour, sign, _ in _BODIES.values()]
    handles += [Line2D([], [], color=GREY, marker="o", linestyle=METHOD_STYLES[method],
                       linewidth=0.8, markerfacecolor=GREY if method == "clean" else "white",
                       label=METHOD_NAMES[method]) for method in known]
    handles += [Line2D([], [], color=PALE, marker=sign, linestyle="none", markersize=5,
                       markeredgewidth=0, label=f"paper: {way}") for way, sign in _WAYS.items()]
    _legend_beside(figure, handles, 2)
    return figure


def _describe_migration(study, found):
    texts, missing, beyond = [], [], 0
    for method, ratios in found.items():
        for body, (name, *_) in _BODIES.items():
            own = {x: both[body] for x, both in ratios.items()}
            known = [f"{_number(x)}: {said(r.ratio)}" for x, r in own.items() if r.ratio.known]
            beyond += sum(r.extrapolated for r in own.values() if r.ratio.known)
            if known:
                texts.append(f"{name}, {METHOD_NAMES[method]}, {', '.join(known)}")
            missing += [f"{name} {_number(x)} {METHOD_NAMES[method]}" for x, r in own.items()
                        if not r.ratio.known and r.pair.case]
    cases = [study.pair("M1", x, method) for x in X_LAGS for method in METHODS]
    caption = ("Time that the bodies of the pair M1 take to come within 10⁻³ W of the centre for "
               "good, over that of a single body from the same distance, against the start of the "
               "lagging one. Filled signs are by the clean method, open ones by the paper's. "
               "Carets at 1 say on which side the paper has each. At x_lag = 0 the lagging body starts "
               f"where single ones stay. {beyond} of the ratios have a time that is extrapolated "
               "along the exponential that the body follows."
               + (f" No time could be told for {_and(missing)}." if missing else "")
               + f" {_how(cases)}")
    return caption, f"Ratios of migration times against x_lag: {'; '.join(texts)}."


# ------------------------------------------------------------------------------------------------
# Fig. 8: damped oscillations


def _damped(study):
    """{method: damped_oscillations()}, of the methods that have any."""
    return {method: own for method in METHODS
            if (own := _found(quantities.damped_oscillations, study, method))}


def _draw_damped(study, found):
    figure = Figure(figsize=(ONE, 4.9), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (1, 1.25)})
    rows = [(top, "maximum", r"$\max(\Delta z)$", COLOURS[1], "s"),
            (top, "equilibrium", r"$\Delta z_\mathrm{eq}$", COLOURS[0], "o"),
            (bottom, "damping", r"$\zeta$", BLACK, "D")]
    heights = {id(top): [], id(bottom): []}
    for method, own in found.items():
        shift = 0.0 if len(found) == 1 else {"clean": -0.002, "paper": 0.002}[method]
        for axes, which, _, colour, sign in rows:
            points = [(x + shift, getattr(o, which).value) for x, o in sorted(own.items())
                      if getattr(o, which).known]
            if not points:
                continue
            x, y = [at for at, _ in points], np.array([value.value for _, value in points])
            error = np.array([value.error for _, value in points])
            axes.errorbar(x, y, error, marker=sign, color=colour, linewidth=0.8,
                          linestyle=METHOD_STYLES[method], elinewidth=0.8, capsize=1.6, zorder=3,
                          markerfacecolor=colour if method == "clean" else "white")
            heights[id(axes)] += [y - error, y + error]
    top.set_ylim(*_limits(heights[id(top)], (0.8, 2.2), 0.08))
    # Room above for the inset.
    low, high = _limits(heights[id(bottom)], (0, 0.05), 0.08)
    bottom.set_ylim(low, high + 1.15 * (high - low))
    top.set_ylabel(r"$\max(\Delta z),\ \Delta z_\mathrm{eq}\;\,[W]$")
    bottom.set_ylabel(r"$\zeta\;\,[\nu/W^2]$")
    bottom.set_xlim(-0.165, 0.015)
    bottom.set_xticks(quantities.DAMPED_X_LAGS[::-1],
                      [_number(x) for x in quantities.DAMPED_X_LAGS[::-1]])
    bottom.set_xlabel(X_LAG)
    _stated(top, STATED["M2 dz_eq"].value, "paper: close to 1, the start")
    for letter, axes in zip("ab", (top, bottom)):
        _letter(axes, letter)
    handles = [Line2D([], [], color=colour, marker=sign, linestyle="none", label=text)
               for _, _, text, colour, sign in rows]
    handles += [Line2D([], [], color=GREY, linewidth=0.8, marker="o",
                       linestyle=METHOD_STYLES[method], label=METHOD_NAMES[method],
                       markerfacecolor=GREY if method == "clean" else "white") for method in found]
    _legend_beside(figure, handles, 2)
    _draw_spirals(bottom, study)
    return figure


def _draw_spirals(axes, study):
    """The paths of M2 from x_lag = 0 about their centre of mass, by the clean method if there is
    that."""
    case = next((case for method in METHODS
                 if (case := quantities.damped_case(study, 0.0, method))), None)
    if case is None:
        return
    path = quantities.centre_of_mass_path(case)
    inset = axes.inset_axes([0.22, 0.625, 0.75, 0.355])
    for body, (name, colour, _, _) in _BODIES.items():
        z, x = path[body].T
        inset.plot(z, x, color=colour, linewidth=0.7,
                   linestyle=STYLES[0] if body == "lead" else STYLES[1])
        inset.plot(z[0], x[0], _BODIES[body][2], color=colour, markersize=2.5)
        inset.annotate(name, (z.mean(), x.max()), xytext=(0, 2), textcoords="offset points",
                       fontsize=5.5, color=colour, ha="center")
    inset.tick_params(labelsize=5.5, length=1.6, pad=1.2, width=0.5)
    inset.set_xlabel(r"$z-z_\mathrm{cm}$", fontsize=SMALL, labelpad=0.5)
    inset.set_ylabel(r"$x-x_\mathrm{cm}$", fontsize=SMALL, labelpad=0.5)
    inset.margins(x=0.05, y=0.22)
    inset.locator_params(axis="y", nbins=3)


def _describe_damped(study, found):
    texts, missing = [], []
    for method, oscillations in found.items():
        for x, own in oscillations.items():
            texts.append(f"x_lag = {_number(x)} {METHOD_NAMES[method]}: max(Δz) "
                         f"{said(own.maximum)}, Δz_eq {said(own.equilibrium)}, ζ "
                         f"{said(own.damping)}, period {said(own.period)}")
            if not own.damping.known:
                missing.append(f"x_lag = {_number(x)} {METHOD_NAMES[method]} "
                               f"({own.damping.reason})")
    cases = [quantities.damped_case(study, x, method)
             for x in quantities.DAMPED_X_LAGS for method in METHODS]
    caption = ("Damped oscillations of the axial distance Δz of the pair M2: (a) the largest Δz "
               "and where Δz comes to; (b) the damping rate ζ of Δz − Δz_eq, which falls off as "
               "exp(−ζt), by the damped cosine that fits Δz from the turn on from which one holds; "
               "its error also says how much that hangs on the start. Inset: paths of both bodies "
               "about their centre of mass for x_lag = 0. Filled signs are with membrane mobility, "
               "open ones without." + (f" No rate could be told for {'; '.join(missing)}."
                                       if missing else "") + f" {DASHED} {UNITS} {_how(cases)}")
    return caption, f"Points against x_lag: {'; '.join(texts)}."


# ------------------------------------------------------------------------------------------------
# Fig. 10: a tumbling cell

SNAPSHOTS = 8


def _tumbling_cases(study):
    return {method: case for method in METHODS
            if (case := quantities.single_case(study, "biconcave-La10", 0.2, method))}


def snapshots(case, count=SNAPSHOTS):
    """So many frames of a run, at even times over the first tumble of the body, or over the whole
    run where it makes none: a list of numbers. Raises DuctileError for a run without surfaces."""
    times = case.run.times
    tumbles = quantities.tumbling_periods(case)
    begin, end = (tumbles.ends[0], tumbles.ends[1]) if len(tumbles.ends) > 1 else times[[0, -1]]
    nearest = [int(np.argmin(np.abs(times - t))) for t in np.linspace(begin, end, count)]
    return list(dict.fromkeys(nearest))


def _outlines(study):
    """{method: [(time, centre, polygons, marker)]} of the tumbling cell."""
    found = {}
    for method, case in _tumbling_cases(study).items():
        try:
            frames = snapshots(case)
            path = quantities.marker_path(case, frames=frames)
            own = [(*quantities.outline(case, frame=frame), marker)
                   for frame, marker in zip(frames, path.marker)]
        except (DuctileError, KeyError, IndexError):
            continue
        if own:
            found[method] = own
    return found


def _draw_tumble(_study, found):
    apart = 1.12
    width = apart * SNAPSHOTS + 0.1
    tops = [loop[:, 0].max() for own in found.values() for _, _, loops, _ in own
            for loop in loops]
    bottoms = [loop[:, 0].min() for own in found.values() for _, _, loops, _ in own
               for loop in loops]
    low, high = min(min(bottoms) - 0.14, -0.14), max(tops) + 0.2
    each = (TWO - 0.47) / width * (high - low) + 0.24
    figure = Figure(figsize=(TWO, each * len(found) + 0.24), layout="constrained")
    panels = figure.subplots(len(found), 1, squeeze=False)[:, 0]
    for axes, (method, own) in zip(panels, found.items()):
        for n, (time, centre, loops, marker) in enumerate(own):
            shift = np.array([apart * n + 0.55 - centre[2], 0])
            for loop in loops:
                points = loop[:, [2, 0]] + shift
                axes.fill(*points.T, facecolor=COLOURS[1], alpha=0.22, linewidth=0)
                axes.plot(*points.T, color=COLOURS[1], linewidth=1.1)
            axes.plot(marker[2] + shift[0], marker[0], "o", color=BLACK, markersize=2.6)
            axes.text(apart * n + 0.55, high - 0.03, f"({'abcdefghijkl'[n]})  {time:.2f}",
                      ha="center", va="top", fontsize=6.5)
        axes.axhline(0, color=PALE, linewidth=0.7, linestyle=(0, (6, 3, 1, 3)), zorder=0)
        axes.annotate("", (0.62, low + 0.05), (0.04, low + 0.05),
                      arrowprops={"arrowstyle": "-|>", "color": GREY, "linewidth": 0.9,
                                  "shrinkA": 0, "shrinkB": 0})
        axes.text(0.68, low + 0.05, "flow", fontsize=SMALL, color=GREY, va="center")
        axes.set(xlim=(0, width), ylim=(low, high), aspect="equal", ylabel=X)
        axes.set_xticks([])
        axes.tick_params(top=False)
        axes.set_title(METHOD_NAMES[method] if len(found) > 1 else "", loc="left", pad=2.5)
    panels[-1].set_xlabel(r"snapshots, with their times $[W^2/\nu]$", fontsize=7)
    return figure


def _describe_tumble(study, found):
    cases = _tumbling_cases(study)
    texts = []
    for method, own in found.items():
        tumbles = quantities.tumbling_periods(cases[method])
        taking = ", ".join(f"{duration.value:.1f}" for duration in tumbles.durations[:6])
        texts.append(f"{METHOD_NAMES[method]} from t = {own[0][0]:.2f} to {own[-1][0]:.2f}, the "
                     f"centre at x = {own[0][1][0]:.2f} and then {own[-1][1][0]:.2f}"
                     + (f", half turns taking {taking}" if taking else f" ({tumbles.reason})"))
    used = [cases[method] for method in found]
    caption = ("A biconcave cell of La = 10 that starts at x = 0.2 tumbles: its outline in the "
               "plane y = 0, cut out of the surface, at even times over the first half turn of its "
               "shape. The flow is from left to right, x points up, the line is the channel's axis "
               "and the dot a point of the membrane that starts on the rim. "
               f"{UNITS} {_how(used)}")
    return caption, f"Outlines of the cell side by side: {'; '.join(texts)}."


# ------------------------------------------------------------------------------------------------
# Fig. 12: a marker's path


def _paths(study):
    """{method: (case, MarkerPath)} of the cell of B1 that starts at 0.2."""
    found = {}
    for method in METHODS:
        case = study.pair("B1", 0.2, method)
        try:
            if case:
                found[method] = case, quantities.marker_path(case, "lag")
        except (DuctileError, KeyError):
            continue
    return found


def _coloured(points, values, norm, **more):
    """A line through points (n, 2) or (n, 3), coloured by values."""
    if points.shape[1] == 3:
        from mpl_toolkits.mplot3d.art3d import Line3DCollection as Collection
    else:
        Collection = LineCollection
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    # From a green that is seen on white.
    colours = matplotlib.colormaps["viridis_r"](np.linspace(0.2, 1, 256))
    line = Collection(pieces, cmap=ListedColormap(colours), norm=norm, **more)
    line.set_array(0.5 * (values[1:] + values[:-1]))
    return line


def _draw_path(_study, found):
    largest = max(path.from_midplane.max() for _, path in found.values())
    norm = Normalize(0, max(largest, 1e-3))
    row = 2.15
    height = row * len(found) + 0.1
    figure = Figure(figsize=(TWO, height))
    line = None
    for number, (method, (case, path)) in enumerate(found.items()):
        top = height - row * number
        name = METHOD_NAMES[method] + (", half of the channel computed" if _is_half(case) else "")
        spatial = figure.add_axes([-0.012, (top - row + 0.06) / height, 0.53, 2.0 / height],
                                  projection="3d", computed_zorder=False)
        line = _draw_in_space(spatial, path, norm)
        figure.text(0.012, (top - 0.12) / height,
                    f"$\\bf{{({'ab'[number]})}}$  {name}", fontsize=8, va="center")
        _draw_along_flow(figure, path, norm, (top - 1.73) / height, 1.3 / height)
    bar = figure.add_axes([0.937, 0.45 / height, 0.013, (height - 0.9) / height])
    figure.colorbar(line, cax=bar)
    bar.set_title(r"$|y|\;\,[W]$", fontsize=7, pad=4)
    bar.tick_params(right=True, left=False, labelsize=6)
    return figure


def _draw_in_space(axes, path, norm):
    """The marker in the channel: along it z from the start, up x."""
    along = path.marker[:, 2] - path.marker[0, 2]
    points = np.column_stack([along, path.marker[:, 1], path.marker[:, 0]])
    line = axes.add_collection3d(_coloured(points, path.from_midplane, norm, linewidth=1.0))
    wide = max(0.1, 1.1 * np.abs(path.marker[:, 1]).max())
    low, high = _limits([path.marker[:, 0]], (-0.4, 0.6))
    axes.set(xlim=(0, along.max()), ylim=(-wide, wide), zlim=(low, high))
    # The midplane y = 0, in which a cell that tumbles stays.
    axes.plot_surface(np.array([[0, along.max()]] * 2), np.zeros((2, 2)),
                      np.array([[low, low], [high, high]]), color=COLOURS[5], alpha=0.13,
                      shade=False, zorder=0)
    axes.set_box_aspect((2.7, 1.15, 1.3), zoom=1.22)
    axes.view_init(elev=20, azim=-64)
    axes.set_xlabel(r"$z\;\,[W]$", labelpad=-4)
    axes.set_ylabel(r"$y\;\,[W]$", labelpad=-4)
    axes.set_zlabel(r"$x\;\,[W]$", labelpad=-7)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_tick_params(labelsize=6, pad=-3)
        axis.pane.set_facecolor("white")
    axes.grid(False)
    axes.locator_params(axis="y", nbins=3)
    axes.locator_params(axis="z", nbins=4)
    return line


def _draw_along_flow(figure, path, norm, bottom, height):
    """Relative to the cell's centre and seen along the flow: the first third of the time, and the
    last."""
    t = path.t
    third = (t[-1] - t[0]) / 3
    wide = 1.08 * np.abs(path.relative).max()
    for n, (kept, name) in enumerate(((t <= t[0] + third, "first"), (t >= t[-1] - third, "last"))):
        axes = figure.add_axes([0.597 + 0.168 * n, bottom, 0.148, height])
        axes.add_collection(_coloured(path.relative[kept][:, [1, 0]], path.from_midplane[kept],
                                      norm, linewidth=0.9))
        axes.axvline(0, color=COLOURS[5], linewidth=2.5, alpha=0.3, zorder=0)
        axes.set(xlim=(-wide, wide), ylim=(-wide, wide), aspect="equal",
                 xlabel=r"$y-y_\mathrm{c}\;\,[W]$")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MultipleLocator(0.4))
        axes.xaxis.label.set_fontsize(7)
        axes.set_title(f"$t$ {'<' if n == 0 else '>'} {t[kept][-1 if n == 0 else 0]:.0f}, the "
                       f"{name} third", fontsize=6.5, pad=3)
        if n == 0:
            axes.set_ylabel(r"$x-x_\mathrm{c}\;\,[W]$", labelpad=-1, fontsize=7)
        else:
            axes.tick_params(labelleft=False)


def _describe_path(_study, found):
    texts = []
    for method, (case, path) in found.items():
        third = (path.t[-1] - path.t[0]) / 3
        early = path.from_midplane[path.t <= path.t[0] + third].max()
        late = path.from_midplane[path.t >= path.t[-1] - third].max()
        kinds = [turning.motion or "unclear" for turning in quantities.rotation_kinds(case, "lag")]
        begins = quantities.wobbles_from(case, "lag")
        texts.append(f"{METHOD_NAMES[method]} the marker is up to {early:.3f} from the midplane in "
                     f"the first third of the time and up to {late:.3f} in the last; by thirds the "
                     f"motion is {', '.join(kinds)}"
                     + (f", and the axis tilts by more than 10 degrees from t = "
                        f"{begins.value.value:.1f} on" if begins.known else ""))
    halves = [METHOD_NAMES[method] for method, (case, _) in found.items() if _is_half(case)]
    caption = ("The path of a marker that starts on the rim of the biconcave cell in the midplane, "
               "in the pair B1 from x_lag = 0.2. Left: in the channel, z from where it starts. "
               "Right: relative to the cell's centre and seen along the flow, in the first and in "
               "the last third of the time: a cell that tumbles in the plane keeps the marker on "
               "the line, one that wobbles does not. Colours are the marker's distance from the "
               "midplane. " + (f"Half of the channel was computed {_and(halves)}: there the cell "
                               "cannot leave the plane. " if halves else "")
               + f"{UNITS} {_how(case for case, _ in found.values())}")
    return caption, f"A marker's path in space: {'; '.join(texts)}."


# ------------------------------------------------------------------------------------------------
# Fig. 13: equilibrium distances


def _equilibria(study):
    """{method: {(pair, x_lag): Quantity}}, of those that are known; rigid pairs count once."""
    found = {method: _found(quantities.equilibrium_distances, study, method) for method in METHODS}
    known = {method: {key: q for key, q in own.items()
                      if q.known and not (method == "paper" and key[0] == "M3")}
             for method, own in found.items()}
    return known if any(known.values()) else {}


def _draw_equilibria(_study, drawn):
    figure = Figure(figsize=(TWO, 2.75), layout="constrained")
    axes = figure.subplots()
    heights = []
    for (method, own), beside in zip(drawn.items(), (-0.006, 0.006)):
        for (pair, x_lag), q in own.items():
            colour, sign = PAIR_SIGNS[pair]
            at = x_lag + 0.0245 * (PAIRS.index(pair) - 3) + (0 if pair == "M3" else beside)
            y, error = q.value.value, q.value.error
            if q.swing and q.swing > 0.05:
                axes.plot([at, at], [y - q.swing, y + q.swing], color=colour, linewidth=3,
                          alpha=0.22, solid_capstyle="butt", zorder=2)
                heights.append([y - q.swing, y + q.swing])
            axes.errorbar([at], [y], [error], fmt=sign, color=colour, elinewidth=0.9, capsize=1.8,
                          markersize=4, zorder=3,
                          markerfacecolor=colour if method == "clean" else "white")
            heights.append([y - error, y + error])
    low, high = _limits(heights, (0, 3), 0.06)
    axes.set(xlim=(-0.5, 0.5), ylim=(low, high), xlabel=X_LAG,
             ylabel=r"$\Delta z_\mathrm{eq}\;\,[W]$")
    axes.set_xticks(X_LAGS, [_number(x) for x in X_LAGS])
    for between in (-0.3, -0.1, 0.1, 0.3):
        axes.axvline(between, color="#e6e6e6", linewidth=0.6, zorder=0)
    _stated(axes, 1, "paper, M2 at 0 and \N{MINUS SIGN}0.2, B4 at \N{MINUS SIGN}0.2: close to 1")
    handles = [Line2D([], [], color=PAIR_SIGNS[pair][0], marker=PAIR_SIGNS[pair][1],
                      linestyle="none", label=pair) for pair in PAIRS
               if any(pair == key[0] for own in drawn.values() for key in own)]
    handles += [Line2D([], [], color=GREY, marker="o", linestyle="none", label=METHOD_NAMES[method],
                       markerfacecolor=GREY if method == "clean" else "white")
                for method in METHODS if drawn[method]]
    _legend_beside(figure, handles, 9, handletextpad=0.2, handlelength=1.6)
    return figure


def _describe_equilibria(study, found):
    texts = []
    for method, known in found.items():
        own = {}
        for (pair, x), q in known.items():
            swing = f", swinging by ±{q.swing:.2f}" if q.swing and q.swing > 0.05 else ""
            own.setdefault(pair, []).append(f"{said(q)} at {_number(x)}{swing}")
        if own:
            texts.append(f"{METHOD_NAMES[method].capitalize()}: " + "; ".join(
                f"{pair} {', '.join(values)}" for pair, values in own.items()))
    cases = [study.pair(pair, x, method)
             for pair in PAIRS for x in X_LAGS for method in METHODS]
    caption = ("The axial distance Δz_eq that the stable pairs come to, against the start of the "
               "lagging body. Filled signs are by the clean method, open ones by the paper's; "
               "bars are errors, and wide pale ones the range of oscillations that go on. Pairs that are "
               f"unstable, or undecided by the end of the run, have none. {DASHED} {UNITS} "
               f"{_how(cases)}")
    return caption, f"Equilibrium distances against x_lag. {'. '.join(texts)}."


# ------------------------------------------------------------------------------------------------
# Figs. 14 and 15: the paper's benchmarks


def _diagonals(study):
    return {method: case for method in METHODS
            if (case := quantities.only_case(study, "diagonal", method))}


def _draw_diagonal(_study, cases):
    figure = Figure(figsize=(ONE, 2.4), layout="constrained")
    axes = figure.subplots()
    drawn, latest = [], 0.0
    for method, case in cases.items():
        t, distance = quantities.diagonal_path(case)
        axes.plot(t, distance, color=COLOURS[0] if method == "clean" else COLOURS[1],
                  linestyle=METHOD_STYLES[method], label=METHOD_NAMES[method])
        drawn.append(distance)
        latest = max(latest, t[-1])
    low = min(np.concatenate(drawn).min(), 0.25)
    high = max(np.concatenate(drawn).max(), 0.4)
    axes.set(xlim=(0, latest), ylim=(low - 0.62 * (high - low), high + 0.08 * (high - low)),
             xlabel=TIME, ylabel=r"$\sqrt{x^2+y^2}\;\,[W]$")
    _legend_beside(figure, axes.get_legend_handles_labels()[0], 1)
    _draw_shape_on_diagonal(axes, next(iter(cases.values())))
    return figure


def _draw_shape_on_diagonal(axes, case):
    """The outline of the capsule at the end in the plane of the diagonal and the channel's axis."""
    try:
        _, centre, loops = quantities.outline(case, normal=(1, -1, 0))
    except (DuctileError, KeyError):
        return
    inset = axes.inset_axes([0.67, 0.09, 0.31, 0.34])
    for loop in loops:
        apart = loop - centre
        along = (apart[:, 0] + apart[:, 1]) / np.sqrt(2)
        inset.fill(apart[:, 2], along, facecolor=COLOURS[0], alpha=0.25, linewidth=0)
        inset.plot(apart[:, 2], along, color=COLOURS[0], linewidth=0.9)
    inset.set(aspect="equal")
    inset.margins(0.1)
    inset.set_xticks([])
    inset.set_yticks([])
    inset.set_xlabel("flow →", fontsize=SMALL, labelpad=1.5)
    inset.set_ylabel("outwards →", fontsize=SMALL, labelpad=1.5)


def _describe_diagonal(study, cases):
    texts = []
    for method, case in cases.items():
        t, distance = quantities.diagonal_path(case)
        found = _found(quantities.diagonal_equilibrium, study, method)
        texts.append(f"{METHOD_NAMES[method]} from {distance[0]:.3f} to {distance[-1]:.3f} at "
                     f"t = {t[-1]:.1f}" + (f", settling at {said(found)}" if found.known else ""))
    first = next(iter(cases.values()))
    reynolds = first.parameters.get("channel.reynolds")
    caption = (f"A capsule of La = {_number(_membranes([first], 'laplace')[0])} and radius "
               f"{first.start(first.run.bodies[0], 'radius'):g} migrates along the diagonal of the "
               f"channel at Re = {_number(float(reynolds))}. Inset: its outline at the end, in the "
               "plane of the diagonal and the channel's axis. The paper compares with a dashed "
               f"line, whose height its text does not state. {UNITS} {_how(cases.values())}")
    return caption, f"The distance from the axis along the diagonal goes {'; '.join(texts)}."


def _draw_rectangular(study, case):
    radius = case.start("lead", "radius")
    t, dz = case.run.series("dz")
    figure = Figure(figsize=(ONE, 2.2), layout="constrained")
    axes = figure.subplots()
    axes.plot(t, dz / radius, color=BLACK)
    axes.set(xlim=(0, t[-1]), ylim=_limits([dz / radius], (0, 6)), xlabel=TIME,
             ylabel=r"$\Delta z/a$")
    found = quantities.rectangular_equilibrium(study)
    if found.known:
        axes.axhline(found.value.value, color=COLOURS[0], linewidth=0.9, linestyle=STYLES[3],
                     zorder=2, gid="stated")
        _stated(axes, STATED["rectangular dz"].value / radius,
                f"paper: starts at {_number(STATED['rectangular dz'].value / radius)}")
        axes.annotate(f"ours: {said(found)}", (0.985, 0.04), xycoords="axes fraction",
                      fontsize=SMALL + 0.5, color=COLOURS[0], ha="right", va="bottom")
    return figure


def _describe_rectangular(study, case):
    t, dz = case.run.series("dz")
    radius = case.start("lead", "radius")
    found = quantities.rectangular_equilibrium(study)
    caption = ("The axial distance of a pair of rigid spheres, in radii, against time, in a "
               "channel twice as wide as high, from (x_lead, x_lag) = "
               f"({_number(case.start('lead'))}, {_number(case.start('lag'))}) and Δz = "
               f"{_number(dz[0], 3)}. Dash-dotted: where it comes to here. The paper compares with "
               f"a dashed line, whose height its text does not state. {UNITS} {_how([case])}")
    return caption, (f"Δz/a starts at {dz[0] / radius:.2f}, is between {dz.min() / radius:.2f} and "
                     f"{dz.max() / radius:.2f}, and {dz[-1] / radius:.2f} at t = {t[-1]:.0f}"
                     + (f"; it comes to {said(found)}." if found.known else "."))


# ------------------------------------------------------------------------------------------------
# Strain that the lattice cannot see

_STRAINED = {
    "single": "capsule, La = 100, from 0.2",
    "released": "capsule, La = 100, from 0.055",
    "cell": "cell, La = 10, from 0.2",
}


def _strained(study):
    """{which: {method: case}}, of those that there are."""
    pick = {"single": lambda method: quantities.single_case(study, "sphere-La100", 0.2, method),
            "released": lambda method: quantities.released_case(study, method),
            "cell": lambda method: quantities.single_case(study, "biconcave-La10", 0.2, method)}
    found = {which: {method: case for method in METHODS if (case := choose(method))}
             for which, choose in pick.items()}
    return {which: own for which, own in found.items() if own}


def _draw_artefact(_study, found):
    width = {1: ONE, 2: 0.72 * TWO}.get(len(found), TWO)
    figure = Figure(figsize=(width, 3.4), layout="constrained")
    panels = figure.subplots(2, len(found), squeeze=False, sharex="col")
    for column, (which, own) in enumerate(found.items()):
        energy, place = panels[:, column]
        highest, lowest, latest = 1e-3, np.inf, 0.0
        for method, case in own.items():
            body = case.run.bodies[0]
            line = {"color": COLOURS[0] if method == "clean" else COLOURS[1],
                    "linestyle": METHOD_STYLES[method]}
            history = quantities.strain_energy_history(case)[body]
            positive = history.energy > 0
            energy.semilogy(history.t[positive], history.energy[positive], **line)
            settled = history.energy[history.t >= min(1.0, 0.1 * history.t[-1])]
            lowest = min(lowest, settled[settled > 0].min(initial=np.inf))
            highest = max(highest, history.energy.max())
            t, x = case.run.series(f"{body}_x")
            place.plot(t, x, **line)
            latest = max(latest, t[-1])
        energy.set_ylim(0.5 * lowest if np.isfinite(lowest) else 1e-4, 2 * highest)
        place.set(xlim=(0, latest), xlabel=TIME)
        kind = {"single": "sphere-La100", "released": "released", "cell": "biconcave-La10"}[which]
        stated = STATED[kind].value
        place.set_ylim(*_limits([line.get_ydata() for line in place.lines],
                                (-0.04, max(0.1, stated + 0.04)), 0.1))
        _stated(place, stated, f"paper: {_number(stated)}")
        _letter(energy, "abc"[column], _STRAINED[which])
        energy.title.set_fontsize(7)
    panels[0, 0].set_ylabel(r"$E_\mathrm{s}\;\,[k_\mathrm{s}a^2]$")
    panels[1, 0].set_ylabel(X)
    methods = [method for method in METHODS if any(method in own for own in found.values())]
    handles = [Line2D([], [], color=COLOURS[0] if method == "clean" else COLOURS[1],
                      linestyle=METHOD_STYLES[method], label=METHOD_NAMES[method])
               for method in methods]
    _legend_beside(figure, handles, 2 if len(found) > 1 else 1)
    return figure


def _rate(rate):
    """"growing by 2.0% per unit of time"."""
    if abs(rate) < 5e-4:
        return "at rest"
    return f"{'growing' if rate > 0 else 'falling'} by {100 * abs(rate):.1f}% per unit of time"


def _describe_artefact(_study, found):
    texts = []
    for which, own in found.items():
        for method, case in own.items():
            history = quantities.strain_energy_history(case)[case.run.bodies[0]]
            x = case.run.series(f"{case.run.bodies[0]}_x")[1][-1]
            grows = history.growth
            texts.append(f"{_STRAINED[which]} {METHOD_NAMES[method]}: E_s "
                         f"{history.last.value.value:.2g} over the last quarter, up to t = "
                         f"{history.t[-1]:.0f}"
                         + (f", {_rate(grows.value.value)}" if grows.known else "")
                         + f", x = {_number(x, 2)} at the end")
    used = [case for own in found.values() for case in own.values()]
    caption = ("Strain on the scale of the lattice spacing gives the fluid no force, so that "
               "nothing relaxes it; it piles up where the membrane has no mobility. Above: strain "
               "energy of single capsules against time, logarithmic, by both methods. "
               f"Below: where they go. {DASHED} {UNITS} {_how(used)}")
    return caption, f"Strain energies against time: {'; '.join(texts)}."


# ------------------------------------------------------------------------------------------------
# All figures


@dataclass(frozen=True)
class Entry:
    """A figure: its `title`; `find(study)`, what it shows, empty where the study has nothing for
    it; and of that `draw(study, found)`, a Figure, and `describe(study, found)`, its caption and
    alternative text."""
    title: str
    find: Callable
    draw: Callable
    describe: Callable


def _of_singles(title, kinds, draw_inset, what, inset):
    return Entry(title, lambda study: _singles(study, kinds),
                 lambda study, found: _draw_singles(found, kinds, draw_inset),
                 lambda study, found: _describe_singles(study, found, what, inset))


def _of_pairs(title, pairs, more):
    return Entry(title, lambda study: _cases_of(study, pairs),
                 lambda study, found: _draw_pairs(found, pairs),
                 lambda study, found: _describe_pairs(found, pairs, more))


FIGURES = {
    "fig3": Entry("Four types of pairs", _examples, _draw_types, _describe_types),
    "fig4": Entry("Classes of all pairs", _all_classes, _draw_map, _describe_map),
    "fig5": _of_singles("Single spheres", _SPHERES, _draw_sections,
                        "single spherical capsules and rigid spheres",
                        "Insets: outlines of the capsules at the end, with their La, the flow from "
                        "left to right."),
    "fig6": _of_pairs("Pairs of equal bodies", ("M1", "M2", "M3"),
                      f"M2 is drawn up to t = {EARLY:.0f}. Insets: M2 from x_lag = 0 at later "
                      "times."),
    "fig7": Entry("Migration times in the pair M1", _migrations, _draw_migration,
                  _describe_migration),
    "fig8": Entry("Damped oscillations of the pair M2", _damped, _draw_damped, _describe_damped),
    "fig9": _of_singles("Single biconcave cells", _CELLS, _draw_lift_off, "single biconcave cells",
                        "Insets: y of the cell of La = 10 against the same time, where the whole "
                        "channel was computed."),
    "fig10": Entry("A cell that tumbles", _outlines, _draw_tumble, _describe_tumble),
    "fig11": _of_pairs("Pairs of different bodies", ("B1", "B2", "B3", "B4"),
                       "Inset: y of the cells of B1, where the whole channel was computed."),
    "fig12": Entry("From tumbling to wobbling", _paths, _draw_path, _describe_path),
    "fig13": Entry("Equilibrium distances", _equilibria, _draw_equilibria, _describe_equilibria),
    "fig14": Entry("A capsule on the diagonal", _diagonals, _draw_diagonal, _describe_diagonal),
    "fig15": Entry("A rigid pair in a rectangular channel",
                   lambda study: quantities.only_case(study, "rectangular", "clean"),
                   _draw_rectangular, _describe_rectangular),
    "artefact": Entry("Strain that the lattice cannot see", _strained, _draw_artefact,
                      _describe_artefact),
}


def _entry(study, which):
    """The Entry of a figure, and what it shows."""
    if which not in FIGURES:
        raise DuctileError(f"'{which}' is no figure: they are {', '.join(FIGURES)}")
    return FIGURES[which], _shown(study, which)


@_memory
def _shown(study, which):
    return FIGURES[which].find(study)


def draw(study, which):
    """A figure of FIGURES from a study, as a matplotlib Figure, or None where the study has no data
    for it. Raises DuctileError for other names."""
    entry, found = _entry(study, which)
    if not found:
        return None
    with matplotlib.rc_context(SETTINGS):
        return entry.draw(study, found)


def describe(study, which):
    """{"title", "caption", "alt"} of a figure that draw() draws: what it shows, how it was
    computed, and in words what can be seen, with its numbers; None where it draws nothing."""
    entry, found = _entry(study, which)
    if not found:
        return None
    caption, alt = entry.describe(study, found)
    return {"title": entry.title, "caption": " ".join(caption.split()),
            "alt": " ".join(alt.split())}
