"""What the study comes to, as one dict: the map, every statement and every number of the paper's
text beside ours. It is what paper.json holds, and what the report shows (report.py has its schema).
"""
import json
import math
import os
from dataclasses import replace
from pathlib import Path

from .. import files
from ..errors import DuctileError
from . import quantities, statements
from .study import METHODS, PAIRS, X_LAGS, Study

FILE = "paper.json"

# As far as a coarse lattice may be from a number that the paper states [W], at least.
_TOLERANCE = 0.05

# What the paper says of each pair, and where.
_SAYS = {
    "M1": "\"The mono-dispersed pair M1 with soft capsules is always stable irrespective of the "
          "starting position\" (section 3).",
    "B1": "\"The B1 pair performs bounded oscillations\" (section 3); they are \"always stable\" "
          "(section 4).",
    ("M2", -0.4): "\"For x_lag = -0.4 the particle pair is stable although with a larger axial "
                  "distance\" than M1 (section 3.1.2).",
    ("M2", -0.2): "\"For the symmetric initial positions [...] the axial distance stays close to "
                  "the starting value\" (section 3.1.2).",
    ("M2", 0.0): "\"Stable but reaches a constant axial distance close to the initial value only "
                 "after extended damped oscillations\" (section 3.1.2).",
    ("M2", 0.2): "Leading and lagging particles drift at different velocities, \"which "
                 "continuously increases the axial distance and makes the pair unstable\" "
                 "(section 3.1.2).",
    ("M2", 0.4): "\"Also turns out to be unstable since already initially, they drift with very "
                 "different axial velocities\" (section 3.1.2); runs were stopped beyond dz = 10.",
    ("M3", -0.2): "\"Only the symmetric placement [...] provides a stable flowing pair\" (section "
                  "3.1.2).",
    "M3": "Unstable: \"only the symmetric placement [...] provides a stable flowing pair\" "
          "(section 3.1.2).",
    ("B2", -0.4): "\"Stable particle pairs only occur for x_lag = -0.2 and -0.4\" (section 3.2.2).",
    ("B2", -0.2): "\"Stable particle pairs only occur for x_lag = -0.2 and -0.4\" (section 3.2.2).",
    ("B2", 0.0): "Unstable; \"the leading particle is strongly dragged to the center by the "
                 "biconcave particle and ultimately reaches the center\" (section 3.2.2), though "
                 "sections 3 and 4 liken B2 to M2, which is damped there.",
    "B2": "\"All other B2 pairs are unstable and axially move away from each other\" (section "
          "3.2.2).",
    ("B3", -0.2): "\"The B3 pairs with x_lag = 0 and -0.2 form stable pairs\" (section 3.2.2).",
    ("B3", 0.0): "\"The B3 pairs with x_lag = 0 and -0.2 form stable pairs\" (section 3.2.2).",
    "B3": "\"The lagging particle migrates towards the off-center stable position, which "
          "ultimately makes the B3 pairs unstable\" (section 3.2.2).",
    ("B4", -0.2): "Lateral oscillations; \"the axial distance between the particles only "
                  "fluctuates little about its initial value and the pair is stable\" (section "
                  "3.2.2).",
    "B4": "Both come to the centre and \"drift apart at different axial velocities due to their "
          "different equilibrium shapes\", slowly (section 3.2.2).",
}


def of(directory, settings):
    """The results of the study in a directory, a dict as report.py describes it. `settings` has
    what no run knows: "version", "size", "commands", "duration_s". Raises DuctileError."""
    study = Study(directory)
    entries = [_entry(study, pair, x_lag) for pair in PAIRS for x_lag in X_LAGS]
    return {
        "version": settings["version"], "size": settings["size"],
        "commands": settings["commands"], "duration_s": settings["duration_s"],
        "methods": {method: _method(study, method) for method in METHODS},
        "counts": {method: _counts(entries, method) for method in METHODS},
        "map": entries,
        "statements": [statements.decided(one, study) for one in statements.STATEMENTS],
        "numbers": _numbers(study),
    }


def write_json(file, value):
    """Writes a file of JSON, which is there when it is whole, and gives its Path."""
    part = file.with_name(file.name + ".part")
    part.write_text(json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n",
                    encoding="utf-8")
    os.replace(part, file)
    return file


def write(directory, results):
    """Writes paper.json into the directory, and gives its Path."""
    return write_json(Path(directory) / FILE, results)


def read(directory):
    """The results in paper.json. Raises DuctileError."""
    return files.read_json(Path(directory) / FILE)


# ------------------------------------------------------------------------------------------------
# How it was computed


