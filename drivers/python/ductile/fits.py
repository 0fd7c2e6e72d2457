"""Fits to series: equilibria that are approached, oscillations, drifts, migration times.

Every fit takes times [W^2/nu] and values, a window [start, end] of times, and gives a small object
whose numbers are Values, with their errors (uncertainty.py), and which draws itself over the data:
fit.plot(axes). What the data do not bear raises DuctileError, with the reason.
"""
from dataclasses import dataclass, field

import numpy as np
from scipy import optimize

from .errors import DuctileError
from .uncertainty import ONE_SIGMA, TWO_SIGMA, Uncertainty, Value

# error95 over error, of what a series may differ from its model: more than a normal law has.
_FAR = 2.5

_DATA = {"color": "#8797AD", "linewidth": 3.2, "alpha": 0.55, "solid_capstyle": "butt"}
_FIT = {"color": "#D55E00", "linewidth": 1.4}
_LIMIT = {"color": "#D55E00", "linewidth": 1.0, "linestyle": (0, (5, 2))}


def window(t, y, start=None, end=None, least=12):
    """The samples of the window as two arrays; by default all. Raises DuctileError."""
    t, y = np.asarray(t, float), np.asarray(y, float)
    if t.ndim != 1 or t.shape != y.shape:
        raise DuctileError(f"a series has as many times as values, not {t.shape} and {y.shape}")
    if not (np.all(np.isfinite(t)) and np.all(np.diff(t) > 0)):
        raise DuctileError("times of a series increase")
    kept = np.ones(len(t), bool)
    if start is not None:
        kept &= t >= start
    if end is not None:
        kept &= t <= end
    t, y = t[kept], y[kept]
    if len(t) < least:
        raise DuctileError(f"{len(t)} samples are too few for a fit, which takes {least}")
    if not np.all(np.isfinite(y)):
        raise DuctileError("the series holds values that are not finite")
    return t, y


def _later_half(t, start):
    t = np.asarray(t, float)
    return t[0] + 0.5 * (t[-1] - t[0]) if start is None and len(t) else start


def _draw(axes, fit, t, y):
    axes.plot(t, y, **_DATA)
    fine = np.linspace(fit.t[0], fit.t[-1], 1000)
    axes.plot(fine, fit.curve(fine), **_FIT)


@dataclass(frozen=True)
class Line:
    """y = level + slope (t - t_mid), with t_mid the middle of the window.

    `level` [unit of y], `slope` [the same per W^2/nu]; `noise`, the standard deviation of the
    residuals, and `correlation_time` [W^2/nu], over which they are correlated.
    """
    level: Value
    slope: Value
    noise: float
    correlation_time: float
    t: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)

    def curve(self, t):
        middle = 0.5 * (self.t[0] + self.t[-1])
        return self.level.value + self.slope.value * (np.asarray(t) - middle)

    def plot(self, axes):
        """Draws the data and the line over them into matplotlib's axes."""
        _draw(axes, self, self.t, self.y)


def fit_line(t, y, start=None, end=None):
    """A straight line through a series, as a Line."""
    t, y = window(t, y, start, end)
    basis = np.column_stack([np.ones_like(t), t - 0.5 * (t[0] + t[-1])])
    values = np.linalg.lstsq(basis, y, rcond=None)[0]
    known = Uncertainty(t, y - basis @ values, basis)
    return Line(known.value(values[0], [1, 0]), known.value(values[1], [0, 1]), known.noise,
                known.correlation_time, t, y)


# ------------------------------------------------------------------------------------------------
# Equilibria


@dataclass(frozen=True)
class Relaxation:
    """y = equilibrium + amplitude exp(-(t - t_0)/time), with t_0 the start of the window.

    `equilibrium` [unit of y], `time` [W^2/nu], `amplitude` [unit of y] at t_0. Where the series
    already rests, "time" and "amplitude" are None, and the equilibrium is the mean.
    `statistical`, the equilibrium with the error of least squares alone; that of `equilibrium` also
    counts by what the approach may differ from an exponential.
    """
    equilibrium: Value
    statistical: Value
    time: Value | None
    amplitude: Value | None
    noise: float
    correlation_time: float
    t: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)
    before: tuple = field(repr=False, default=None)

    @property
    def rests(self):
        return self.time is None

    def curve(self, t):
        if self.rests:
            return np.full_like(np.asarray(t, float), self.equilibrium.value)
        decayed = np.exp(-(np.asarray(t) - self.t[0]) / self.time.value)
        return self.equilibrium.value + self.amplitude.value * decayed

    def plot(self, axes):
        """Draws the data, the curve over them, and the equilibrium with its error."""
        _draw(axes, self, *(self.before or (self.t, self.y)))
        value, error = self.equilibrium.value, self.equilibrium.error
        axes.axhline(value, **_LIMIT)
        axes.axhspan(value - error, value + error, color=_LIMIT["color"], alpha=0.15, linewidth=0)


