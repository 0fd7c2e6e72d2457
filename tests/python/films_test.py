#!/usr/bin/python3
"""Pictures of surfaces and films: what is seen where, how large and in which colour; and files."""
import fcntl
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import support
import h5py
import numpy as np

import ductile
from ductile import display, films, refinement, rendering
from ductile.errors import DuctileError
from ductile.paper import making
from ductile.paper.study import Study
from paper_figures_test import Synthetic

if films.missing_packages():
    print(f"skipped: Debian's packages {' '.join(films.missing_packages())} are not installed")
    sys.exit(77)

SCRIPT = support.PACKAGE / "film.py"
RADIUS = 0.4
LEAD, LAG = 0, 2  # the channel of RGB that their colours, blue and vermilion, have least of


def write_run(directory, times, places, length=12.0, spins=None, forces=True, trajectory=True):
    """A run of spheres: `places` are functions of time, {name: t -> (x, y, z)}; `spins` angular
    velocities about y."""
    directory.mkdir(parents=True, exist_ok=True)
    times = np.asarray(times, float)
    columns = {"t": times}
    for name, place in places.items():
        at = np.array([place(t) for t in times], float).reshape(-1, 3)
        columns |= {f"{name}_{axis}": at[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"{name}_v{axis}": 0 * times for axis in "xyz"}
    if trajectory:
        support.write_trajectory(directory, columns)
    vertices, triangles = support.sphere(2)
    (directory / "frames").mkdir(exist_ok=True)
    with h5py.File(directory / "run.h5", "w") as overview:
        overview["channel/corners"] = [[x, y, z] for x in (-1, 1) for y in (-1, 1)
                                       for z in (-length / 2, length / 2)]
        overview.create_group("frames")
        for name in places:
            overview[f"bodies/{name}/triangles"] = triangles
        for n, t in enumerate(times):
            with h5py.File(directory / f"frames/{n:06}.h5", "w") as frame:
                frame.attrs["time"] = t
                for name, place in places.items():
                    at = np.array(place(t), float)
                    offset = length * np.floor(at[2] / length + 0.5)
                    frame[f"{name}/position"] = RADIUS * vertices + at - (0, 0, offset)
                    frame[name].attrs["z_offset"] = offset
                    spin = (spins or {}).get(name, 0.0)
                    frame[f"{name}/velocity"] = np.cross((0, spin, 0), RADIUS * vertices)
                    if forces:
                        frame[f"{name}/force"] = vertices
            overview[f"frames/{n:06}"] = h5py.ExternalLink(f"frames/{n:06}.h5", "/")


def pair(dz=1.2, z=0.0, speed=4.0):
    """Places of a pair that is carried along."""
    return {"lead": lambda t: (0.2, 0.0, z + dz / 2 + speed * t),
            "lag": lambda t: (-0.3, 0.1, z - dz / 2 + speed * t)}


def pixels_of(picture, body):
    """Where a picture has a body's colour, light or dark: walls and shadows are grey."""
    least, most = picture[..., body].astype(int), picture[..., 2 - body].astype(int)
    return most - least > 40


class Directory(unittest.TestCase):
    def setUp(self):
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        self.work = Path(own.name)

    def written(self, *arguments, **others):
        write_run(self.work, *arguments, **others)
        return ductile.read_run(self.work)

    def fails(self, text, call, *arguments, **others):
        with self.assertRaises(ductile.DuctileError) as caught:
            call(*arguments, **others)
        self.assertIn(text, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))


