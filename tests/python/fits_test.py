#!/usr/bin/python3
"""Fits against series whose answer is known."""
import unittest

import support
import numpy as np

import ductile
from ductile.uncertainty import Uncertainty, correlated, whitened


class Noise(unittest.TestCase):
    def test_whitening_and_correlating_are_what_they_say(self):
        t = np.sort(np.random.default_rng(0).uniform(0, 10, 30))
        rho = np.exp(-np.diff(t) / 1.7)
        matrix = np.exp(-np.abs(t[:, None] - t) / 1.7)
        values = np.random.default_rng(1).normal(size=(30, 2))
        np.testing.assert_allclose(correlated(values, rho), matrix @ values, rtol=1e-10)
        white = whitened(values, rho)
        np.testing.assert_allclose(white.T @ white, values.T @ np.linalg.solve(matrix, values),
                                   rtol=1e-10)

    def test_the_error_of_a_mean_of_white_noise_is_the_textbooks(self):
        t = np.arange(400.0)
        y = np.random.default_rng(2).normal(size=400)
        known = Uncertainty(t, y - y.mean(), np.ones((400, 1)))
        self.assertAlmostEqual(known.value(0, [1]).error / (y.std(ddof=1) / 20), 1, delta=0.15)

    def test_a_value_prints_its_digits(self):
        self.assertEqual(str(ductile.Value(0.286123, 0.00123, 0.0025)), "0.2861 +- 0.0012")
        self.assertEqual(str(ductile.Value(1234.5, 56, 110)), "1234 +- 56")
        self.assertEqual(float(ductile.Value(2.0, 1, 2)), 2.0)


class Lines(unittest.TestCase):
    def test_a_line_is_found(self):
        t = np.linspace(3, 23, 101)
        fit = ductile.fit_line(t, 0.3 - 0.02 * (t - 13))
        self.assertAlmostEqual(fit.level.value, 0.3)
        self.assertAlmostEqual(fit.slope.value, -0.02)

    def test_errors_hold_for_correlated_noise(self):
        # 300 lines: of a probability p so many lie within three standard deviations of
        # sqrt(p(1 - p)/300): .027 for .68, .0126 for .95.
        rng = np.random.default_rng(11)
        inside = []
        t = np.arange(0, 60, 0.2)
        for n in range(300):
            noise = support.correlated_noise(rng, len(t), 0.2, [0, 0.6, 2][n % 3])
            slope = ductile.fit_line(t, 0.02 * t + noise).slope
            inside.append((abs(slope.value - 0.02) < slope.error,
                           abs(slope.value - 0.02) < slope.error95))
        one, two = np.mean(inside, axis=0)
        self.assertLess(abs(one - 0.6827), 0.081, (one, two))
        self.assertLess(abs(two - 0.95), 0.038, (one, two))


