"""What the paper's text says in words, decided from the runs.

Each function decorated with @statement decides one of them for one method: it gives a Finding, or
raises Missing where the runs that it needs have not been computed, and DuctileError where they do
not tell. What a decision takes is said in its own text, with the numbers.
"""
from dataclasses import dataclass

import numpy as np

from ..errors import DuctileError
from . import quantities
from .study import METHODS, PAIRS, X_LAGS

BOUND = ("stable", "damped", "bounded")
CENTRE = 0.05  # W: as near to the axis counts as at it, coarse lattices being wrong by as much
NEAR = 0.3     # W: by as much dz may differ from its start and still be "close" to it
VERY_NEAR = 0.15  # W: the same of "very close"
ALIKE = 0.2    # of growing distances that are said to grow alike: by this part they may differ

OPPOSITE, SAME = (-0.4, -0.2), (0.2, 0.4)


class Missing(DuctileError):
    """The cases that a statement is about have not been computed."""


@dataclass(frozen=True)
class Finding:
    """Whether the runs of a method confirm a statement, in what words, and which they are."""
    confirmed: bool
    said: str
    cases: tuple = ()


@dataclass(frozen=True)
class Statement:
    """What the paper says: `name`, `figure` ("fig7") or None, `source`, and its words; `decide`
    takes a study and a method. `rigid`, whether it is of rigid bodies, which are computed once."""
    name: str
    figure: str | None
    source: str
    says: str
    decide: object
    rigid: bool


STATEMENTS = []
_CALLED = {"clean": "the clean method", "paper": "the paper's method"}


def statement(name, figure, source, says, rigid=False):
    def keep(decide):
        STATEMENTS.append(Statement(name, figure, source, says, decide, rigid))
        return decide
    return keep


def decided(one, study):
    """The statement with its outcome: a dict of the report, whose schema report.py has."""
    found, undecided = {}, {}
    for method in METHODS[:1] if one.rigid else METHODS:
        try:
            found[method] = one.decide(study, method)
        except Missing:
            continue
        except DuctileError as error:
            undecided[method] = str(error).replace(f"{study.directory}/", "")
    outcomes = {finding.confirmed for finding in found.values()}
    outcome = ("depends on the method" if len(outcomes) == 2 else
               "confirmed" if outcomes == {True} else "not confirmed" if outcomes == {False} else
               "undecided" if undecided else "not computed")
    texts = [("" if one.rigid else f"By {_CALLED[method]}: ") + (
        found[method].said if method in found else f"undecided: {undecided[method]}.")
        for method in METHODS if method in found or method in undecided]
    ours = "; ".join(("" if one.rigid else f"by {_CALLED[method]}: ")
                     + ("yes" if finding.confirmed else "no")
                     for method, finding in found.items())
    return {"id": one.name, "figure": one.figure, "source": one.source, "says": one.says,
            "ours": ours, "outcome": outcome, "evidence": " ".join(texts),
            "cases": list(dict.fromkeys(case for finding in found.values()
                                        for case in finding.cases))}


# ------------------------------------------------------------------------------------------------
# What the decisions are made of


def _pair(study, pair, x_lag, method):
    case = study.pair(pair, x_lag, method)
    if case is None:
        raise Missing(f"{quantities.pair_name(pair, x_lag)} has not been computed")
    return case


def _whole(case):
    """The case, if it has come to an end that says something of the physics."""
    status = case.summary.get("status")
    if not case.ended:
        raise DuctileError(f"{case.label} has not ended")
    if status in ("blew up", "contact"):
        raise DuctileError(f"{case.label}: "
                           + ("the run blew up" if status == "blew up" else "surfaces crossed"))
    return case


def _whole_pair(study, pair, x_lag, method):
    return _whole(_pair(study, pair, x_lag, method))


def _single(study, kind, start, method):
    case = quantities.single_case(study, kind, start, method)
    if case is None:
        raise Missing(f"{kind} from {start:g} has not been computed")
    return _whole(case)


def _only(study, campaign, method):
    case = quantities.only_case(study, campaign, method)
    if case is None:
        raise Missing(f"the case of {campaign} has not been computed")
    return _whole(case)


def _verdict(study, pair, x_lag, method):
    """Whether a pair stays together, None while that is undecided; its verdict, and its case."""
    found = quantities.class_of(_pair(study, pair, x_lag, method), pair, x_lag)
    if found.verdict in (None, "undecided"):
        return None, "undecided", found.case
    return found.verdict in BOUND, found.verdict, found.case


def _verdicts(study, pair, method, x_lags=X_LAGS):
    """(whether bound by x_lag, "-0.4 stable, ...", the cases)."""
    found = {x_lag: _verdict(study, pair, x_lag, method) for x_lag in x_lags}
    said = f"{pair}: " + ", ".join(f"{x_lag:g} {verdict}"
                                   for x_lag, (_, verdict, _) in found.items())
    return ({x_lag: bound for x_lag, (bound, _, _) in found.items()}, said,
            tuple(case for _, _, case in found.values()))


def _agree(found, expected, said):
    """Whether all that is found is as expected; None, undecided, among what is found leaves it open
    unless another is contrary, and then DuctileError is raised."""
    if any(value is not None and value != expected[key] for key, value in found.items()):
        return False
    if any(value is None for value in found.values()):
        raise DuctileError(said)
    return True