class Refined(unittest.TestCase):
    def test_a_coarse_sphere_becomes_a_smooth_one(self):
        vertices, triangles = support.sphere(1)
        fine = refinement.Refinement(triangles, 5000)
        self.assertEqual(len(fine.triangles), 80 * 4**3)
        places = fine.positions(vertices)
        np.testing.assert_array_equal(places[:len(vertices)], vertices)
        radii = np.linalg.norm(places, axis=1)
        # Chords of the mesh are 4% inside of the sphere.
        self.assertLess(np.abs(radii - 1).max(), 0.012)
        outwards = refinement.normals(places, fine.triangles)
        self.assertGreater((outwards * places).sum(axis=1).min(), 0.99)
        np.testing.assert_allclose(fine.values(vertices @ (1, 2, 3)).mean(), 0, atol=1e-12)
        area = refinement.vertex_areas(places, fine.triangles).sum()
        self.assertAlmostEqual(area / (4 * np.pi), 1, delta=0.01)

    def test_a_plane_stays_one_and_an_open_surface_is_left_alone(self):
        vertices, triangles = support.sphere(1)
        flat = refinement.Refinement(triangles, 1000).positions(vertices * (1, 1, 0))
        np.testing.assert_array_equal(flat[:, 2], 0)
        opened = refinement.Refinement(triangles[1:], 1000)
        self.assertEqual(len(opened.triangles), len(triangles) - 1)


