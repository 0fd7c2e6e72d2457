#!/usr/bin/python3
"""What the study comes to, from runs that follow known laws: verdicts, statements, numbers."""
import errno
import fcntl
import itertools
import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import support  # noqa: F401  (finds the package)
import numpy as np
from paper_figures_test import Synthetic, Whole, write_whole

from ductile.errors import DuctileError
from ductile.paper import making, report, reproduce, results, statements
from ductile.paper.study import METHODS, PAIRS, X_LAGS, Study

SETTINGS = {"version": "0", "size": "quick", "commands": ["./ductile.sh reproduce --quick"],
            "duration_s": 1.0}


def outcome(study, name):
    one = next(one for one in statements.STATEMENTS if one.name == name)
    return statements.decided(one, study)["outcome"]


class Results(Whole):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.results = results.of(cls.study.directory, SETTINGS)

    def numbers(self):
        return {number["id"]: number for number in self.results["numbers"]}

    def test_they_are_what_the_report_takes(self):
        report.validate(self.results)
        file = results.write(self.study.directory, self.results)
        self.assertEqual(results.read(self.study.directory), json.loads(file.read_text()))
        self.assertEqual(json.loads(file.read_text()), self.results)

    def test_all_is_as_in_the_paper_where_the_laws_are(self):
        for counts in self.results["counts"].values():
            self.assertEqual(counts, {"same": 35, "differs": 0, "undecided": 0, "missing": 0})
        for entry in self.results["map"]:
            self.assertEqual((entry["outcome"], entry["explanation"]), ("same", ""))

    def test_statements_follow_the_laws(self):
        found = {one["id"]: one["outcome"] for one in self.results["statements"]}
        expected = {"stiffer": "confirmed", "same-half": "confirmed", "symmetric": "confirmed",
                    "m1-stable": "confirmed", "m2-transition": "confirmed",
                    "m3-symmetric": "confirmed", "la10-centre": "confirmed",
                    "m1-same-growth": "not confirmed", "fig7-lead": "confirmed",
                    "fig7-lag": "confirmed", "second-stable": "depends on the method",
                    "fig8-amplitude": "confirmed", "fig8-damping": "confirmed",
                    "m3-grows": "not confirmed", "m3-same-growth": "confirmed",
                    "cell-place": "not confirmed", "cell-lifts": "confirmed",
                    "b1-lifts": "confirmed", "fig12": "confirmed", "b4-swings": "not confirmed",
                    "b4-centre": "not confirmed", "fig14": "confirmed", "fig15": "confirmed",
                    "volume": "not computed"}
        self.assertEqual({name: found[name] for name in expected}, expected)

    def test_numbers_are_those_of_the_laws(self):
        found = self.numbers()
        for name, true, outcome in (
                ("x-sphere-La100-0.2", 0.3, "confirmed"), ("x-rigid-0.4", 0.41, "confirmed"),
                ("x-biconcave-La10-0.2", 0.18, "not confirmed"),
                ("dz-M2--0.4", 4.4, "ours alone"), ("dz-M1-quotient", 1.3, "not confirmed"),
                ("fig7-lead-0.2", 0.7, "ours alone"), ("fig8-damping--0.15", 0.06, "ours alone"),
                ("B4-parting", 400, "confirmed"), ("fig14", 0.25 * np.sqrt(2), "ours alone"),
                ("fig15", 3.625, "ours alone")):
            own = found[name]["ours"][0]
            self.assertLess(abs(own["value"] - true), max(3 * (own["error"] or 0), 1e-6 * true),
                            name)
            self.assertEqual(found[name]["outcome"], outcome, name)

    def test_what_is_undecided_says_why(self):
        entry = next(one for one in self.results["statements"] if one["id"] == "cell-tumbles")
        self.assertEqual(entry["outcome"], "undecided")
        self.assertIn("the run wrote no surfaces", entry["evidence"])
        self.assertNotIn(str(self.study.directory), json.dumps(self.results))


