"""The numbers of the study: what its figures show and its report says, from the runs, with errors.

Lengths are in W, half the channel's width, times in W^2/nu, rates in nu/W^2, strain energies in
k_s a^2, angles in degrees. Every number is a Quantity: a Value with its error (uncertainty.py), or
none, with the reason. What the paper says of the same numbers is in STATED and PAPER_CLASSES.

A function that takes a study and a method looks at the cases of that method, on the lattice of
`nodes` across the channel, by default the coarsest, which is the study's own. Rigid bodies have no
membrane: their cases stand for both methods.
"""
import math
from dataclasses import dataclass, field, replace

import numpy as np

from .. import rotation
from ..errors import DuctileError
from ..fits import Oscillation, fit_line, fit_oscillation, fit_relaxation, migration_time
from ..uncertainty import Value
from .study import PAIRS, X_LAGS, Study

# ------------------------------------------------------------------------------------------------
# What the paper says

# Fig. 4, by the text of sections 3, 3.1.2 and 3.2.2, which names every cell: for x_lag = -0.4 to
# 0.4, in the words of the program's verdicts.
_STABLE, _DAMPED, _BOUNDED, _UNSTABLE = "stable", "damped", "bounded", "unstable"
PAPER_CLASSES = {
    "M1": (_STABLE,) * 5,
    "M2": (_STABLE, _STABLE, _DAMPED, _UNSTABLE, _UNSTABLE),
    "M3": (_UNSTABLE, _STABLE, _UNSTABLE, _UNSTABLE, _UNSTABLE),
    "B1": (_BOUNDED,) * 5,
    "B2": (_STABLE, _STABLE, _UNSTABLE, _UNSTABLE, _UNSTABLE),
    "B3": (_UNSTABLE, _STABLE, _STABLE, _UNSTABLE, _UNSTABLE),
    "B4": (_UNSTABLE, _STABLE, _UNSTABLE, _UNSTABLE, _UNSTABLE),
}


# The verdicts that count as each of the paper's classes: where it says that a pair is stable, one
# that comes to rest after a swing or two does what it says; its bounded oscillations are the same
# where they die out.
ACCEPTED = {_STABLE: (_STABLE, _DAMPED), _DAMPED: (_DAMPED,),
            _BOUNDED: (_BOUNDED, _DAMPED, _STABLE), _UNSTABLE: (_UNSTABLE,)}


def accepted(pair, paper):
    """The verdicts that count as the paper's class of a pair. Its stable pairs of the tumbling cell
    of La = 100 are modulated for good (section 3.2.2), which the program calls bounded."""
    return ACCEPTED[paper] + ((_BOUNDED,) if (pair, paper) == ("B2", _STABLE) else ())


@dataclass(frozen=True)
class Stated:
    """A number that the paper's text states: `value`, in what words, and in which section."""
    value: float
    words: str
    section: str


STATED = {
    "sphere-La10": Stated(0.0, "settles at the channel center", "3.1.1"),
    "sphere-La100": Stated(0.3, "the known equilibrium position at x = 0.3", "3.1.2"),
    "rigid": Stated(0.4, "inferred: x_lag = +-0.4 is \"close to their equilibrium positions\"",
                    "3.1.2"),
    "biconcave-La10": Stated(0.0, "inferred: very close to that of a sphere of the same rigidity; "
                                  "does not fully reach the centre", "3.2.1"),
    "biconcave-La100": Stated(0.3, "inferred: very close to that of a sphere of the same rigidity",
                              "3.2.1"),
    "released": Stated(0.0, "a second type of stable position at x = 0", "3.1.2"),
    "dz stop": Stated(10.0, "we stop the simulations once dz is beyond 10", "3.1.2"),
    "M2 dz_eq": Stated(1.0, "close to the initial value", "3.1.2"),
    "M1 quotient": Stated(2.0, "dz for x_lag = 0.4 is twice as large as that for -0.4", "3.1.2"),
    "B4 parting": Stated(400.0, "one would need 400 time units to reach dz = 10", "3.2.2"),
    "rectangular dz": Stated(2.0, "initial axial distance 2 (5 a)", "A"),
}

# Fig. 7: whether the presence of the other particle makes the way to the centre take longer.
MIGRATES = {
    "lead": {-0.4: "slower", -0.2: "faster", 0.0: "faster", 0.2: "faster", 0.4: "slower"},
    "lag": {-0.4: "faster", -0.2: "faster", 0.2: "slower", 0.4: "slower"},
}


def paper_class(pair, x_lag):
    """The paper's class of a pair, as the program's verdicts are called."""
    return PAPER_CLASSES[pair][_index(x_lag)]


def _index(x_lag):
    return int(np.argmin(np.abs(np.array(X_LAGS) - x_lag)))


# ------------------------------------------------------------------------------------------------
# Numbers


@dataclass(frozen=True)
class Quantity:
    """A number of the study, or why there is none.

    `value`, a Value, or None, and then `reason` says why. `how` says by what it was found, `swing`
    half the range of what goes on about it, where something does, and `case` which runs it is from.
    """
    value: Value | None
    reason: str = ""
    how: str = ""
    swing: float | None = None
    case: str = ""

    @property
    def known(self):
        return self.value is not None

    def __float__(self):
        """The number; NaN where there is none."""
        return float(self.value) if self.known else math.nan

    def __str__(self):
        return str(self.value) if self.known else f"none: {self.reason}"