class WhatIsSeen(Directory):
    def check(self, scene, frame, body, place):
        """A sphere is a disc of the right size in the right place."""
        seen = pixels_of(scene.image(frame), body)
        centre, width = scene.view(frame)
        scale = scene.size[0] / width
        self.assertAlmostEqual(seen.sum() / (np.pi * (RADIUS * scale)**2), 1, delta=0.025)
        rows, columns = np.nonzero(seen)
        x, y, z = place
        self.assertAlmostEqual(columns.mean() + 0.5, scene.size[0] / 2 + (z - centre) * scale,
                               delta=1)
        height = x * np.cos(rendering.RAISED) - y * np.sin(rendering.RAISED)
        self.assertAlmostEqual(rows.mean() + 0.5, scene.size[1] / 2 - height * scale, delta=1)

    def test_spheres_are_discs_where_they_belong(self):
        run = self.written([0, 1], pair())
        for size in ((800, 300), (640, 400)):
            scene = rendering.Scene(run, size=size, markers=False, labels=False)
            for frame in (0, 1):
                for body, name in ((LEAD, "lead"), (LAG, "lag")):
                    self.check(scene, frame, body, pair()[name](frame))

    def test_a_pair_is_together_across_the_periodic_end(self):
        # The leading one has gone through the end, by one period and by three.
        for behind in (12.0, 36.0):
            places = {"lead": lambda t: (0.2, 0, 6.6 + t - behind),
                      "lag": lambda t: (-0.3, 0, 5.4 + t)}
            run = self.written([0, 1, 2, 30], places)
            scene = rendering.Scene(run, markers=False, labels=False)
            for frame in range(4):
                t = run.times[frame]
                centre = scene.view(frame)[0]
                for body, x, dz in ((LEAD, 0.2, 0.6), (LAG, -0.3, -0.6)):
                    self.check(scene, frame, body, (x, 0, centre + dz))
                self.assertAlmostEqual((centre - 6 - t) % 12 % 12, 0, delta=1e-6)

    def test_bodies_that_part_stay_in_the_picture(self):
        places = {"lead": lambda t: (0.2, 0, 0.6 + 0.15 * t), "lag": lambda t: (-0.3, 0, -0.6)}
        run = self.written(np.arange(61.0), places)
        scene = rendering.Scene(run, size=(400, 150), markers=False, labels=False)
        widths = np.array([scene.view(frame)[1] for frame in range(61)])
        self.assertGreater(widths[-1], 1.3 * widths[0])
        self.assertLess(np.abs(np.diff(widths)).max(), 0.3)
        for frame in (0, 30, 45, 60):
            for body, name in ((LEAD, "lead"), (LAG, "lag")):
                self.check(scene, frame, body, places[name](frame))

    def test_periodic_images_are_paler(self):
        run = self.written([0], {"one": lambda t: (0, 0, 0.3)}, length=3.0)
        scene = rendering.Scene(run, markers=False, labels=False)
        picture, scale = scene.image(0).astype(int), 800 / scene.view(0)[1]
        own, image = (picture[150, int(400 + shift * scale)] for shift in (0, 3))
        self.assertGreater(image.min(), own.min() + 60)
        self.assertGreater(pixels_of(picture, LEAD)[:, 700:].sum(), 100)

    def test_only_the_time_tells_frames_of_a_steady_motion_apart(self):
        run = self.written([0, 0.1, 0.2], pair())
        scene = rendering.Scene(run)
        first, second = scene.image(0), scene.image(1)
        np.testing.assert_array_equal(first, scene.image(0))
        rows, columns = np.nonzero((first != second).any(axis=2))
        self.assertGreater(len(rows), 10)
        self.assertLess(rows.max(), 30)
        self.assertLess(columns.max(), 150)
        without = rendering.Scene(run, labels=False).image(0)
        dark = (first.max(axis=2) < 130) & (without.min(axis=2) > 220)
        self.assertGreater(dark[:30, :150].sum(), 60)  # t = 0.0 W^2/nu
        self.assertGreater(dark[220:, :80].sum(), 40)  # the axes
        self.assertEqual(dark[:200, 150:].sum(), 0)

    def test_frames_differ_where_bodies_move(self):
        run = self.written([0, 1], {"one": lambda t: (-0.2 + 0.3 * t, 0, 2 * t)})
        scene = rendering.Scene(run, labels=False)
        moved = scene.image(0) != scene.image(1)
        self.assertGreater(moved.any(axis=2).sum(), 2000)

    def test_markers_turn_with_the_surface(self):
        run = self.written([0, 1], pair())
        with h5py.File(self.work / "frames/000001.h5", "r+") as frame:
            turned, centre = support.sphere(2)[0], frame["lead/position"][...].mean(axis=0)
            angle = 0.4
            turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0],
                             [-np.sin(angle), 0, np.cos(angle)]])
            frame["lead/position"][...] = centre + RADIUS * turned @ turn.T
        changed = {}
        for markers in (True, False):
            scene = rendering.Scene(run, labels=False, markers=markers)
            first, second = (scene.image(frame).astype(int) for frame in (0, 1))
            changed[markers] = (np.abs(first - second).max(axis=2) > 60).sum()
        self.assertGreater(changed[True], 60)
        self.assertLess(changed[False], 30)

    def test_every_view_shows_both_bodies(self):
        run = self.written([0], pair())
        for view in rendering.VIEWS:
            picture = rendering.image(run, 0, view=view, size=(300, 300))
            self.assertEqual((picture.shape, picture.dtype), ((300, 300, 3), np.uint8))
            for body in (LEAD, LAG):
                self.assertGreater(pixels_of(picture, body).sum(), 400, view)

    def test_fields_have_colours_and_a_bar(self):
        run = self.written([0], pair(), spins={"lead": 5.0})
        by_body = rendering.image(run, 0)
        for colour in ("speed", "force", "x"):
            scene = rendering.Scene(run, colour=colour)
            picture = scene.image(0)
            bar = (picture.max(axis=2).astype(int) - picture.min(axis=2) > 60)[:28, 600:]
            self.assertGreater(bar.sum(), 300, colour)
            self.assertFalse(np.array_equal(picture, by_body))
        # The one that turns goes fastest at 2 nu/W, the other one does not.
        scene = rendering.Scene(run, colour="speed")
        self.assertEqual(scene.limits, (0, 2))
        picture, middle = scene.image(0).astype(int), 800 / scene.view(0)[1]
        spread = [np.ptp(picture[20 + 40:220, int(400 + z * middle) - 5:int(400 + z * middle) + 5],
                         axis=(0, 1)).max() for z in (0.6, -0.6)]
        self.assertGreater(spread[0], spread[1])
        self.assertEqual(rendering.Scene(run, colour="x").limits, (-0.8, 0.8))

    def test_a_surface_that_blew_up_is_left_out(self):
        run = self.written([0, 1], pair())
        with h5py.File(self.work / "frames/000001.h5", "r+") as frame:
            frame["lag/position"][3] = np.nan
        scene = rendering.Scene(run)
        self.assertGreater(pixels_of(scene.image(1), LEAD).sum(), 3000)
        self.assertEqual(pixels_of(scene.image(1), LAG).sum(), 0)
        self.assertGreater(pixels_of(scene.image(0), LAG).sum(), 3000)

    def test_what_cannot_be_shown_is_refused(self):
        run = self.written([0, 1], pair(), forces=False)
        self.fails("there are body, speed, force, x", rendering.image, run, 0, colour="red")
        self.fails("there are raised, side, top, front", rendering.image, run, 0, view="below")
        self.fails("has no frame 2: there are 2", rendering.image, run, 2)
        self.fails("no forces", rendering.image, run, 0, colour="force")
        self.fails("from 64 to 4096", rendering.image, run, 0, size=(10, 300))
        self.fails("none of those", rendering.Scene(run, [0]).image, 1)
        self.fails("there are lead, lag", rendering.shape, run, "none", 0)
        self.fails("either times or frames", rendering.shape_strip, run, "lag")