def _bound_from(x_lags):
    return {x_lag: x_lag in x_lags for x_lag in X_LAGS}


def _last(case, body, axis="x"):
    return float(case.run.series(f"{body}_{axis}")[1][-1])


def _at(case, column, time):
    """A column's value at a time. Raises DuctileError if the run ended before."""
    t, values = case.run.series(column)
    if t[-1] < time - 1e-6:
        raise DuctileError(f"{case.label} ends at t = {t[-1]:.3g}, before {time:g}")
    return float(np.interp(time, t, values))


def _known(quantity, what):
    if not quantity.known:
        raise DuctileError(f"{what}: {quantity.reason}")
    return quantity.value


def _distance(study, pair, x_lag, method):
    """dz_eq of a pair that stays together."""
    case = _pair(study, pair, x_lag, method)
    return _known(quantities.equilibrium_distance(case, pair, x_lag),
                  quantities.pair_name(pair, x_lag))


def _numbers(values, form="{:.3g}"):
    return ", ".join(f"{x_lag:g}: {form.format(value)}" for x_lag, value in values.items())


# ------------------------------------------------------------------------------------------------
# Section 3: the map


@statement("stiffer", "fig4", "section 3, abstract",
           "Stable pairs become unstable when the stiffness of the particles is increased.")
def _stiffer(study, method):
    bounds, said, cases = [], [], ()
    for pair in ("M1", "M2", "M3"):
        bound, text, own = _verdicts(study, pair, method)
        bounds.append(bound)
        said.append(text)
        cases += own
    text = "; ".join(said) + "."
    # No pair that has parted is bound again where it is stiffer, and some that are bound part.
    for soft, stiff in zip(bounds, bounds[1:]):
        if any(soft[x] is False and stiff[x] for x in X_LAGS):
            return Finding(False, text, cases)
    if any(None in bound.values() for bound in bounds):
        raise DuctileError(text)
    return Finding(sum(bounds[0].values()) > sum(bounds[2].values()), text, cases)


@statement("same-half", "fig4", "section 3, abstract",
           "A pair with both particles in the same half of the channel is more prone to become "
           "unstable than one with particles in opposite halves.")
def _same_half(study, method):
    known = {side: [_verdict(study, pair, x_lag, method)[0] for pair in PAIRS for x_lag in side]
             for side in (OPPOSITE, SAME)}
    parted = {side: own.count(False) for side, own in known.items()}
    unknown = {side: own.count(None) for side, own in known.items()}
    said = (f"of 14 pairs each {parted[SAME]} part that start in the same half, "
            f"{parted[OPPOSITE]} that start in opposite ones; {unknown[SAME]} and "
            f"{unknown[OPPOSITE]} are undecided.")
    surely = parted[SAME] > parted[OPPOSITE] + unknown[OPPOSITE]
    if not surely and parted[SAME] + unknown[SAME] > parted[OPPOSITE]:
        raise DuctileError(said)
    return Finding(surely, said)


@statement("symmetric", "fig4", "section 3",
           "From symmetric places, x_lead = -x_lag = 0.2, a pair is stable, whatever its type.")
def _symmetric(study, method):
    found = {pair: _verdict(study, pair, -0.2, method) for pair in PAIRS}
    said = ", ".join(f"{pair} {verdict}" for pair, (_, verdict, _) in found.items()) + "."
    return Finding(_agree({pair: bound for pair, (bound, _, _) in found.items()},
                          dict.fromkeys(PAIRS, True), said),
                   said, tuple(case for _, _, case in found.values()))


@statement("m1-stable", "fig4", "section 3",
           "The soft pair M1 is stable from wherever it starts, and comes to the centre.")
def _m1_stable(study, method):
    bound, said, cases = _verdicts(study, "M1", method)
    ends = {x_lag: max(abs(_last(_pair(study, "M1", x_lag, method), body))
                       for body in ("lead", "lag")) for x_lag in X_LAGS}
    return Finding(_agree(bound, _bound_from(X_LAGS), said) and max(ends.values()) < CENTRE,
                   f"{said}; the larger |x| at the end is {_numbers(ends)} W, to be below "
                   f"{CENTRE:g}.", cases)


@statement("m2-transition", "fig4", "section 3",
           "The pair M2 is stable from opposite halves, unstable from the same half, and damped "
           "oscillations lie between, at x_lag = 0.")
def _m2_transition(study, method):
    bound, said, cases = _verdicts(study, "M2", method)
    as_said = _agree(bound, _bound_from((*OPPOSITE, 0.0)), said)
    return Finding(as_said and _verdict(study, "M2", 0.0, method)[1] == "damped", said + ".", cases)


@statement("m3-symmetric", "fig4", "sections 3 and 3.1.2",
           "Of the rigid pairs M3 only the symmetric one is stable.", rigid=True)
def _m3_symmetric(study, method):
    bound, said, cases = _verdicts(study, "M3", method)
    return Finding(_agree(bound, _bound_from((-0.2,)), said), said + ".", cases)


# ------------------------------------------------------------------------------------------------
# Section 3.1.1: single particles


@statement("la10-centre", "fig5", "section 3.1.1",
           "A soft sphere settles at the centre of the channel, wherever it starts.")
