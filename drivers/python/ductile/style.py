"""How all pictures look: colours that every common colour vision tells apart, and line styles that
tell the same things apart in grey."""
import numpy as np

# Okabe & Ito's palette.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
STYLES = ["-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5))]
BLACK, GREY, PALE, FAILED = "#222222", "#555555", "#999999", "#B2182B"
VERDICT_COLOURS = {"stable": "#009E73", "damped": "#0072B2", "bounded": "#CC79A7",
                   "unstable": "#D55E00", "undecided": "#666666"}
NAMES = {"lead": "leading", "lag": "lagging"}

SETTINGS = {
    "font.size": 10, "font.family": "DejaVu Sans", "axes.edgecolor": BLACK,
    "axes.labelcolor": BLACK, "text.color": BLACK, "xtick.color": BLACK, "ytick.color": BLACK,
    "axes.linewidth": 0.8, "xtick.direction": "in", "ytick.direction": "in", "xtick.top": True,
    "ytick.right": True, "legend.frameon": False, "lines.linewidth": 1.8,
    "mathtext.fontset": "dejavusans", "pdf.fonttype": 42,
}


def colours_of(count):
    """So many colours: of the palette, or evenly spaced over a map whose lightness rises."""
    if count <= len(COLOURS):
        return COLOURS[:count]
    from matplotlib import colormaps
    return [colormaps["viridis"](share) for share in np.linspace(0, 0.92, count)]


def grid(axes):
    axes.grid(color="#e6e6e6", linewidth=0.6)
    axes.set_axisbelow(True)


def zero_line(axes):
    axes.axhline(0, color=PALE, linewidth=0.8, linestyle=(0, (6, 4)), zorder=0)


def margin_labels(axes, entries):
    """Numbers in the margin at the right of a panel, whose limits are set: (value, error or None,
    text, colour) each, with a bar for the error at its height, and texts moved apart."""
    apart, lowest = 13.5, None
    height = axes.get_window_extent().height * 72 / axes.figure.dpi
    low, high = axes.get_ylim()
    apart /= max(height, 1)
    places = []
    for value, error, text, colour in sorted(entries, key=lambda entry: entry[0]):
        at = (value - low) / (high - low)
        lowest = at if lowest is None else max(at, lowest + apart)
        places.append([lowest, value, error, text, colour])
    # As far down as they were pushed up together, on average; they stay inside of the panel.
    if places:
        ats = np.array([place[0] for place in places])
        wanted = np.array([(place[1] - low) / (high - low) for place in places])
        shift = min((ats - wanted).mean() if len(ats) > 1 else 0.0, max(ats[0] - 0.02, 0.0))
        for place in places:
            place[0] -= shift
    for n, (at, value, error, text, colour) in enumerate(places):
        beside = 1.015 + (0.012 * n if len(places) > 1 else 0)
        if error is not None:
            axes.errorbar([beside], [value], [[error], [error]], fmt="o", markersize=3,
                          color=colour, elinewidth=1.4, capsize=2.2, clip_on=False,
                          transform=axes.get_yaxis_transform())
        axes.annotate(text, (1.015 if error is None else 1.035 + 0.012 * (len(places) - 1), at),
                      xycoords="axes fraction", ha="left", va="center", fontsize=8.5, color=colour,
                      annotation_clip=False)
