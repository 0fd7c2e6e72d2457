"""What the tests of the Python package share: where it is, and runs made of numbers."""
import json
import os
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "drivers" / "python"
sys.path.insert(0, str(PACKAGE))

import numpy as np  # noqa: E402

# The program, where a test needs it; ctest gives it.
PROGRAM = os.environ.get("DUCTILE_PROGRAM")


def write_trajectory(directory, columns, units=None):
    """A trajectory.csv of {name: values}; the unit of a name that is not given is W."""
    units = {"t": "W^2/nu", **(units or {})}
    header = ",".join(f"{name}[{units.get(name, 'W')}]" for name in columns)
    rows = zip(*(np.asarray(values, float) for values in columns.values()))
    text = header + "\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in rows)
    Path(directory).mkdir(parents=True, exist_ok=True)
    (Path(directory) / "trajectory.csv").write_text(text)


def pair_columns(t, x_lag=-0.2):
    """The columns of a pair of today's program, with plausible numbers."""
    t = np.asarray(t, float)
    zero = np.zeros_like(t)
    columns = {"t": t}
    for name, x, z in (("lead", 0.2, 0.5), ("lag", x_lag, -0.5)):
        columns |= {f"{name}_x": x * np.exp(-t / 10), f"{name}_y": zero, f"{name}_z": z + 4 * t,
                    f"{name}_vx": zero, f"{name}_vy": zero, f"{name}_vz": zero + 4}
    columns["dz"] = 1 + 0.5 * (1 - np.exp(-t / 8))
    for name in ("lead", "lag"):
        columns |= {f"{name}_deformation": zero + 0.1, f"{name}_volume_error": zero,
                    f"{name}_strain_energy": 0.05 * np.exp(-t), f"{name}_slip": zero}
    return columns


def pair_parameters(x_lag=-0.2, laplace=10.0, **others):
    parameters = {"name": "M1", "channel.nodes": 36, "channel.length": 12.0,
                  "channel.reynolds": 10.0}
    for name, x in (("lead", 0.2), ("lag", x_lag)):
        parameters |= {f"body.{name}.kind": "capsule", f"body.{name}.shape": "sphere",
                       f"body.{name}.radius": 0.4, f"body.{name}.x": x, f"body.{name}.y": 0.0,
                       f"body.{name}.laplace": laplace, f"body.{name}.mobility": 0.001}
    return parameters | others


def write_pair(directory, x_lag=-0.2, laplace=10.0, t=None, summary=True, **others):
    """A whole directory of a run, but for its frames."""
    t = np.linspace(0, 40, 201) if t is None else t
    write_trajectory(directory, pair_columns(t, x_lag))
    if summary:
        text = {"scenario": "M1", "status": "decided", "verdict": "stable",
                "verdict_reason": "dz approaches 1.5 +- 0.04", "dz_W": 1.49,
                "dz_limit_W": 1.5, "dz_limit_error_W": 0.04,
                "bodies": [{"name": "lead", "x_limit_W": 0.001, "x_limit_error_W": 0.002},
                           {"name": "lag", "x_limit_W": -0.001, "x_limit_error_W": 0.002}],
                "parameters": pair_parameters(x_lag, laplace, **others)}
        (Path(directory) / "summary.json").write_text(json.dumps(text))


def correlated_noise(rng, count, step, time):
    """Noise of unit variance whose correlation falls off as exp(-|t - t'|/time); white for 0."""
    white = rng.normal(size=count)
    if time == 0:
        return white
    correlation = np.exp(-step / time)
    noise = white.copy()
    for n in range(1, count):
        noise[n] = correlation * noise[n - 1] + np.sqrt(1 - correlation**2) * white[n]
    return noise


def sphere(frequency=3):
    """Vertices on the unit sphere, and triangles counterclockwise from outside: an icosahedron
    whose faces are divided in four `frequency` times."""
    golden = (1 + 5**0.5) / 2
    vertices = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0),
                (0, -1, golden), (0, 1, golden), (0, -1, -golden), (0, 1, -golden),
                (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]
    vertices = [np.array(v) / np.linalg.norm(v) for v in vertices]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
                 (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
                 (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(frequency):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                point = vertices[a] + vertices[b]
                middles[key] = len(vertices)
                vertices.append(point / np.linalg.norm(point))
            return middles[key]
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return np.array(vertices), np.array(triangles)