def _none(reason, case=""):
    return Quantity(None, str(reason), case=case)


def _of(case, found):
    """The quantity with its case's name."""
    return replace(found, case=case.label)


def scaled(value, factor):
    """A Value in another unit."""
    size = abs(factor)
    return Value(value.value * factor, value.error * size, value.error95 * size)


def quotient(above, below):
    """The quotient of two Quantities whose errors are independent."""
    for quantity in (above, below):
        if not quantity.known:
            return _none(quantity.reason, quantity.case)
    a, b = above.value, below.value
    if b.value == 0:
        return _none("the divisor is zero", below.case)
    ratio = a.value / b.value
    errors = [float(np.hypot(getattr(a, which) / b.value, ratio * getattr(b, which) / b.value))
              for which in ("error", "error95")]
    return Quantity(Value(ratio, *errors), how="a quotient", case=f"{above.case}, {below.case}")


def level(t, y):
    """Where a series comes to, as a Quantity: its equilibrium, or the middle of what goes on.

    Over the later half, by fit_relaxation(): of what rests the mean, of what approaches
    exponentially the limit, with its error; what drifts without a limit has none.

    Where the later half holds three periods of an oscillation (a cell that tumbles, a pair that
    swings), the series is first averaged over a period, twice, and the error also has in it by how
    much the average has moved in the last period. An average that has no limit, but moves by less
    than a tenth of the swings, is taken where it ends, with that movement as error. `swing` is half
    the range of the last two periods. Of 76 cuts, at t = 36 to 90, through four damped pairs 71
    had a level; that of the end was within the error in 87%, and within twice that in 97%.
    """
    t, y = np.asarray(t, float), np.asarray(y, float)
    try:
        period = _period_of_later_half(t, y)
        if period is not None:
            return _level_of_swings(t, y, period)
        found = fit_relaxation(t, y)
    except DuctileError as error:
        return _none(error)
    return Quantity(found.equilibrium, how=_kind(found))


def _kind(relaxation):
    return "the mean of what rests" if relaxation.rests else "the limit of an exponential approach"


def _level_of_swings(t, y, period):
    even, smooth = _averaged(t, y, period)
    later = even >= 0.5 * (t[0] + t[-1])
    swing = 0.5 * float(np.ptp(y[t >= t[-1] - 2 * period]))
    moved = abs(smooth[-1] - np.interp(even[-1] - period, even, smooth))
    try:
        found = fit_relaxation(even[later], smooth[later], start=even[later][0])
        value, what = found.equilibrium, _kind(found)
    except DuctileError:
        wanders = float(np.ptp(smooth[later]))
        if wanders > 0.1 * swing:
            raise
        value, what = Value(float(smooth[-1]), wanders, 2 * wanders), "the middle of the swings"
    whole = Value(value.value, float(np.hypot(value.error, moved)),
                  float(np.hypot(value.error95, 2 * moved)))
    return Quantity(whole, how=f"{what}, averaged over periods of {period:.3g}", swing=swing)


def _period_of_later_half(t, y):
    """The period of an oscillation of which the later half of a series holds three, or None."""
    half = 0.5 * (t[-1] - t[0])
    try:
        found = fit_oscillation(t, y, start=t[0] + half)
    except DuctileError:
        return None
    return found.period.value if 3 * found.period.value <= half else None


def _averaged(t, y, period):
    """A series on even times, averaged over a period twice, which leaves nothing of an oscillation
    with that period and a straight line as it is; shorter by a period at both ends."""
    count = max(int(math.ceil((t[-1] - t[0]) / np.median(np.diff(t)))), 2)
    even, step = np.linspace(t[0], t[-1], count + 1, retstep=True)
    values = np.interp(even, t, y)
    width = max(int(round(period / step)), 1)
    kernel = np.full(width, 1 / width)
    kernel = np.convolve(kernel, kernel)
    smooth = np.convolve(values, kernel, mode="valid")
    return even[width - 1:width - 1 + len(smooth)], smooth


def extrema(t, y, reversal):
    """Indices of the turning points of a series, which it goes back from by `reversal` [unit of y]
    at least; the first sample is none."""
    found, low, high, rising = [], 0, 0, None
    for n, value in enumerate(y):
        if value > y[high]:
            high = n
        if value < y[low]:
            low = n
        if rising is not False and y[high] - value >= reversal:
            if high > 0:
                found.append(high)
            rising, low = False, n
            high = n
        elif rising is not True and value - y[low] >= reversal:
            if low > 0:
                found.append(low)
            rising, high = True, n
            low = n
    return found


# ------------------------------------------------------------------------------------------------
# Cases

SINGLES = ("sphere-La10", "sphere-La100", "rigid", "biconcave-La10", "biconcave-La100")
_CAMPAIGN_OF = {"sphere": "spheres", "rigid": "rigid", "biconcave": "cells"}
STARTS = (0.2, 0.4)
# The M2 pairs of Fig. 8.
DAMPED_X_LAGS = (0.0, -0.05, -0.1, -0.15)