class Shapes(Directory):
    def test_a_shape_is_alone_and_fills_the_picture(self):
        run = self.written([0, 1], pair())
        picture = rendering.shape(run, "lag", 1, size=(200, 120), markers=False)
        self.assertEqual(picture.shape, (120, 200, 3))
        seen = pixels_of(picture, LAG)
        self.assertEqual(pixels_of(picture, LEAD).sum(), 0)
        self.assertTrue((picture[~seen] > 150).all())
        self.assertAlmostEqual(seen.any(axis=1).sum(), 120 / 1.06, delta=2)
        picture = rendering.shape(run, "lag", 1, size=(200, 200), across=1.6, markers=False)
        self.assertAlmostEqual(pixels_of(picture, LAG).sum() / (np.pi * 50**2), 1, delta=0.025)

    def test_a_strip_has_one_scale_and_the_times(self):
        run = self.written([0, 0.5, 1, 1.5], pair())
        strip = rendering.shape_strip(run, "lead", times=[0.1, 1.4], size=(150, 100))
        self.assertEqual(strip.shape[1], 300)
        own = [pixels_of(strip[:100, side], LEAD).sum()
               for side in (slice(150), slice(150, 300))]
        self.assertAlmostEqual(own[0] / own[1], 1, delta=0.01)
        dark = strip[100:].max(axis=2) < 130
        self.assertGreater(dark[:, :150].sum(), 60)
        self.assertGreater(dark[:, 150:].sum(), 60)
        bare = rendering.shape_strip(run, "lead", frames=[0, -1], size=(150, 100), labels=False)
        np.testing.assert_array_equal(bare, strip[:100])


def probe(file):
    """What ffprobe says of a film's stream."""
    said = subprocess.run(
        ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", file],
        check=True, capture_output=True, text=True).stdout
    stream, = json.loads(said)["streams"]
    return stream


def pictures_of(file, size):
    """A film's pictures, (n, height, width, 3)."""
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt",
                          "rgb24", "-"], check=True, capture_output=True).stdout
    return np.frombuffer(raw, np.uint8).reshape(-1, size[1], size[0], 3)