class Relaxations(unittest.TestCase):
    def test_an_exponential_without_noise_is_found_exactly(self):
        t = np.linspace(0, 60, 601)
        fit = ductile.fit_relaxation(t, 0.3 - 0.1 * np.exp(-t / 14))
        self.assertFalse(fit.rests)
        self.assertAlmostEqual(fit.equilibrium.value, 0.3, places=6)
        self.assertAlmostEqual(fit.time.value, 14, places=3)
        self.assertAlmostEqual(fit.amplitude.value, -0.1 * np.exp(-30 / 14), places=6)
        # A quarter of what is still to come is not believed.
        to_come = 0.1 * np.exp(-60 / 14)
        self.assertAlmostEqual(fit.equilibrium.error, to_come / 4, delta=0.02 * to_come)
        np.testing.assert_allclose(fit.curve(t[300:]), 0.3 - 0.1 * np.exp(-t[300:] / 14), atol=1e-6)

    def test_the_error_of_least_squares_holds_where_the_model_does(self):
        # White and correlated noise; two to four times the relaxation in the window. Bounds: three
        # standard deviations of 200 draws.
        rng = np.random.default_rng(5)
        inside = []
        for n in range(200):
            t = np.arange(0, 80, 0.25)
            time = 40 / rng.uniform(2, 4)
            noise = support.correlated_noise(rng, len(t), 0.25, [0, 0.5, 1.0][n % 3])
            y = 0.3 - 0.1 * np.exp(-(t - 40) / time) + 0.002 * noise
            fit = ductile.fit_relaxation(t, y)
            off = abs(fit.statistical.value - 0.3)
            inside.append((off < fit.statistical.error, off < fit.statistical.error95,
                           off < fit.equilibrium.error95))
        one, two, whole = np.mean(inside, axis=0)
        self.assertGreater(one, 0.6827 - 0.099)
        self.assertGreater(two, 0.95 - 0.046)
        self.assertGreaterEqual(whole, two)

    def test_the_whole_error_also_holds_where_the_approach_is_no_exponential(self):
        # A second exponential, of a third of the time and half the amplitude to twice it, of
        # either sign, or an approach as a power of time: what least squares alone would be wrong
        # about by many times its error.
        rng = np.random.default_rng(6)
        statistical, whole, two = [], [], []
        for n in range(120):
            t = np.arange(0, 60, 0.25)
            time = rng.uniform(6, 15)
            second = rng.uniform(0.5, 2) * rng.choice([-1, 1])
            if n % 3:
                y = 0.3 - 0.1 * (np.exp(-t / time) + second * np.exp(-3 * t / time))
            else:
                y = 0.3 - 0.1 / (1 + t / time)**rng.uniform(3, 5)
            fit = ductile.fit_relaxation(t, y)
            off = abs(fit.equilibrium.value - 0.3)
            statistical.append(off < fit.statistical.error)
            whole.append(off < fit.equilibrium.error)
            two.append(off < fit.equilibrium.error95)
        print(f"approaches that are no exponential: within the error {np.mean(whole):.2f}, within "
              f"error95 {np.mean(two):.2f}, of least squares alone {np.mean(statistical):.2f}")
        # What it is to hold for has no law of probability: two of three, and nine of ten.
        self.assertGreater(np.mean(whole), 0.6)
        self.assertGreater(np.mean(two), 0.9)
        self.assertLess(np.mean(statistical), 0.3)  # or the rest would not be needed

    def test_what_rests_rests(self):
        t = np.arange(0, 60, 0.2)
        noise = support.correlated_noise(np.random.default_rng(3), len(t), 0.2, 0.6)
        fit = ductile.fit_relaxation(t, 0.3 + 0.001 * noise)
        self.assertTrue(fit.rests)
        self.assertLess(abs(fit.equilibrium.value - 0.3), fit.equilibrium.error95)
        self.assertLess(fit.equilibrium.error, 0.001)

    def test_what_has_no_limit_is_refused(self):
        t = np.arange(0, 60, 0.2)
        noise = 1e-3 * np.random.default_rng(4).normal(size=len(t))
        for moving in (0.01 * t, 0.01 * t + 1e-4 * t**2, np.exp(t / 30)):
            with self.assertRaisesRegex(ductile.DuctileError, "approaches no limit"):
                ductile.fit_relaxation(t, moving + noise)
        with self.assertRaisesRegex(ductile.DuctileError, "too few"):
            ductile.fit_relaxation(t[:5], t[:5])
        with self.assertRaisesRegex(ductile.DuctileError, "not finite"):
            ductile.fit_relaxation(t, np.where(t > 40, np.nan, t))
        with self.assertRaisesRegex(ductile.DuctileError, "times of a series increase"):
            ductile.fit_relaxation(t[::-1], t)


class Migrations(unittest.TestCase):
    def test_of_an_exponential_it_is_known(self):
        t = np.arange(0, 100, 0.5)
        migration = ductile.migration_time(t, 0.2 * np.exp(-t / 13))
        self.assertAlmostEqual(migration.time.value, 13 * np.log(200), places=9)
        self.assertAlmostEqual(migration.first, 13 * np.log(200), places=9)
        self.assertEqual(migration.time.error, 0.25)
        self.assertFalse(migration.extrapolated)

    def test_a_body_that_crosses_the_centre_has_not_arrived(self):
        t = np.arange(5, 105, 0.05)
        x = 0.2 * np.exp(-(t - 5) / 13) * np.cos(0.3 * (t - 5))
        migration = ductile.migration_time(t, x)
        self.assertAlmostEqual(migration.first, 0.5 * np.pi / 0.3, delta=0.1)
        after = np.abs(x[t - 5 > migration.time.value])
        self.assertLess(after.max(), 1e-3)
        self.assertGreater(np.abs(x[t - 5 > migration.time.value - 0.1]).max(), 1e-3)

    def test_it_is_extrapolated_only_where_asked(self):
        t = np.arange(0, 50, 0.1)
        rng = np.random.default_rng(8)
        x = 0.2 * np.exp(-t / 13) + 1e-5 * rng.normal(size=len(t))
        with self.assertRaisesRegex(ductile.DuctileError, "does not come to within 0.001 W of 0 W"):
            ductile.migration_time(t, x)
        migration = ductile.migration_time(t, x, extrapolate=True)
        self.assertTrue(migration.extrapolated)
        self.assertLess(abs(migration.time.value - 13 * np.log(200)), migration.time.error95)
        self.assertLess(migration.time.error, 0.1)
        with self.assertRaisesRegex(ductile.DuctileError, "heads for"):
            ductile.migration_time(t, 0.1 + x, extrapolate=True)
        # One that swings about the axis, away from it at the end, is not on its way there.
        swinging = 0.0011 * (1.2 + np.cos(2 * np.pi * t / 45))
        with self.assertRaisesRegex(ductile.DuctileError, "does not approach 0 W"):
            ductile.migration_time(t, swinging, extrapolate=True)

    def test_a_body_that_is_there_has_none(self):
        with self.assertRaisesRegex(ductile.DuctileError, "from the beginning"):
            ductile.migration_time([0, 1, 2], [0, 1e-5, 0])