_METHODS = {
    "clean": ("Clean", "This program's own method: surfaces are felt by the fluid where they are, "
                       "on a lattice that goes along with the bodies, and the density is the "
                       "pressure alone; the membranes have a small mobility, by which strain "
                       "relaxes that the lattice cannot see, and edges of about a lattice "
                       "spacing; what the lattice does not resolve of the film between two rigid "
                       "spheres comes from lubrication theory."),
    "paper": ("The paper's",
              "As in the paper markers lie on the surfaces, which are felt some tenths of a "
              "lattice spacing outside of them, the lattice is at rest, and the density weighs in "
              "the momentum, eq. (3); the membranes have no mobility, and edges shorter than a "
              "lattice spacing (those of the paper: 0.68), so "
              "that strain that the kernel filters out can pile up. The soft biconcave cells "
              "start beside the plane y = 0, in the whole channel. Walls and the volume's modulus "
              "are the paper's on its own lattice alone."),
}
_SETTINGS = ("channel.nodes", "channel.walls", "channel.length", "fluid.tau", "fluid.frame",
             "fluid.equilibrium", "membrane.mobility", "membrane.edge", "membrane.retraction",
             "membrane.volume_modulus", "channel.symmetry", "fluid.storage", "fluid.arithmetic")


def _method(study, method):
    title, summary = _METHODS[method]
    cases = [case for case in study.all_cases
             if case.method == method and case.campaign in PAIRS and case.campaign != "M3"]
    coarsest = {}
    for case in cases:
        known = coarsest.setdefault(case.campaign, case)
        if case.nodes < known.nodes:
            coarsest[case.campaign] = case
    settings = {}
    for key in _SETTINGS:
        values = {}
        for pair, case in coarsest.items():
            values.setdefault(_said(case.parameters.get(key)), []).append(pair)
        if values:
            settings[key] = (next(iter(values)) if len(values) == 1 else "; ".join(
                f"{value} ({', '.join(pairs)})" for value, pairs in values.items()))
    return {"title": title, "summary": summary, "settings": settings}


def _said(value):
    if value is None:
        return "\N{EM DASH}"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


# ------------------------------------------------------------------------------------------------
# The map


def accepts(pair, x_lag):
    """The verdicts of the program that count as the paper's class of a pair."""
    return list(quantities.accepted(pair, quantities.paper_class(pair, x_lag)))


def outcome_of(verdict, accepted):
    """Of a verdict or None: "same", "differs", "undecided" or "missing"."""
    if verdict is None:
        return "missing"
    if verdict == "undecided":
        return "undecided"
    return "same" if verdict in accepted else "differs"


def finer_wanted(study, methods=METHODS):
    """The cases whose verdict is not the paper's, or has none: those of which a finer lattice is to
    be evidence, as a list of Cases."""
    found = []
    for pair in PAIRS:
        for x_lag in X_LAGS:
            for method in methods if pair != "M3" else METHODS[:1]:
                case = study.pair(pair, x_lag, method)
                verdict = quantities.class_of(case, pair, x_lag).verdict
                if case and outcome_of(verdict, accepts(pair, x_lag)) != "same":
                    found.append(case)
    return found


def _run(case, pair, x_lag):
    """A RUN of the report, of a case; None of none."""
    if case is None:
        return None
    summary = case.summary
    found = quantities.class_of(case, pair, x_lag)
    verdict = found.verdict or "undecided"
    bodies = {body["name"]: body for body in summary.get("bodies", [])}
    t, dz = case.run.series("dz")
    return {
        "case": case.label, "nodes": case.nodes, "verdict": verdict,
        "reason": found.reason,
        "outcome": outcome_of(verdict, accepts(pair, x_lag)),
        "time": float(t[-1]), "dz": float(dz[-1]),
        "dz_limit": summary.get("dz_limit_W"), "dz_limit_error": summary.get("dz_limit_error_W"),
        "x": {body: float(case.run.series(f"{body}_x")[1][-1]) for body in ("lead", "lag")},
        "strain_energy": {body: bodies.get(body, {}).get("strain_energy_over_ks_a2")
                          for body in ("lead", "lag")},
        "strain_settled": {body: bodies.get(body, {}).get("strain_energy_settled")
                           for body in ("lead", "lag")},
    }