def kind_of(case, body=None):
    """"rigid", "sphere-La10", "biconcave-La100", ... of a body, by default the first."""
    body = body or case.run.bodies[0]
    own = {key.split(".", 2)[2]: value for key, value in case.parameters.items()
           if key.startswith(f"body.{body}.")}
    if own.get("kind") == "rigid":
        return "rigid"
    return f"{own.get('shape', 'sphere')}-La{float(own.get('laplace', math.nan)):g}"


def single_case(study, name, start, method, nodes=None):
    """The case of a single body of SINGLES that starts at x = `start`, or None."""
    method = "clean" if name == "rigid" else method
    found = [case for case in study.cases(_CAMPAIGN_OF[name.split("-")[0]], method, nodes)
             if kind_of(case) == name and abs(case.start(case.run.bodies[0]) - start) < 1e-9]
    return Study.coarsest(found)


def damped_case(study, x_lag, method, nodes=None):
    """The case of M2 with x_lag = 0, -0.05, -0.1 or -0.15, or None."""
    return study.pair("M2" if x_lag == 0 else "damped", x_lag, method, nodes)


def only_case(study, campaign, method, nodes=None):
    """The case of a campaign that has one: "diagonal" or "rectangular"; or None."""
    return Study.coarsest(study.cases(campaign, method, nodes))


def released_case(study, method):
    """The capsule that is released near to the centre, on the finest lattice; or None."""
    return Study.finest([case for case in study.cases("released", method) if case.ended])


def _missing(what):
    return _none(f"{what} has not been computed")


def pair_name(pair, x_lag):
    """"M2, x_lag = -0.2"."""
    return f"{pair}, x_lag = {x_lag:g}"


# ------------------------------------------------------------------------------------------------
# Fig. 4: classes


@dataclass(frozen=True)
class Class:
    """What came of a pair: `verdict`, "stable", "damped", "bounded", "unstable" or "undecided", or
    None where there is none, with the `reason`; `paper`, the paper's; `case`, whose it is; `pair`,
    "M1" to "B4"."""
    verdict: str | None
    reason: str
    paper: str
    case: str = ""
    pair: str = ""

    @property
    def agrees(self):
        """Whether it counts as the paper's class, accepted(); None where ours is undecided or
        missing."""
        if self.verdict in (None, "undecided"):
            return None
        return self.verdict in accepted(self.pair, self.paper)


def classes(study, method, nodes=None):
    """What came of every pair: {(pair, x_lag): Class}."""
    return {(pair, x_lag): class_of(study.pair(pair, x_lag, method, nodes), pair, x_lag)
            for pair in PAIRS for x_lag in X_LAGS}


def class_of(case, pair, x_lag):
    """The Class of a case, which may be None."""
    paper = paper_class(pair, x_lag)
    if case is None:
        return Class(None, "it has not been computed", paper)
    if not case.summary:
        return Class(None, "the run has not ended", paper, case.label)
    verdict = case.summary.get("verdict")
    if case.summary.get("status") == "blew up":
        why = str(case.summary.get("blow_up", {}).get("reason", "it became unstable"))
        return Class("undecided", f"the run blew up: {why}", paper, case.label)
    if not case.ended:
        return Class("undecided", "the run has not ended", paper, case.label)
    if verdict is None:
        return Class(None, f"the run ended without a verdict: {case.summary.get('status')}", paper,
                     case.label)
    reason = str(case.summary.get("verdict_reason", ""))
    if verdict == "undecided":
        held = _held_together(case)
        if held and paper in (_BOUNDED, _UNSTABLE):
            return Class(_BOUNDED, f"{held} (the program's own judge has not decided: {reason})",
                         paper, case.label, pair)
    return Class(verdict, reason, paper, case.label, pair)


# Where the paper says that a pair swings within bounds, or parts, one that the program has not
# judged by the end counts as bounded if it has run for so long [W^2/nu], and dz of the last quarter
# is nowhere larger than in the quarter before by more than this [W]: a figure shows as much. Where
# the paper says that a pair comes to rest, that is not known until it does.
_LONG_ENOUGH, _NO_FURTHER = 40.0, 0.15


def _held_together(case):
    """In what words a pair has stayed together without coming to rest; nothing if it has not."""
    t, dz = case.run.series("dz")
    shares = t / t[-1]
    before = np.abs(dz[(shares >= 0.5) & (shares <= 0.75)])
    last = np.abs(dz[shares >= 0.75])
    if t[-1] < _LONG_ENOUGH or last.max() > before.max() + _NO_FURTHER:
        return ""
    return (f"over the last quarter of the run, to t = {t[-1]:.3g}, dz stays between "
            f"{last.min():.2f} and {last.max():.2f} W, and was as large as {before.max():.2f} W in "
            "the quarter before")


# ------------------------------------------------------------------------------------------------
# Figs. 5, 9: single bodies

# Limits of x and dz [W] that are known no better count as unknown; that of dz is the verdict's.
_LARGEST_OF_X, _LARGEST_OF_DZ = 0.05, 0.6


def single_equilibria(study, method, nodes=None):
    """Where single bodies settle, x [W], by kind and start: {("sphere-La100", 0.2): Quantity}."""
    return {(name, start): equilibrium(single_case(study, name, start, method, nodes), "x")
            for name in SINGLES for start in STARTS}


