#!/usr/bin/python3
"""Reading runs and campaigns: of today's program, of older ones, whole or cut off."""
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import support
import h5py
import numpy as np

import ductile


class Directory(unittest.TestCase):
    def setUp(self):
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        self.work = Path(own.name)

    def fails(self, text, call, *arguments):
        """The call raises DuctileError, whose one line names what is wrong."""
        with self.assertRaises(ductile.DuctileError) as caught:
            call(*arguments)
        self.assertIn(text, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))


class Runs(Directory):
    def test_a_table_with_units_and_bodies(self):
        support.write_pair(self.work)
        run = ductile.read_run(self.work)
        self.assertEqual(run.bodies, ["lead", "lag"])
        self.assertEqual(len(run.table), 201)
        self.assertEqual(list(run.table.columns[:3]), ["t", "lead_x", "lead_y"])
        self.assertEqual(run.units["t"], "W^2/nu")
        self.assertEqual(run.table.attrs["units"]["dz"], "W")
        t, dz = run.series("dz")
        np.testing.assert_array_equal(dz, run.table["dz"])
        self.assertEqual(run.parameters["body.lag.x"], -0.2)
        self.assertEqual(run.four_way, "stable pair")
        self.fails("no column lag_q", run.series, "lag_q")

    def test_new_columns_are_columns(self):
        columns = support.pair_columns(np.arange(3.0))
        columns |= {"lag_omega_y": [1, 2, 3], "flow_rate": [3, 3, 3], "lag_inclination": [1, 2, 3]}
        support.write_trajectory(self.work, columns, {"lag_omega_y": "nu/W^2"})
        run = ductile.read_run(self.work)
        self.assertEqual(run.bodies, ["lead", "lag"])
        self.assertEqual(list(run.table["lag_omega_y"]), [1, 2, 3])
        self.assertEqual(run.units["lag_omega_y"], "nu/W^2")

    def test_a_line_that_a_crash_cut_off_does_not_count(self):
        support.write_pair(self.work, t=np.arange(5.0))
        file = self.work / "trajectory.csv"
        whole = file.read_text()
        last = whole.splitlines()[-1]
        # Wherever it was cut: also in the last number, which then is another number.
        for length in (1, len(last) // 2, len(last) - 1, len(last)):
            file.write_text(whole + last[:length])
            self.assertEqual(len(ductile.read_run(self.work).table), 5, length)

    def test_what_is_no_run_or_no_trajectory_is_one_clear_error(self):
        self.fails("no such directory", ductile.read_run, self.work / "none")
        self.fails("has no trajectory.csv", ductile.read_run, self.work)
        file = self.work / "trajectory.csv"

        def table():
            return ductile.read_run(self.work).table
        for text, complaint in (("", "no whole line"), ("t[W^2/nu],a_x[W]", "no whole line"),
                                ("t[W^2/nu],a_x[W]\n", "no samples"), ("time,x\n1,2\n", "header"),
                                ("t[W^2/nu],a_x[W]\n1,2\n3\n", "columns"),
                                ("t[W^2/nu],a_x[W]\n1,2,3\n", "3 numbers a line under 2 names"),
                                ("t[W^2/nu],a_x[W]\n1,two\n", "two")):
            file.write_text(text)
            self.fails(complaint, table)
        file.write_bytes(b"\xff\xfe\x00")
        self.fails("cannot be read", table)

    def test_without_a_summary_parameters_come_from_the_scenario(self):
        support.write_pair(self.work, summary=False)
        (self.work / "scenario.toml").write_text(
            'name = "M1"\n[channel]\nnodes = 36\nwall_velocity = [0.0, 0.0]\n'
            '[petsc]\nmembrane_ksp_type = "cg"\n'
            '[[body]]\nname = "lead"\nx = 0.2\n[[body]]\nx = -0.2\n')
        run = ductile.read_run(self.work)
        self.assertEqual(run.parameters, {
            "name": "M1", "channel.nodes": 36, "channel.wall_velocity": [0.0, 0.0],
            "petsc.membrane_ksp_type": "cg", "body.lead.x": 0.2, "body.body2.x": -0.2})
        self.fails("goes on, or has been killed", lambda: run.summary)
        (self.work / "scenario.toml").write_text("name =")
        self.fails("is no TOML", lambda: ductile.read_run(self.work).parameters)

    def test_a_summary_without_parameters_is_an_older_one(self):
        support.write_pair(self.work)
        (self.work / "summary.json").write_text('{"scenario": "M1", "verdict": "undecided"}')
        (self.work / "scenario.toml").write_text("[channel]\nnodes = 24\n")
        run = ductile.read_run(self.work)
        self.assertEqual(run.parameters, {"channel.nodes": 24})
        self.assertIsNone(run.four_way)
        (self.work / "summary.json").write_text('{"scenario": "M1"}')
        self.fails("no verdict", lambda: ductile.read_run(self.work).four_way)
        (self.work / "summary.json").write_text("{")
        self.fails("is no JSON", lambda: ductile.read_run(self.work).summary)

    def test_the_papers_four_types(self):
        self.assertEqual(ductile.four_way("damped"), "stable pair with damped oscillations")
        self.assertEqual(ductile.four_way("bounded"), "stable pair with bounded oscillations")
        self.assertEqual(ductile.four_way("unstable"), "unstable pair")
        for nothing in ("undecided", None, "", float("nan")):
            self.assertIsNone(ductile.four_way(nothing))
        self.fails("no verdict", ductile.four_way, "stabel")


class Frames(Directory):
    def write_frames(self, times=(0.0, 0.5)):
        vertices, triangles = support.sphere(1)
        (self.work / "frames").mkdir()
        with h5py.File(self.work / "run.h5", "w") as overview:
            overview["bodies/one/triangles"] = triangles
            for n, time in enumerate(times):
                with h5py.File(self.work / f"frames/{n:06}.h5", "w") as frame:
                    frame.attrs["time"] = time
                    frame["one/position"] = vertices + [0, 0, 0.1]
                    frame["one"].attrs["z_offset"] = 12.0 * n
                    frame["one/velocity"] = np.ones_like(vertices)
                overview[f"frames/{n:06}"] = h5py.ExternalLink(f"frames/{n:06}.h5", "/")
        return vertices, triangles

    def test_surfaces_come_unwrapped(self):
        support.write_pair(self.work)
        vertices, triangles = self.write_frames()
        run = ductile.read_run(self.work)
        np.testing.assert_array_equal(run.times, [0, 0.5])
        for frame in (1, -1):
            surface = run.surfaces(frame)["one"]
            self.assertEqual(surface.time, 0.5)
            np.testing.assert_allclose(surface.vertices, vertices + [0, 0, 12.1])
            np.testing.assert_array_equal(surface.triangles, triangles)
            self.assertIsNone(surface.force)
            self.assertEqual(surface.velocity.shape, vertices.shape)
        self.fails("has no frame 2: there are 2", run.surfaces, 2)
        self.fails("has no surface of a body two", ductile.surface_angles, run, "two")

    def test_missing_frames_are_one_clear_error(self):
        support.write_pair(self.work)
        run = ductile.read_run(self.work)
        self.fails("the run wrote no surfaces", run.surfaces, 0)
        self.write_frames()
        (self.work / "frames/000001.h5").unlink()
        self.fails("frames/000001.h5: missing", run.surfaces, 1)
        (self.work / "run.h5").write_text("no HDF5")
        self.fails("cannot be read", run.surfaces, 0)


class Campaigns(Directory):
    def write_campaign(self):
        (self.work / "campaign.csv").write_text(
            "case,body.lag.x,channel.start,state,verdict,verdict_time[W^2/nu]\n"
            "a,-0.2,rest,done,stable,41\nb,0.2,rest,running,,\nc,0.4,dev")
        (self.work / "campaign.json").write_text('{"axes": ["body.lag.x", "channel.start"]}')
        support.write_pair(self.work / "cases/a")

    def test_a_row_a_case(self):
        self.write_campaign()
        campaign = ductile.read_campaign(self.work)
        self.assertEqual(campaign.cases, ["a", "b"])
        self.assertEqual(campaign.axes, ["body.lag.x", "channel.start"])
        self.assertEqual(list(campaign.table["body.lag.x"]), [-0.2, 0.2])
        self.assertEqual(campaign.table["verdict_time"][0], 41)
        self.assertTrue(np.isnan(campaign.table["verdict_time"][1]))
        self.assertEqual([ductile.four_way(v) for v in campaign.table["verdict"]],
                         ["stable pair", None])
        self.assertEqual(campaign.run("a").bodies, ["lead", "lag"])
        self.fails("has no case d", campaign.run, "d")
        self.fails("no such directory", campaign.run, "b")

    def test_what_is_no_campaign_is_one_clear_error(self):
        self.fails("has no campaign.csv", ductile.read_campaign, self.work)
        self.write_campaign()
        (self.work / "campaign.json").write_text(json.dumps({"axes": ["body.lag.y"]}))
        self.fails("body.lag.y", lambda: ductile.read_campaign(self.work).axes)
        (self.work / "campaign.json").unlink()
        self.fails("campaign.json: no such file", lambda: ductile.read_campaign(self.work).axes)
        (self.work / "campaign.csv").write_text("case,state\na\n")
        self.fails("line 2 has 1 fields under 2 names",
                   lambda: ductile.read_campaign(self.work).table)


@unittest.skipUnless(support.PROGRAM, "DUCTILE_PROGRAM names no program")
class Program(Directory):
    def test_files_of_the_program_itself(self):
        self.check_files()

    def test_files_of_membranes_inside_of_their_surfaces(self):
        self.check_files("--set", "membrane.retraction=0.4")

    def check_files(self, *options):
        run = self.work / "run"
        subprocess.run([support.PROGRAM, "pair", "M1", "--x-lag", "-0.2", "--nodes", "12",
                        "--length", "4", "--set", "run.time_limit=0.2", "--set", "output.surfaces_every=0.1",
                        *options, "-o", run], check=True, capture_output=True)
        run = ductile.read_run(run)
        self.assertEqual(run.bodies, ["lead", "lag"])
        self.assertEqual(run.parameters["channel.nodes"], 12)
        self.assertEqual(run.parameters["body.lag.x"], -0.2)
        self.assertEqual(run.parameters["body.lead.laplace"], 10)
        self.assertEqual(run.summary["status"], "time limit")
        self.assertEqual(len(run.times), 3)
        table = run.table.set_index("t")
        for frame in range(3):
            for body, surface in run.surfaces(frame).items():
                row = table.loc[run.times[frame]]
                moments = ductile.second_moments(surface.vertices, surface.triangles)
                # The program's centroid is that of the volume too.
                np.testing.assert_allclose(
                    moments.centroid, [row[f"{body}_{axis}"] for axis in "xyz"], atol=1e-10)
        series = ductile.surface_angles(run, "lead")
        for name in ("inclination", "tilt", "omega_y"):
            np.testing.assert_allclose(series[name][1:], table.loc[run.times[1:], f"lead_{name}"],
                                       atol=1e-6)


if __name__ == "__main__":
    unittest.main()
