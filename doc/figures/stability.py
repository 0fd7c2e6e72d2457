#!/usr/bin/python3
"""Predicted against measured limits of stability of the explicit integrators.

    doc/figures/stability.py

Reads stability.csv beside this file, the output of build/tests/bench/stability_bench, draws
stability.png and prints the tables of doc/stability.md.
"""
import csv
import math
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = pathlib.Path(__file__).resolve().parent
COLOURS = {"shear": "#0072B2", "bending": "#D55E00", "volume": "#009E73", "mixture": "#CC79A7"}
LABELS = {"shear": r"$k_s$ and $k_a$", "bending": r"$k_b$", "volume": r"$k_v$",
          "mixture": "all together"}
NUMBERS = ("tau", "radius", "edge", "k_a/k_s", "k_b/k_s", "k_v/k_s", "mobility", "predicted",
           "measured", "ratio", "mu", "frequency", "degree")


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for key in NUMBERS:
            row[key] = float(row[key])
    return rows


def kind(row):
    if row["run"] == "channel":
        return "*", "channel, either scheme"
    if row["integrator"] == "explicit-euler":
        return "o", "box, explicit-euler"
    return "s", "box, adams-bashforth"


def spread(rows):
    ratios = sorted(row["ratio"] for row in rows)
    rms = math.sqrt(sum(math.log(r) ** 2 for r in ratios) / len(ratios))
    return f"{len(rows):3d} | {ratios[0]:.3f} to {ratios[-1]:.3f} | {100 * rms:.1f}%"


def draw(rows):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.3), constrained_layout=True)
    for row in rows:
        marker, _ = kind(row)
        style = dict(marker=marker, color=COLOURS[row["raised"]], linestyle="none",
                     markersize=9 if marker == "*" else 5, markeredgecolor="white",
                     markeredgewidth=0.5, zorder=3 if marker == "*" else 2)
        left.loglog(row["measured"], row["predicted"], **style)
        right.semilogx(row["measured"], row["ratio"], **style)
    low = 0.8 * min(row["measured"] for row in rows)
    high = 1.25 * max(row["measured"] for row in rows)
    for axes, values in ((left, (low, high)), (right, (1, 1))):
        axes.plot((low, high), values, color="0.4", linewidth=0.8, zorder=1)
        axes.fill_between((low, high), [0.9 * v for v in values], [1.1 * v for v in values],
                          color="0.92", zorder=0, linewidth=0)
        axes.set_xlim(low, high)
        axes.set_xlabel("measured limit [lattice units]")
    left.set_ylim(low, high)
    left.set_ylabel("predicted limit [lattice units]")
    right.set_ylabel("predicted / measured")
    right.set_ylim(0.8, 1.2)
    for name, colour in COLOURS.items():
        left.plot([], [], "o", color=colour, label=LABELS[name])
    left.legend(frameon=False, loc="upper left", title="raised until the run fails")
    seen = {}
    for row in rows:
        seen.setdefault(*kind(row)[::-1])
    for label, marker in sorted(seen.items()):
        right.plot([], [], marker, color="0.3", label=label)
    right.legend(frameon=False, loc="upper right")
    figure.savefig(HERE / "stability.png", dpi=110)


def main():
    rows = read(HERE / "stability.csv")
    draw(rows)
    print("cases | number | predicted/measured | rms error")
    print("all  ", spread(rows))
    for integrator in ("explicit-euler", "adams-bashforth"):
        for name in COLOURS:
            some = [r for r in rows if r["run"] == "box" and r["integrator"] == integrator
                    and r["raised"] == name]
            print(f"box, {integrator}, {name} | {spread(some)}")
    print(f"channel | {spread([r for r in rows if r['run'] == 'channel'])}")
    print("\nchannel runs")
    for r in rows:
        if r["run"] == "channel":
            print(f"{r['raised']} | {r['integrator']} | {r['tau']:g} | {r['shape']} | "
                  f"{r['radius']:g} | {r['edge']:g} | {r['law']} | {r['mobility']:g} | "
                  f"{r['predicted']:.3g} | {r['measured']:.3g} | {r['ratio']:.3f}")
    print("\nbeyond 5%")
    for r in rows:
        if abs(r["ratio"] - 1) > 0.05:
            print(r)
    print("\nlimits against tau, a = 7.2, edge 1.2, C = 2: measured (predicted)")
    for tau in (0.55, 0.6, 0.7, 0.8, 0.9, 1.0):
        cells = []
        for integrator in ("explicit-euler", "adams-bashforth"):
            for name in ("shear", "bending", "volume"):
                for r in rows:
                    if ((r["run"], r["raised"], r["integrator"], r["tau"], r["radius"], r["edge"],
                         r["shape"], r["collision"], r["mobility"], r["law"])
                            == ("box", name, integrator, tau, 7.2, 1.2, "sphere", "bgk", 1e-3,
                                "skalak") and r["k_a/k_s"] == (2 if name == "shear" else 0)):
                        cells.append(f"{r['measured']:.3g} ({r['predicted']:.3g})")
        print(f"{tau:g} | " + " | ".join(cells))
    print("\nmu at the measured limit, by modulus, box, explicit-euler, tau = 1 and 0.6")
    for tau in (1.0, 0.6):
        for name in ("shear", "bending", "volume"):
            mu = sorted(r["mu"] for r in rows if r["run"] == "box" and r["raised"] == name
                        and r["integrator"] == "explicit-euler" and r["tau"] == tau)
            print(f"{tau:g} {name}: {mu[0]:.2f} to {mu[-1]:.2f}")


if __name__ == "__main__":
    main()