def equilibrium(case, axis="x", body=None):
    """Where a body settles along x or y [W]; of one that tumbles the mean, with `swing`.

    By level(); where that finds none, the limit that the program extrapolates to (x_limit_W of
    summary.json). A limit that is not known to better than 0.05 is none.
    """
    if case is None:
        return _missing("the case")
    body = body or case.run.bodies[0]
    found = _if_better(level(*case.run.series(f"{body}_{axis}")), _LARGEST_OF_X)
    if not found.known and axis == "x":
        own = next((own for own in case.summary.get("bodies", []) if own.get("name") == body), {})
        found = _programs(own.get("x_limit_W"), own.get("x_limit_error_W"),
                          _LARGEST_OF_X, found)
    return _of(case, found)


def _if_better(found, largest):
    """A quantity, or none where its error is larger than that."""
    if not found.known or found.value.error <= largest:
        return found
    return _none(f"the limit of {found.value} is not known to better than {largest:g}", found.case)


def _programs(limit, error, largest, otherwise):
    """A limit of summary.json, of which the error holds in 99 of 100 cases (doc/verdict.md): it is
    stated as the one that holds in 95, and half of it as that of 68."""
    if limit is None or error is None or error > largest:
        return otherwise
    return Quantity(Value(float(limit), 0.5 * error, float(error)),
                    how="the limit that the program extrapolates to")


# ------------------------------------------------------------------------------------------------
# Fig. 7: migration times


@dataclass(frozen=True)
class MigrationRatio:
    """t_m of a body in the pair over that of a single one: `ratio`, and the times `pair` and
    `single` [W^2/nu]; `extrapolated`, whether one of the runs ended before."""
    ratio: Quantity
    pair: Quantity
    single: Quantity
    extrapolated: bool


# A migration time whose error is a larger share of it counts as unknown.
_LARGEST_OF_TIME = 0.25


def time_to_centre(case, body):
    """t_m [W^2/nu], until a body is within 1e-3 W of x = 0 for good: (Quantity, extrapolated).

    By fits.migration_time(), along the exponential that is followed where the run ends before. A
    time that this does not give to better than a quarter is none.
    """
    if case is None:
        return _missing("the case"), False
    try:
        found = migration_time(*case.run.series(f"{body}_x"), extrapolate=True)
    except DuctileError as error:
        return _none(error, case.label), False
    if found.extrapolated and not found.time.error <= _LARGEST_OF_TIME * found.time.value:
        return _none(f"the run ends with the body at x = {found.y[-1]:.2g}, and extrapolates to "
                     f"{found.time}", case.label), False
    how = "extrapolated" if found.extrapolated else "reached"
    return Quantity(found.time, how=how, case=case.label), found.extrapolated


def migration_ratios(study, method, nodes=None):
    """How much longer the bodies of M1 take to the centre than single ones that start as far from
    it (Fig. 7): {x_lag: {"lead": MigrationRatio, "lag": MigrationRatio}}.

    By symmetry a single body that starts at x = -0.4 takes as long as one from 0.4.
    """
    singles = {start: time_to_centre(*_single_sphere(study, start, method, nodes))
               for start in STARTS}
    result = {}
    for x_lag in X_LAGS:
        case = study.pair("M1", x_lag, method, nodes)
        result[x_lag] = {}
        for body, start in (("lead", 0.2), ("lag", abs(x_lag))):
            if start == 0:
                none = _none("it starts at the centre, where single ones stay")
                result[x_lag][body] = MigrationRatio(none, none, none, False)
                continue
            pair, beyond = time_to_centre(case, body)
            single, single_beyond = singles[start]
            result[x_lag][body] = MigrationRatio(quotient(pair, single), pair, single,
                                                 beyond or single_beyond)
    return result


def _single_sphere(study, start, method, nodes):
    case = single_case(study, "sphere-La10", start, method, nodes)
    return case, case.run.bodies[0] if case else ""


# ------------------------------------------------------------------------------------------------
# Fig. 8: damped oscillations

# From so much [W] on a change of dz back counts as a turn; capsules at the centre of a coarse
# lattice make it wander by 0.02 (doc/verdict.md).
TURN = 0.05
# A damped cosine holds where it leaves no more than this of its amplitude.
_HOLDS = 0.05
_STARTS_TRIED = 8


@dataclass(frozen=True)
class DampedOscillation:
    """The oscillation of dz of a pair.

    `maximum`, the largest dz [W]; `equilibrium`, where it comes to [W]; `damping`, zeta [nu/W^2],
    of dz - dz_eq falling off as exp(-zeta t), and `period` [W^2/nu], of the swings from where on
    one damped cosine describes them (damped_oscillation() has the rule). `fit`, from which these
    two are, or None.
    """
    case: str
    maximum: Quantity
    equilibrium: Quantity
    damping: Quantity
    period: Quantity
    fit: Oscillation | None = field(repr=False, default=None)


def damped_oscillations(study, method, nodes=None):
    """max(dz), dz_eq, damping rate and period of the M2 pairs of Fig. 8, {x_lag:
    DampedOscillation}, of those that have been computed."""
    cases = {x_lag: damped_case(study, x_lag, method, nodes) for x_lag in DAMPED_X_LAGS}
    return {x_lag: damped_oscillation(case) for x_lag, case in cases.items() if case}