def _la10_centre(study, method):
    cases = [_single(study, "sphere-La10", start, method) for start in quantities.STARTS]
    ends = {case.start("particle"): abs(_last(case, "particle")) for case in cases}
    return Finding(max(ends.values()) < CENTRE,
                   f"|x| at the end, by the start: {_numbers(ends)} W, to be below {CENTRE:g}.",
                   tuple(case.label for case in cases))


@statement("softer-inside", "fig5", "section 3",
           "Softer particles are located closer to the channel's centre.")
def _softer_inside(study, method):
    places, cases = {}, ()
    for kind in ("sphere-La10", "sphere-La100", "rigid"):
        case = _single(study, kind, 0.2, method)
        places[kind] = abs(_known(quantities.equilibrium(case), case.label).value)
        cases += (case.label,)
    values = list(places.values())
    return Finding(values[0] < values[1] < values[2], "|x| comes to " + ", ".join(
        f"{value:.3f} W ({kind})" for kind, value in places.items()) + ".", cases)


@statement("shapes", "fig5", "section 3.1.1, inset of Fig. 5",
           "A soft sphere becomes a bullet, a stiff one stays nearly spherical.")
def _shapes(study, method):
    cases = {kind: _single(study, kind, 0.2, method) for kind in ("sphere-La10", "sphere-La100")}
    soft, stiff = (float(case.run.series("particle_deformation")[1][-1])
                   for case in cases.values())
    asymmetry = {kind: _fore_aft(case) for kind, case in cases.items()}
    text = ", ".join(f"{kind.split('-')[1]} {value:.3f}" for kind, value in asymmetry.items())
    bullet = abs(asymmetry["sphere-La10"]) > max(0.1, 2 * abs(asymmetry["sphere-La100"]))
    return Finding(bullet and stiff < 0.05,
                   f"Taylor deformation at the end {soft:.3f} and {stiff:.3f} (to be below 0.05); "
                   f"skewness along the flow of the surface's vertices {text} (that of the soft one "
                   "is to be above 0.1).",
                   tuple(case.label for case in cases.values()))


def _fore_aft(case):
    """The skewness along the flow of the places of a surface's vertices, 0 of what is the same
    fore and aft, in the last frame."""
    surface = case.run.surfaces(-1)[case.run.bodies[0]]
    z = surface.vertices[:, 2] - surface.vertices[:, 2].mean()
    return float((z**3).mean() / (z**2).mean()**1.5)


# ------------------------------------------------------------------------------------------------
# Section 3.1.2: mono-dispersed pairs


@statement("m1-nearly-constant", "fig6", "section 3.1.2",
           "For x_lag = 0 and -0.2 the particles of M1 migrate with nearly constant axial "
           "distance.")
def _m1_nearly_constant(study, method):
    changes = {}
    for x_lag in X_LAGS:
        t, dz = _whole_pair(study, "M1", x_lag, method).run.series("dz")
        changes[x_lag] = float(np.abs(dz - dz[0]).max())
    calm = max(changes[0.0], changes[-0.2])
    return Finding(calm < NEAR and calm < min(changes[x] for x in (-0.4, 0.2, 0.4)),
                   f"largest change of dz by x_lag: {_numbers(changes)} W; it is to be below "
                   f"{NEAR:g} W for 0 and -0.2, and larger for the others.")


@statement("m1-push", "fig6", "section 3.1.2",
           "From the same streamline, x_lag = 0.2, the leading soft particle is pushed strongly "
           "towards the centre: it comes near to it in a very short time, and takes longer to "
           "reach it fully.")
def _m1_push(study, method):
    pair = _whole_pair(study, "M1", 0.2, method)
    single = _single(study, "sphere-La10", 0.2, method)
    times = [_time_within(case, body, CENTRE) for case, body in ((pair, "lead"),
                                                                 (single, "particle"))]
    return Finding(times[0] < 0.5 * times[1],
                   f"the leader is first within {CENTRE:g} W of the centre at t = {times[0]:.3g}, "
                   f"a single sphere at {times[1]:.3g}; it is to take less than half as long.",
                   (pair.label, single.label))


def _time_within(case, body, distance):
    """When a body is first so near to the axis. Raises DuctileError if it never is."""
    t, x = case.run.series(f"{body}_x")
    near = np.flatnonzero(np.abs(x) < distance)
    if not len(near):
        raise DuctileError(f"{case.label}: {body} does not come to within {distance:g} W of the "
                           "centre")
    return float(t[near[0]])


def _grown_alike(grown):
    """Whether two distances have grown by the same, within ALIKE."""
    if min(abs(value) for value in grown.values()) < 1e-6:
        raise DuctileError("a distance has not grown at all")
    first, second = grown.values()
    return abs(first / second - 1) < ALIKE


@statement("m1-same-growth", "fig6", "section 3.1.2",
           "At first the axial distance grows at the same rate for x_lag = 0.4 and -0.4.")
def _m1_same_growth(study, method):
    cases = {x_lag: _pair(study, "M1", x_lag, method) for x_lag in (-0.4, 0.4)}
    grown = {x_lag: _at(case, "dz", 1.0) - _at(case, "dz", 0.0) for x_lag, case in cases.items()}
    return Finding(_grown_alike(grown),
                   f"dz has grown at t = 1 by {_numbers(grown)} W; they are to be the same within "
                   f"{ALIKE:.0%}.", tuple(case.label for case in cases.values()))


