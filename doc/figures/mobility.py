#!/usr/bin/python3
"""Which modes of a membrane the 4-point kernel lets the fluid see, and what the mobility adds.

    doc/figures/mobility.py

Takes a flat sheet of markers on a lattice, at random places and angles, computes how the fluid
answers within a step to a force that varies as cos(q x) along it, (1/2) S S^T A per force per area,
and compares it with the kernel's transform, (3/16) phi^(q_1)^2 phi^(q_2)^2. Draws mobility.png
beside this file.
"""
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent


def phi(r):
    """Peskin's 4-point kernel, eq. (17)."""
    r = np.abs(r)
    inner = (3 - 2 * r + np.sqrt(np.maximum(0, 1 + 4 * r - 4 * r * r))) / 8
    outer = (5 - 2 * r - np.sqrt(np.maximum(0, -7 + 12 * r - 4 * r * r))) / 8
    return np.where(r <= 1, inner, np.where(r <= 2, outer, 0))


def transform(q):
    """Fourier transform of phi."""
    r = np.linspace(-2, 2, 4001)
    f = phi(r) * np.cos(np.multiply.outer(q, r))
    return (f.sum(axis=-1) - 0.5 * (f[..., 0] + f[..., -1])) * (r[1] - r[0])


def answer(q, direction, spacing, rng):
    """Measured: velocity per force per area of the mode cos(q . x) on a sheet in a periodic box."""
    box = 32
    count = int(box / spacing)
    h = box / count
    x, y = np.meshgrid(np.arange(count) * h, np.arange(count) * h, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) + rng.uniform(0, 1, 3)
    wave = 2 * np.pi / box * np.round(q * box / (2 * np.pi) * np.array(direction))
    mode = np.cos(points[:, :2] @ wave)
    grid = np.zeros((box, box, 8))
    base = np.floor(points).astype(int) - 1
    rows = []
    for i in range(4):
        for j in range(4):
            for k in range(4):
                node = base + [i, j, k]
                w = np.prod(phi(node - points), axis=1)
                rows.append((node[:, 0] % box, node[:, 1] % box, node[:, 2] % 8, w))
    for a, b, c, w in rows:
        np.add.at(grid, (a, b, c), w * mode * h * h)
    back = sum(w * grid[a, b, c] for a, b, c, w in rows)
    return np.linalg.norm(wave), 0.5 * (back @ mode) / (mode @ mode)


def main():
    rng = np.random.default_rng(1)
    wavelength = np.geomspace(2, 32, 400)
    q = 2 * np.pi / wavelength
    formula = 3 / 16 * transform(q) ** 2

    figure, axes = plt.subplots(figsize=(5.4, 3.8), constrained_layout=True)
    axes.loglog(wavelength, np.maximum(formula, 1e-12), color="C0",
                label=r"fluid within a step, $\frac{3}{16}\,\hat\varphi(q)^2$")
    for spacing, marker in ((0.6, "o"), (1.2, "s")):
        points = np.array([answer(k, (1, 0), spacing, rng)
                           for k in 2 * np.pi / np.array([2.3, 2.67, 3.2, 4, 5.33, 8, 16])])
        axes.loglog(2 * np.pi / points[:, 0], points[:, 1], marker, color="C1", mfc="none",
                    label=f"measured, markers {spacing} apart")
        for k, value in points:
            print(f"spacing {spacing}: wavelength {2 * np.pi / k:5.2f} dx, measured {value:.5f}, "
                  f"kernel's transform {3 / 16 * transform(np.array([k]))[0] ** 2:.5f}")
    for mobility, style in ((1e-3, "--"), (3e-4, ":")):
        axes.axhline(6 * mobility, color="0.3", ls=style, lw=1,
                     label=f"mobility {mobility:g} dx/eta, tau = 1")
        crossing = wavelength[np.argmin(np.abs(formula - 6 * mobility))]
        print(f"mobility {mobility:g}: as much as the fluid's answer at a wavelength of "
              f"{crossing:.2f} dx")
    axes.set_xticks([2, 3, 4, 6, 8, 16, 32], [2, 3, 4, 6, 8, 16, 32], minor=False)
    axes.minorticks_off()
    axes.set_xlabel("wavelength on the membrane / dx")
    axes.set_ylabel("velocity per force per area")
    axes.set_ylim(1e-5, 0.4)
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    figure.savefig(HERE / "mobility.png", dpi=150)


if __name__ == "__main__":
    main()