def _relaxation_at(rate, t, y):
    """Least squares of [equilibrium, amplitude] at a given rate: sum of squares, and these."""
    basis = np.column_stack([np.ones_like(t), np.exp(-rate * (t - t[0]))])
    values = np.linalg.lstsq(basis, y, rcond=None)[0]
    rest = y - basis @ values
    return rest @ rest, values, rest


def _relaxation(t, y):
    """The best exponential: (rate, [equilibrium, amplitude], Uncertainty), or None if there is
    none: the best rate is at an end of what the window can tell."""
    length = t[-1] - t[0]
    rates = np.geomspace(0.05, 60, 60) / length
    costs = [_relaxation_at(rate, t, y)[0] for rate in rates]
    best = int(np.argmin(costs))
    if best in (0, len(rates) - 1):
        return None
    found = optimize.minimize_scalar(
        lambda log_rate: _relaxation_at(np.exp(log_rate), t, y)[0], method="bounded",
        bounds=np.log(rates[[best - 1, best + 1]]), options={"xatol": 1e-10})
    rate = float(np.exp(found.x))
    _, values, rest = _relaxation_at(rate, t, y)
    decayed = np.exp(-rate * (t - t[0]))
    jacobian = np.column_stack([np.ones_like(t), decayed,
                                -values[1] * (t - t[0]) * decayed])
    return rate, values, Uncertainty(t, rest, jacobian)


def _with_skew(value, rate, known, t, y):
    """The equilibrium as a Value whose errors also hold where the rate is at their ends.

    What is still to come grows without bound as the rate falls, so that the error that the
    derivative gives is too small on that side.
    """
    errors = []
    for level in (ONE_SIGMA, TWO_SIGMA):
        along = known.half_width([0, 0, 1], level)
        if along >= 0.9 * rate:
            return None
        ends = [_relaxation_at(rate + sign * along, t, y)[1][0] for sign in (-1, 1)]
        errors.append(max(known.half_width([1, 0, 0], level),
                          *(abs(end - value) for end in ends)))
    return Value(value, *errors)