@statement("fig7-lead", "fig7", "section 3.1.2, Fig. 7",
           "The lagging particle slows the migration of the leading one for x_lag = 0.4 and -0.4, "
           "and makes it faster for the three other starts.")
def _fig7_lead(study, method):
    return _fig7(study, method, "lead")


@statement("fig7-lag", "fig7", "section 3.1.2, Fig. 7",
           "The lagging particle migrates faster than a single one where it starts in the other "
           "half, and slower where both start in the same half.")
def _fig7_lag(study, method):
    return _fig7(study, method, "lag")


def _fig7(study, method, body):
    for x_lag in X_LAGS:
        _whole_pair(study, "M1", x_lag, method)
    for start in quantities.STARTS:
        _single(study, "sphere-La10", start, method)
    found = quantities.migration_ratios(study, method)
    ratios, cases, right = {}, (), True
    for x_lag, expected in quantities.MIGRATES[body].items():
        own = found[x_lag][body]
        ratio = _known(own.ratio, f"x_lag = {x_lag:g}")
        ratios[x_lag] = str(ratio) + (" (extrapolated)" if own.extrapolated else "")
        if abs(ratio.value - 1) <= ratio.error95:
            raise DuctileError(f"x_lag = {x_lag:g}: {ratio} cannot be told from 1")
        right &= (ratio.value > 1) == (expected == "slower")
        cases += (own.pair.case,)
    return Finding(right, "t_pair/t_single by x_lag: " + _numbers(ratios, "{}") + ".", cases)


@statement("m2-push", "fig6", "section 3.1.2",
           "For x_lag = 0.2 the lagging particle of M2 pushes the leading one towards the centre, "
           "and the pair parts.")
def _m2_push(study, method):
    case = _whole_pair(study, "M2", 0.2, method)
    bound, verdict, label = _verdict(study, "M2", 0.2, method)
    nearest = float(np.abs(case.run.series("lead_x")[1]).min())
    return Finding(nearest < 0.1 and _agree({0.2: bound}, {0.2: False}, label),
                   f"the leader comes to |x| = {nearest:.3f} W, which "
                   f"is to be below 0.1; the pair is {verdict}.", (label,))


@statement("m2-leader", "fig6", "section 3.1.2",
           "The leading particle of M2, x_lag = 0.2, then migrates to the centre.")
def _m2_leader(study, method):
    case = _whole_pair(study, "M2", 0.2, method)
    t, x = case.run.series("lead_x")
    later = x[t >= 0.75 * t[-1]]
    inward = abs(later[-1]) < abs(later[0])
    return Finding(bool(inward and abs(x[-1]) < 0.1),
                   f"over the last quarter of the run, to t = {t[-1]:.3g}, its x goes from "
                   f"{later[0]:.3f} to {later[-1]:.3f} W." + _strain(case, "lead"), (case.label,))


@statement("second-stable", "artefact", "section 3.1.2",
           "Continued alone from x = 0.055, the leader of M2 migrates to the centre, a second "
           "stable position, instead of going back to x = 0.3. (Ours is released there undeformed.)")
def _second_stable(study, method):
    case = quantities.released_case(study, method)
    if case is None:
        raise Missing("the capsule released near to the centre has not been computed")
    t, x = _whole(case).run.series("particle_x")
    said = (f"at {case.nodes} nodes it goes from {x[0]:.3f} to {x[-1]:.3f} W by t = {t[-1]:.3g}."
            + _strain(case, "particle"))
    if 0.5 * abs(x[0]) <= abs(x[-1]) <= abs(x[0]):
        raise DuctileError(said)
    return Finding(bool(abs(x[-1]) < abs(x[0])), said, (case.label,))


def _strain(case, body):
    """A sentence on a capsule's strain energy."""
    own = quantities.strain_energy_history(case).get(body)
    if own is None:
        return ""
    state = {True: "has settled", False: "has not settled"}.get(own.settled, "")
    t, energy = own.t, own.energy
    half = float(np.interp(0.5 * t[-1], t, energy))
    said = f" Its strain energy is {half:.2g} k_s a^2 half-way and {energy[-1]:.2g} at the end"
    return said + (f": it {state}." if state else ".")


@statement("m2-opposite", "fig6", "section 3.1.2",
           "For x_lag = -0.4 the pair M2 is stable, with a larger axial distance than M1; for "
           "-0.2 its distance stays close to the start.")
def _m2_opposite(study, method):
    bound, said, cases = _verdicts(study, "M2", method, OPPOSITE)
    if not _agree(bound, dict.fromkeys(OPPOSITE, True), said):
        return Finding(False, said + ".", cases)
    far = [_distance(study, pair, -0.4, method).value for pair in ("M1", "M2")]
    near = _distance(study, "M2", -0.2, method).value
    return Finding(far[1] > far[0] and abs(near - 1) < NEAR,
                   f"{said}; dz comes to {far[1]:.3g} W for -0.4, {far[0]:.3g} W of M1, and to "
                   f"{near:.3g} W for -0.2.", cases)


@statement("m2-damped", "fig8", "section 3.1.2",
           "The damped oscillations of M2, x_lag = 0 to -0.15, all end at a distance very close "
           "to the initial one.")