class Films(Directory):
    def test_a_film_is_what_it_says(self):
        run = self.written(np.arange(12) / 10, {
            "lead": lambda t: (0.5 - t, 0, 0.6 + 4 * t), "lag": lambda t: (0, 0, -0.6 + 4 * t)})
        file = self.work / "film.mp4"
        self.assertEqual(films.make(run, file, fps=10, size=(400, 150)), 12)
        stream = probe(file)
        self.assertEqual((stream["codec_name"], stream["pix_fmt"], stream["width"],
                          stream["height"], int(stream["nb_read_frames"])),
                         ("h264", "yuv420p", 400, 150, 12))
        self.assertAlmostEqual(float(stream["duration"]), 1.2, delta=0.01)
        content = file.read_bytes()
        self.assertLess(content.index(b"moov"), content.index(b"mdat"))
        self.assertLess(len(content), 50_000)
        scene = rendering.Scene(run, size=(400, 150))
        shown = pictures_of(file, (400, 150))
        for frame in (0, 6, 11):
            difference = np.abs(shown[frame].astype(int) - scene.image(frame))
            self.assertLess(difference.mean(), 2)
        self.assertGreater(np.abs(shown[0].astype(int) - shown[11]).mean(), 2)
        # Colours as they were, white as white.
        self.assertGreater(shown[0][:5, 200:].min(), 250)
        self.assertEqual(sorted(path.name for path in self.work.iterdir()),
                         ["film.mp4", "frames", "run.h5", "trajectory.csv"])

    def test_times_and_speed_choose_frames(self):
        run = self.written(np.arange(21) / 4, pair())
        chosen = films.chosen_frames
        self.assertEqual(chosen(run), list(range(21)))
        self.assertEqual(chosen(run, start=1, end=2), [4, 5, 6, 7, 8])
        self.assertEqual(chosen(run, start=4.9), [20])
        self.assertEqual(chosen(run, fps=10, speed=5), list(range(0, 21, 2)))
        self.assertEqual(chosen(run, fps=8, speed=1, end=0.5), [0, 0, 1, 1, 2])
        self.fails("from t = 6 to 5: they go from 0 to 5", chosen, run, start=6, end=5)
        self.fails("from t = 7 to 5:", chosen, run, start=7)
        self.fails("fps 0", chosen, run, fps=0)
        self.fails("speed -1", chosen, run, speed=-1)
        self.fails("more than 20000 pictures", chosen, run, speed=1e-4)

    def test_wrong_files_and_sizes_are_refused(self):
        run = self.written([0, 1], pair())
        self.fails("x.avi: must end in .mp4", films.make, run, "x.avi")
        self.fails("size 801x300: width and height must be even", films.make, run,
                   self.work / "x.mp4", size=(801, 300))
        with self.assertRaises(OSError):
            films.make(run, self.work / "none/x.mp4")
        with mock.patch.object(rendering.Scene, "image", side_effect=KeyboardInterrupt), \
                self.assertRaises(KeyboardInterrupt):
            films.make(run, self.work / "x.mp4")
        self.assertFalse(list(self.work.glob("x.mp4*")))

    def test_one_process_at_a_time_writes_a_film(self):
        file = self.work / "film.mp4"
        with open(f"{file}.part", "ab") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            with self.assertRaisesRegex(DuctileError, "film.mp4: another process is making it"):
                films._write(iter(()), file, 20, (64, 64))
            self.assertTrue(Path(held.name).exists())

    def test_what_is_not_installed_is_named(self):
        run = self.written([0, 1], pair())
        self.assertTrue(films.available() and rendering.available())
        with mock.patch.object(display.importlib.util, "find_spec", return_value=None), \
                mock.patch.object(display.shutil, "which", return_value=None):
            self.assertFalse(films.available() or rendering.available())
            self.fails("packages python3-vtk9 xvfb ffmpeg, not installed here: apt-get install",
                       films.make, run, self.work / "x.mp4")