def _misfit(t, y, limit, to_come):
    """By how much the equilibrium may be wrong because the approach is not quite an exponential.

    Parts of the window have it elsewhere, by more than their own errors explain; and a quarter of
    what is still to come is not believed.
    """
    count = len(t)
    apart = 0.0
    for part in (slice(count // 2, None), slice(count // 4, None), slice(0, 3 * count // 4)):
        found = _relaxation(t[part], y[part])
        other = found and _with_skew(found[1][0], found[0], found[2], t[part], y[part])
        if other:
            apart = max(apart, abs(other.value - limit.value) - np.hypot(other.error, limit.error))
    return float(np.hypot(apart, 0.25 * to_come))


def fit_relaxation(t, y, start=None, end=None):
    """Where a series comes to rest: y -> equilibrium + amplitude exp(-(t - t_0)/time).

    Over the later half by default, since the last approach alone is one exponential; give `start`
    to say from where on it is. Least squares, with the errors of uncertainty.py. To them comes what
    the approach may differ from an exponential: how far apart parts of the window have the
    equilibrium, beyond their own errors, and a quarter of what is still to come. Of 92 cuts through
    recorded runs of pairs, at 40 to 80% of their time, the equilibrium that the whole run leads to
    was within the error in 7 of 10 and within error95 in 9 of 10 (doc/analysis.md).

    Returns a Relaxation. A series without a drift beyond its error rests, and its equilibrium is
    the mean. Raises DuctileError where it moves, and no limit follows from how.
    """
    before = window(t, y, None, end)
    t, y = window(t, y, _later_half(before[0], start), end, 24)
    line = fit_line(t, y)
    found = _relaxation(t, y)
    limit = found and _with_skew(found[1][0], found[0], found[2], t, y)
    if limit is None:
        if abs(line.slope.value) < line.slope.error95:
            ones = np.ones((len(t), 1))
            known = Uncertainty(t, y - y.mean(), ones)
            rest = known.value(y.mean(), [1])
            # The drift that hides in the noise goes on to the end of the window.
            drift = 0.5 * abs(line.slope.value) * (t[-1] - t[0])
            whole = Value(rest.value, float(np.hypot(rest.error, drift)),
                          float(np.hypot(rest.error95, _FAR * drift)))
            return Relaxation(whole, rest, None, None, known.noise, known.correlation_time, t, y,
                              before)
        raise DuctileError(f"from t = {t[0]:.4g} on the series moves by {line.slope} per W^2/nu, "
                           "and approaches no limit that could be told: an earlier start or a "
                           "longer run may help")
    rate, values, known = found
    beside = _misfit(t, y, limit, values[1] * np.exp(-rate * (t[-1] - t[0])))
    time = known.value(1 / rate, [0, 0, -1 / rate**2])
    whole = Value(limit.value, float(np.hypot(limit.error, beside)),
                  float(np.hypot(limit.error95, _FAR * beside)))
    return Relaxation(whole, limit, time, known.value(values[1], [0, 1, 0]), known.noise,
                      known.correlation_time, t, y, before)


@dataclass(frozen=True)
class Migration:
    """When a body has come to a place.

    `time` [W^2/nu] from the start of the series, from which on it stays `within` [W] of `target`
    [W]; `first`, when it first was there; `extrapolated`, whether the run ended before.
    """
    time: Value
    first: float
    within: float
    target: float
    extrapolated: bool
    t: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)
    approach: Relaxation | None = field(repr=False, default=None)

    def plot(self, axes):
        """Draws the distance from the target, logarithmic, and when it is small enough."""
        axes.semilogy(self.t, np.abs(self.y - self.target), **_DATA)
        if self.approach is not None:
            fine = np.linspace(self.approach.t[0], self.t[0] + self.time.value, 500)
            axes.semilogy(fine, np.abs(self.approach.curve(fine) - self.target), **_FIT)
        axes.axhline(self.within, **_LIMIT)
        axes.axvline(self.t[0] + self.time.value, **_LIMIT)


def _crossing(t, distance, within, n):
    """When the distance has passed `within` between samples n and n + 1: it is interpolated as an
    exponential."""
    a, b = (np.log(max(d, np.finfo(float).tiny) / within) for d in distance[n:n + 2])
    return t[n] + (t[n + 1] - t[n]) * a / (a - b)


def migration_time(t, x, target=0.0, within=1e-3, extrapolate=False):
    """The migration time t^m of a body, as in Fig. 7 of Patel & Stark (2021), as a Migration.

    "The time needed to reach the channel centerline with a distance smaller than 10^-3" (of W):
    from the first sample to when |x - target| is below `within` for good, so that a body that
    crosses the centre has not arrived; `first` of the result counts the crossing. The time is
    interpolated between samples, and its error half the time between them.

    A body that is not there yet has a migration time only with `extrapolate`: by the exponential
    that its later half follows, of fit_relaxation(), which must lead to the target; the error is
    then that of the fit. Else DuctileError is raised.
    """
    t, x = window(t, x, least=2)
    distance = np.abs(x - target)
    outside = np.flatnonzero(distance >= within)
    if len(outside) == 0:
        raise DuctileError(f"the body is within {within:g} W of {target:g} W from the beginning")
    inside = np.flatnonzero(distance < within)
    crossings = inside[inside > outside[0]]
    first = _crossing(t, distance, within, crossings[0] - 1) - t[0] if len(crossings) else np.nan
    last = outside[-1]
    if last < len(t) - 1:
        arrived = _crossing(t, distance, within, last) - t[0]
        half = 0.5 * (t[last + 1] - t[last])
        return Migration(Value(arrived, half, half), first, within, target, False, t, x)
    if not extrapolate:
        raise DuctileError(f"the body does not come to within {within:g} W of {target:g} W and "
                           f"stay there: it ends at {distance[-1]:.3g} W from it")
    fit = fit_relaxation(t, x)
    if fit.rests or abs(fit.equilibrium.value - target) > max(within, fit.equilibrium.error95):
        raise DuctileError(f"the body heads for {fit.equilibrium} W, not for {target:g} W")
    return _extrapolated(t, x, target, within, first, fit)


def _extrapolated(t, x, target, within, first, fit):
    # Towards the target itself, which is known: log|x - target| is a straight line.
    line = fit_line(fit.t, np.log(np.abs(fit.y - target)))
    level, slope = line.level.value, line.slope.value
    if slope + line.slope.error95 >= 0:
        raise DuctileError(f"the body does not approach {target:g} W: it ends at "
                           f"{abs(x[-1] - target):.3g} W from it, and log|x| changes by "
                           f"{line.slope} per W^2/nu")
    arrived = 0.5 * (line.t[0] + line.t[-1]) + (np.log(within) - level) / slope
    # Level and slope at the middle of the window are independent.
    errors = [np.hypot(getattr(line.level, which) / slope,
                       (np.log(within) - level) / slope**2 * getattr(line.slope, which))
              for which in ("error", "error95")]
    return Migration(Value(arrived - t[0], *errors), first, within, target, True, t, x, fit)


# ------------------------------------------------------------------------------------------------
# Oscillations


@dataclass(frozen=True)
class Oscillation:
    """An oscillation that is damped, on a straight line:

    y = offset + drift (t - t_mid)
        + amplitude exp(-damping (t - t_0)) cos(2 pi frequency (t - t_0) + phase)

    with t_0 the start and t_mid the middle of the window. `offset` and `amplitude` (at t_0) [unit
    of y], `drift` [the same per W^2/nu], `damping` [nu/W^2] (negative: it grows), `frequency`
    [nu/W^2] and `period` [W^2/nu], `phase` [rad]; `noise`, the standard deviation of the
    residuals, and `correlation_time` [W^2/nu] over which they are correlated.
    """
    offset: Value
    drift: Value
    amplitude: Value
    damping: Value
    frequency: Value
    period: Value
    phase: Value
    noise: float
    correlation_time: float
    t: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)

    def curve(self, t):
        since = np.asarray(t) - self.t[0]
        middle = 0.5 * (self.t[0] + self.t[-1])
        return (self.offset.value + self.drift.value * (np.asarray(t) - middle)
                + self.amplitude.value * np.exp(-self.damping.value * since)
                * np.cos(2 * np.pi * self.frequency.value * since + self.phase.value))

    def plot(self, axes):
        """Draws the data, the fit over them, and its envelope."""
        _draw(axes, self, self.t, self.y)
        fine = np.linspace(self.t[0], self.t[-1], 400)
        middle = 0.5 * (self.t[0] + self.t[-1])
        centre = self.offset.value + self.drift.value * (fine - middle)
        envelope = self.amplitude.value * np.exp(-self.damping.value * (fine - self.t[0]))
        for sign in (-1, 1):
            axes.plot(fine, centre + sign * envelope, **_LIMIT)