def _m2_damped(study, method):
    found = _damped(study, method)
    ends = {x: _known(own.equilibrium, f"x_lag = {x:g}").value for x, own in found.items()}
    turns = {x: len(quantities.extrema(*case.run.series("dz"), quantities.TURN))
             for x, case in ((x, quantities.damped_case(study, x, method)) for x in found)}
    return Finding(all(abs(end - 1) < VERY_NEAR for end in ends.values())
                   and min(turns.values()) >= 2,
                   f"dz_eq by x_lag: {_numbers(ends)} W, to be within {VERY_NEAR:g} W of 1; dz "
                   f"turns {_numbers(turns)} times, two at least.",
                   tuple(own.case for own in found.values()))


@statement("fig8-amplitude", "fig8", "section 3.1.2, Fig. 8a",
           "The largest amplitude of the damped oscillations falls as the lagging particle starts "
           "further from the centre, x_lag = 0, -0.05, -0.1, -0.15.")
def _fig8_amplitude(study, method):
    found = _damped(study, method)
    tops = {x: _known(own.maximum, f"x_lag = {x:g}").value for x, own in found.items()}
    values = list(tops.values())
    return Finding(all(a > b for a, b in zip(values, values[1:])),
                   f"max(dz) by x_lag: {_numbers(tops)} W.",
                   tuple(own.case for own in found.values()))


@statement("fig8-damping", "fig8", "section 3.1.2, Fig. 8b",
           "From x_lag = 0 to -0.15 the damping rate first does not vary much, and then increases "
           "sharply.")
def _fig8_damping(study, method):
    found = _damped(study, method)
    rates = {x: _known(own.damping, f"x_lag = {x:g}") for x, own in found.items()}
    rate = list(rates.values())
    first = max(rate[:2], key=lambda one: one.value)
    apart = rate[-1].value - 1.3 * first.value
    said = ("zeta by x_lag: " + _numbers(rates, "{}") + " nu/W^2; the last is to be 1.3 times that "
            "of the first two.")
    if abs(apart) <= float(np.hypot(rate[-1].error95, 1.3 * first.error95)):
        raise DuctileError(said)
    return Finding(bool(apart > 0), said,
                   tuple(own.case for own in found.values()))


def _damped(study, method):
    found = quantities.damped_oscillations(study, method)
    if len(found) < len(quantities.DAMPED_X_LAGS):
        raise Missing("not all of Fig. 8 has been computed")
    for x_lag in found:
        _whole(quantities.damped_case(study, x_lag, method))
    return dict(sorted(found.items(), reverse=True))


@statement("m3-grows", "fig6", "section 3.1.2",
           "The distance of the symmetric rigid pair does not stay constant: it grows until the "
           "spheres have come to their lateral places.", rigid=True)
def _m3_grows(study, method):
    case = _whole_pair(study, "M3", -0.2, method)
    end = _distance(study, "M3", -0.2, method).value
    t, dz = case.run.series("dz")
    x = np.abs(case.run.series("lead_x")[1])
    settled = t[np.flatnonzero(np.abs(x - x[-1]) > 0.02)[-1]] if np.ptp(x) > 0.02 else t[0]
    later = float(np.ptp(dz[t >= settled]))
    return Finding(end > dz[0] + 0.1 and later < 0.1,
                   f"dz grows from {dz[0]:.3g} to {end:.3g} W, and changes by {later:.3g} after "
                   f"the leader is within 0.02 W of its place at t = {settled:.3g} (to be below "
                   "0.1).", (case.label,))


@statement("m3-same-growth", "fig6", "section 3.1.2",
           "For x_lag = 0.4 and -0.4 the distance of the rigid pair increases alike over the whole "
           "time.", rigid=True)
def _m3_same_growth(study, method):
    cases = {x_lag: _whole_pair(study, "M3", x_lag, method) for x_lag in (-0.4, 0.4)}
    end = min(float(case.run.series("t")[0][-1]) for case in cases.values())
    grown = {x: _at(case, "dz", end) - _at(case, "dz", 0.0) for x, case in cases.items()}
    halfway = {x: _at(case, "dz", end / 2) - _at(case, "dz", 0.0) for x, case in cases.items()}
    return Finding(_grown_alike(halfway) and _grown_alike(grown),
                   f"by t = {end / 2:.3g} it has grown by {_numbers(halfway)} W, by {end:.3g} by "
                   f"{_numbers(grown)} W; they are to be the same within {ALIKE:.0%}.",
                   tuple(case.label for case in cases.values()))


# ------------------------------------------------------------------------------------------------
# Section 3.2.1: single cells


@statement("cell-place", "fig9", "section 3.2.1",
           "A biconcave cell migrates to a place very close to that of a sphere of the same "
           "softness; the soft one does not fully reach the centre.")
def _cell_place(study, method):
    places, cases = {}, ()
    for softness in ("La10", "La100"):
        for shape in ("sphere", "biconcave"):
            case = _single(study, f"{shape}-{softness}", 0.2, method)
            places[shape, softness] = _known(quantities.equilibrium(case), case.label).value
            cases += (case.label,)
    apart = {softness: abs(abs(places["biconcave", softness]) - abs(places["sphere", softness]))
             for softness in ("La10", "La100")}
    t, x = _single(study, "biconcave-La10", 0.2, method).run.series("particle_x")
    late = float(np.abs(x[t >= 0.8 * t[-1]]).mean())
    return Finding(max(apart.values()) < CENTRE and late > 1e-3,
                   "the cell's x is " + ", ".join(
                       f"{places['biconcave', own]:.3f} W at {own} where the sphere's is "
                       f"{places['sphere', own]:.3f}" for own in apart) +
                   f"; they are to be within {CENTRE:g} W. The soft cell's |x| is {late:.3f} W "
                   "over the last fifth.", cases)