def damped_oscillation(case):
    """The DampedOscillation of a pair.

    A single damped cosine is no model of the first swings, which are large and slow: the rate that
    a fit gives falls as it starts later. The fit of fit_oscillation() starts at the first turn of
    dz from which on one damped cosine holds, its residuals being below 5% of its amplitude, over
    two periods or more; where there is none, at the turn where they are smallest. The errors of
    rate and period also have in them by how much the fit from the next turn on differs (where none
    holds, from the one before too).
    """
    t, dz = case.run.series("dz")
    turns = extrema(t, dz, TURN)
    fits, why = {}, ""
    for number, turn in enumerate(turns[:_STARTS_TRIED]):
        try:
            fit = fit_oscillation(t, dz, start=t[turn])
        except DuctileError as error:
            why = why or str(error)
            continue
        if 2 * fit.period.value <= fit.t[-1] - fit.t[0]:
            fits[number] = fit
            if number - 1 in fits and _misfit(fits[number - 1]) < _HOLDS:
                break
        else:
            why = why or (f"from t = {t[turn]:.3g} on dz has not two periods of the "
                          f"{fit.period.value:.3g} that fit it best")
    if len(turns) < 2 or not fits:
        why = why if len(turns) > 1 else f"dz turns {len(turns)} times by {TURN:g} W or more"
        rate = period = _none(why, case.label)
        chosen = None
    else:
        chosen = next((number for number, fit in fits.items() if _misfit(fit) < _HOLDS),
                      min(fits, key=lambda number: _misfit(fits[number])))
        beside = [chosen + 1] + ([] if _misfit(fits[chosen]) < _HOLDS else [chosen - 1])
        rate, period = (_with_spread(case, fits[chosen], [fits[n] for n in beside if n in fits],
                                     which) for which in ("damping", "period"))
    return DampedOscillation(case.label, largest(case, t, dz), _of(case, _level_of_dz(case)),
                             rate, period, fits.get(chosen))


def _misfit(fit):
    return fit.noise / fit.amplitude.value


def _with_spread(case, fit, others, which):
    """A number of a fit, whose errors also hold those of others."""
    value = getattr(fit, which)
    apart = max((abs(getattr(other, which).value - value.value) for other in others), default=0.0)
    return Quantity(Value(value.value, float(np.hypot(value.error, apart)),
                          float(np.hypot(value.error95, 2 * apart))),
                    how=f"a damped cosine through dz from its turn at t = {fit.t[0]:.3g}, with "
                    f"residuals of {_misfit(fit):.0%}", case=case.label)


def largest(case, t, y):
    """The largest value of a series, by the parabola through the largest sample and its neighbours,
    which is as wrong as that corrects the sample. A series that still rises at its end has none."""
    n = int(np.argmax(y))
    if n == len(y) - 1:
        return _none(f"it still grows at the end, at t = {t[-1]:.3g}", case.label)
    if n == 0:
        return Quantity(Value(float(y[0]), 0.0, 0.0), how="it falls from its start",
                        case=case.label)
    a, b, c = np.polyfit(t[n - 1:n + 2] - t[n], y[n - 1:n + 2], 2)
    top = c - b**2 / (4 * a) if a < 0 else y[n]
    error = float(max(abs(top - y[n]), np.finfo(float).eps * abs(top)))
    return Quantity(Value(float(top), error, 2 * error), how="a parabola through its top",
                    case=case.label)


def centre_of_mass_path(case):
    """The path of a pair's bodies relative to their centre of mass (inset of Fig. 8b): t and arrays
    (n, 2) of [z, x] [W], {"t": ..., "lead": ..., "lag": ...}. Raises DuctileError for bodies whose
    volumes differ."""
    if kind_of(case, "lead").split("-")[0] != kind_of(case, "lag").split("-")[0]:
        raise DuctileError(f"{case.label}: bodies of two shapes have not the same mass")
    table = case.run.table
    place = {body: table[[f"{body}_z", f"{body}_x"]].to_numpy() for body in ("lead", "lag")}
    centre = 0.5 * (place["lead"] + place["lag"])
    return {"t": table["t"].to_numpy(), **{body: own - centre for body, own in place.items()}}


# ------------------------------------------------------------------------------------------------
# Fig. 13: equilibrium distances


def equilibrium_distances(study, method, nodes=None):
    """dz_eq [W] of all pairs that the program calls stable, damped or bounded, as Quantities:
    {(pair, x_lag): Quantity}; of bounded ones the middle, with `swing`. Of others there is none."""
    return {(pair, x_lag): equilibrium_distance(study.pair(pair, x_lag, method, nodes), pair, x_lag)
            for pair in PAIRS for x_lag in X_LAGS}


def equilibrium_distance(case, pair, x_lag):
    """dz_eq [W] of a case, which may be None; see equilibrium_distances()."""
    found = class_of(case, pair, x_lag)
    if found.verdict is None:
        return _none(found.reason, found.case)
    if found.verdict in ("unstable", "undecided"):
        return _none(f"the pair is {found.verdict}: {found.reason}", found.case)
    return _of(case, _level_of_dz(case))


def _came_to_nothing(case):
    """Why a pair comes to no distance, or "" where it may."""
    if case.summary.get("status") == "blew up":
        return "the run blew up"
    if case.summary.get("verdict") == _UNSTABLE:
        return f"the pair is unstable: {case.summary.get('verdict_reason', '')}"
    return ""