class Differences(unittest.TestCase):
    """A study that differs from the paper here and there."""

    def setUp(self):
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        self.synthetic = write_whole(own.name)
        self.directory = Path(own.name)

    def rewrite(self, pair, x_lag, method, verdict, nodes=24, **summary):
        """Another end of a case, or one on a finer lattice."""
        if nodes != 24:
            self.synthetic.pair(pair, x_lag, method, nodes)
        file = (self.directory / pair / "cases" / f"{method}-{nodes}_lag-x_{x_lag:g}"
                / "summary.json")
        file.write_text(json.dumps(json.loads(file.read_text())
                                   | {"verdict": verdict, "verdict_reason": "as told"} | summary))

    def entry(self, pair, x_lag):
        found = results.of(self.directory, SETTINGS)
        report.validate(found)
        return next(entry for entry in found["map"]
                    if (entry["pair"], entry["x_lag"]) == (pair, x_lag)), found

    def test_one_method_alone(self):
        self.rewrite("M2", 0.2, "clean", "stable")
        entry, found = self.entry("M2", 0.2)
        self.assertEqual(entry["outcome"], "differs")
        self.assertIn("come to different ends", entry["explanation"])
        self.assertEqual(found["counts"]["clean"]["differs"], 1)
        self.assertEqual(found["counts"]["paper"]["differs"], 0)
        study = Study(self.directory)
        self.assertEqual(outcome(study, "m2-transition"), "depends on the method")
        self.assertEqual(outcome(study, "stiffer"), "confirmed")

    def test_both_methods_and_a_finer_lattice(self):
        for method in METHODS:
            self.rewrite("B2", -0.4, method, "unstable", bodies=[
                {"name": "lead", "strain_energy_over_ks_a2": 0.04, "strain_energy_settled": False},
                {"name": "lag", "strain_energy_over_ks_a2": 0.01, "strain_energy_settled": True}])
        self.rewrite("B2", -0.4, "clean", "stable", 48)
        entry, _ = self.entry("B2", -0.4)
        self.assertEqual([run["nodes"] for run in entry["finer"]["clean"]], [48])
        self.assertEqual(entry["ours"]["clean"]["nodes"], 24)
        self.assertTrue(entry["changes_with_resolution"])
        for said in ("Both methods differ from the paper here",
                     "0.04 k_s a^2 (leading, not settled)",
                     "0.01 k_s a^2 (lagging, settled)", "At 48 nodes it is stable",
                     "The verdict changes with the resolution"):
            self.assertIn(said, entry["explanation"])

    def test_a_number_that_a_pair_has_not_is_undecided(self):
        for method in METHODS:
            self.rewrite("B4", 0.2, method, "damped")
            self.rewrite("M1", 0.2, method, "unstable")
            self.rewrite("M2", 0.0, method, "damped", status="blew up")
        _, found = self.entry("B4", 0.2)
        numbers = {number["id"]: number for number in found["numbers"]}
        for name, why in (("B4-parting", "the pair is damped: as told"),
                          ("fig8-equilibrium-0", "the run blew up"),
                          ("dz-M1-0.2", "the pair is unstable: as told")):
            self.assertEqual((numbers[name]["outcome"], numbers[name]["ours"]), ("undecided", []))
            self.assertIn(why, numbers[name]["remark"])

    def test_a_cell_that_tilts_and_does_not_wobble_is_undecided(self):
        for last, expected in (("resting", "undecided"), ("wobbling", "confirmed")):
            with mock.patch.object(statements, "_kinds",
                                   lambda _, last=last: ["tumbling", "tumbling", last]):
                for name in ("fig12", "cell-lifts"):
                    one = next(one for one in statements.STATEMENTS if one.name == name)
                    found = statements.decided(one, Study(self.directory))
                    self.assertEqual(found["outcome"], expected, name)
                    if expected == "undecided":
                        self.assertIn("is tumbling, tumbling, resting. ", found["evidence"] + " ")

    def test_one_report_at_a_time(self):
        held = os.open(self.directory, os.O_RDONLY)
        self.addCleanup(os.close, held)
        fcntl.flock(held, fcntl.LOCK_EX)
        with self.assertRaisesRegex(DuctileError, "another process makes its report"):
            making.make(self.directory, with_films=False)
        # A file system without locks is no obstacle.
        with mock.patch("fcntl.flock", side_effect=OSError(errno.ENOSYS, "no locks")), \
                mock.patch.object(making, "_make", return_value="made"):
            self.assertEqual(making.make(self.directory, with_films=False), "made")

    def test_what_counts_as_the_papers_class(self):
        for pair, x_lag, verdict, expected in (
                ("M1", -0.4, "damped", "same"), ("M1", 0.4, "bounded", "differs"),
                ("B1", 0.0, "stable", "same"), ("B1", 0.2, "unstable", "differs"),
                ("M2", 0.0, "stable", "differs"), ("B4", 0.2, "undecided", "undecided"),
                ("B2", -0.2, "bounded", "same"), ("B3", -0.2, "undecided", "undecided"),
                ("B1", -0.4, "undecided", "same")):
            self.rewrite(pair, x_lag, "clean", verdict)
            run = results._entry(Study(self.directory), pair, x_lag)["ours"]["clean"]
            self.assertEqual(run["outcome"], expected, (pair, verdict))
        wanted = {case.label for case in results.finer_wanted(Study(self.directory))}
        self.assertEqual(wanted, {"M1/clean-24_lag-x_0.4", "B1/clean-24_lag-x_0.2",
                                  "M2/clean-24_lag-x_0", "B3/clean-24_lag-x_-0.2",
                                  "B4/clean-24_lag-x_0.2"})
        self.assertEqual(results.finer_wanted(Study(self.directory), ("paper",)), [])

    def test_statements_can_fail(self):
        """Each is turned by the runs that it is about."""
        for pair, x_lag, verdict, name in (
                ("M3", 0.0, "damped", "m3-symmetric"), ("M1", 0.4, "unstable", "m1-stable"),
                ("B3", -0.2, "unstable", "symmetric"), ("B2", 0.4, "stable", "b2-classes"),
                ("B4", -0.4, "damped", "b4-classes"), ("B1", -0.4, "unstable", "b1-bounded"),
                ("M3", 0.4, "stable", "stiffer")):
            self.assertEqual(outcome(Study(self.directory), name), "confirmed", name)
            for method in METHODS if pair != "M3" else METHODS[:1]:
                self.rewrite(pair, x_lag, method, verdict)
            self.assertEqual(outcome(Study(self.directory), name), "not confirmed", name)

    def test_a_small_part_of_a_study(self):
        with tempfile.TemporaryDirectory() as place:
            study = Synthetic(place)
            study.pair("M2", 0.0, "clean")
            found = results.of(place, SETTINGS)
            report.validate(found)
            self.assertEqual(found["counts"]["clean"], {"same": 1, "differs": 0, "undecided": 0,
                                                        "missing": 34})
            self.assertEqual({one["outcome"] for one in found["statements"]}, {"not computed"})

    def test_capsules_that_lose_volume(self):
        for method, error in (("paper", 0.013), ("clean", 0.001)):
            self.rewrite("M1", 0.0, method, "stable", bodies=[
                {"name": "lead", "volume_error_max": 0.004},
                {"name": "lag", "volume_error_max": error}])
        found = next(one for one in results.of(self.directory, SETTINGS)["statements"]
                     if one["id"] == "volume")
        self.assertEqual(found["outcome"], "depends on the method")
        self.assertIn("1.3%, of M1/paper-24_lag-x_0 lag", found["evidence"])