@statement("cell-slower", "fig9", "section 3.2.1",
           "The soft cell migrates significantly slower than the soft sphere.")
def _cell_slower(study, method):
    cell, sphere = (_single(study, kind, 0.2, method) for kind in ("biconcave-La10",
                                                                  "sphere-La10"))
    t, x = cell.run.series("particle_x")
    late = float(np.abs(x[t >= 0.8 * t[-1]]).mean())
    if late > 0.5 * abs(x[0]):
        return Finding(False, f"the cell does not migrate: by t = {t[-1]:.3g} its |x| is "
                       f"{late:.3f} W on average over the last fifth.", (cell.label, sphere.label))
    half = 0.5 * abs(float(x[0]))
    times = [_time_within(case, "particle", half) for case in (cell, sphere)]
    return Finding(times[0] > 1.5 * times[1],
                   f"the cell has come half-way at t = {times[0]:.3g}, the sphere at "
                   f"{times[1]:.3g}; it is to take half as long again.", (cell.label, sphere.label))


@statement("cell-tumbles", "fig10", "section 3.2.1",
           "The stiff cell tumbles in the plane y = 0, like a solid body.")
def _cell_tumbles(study, method):
    case = _single(study, "biconcave-La100", 0.2, method)
    kinds = _kinds(case)
    return Finding(all(kind == "tumbling" for kind in kinds),
                   f"by thirds of the run it is {', '.join(kinds)}.", (case.label,))


def _wobbles(case):
    """Whether the axis of a cell tilts out of the plane and the cell wobbles, in a third of its run.
    Raises DuctileError where it tilts and none of the thirds counts as wobbling."""
    tilts = quantities.wobbles_from(case).known
    kinds = _kinds(case) if tilts else []
    if tilts and "wobbling" not in kinds:
        raise DuctileError(f"{case.label}: its axis tilts by 10 degrees, but by thirds of the run it "
                           f"is {', '.join(kinds)}")
    return tilts


def _kinds(case):
    """How a cell turns in thirds of its run."""
    found = quantities.rotation_kinds(case)
    for turning in found:
        if turning.motion is None:
            raise DuctileError(turning.reason)
    return [turning.motion for turning in found]


@statement("cell-period", "fig10", "section 3.2.1",
           "As the soft cell comes nearer to the centre the period of its tumbling grows.")
def _cell_period(study, method):
    case = _single(study, "biconcave-La10", 0.2, method)
    found = quantities.tumbling_periods(case)
    if len(found.durations) < 3:
        raise DuctileError(f"{case.label}: {found.reason or 'fewer than three tumbles'}")
    first, last = found.durations[0].value, found.durations[-1].value
    return Finding(bool(last > 1.1 * first and abs(found.x[-1]) < abs(found.x[0])),
                   f"the first tumble takes {first:.3g} W^2/nu at x = {found.x[0]:.3f}, the last "
                   f"of {len(found.durations)} {last:.3g} at {found.x[-1]:.3f} W.", (case.label,))


@statement("cell-lifts", "fig9", "section 3.2.1, inset of Fig. 9",
           "The soft cell leaves the midplane y = 0, and its tumbling turns to wobbling.")
def _cell_lifts(study, method):
    case = _single(study, "biconcave-La10", 0.2, method)
    leaves, said = _lifted(case)
    return Finding(leaves and _wobbles(case), said, (case.label,))


def _lifted(case):
    away = quantities.out_of_plane(case)
    if away.leaves is None:
        raise DuctileError(away.largest.reason)
    wobbling = quantities.wobbles_from(case)
    said = (f"|y| comes to {away.largest.value.value:.4f} W ({away.largest.how}) and is "
            f"{away.last.value.value:.4f} over the last fifth, from a start at "
            f"{abs(away.y[0]):.4f}; ")
    said += (f"its axis is tilted by 10 degrees from t = {wobbling.value.value:.3g}."
             if wobbling.known else f"{wobbling.reason}.")
    return bool(away.leaves), said


# ------------------------------------------------------------------------------------------------
# Section 3.2.2: bi-dispersed pairs


@statement("b1-bounded", "fig11", "sections 3 and 3.2.2",
           "The soft pair B1 stays together from wherever it starts, in bounded oscillations.")
def _b1_bounded(study, method):
    bound, said, cases = _verdicts(study, "B1", method)
    if not _agree(bound, _bound_from(X_LAGS), said):
        return Finding(False, said + ".", cases)
    swings = {}
    for x_lag in X_LAGS:
        t, dz = _whole_pair(study, "B1", x_lag, method).run.series("dz")
        swings[x_lag] = 0.5 * float(np.ptp(dz[t >= 0.75 * t[-1]]))
    return Finding(min(swings.values()) > 0.05, f"{said}; over the last quarter dz swings by "
                   f"{_numbers(swings)} W, to be above 0.05.", cases)


