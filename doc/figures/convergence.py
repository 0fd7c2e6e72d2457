#!/usr/bin/python3
"""What is left of the lattice's spacing in single particles, pairs, drag, lift and deformation.

    ./ductile.sh converge [RUNS]    computes them, and calls
    doc/figures/convergence.py RUNS

Draws a figure a case into convergence/ beside this file, and prints the tables of
doc/convergence.md: each number by the paper's coupling (markers on the surface, a lattice at rest),
by the default ("corrected"), Richardson's limit of the two finest lattices, and the order that the
last three of each show, where they go one way.
"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent / "convergence"


def rows(path):
    with open(path, encoding="utf-8") as file:
        names = next(file).strip().split(",")
        table = np.array([[float(v) if v else np.nan for v in line.split(",")] for line in file])
    return dict(zip(names, table.T))


def settled(run):
    """x at the end, at rest."""
    return run["particle_x[W]"][-1] if run["t[W^2/nu]"][-1] > 39.9 else None


def mean_x(run):
    """Mean of x from t = 20 to 40: a cell tumbles."""
    late = run["t[W^2/nu]"] > 20
    return run["particle_x[W]"][late].mean() if run["t[W^2/nu]"][-1] > 39.9 else None


def early(run):
    """x at t = 5, on the way to the axis."""
    return float(np.interp(5, run["t[W^2/nu]"], run["particle_x[W]"]))


def farthest(run):
    """The largest dz after the two have passed each other, until t = 20."""
    return run["dz[W]"][run["t[W^2/nu]"] > 7].max() if run["t[W^2/nu]"][-1] > 19.9 else None


def turn(run):
    return run["dz[W]"].max() if run["dz[W]"][-1] < run["dz[W]"].max() else None


def last_distance(run):
    return run["dz[W]"][-1] if run["t[W^2/nu]"][-1] > 39.9 else None


def parted(run):
    """dz at t = 12, after the two have touched."""
    return run["dz[W]"][-1] if run["t[W^2/nu]"][-1] > 11.9 else None


# Name of the figure, campaign, case (with @ for the nodes), quantity, what it is.
CASES = [
    ("La10", "soft", "nodes_@", early, "La = 10: x at t = 5 [W]"),
    ("La100", "stiff", "nodes_@", settled, "La = 100: x at rest [W]"),
    ("cell", "cell", "nodes_@", mean_x, "biconcave, La = 100: mean x, t = 20 to 40 [W]"),
    ("rigid", "rigid", "nodes_@", settled, "rigid: x at rest [W]"),
    ("M2-near", "M2", "near_nodes_@", farthest, "M2, x_lag = 0: largest dz by t = 20 [W]"),
    ("M2-far", "M2", "far_nodes_@", turn, "M2, x_lag = 0.4: largest dz [W]"),
    ("M3", "M3", "apart_nodes_@", last_distance, "M3, x_lag = -0.2: dz at t = 40 [W]"),
    ("M3-touch", "M3", "touch_nodes_@", parted, "M3, x_lag = 0: dz at t = 12 [W]"),
]
NODES = (20, 24, 30, 36, 48, 60)
STATIC = {"array": "cubic array of spheres: K",
          "wall-far": "towards a wall, gap a: $F/6\\pi\\eta aU$",
          "wall-near": "towards a wall, gap 0.4 a: $F/6\\pi\\eta aU$",
          "shear-1": "capsule in shear, C = 1: D/Ca",
          "shear-2": "capsule in shear, C = 2: D/Ca", "lift": "held sphere: lift coefficient"}


def richardson(n, values, order=2):
    """The limit of the two finest, and the order that the three finest show."""
    if len(n) < 2:
        return None, None
    (a, b), (u, v) = n[-2:], values[-2:]
    limit = v + (v - u) / ((b / a) ** order - 1)
    if len(n) < 3:
        return limit, None
    w = values[-3]
    orders = np.linspace(0.2, 6, 581)
    ratio = [(n[-3] ** -p - n[-2] ** -p) / (n[-2] ** -p - n[-1] ** -p) for p in orders]
    asked = (w - u) / (u - v) if u != v else np.nan
    if not ratio[0] < asked < ratio[-1]:
        return limit, None
    return limit, float(np.interp(asked, ratio, orders))


def draw(name, label, series, limit, axis):
    figure, axes = plt.subplots(figsize=(4.6, 3.2), layout="constrained")
    for method, (n, values) in series.items():
        style = {"plain": "o--", "corrected": "s-"}[method.split(",")[0]]
        axes.plot(1 / np.array(n) ** 2, values, style, fillstyle="none",
                  label=method.replace("corrected", "default"))
    if limit is not None:
        axes.axhline(limit, color="0.6", lw=0.8)
    axes.set_xlim(left=0)
    axes.locator_params(axis="x", nbins=5)  # more would run into each other
    axes.set_xlabel(axis)
    axes.set_ylabel(label, fontsize="small")
    if len(series) > 4:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=3, fontsize="x-small",
                    frameon=False)
    else:
        axes.legend(fontsize="small", frameon=False)
    figure.savefig(HERE / f"{name}.png", dpi=110)
    plt.close(figure)


def main():
    runs = pathlib.Path(sys.argv[1])
    HERE.mkdir(exist_ok=True)
    print("| case | coupling | " + " | ".join(map(str, NODES)) + " | limit | order |")
    print("|---|---|" + "---|" * (len(NODES) + 2))
    for name, campaign, case, quantity, label in CASES:
        series = {}
        for method, suffix in (("plain", "-plain"), ("corrected", "")):
            found = {}
            for n in NODES:
                path = runs / (campaign + suffix) / "cases" / case.replace("@", str(n))
                path /= "trajectory.csv"
                if path.exists() and (value := quantity(rows(path))) is not None:
                    found[n] = value
            if not found:
                continue
            series[method] = (list(found), list(found.values()))
            limit, order = richardson(list(found), list(found.values()))
            cells = [f"{found[n]:.4f}" if n in found else "" for n in NODES]
            cells += [f"{limit:.4f}" if limit is not None else "",
                      f"{order:.1f}" if order is not None else ""]
            print(f"| {label} | {method} | " + " | ".join(cells) + " |")
        limit = richardson(*series["corrected"])[0] if "corrected" in series else None
        draw(name, label, series, limit, "1/nodes$^2$")
    static = runs / "cases.csv"
    if not static.exists():
        return
    with open(static, encoding="utf-8") as file:
        table = [(r[0], r[1], *map(float, r[2:])) for r in csv.reader(file)]
    for name, label in STATIC.items():
        series = {}
        law = None
        for case, method, tau, radius, value, theory in table:
            if case != name:
                continue
            key = f"{method}, tau = {tau:g}" if name == "lift" else method
            series.setdefault(key, ([], []))
            series[key][0].append(radius)
            series[key][1].append(value)
            law = None if np.isnan(theory) else theory
        if not series:
            continue
        print(f"\n{label}" + (f", law {law:.4f}" if law else ""))
        for key, (radii, values) in series.items():
            print(f"| {key} | " + " | ".join(f"a = {a:.3g}: {v:.4f}" for a, v in
                                             zip(radii, values)) + " |")
        draw(name, label, series, law, "(dx/a)$^2$")


if __name__ == "__main__":
    main()
