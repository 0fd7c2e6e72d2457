#!/usr/bin/python3
"""The numbers and figures of the study of the paper, from runs that follow known laws."""
import itertools
import json
import math
import tempfile
import unittest
from pathlib import Path

import support
import h5py
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from scipy import optimize

import ductile
from ductile.paper import figures, quantities
from ductile.paper.study import METHODS, PAIRS, X_LAGS, Study

# ------------------------------------------------------------------------------------------------
# The laws: lengths in W, times in W^2/nu.

T = np.arange(0, 100.1, 0.25)
SINGLE_TIME = 12.0  # e-folding time of a soft sphere's way to the centre
PAIR_TIMES = {"lead": {-0.4: 13.8, -0.2: 10.8, 0.0: 9.6, 0.2: 8.4, 0.4: 30.0},
              "lag": {-0.4: 11.4, -0.2: 10.2, 0.2: 13.2, 0.4: 15.0}}
# dz of the pairs that settle.
LIMITS = {("M1", -0.4): 2.0, ("M1", -0.2): 1.3, ("M1", 0.0): 1.2, ("M1", 0.2): 1.5,
          ("M1", 0.4): 2.6, ("M2", -0.4): 4.4, ("M2", -0.2): 1.1, ("M3", -0.2): 1.4,
          ("B2", -0.4): 3.0, ("B2", -0.2): 0.9, ("B3", -0.2): 0.95, ("B3", 0.0): 1.05,
          ("B4", -0.2): 0.85}
# Of the damped M2 pairs by x_lag: limit, amplitude, damping rate, period.
DAMPED = {0.0: (1.06, 0.9, 0.036, 10.0), -0.05: (1.05, 0.6, 0.037, 9.8),
          -0.1: (1.04, 0.3, 0.041, 9.5), -0.15: (1.03, 0.2, 0.06, 9.0)}
BOUNDED, SWING, BEAT = 3.0, 0.5, 8.0  # of B1: middle and half range of dz, and its period
SINGLES = {"sphere-La10": 0.0, "sphere-La100": 0.3, "rigid": 0.41, "biconcave-La100": 0.29}
CELL_X, CELL_SWING, HALF_TURN = 0.18, 0.02, 5.0  # of the cell that tumbles
RADIUS, LEAN, LEANS_FROM = 0.48, math.radians(30), 50.0  # of the disc that begins to wobble
GROWTH = 0.02  # rate at which strain piles up
DIAGONAL, RECTANGULAR = 0.25, (1.45, 0.55, 0.04, 8.0)

SPHERE, TRIANGLES = support.sphere(2)
DISC = np.array([RADIUS, RADIUS, 0.15])


def swing(t, limit, amplitude, damping, period):
    """dz that starts low and swings about its limit."""
    return limit - amplitude * np.exp(-damping * t) * np.cos(2 * np.pi * t / period)


def turned(t):
    """The rotation of the disc at a time: about y, and from LEANS_FROM on about an axis that leans
    out of it by LEAN; its marker goes round from x towards -z."""
    angle = np.pi * t / HALF_TURN
    c, s = np.cos(angle), np.sin(angle)
    about = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    lean = LEAN if t >= LEANS_FROM else 0.0
    c, s = np.cos(lean), np.sin(lean)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ about


def disc_columns(body, t):
    """The columns of direction of the disc that turns()."""
    rotations = np.array([turned(time) for time in t])
    second = rotations * DISC**2 @ rotations.transpose(0, 2, 1)
    omega = np.where(t < LEANS_FROM, 1, np.cos(LEAN)) * np.pi / HALF_TURN
    return {f"{body}_omega_y": omega, f"{body}_inclination": ductile.inclination(second),
            f"{body}_phase": ductile.phase(rotations[:, :, 0], np.zeros(3)),
            f"{body}_tilt": ductile.tilt(second)}


def body_columns(body, t, x, y=0.0, z=0.0, energy=0.0018):
    one = np.ones_like(t)
    return {f"{body}_x": x * one, f"{body}_y": y * one, f"{body}_z": z + 4 * t,
            f"{body}_vx": 0 * one, f"{body}_vy": 0 * one, f"{body}_vz": 4 * one,
            f"{body}_strain_energy": energy * one}


def own_parameters(body, kind, start, **others):
    """The keys of a body of a kind such as "sphere-La10"."""
    keys = {"kind": "rigid" if kind == "rigid" else "capsule", "shape": kind.split("-")[0],
            "radius": 0.4, "x": start, "y": 0.0, "edge": 1.2} | others
    if kind == "rigid":
        keys["shape"] = "sphere"
    else:
        keys["laplace"] = float(kind.split("La")[1])
    return {f"body.{body}.{key}": value for key, value in keys.items()}


