#!/usr/bin/python3
"""The quick study of the paper, from nothing to its report, and what it must find.

    reproduce_quick.py PROGRAM WORK

Held are verdicts that a coarse lattice decides with room to spare, and statements and numbers that
follow from them: those that hang on the lattice, on a swing more or less, or on round-off, are not.
What an interrupted study has left in WORK is gone on with.
"""
import subprocess
import sys
from pathlib import Path

import support

from ductile.paper import report, results

program, work = sys.argv[1:3]
work = Path(work).resolve()
script = Path(support.PYTHON) / "reproduce.py"

# Verdicts by pair, x_lag and method; "together" stands for stable, damped or bounded.
TOGETHER = ("stable", "damped", "bounded")
HELD = {}


def hold(pair, method, *verdicts):
    for x_lag, verdict in zip((-0.4, -0.2, 0.0, 0.2, 0.4), verdicts):
        if verdict:
            HELD[pair, x_lag, method] = verdict


def expect(condition, *story):
    if not condition:
        sys.exit("\n".join(str(part) for part in story))


made = subprocess.run(["/usr/bin/python3", "-B", str(script), "--program", program, "--quick", "-o",
                       str(work)], check=False)
expect(made.returncode == 0, f"exit code {made.returncode}")
found = results.read(work)
report.validate(found)
expect((work / "report.html").stat().st_size > 1e6, "no report")
