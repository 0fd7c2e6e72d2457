#!/usr/bin/python3
"""Angles and motions of bodies whose turning is known: ellipsoids that tumble, tank-tread, ..."""
import unittest

import support
import numpy as np

import ductile
from ductile.rotation import marker_of

SPHERE, TRIANGLES = support.sphere(3)


def turn_y(angle):
    """The rotation about y by an angle [rad], which turns z towards x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def turn_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def series_of(times, surface_at):
    """The angles of surface_at(t), vertices, by the package's functions, as angles() has them."""
    series = {name: [] for name in ("inclination", "phase", "tilt", "omega_y")}
    marker = None
    for t in times:
        vertices = surface_at(t)
        moments = ductile.second_moments(vertices, TRIANGLES)
        marker = marker_of(vertices, moments.centroid) if marker is None else marker
        h = 1e-4
        velocity = (surface_at(t + h) - surface_at(t - h)) / (2 * h)
        series["inclination"].append(ductile.inclination(moments.second))
        series["tilt"].append(ductile.tilt(moments.second))
        series["phase"].append(ductile.phase(vertices[marker], moments.centroid))
        series["omega_y"].append(ductile.surface_rotation(vertices, TRIANGLES, velocity)[1])
    return {"t": np.asarray(times), **{name: np.array(values) for name, values in series.items()}}


class Surfaces(unittest.TestCase):
    def test_moments_of_a_box_are_exact_wherever_it_is(self):
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
        triangles = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7),
                     (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
        turn = turn_y(0.4) @ turn_x(0.9)
        for centre in (np.zeros(3), np.array([0.3, -0.2, 5000.0])):
            moved = (corners - [0.5, 1, 1.5]) @ turn.T + centre
            moments = ductile.second_moments(moved, triangles)
            self.assertAlmostEqual(moments.volume, 6, places=9)
            np.testing.assert_allclose(moments.centroid, centre, atol=1e-9)
            own = turn @ np.diag([6 / 12, 6 * 4 / 12, 6 * 9 / 12]) @ turn.T
            np.testing.assert_allclose(moments.second, own, atol=1e-9)

    def test_moments_of_an_ellipsoid_converge_to_the_analytic_ones(self):
        axes = np.array([0.3, 0.4, 0.7])
        volume = 4 / 3 * np.pi * axes.prod()
        errors = []
        for frequency in (2, 3, 4):
            vertices, triangles = support.sphere(frequency)
            moments = ductile.second_moments(vertices * axes, triangles)
            errors.append([abs(moments.volume / volume - 1),
                           *np.abs(np.diag(moments.second) / (volume * axes**2 / 5) - 1)])
        ratios = np.array(errors[:-1]) / errors[1:]
        self.assertTrue(np.all(ratios > 3.7), ratios)  # second order in the mesh's spacing

    def test_a_surface_that_is_not_closed_or_inside_out_is_refused(self):
        with self.assertRaisesRegex(ductile.DuctileError, "encloses no volume"):
            ductile.second_moments(SPHERE, TRIANGLES[:, ::-1])

    def test_angles_are_those_of_the_definition(self):
        for degrees in (-80, -30, 0, 10, 45, 89):
            # Longest along z turned by the angle towards x, shortest along y turned out of it.
            vertices = SPHERE * [0.5, 0.3, 0.8] @ turn_y(np.radians(degrees)).T
            second = ductile.second_moments(vertices, TRIANGLES).second
            self.assertAlmostEqual(ductile.inclination(second), degrees, places=1)
            self.assertAlmostEqual(ductile.tilt(second), 90, places=1)
            tilted = SPHERE * [0.6, 0.8, 0.3] @ turn_x(np.radians(degrees)).T
            self.assertAlmostEqual(
                ductile.tilt(ductile.second_moments(tilted, TRIANGLES).second),
                abs(degrees), places=1)
        self.assertAlmostEqual(ductile.phase([1, 0, 0], [0, 0, 0]), 90)
        self.assertAlmostEqual(ductile.phase([0, 5, -1], [0, 0, 0]), 180)

    def test_the_rotation_of_a_rigid_body_is_its_own_whatever_its_mesh(self):
        omega = np.array([0.3, -0.7, 0.2])
        vertices = SPHERE * [0.5, 0.3, 0.8] + [0.2, 0, 40]
        velocity = np.cross(omega, vertices - [0.2, 0, 40]) + [0.1, 0, 4]
        np.testing.assert_allclose(
            ductile.surface_rotation(vertices, TRIANGLES, velocity), omega, atol=1e-10)
        # A pure strain has none.
        np.testing.assert_allclose(
            ductile.surface_rotation(SPHERE, TRIANGLES, SPHERE * [1, -1, 0]), 0, atol=2e-3)


class Series(unittest.TestCase):
    def test_a_phase_goes_on_through_its_ends(self):
        t = np.linspace(0, 20, 201)
        true = 20 - 100 * t
        wrapped = (true + 180) % 360 - 180
        np.testing.assert_allclose(ductile.unwrapped_phase(t, wrapped), true, atol=1e-9)
        half = (true + 90) % 180 - 90
        np.testing.assert_allclose(ductile.unwrapped_inclination(t, half), true, atol=1e-9)

    def test_omega_tells_turns_that_samples_alone_would_hide(self):
        t = np.linspace(0, 40, 41)
        rate = np.radians(300) * (1 + 0.2 * np.sin(0.5 * t))
        true = np.degrees(np.concatenate([[0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))]))
        wrapped = (true + 180) % 360 - 180
        np.testing.assert_allclose(ductile.unwrapped_phase(t, wrapped, rate), true, atol=1e-9)
        self.assertLess(np.abs(ductile.unwrapped_phase(t[:3], wrapped[:3])[-1]), 200)

    def test_steps_that_could_be_either_way_are_refused(self):
        with self.assertRaisesRegex(ductile.DuctileError, "too far to tell which way"):
            ductile.unwrapped_phase([0, 1, 2], [0, 170, -20])
        with self.assertRaisesRegex(ductile.DuctileError, "against what omega_y says"):
            ductile.unwrapped_inclination([0, 1, 2], [0, 80, 10], [0, 0, 0])