class Synthetic:
    """A study that is written case by case."""

    def __init__(self, directory):
        self.directory = Path(directory)
        self.cases = {}

    def add(self, campaign, name, columns, parameters, frames=None, **summary):
        """A case of which the columns are given; `frames`, {body: (times, vertices_at)}."""
        place = self.directory / campaign / "cases" / name
        units = {column: "k_s*a^2" for column in columns if column.endswith("_energy")}
        support.write_trajectory(place, columns, units)
        nodes = int(name.split("clean-" if "clean-" in name else "paper-")[1].split("_")[0])
        parameters = {"channel.nodes": nodes, "channel.reynolds": 10.0,
                      "channel.symmetry": "none"} | parameters
        (place / "summary.json").write_text(json.dumps(
            {"status": "time limit", "parameters": parameters} | summary))
        if frames:
            self.write_frames(place / "run.h5", frames)
        self.list(campaign, name)

    def list(self, campaign, name):
        self.cases.setdefault(campaign, []).append(name)
        (self.directory / campaign).mkdir(parents=True, exist_ok=True)
        text = "case\n" + "".join(f"{name}\n" for name in self.cases[campaign])
        (self.directory / campaign / "campaign.csv").write_text(text)

    @staticmethod
    def write_frames(file, frames):
        with h5py.File(file, "w") as out:
            for body, (times, vertices_at) in frames.items():
                out[f"bodies/{body}/triangles"] = TRIANGLES
                for n, time in enumerate(times):
                    frame = out.require_group(f"frames/{n:06}")
                    frame.attrs["time"] = time
                    frame[f"{body}/position"] = vertices_at(time)
                    frame[body].attrs["z_offset"] = 12.0 * (n // 10)

    def pair(self, pair, x_lag, method, nodes=24, campaign=None, **changed):
        """A pair that follows the laws, and what the program would call it."""
        soft, stiff, cell = "sphere-La10", "sphere-La100", "biconcave-La"
        kinds = {"M1": (soft, soft), "M2": (stiff, stiff), "M3": ("rigid", "rigid"),
                 "B1": (soft, cell + "10"), "B2": (stiff, cell + "100"), "B3": (soft, stiff),
                 "B4": (stiff, soft)}[pair]
        t, dz, verdict = self.law(pair, x_lag)
        growing = GROWTH if method == "paper" else 0.0
        energy = 0.002 * np.exp(growing * t)
        lead = body_columns("lead", t, 0.25 + 0.05 * np.exp(-t / 10), z=dz, energy=energy)
        lag = body_columns("lag", t, 0.3 * np.tanh(t / 10) * np.sign(x_lag or -1)
                           + x_lag * np.exp(-t / 10), energy=energy)
        frames = None
        if pair == "M1":
            for body, own, start in (("lead", lead, 0.2), ("lag", lag, x_lag)):
                time = PAIR_TIMES[body].get(x_lag, 10.0)
                own[f"{body}_x"] = start * np.exp(-t / time)
        if pair == "B1":
            lag |= disc_columns("lag", t)
            lag["lag_y"] = 0.002 * np.exp(0.03 * t)
            lag["lag_x"] = 0.1 + 0.1 * np.exp(-t / 20)
            if x_lag == 0.2:
                def vertices(time):
                    place = [np.interp(time, t, lag["lag_x"]), np.interp(time, t, lag["lag_y"]),
                             4 * time - 12.0 * (int(round(4 * time)) // 10)]
                    return (SPHERE * DISC) @ turned(time).T + place
                frames = {"lag": (t[::1], vertices)}
        columns = {"t": t} | lead | lag | {"dz": dz}
        if pair == "M3":
            columns = {name: own for name, own in columns.items() if "strain" not in name}
        parameters = own_parameters("lead", kinds[0], 0.2, mobility=self.mobility(method)) \
            | own_parameters("lag", kinds[1], x_lag, mobility=self.mobility(method)) \
            | {key.replace("__", "."): value for key, value in changed.items()}
        self.add(campaign or pair, f"{method}-{nodes}_lag-x_{x_lag:g}", columns, parameters,
                 frames, verdict=verdict, verdict_reason="as the law has it", dz_W=dz[-1])

    @staticmethod
    def mobility(method):
        return 0.001 if method == "clean" else 0.0

    @staticmethod
    def law(pair, x_lag):
        """t, dz and verdict."""
        if pair == "M2" and x_lag in DAMPED:
            return T, swing(T, *DAMPED[x_lag]), "damped"
        if pair == "B1":
            return T, BOUNDED + SWING * np.sin(2 * np.pi * T / BEAT), "bounded"
        if (pair, x_lag) in LIMITS:
            limit = LIMITS[pair, x_lag]
            return T, limit + (1 - limit) * np.exp(-T / 8), "stable"
        if pair == "B4":
            return T, 1 + 0.0225 * T, "unstable"
        t = T[T <= 30]
        return t, 1 + 0.3 * t, "unstable"

    def single(self, kind, start, method, nodes=24, campaign=None, x=None, energy=0.0018, **others):
        """A single body that goes to the place of its kind, or along x."""
        if x is None:
            limit, time = SINGLES[kind], SINGLE_TIME
            x = limit + (start - limit) * np.exp(-T / time)
        name = {"sphere": "spheres", "rigid": "rigid", "biconcave": "cells"}[kind.split("-")[0]]
        columns = {"t": T} | body_columns("particle", T, x, energy=energy)
        columns |= others.pop("columns", {})
        if kind == "rigid":
            del columns["particle_strain_energy"]
        radius = others.pop("radius", 0.4)
        parameters = own_parameters("particle", kind, start, mobility=self.mobility(method),
                                    radius=radius)
        suffix = "" if campaign else f"_x_{start:g}"
        self.add(campaign or name, f"{kind}_{method}-{nodes}{suffix}", columns,
                 parameters | others.pop("parameters", {}), others.pop("frames", None), **others)


def write_whole(directory):
    """A study in which everything has been computed."""
    study = Synthetic(directory)
    for method in METHODS:
        for pair, x_lag in itertools.product(PAIRS, X_LAGS):
            if method == "clean" or pair != "M3":
                study.pair(pair, x_lag, method)
        for x_lag in (-0.05, -0.1, -0.15):
            study.pair("M2", x_lag, method, campaign="damped")
        strained = 0.002 * np.exp((GROWTH if method == "paper" else 0) * T)
        for start in (0.2, 0.4):
            ball = {"particle": (T[[0, -1]], lambda time: 0.4 * SPHERE + [0.3, 0, 4 * time])}
            study.single("sphere-La100", start, method, energy=strained, frames=ball)
            # By the paper's method the soft sphere wanders about the centre.
            wander = start * np.exp(-T / 10) + 0.008 * np.sin(T / 3) if method == "paper" else None
            study.single("sphere-La10", start, method, x=wander, frames=ball)
            study.single("biconcave-La100", start, method)
            x = CELL_X + CELL_SWING * np.cos(2 * np.pi * T / HALF_TURN) \
                + (start - CELL_X - CELL_SWING) * np.exp(-T / 10)
            disc = {"particle": (T[:81], lambda time: (SPHERE * DISC) @ turned(time).T
                                 + [0.2, 0, 4 * time - 12.0 * (int(round(4 * time)) // 10)])}
            study.single("biconcave-La10", start, method, x=x, energy=0.05 * np.exp(
                (GROWTH if method == "paper" else 0) * T), frames=disc,
                columns=disc_columns("particle", T) | {"particle_y": 0.001 * np.exp(0.02 * T)})
        outward = 0.055 * np.exp(T / 60) if method == "clean" else 0.055 * np.exp(-T / 30)
        study.single("sphere-La100", 0.055, method, campaign="released", x=outward,
                     energy=strained)
        along = DIAGONAL + (0.2 - DIAGONAL) * np.exp(-T / 8)
        egg = {"particle": (T[[0, -1]], lambda time: SPHERE * [0.18, 0.18, 0.24]
                            + [DIAGONAL, DIAGONAL, 4 * time])}
        study.single("sphere-La10", 0.2, method, 60, "diagonal", along, radius=0.2, frames=egg,
                     columns={"particle_y": along}, parameters={"channel.reynolds": 100.0})
    for start in (0.2, 0.4):
        study.single("rigid", start, "clean")
    dz = swing(T, *RECTANGULAR)
    study.add("rectangular", "clean-24",
              {"t": T} | body_columns("lead", T, 0.24) | body_columns("lag", T, -0.2) | {"dz": dz},
              own_parameters("lead", "rigid", 0.24) | own_parameters("lag", "rigid", -0.2),
              verdict="damped")
    return study


class Whole(unittest.TestCase):
    """Tests on the whole study, which is written once."""

    @classmethod
    def setUpClass(cls):
        own = tempfile.TemporaryDirectory()
        cls.addClassCleanup(own.cleanup)
        write_whole(own.name)
        cls.study = Study(own.name)

    def within(self, quantity, true, most=None):
        """A quantity is known, and right within twice its error, and within `most`."""
        self.assertTrue(quantity.known, quantity.reason)
        apart = abs(quantity.value.value - true)
        self.assertLessEqual(apart, max(quantity.value.error95, 1e-9 * abs(true)), str(quantity))
        if most is not None:
            self.assertLessEqual(apart, most, str(quantity))
        self.assertTrue(quantity.how)
        self.assertTrue(quantity.case)


class Numbers(Whole):
    def test_classes_and_the_papers(self):
        self.assertEqual({len(row) for row in quantities.PAPER_CLASSES.values()}, {5})
        self.assertEqual(quantities.paper_class("M2", 0.0), "damped")
        self.assertEqual(quantities.paper_class("B3", 0.0), "stable")
        self.assertEqual(quantities.paper_class("B4", 0.4), "unstable")
        found = quantities.classes(self.study, "clean")
        self.assertEqual(len(found), 35)
        self.assertTrue(all(own.agrees for own in found.values()))
        self.assertEqual(found["M2", 0.0].case, "M2/clean-24_lag-x_0")
        for verdict, paper, agrees in (("damped", "stable", True), ("stable", "damped", False),
                                       ("stable", "bounded", True), ("unstable", "bounded", False),
                                       ("undecided", "stable", None), (None, "stable", None)):
            self.assertIs(quantities.Class(verdict, "", paper).agrees, agrees)
        self.assertIs(quantities.Class("bounded", "", "stable", pair="B2").agrees, True)
        self.assertIs(quantities.Class("bounded", "", "stable", pair="B3").agrees, False)
        by_the_paper = quantities.classes(self.study, "paper")
        self.assertEqual(by_the_paper["M3", 0.2], found["M3", 0.2])  # rigid: of both methods

    def test_migration_ratios(self):
        found = quantities.migration_ratios(self.study, "clean")
        for body, times in PAIR_TIMES.items():
            for x_lag, time in times.items():
                own = found[x_lag][body]
                start = 0.2 if body == "lead" else abs(x_lag)
                self.within(own.pair, time * math.log(start / 1e-3), 0.01)
                self.within(own.single, SINGLE_TIME * math.log(start / 1e-3), 0.01)
                self.within(own.ratio, time / SINGLE_TIME, 1e-3)
                self.assertEqual(own.extrapolated, time == 30.0)
        self.assertIn("starts at the centre", found[0.0]["lag"].ratio.reason)
        wandering = quantities.migration_ratios(self.study, "paper")[0.2]["lead"]
        self.assertIsNone(wandering.ratio.value)
        self.assertIn("0 W", wandering.single.reason)
        self.assertTrue(math.isnan(float(wandering.ratio)))
        self.assertIn("none: ", str(wandering.ratio))

    def test_damped_oscillations(self):
        found = quantities.damped_oscillations(self.study, "clean")
        self.assertEqual(sorted(found), sorted(DAMPED))
        for x_lag, own in found.items():
            limit, amplitude, damping, period = DAMPED[x_lag]
            self.within(own.damping, damping, 1e-4)
            self.within(own.period, period, 1e-2)
            self.within(own.equilibrium, limit, 2e-3)
            top = -optimize.minimize_scalar(lambda t: -swing(t, *DAMPED[x_lag]), method="bounded",
                                            bounds=(0.3 * period, 0.7 * period)).fun
            self.within(own.maximum, top, 1e-3)
            self.assertEqual(own.fit.damping.value, own.damping.value.value)

    def test_a_pair_that_does_not_oscillate_has_no_damping(self):
        own = quantities.damped_oscillation(self.study.pair("M2", -0.2, "clean"))
        self.assertFalse(own.damping.known)
        self.assertIn("turns 0 times", own.damping.reason)
        self.within(own.equilibrium, LIMITS["M2", -0.2], 1e-3)
        growing = quantities.damped_oscillation(self.study.pair("M2", 0.2, "clean"))
        self.assertIn("still grows", growing.maximum.reason)
        self.assertFalse(growing.equilibrium.known)

    def test_equilibrium_distances(self):
        found = quantities.equilibrium_distances(self.study, "clean")
        for (pair, x_lag), own in found.items():
            if (pair, x_lag) in LIMITS:
                self.within(own, LIMITS[pair, x_lag], 1e-3)
                self.assertIsNone(own.swing)
            elif (pair, x_lag) == ("M2", 0.0):
                self.within(own, DAMPED[0.0][0], 2e-3)
            elif pair == "B1":
                self.within(own, BOUNDED, 5e-3)
                self.assertAlmostEqual(own.swing, SWING, delta=0.01)
            else:
                self.assertFalse(own.known)
                self.assertIn("unstable", own.reason)
        ratio = quantities.quotient(found["M1", 0.4], found["M1", -0.4])
        self.within(ratio, 1.3, 1e-3)
        self.assertFalse(quantities.quotient(found["M1", 0.4], found["M2", 0.4]).known)

    def test_single_equilibria(self):
        for method in METHODS:
            found = quantities.single_equilibria(self.study, method)
            for name, start in itertools.product(quantities.SINGLES, (0.2, 0.4)):
                own = found[name, start]
                if name == "biconcave-La10":
                    self.within(own, CELL_X, 3e-3)
                    self.assertAlmostEqual(own.swing, CELL_SWING, delta=2e-3)
                elif (name, method) != ("sphere-La10", "paper"):
                    self.within(own, SINGLES[name], 1e-3)

    def test_benchmarks(self):
        self.within(quantities.diagonal_equilibrium(self.study, "clean"), DIAGONAL * math.sqrt(2),
                    1e-3)
        self.within(quantities.rectangular_equilibrium(self.study), RECTANGULAR[0] / 0.4, 5e-3)

    def test_when_a_slow_pair_would_part(self):
        def of(pair, x_lag):
            return quantities.parting_time(self.study.pair(pair, x_lag, "clean"))
        self.within(of("B4", 0.2), 400, 1e-3)
        self.within(of("M2", 0.4), 30, 0.25)
        self.assertIn("the pair is stable", of("M1", 0.0).reason)

    def test_paths_about_the_centre_of_mass(self):
        path = quantities.centre_of_mass_path(self.study.pair("M2", 0.0, "clean"))
        np.testing.assert_allclose(path["lead"], -path["lag"], atol=1e-12)
        np.testing.assert_allclose(2 * path["lead"][:, 0], swing(T, *DAMPED[0.0]), atol=1e-9)
        with self.assertRaisesRegex(ductile.DuctileError, "not the same mass"):
            quantities.centre_of_mass_path(self.study.pair("B1", 0.0, "clean"))


class Turning(Whole):
    def test_a_markers_path(self):
        path = quantities.marker_path(self.study.pair("B1", 0.2, "clean"))
        np.testing.assert_allclose(np.linalg.norm(path.relative, axis=1), RADIUS, atol=1e-9)
        np.testing.assert_allclose(path.relative[0], [RADIUS, 0, 0], atol=0.02)
        np.testing.assert_allclose(path.centre[:, 2], 4 * path.t, atol=1e-9)
        early, late = path.t < LEANS_FROM, path.t >= LEANS_FROM
        np.testing.assert_allclose(path.relative[early, 1], path.relative[0, 1], atol=1e-9)
        self.assertAlmostEqual(np.abs(path.relative[late, 1]).max(), RADIUS * math.sin(LEAN),
                               delta=0.005)
        np.testing.assert_array_equal(path.from_midplane, np.abs(path.marker[:, 1]))
        some = quantities.marker_path(self.study.pair("B1", 0.2, "clean"), frames=[0, 7])
        np.testing.assert_allclose(some.marker, path.marker[[0, 7]])

    def test_from_tumbling_to_wobbling(self):
        case = self.study.pair("B1", 0.2, "clean")
        kinds = quantities.rotation_kinds(case, parts=4)
        self.assertEqual([own.motion for own in kinds],
                         ["tumbling", "tumbling", "wobbling", "wobbling"])
        self.assertEqual((kinds[0].begin, kinds[-1].end), (0, 100))
        begins = quantities.wobbles_from(case)
        self.assertGreaterEqual(begins.value.value, LEANS_FROM)
        self.assertLess(begins.value.value, LEANS_FROM + HALF_TURN)
        steady = self.study.cases("cells", "clean", particle=0.4)
        self.assertEqual(len(steady), 2)

    def test_tumbles_one_by_one(self):
        case = quantities.single_case(self.study, "biconcave-La10", 0.2, "clean")
        found = quantities.tumbling_periods(case)
        self.assertGreater(len(found.durations), 8)
        for duration in found.durations[:8]:  # before it leans
            self.assertAlmostEqual(duration.value, HALF_TURN, delta=duration.error)
        np.testing.assert_allclose(found.x[3:8], CELL_X, atol=2e-3)
        still = quantities.tumbling_periods(
            quantities.single_case(self.study, "sphere-La100", 0.2, "clean"))
        self.assertEqual(still.durations, [])
        self.assertTrue(still.reason)

    def test_out_of_the_plane(self):
        found = quantities.out_of_plane(self.study.pair("B1", 0.0, "clean"))
        self.assertTrue(found.leaves)
        self.within(found.largest, 0.002 * math.exp(3), 1e-9)
        flat = quantities.out_of_plane(self.study.pair("M2", 0.0, "clean"), "lag")
        self.assertFalse(flat.leaves)

    def test_strain_that_grows_and_strain_that_rests(self):
        for method, rate in (("clean", 0.0), ("paper", GROWTH)):
            case = quantities.released_case(self.study, method)
            found = quantities.strain_energy_history(case)["particle"]
            self.assertAlmostEqual(found.growth.value.value, rate, delta=1e-6)
            self.assertAlmostEqual(found.last.value.value,
                                   np.mean(0.002 * np.exp(rate * T[T >= 75])), delta=1e-9)
        rigid = quantities.single_case(self.study, "rigid", 0.2, "paper")
        self.assertEqual(quantities.strain_energy_history(rigid), {})


class Sections(unittest.TestCase):
    def test_a_sphere_is_cut_in_a_circle(self):
        vertices, triangles = support.sphere(4)
        for height in (0.0, 0.3, 0.77):
            loops = quantities.section(vertices, triangles, through=(0, height, 0))
            self.assertEqual(len(loops), 1)
            np.testing.assert_array_equal(loops[0][0], loops[0][-1])
            np.testing.assert_allclose(loops[0][:, 1], height, atol=1e-12)
            np.testing.assert_allclose(np.hypot(loops[0][:, 0], loops[0][:, 2]),
                                       math.sqrt(1 - height**2), atol=6e-3)
            around = np.linalg.norm(np.diff(loops[0], axis=0), axis=1).sum()
            self.assertAlmostEqual(around, 2 * np.pi * math.sqrt(1 - height**2), delta=0.02)
        self.assertEqual(quantities.section(vertices, triangles, through=(0, 1.1, 0)), [])

    def test_a_box_is_cut_exactly_and_two_bodies_twice(self):
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
        triangles = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
                              (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)])
        loops = quantities.section(corners, triangles, through=(0, 0.7, 0))
        self.assertEqual(len(loops), 1)
        self.assertAlmostEqual(np.linalg.norm(np.diff(loops[0], axis=0), axis=1).sum(), 8)
        both = np.concatenate([corners, corners * 0.5 + [5, 0, 0]])
        loops = quantities.section(both, np.concatenate([triangles, triangles + 8]),
                                   through=(0, 0.7, 0))
        self.assertEqual([round(np.linalg.norm(np.diff(loop, axis=0), axis=1).sum(), 9)
                          for loop in loops], [8, 4])
        # A face in the plane is no line, or is its outline.
        self.assertLessEqual(len(quantities.section(corners, triangles)), 1)

    def test_the_rim_of_a_disc(self):
        vertices = SPHERE * DISC
        rim = vertices[quantities.rim_vertex(vertices, np.zeros(3))]
        self.assertGreater(rim[0], 0.98 * RADIUS)
        self.assertLess(abs(rim[1]), 0.05)


class Levels(unittest.TestCase):
    def test_what_drifts_has_no_level(self):
        found = quantities.level(T, 1 + 0.02 * T)
        self.assertFalse(found.known)
        self.assertIn("no limit", found.reason)
        self.assertFalse(quantities.level(T[:5], T[:5]).known)

    def test_noise_is_in_the_error(self):
        rng = np.random.default_rng(3)
        found = []
        for _ in range(60):
            noise = 0.05 * support.correlated_noise(rng, len(T), 0.25, 2.0)
            found.append(quantities.level(T, 1.3 - 0.3 * np.exp(-T / 8) + noise))
        known = [own.value for own in found if own.known]
        self.assertGreater(len(known), 50)  # what seems to drift, by chance, has none
        within = sum(abs(value.value - 1.3) <= value.error95 for value in known)
        self.assertGreater(within, 0.95 * len(known) - 3.5 * math.sqrt(0.95 * 0.05 * len(known)))

    def test_turning_points(self):
        t = np.arange(0, 40, 0.1)
        y = np.cos(2 * np.pi * t / 10) * np.exp(-t / 10)
        found = quantities.extrema(t, y, 0.1)
        np.testing.assert_allclose(t[found], np.array([5, 10, 15, 20, 25]) - 0.252, atol=0.06)
        self.assertEqual(quantities.extrema(t, 0.01 * y, 0.1), [])
        self.assertEqual(quantities.extrema(t, t, 0.1), [])


# ------------------------------------------------------------------------------------------------
# Figures


def lines_of(axes, least=2):
    """The lines of data of an axes."""
    return [line for line in axes.lines if line.get_gid() != "stated"
            and line.get_transform() == axes.transData and len(line.get_xdata()) >= least]


def everything(figure):
    """All axes of a figure, with insets."""
    found = list(figure.axes)
    for axes in figure.axes:
        found += axes.child_axes
    return found


def texts_of(figure):
    return [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]


def drawn(study, which):
    figure = figures.draw(study, which)
    if figure is not None:
        FigureCanvasAgg(figure).draw()
    return figure


# What each figure's axes are called, with the paper's signs, and what is said of the paper.
LABELS = {
    "fig3": ({r"$t\;\,[W^2/\nu]$", r"$\Delta z\;\,[W]$"}, {"paper: stops at 10"}),
    "fig4": ({r"$x_\mathrm{lag}\;\,[W]$"}, set()),
    "fig5": ({r"$t\;\,[W^2/\nu]$", r"$x\;\,[W]$"},
             {"paper: centre", "paper: 0.3", "paper: near 0.4"}),
    "fig6": ({r"$t\;\,[W^2/\nu]$", r"$x_\mathrm{lead}\;\,[W]$", r"$x_\mathrm{lag}\;\,[W]$",
              r"$\Delta z\;\,[W]$"}, {"paper: 0", "paper: 0.3", "near 0.4", "paper: 1",
                                      "paper: stops at 10"}),
    "fig7": ({r"$x_\mathrm{lag}\;\,[W]$",
              r"$t^\mathrm{m}_\mathrm{pair}\,/\,t^\mathrm{m}_\mathrm{single}$"},
             {"paper: slower", "paper: faster"}),
    "fig8": ({r"$x_\mathrm{lag}\;\,[W]$", r"$\zeta\;\,[\nu/W^2]$",
              r"$\max(\Delta z),\ \Delta z_\mathrm{eq}\;\,[W]$", r"$x-x_\mathrm{cm}$",
              r"$z-z_\mathrm{cm}$"}, {"paper: close to 1, the start"}),
    "fig9": ({r"$t\;\,[W^2/\nu]$", r"$x\;\,[W]$", "$y$"}, {"paper: centre", "paper: 0.3"}),
    "fig10": ({r"$x\;\,[W]$"}, {"flow"}),
    "fig11": ({r"$t\;\,[W^2/\nu]$", r"$x_\mathrm{lead}\;\,[W]$", r"$x_\mathrm{lag}\;\,[W]$",
               r"$\Delta z\;\,[W]$", "$y$"}, {"paper: 0", "paper: 0.3", "paper: 1"}),
    "fig12": ({r"$x\;\,[W]$", r"$y\;\,[W]$", r"$z\;\,[W]$", r"$x-x_\mathrm{c}\;\,[W]$"}, set()),
    "fig13": ({r"$x_\mathrm{lag}\;\,[W]$", r"$\Delta z_\mathrm{eq}\;\,[W]$"},
              {"paper, M2 at 0 and −0.2, B4 at −0.2: close to 1"}),
    "fig14": ({r"$t\;\,[W^2/\nu]$", r"$\sqrt{x^2+y^2}\;\,[W]$"}, set()),
    "fig15": ({r"$t\;\,[W^2/\nu]$", r"$\Delta z/a$"}, {"paper: starts at 5", "ours: 3.62"}),
    "artefact": ({r"$t\;\,[W^2/\nu]$", r"$E_\mathrm{s}\;\,[k_\mathrm{s}a^2]$", r"$x\;\,[W]$"},
                 {"paper: 0.3", "paper: 0"}),
}


class Figures(Whole):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.figures = {which: drawn(cls.study, which) for which in figures.FIGURES}

    def test_there_is_one_for_each_of_the_paper(self):
        self.assertEqual(list(figures.FIGURES),
                         [f"fig{n}" for n in range(3, 16)] + ["artefact"])
        with self.assertRaisesRegex(ductile.DuctileError, "'fig2' is no figure"):
            figures.draw(self.study, "fig2")

    def test_axes_are_the_papers_and_its_numbers_are_marked(self):
        for which, (labels, marks) in LABELS.items():
            figure = self.figures[which]
            self.assertIsNotNone(figure, which)
            found = {label for axes in everything(figure) for label in
                     (axes.get_xlabel(), axes.get_ylabel(),
                      *([axes.get_zlabel()] if hasattr(axes, "get_zlabel") else []))}
            self.assertLessEqual(labels, found, which)
            texts = "\n".join(text.get_text() for text in texts_of(figure))
            for mark in marks:
                self.assertIn(mark, texts, which)

    def test_widths_are_those_of_the_journals_columns(self):
        for which, figure in self.figures.items():
            self.assertLessEqual(figure.get_figwidth(), figures.TWO, which)
            self.assertLessEqual(figure.get_figheight(), 9.5, which)

    def test_panels(self):
        count = {which: len(figure.axes) for which, figure in self.figures.items()}
        self.assertEqual(count["fig6"], 15 + 1)  # rigid pairs once, and a note instead
        self.assertEqual(count["fig11"], 24)
        self.assertEqual(count["fig8"], 2)
        self.assertEqual(count["artefact"], 6)
        insets = [len(axes.child_axes) for axes in self.figures["fig6"].axes]
        self.assertEqual(sum(insets), 6)  # of M2, by both methods
        self.assertEqual(sum(len(axes.child_axes) for axes in self.figures["fig11"].axes), 2)
        for axes in self.figures["fig6"].axes[:9]:
            self.assertEqual(len(lines_of(axes, 3)), 5)

    def test_limits_hold_the_data(self):
        for which, figure in self.figures.items():
            for axes in figure.axes:
                if hasattr(axes, "get_zlim"):
                    continue
                (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
                for line in lines_of(axes, 1):
                    x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
                    kept = (x >= left) & (x <= right)
                    if which != "fig6":  # there later times are in an inset
                        self.assertTrue(kept.all(), which)
                    slack = 1e-9 * (high - low)
                    if axes.get_yscale() == "linear":
                        self.assertTrue(np.all((y[kept] >= low - slack)
                                               & (y[kept] <= high + slack)), which)

    def test_nothing_is_told_by_colour_alone(self):
        for which, figure in self.figures.items():
            for axes in everything(figure):
                if hasattr(axes, "get_zlim"):
                    continue
                styles = {}
                for line in lines_of(axes, 1):
                    dashes = str(line._unscaled_dash_pattern)
                    style = (line.get_linestyle() == "None" or dashes, str(line.get_marker()))
                    if len(line.get_xdata()) == 1 and line.get_marker() == "o" \
                            and which in ("fig5", "fig9"):
                        continue  # where a curve begins
                    styles.setdefault(style, set()).add(str(line.get_color()))
                for style, colours in styles.items():
                    if style[1] == "_":
                        continue  # caps of error bars
                    self.assertEqual(len(colours), 1, (which, style, colours))

    def test_texts_are_inside_and_do_not_cover_each_other(self):
        bad = []
        for which, figure in self.figures.items():
            width, height = figure.get_size_inches() * figure.dpi
            boxes, hidden = [], not_drawn(figure)
            for text in texts_of(figure):
                box = text.get_window_extent()
                if text in hidden or not box.width or not math.isfinite(box.width):
                    continue
                self.assertGreaterEqual(text.get_fontsize(), 5, which)
                if min(box.x0, box.y0) < -1 or box.x1 > width + 1 or box.y1 > height + 1:
                    bad.append((which, text.get_text()))
                boxes.append((box, text.get_text()))
            for (one, said), (other, also) in itertools.combinations(boxes, 2):
                across = min(one.x1, other.x1) - max(one.x0, other.x0)
                up = min(one.y1, other.y1) - max(one.y0, other.y0)
                if across > 2 and up > 0.3 * min(one.height, other.height):
                    bad.append((which, said, also))
        self.assertEqual(bad, [])

    def test_words_say_what_is_shown_with_its_numbers(self):
        for which, entry in figures.FIGURES.items():
            text = figures.describe(self.study, which)
            self.assertEqual(text["title"], entry.title)
            self.assertIn("nodes across the channel", text["caption"], which)
            self.assertGreater(len(text["alt"]), 60, which)
            for part in text.values():
                self.assertNotIn("\n", part)
                self.assertNotIn("nan", part)
                self.assertNotIn("None", part)
        said = {which: figures.describe(self.study, which) for which in figures.FIGURES}
        self.assertIn("35 of 35 pairs are of the paper's class", said["fig4"]["alt"])
        self.assertIn("−0.2: 0.900", said["fig7"]["alt"])
        self.assertIn("ζ 0.036", said["fig8"]["alt"])
        self.assertIn("M1 2.00", said["fig13"]["alt"])
        self.assertIn("wobbling", said["fig12"]["alt"])
        self.assertIn("0.3536", said["fig14"]["alt"])
        self.assertIn("mobility 0.001", said["fig6"]["caption"])
        self.assertIn("60 nodes", said["fig14"]["caption"])
        self.assertIn("No time could be told for", said["fig7"]["caption"])


def not_drawn(figure):
    """Texts that have a place and are not drawn: labels of ticks beyond an axis' limits; and what
    the projection of axes in space places when it draws."""
    hidden = set()
    for axes in everything(figure):
        if hasattr(axes, "get_zlim"):
            hidden |= set(axes.findobj(Text))
            continue
        for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            low, high = sorted(limits)
            slack = 1e-9 * (high - low)
            for tick in axis.majorTicks + axis.minorTicks:
                if not axes.axison or not low - slack <= tick.get_loc() <= high + slack:
                    hidden |= {tick.label1, tick.label2}
    return hidden


class Partial(unittest.TestCase):
    def setUp(self):
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        self.writer = Synthetic(own.name)

    def study(self):
        return Study(self.writer.directory)

    def test_of_nothing_nothing_is_drawn(self):
        self.writer.list("M1", "clean-24_lag-x_0")  # which has not begun
        study = self.study()
        for which in figures.FIGURES:
            self.assertIsNone(figures.draw(study, which), which)
            self.assertIsNone(figures.describe(study, which), which)
        self.assertIn("not been computed",
                      quantities.diagonal_equilibrium(study, "clean").reason)
        self.assertEqual(quantities.damped_oscillations(study, "clean"), {})

    def test_what_is_there_is_drawn(self):
        self.writer.pair("M2", 0.0, "clean")
        self.writer.pair("M3", 0.2, "clean")
        self.writer.pair("B1", -0.2, "paper")
        self.writer.single("sphere-La100", 0.2, "clean")
        study = self.study()
        figures_there = {which for which in figures.FIGURES if drawn(study, which)}
        self.assertEqual(figures_there, {"fig3", "fig4", "fig5", "fig6", "fig8", "fig11", "fig13",
                                         "artefact"})
        for which in figures_there:
            self.assertTrue(figures.describe(study, which)["alt"], which)
        self.assertIn("not computed", "".join(
            text.get_text() for text in texts_of(drawn(study, "fig6"))))
        self.assertIn("No pair that was computed is stable",
                      figures.describe(study, "fig3")["caption"])

    def test_rigid_bodies_alone(self):
        self.writer.single("rigid", 0.2, "clean")
        self.writer.pair("M3", -0.2, "clean")
        study = self.study()
        self.assertEqual(len(drawn(study, "fig5").axes), 1)
        self.assertEqual(len(drawn(study, "fig6").axes), 9)
        self.assertIn("rigid bodies alone", figures.describe(study, "fig6")["caption"])

    def test_runs_that_go_on_have_no_class_and_are_drawn(self):
        self.writer.pair("M1", -0.2, "clean")
        (self.writer.directory / "M1/cases/clean-24_lag-x_-0.2/summary.json").unlink()
        place = self.writer.directory / "M1/cases/clean-24_lag-x_-0.2/scenario.toml"
        place.write_text('name = "M1"\n[channel]\nnodes = 24\nsymmetry = "y"\n'
                         '[[body]]\nname = "lead"\nkind = "capsule"\nlaplace = 10.0\nx = 0.2\n'
                         'mobility = 0.001\n'
                         '[[body]]\nname = "lag"\nkind = "capsule"\nlaplace = 10.0\nx = -0.2\n')
        study = self.study()
        own = quantities.classes(study, "clean")["M1", -0.2]
        self.assertIsNone(own.verdict)
        self.assertEqual(own.reason, "the run has not ended")
        self.assertIsNone(own.agrees)
        self.assertFalse(quantities.equilibrium_distances(study, "clean")["M1", -0.2].known)
        self.assertIn("still running", figures.describe(study, "fig6")["alt"])

    def test_half_a_channel_shows_nothing_leaving_the_plane(self):
        self.writer.single("biconcave-La100", 0.2, "clean", parameters={"channel.symmetry": "y"})
        case = quantities.single_case(self.study(), "biconcave-La100", 0.2, "clean")
        found = quantities.out_of_plane(case)
        self.assertIsNone(found.leaves)
        self.assertIn("half of the channel", found.last.reason)

    def test_it_is_said_where_nothing_can_leave_the_plane(self):
        self.writer.pair("B1", 0.2, "clean", channel__symmetry="y")
        self.writer.pair("B1", 0.2, "paper")
        study = self.study()
        said = figures.describe(study, "fig12")["caption"]
        self.assertIn("Half of the channel was computed by the clean method: there the cell "
                      "cannot leave the plane", said)
        self.assertIn("half of the channel computed", "".join(
            text.get_text() for text in texts_of(drawn(study, "fig12"))))
        panels = drawn(study, "fig11").axes
        self.assertEqual([len(axes.child_axes) for axes in panels].count(1), 1)

    def test_the_coarsest_lattice_counts_unless_another_is_asked_for(self):
        for nodes, limit in ((48, 0.31), (24, 0.25), (36, 0.29)):
            self.writer.single("sphere-La100", 0.2, "clean", nodes,
                               x=limit + (0.2 - limit) * np.exp(-T / 12))
        study = self.study()
        for nodes, limit in ((None, 0.25), (36, 0.29), (48, 0.31)):
            found = quantities.single_equilibria(study, "clean", nodes)["sphere-La100", 0.2]
            self.assertAlmostEqual(found.value.value, limit, places=4)
        self.assertFalse(quantities.single_equilibria(study, "clean", 60)["sphere-La100",
                                                                          0.2].known)


if __name__ == "__main__":
    unittest.main()