class Oscillations(unittest.TestCase):
    def test_without_noise_it_is_found_exactly(self):
        t = np.arange(2, 60, 0.1)
        since = t - 2
        y = (1.3 + 0.002 * (t - 31)
             + 0.8 * np.exp(-0.07 * since) * np.cos(2 * np.pi * since / 13 + 0.5))
        fit = ductile.fit_oscillation(t, y)
        middle = 0.5 * (t[0] + t[-1])
        for name, value in (("offset", 1.3 + 0.002 * (middle - 31)), ("drift", 0.002),
                            ("amplitude", 0.8), ("damping", 0.07), ("frequency", 1 / 13),
                            ("period", 13), ("phase", 0.5)):
            self.assertAlmostEqual(getattr(fit, name).value, value, places=6, msg=name)
        np.testing.assert_allclose(fit.curve(t), y, atol=1e-6)

    def test_a_growing_one_and_a_window(self):
        t = np.arange(0, 80, 0.2)
        y = np.where(t < 20, 5.0, 0.1 * np.exp(0.02 * t) * np.cos(2 * np.pi * t / 11))
        fit = ductile.fit_oscillation(t, y, start=20)
        self.assertAlmostEqual(fit.damping.value, -0.02, places=6)
        self.assertAlmostEqual(fit.amplitude.value, 0.1 * np.exp(0.4), places=6)

    def test_uneven_samples(self):
        rng = np.random.default_rng(1)
        t = np.sort(rng.uniform(0, 60, 400))
        fit = ductile.fit_oscillation(t, np.exp(-t / 30) * np.sin(2 * np.pi * t / 9))
        self.assertAlmostEqual(fit.period.value, 9, places=5)

    def test_what_is_no_oscillation_is_refused(self):
        t = np.arange(0, 60, 0.2)
        rng = np.random.default_rng(3)
        for y, reason in ((np.ones_like(t), "constant"),
                          (1 - np.exp(-t / 9), "."),
                          (np.cos(2 * np.pi * t / 150), "not one of them"),
                          (rng.normal(size=len(t)), "told from the noise"),
                          (support.correlated_noise(rng, len(t), 0.2, 1.0), "told from the noise")):
            with self.assertRaisesRegex(ductile.DuctileError, reason):
                ductile.fit_oscillation(t, y)


class Drawing(unittest.TestCase):
    def test_every_fit_draws_its_curve_over_the_data(self):
        from matplotlib.figure import Figure
        t = np.arange(0, 100, 0.5)
        decay = 0.2 * np.exp(-t / 13)
        fits = [ductile.fit_line(t, 0.1 * t), ductile.fit_relaxation(t, 0.1 + decay),
                ductile.fit_oscillation(t, decay * np.cos(t)), ductile.migration_time(t, decay)]
        for fit in fits:
            axes = Figure().subplots()
            fit.plot(axes)
            drawn = [line.get_xydata() for line in axes.lines]
            data = np.column_stack([fit.t, fit.y])
            self.assertTrue(any(len(d) >= len(data) and np.allclose(d[-len(data):], data)
                                for d in drawn), fit)
            self.assertGreaterEqual(len(drawn), 2)


if __name__ == "__main__":
    unittest.main()
