#!/usr/bin/python3
"""The quick study of the paper, from nothing to its report, and what it must find.

    reproduce_quick.py PROGRAM WORK

Held are verdicts that a coarse lattice decides with room to spare, and statements and numbers that
follow from them. Not held are those that hang on the lattice, on a swing more or less, or on
round-off, as where a membrane without mobility crumples or a film of fluid is thinner than the
lattice. What an interrupted study of the same program has left in WORK is gone on with.
"""
import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

import support

from ductile.paper import report, results
from ductile.paper.study import X_LAGS

TOGETHER = ("stable", "damped", "bounded")
PARTED, DAMPED = ("unstable",), ("damped",)

# By pair and method, for x_lag = -0.4 to 0.4; None where it hangs on the lattice or on luck.
VERDICTS = {
    ("M1", "clean"): (None, None, None, TOGETHER, TOGETHER),
    ("M2", "clean"): (None, TOGETHER, None, PARTED, None),
    ("M2", "paper"): (None, TOGETHER, DAMPED, None, None),
    ("M3", "clean"): (None, TOGETHER, PARTED, PARTED, PARTED),
    ("B2", "clean"): (PARTED, None, None, PARTED, PARTED),
    ("B2", "paper"): (PARTED, None, None, None, PARTED),
    ("B3", "clean"): (PARTED, TOGETHER, None, PARTED, PARTED),
    ("B3", "paper"): (None, TOGETHER, None, None, None),
    ("B4", "clean"): (None, TOGETHER, None, None, None),
}

# Outcomes of statements: by both methods together, or by the one that is named.
STATEMENTS = {
    "la10-centre": {"clean": "yes"},
    "softer-inside": {"clean": "yes"},
    "shapes": {"clean": "yes"}, "m1-same-growth": {"clean": "yes", "paper": "yes"},
    "m2-push": {"clean": "yes"}, "m2-damped": {"paper": "yes"},
    "fig8-amplitude": {"clean": "yes", "paper": "yes"},
    "cell-slower": {"clean": "yes"}, "b3-outside": {"clean": "yes"},
    # The artefact: by the paper's method the capsule goes to the centre, by the clean one outward.
    "second-stable": {"clean": "no", "paper": "yes"},
    "fig14": {"clean": "yes"},
}
RIGID_STATEMENTS = {"m3-symmetric": "confirmed"}

# Numbers [W, nu/W^2 and so on] by the clean method, with what another compiler, a bug mended or a
# length of the run may change them by; they are those of these lattices, not the paper's.
NUMBERS = {
    "x-sphere-La10-0.2": (0.0119, 0.004), "x-sphere-La10-0.4": (0.0114, 0.004),
    "x-sphere-La100-0.2": (0.3412, 0.003), "x-sphere-La100-0.4": (0.3417, 0.003),
    "x-rigid-0.2": (0.4891, 0.003), "x-rigid-0.4": (0.4892, 0.003),
    "dz-M1-0.4": (4.07, 0.15), "dz-M2--0.2": (1.174, 0.02), "dz-M3--0.2": (1.585, 0.03),
    "dz-B4--0.2": (0.875, 0.05), "fig8-maximum--0.05": (2.056, 0.02),
    "fig8-maximum--0.1": (1.524, 0.02), "fig8-maximum--0.15": (1.309, 0.02),
    "fig14": (0.2603, 0.003),
}


def verdicts_that_differ(found):
    """Sentences on those of the map that are not as VERDICTS has them."""
    map_of = {(entry["pair"], entry["x_lag"]): entry["ours"] for entry in found["map"]}
    for (pair, method), row in VERDICTS.items():
        for x_lag, expected in zip(X_LAGS, row):
            run = map_of[pair, x_lag][method]
            if expected and (run is None or run["verdict"] not in expected):
                yield (f"{pair}, x_lag = {x_lag:g}, {method}: {run and run['verdict']} "
                       f"({run and run['reason']}), not {' or '.join(expected)}")


def statements_that_differ(found):
    """The same of STATEMENTS."""
    by_name = {entry["id"]: entry for entry in found["statements"]}
    called = {"clean": "by the clean method", "paper": "by the paper's method"}
    for name, by_method in STATEMENTS.items():
        entry = by_name[name]
        for method, expected in by_method.items():
            if f"{called[method]}: {expected}" not in entry["ours"]:
                yield f"{name}: {entry['ours']!r} has no {expected!r} {called[method]}"
    for name, expected in RIGID_STATEMENTS.items():
        if by_name[name]["outcome"] != expected:
            yield f"{name}: {by_name[name]['outcome']}, not {expected}"


def numbers_that_differ(found):
    """The same of NUMBERS."""
    by_name = {entry["id"]: entry for entry in found["numbers"]}
    for name, (value, bound) in NUMBERS.items():
        own = [one for one in by_name[name]["ours"] if one["method"] == "clean"]
        if not own or not abs(own[0]["value"] - value) <= bound:
            yield f"{name}: {own and own[0]['value']}, not {value} +- {bound}"


def main():
    program, work = sys.argv[1:3]
    work = Path(work).resolve()
    made_by = work / "made-by"
    own = hashlib.sha256(Path(program).read_bytes()).hexdigest()
    if not made_by.exists() or made_by.read_text(encoding="ascii") != own:
        if work.exists() and not (made_by.exists() or (work / "M2").is_dir()):
            return f"{work}: is no study: choose another directory"
        shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True, exist_ok=True)
    made_by.write_text(own, encoding="ascii")
    script = support.PACKAGE / "reproduce.py"
    made = subprocess.run(["/usr/bin/python3", "-B", str(script), "--program", program, "--quick",
                           "--no-films", "-o", str(work)], check=False)
    if made.returncode != 0:
        return f"exit code {made.returncode}"
    found = results.read(work)
    report.validate(found)
    wrong = [*verdicts_that_differ(found), *statements_that_differ(found),
             *numbers_that_differ(found)]
    if (work / "report.html").stat().st_size < 1e6:
        wrong.append("report.html is too short to hold the figures")
    return "\n".join(wrong) or None


if __name__ == "__main__":
    sys.exit(main())