def _level_of_dz(case):
    """Where dz comes to: by level(), else the limit that the program extrapolates to, else the line
    about which a damped cosine swings. A pair that parts, or whose run blew up, has none."""
    ended = _came_to_nothing(case)
    if ended:
        return _none(ended, case.label)
    t, dz = case.run.series("dz")
    found = _if_better(level(t, dz), _LARGEST_OF_DZ)
    if found.known:
        return found
    found = _programs(case.summary.get("dz_limit_W"), case.summary.get("dz_limit_error_W"),
                      _LARGEST_OF_DZ, found)
    if found.known:
        return found
    turns = extrema(t, dz, TURN)
    try:
        fit = fit_oscillation(t, dz, start=t[turns[1]] if len(turns) > 1 else None)
    except DuctileError:
        return found
    # The drift goes on to the end of the window, and nobody knows how far beyond it.
    drift = abs(fit.drift.value) * (fit.t[-1] - fit.t[0])
    return _if_better(Quantity(Value(fit.offset.value, float(np.hypot(fit.offset.error, drift)),
                                     float(np.hypot(fit.offset.error95, 2 * drift))),
                               how="the line about which a damped cosine swings"),
                      _LARGEST_OF_DZ)


# A slower growth of dz [nu/W] counts as rest, as in doc/verdict.md.
_PARTS = 0.003


def parting_time(case, distance=STATED["dz stop"].value):
    """When dz comes to `distance` [W^2/nu] if it goes on as over the last quarter of the run (the
    paper: some 400 for B4 from x_lag = 0.2); when it did where it has. A pair that stays together
    has none, whatever dz does at the end of its run."""
    if case is None:
        return _missing("the case")
    verdict = case.summary.get("verdict")
    if verdict in (_STABLE, _DAMPED, _BOUNDED):
        return _none(f"the pair is {verdict}: {case.summary.get('verdict_reason', '')}", case.label)
    t, dz = case.run.series("dz")
    if dz[-1] >= distance:
        n = int(np.flatnonzero(dz >= distance)[0])
        step = float(t[n] - t[max(n - 1, 0)])
        return Quantity(Value(float(t[n]), step, step), how="reached", case=case.label)
    if case.summary.get("status") == "blew up":
        return _none("the run blew up", case.label)
    try:
        line = fit_line(t, dz, start=t[-1] - 0.25 * (t[-1] - t[0]))
    except DuctileError as error:
        return _none(error, case.label)
    slope = line.slope
    if slope.value <= max(slope.error95, _PARTS):
        return _none(f"dz grows by {slope} per W^2/nu at the end: it does not part", case.label)
    level_now, middle = line.level, 0.5 * (line.t[0] + line.t[-1])
    missing = distance - level_now.value
    errors = [float(np.hypot(getattr(level_now, which) / slope.value,
                             missing / slope.value**2 * getattr(slope, which)))
              for which in ("error", "error95")]
    return Quantity(Value(middle + missing / slope.value, *errors),
                    how="a straight line through the last quarter", case=case.label)


# ------------------------------------------------------------------------------------------------
# Figs. 9 to 12: how a cell turns


def _body_that_turns(case):
    """The biconcave body of a case, or the only one."""
    cells = [body for body in case.run.bodies if kind_of(case, body).startswith("biconcave")]
    return (cells or case.run.bodies)[0]


@dataclass(frozen=True)
class Tumbling:
    """The tumbles of a body: half turns of its shape, from disc across the flow to disc across the
    flow (a whole turn of a marker takes two).

    `ends`, when they were over, the first number the start of the first; `durations` [W^2/nu],
    Values whose error is the time between two samples; `x` [W], where the body was on average in
    each; or the `reason` why there are none.
    """
    ends: np.ndarray
    durations: list
    x: np.ndarray
    reason: str = ""