@statement("b1-further", "fig11", "section 3.2.2",
           "The axial distance of B1 in its final state is larger than that of M1.")
def _b1_further(study, method):
    bound, said, cases = _verdicts(study, "B1", method)
    if not _agree(bound, _bound_from(X_LAGS), said):
        raise DuctileError(f"not all of the pairs have a final state: {said}")
    late, right = {}, True
    for x_lag in X_LAGS:
        soft, mixed = (_distance(study, pair, x_lag, method).value for pair in ("M1", "B1"))
        late[x_lag] = f"{mixed:.3g} ({soft:.3g})"
        right &= mixed > soft
    return Finding(right, f"dz_eq, in brackets that of M1: {_numbers(late, '{}')} W.", cases)


@statement("b1-lifts", "fig11", "section 3.2.2, inset of Fig. 11",
           "Near the centre the cells of B1 leave the midplane.")
def _b1_lifts(study, method):
    cases = {x_lag: _whole_pair(study, "B1", x_lag, method) for x_lag in X_LAGS}
    found = {x_lag: quantities.out_of_plane(case) for x_lag, case in cases.items()}
    known = {x_lag: away for x_lag, away in found.items() if away.leaves is not None}
    if len(known) < 3:
        raise DuctileError("half of the channel was computed, in which nothing leaves the plane")
    left = [x_lag for x_lag, away in known.items() if away.leaves]
    y = {x_lag: away.last.value.value for x_lag, away in known.items()}
    return Finding(len(left) >= len(known) - 1,
                   f"{len(left)} of the {len(known)} that were computed in the whole channel have "
                   f"(all but one are to); |y| over the last fifth, by x_lag: {_numbers(y)} W.",
                   tuple(cases[x_lag].label for x_lag in known))


@statement("b1-quick", "fig11", "section 3.2.2",
           "From x_lag = -0.2 the cell of B1 migrates very quickly to the centre, unlike a single "
           "one.")
def _b1_quick(study, method):
    pair = _whole_pair(study, "B1", -0.2, method)
    single = _single(study, "biconcave-La10", 0.2, method)
    time = 10.0
    x, alone = abs(_at(pair, "lag_x", time)), abs(_at(single, "particle_x", time))
    return Finding(x < 0.5 * alone, f"at t = {time:g} it is at |x| = {x:.3f}, a single one at "
                   f"{alone:.3f} W; it is to be at less than half.", (pair.label, single.label))


@statement("fig12", "fig12", "section 3.2.2, Fig. 12",
           "The cell of B1, x_lag = 0.2, turns from tumbling in the plane to wobbling.")
def _fig12(study, method):
    case = _whole_pair(study, "B1", 0.2, method)
    if case.parameters.get("channel.symmetry") == "y":
        raise DuctileError("half of the channel was computed, in which nothing wobbles")
    found = quantities.wobbles_from(case)
    kinds = _kinds(case)
    said = f"by thirds of the run it is {', '.join(kinds)}; "
    said += (f"its axis is tilted by 10 degrees from t = {found.value.value:.3g}." if found.known
             else f"{found.reason}.")
    return Finding(_wobbles(case) and kinds[0] == "tumbling", said, (case.label,))


@statement("b1-direct", "fig11", "section 3.2.2",
           "From x_lag = -0.2 the cell of B1 wobbles from the beginning, without tumbling first.")
def _b1_direct(study, method):
    case = _whole_pair(study, "B1", -0.2, method)
    if case.parameters.get("channel.symmetry") == "y":
        raise DuctileError("half of the channel was computed, in which nothing wobbles")
    kinds = _kinds(case)
    return Finding(kinds[0] == "wobbling", f"by thirds of the run it is {', '.join(kinds)}.",
                   (case.label,))


@statement("b2-classes", "fig11", "section 3.2.2",
           "Of the pairs B2 only those from x_lag = -0.4 and -0.2 are stable.")
def _b2_classes(study, method):
    bound, said, cases = _verdicts(study, "B2", method)
    return Finding(_agree(bound, _bound_from(OPPOSITE), said), said + ".", cases)


@statement("b2-modulations", "fig11", "section 3.2.2",
           "The bounded oscillations have vanished at La = 100, but modulations of small amplitude "
           "are visible.")
def _b2_modulations(study, method):
    case = _whole_pair(study, "B2", -0.2, method)
    t, dz = case.run.series("dz")
    late = dz[t >= 0.75 * t[-1]]
    swing = 0.5 * float(np.ptp(late))
    turns = quantities.extrema(t, dz, 0.005)
    return Finding(swing < 0.2 and len(turns) >= 4,
                   f"over the last quarter dz swings by +-{swing:.3g} W about {late.mean():.3g} "
                   f"(to be below 0.2), and turns {len(turns)} times in the run.", (case.label,))


@statement("b2-leader", "fig11", "section 3.2.2",
           "From x_lag = 0 the leading particle of B2 is dragged to the centre, and reaches it.")
def _b2_leader(study, method):
    case = _whole_pair(study, "B2", 0.0, method)
    end = _last(case, "lead")
    return Finding(abs(end) < CENTRE, f"at t = {case.run.series('t')[0][-1]:.3g} it is at x = "
                   f"{end:.3f} W, which is to be below {CENTRE:g}." + _strain(case, "lead"),
                   (case.label,))