class Report(Directory):
    """The media of a study's report, which a process a core draws."""

    def setUp(self):
        super().setUp()
        writer = Synthetic(self.work)
        for x_lag in (-0.2, 0.0, 0.2):
            writer.pair("M1", x_lag, "clean")
        for name in writer.cases["M1"]:
            write_run(self.work / "M1" / "cases" / name, [0, 40, 80], pair(), trajectory=False)
        self.cases = making._shown(Study(self.work))

    def drawn(self):
        """Whether each case has its film and everything else."""
        files = [[case.run.directory / name for name in ("trajectory.png", "shapes.png",
                                                         "poster.png", films.NAME)]
                 for case in self.cases]
        return [all(file.exists() for file in of_case) for of_case in files]

    def test_a_process_draws_its_share(self):
        self.assertEqual(len(self.cases), 3)
        making._draw_share(self.work, "1/3")
        self.assertEqual(self.drawn(), [False, True, False])

    def test_shares_are_drawn_side_by_side(self):
        there, own_media = [], making._media

        def media(case, with_films):
            there.append((case.label, (case.run.directory / films.NAME).exists()))
            return own_media(case, with_films)
        with mock.patch.object(making, "_media", media), \
                mock.patch.object(os, "sched_getaffinity", lambda _: {0, 1}):
            given = making._all_media(self.work, self.cases, True, lambda text: None)
        self.assertEqual(self.drawn(), [True] * 3)
        labels = [case.label for case in self.cases]
        self.assertEqual(list(given), labels)
        # Its own share first, then a look at all, where the other process has drawn the rest.
        self.assertEqual(there, [(labels[0], False), (labels[2], False)]
                         + [(label, True) for label in labels])

    def test_what_a_process_fails_to_draw_is_drawn(self):
        with mock.patch.object(making, "SCRIPT", self.work / "nowhere.py"), \
                mock.patch.object(os, "sched_getaffinity", lambda _: {0, 1}):
            given = making._all_media(self.work, self.cases, True, lambda text: None)
        self.assertEqual(self.drawn(), [True] * 3)
        for case in self.cases:
            self.assertEqual(given[case.label]["film"].name, films.NAME)


class CommandLine(Directory):
    command = [sys.executable, str(SCRIPT)]

    def run_script(self, *arguments, **others):
        return subprocess.run([*self.command, *map(str, arguments)], cwd=self.work,
                              capture_output=True, text=True, **others)

    def test_a_film_of_a_run(self):
        write_run(self.work / "a", np.arange(6) / 2, pair())
        done = self.run_script("a")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "a/film.mp4\n", ""))
        stream = probe(self.work / "a/film.mp4")
        self.assertEqual((int(stream["nb_read_frames"]), stream["width"], stream["height"]),
                         (6, 800, 300))
        done = self.run_script("a", "-o", "own.mp4", "--colour", "speed", "--fps", "5", "--size",
                               "320x160", "--from", "0.5", "--to", "2.5", "--speed", "1")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "own.mp4\n", ""))
        stream = probe(self.work / "own.mp4")
        self.assertEqual((int(stream["nb_read_frames"]), stream["r_frame_rate"], stream["width"]),
                         (11, "5/1", 320))

    def test_films_of_a_campaign(self):
        cases = self.work / "study/cases"
        for name in ("a", "b", "broken"):
            write_run(cases / name, [0, 1], pair())
        (cases / "broken/frames/000001.h5").unlink()
        support.write_pair(cases / "none")
        (self.work / "study/campaign.csv").write_text("case,state\na,\nb,\nnone,\nwaiting,\n")
        done = self.run_script("study", "--size", "160x80")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout, "study/cases/a/film.mp4\nstudy/cases/b/film.mp4\n")
        self.assertTrue((cases / "b/film.mp4").exists())
        (self.work / "study/campaign.csv").write_text("case,state\nbroken,\nb,\n")
        done = self.run_script("study", "--size", "160x80")
        self.assertEqual((done.returncode, done.stdout), (2, "study/cases/b/film.mp4\n"), done.stderr)
        self.assertIn("broken/frames/000001.h5: missing", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)

    def test_what_cannot_be_filmed_is_one_line(self):
        write_run(self.work / "a", [0, 1], pair())
        support.write_pair(self.work / "none")
        write_run(self.work / "empty", [], pair(), trajectory=False)
        support.write_pair(self.work / "empty", **{"output.surfaces_every": 0.0})
        (self.work / "study").mkdir()
        (self.work / "study/campaign.csv").write_text("case,state\na,\n")
        zero = "has no frames: the run was made with output.surfaces_every = 0"
        for arguments, code, text in (
                (("there",), 2, "there: no such directory"), ((".",), 2, "neither a run"),
                (("none",), 2, zero), (("empty",), 2, zero),
                (("study",), 2, "no run of the campaign has frames"),
                (("study", "-o", "x.mp4"), 2, "holds a campaign"),
                (("a", "--colour", "red"), 2, "colour 'red': there are body, speed, force, x"),
                (("a", "-o", "x.avi"), 2, "x.avi: must end in .mp4"),
                (("a", "--from", "3"), 2, "has no frames from t = 3 to 1"),
                (("a", "--size", "big"), 2, "must be like 800x300"),
                (("a", "--size", "801x300"), 2, "must be even"),
                (("a", "--size", "20x20"), 2, "from 64 to 4096"),
                (("a", "--fps", "0"), 2, "fps 0"), (("a", "--speed", "0"), 2, "speed 0"),
                (("a", "-o", "none/there/x.mp4"), 1, "none/there/x.mp4: No such file")):
            done = self.run_script(*arguments)
            self.assertEqual((done.returncode, done.stdout), (code, ""), arguments)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)

    def test_without_ffmpeg_and_xvfb_it_says_which_packages(self):
        write_run(self.work / "a", [0, 1], pair())
        (self.work / "bin").mkdir()
        done = self.run_script("a", env={**os.environ, "PATH": str(self.work / "bin")})
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertIn("packages xvfb ffmpeg, not installed", done.stderr)


