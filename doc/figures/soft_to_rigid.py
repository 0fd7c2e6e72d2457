#!/usr/bin/python3
"""From soft to rigid: where one sphere of softness La settles in the square channel, by one method.

    doc/figures/soft_to_rigid.py [--runs DIR] [--jobs N] [--program CMD] [--plot-only]

Runs the capsule at La = 10 to 10^6 with the implicit integrator, and the rigid sphere, at 36 nodes
across (a = 0.4, Re = 10, tau = 1, 6 W long), and draws soft_to_rigid.png beside this file. A run
whose summary is there already is not repeated. Each is released near to where it settles; x_eq is
extrapolated from the positions at the run's end and 8 and 16 time units before (Aitken).
"""
import argparse
import concurrent.futures
import csv
import json
import pathlib
import shlex
import subprocess

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parent.parent
# Softness, and a release not far from where it settles.
CAPSULES = {10: 0.06, 30: 0.12, 100: 0.28, 300: 0.36, 1e3: 0.4, 1e4: 0.425, 1e5: 0.425, 1e6: 0.425}
RIGID_START = 0.425
COMMON = ["--set", "channel.length=6", "--set", "fluid.storage=single", "--set", "run.time_limit=24",
          "--set", "output.surfaces_every=0"]


def run(program, directory, scenario, settings):
    if not (directory / "summary.json").exists():
        command = [*program, "run", str(TOP / "drivers" / "scenarios" / scenario), *COMMON,
                   "-o", str(directory), "--force"]
        for setting in settings:
            command += ["--set", setting]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    summary = json.loads((directory / "summary.json").read_text())
    body = summary["bodies"][0]
    x = body["position_W"][0]
    return {
        "t": summary["time_W2_over_nu"],
        "x": x,
        "x_eq": extrapolated(directory / "trajectory.csv"),
        "volume": body.get("volume_error_max"),
        "wall": summary["wall_time_s"],
    }


def extrapolated(file, apart=8):
    """The limit of an exponential approach; the last position where it is not one."""
    with open(file, encoding="utf-8") as lines:
        rows = list(csv.reader(lines))
    column = rows[0].index("particle_x[W]")
    track = [(float(row[0]), float(row[column])) for row in rows[1:]]
    end = track[-1][0]
    x0, x1, x2 = (min(track, key=lambda row: abs(row[0] - (end - n * apart)))[1]
                  for n in (2, 1, 0))
    ratio = (x2 - x1) / (x1 - x0) if x1 != x0 else 1
    return x2 + (x2 - x1) * ratio / (1 - ratio) if 0 < ratio < 0.9 else x2


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--runs", type=pathlib.Path, default=TOP / "runs" / "soft_to_rigid")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--program", default=f"{TOP / 'ductile.sh'} -n 1")
    parser.add_argument("--plot-only", action="store_true",
                        help="draw from the runs that are there, make none")
    arguments = parser.parse_args()
    program = shlex.split(arguments.program)

    jobs = {"rigid": ("rigid.toml", [f"body.particle.x={RIGID_START}"])}
    for laplace, start in sorted(CAPSULES.items(), reverse=True):
        jobs[laplace] = ("sphere-La100.toml",
                         [f"body.particle.laplace={laplace:g}", f"body.particle.x={start}",
                          "membrane.integrator=implicit"])
    results = {}
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        pending = {}
        for key, (scenario, settings) in jobs.items():
            name = "rigid" if key == "rigid" else f"La{key:g}"
            directory = arguments.runs / name
            if arguments.plot_only and not (directory / "summary.json").exists():
                continue
            pending[key] = pool.submit(run, program, directory, scenario, settings)
        for key, future in pending.items():
            results[key] = future.result()

    print(f"{'La':>8} {'t':>6} {'x':>8} {'x_eq':>8} {'max volume error':>17} {'wall time':>10}")
    for key, r in results.items():
        volume = "-" if r["volume"] is None else f"{r['volume']:.1e}"
        name = key if key == "rigid" else f"{key:g}"
        print(f"{name:>8} {r['t']:6.1f} {r['x']:8.4f} {r['x_eq']:8.4f} {volume:>17}"
              f" {r['wall']:8.0f} s")

    figure, axes = plt.subplots(figsize=(5.2, 3.6), constrained_layout=True)
    softness = sorted(key for key in results if key != "rigid")
    axes.semilogx(softness, [abs(results[key]["x_eq"]) for key in softness], "o-", color="C0",
                  label="capsule, implicit")
    if "rigid" in results:
        axes.axhline(results["rigid"]["x_eq"], color="0.35", ls="--", label="rigid sphere")
    axes.set_xlabel(r"Laplace number $La = k_s a/(\rho\nu^2)$")
    axes.set_ylabel(r"equilibrium position $x_{eq}/W$")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(HERE / "soft_to_rigid.png", dpi=150)
    print(f"drawn into {HERE / 'soft_to_rigid.png'}")


if __name__ == "__main__":
    main()