def _entry(study, pair, x_lag):
    own = METHODS if pair != "M3" else METHODS[:1]
    ours, finer = dict.fromkeys(METHODS), {method: [] for method in METHODS}
    for method in own:
        base = study.pair(pair, x_lag, method)
        ours[method] = _run(base, pair, x_lag)
        finer[method] = [_run(case, pair, x_lag) for case in study.cases(pair, method, lag=x_lag)
                         if base and case.nodes > base.nodes and case.ended]
        finer[method].sort(key=lambda run: run["nodes"])
    paper = quantities.paper_class(pair, x_lag)
    runs = [ours[method] for method in own if ours[method]]
    outcomes = {run["outcome"] for run in runs}
    outcome = ("missing" if not runs else "same" if outcomes == {"same"} else
               "differs" if "differs" in outcomes else "undecided")
    changes = any(_changes(ours[method], finer[method]) for method in own)
    return {
        "pair": pair, "x_lag": x_lag,
        "paper": {"verdict": paper, "accepts": accepts(pair, x_lag),
                  "text": _SAYS.get((pair, x_lag)) or _SAYS[pair]},
        "ours": ours, "finer": finer, "outcome": outcome, "changes_with_resolution": changes,
        "explanation": _explanation(paper, {method: ours[method] for method in own}, finer,
                                    changes),
    }


def _bound(verdict):
    return verdict in statements.BOUND


def _changes(run, finer):
    """Whether a finer lattice has another decided verdict as to staying together."""
    return bool(run) and any(
        "undecided" not in (run["verdict"], other["verdict"])
        and _bound(run["verdict"]) != _bound(other["verdict"]) for other in finer)


def _explanation(paper, ours, finer, changes):
    """In words, what there is to say of a difference: verdicts, strain energies, lattices."""
    words = []
    called = {"clean": "the clean method", "paper": "the paper's method"}
    for method, run in ours.items():
        if run is None:
            continue
        if run["outcome"] == "same":
            if run["verdict"] != paper:
                words.append(f"By {called[method]} the pair stays together as in the paper, and is "
                             f"{run['verdict']} where the paper calls it {paper}.")
            continue
        said = (f"By {called[method]} at {run['nodes']} nodes the pair is {run['verdict']}: "
                f"{run['reason']}.")
        if run["outcome"] == "undecided":
            said = (f"By {called[method]} at {run['nodes']} nodes nothing is decided by t = "
                    f"{run['time']:.3g}, where dz = {run['dz']:.3g}: {run['reason']}.")
        words.append(said + _strains(run))
        for other in finer[method]:
            words.append(f"At {other['nodes']} nodes it is {other['verdict']}, dz = "
                         f"{other['dz']:.3g} at t = {other['time']:.3g}.")
        if not finer[method]:
            words.append("No finer lattice has been computed.")
    decided = [run for run in ours.values() if run and run["outcome"] != "undecided"]
    if len(decided) == 2 and decided[0]["outcome"] != decided[1]["outcome"]:
        words.append("The two methods, which differ in mobility, edges, the fluid and where "
                     "surfaces are felt, come to different ends.")
    elif len(decided) == 2 and decided[0]["outcome"] == "differs":
        words.append("Both methods differ from the paper here.")
    if changes:
        words.append("The verdict changes with the resolution.")
    return " ".join(words)


def _strains(run):
    known = {body: energy for body, energy in run["strain_energy"].items() if energy is not None}
    if not known:
        return ""
    parts = []
    for body, energy in known.items():
        settled = {True: ", settled", False: ", not settled"}.get(run["strain_settled"][body], "")
        name = "leading" if body == "lead" else "lagging"
        parts.append(f"{energy:.2g} k_s a^2 ({name}{settled})")
    return " The strain energies are " + " and ".join(parts) + "."


def _counts(entries, method):
    counts = dict.fromkeys(("same", "differs", "undecided", "missing"), 0)
    for entry in entries:
        run = entry["ours"]["clean" if entry["pair"] == "M3" else method]
        counts[run["outcome"] if run else "missing"] += 1
    return counts


# ------------------------------------------------------------------------------------------------
# Numbers