def tumbling_periods(case, body=None):
    """The tumbles of a body one by one, as Tumbling."""
    def nothing(reason):
        return Tumbling(np.array([]), [], np.array([]), str(reason))
    body = body or _body_that_turns(case)
    try:
        series = rotation.angles(case.run, body)
        turning = rotation.classify(series, start=series["t"][0])
    except DuctileError as error:
        return nothing(error)
    if "inclination" not in turning.unwrapped:
        return nothing("the body rolls: it has no longest axis in the plane")
    t, angle = turning.t, turning.unwrapped["inclination"]
    progress = (angle - angle[0]) * (1 if angle[-1] >= angle[0] else -1)
    furthest = np.maximum.accumulate(progress)
    count = int(furthest[-1] // 180)
    if count == 0:
        return nothing(f"the shape turns by {furthest[-1]:.0f} degrees, less than half a turn")
    ends = [float(t[0])]
    for turn in 180.0 * np.arange(1, count + 1):
        n = int(np.argmax(furthest >= turn))
        share = (turn - furthest[n - 1]) / (furthest[n] - furthest[n - 1])
        ends.append(float(t[n - 1] + share * (t[n] - t[n - 1])))
    step = float(np.median(np.diff(t)))
    times, x = case.run.series(f"{body}_x")
    durations, places = [], []
    for begin, end in zip(ends, ends[1:]):
        durations.append(Value(end - begin, step, step))
        places.append(float(np.interp(np.linspace(begin, end, 100), times, x).mean()))
    return Tumbling(np.array(ends), durations, np.array(places))


@dataclass(frozen=True)
class Turning:
    """How a body turns from `begin` to `end`: `motion` as rotation.classify() calls it, or None
    with the `reason`; `found`, all of what that found."""
    begin: float
    end: float
    motion: str | None
    reason: str = ""
    found: rotation.Rotation | None = field(repr=False, default=None)


def rotation_kinds(case, body=None, parts=3):
    """How a body turns in so many equal parts of the run: a list of Turning."""
    body = body or _body_that_turns(case)
    try:
        series = rotation.angles(case.run, body)
    except DuctileError as error:
        return [Turning(math.nan, math.nan, None, str(error))]
    ends = np.linspace(series["t"][0], series["t"][-1], parts + 1)
    found = []
    for begin, end in zip(ends, ends[1:]):
        try:
            turning = rotation.classify(series, start=begin, end=end)
            found.append(Turning(float(begin), float(end), turning.motion, "", turning))
        except DuctileError as error:
            found.append(Turning(float(begin), float(end), None, str(error)))
    return found


def wobbles_from(case, body=None):
    """When the tilt of a body first goes beyond 10 degrees [W^2/nu], from which on the axis about
    which it tumbles is not that of the plane y = 0; the error is the time between two samples."""
    body = body or _body_that_turns(case)
    try:
        series = rotation.angles(case.run, body)
    except DuctileError as error:
        return _none(error, case.label)
    t, beyond = series["t"], np.flatnonzero(series["tilt"] > rotation.WOBBLES)
    if len(beyond) == 0:
        return _none(f"the tilt stays below {rotation.WOBBLES:g} degrees, up to t = {t[-1]:.3g}",
                     case.label)
    step = float(np.median(np.diff(t)))
    return Quantity(Value(float(t[beyond[0]]), step, step), how="the tilt's first beyond 10 "
                    "degrees", case=case.label)


@dataclass(frozen=True)
class OutOfPlane:
    """How far a body leaves the plane y = 0: `t`, `y` [W]; `largest`, the largest |y| [W] by its
    samples, `last`, the root mean square of y over the last fifth, with its standard deviation as
    error. `leaves`, whether the last is beyond thrice the start and 0.001 W; None where it cannot
    be known."""
    t: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)
    largest: Quantity
    last: Quantity
    leaves: bool | None


def out_of_plane(case, body=None):
    """How far a body leaves the plane y = 0, as OutOfPlane."""
    body = body or _body_that_turns(case)
    t, y = case.run.series(f"{body}_y")
    if case.parameters.get("channel.symmetry") == "y":
        none = _none("half of the channel was computed, in which nothing leaves the plane",
                     case.label)
        return OutOfPlane(t, y, none, none, None)
    late = np.abs(y[t >= t[-1] - 0.2 * (t[-1] - t[0])])
    size, spread = float(np.sqrt(np.mean(late**2))), float(late.std())
    n = int(np.argmax(np.abs(y)))
    step = float(np.abs(np.diff(y)).max(initial=0.0))
    return OutOfPlane(
        t, y,
        Quantity(Value(float(abs(y[n])), step, step), how=f"at t = {t[n]:.3g}", case=case.label),
        Quantity(Value(size, spread, 2 * spread), how="over the last fifth", case=case.label),
        bool(size > max(3 * abs(y[0]), 1e-3)))


@dataclass(frozen=True)
class MarkerPath:
    """The path of a point of a body's surface, in the frames of a run: `t` [W^2/nu], `marker` and
    `centre`, the volume's centroid, [W], arrays (n, 3) of x, y, z with z not wrapped; `vertex`, its
    number in the mesh."""
    t: np.ndarray
    marker: np.ndarray = field(repr=False)
    centre: np.ndarray = field(repr=False)
    vertex: int

    @property
    def relative(self):
        """The marker's place relative to the centre [W]."""
        return self.marker - self.centre

    @property
    def from_midplane(self):
        """|y| of the marker [W], its distance from the midplane of the channel."""
        return np.abs(self.marker[:, 1])


def rim_vertex(vertices, centre):
    """The vertex on a body's rim in the midplane y = y_c: of those near that plane the one furthest
    from the centre, on the side of the larger x where there are two."""
    apart = np.asarray(vertices) - centre
    near = np.sqrt(4 * np.pi / len(apart)) * np.abs(apart).max() / 2
    far = np.hypot(apart[:, 0], apart[:, 2])
    far = np.where(np.abs(apart[:, 1]) <= near, far, -np.inf)
    # Vertices of a symmetric mesh are as far but for round-off.
    rim = np.flatnonzero(far >= far.max() * (1 - 1e-6))
    return int(rim[np.argmax(apart[rim, 0])])


def marker_path(case, body=None, frames=None):
    """The path of a marker that starts on the rim of a body, in the midplane (Fig. 12), in all
    frames or in those, as MarkerPath. Raises DuctileError for a run without surfaces."""
    body = body or _body_that_turns(case)
    first = case.run.surfaces(0)[body]
    vertex = rim_vertex(first.vertices,
                        rotation.second_moments(first.vertices, first.triangles).centroid)
    t, markers, centres = [], [], []
    for number in range(len(case.run.times)) if frames is None else frames:
        surface = case.run.surfaces(number)[body]
        centre = rotation.second_moments(surface.vertices, surface.triangles).centroid
        t.append(surface.time)
        markers.append(surface.vertices[vertex])
        centres.append(centre)
    return MarkerPath(np.array(t), np.array(markers), np.array(centres), vertex)