class Motions(unittest.TestCase):
    def test_a_jeffery_orbit_tumbles_at_its_rate(self):
        # An ellipsoid r times as long as wide in the plane of the flow u_z = gamma x, its third
        # axis along the vorticity: tan(phi) = tan(theta)/r, theta = -gamma r t/(r^2 + 1) (Jeffery, Proc.
        # R. Soc. A 102, 161, 1922).
        gamma, ratio = 5.0, 2.0
        rate = -gamma * ratio / (ratio**2 + 1)

        def surface(t):
            theta = rate * t
            phi = np.arctan2(np.sin(theta), ratio * np.cos(theta))
            return SPHERE * [0.25, 0.3, 0.5] @ turn_y(phi).T + [0.2, 0, 4 * t]
        times = np.arange(0, 16, 0.05)
        series = series_of(times, surface)
        theta = rate * times
        own = np.unwrap(np.arctan2(np.sin(theta), ratio * np.cos(theta)))
        np.testing.assert_allclose(
            ductile.unwrapped_inclination(times, series["inclination"], series["omega_y"]),
            np.degrees(own), atol=0.3)
        exact = -gamma * (ratio**2 * np.sin(own)**2 + np.cos(own)**2) / (ratio**2 + 1)
        np.testing.assert_allclose(series["omega_y"], exact, rtol=1e-3)
        found = ductile.classify(series, start=0)
        self.assertEqual(found.motion, "tumbling")
        self.assertLess(abs(found.shape_rate.value - rate), 2e-3 * abs(rate))
        self.assertLess(abs(found.marker_rate.value - rate), 2e-3 * abs(rate))
        self.assertLess(found.shape_rate.error95, 5e-3 * abs(rate))
        self.assertLess(found.wobble, 0.5)
        # So it is where samples are half a turn of the shape apart, with the help of omega_y.
        coarse = {name: values[::12] for name, values in series.items()}
        found = ductile.classify(coarse, start=0)
        self.assertEqual(found.motion, "tumbling")
        self.assertLess(abs(found.shape_rate.value - rate), 0.02 * abs(rate))

    def tank_treading(self, t, inclined, axes=(0.3, 0.35, 0.6)):
        """Every point of the surface goes round an ellipsoid that is as inclined(t) says."""
        points = SPHERE @ turn_y(-2.0 * t).T
        return points * axes @ turn_y(np.radians(inclined(t))).T + [0.1, 0, 3 * t]

    def test_a_tank_treading_ellipsoid_turns_its_surface_and_not_its_shape(self):
        times = np.arange(0, 30, 0.1)
        series = series_of(times, lambda t: self.tank_treading(t, lambda t: 20))
        found = ductile.classify(series)
        self.assertEqual(found.motion, "tank-treading")
        self.assertAlmostEqual(found.marker_rate.value, -2, delta=0.01)
        self.assertAlmostEqual(found.inclination, 20, delta=0.3)
        self.assertLess(found.swing, 0.5)
        self.assertLess(abs(found.shape_rate.value), 1e-3)

    def test_one_whose_inclination_swings_is_swinging(self):
        times = np.arange(0, 30, 0.1)
        found = ductile.classify(series_of(
            times, lambda t: self.tank_treading(t, lambda t: 15 + 12 * np.sin(4 * t))))
        self.assertEqual(found.motion, "swinging")
        self.assertAlmostEqual(found.swing, 12, delta=0.5)
        self.assertAlmostEqual(found.inclination, 15, delta=1)

    def test_a_disc_whose_axis_of_tumbling_varies_wobbles(self):
        def surface(t):
            turned = SPHERE * [0.5, 0.5, 0.2] @ turn_x(np.radians(15 + 15 * np.sin(0.5 * t))).T
            return turned @ turn_y(-1.5 * t).T
        found = ductile.classify(series_of(np.arange(0, 30, 0.1), surface))
        self.assertEqual(found.motion, "wobbling")
        self.assertAlmostEqual(found.wobble, 30, delta=1)
        self.assertAlmostEqual(found.shape_rate.value, -1.5, delta=0.02)

    def test_a_disc_that_rolls_has_no_inclination(self):
        found = ductile.classify(series_of(
            np.arange(0, 30, 0.1), lambda t: SPHERE * [0.5, 0.2, 0.5] @ turn_y(-1.5 * t).T))
        self.assertEqual(found.motion, "rolling")
        self.assertIsNone(found.shape_rate)
        self.assertAlmostEqual(found.marker_rate.value, -1.5, delta=0.01)

    def test_what_does_not_turn_rests(self):
        found = ductile.classify(series_of(
            np.arange(0, 30, 0.1), lambda t: SPHERE * [0.3, 0.4, 0.5] @ turn_y(0.3).T))
        self.assertEqual(found.motion, "resting")

    def test_a_body_without_the_samples_for_it_is_refused(self):
        with self.assertRaisesRegex(ductile.DuctileError, "too few"):
            ductile.classify({name: np.zeros(8) for name in ("t", "phase", "tilt", "inclination")})

    def test_it_draws_its_angles(self):
        from matplotlib.figure import Figure
        times = np.arange(0, 30, 0.1)
        found = ductile.classify(series_of(times, lambda t: self.tank_treading(t, lambda t: 20)))
        axes = Figure().subplots()
        found.plot(axes)
        labels = [text.get_text() for text in axes.get_legend().get_texts()]
        self.assertEqual(sorted(labels), ["inclination", "phase", "tilt"])


if __name__ == "__main__":
    unittest.main()