def _numbers(study):
    found = []

    def add(name, figure, source, quantity, unit, by_method, stated=None, words="",
            tolerance=None):
        ours, remarks = [], []
        for method, own in by_method.items():
            if own is None:
                continue
            if own.known:
                ours.append({"method": method, "nodes": _nodes(study, own.case),
                             "value": own.value.value, "error": _finite(own.value.error),
                             "case": own.case.split(",")[0]})
                if own.swing is not None:
                    remarks.append(f"{method}: swings by +-{own.swing:.2g}")
            elif own.case:
                remarks.append(f"{method}: {own.reason}")
        if stated is None:
            outcome = "ours alone" if ours else "undecided" if remarks else "not computed"
        elif not ours:
            outcome = "undecided" if remarks else "not computed"
        else:
            agree = {_agrees(own["value"] - stated, own["error"] or 0, tolerance) for own in ours}
            outcome = ("undecided" if agree == {None} else
                       "depends on the method" if agree >= {True, False} else
                       "confirmed" if True in agree else "not confirmed")
            remarks.append(f"within {tolerance:g} counts as confirmed")
        found.append({"id": name, "figure": figure, "source": source, "quantity": quantity,
                      "unit": unit, "paper": stated, "paper_text": words, "ours": ours,
                      "outcome": outcome, "remark": "; ".join(remarks)})

    for kind in quantities.SINGLES:
        stated = quantities.STATED[kind]
        methods = METHODS if kind != "rigid" else METHODS[:1]
        for start in quantities.STARTS:
            add(f"x-{kind}-{start:g}", "fig9" if kind.startswith("biconcave") else "fig5",
                f"section {stated.section}", f"x_eq, {kind}, from {start:g}", "W",
                {method: _absolute(quantities.equilibrium(quantities.single_case(
                    study, kind, start, method))) for method in methods}, stated.value,
                stated.words, _TOLERANCE)
    for pair in PAIRS:
        methods = METHODS if pair != "M3" else METHODS[:1]
        for x_lag in X_LAGS:
            if quantities.paper_class(pair, x_lag) == "unstable":
                continue
            add(f"dz-{pair}-{x_lag:g}", "fig13", "Fig. 13",
                f"dz_eq, {quantities.pair_name(pair, x_lag)}", "W",
                {method: quantities.equilibrium_distance(study.pair(pair, x_lag, method), pair,
                                                         x_lag) for method in methods})
    stated = quantities.STATED["M1 quotient"]
    add("dz-M1-quotient", "fig6", f"section {stated.section}",
        "dz_eq of M1, x_lag = 0.4 over -0.4", "",
        {method: quantities.quotient(*(
            quantities.equilibrium_distance(study.pair("M1", x_lag, method), "M1", x_lag)
            for x_lag in (0.4, -0.4))) for method in METHODS}, stated.value, stated.words, 0.2)
    ratios = {method: quantities.migration_ratios(study, method) for method in METHODS}
    for body, expected in quantities.MIGRATES.items():
        for x_lag in expected:
            add(f"fig7-{body}-{x_lag:g}", "fig7", "Fig. 7",
                f"t_pair/t_single of the {'leading' if body == 'lead' else 'lagging'} one, "
                f"x_lag = {x_lag:g}", "",
                {method: ratios[method][x_lag][body].ratio for method in METHODS})
    damped = {method: quantities.damped_oscillations(study, method) for method in METHODS}
    for what, name, unit in (("maximum", "max(dz)", "W"), ("equilibrium", "dz_eq", "W"),
                             ("damping", "zeta", "nu/W^2"), ("period", "period", "W^2/nu")):
        for x_lag in quantities.DAMPED_X_LAGS:
            own = {method: damped[method].get(x_lag) for method in METHODS}
            add(f"fig8-{what}-{x_lag:g}", "fig8", "Fig. 8", f"{name} of M2, x_lag = {x_lag:g}",
                unit, {method: one and getattr(one, what) for method, one in own.items()})
    stated = quantities.STATED["B4 parting"]
    add("B4-parting", "fig11", f"section {stated.section}", "t at which dz = 10, B4, x_lag = 0.2",
        "W^2/nu", {method: quantities.parting_time(study.pair("B4", 0.2, method))
                   for method in METHODS}, stated.value, stated.words, 100.0)
    add("fig14", "fig14", "appendix A, Fig. 14", "place on the diagonal, sqrt(x^2 + y^2)", "W",
        {method: quantities.diagonal_equilibrium(study, method) for method in METHODS})
    add("fig15", "fig15", "appendix A, Fig. 15", "dz_eq/a in the channel of 1:2", "",
        {"clean": quantities.rectangular_equilibrium(study)})
    return found


def _agrees(apart, error, tolerance):
    """Whether a number is the one that is stated; None where its error leaves it open."""
    if abs(apart) <= tolerance and error <= tolerance:
        return True
    return False if abs(apart) > tolerance + 2 * error else None


def _absolute(quantity):
    """|x|: the channel is symmetric."""
    if quantity is None or not quantity.known or quantity.value.value >= 0:
        return quantity
    return replace(quantity, value=quantities.scaled(quantity.value, -1.0))


def _nodes(study, label):
    first = label.split(",")[0]
    return next((case.nodes for case in study.all_cases if case.label == first), 0)


def _finite(value):
    return float(value) if math.isfinite(value) else None


def settings_of(directory):
    """What `reproduce` has noted of the study in a directory. Raises DuctileError."""
    found = files.read_json(Path(directory) / "reproduce.json")
    for key in ("version", "size", "commands", "duration_s"):
        if key not in found:
            raise DuctileError(f"{Path(directory) / 'reproduce.json'}: has no \"{key}\"")
    return found