def _oscillation_basis(t, damping, frequency):
    since = t - t[0]
    decay = np.exp(-damping * since)
    angle = 2 * np.pi * frequency * since
    return np.column_stack([np.ones_like(t), t - 0.5 * (t[0] + t[-1]),
                            decay * np.cos(angle), decay * np.sin(angle)])


def _candidates(t, y, low, high):
    """(damping, frequency) from which to start: peaks of the spectra of the detrended series with
    several exponential weights."""
    length, count = t[-1] - t[0], len(t)
    even = np.linspace(t[0], t[-1], count)
    values = np.interp(even, t, y)
    values -= np.polyval(np.polyfit(even, values, 1), even)
    size = 8 * 2 ** int(np.ceil(np.log2(count)))
    frequencies = np.fft.rfftfreq(size, length / (count - 1))
    allowed = (frequencies >= low) & (frequencies <= high)
    found = []
    for damping in np.array([-1, 0, 1, 2, 4, 8, 16]) / length:
        weight = np.exp(-damping * (even - even[0]))
        power = np.abs(np.fft.rfft(values * weight, size))**2 / (weight @ weight)
        power = np.where(allowed, power, 0)
        peaks = np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:])
                               & allowed[1:-1]) + 1
        peaks = np.append(peaks[np.argsort(power[peaks])[-3:]], np.argmax(power))
        found += [(damping, frequencies[peak]) for peak in peaks]

    def cost(candidate):
        basis = _oscillation_basis(t, *candidate)
        rest = y - basis @ np.linalg.lstsq(basis, y, rcond=None)[0]
        return rest @ rest
    return sorted(set(found), key=cost)[:4]


def _oscillation_residual(parameters, t, y):
    return _oscillation_basis(t, *parameters[4:]) @ parameters[:4] - y


