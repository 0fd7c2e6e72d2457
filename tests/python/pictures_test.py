#!/usr/bin/python3
"""Pictures: what is in them, into which files they go, and that they come up quickly."""
import json
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import support
import numpy as np

from ductile import errors, parameters, pictures, trajectories

SCRIPT = support.PACKAGE / "plot.py"


def texts_of(figure):
    """All that is written in a figure, as one text."""
    from matplotlib.text import Text
    return "\n".join(text.get_text() for text in figure.findobj(Text))


def panels_of(figure):
    return [axes.get_ylabel() for axes in figure.axes]


class Directory(unittest.TestCase):
    def setUp(self):
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        self.work = Path(own.name)


class OneRun(Directory):
    def drawn(self):
        figure, file = pictures.draw([self.work])
        self.assertEqual(file, self.work / "trajectory")
        return figure

    def test_it_says_what_was_run_and_where_it_heads(self):
        support.write_pair(self.work, laplace=100.0, **{"fluid.tau": 0.8})
        figure = self.drawn()
        text = texts_of(figure)
        for part in ("M1", "stable", "Re = 10", "La = 100", r"$x_{\mathrm{lag}}$ = −0.2 W",
                     "36 nodes", r"$\tau$ = 0.8", "dz approaches 1.5 ± 0.04", "→ 1.50 ± 0.04",
                     "→ 0.001 ± 0.002", "→ −0.001 ± 0.002", "leading", "lagging"):
            self.assertIn(part, text)
        self.assertNotIn("mobility", text)  # as usual
        self.assertEqual(len(panels_of(figure)), 3)

    def test_the_data_are_in_it(self):
        support.write_pair(self.work)
        figure = self.drawn()
        columns = support.pair_columns(np.linspace(0, 40, 201))
        for panel, names in ((0, ("lead_x", "lag_x")), (1, ("dz",))):
            lines = [line.get_ydata() for line in figure.axes[panel].lines]
            for name in names:
                self.assertTrue(any(len(line) == 201 and np.allclose(line, columns[name])
                                    for line in lines), name)

    def test_y_is_drawn_where_it_moves(self):
        columns = support.pair_columns(np.linspace(0, 40, 201))
        for amplitude, panels in ((0.004, 3), (0.006, 4)):
            columns["lag_y"] = amplitude * np.sin(columns["t"])
            support.write_trajectory(self.work, columns)
            self.assertEqual(len(panels_of(self.drawn())), panels)
        self.assertEqual(panels_of(self.drawn())[1], "$y/W$")

    def test_a_run_that_goes_on_or_has_died_is_drawn(self):
        support.write_pair(self.work, summary=False, t=np.arange(4.0))
        with open(self.work / "trajectory.csv", "a") as file:
            file.write("4.0,0.2,na")
        self.drawn()
        (self.work / "summary.json").write_text('{"status": "blew up", "blow_up": {"step": 7, "rea')
        self.drawn()
        (self.work / "summary.json").write_text(
            '{"status": "blew up", "blow_up": {"step": 7, "reason": "a volume of nan"}}')
        self.assertIn("at step 7: a volume of nan", texts_of(self.drawn()))

    def test_the_limit_of_dz_is_what_the_program_says(self):
        for summary, limit in (({"dz_limit_W": 0.881, "dz_limit_error_W": 0.01}, (0.881, 0.01)),
                               ({"dz_limit_W": None, "dz_limit_error_W": None}, None),
                               ({}, None)):
            self.assertEqual(trajectories.Drawn(self.work, {}, summary, {}).limit_of_dz, limit)