@statement("b3-classes", "fig11", "section 3.2.2",
           "The pairs B3 from x_lag = 0 and -0.2 are stable: the soft leader drags the stiffer "
           "particle to the centre. The others are unstable.")
def _b3_classes(study, method):
    bound, said, cases = _verdicts(study, "B3", method)
    ends = {x: abs(_last(_pair(study, "B3", x, method), "lag")) for x in (-0.2, 0.0)}
    return Finding(_agree(bound, _bound_from((-0.2, 0.0)), said) and max(ends.values()) < CENTRE,
                   f"{said}; the stiff one is at |x| = {_numbers(ends)} W at the end, to be below "
                   f"{CENTRE:g}.", cases)


@statement("b3-outside", "fig11", "section 3.2.2",
           "In the unstable pairs B3 the lagging particle migrates to the place off the centre.")
def _b3_outside(study, method):
    cases = {x: _whole_pair(study, "B3", x, method) for x in (-0.4, 0.2, 0.4)}
    ends = {x: abs(_last(case, "lag")) for x, case in cases.items()}
    return Finding(min(ends.values()) > 3 * CENTRE,
                   f"it is at |x| = {_numbers(ends)} W at the end, to be above {3 * CENTRE:g}.",
                   tuple(case.label for case in cases.values()))


@statement("b4-classes", "fig11", "section 3.2.2",
           "Of the pairs B4 only the symmetric one is stable.")
def _b4_classes(study, method):
    bound, said, cases = _verdicts(study, "B4", method)
    return Finding(_agree(bound, _bound_from((-0.2,)), said), said + ".", cases)


@statement("b4-centre", "fig11", "section 3.2.2",
           "The pairs B4 that are not symmetric come to the centre, both particles.")
def _b4_centre(study, method):
    cases = {x: _whole_pair(study, "B4", x, method) for x in (-0.4, 0.0, 0.2, 0.4)}
    ends = {x: max(abs(_last(case, body)) for body in ("lead", "lag"))
            for x, case in cases.items()}
    return Finding(max(ends.values()) < CENTRE,
                   f"the larger |x| at the end is {_numbers(ends)} W, to be below {CENTRE:g}.",
                   tuple(case.label for case in cases.values()))


@statement("b4-swings", "fig11", "section 3.2.2",
           "The symmetric pair B4 oscillates laterally while its distance only fluctuates little "
           "about the initial one.")
def _b4_swings(study, method):
    case = _whole_pair(study, "B4", -0.2, method)
    t, x = case.run.series("lead_x")
    dz = case.run.series("dz")[1]
    turns = len(quantities.extrema(t, x, 0.01))
    change = float(np.abs(dz - dz[0]).max())
    return Finding(turns >= 3 and change < NEAR,
                   f"x of the leader turns {turns} times by 0.01 W or more, and dz is never "
                   f"further than {change:.3g} W from its start (to be below {NEAR:g}).",
                   (case.label,))


# ------------------------------------------------------------------------------------------------
# Section 2.2.2 and Appendix A


@statement("volume", None, "section 2.2.2",
           "The volume of the capsules changes by less than 1%.")
def _volume(study, method):
    errors = {}
    for case in study.all_cases:
        if case.method != method or case.summary.get("status") == "blew up":
            continue
        for body in case.summary.get("bodies", []):
            if body.get("volume_error_max") is not None:
                errors[f"{case.label} {body['name']}"] = body["volume_error_max"]
    if not errors:
        raise Missing("no capsule has been computed")
    worst = max(errors, key=errors.get)
    return Finding(errors[worst] < 0.01, f"of {len(errors)} capsules the largest change is "
                   f"{100 * errors[worst]:.2g}%, of {worst}.")


@statement("fig14", "fig14", "appendix A, Fig. 14",
           "A soft capsule on the diagonal at Re = 100 settles there, away from the centre.")
def _fig14(study, method):
    case = _only(study, "diagonal", method)
    place = _known(quantities.diagonal_equilibrium(study, method), case.label)
    x, y = _last(case, "particle"), _last(case, "particle", "y")
    return Finding(abs(x - y) < 0.01 and place.value > CENTRE,
                   f"it settles at {place} W along the diagonal, x = {x:.4f} and y = {y:.4f} W; "
                   "that a push away from the diagonal would die out is not tested."
                   + _strain(case, "particle"), (case.label,))


@statement("fig15", "fig15", "appendix A, Fig. 15",
           "A rigid pair in the channel of 1:2 comes to rest by damped oscillations of its "
           "distance.", rigid=True)
def _fig15(study, method):
    case = _only(study, "rectangular", "clean")
    t, dz = case.run.series("dz")
    turns = quantities.extrema(t, dz, quantities.TURN)
    sizes = np.abs(np.diff(dz[turns])) if len(turns) > 2 else np.array([])
    falling = len(sizes) >= 2 and bool(np.all(np.diff(sizes) < 0))
    place = quantities.rectangular_equilibrium(study)
    return Finding(falling, "dz/a turns at "
                   + ", ".join(f"{dz[n] / case.start('lead', 'radius'):.3g}" for n in turns)
                   + (f", towards {place.value}." if place.known else f"; {place.reason}."),
                   (case.label,))