def _oscillation_jacobian(parameters, t, _y):
    basis = _oscillation_basis(t, *parameters[4:])
    cosine, sine = parameters[2:4]
    since = t - t[0]
    by_damping = -since * (cosine * basis[:, 2] + sine * basis[:, 3])
    by_frequency = 2 * np.pi * since * (sine * basis[:, 2] - cosine * basis[:, 3])
    return np.column_stack([basis, by_damping, by_frequency])


def fit_oscillation(t, y, start=None, end=None):
    """An oscillation on a straight line, by least squares, as an Oscillation.

    The whole series by default. Of all frequencies between one period in the window and half the
    sampling rate the best fit is taken. Errors are those of uncertainty.py, and right whether
    residuals are white or correlated over a time that is short against the window
    (tests/python/coverage_test.py measures it).

    Raises DuctileError if the window has not a whole period, if the oscillation dies within a
    quarter of one, or if its amplitude is not clear of what the noise would make.
    """
    t, y = window(t, y, start, end, 24)
    length = t[-1] - t[0]
    low, high = 1 / length, 0.5 / np.median(np.diff(t))
    size = np.ptp(y)
    if not size > 0:
        raise DuctileError("the series is constant, and does not oscillate")
    scaled = y / size
    best = None
    for candidate in _candidates(t, scaled, low, high):
        basis = _oscillation_basis(t, *candidate)
        first = np.concatenate([np.linalg.lstsq(basis, scaled, rcond=None)[0], candidate])
        with np.errstate(over="ignore", invalid="ignore"):
            try:
                found = optimize.least_squares(
                    _oscillation_residual, first, _oscillation_jacobian, method="lm",
                    args=(t, scaled), x_scale=np.array([1, 1 / length, 1, 1] + 2 * [1 / length]))
            except ValueError:  # a trial that overflows
                continue
        plausible = 0 < found.x[5] <= high and np.all(np.isfinite(found.x))
        if plausible and (best is None or found.cost < best.cost):
            best = found
    if best is None:
        raise DuctileError("no oscillation fits the series")
    return _oscillation(t, y, size, best.x)


def _oscillation(t, y, size, parameters):
    scaled = y / size
    known = Uncertainty(t, _oscillation_residual(parameters, t, scaled),
                        _oscillation_jacobian(parameters, t, scaled))
    cosine, sine, damping, frequency = parameters[2:]
    square = cosine**2 + sine**2
    amplitude = np.sqrt(square)
    if frequency * (t[-1] - t[0]) < 1:
        raise DuctileError(f"the best fit has a period of {1 / frequency:.3g}, and the window of "
                           f"{t[-1] - t[0]:.3g} not one of them: no oscillation can be told from a "
                           "drift")
    if damping > 4 * frequency:
        raise DuctileError(f"the best fit dies out within {1 / damping:.3g}, less than a quarter "
                           f"of its period of {1 / frequency:.3g}: that is no oscillation")

    def value(number, gradient, unit=1.0):
        found = known.value(number, gradient)
        return Value(found.value * unit, found.error * unit, found.error95 * unit)
    of_amplitude = [0, 0, cosine / amplitude, sine / amplitude, 0, 0]
    result = Oscillation(
        offset=value(parameters[0], [1, 0, 0, 0, 0, 0], size),
        drift=value(parameters[1], [0, 1, 0, 0, 0, 0], size),
        amplitude=value(amplitude, of_amplitude, size),
        damping=value(damping, [0, 0, 0, 0, 1, 0]),
        frequency=value(frequency, [0, 0, 0, 0, 0, 1]),
        period=value(1 / frequency, [0, 0, 0, 0, 0, -1 / frequency**2]),
        phase=value(np.arctan2(-sine, cosine), [0, 0, sine / square, -cosine / square, 0, 0]),
        noise=known.noise * size, correlation_time=known.correlation_time, t=t, y=y)
    # Of so many oscillations that noise may make one has the largest amplitude (Scargle,
    # Astrophys. J. 263, 835, 1982); four dampings tried count as another each.
    length = t[-1] - t[0]
    trials = 4 * length * min(0.5 / np.median(np.diff(t)), 1 / known.correlation_time)
    if result.amplitude.value < np.sqrt(2 * np.log(100 * trials)) * result.amplitude.error:
        raise DuctileError(f"no oscillation can be told from the noise: the best fit has the "
                           f"amplitude {result.amplitude}")
    return result