class Several(Directory):
    def test_runs_are_told_apart_by_what_differs(self):
        for x in (0.2, -0.4, 0.0):
            support.write_pair(self.work / str(x), x_lag=x)
        figure, file = pictures.draw([self.work / str(x) for x in (0.2, -0.4, 0.0)])
        self.assertEqual(file, Path("overlay"))
        legends = [text.get_text() for text in figure.axes[0].artists[0].get_texts()] \
            if figure.axes[0].artists else texts_of(figure).split("\n")
        own = [text for text in legends if "lag" in text and "stable" in text]
        self.assertEqual(own, [r"$x_{\mathrm{lag}}$ = " + f"{x} W: stable"
                               for x in ("−0.4", "0", "0.2")])
        self.assertIn("Re = 10, La = 10, 36 nodes", texts_of(figure))

    def test_what_bodies_share_in_one_run_alone_is_still_told(self):
        # x is 0.2 for both in the second run.
        told = parameters.differences([support.pair_parameters(-0.2), support.pair_parameters(0.2)])
        self.assertEqual(told, [{"body.lag.x": -0.2}, {"body.lag.x": 0.2}])
        told = parameters.differences([support.pair_parameters(laplace=10.0),
                                       support.pair_parameters(laplace=100.0)])
        self.assertEqual(told, [{"body.laplace": 10}, {"body.laplace": 100}])

    def test_runs_that_do_not_differ_have_their_directories_names(self):
        for name in ("first", "second"):
            support.write_pair(self.work / name)
        figure, _ = pictures.draw([self.work / "first", self.work / "second"])
        self.assertIn("first: stable", texts_of(figure))

    def test_the_coupling_is_told_as_it_was_asked_for(self):
        def with_coupling(retraction, own, **others):
            return support.pair_parameters(**{
                "membrane.retraction": retraction, "rigid.retraction": "felt", "rigid.slip": "felt",
                "fluid.magic": 0.1875, "fluid.collision": "bgk", "body.lead.retraction": own,
                "body.lag.retraction": own} | others)
        felt, coarse = with_coupling("felt", 0.575), with_coupling("felt", 0.7)
        plain = with_coupling(0.0, 0.0, **{"fluid.frame": "walls"})
        self.assertEqual(parameters.headline(felt), parameters.headline(support.pair_parameters()))
        self.assertEqual(parameters.headline(plain)[-2:],
                         ["membrane retraction = 0 dx", "lattice with the walls"])
        # What follows from the lattice alone does not tell runs apart.
        self.assertEqual(parameters.differences([felt, coarse]), [{}, {}])
        told = parameters.differences([felt, plain])
        self.assertEqual([said["membrane.retraction"] for said in told], ["felt", 0.0])
        self.assertEqual(parameters.said("membrane.retraction", "felt"), "membrane retraction felt")
        own = with_coupling("felt", 0.575, **{"body.lag.retraction": 0.0})
        self.assertIn("retraction of lag = 0 dx", [
            parameters.said(*item) for item in parameters.differences([felt, own])[1].items()])

    def test_old_limits_of_time_do_not_tell_runs_apart(self):
        told = parameters.differences([support.pair_parameters(**{"run.time_limit": t, "name": n})
                                       for t, n in ((10, "a"), (20, "b"))])
        self.assertEqual(told, [{}, {}])


class Campaign(Directory):
    def write(self, axes=("body.lag.x", "channel.reynolds"), extra=""):
        rows = [("a", -0.2, 10, "decided", "stable", 1.31),
                ("b", 0.2, 10, "stopped at dz", "unstable", 10),
                ("c", -0.2, 20, "unfinished", "", ""), ("d", 0.2, 20, "blew up", "stable", 1.2)]
        (self.work / "campaign.csv").write_text(
            "case,body.lag.x,channel.reynolds,state,verdict,dz[W]\n"
            + "".join(",".join(map(str, row)) + "\n" for row in rows) + extra)
        (self.work / "campaign.json").write_text(json.dumps({"axes": list(axes)}))
        support.write_pair(self.work / "cases/a", -0.2)
        support.write_pair(self.work / "cases/b", 0.2)

    def test_a_map_has_a_labelled_cell_a_case(self):
        self.write()
        figure, file = pictures.draw([self.work], as_map=True)
        self.assertEqual(file, self.work / "map")
        axes = figure.axes[0]
        self.assertEqual(len(axes.patches), 4)
        self.assertEqual([label.get_text() for label in axes.get_xticklabels()], ["−0.2", "0.2"])
        self.assertEqual([label.get_text() for label in axes.get_yticklabels()], ["10", "20"])
        cells = {text.get_text(): (round(text.get_position()[0]), round(text.get_position()[1]))
                 for text in axes.texts}
        self.assertEqual(cells["stable"], (0, 0))
        self.assertEqual(cells["unstable"], (1, 0))
        self.assertEqual(cells["unfinished"], (0, 1))
        self.assertEqual(cells["blew up"], (1, 1))  # and not stable, as it was until then
        self.assertNotIn(r"$\Delta z$ = 1.2", cells)
        self.assertEqual(cells[r"$\Delta z$ = 1.31"], (0, 0))
        self.assertIn("Re", axes.get_ylabel())

    def test_its_cases_are_drawn_over_each_other(self):
        self.write()
        figure, file = pictures.draw([self.work])
        self.assertEqual(file, self.work / "overlay")
        self.assertIn(r"$x_{\mathrm{lag}}$ = −0.2 W, Re = 10: stable", texts_of(figure))

    def test_a_map_of_what_has_none_is_refused(self):
        self.write(axes=("body.lag.x", "channel.reynolds", "state"))
        with self.assertRaisesRegex(errors.DuctileError, "sweeps 3 keys"):
            pictures.draw([self.work], as_map=True)
        self.write(axes=("body.lag.x",))
        with self.assertRaisesRegex(errors.DuctileError, "cases a and c are at the same place"):
            pictures.draw([self.work], as_map=True)