@unittest.skipUnless(support.PROGRAM, "DUCTILE_PROGRAM names no program")
class Program(CommandLine):
    """The same by `ductile film`."""
    command = [support.PROGRAM, "film"]
    test_without_ffmpeg_and_xvfb_it_says_which_packages = None  # nor would MPI find its own

    def test_numbers_are_checked(self):
        write_run(self.work / "a", [0, 1], pair())
        done = self.run_script("a", "--fps", "many")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))


class Server(Directory):
    """The X server ends with the process, and asks for no display."""

    def test_it_stays_while_clients_come_and_go_and_ends_with_the_last(self):
        server, name, client = display._start_server()
        self.addCleanup(server.kill)
        for _ in range(3):
            display._client(int(name[1:])).close()
            with self.assertRaises(subprocess.TimeoutExpired):
                server.wait(0.3)
        client.close()
        self.assertEqual(server.wait(10), 0)

    def test_a_number_that_is_taken_is_left_to_its_server(self):
        servers, first = [], random.randrange(5000, 60000)
        with mock.patch.object(display, "NUMBERS", range(first, first + 3)):
            for _ in range(3):
                server, name, client = display._start_server()
                self.addCleanup(server.wait)
                self.addCleanup(client.close)
                servers.append(name)
            self.assertEqual(sorted(servers), sorted(f":{first + n}" for n in range(3)))
            self.fails("Xvfb does not start: ", display._start_server)

    def drawing(self, then):
        write_run(self.work, [0], pair())
        text = ("import sys; sys.path.insert(0, sys.argv[1])\n"
                "import ductile\nfrom ductile import display, rendering\n"
                "rendering.image(ductile.read_run(sys.argv[2]), 0)\n"
                f"print(display.window()._server.pid, flush=True)\n{then}")
        return subprocess.Popen(
            [sys.executable, "-c", text, support.PACKAGE, self.work], stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, env={**os.environ, "DISPLAY": ":4711"})

    def has_gone(self, number):
        for _ in range(100):
            if not Path(f"/proc/{number}").exists() or \
                    Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z":
                return True
            time.sleep(0.1)
        return False

    def test_it_ends_with_the_program(self):
        program = self.drawing("import os; assert os.environ['DISPLAY'] == ':4711'")
        said, errors = program.communicate()
        self.assertEqual((program.returncode, errors), (0, ""))
        self.assertTrue(self.has_gone(int(said)))

    def test_it_ends_with_one_that_is_killed(self):
        program = self.drawing("import time; time.sleep(60)")
        number = int(program.stdout.readline())
        program.send_signal(signal.SIGKILL)
        program.communicate()
        self.assertTrue(self.has_gone(number))


if __name__ == "__main__":
    unittest.main()
