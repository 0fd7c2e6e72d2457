#!/usr/bin/python3
"""Figure of doc/precision.md: runs with populations stored in single and in double precision.

    precision.py NAME=DOUBLE_DIR,SINGLE_DIR ... -o FIGURE.png

Each pair of directories holds runs of the same scenario. Draws where the particles are, and how far
apart the two runs are, and prints the largest distance.
"""
import argparse
import csv
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def columns(directory):
    with open(pathlib.Path(directory) / "trajectory.csv", newline="") as file:
        rows = list(csv.reader(file))
    names = [name.split("[")[0] for name in rows[0]]
    return {name: [float(row[n]) for row in rows[1:]] for n, name in enumerate(names)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="+", metavar="NAME=DOUBLE,SINGLE")
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7, 6))
    for number, run in enumerate(arguments.runs):
        name, directories = run.split("=", 1)
        double, single = map(columns, directories.split(",", 1))
        assert double["t"] == single["t"], f"{name}: the runs have different rows"
        colour = f"C{number}"
        above.plot(double["t"], double["lead_x"], colour, label=name)
        above.plot(double["t"], double["lag_x"], colour + "--")
        for quantity, style in (("lead_x", "-"), ("lag_x", "--"), ("dz", ":")):
            apart = [abs(a - b) for a, b in zip(double[quantity], single[quantity])]
            print(f"{name}: {quantity} at most {max(apart):.2e} W apart")
            below.semilogy(double["t"], [max(d, 1e-12) for d in apart], colour + style,
                           label=f"{name}, {quantity}", linewidth=0.9)
    above.set_ylabel("x [W] (leading: full, lagging: dashed)")
    above.legend()
    below.set_ylabel("|single - double| [W]")
    below.set_xlabel("t [W^2/nu]")
    below.legend(fontsize="x-small", ncol=3, loc="lower right")
    figure.tight_layout()
    figure.savefig(arguments.output, dpi=110)


if __name__ == "__main__":
    main()