class CommandLine(Directory):
    def run_script(self, *arguments):
        return subprocess.run([sys.executable, SCRIPT, *map(str, arguments)], cwd=self.work,
                              capture_output=True, text=True)

    def test_each_format_is_what_it_says(self):
        support.write_pair(self.work / "a")
        support.write_pair(self.work / "b", x_lag=0.2)
        for form, begin in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
            done = self.run_script("a", "--format", form)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual(done.stdout, f"a/trajectory.{form}\n")
            self.assertTrue((self.work / f"a/trajectory.{form}").read_bytes().startswith(begin))
        self.assertEqual(self.run_script("a", "b", "-o", "both.svg", "--quiet").stdout, "")
        self.assertTrue((self.work / "both.svg").read_bytes().startswith(b"<?xml"))
        self.assertEqual(sorted(p.name for p in self.work.iterdir()), ["a", "b", "both.svg"])

    def test_what_cannot_be_drawn_is_one_line(self):
        support.write_pair(self.work / "a")
        for arguments, code, text in (
                (("none",), 2, "none: no such directory"), ((".",), 2, "neither a run"),
                (("a", "--map"), 2, "one campaign"), (("a", "-o", "x.jpg"), 2, "must end in"),
                (("a", "-o", "x.png", "--format", "pdf"), 2, "ends in .png"),
                (("a", "-o", "none/x.png"), 1, "none/x.png: No such file or directory")):
            done = self.run_script(*arguments)
            self.assertEqual(done.returncode, code, arguments)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)

    def test_nothing_slow_is_loaded_and_nothing_near_gets_in_the_way(self):
        support.write_pair(self.work / "a")
        for name in ("numpy", "json", "ductile"):
            (self.work / f"{name}.py").write_text("raise SystemExit('the wrong one')")
        done = self.run_script("a")
        self.assertEqual(done.returncode, 0, done.stderr)
        program = ("import sys; sys.path[0] = sys.argv[1]\nfrom ductile import pictures\n"
                   "pictures.main([sys.argv[2], '--quiet'])\n"
                   "slow = {'pandas', 'scipy', 'h5py', 'matplotlib.pyplot'}\n"
                   "print(sorted(slow & set(sys.modules)))")
        done = subprocess.run([sys.executable, "-c", program, support.PACKAGE, self.work / "a"],
                              capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout, "[]\n")


@unittest.skipUnless(support.PROGRAM, "DUCTILE_PROGRAM names no program")
class Program(Directory):
    def test_defaults_are_the_programs(self):
        text = subprocess.run([support.PROGRAM, "keys"], check=True, capture_output=True,
                              text=True).stdout
        defaults, table = {}, None
        for line in text.splitlines():
            if heading := re.match(r"\[+(\w+)\]+", line):
                table = heading[1]
            elif entry := re.match(r"  (\w+) = (.*)$", line):
                try:
                    value = tomllib.loads(f"v = {entry[2]}")["v"]
                except tomllib.TOMLDecodeError:  # a rule, which begins with the usual value
                    value = re.match(r"\w*", entry[2])[0]
                defaults[f"{table}.{entry[1]}"] = value
                if table in ("membrane", "rigid"):
                    defaults[f"body.{entry[1]}"] = value
        self.assertGreater(len(defaults), 30)
        for key, value in parameters.DEFAULTS.items():
            self.assertEqual(defaults[key], value, key)

    def test_the_command_hands_over(self):
        support.write_pair(self.work / "a")
        done = subprocess.run([support.PROGRAM, "plot", "a", "--format", "svg"], cwd=self.work,
                              capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "a/trajectory.svg\n", ""))
        done = subprocess.run([support.PROGRAM, "plot", "a", "none"], cwd=self.work,
                              capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr),
                         (2, "", "none: no such directory\n"))


if __name__ == "__main__":
    unittest.main()