# ------------------------------------------------------------------------------------------------
# Sections of surfaces


def section(vertices, triangles, through=(0.0, 0.0, 0.0), normal=(0.0, 1.0, 0.0)):
    """The lines in which a closed surface of triangles meets a plane: a list of closed polygons,
    arrays (n, 3) [W] of which the first point is the last as well, the longest first.

    Every triangle that the plane cuts gives a straight piece, from edge to edge; pieces are linked
    by the edges that they share. A vertex in the plane counts as above it.
    """
    vertices, triangles = np.asarray(vertices, float), np.asarray(triangles)
    height = (vertices - np.asarray(through)) @ (np.asarray(normal, float)
                                                 / np.linalg.norm(normal))
    above = height >= 0
    links = {}
    for triangle in triangles[(above[triangles].sum(axis=1) % 3) != 0]:
        ends = [tuple(sorted((int(a), int(b)))) for a, b in zip(triangle, np.roll(triangle, -1))
                if above[a] != above[b]]
        for one, other in (ends, ends[::-1]):
            links.setdefault(one, []).append(other)
    points = {}
    for a, b in links:
        share = height[a] / (height[a] - height[b])
        points[a, b] = vertices[a] + share * (vertices[b] - vertices[a])
    loops = []
    while links:
        at = next(iter(links))
        loop, first = [at], at
        while True:
            onward = next((edge for edge in links.pop(at, []) if edge in links), None)
            if onward is None:
                break
            at = onward
            loop.append(at)
        loops.append(np.array([points[edge] for edge in [*loop, first]]))
    return sorted(loops, key=lambda loop: -np.linalg.norm(np.diff(loop, axis=0), axis=1).sum())


def outline(case, body=None, frame=-1, normal=(0.0, 1.0, 0.0)):
    """The outline of a body in a frame, cut by the plane through the channel's axis with that
    normal: (time, centre, polygons), the centre an array (3,). Raises DuctileError for a run
    without surfaces."""
    body = body or _body_that_turns(case)
    surface = case.run.surfaces(frame)[body]
    centre = rotation.second_moments(surface.vertices, surface.triangles).centroid
    return surface.time, centre, section(surface.vertices, surface.triangles, normal=normal)


# ------------------------------------------------------------------------------------------------
# Figs. 14 and 15


def diagonal_path(case):
    """t [W^2/nu] and the distance from the axis along the diagonal, sqrt(x^2 + y^2) [W]."""
    body = case.run.bodies[0]
    t, x = case.run.series(f"{body}_x")
    return t, np.hypot(x, case.run.series(f"{body}_y")[1])


def diagonal_equilibrium(study, method, nodes=None):
    """Where the capsule of Fig. 14 settles on the diagonal, sqrt(x^2 + y^2) [W]."""
    case = only_case(study, "diagonal", method, nodes)
    return _of(case, level(*diagonal_path(case))) if case else _missing("the capsule of Fig. 14")


def rectangular_equilibrium(study, nodes=None):
    """Where the distance of the rigid pair of Fig. 15 comes to, dz/a, by _level_of_dz()."""
    case = only_case(study, "rectangular", "clean", nodes)
    if case is None:
        return _missing("the pair of Fig. 15")
    found = _of(case, _level_of_dz(case))
    if not found.known:
        return found
    radius = case.start("lead", "radius")
    swing = None if found.swing is None else found.swing / radius
    return replace(found, value=scaled(found.value, 1 / radius), swing=swing)


# ------------------------------------------------------------------------------------------------
# Strain that the lattice cannot see


@dataclass(frozen=True)
class StrainEnergy:
    """The strain energy of a capsule against time [k_s a^2]: `t`, `energy`; `last`, the mean of the
    last quarter of the time, with the standard deviation of its samples as error; `growth`, the
    rate of its logarithm over the later half [nu/W^2]; `settled`, whether the program says that it
    has, None where it does not say."""
    t: np.ndarray = field(repr=False)
    energy: np.ndarray = field(repr=False)
    last: Quantity
    growth: Quantity
    settled: bool | None


def strain_energy_history(case):
    """The strain energies of a case's capsules, {body: StrainEnergy}; rigid bodies have none."""
    found = {}
    for body in case.run.bodies:
        if f"{body}_strain_energy" not in case.run.units:
            continue
        t, energy = case.run.series(f"{body}_strain_energy")
        late = energy[t >= t[-1] - 0.25 * (t[-1] - t[0])]
        spread = float(late.std())
        last = Quantity(Value(float(late.mean()), spread, 2 * spread),
                        how="mean of the last quarter", case=case.label)
        own = next((own for own in case.summary.get("bodies", []) if own.get("name") == body), {})
        found[body] = StrainEnergy(t, energy, last, _growth(case, t, energy),
                                   own.get("strain_energy_settled"))
    return found


def _growth(case, t, energy):
    late = t >= 0.5 * (t[0] + t[-1])
    if not np.all(energy[late] > 0):
        return _none("the strain energy is zero", case.label)
    try:
        return Quantity(fit_line(t[late], np.log(energy[late])).slope,
                        how="a line through its logarithm, over the later half", case=case.label)
    except DuctileError as error:
        return _none(error, case.label)