class Reproduction(unittest.TestCase):
    """The campaigns, and which of their cases a size takes."""

    @classmethod
    def setUpClass(cls):
        program = os.environ["DUCTILE_PROGRAM"]
        own = tempfile.TemporaryDirectory()
        cls.addClassCleanup(own.cleanup)
        subprocess.run([program, "campaign", *map(str, reproduce.campaign_files()), "-o", own.name,
                        "--prepare"], check=True, capture_output=True)
        cls.directory = Path(own.name)

    def cases(self):
        return {f"{file.parent.name}/{row['case']}": row
                for file in sorted(self.directory.glob("*/campaign.csv"))
                for row in results.files.read_table(file)[0]}

    def chosen(self, size, methods=METHODS):
        expressions = [re.compile(pattern.replace(".", r"\.").replace("*", ".*") + "$")
                       for pattern in reproduce.patterns(size, methods)]
        found = {name for name in self.cases()
                 if any(expression.match(name) for expression in expressions)}
        for expression in expressions:
            self.assertTrue(any(expression.match(name) for name in self.cases()),
                            expression.pattern)
        return found

    def test_all_scenarios_are_good(self):
        for size in reproduce.SIZES:
            refused = [name for name in self.chosen(size)
                       if self.cases()[name]["state"] == "refused"]
            self.assertEqual(refused, [])

    def test_every_size_has_the_whole_study(self):
        for size in reproduce.SIZES:
            chosen = self.chosen(size)
            for pair, x_lag in itertools.product(PAIRS, X_LAGS):
                own = [name for name in chosen if name.startswith(f"{pair}/")
                       and float(self.cases()[name]["body.lag.x"]) == x_lag]
                self.assertEqual(len(own), 1 if pair == "M3" else 2, (size, pair, x_lag, own))
            for campaign, count in (("damped", 6), ("spheres", 8), ("rigid", 2),
                                    ("cells", 4 if size == "quick" else 8),
                                    ("released", 4 if size == "default" else 2),
                                    ("diagonal", 2), ("rectangular", 1)):
                own = [name for name in chosen if name.startswith(f"{campaign}/")]
                self.assertEqual(len(own), count, (size, campaign, own))
            self.assertEqual(len(chosen), {"quick": 90, "default": 96, "paper": 94}[size])

    def test_one_method_alone(self):
        chosen = self.chosen("default", ("clean",))
        self.assertEqual(len(chosen), 52)
        self.assertFalse(any("paper-" in name for name in chosen))

    def test_finer_cases_are_there(self):
        nodes = reproduce.FINER
        for pair, x_lag in itertools.product(PAIRS, X_LAGS):
            for method in METHODS if pair != "M3" else METHODS[:1]:
                self.assertIn(f"{pair}/{method}-{nodes}_lag-x_{x_lag:g}", self.cases())


class Notes(unittest.TestCase):
    def test_a_directory_without_a_study(self):
        with tempfile.TemporaryDirectory() as place:
            with self.assertRaisesRegex(DuctileError, "holds no campaign of the study"):
                Study(place)
            with self.assertRaisesRegex(DuctileError, "reproduce.json: no such file"):
                results.settings_of(place)
            (Path(place) / "reproduce.json").write_text('{"version": "0"}')
            with self.assertRaisesRegex(DuctileError, 'has no "size"'):
                results.settings_of(place)


if __name__ == "__main__":
    unittest.main()
