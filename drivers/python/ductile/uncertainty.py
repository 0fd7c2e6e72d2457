"""Values with their errors, from least squares whose residuals may be correlated in time.

Residuals of a simulation's series are seldom white: what a model leaves over is smooth. An error
that takes n samples for n independent ones would be too small, by a factor of ten and more. Here
the residuals are taken for a stationary process whose correlation falls off as exp(-|t - t'|/tau)
(the Ornstein-Uhlenbeck process, AR(1) where samples are evenly spaced), tau being known from them
only so well. The estimate is that of ordinary least squares, b, whose covariance is

    C(tau) = sigma^2 (J'J)^-1 J' V J (J'J)^-1,   V_ij = exp(-|t_i - t_j|/tau),

with the model's derivatives J. The likelihood of tau is the restricted one (Patterson & Thompson,
Biometrika 58, 545, 1971; of Harville's form), which is that of the residuals alone, so that the
fit's having followed some of the noise makes tau and sigma no smaller. Instead of the likeliest
tau all are used, by their likelihood, with a prior flat in log(tau): intervals are those of the
mixture of the t distributions that they give.
"""
from dataclasses import dataclass

import numpy as np
from scipy import linalg, optimize, stats

# Levels of the errors that are stated.
ONE_SIGMA = 0.6827
TWO_SIGMA = 0.95
_TAUS = 48  # correlation times that are tried


@dataclass(frozen=True)
class Value:
    """A number with its uncertainty.

    The true value lies within value +- error with a probability of 68.27%, and within
    value +- error95 with one of 95%.
    """
    value: float
    error: float
    error95: float

    def __float__(self):
        return float(self.value)

    def __str__(self):
        if not np.isfinite(self.error) or self.error <= 0:
            return f"{self.value:.6g} +- {self.error:.2g}"
        digits = 1 - int(np.floor(np.log10(self.error)))
        if abs(digits) > 12:
            return f"{self.value:.6g} +- {self.error:.2g}"
        shown = max(digits, 0)
        return f"{round(self.value, digits):.{shown}f} +- {round(self.error, digits):.{shown}f}"


def whitened(values, correlation):
    """V^(-1/2) times `values`, whose rows are samples; `correlation` is that of neighbours."""
    scale = np.sqrt(1 - correlation**2)
    rest = (values[1:].T - correlation * values[:-1].T) / scale
    return np.concatenate([values[:1], rest.T])


def correlated(values, correlation):
    """V times `values`: V^-1 is tridiagonal."""
    squares = correlation**2
    band = np.zeros((2, len(values)))
    band[0, 1:] = -correlation / (1 - squares)
    band[1] = 1
    band[1, 1:] += squares / (1 - squares)
    band[1, :-1] += squares / (1 - squares)
    return linalg.solveh_banded(band, values)


class Uncertainty:
    """The uncertainty of the parameters of a least-squares fit."""

    def __init__(self, times, residuals, jacobian):
        """`times`, increasing, and `residuals` of n samples; `jacobian` (n, p), at the solution."""
        # Columns of one size: parameters have units.
        size = np.linalg.norm(jacobian, axis=0)
        jacobian = jacobian / size
        count, parameters = jacobian.shape
        self.degrees = count - parameters
        self.noise = float(np.sqrt(residuals @ residuals / self.degrees))
        gaps = np.diff(times)
        # Correlation times beyond a quarter of the series are drifts, which models have.
        taus = np.geomspace(0.15 * np.median(gaps), 0.25 * (times[-1] - times[0]), _TAUS)
        bread = np.linalg.inv(jacobian.T @ jacobian)
        likelihood = np.empty(_TAUS)
        covariances = np.empty((_TAUS, parameters, parameters))
        # Residuals that vanish to round-off have no correlation to speak of.
        unit = max(self.noise, np.finfo(float).tiny)
        for n, tau in enumerate(taus):
            correlation = np.exp(-gaps / tau)
            orthogonal, triangle = np.linalg.qr(whitened(jacobian, correlation))
            white = whitened(residuals / unit, correlation)
            left = white - orthogonal @ (orthogonal.T @ white)
            squares = max(left @ left, np.finfo(float).tiny)
            likelihood[n] = (-0.5 * np.sum(np.log1p(-correlation**2))
                             - np.sum(np.log(np.abs(np.diag(triangle))))
                             - 0.5 * self.degrees * np.log(squares))
            middle = jacobian.T @ correlated(jacobian, correlation)
            covariances[n] = squares / self.degrees * unit**2 * bread @ middle @ bread
        self.weights = np.exp(likelihood - likelihood.max())
        self.weights /= self.weights.sum()
        self.covariances = covariances / np.outer(size, size)
        #: The likely correlation time of the residuals.
        self.correlation_time = float(np.exp(self.weights @ np.log(taus)))

    def half_width(self, gradient, level):
        """Half the width of the interval that holds a function of the parameters at that level."""
        gradient = np.asarray(gradient, float)
        scales = np.sqrt(np.einsum("i,nij,j->n", gradient, self.covariances, gradient))
        used = self.weights > 1e-6
        scales, weights = scales[used], self.weights[used] / self.weights[used].sum()
        if not scales.max() > 0:
            return 0.0
        far = stats.t.ppf(0.5 + 0.5 * level, self.degrees)
        low, high = 0.999 * far * scales.min(), 1.001 * far * scales.max()

        def excess(width):
            inside = 2 * stats.t.cdf(width / scales, self.degrees) - 1
            return weights @ inside - level
        return float(optimize.brentq(excess, low, high))

    def value(self, value, gradient):
        """A function of the parameters, linear in them within their errors, as a Value."""
        return Value(float(value), self.half_width(gradient, ONE_SIGMA),
                     self.half_width(gradient, TWO_SIGMA))
