#!/usr/bin/python3
"""The report beside the paper: what is in the page, that it is sound HTML without any network, and,
where there is chromium, that it fits screens, opens cells, plays films, and does without scripts.
"""
import base64
import copy
import fcntl
import json
import os
import re
import select
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest
import zlib
from html.parser import HTMLParser
from pathlib import Path

import support  # noqa: F401  (where the package is)

from ductile.errors import DuctileError
from ductile.paper import report
from ductile.paper.study import PAIRS, X_LAGS

CHROMIUM = shutil.which("chromium")
FFMPEG = shutil.which("ffmpeg")
SIGNS = {"stable": "sign-stable", "damped": "sign-damped", "bounded": "sign-bounded",
         "unstable": "sign-unstable", "undecided": "sign-undecided", None: "sign-none"}

# Fig. 4 of the paper.
S, D, B, U = "stable", "damped", "bounded", "unstable"
FIG4 = {"M1": (S, S, S, S, S), "M2": (S, S, D, U, U), "M3": (U, S, U, U, U), "B1": (B, B, B, B, B),
        "B2": (S, S, U, U, U), "B3": (U, S, S, U, U), "B4": (U, S, U, U, U)}
# Where our verdicts are made up to be others, by method; None was not computed.
OTHERS = {("M2", 0.4, "paper"): "stable", ("B1", -0.2, "clean"): "stable",
          ("B1", -0.2, "paper"): "stable", ("B2", -0.4, "clean"): "undecided",
          ("B4", 0.4, "paper"): None, ("M3", 0.0, "clean"): "damped",
          ("B3", 0.4, "clean"): "bounded", ("B3", 0.4, "paper"): None,
          ("B4", 0.0, "clean"): None, ("B4", 0.0, "paper"): None}
NASTY = "a < b & \"c\" <script>alert('d')</script>"


def a_run(pair, x_lag, method, nodes, verdict, outcome):
    rigid = pair == "M3"
    return {"case": f"{pair}/{method}-{nodes}_lag-x_{x_lag:g}", "nodes": nodes, "verdict": verdict,
            "reason": {"unstable": "dz has come to 10 at t = 23.4",
                       "undecided": "dz falls by 0.012 per unit of time, towards 1.95 +- 0.2"
                       }.get(verdict, "dz approaches 1.212 +- 0.014"),
            "outcome": outcome, "time": 23.4 if verdict == "unstable" else 61.2,
            "dz": 10.003 if verdict == "unstable" else 1.2079,
            "dz_limit": None if verdict in ("unstable", "undecided") else 1.2124,
            "dz_limit_error": None if verdict in ("unstable", "undecided") else 0.0143,
            "x": {"lead": 0.28713, "lag": -0.00002},
            "strain_energy": dict.fromkeys(("lead", "lag"), None) if rigid
            else {"lead": 0.0587, "lag": 0.00154},
            "strain_settled": {"lead": None, "lag": None} if rigid
            else {"lead": True, "lag": method == "clean"}}


def made_up_results():
    """Results of all 35 cells, of which some differ, are undecided or missing."""
    entries, counts = [], {m: dict.fromkeys(report.OUTCOMES, 0) for m in report.METHODS}
    for pair, verdicts in FIG4.items():
        for x_lag, verdict in zip(X_LAGS, verdicts):
            ours = {}
            for method in report.METHODS:
                if pair == "M3" and method == "paper":
                    ours[method] = None  # stands for both
                    counts["paper"][ours["clean"]["outcome"]] += 1
                    continue
                own = OTHERS.get((pair, x_lag, method), verdict)
                outcome = {verdict: "same", "undecided": "undecided", None: "missing"
                           }.get(own, "differs")
                ours[method] = own and a_run(pair, x_lag, method, 36, own, outcome)
                counts[method][outcome] += 1
            found = [run["outcome"] for run in ours.values() if run]
            outcome = next((o for o in ("differs", "undecided", "same") if o in found), "missing")
            changes = (pair, x_lag) in (("B1", -0.2), ("M3", 0.0))
            finer = {"clean": [a_run(pair, x_lag, "clean", 48, verdict, "same")] if changes else [],
                     "paper": []}
            entries.append({
                "pair": pair, "x_lag": x_lag, "outcome": outcome, "finer": finer, "ours": ours,
                "paper": {"verdict": verdict, "text": f"Fig. 4 has {pair} at x_lag = {x_lag:g} "
                          f"{verdict}. Section 3: \"a quotation\" of W^2/nu and x_lag = -0.2.",
                          "accepts": [verdict, "damped"] if pair == "B4" and verdict == S
                          else [verdict]},
                "changes_with_resolution": changes,
                "explanation": "" if outcome in ("same", "missing") else
                "The strain energy of the lagging capsule grows without mobility, and with it the "
                "lift towards the centre; on 48 nodes dz comes to 1.21 +- 0.02."})
    return {
        "version": "1.2.3", "size": "default", "duration_s": 5025.0,
        "commands": ["./ductile.sh reproduce --default", "./ductile.sh reproduce --report <&>"],
        "methods": {
            "clean": {"title": "Clean", "summary": "Capsules with the membrane's mobility of 0.001 "
                      "and edges of 1.2 lattice spacings, which keeps strain from piling up.",
                      "settings": {"membrane.mobility": "0.001", "membrane.edge": "1.2",
                                   "channel.walls": "halfway", "fluid.tau": "1"}},
            "paper": {"title": "The paper's", "summary": "As the paper has it: no mobility, and "
                      "20480 triangles to a capsule.",
                      "settings": {"membrane.mobility": "0", "membrane.edge": "0.68",
                                   "channel.walls": "regularized", "fluid.tau": "1",
                                   "rigid.retraction": "0.5"}}},
        "counts": counts, "map": entries,
        "statements": [
            {"id": f"s{n}", "figure": figure, "source": source, "says": says, "ours": ours,
             "outcome": outcome, "evidence": "Ratios of migration times, 1.21 +- 0.02 and 1.34 +- "
             "0.03.", "cases": ["M1/clean-36_lag-x_-0.4", "single/clean-36_La10"]}
            for n, (figure, source, says, ours, outcome) in enumerate((
                ("fig7", "section 3.1.2", "A lagging particle at x_lag = 0.4 or -0.4 slows the "
                 "migration of the leading one down.", "It does.", "confirmed"),
                ("fig7", "section 3.1.2", NASTY, NASTY, "not confirmed"),
                ("fig8", "section 3.1.2", "The damping rate first does not vary significantly for "
                 "decreasing x_lag, but then increases sharply.", "Of 4 cases one is still under "
                 "way.", "undecided"),
                (None, "Appendix A", "The capsule settles on the diagonal.", "-", "not computed"),
                ("fig6", "section 3.1.2", "The steady dz of M1 at x_lag = 0.4 is twice as large as "
                 "that at -0.4.", "2.21 +- 0.05 against 1.18 +- 0.01.", "confirmed"),
                ("artefact", "section 3.1.2", "Released at x = 0.055 it goes to the centre.",
                 "by the clean method: no; by the paper's method: yes",
                 "depends on the method")))],
        "numbers": [
            {"id": "x-eq", "figure": "fig5", "source": "Fig. 5", "quantity": "x_eq, La = 100",
             "unit": "W", "paper": 0.3, "paper_text": "read off the figure, to 0.01",
             "ours": [{"method": "clean", "nodes": 36, "value": 0.28713, "error": 0.0021,
                       "case": "single/clean-36_La100"},
                      {"method": "paper", "nodes": 36, "value": 0.1214, "error": None,
                       "case": "single/paper-36_La100"}],
             "outcome": "confirmed", "remark": "By the clean method alone."},
            {"id": "period", "figure": "fig8", "source": "section 3.1.2",
             "quantity": "period of M2 at x_lag = 0", "unit": "W^2/nu", "paper": None,
             "paper_text": "not given", "ours": [{"method": "clean", "nodes": 36, "value": 1.3e-5,
                                                  "error": None,
                                                  "case": "M2/clean-36_lag-x_0"}],
             "outcome": "ours alone", "remark": ""},
            {"id": "none", "figure": None, "source": "Appendix A", "quantity": NASTY, "unit": "",
             "paper": 0.0, "paper_text": "", "ours": [], "outcome": "not computed",
             "remark": ""}],
    }


def png(width, height, colour=(0, 114, 178)):
    """The bytes of a picture of one colour."""
    def part(kind, content):
        return (struct.pack(">I", len(content)) + kind + content
                + struct.pack(">I", zlib.crc32(kind + content)))
    rows = (b"\0" + bytes(colour) * width) * height
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head)
            + part(b"IDAT", zlib.compress(rows)) + part(b"IEND", b""))


SVG = (b'<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="720pt" '
       b'height="300pt" viewBox="0 0 720 300"><path d="M0 0 720 300" stroke="#000"/></svg>\n')


def write_pictures(directory):
    """Tiny pictures and a film in a directory; the `figures` and `media` of a report."""
    for name, content in (("figure.svg", SVG), ("plot.png", png(400, 300)),
                          ("shapes.png", png(300, 80, (213, 94, 0))),
                          ("poster.png", png(64, 36, (0, 158, 115)))):
        (directory / name).write_bytes(content)
    film = directory / "film.mp4"
    if FFMPEG:
        subprocess.run([FFMPEG, "-loglevel", "error", "-y", "-f", "lavfi", "-i",
                        "testsrc=size=64x36:rate=5:duration=1", "-pix_fmt", "yuv420p", film],
                       check=True)
    else:
        film.write_bytes(b"\0\0\0\x18ftypmp42" + bytes(64))
    figures = {f"fig{n}": {"file": Path("figure.svg"), "title": f"Fig. {n}: a title & more",
                           "alt": f"Curves of figure {n} <x>",
                           "caption": "What is seen, with x_lag = -0.2 and 1.2 +- 0.1."}
               for n in range(4, 16)}
    media = {}
    for pair in PAIRS:
        for x_lag in X_LAGS:
            for how in ("clean-36", "paper-36", "clean-48"):
                media[f"{pair}/{how}_lag-x_{x_lag:g}"] = {
                    "film": film if how != "clean-48" else None, "poster": Path("poster.png"),
                    "trajectory": Path("plot.png"), "alt": f"{pair} & x_lag = {x_lag:g}",
                    "shapes": Path("shapes.png") if how == "clean-36" else None}
    return figures, media


class Page(HTMLParser):
    """A page taken apart: its mistakes, its elements, and what the cells of the map show."""
    VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source",
            "track", "wbr"}

    def __init__(self, text):
        super().__init__()
        self.mistakes, self.elements, self.stack, self.text = [], [], [], []
        self.cells, self.styles = {}, []
        self.feed(text)
        self.close()
        if self.stack:
            self.mistakes.append(f"not closed: {[tag for tag, _ in self.stack]}")

    def handle_starttag(self, tag, attrs):
        if len(dict(attrs)) != len(attrs):
            self.mistakes.append(f"an attribute twice in {attrs}")
        attrs = dict(attrs)
        self.elements.append((tag, attrs))
        block = {"p", "div", "table", "ul", "figure", "section", "h2", "h3", "h4", "dl", "pre"}
        if tag in block and any(open_tag == "p" for open_tag, _ in self.stack):
            self.mistakes.append(f"<{tag}> in a <p>, line {self.getpos()[0]}")
        if tag == "a" and any(open_tag == "a" for open_tag, _ in self.stack):
            self.mistakes.append(f"<a> in an <a>, line {self.getpos()[0]}")
        if tag not in self.VOID:
            self.stack.append((tag, attrs))
        by = next((a["data-by"] for _, a in reversed(self.stack) if "data-by" in a), None)
        cell = next((a["data-cell"] for _, a in self.stack if "data-cell" in a), None)
        if cell and tag == "td":
            self.cells[cell] = {"class": attrs["class"], "signs": {}, "words": {}, "links": []}
        elif cell and tag == "use" and by:
            self.cells[cell]["signs"][by] = attrs["href"][1:]
        elif cell and tag == "a":
            self.cells[cell]["links"].append(attrs["href"])

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.stack.pop()

    def handle_endtag(self, tag):
        if not self.stack or self.stack[-1][0] != tag:
            self.mistakes.append(f"</{tag}> in {[t for t, _ in self.stack]}, {self.getpos()[0]}")
        else:
            self.stack.pop()

    def handle_data(self, data):
        inside = [tag for tag, _ in self.stack]
        if "style" in inside:
            self.styles.append(data)
        elif "script" not in inside:
            self.text.append(data)
        by = next((a["data-by"] for _, a in reversed(self.stack) if "data-by" in a), None)
        cell = next((a["data-cell"] for _, a in self.stack if "data-cell" in a), None)
        if cell and by and any("word" in a.get("class", "").split() for _, a in self.stack):
            words = self.cells[cell]["words"]
            words[by] = words.get(by, "") + data

    def all(self, tag):
        return [attrs for name, attrs in self.elements if name == tag]


class Written(unittest.TestCase):
    """A report of made-up results, written once for all tests."""

    @classmethod
    def setUpClass(cls):
        own = tempfile.TemporaryDirectory()
        cls.addClassCleanup(own.cleanup)
        cls.work = Path(own.name)
        cls.results = made_up_results()
        cls.figures, cls.media = write_pictures(cls.work)
        cls.file = report.write(cls.work, cls.results, cls.figures, cls.media,
                                cls.work / "report.html")
        cls.html = cls.file.read_text(encoding="utf-8")
        cls.page = Page(cls.html)


class Content(Written):
    def test_it_is_sound(self):
        self.assertTrue(self.html.startswith("<!DOCTYPE html>\n<html lang="))
        self.assertEqual(self.page.mistakes, [])
        ids = [attrs["id"] for _, attrs in self.page.elements if "id" in attrs]
        self.assertEqual(sorted(ids), sorted(set(ids)))
        for tag, attrs in self.page.elements:
            href = attrs.get("href", "")
            if href.startswith("#"):
                self.assertIn(href[1:], ids)
            for key in ("aria-labelledby", "data-film"):
                if key in attrs:
                    self.assertIn(attrs[key], ids)
        self.assertFalse(list(self.work.glob("*.part")))

    def test_it_needs_no_network(self):
        links = set()
        for tag, attrs in self.page.elements:
            for key in ("src", "href", "poster", "srcset", "xlink:href", "data", "action"):
                address = attrs.get(key)
                if address is None or address.startswith(("#", "data:")):
                    continue
                self.assertEqual((tag, key), ("a", "href"), address)
                links.add(address)
        self.assertEqual(links, {"https://doi.org/10.1039/d1sm00276g"})
        for text in self.page.styles + [a["style"] for _, a in self.page.elements if "style" in a]:
            self.assertIsNone(re.search(r"url\(|@import|//", text))
        scripts = re.findall(r"<script>(.*?)</script>", self.html, re.DOTALL)
        self.assertEqual(len(scripts), 1)
        self.assertIsNone(re.search(r"https?:|fetch\(|import\b", scripts[0]))

    def test_pictures_and_films_can_be_read_out(self):
        pictures, films = self.page.all("img"), self.page.all("video")
        self.assertEqual(len(pictures), 12 + 34 * 2 + 27 + 2)  # figures, clean, paper, finer
        for picture in pictures:
            self.assertTrue(picture["alt"].strip())
            self.assertTrue(int(picture["width"]) and int(picture["height"]))
        self.assertEqual((pictures[-1]["width"], pictures[-1]["height"]), ("960", "400"))
        self.assertIn("Curves of figure 15 <x>", [picture["alt"] for picture in pictures])
        for film in films:
            self.assertTrue(film["aria-label"].startswith("Film: "))
            self.assertEqual((film["preload"], "controls" in film, "src" in film),
                             ("none", True, False))
            self.assertTrue(film["poster"].startswith("data:image/png;base64,"))
        data = re.findall(r'<script type="text/plain" id="[^"]*" data-type="video/mp4">([^<]*)<',
                          self.html)
        self.assertEqual(len(data), len(films))
        self.assertEqual(base64.b64decode(data[0]), (self.work / "film.mp4").read_bytes())
        for attrs in self.page.all("svg"):
            self.assertTrue(attrs.get("aria-hidden") == "true" or attrs.get("aria-label"))

    def test_every_cell_has_its_signs(self):
        self.assertEqual(len(self.page.cells), 35)
        panels = {attrs["id"] for tag, attrs in self.page.elements
                  if attrs.get("class") == "panel"}
        for entry in self.results["map"]:
            name = f"{entry['pair']}_{entry['x_lag']:g}"
            cell = self.page.cells[name]
            clean, paper = (entry["ours"][m] for m in ("clean", "paper"))
            paper = clean if entry["pair"] == "M3" else paper
            for by, verdict in (("paper", entry["paper"]["verdict"]),
                                ("ours-clean", clean and clean["verdict"]),
                                ("ours-paper", paper and paper["verdict"])):
                self.assertEqual(cell["signs"][by], SIGNS[verdict], (name, by))
                self.assertEqual(cell["words"][by].replace("≠", "").strip(),
                                 verdict or "not computed")
                self.assertEqual("≠" in cell["words"][by], by != "paper" and verdict not in (
                    None, "undecided", entry["paper"]["verdict"]), (name, by))
            self.assertIn(entry["outcome"], cell["class"].split())
            self.assertEqual(cell["links"], [f"#{name}"])
            self.assertIn(name, panels)

    def test_texts_are_text(self):
        self.assertNotIn("<script>alert", self.html)
        text = "".join(self.page.text)
        nasty = NASTY.replace('"c"', "\u201cc\u201d")
        self.assertGreaterEqual(text.count(nasty), 4)
        self.assertIn("./ductile.sh reproduce --report <&>", text)
        for part in ("towards 1.95 ± 0.2", "xlag\u00a0=\u00a0−0.2", "W²/ν", "10−5"):
            self.assertTrue(part in text, part)
        self.assertIn("M2/clean-36_lag-x_-0.4", text)

    def test_it_counts(self):
        counts = self.results["counts"]
        self.assertEqual([counts[m][o] for m in ("clean", "paper") for o in report.OUTCOMES],
                         [30, 3, 1, 1, 29, 3, 0, 3])
        text = "".join(self.page.text)
        for part in ("Of the 35 pairs of the paper’s Fig. 4, 30 of the 34 computed end as in the "
                     "paper by the clean method, and 29 of the 32 computed by the paper’s own.",
                     "84 min", "0.2871 ± 0.0021", "−4%", "changes with the resolution"):
            self.assertTrue(part in text, part)

    def test_summaries(self):
        none = {"same": 0, "differs": 0, "undecided": 0, "missing": 35}
        whole = {"same": 35, "differs": 0, "undecided": 0, "missing": 0}
        bad = {"same": 0, "differs": 35, "undecided": 0, "missing": 0}
        for clean, paper, text in (
                (whole, bad, "35 end as in the paper by the clean method, and none by the paper's "
                 "own."),
                (none, whole, "by the clean method none has been computed, and 35 end as in the "
                 "paper by the paper's own."),
                ({"same": 1, "differs": 1, "undecided": 0, "missing": 33}, none,
                 "1 of the 2 computed ends as in the paper by the clean method, and by the paper's "
                 "own none has been computed.")):
            self.assertEqual(report._summary({"clean": clean, "paper": paper}),
                             "Of the 35 pairs of the paper's Fig. 4, " + text)


class Refused(Written):
    def refused(self, change, text):
        results = copy.deepcopy(self.results)
        change(results)
        with self.assertRaisesRegex(DuctileError, text) as caught:
            report.write(self.work, results, self.figures, self.media, self.work / "other.html")
        self.assertNotIn("\n", str(caught.exception))
        self.assertFalse((self.work / "other.html").exists())

    def test_parts_that_are_missing_or_wrong(self):
        for change, text in (
                (lambda r: r.pop("counts"), "all: has no 'counts'"),
                (lambda r: r["map"][3]["ours"]["clean"].pop("dz"),
                 r"map\[3\].ours.clean: has no 'dz'"),
                (lambda r: r["map"][3]["ours"]["clean"].update(dz=float("nan")),
                 r"map\[3\].ours.clean.dz: is not a finite number but nan"),
                (lambda r: r["map"][0].update(outcome="fine"), r"map\[0\].outcome: is none of "),
                (lambda r: r["map"].pop(6), "map: has no entries of M2 at x_lag = -0.2"),
                (lambda r: r["map"].append(r["map"][0]), "has 2 entries of M1 at x_lag = -0.4"),
                (lambda r: r["map"].append(dict(r["map"][0], x_lag=0.3)),
                 "map: has 36 entries, and the study has 35"),
                (lambda r: r["counts"]["paper"].update(same=4),
                 "counts.paper.same: is 4, and the map has 29"),
                (lambda r: r["statements"][1].update(id="s0"), r"statements\[1\].id: 's0' is "),
                (lambda r: r["numbers"][0].update(id="a b"), "'a b' is no identifier"),
                (lambda r: r["numbers"][0].update(outcome="same"), "is none of confirmed"),
                (lambda r: r["methods"]["clean"].update(settings={"a": 1}),
                 "methods.clean.settings.a: is not a text but 1")):
            self.refused(change, text)
        with self.assertRaisesRegex(DuctileError, "all: is not a dict but None"):
            report.validate(None)

    def test_files_that_are_missing_or_wrong(self):
        for figures, media, text in (
                ({"fig5": dict(self.figures["fig5"], file="none.svg")}, {},
                 "none.svg: the picture of fig5: No such file"),
                ({"fig5": dict(self.figures["fig5"], file="a.pdf")}, {}, "a.pdf: .* must end in"),
                ({"fig5": dict(self.figures["fig5"], file="film.mp4")}, {}, "is no picture"),
                ({"fig5": dict(self.figures["fig5"], alt=" ")}, {}, "has no text that says"),
                ({"fig5": {"file": "figure.svg"}}, {}, "figures of the report: fig5 has no title"),
                ({}, {"M1/a": {"film": "plot.png"}}, "the film of M1/a is no film")):
            with self.assertRaisesRegex(DuctileError, text):
                report.write(self.work, self.results, figures, media, self.work / "other.html")
        with self.assertRaisesRegex(DuctileError, "none/report.html: No such file or directory"):
            report.write(self.work, self.results, {}, {}, self.work / "none/report.html")

    def test_what_has_not_been_computed_yet_is_a_page_too(self):
        results = copy.deepcopy(self.results)
        for entry in results["map"]:
            entry.update(ours={"clean": None, "paper": None}, finer={"clean": [], "paper": []},
                         outcome="missing", changes_with_resolution=False, explanation="")
        results["counts"] = {m: {"same": 0, "differs": 0, "undecided": 0, "missing": 35}
                             for m in report.METHODS}
        results.update(statements=[], numbers=[], commands=[], duration_s=None)
        for method in report.METHODS:
            results["methods"][method]["settings"] = {}
        file = report.write(self.work, results, {}, {}, self.work / "empty.html")
        page = Page(file.read_text(encoding="utf-8"))
        self.assertEqual(page.mistakes, [])
        self.assertEqual(len(page.cells), 35)


class Browser:
    """Chromium without a window, spoken to by its DevTools protocol over two pipes."""

    def __init__(self, directory):
        ours = []
        theirs = []
        for pair in (os.pipe(), os.pipe()[::-1]):  # they read from the first, write to the second
            theirs.append(fcntl.fcntl(pair[0], fcntl.F_DUPFD_CLOEXEC, 10))
            os.close(pair[0])
            ours.append(pair[1])
        self.to, self.back = ours
        self.log = (Path(directory) / "chromium.log").open("wb")
        self.process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
             "--disable-dev-shm-usage", "--disable-background-networking", "--disable-extensions",
             "--remote-debugging-pipe", f"--user-data-dir={directory}/profile", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log, close_fds=False,
            start_new_session=True,
            preexec_fn=lambda: [os.dup2(fd, n) for n, fd in enumerate(theirs, 3)])
        for fd in theirs:
            os.close(fd)
        self.count, self.session, self.rest, self.events = 0, None, b"", []
        try:
            self.attach()
        except Exception:
            self.close()
            raise

    def attach(self):
        target = self("Target.createTarget", url="about:blank")["targetId"]
        self.session = self("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self(f"{domain}.enable")
        self("Page.setLifecycleEventsEnabled", enabled=True)

    def __call__(self, method, **params):
        """The result of a command."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read(60)
            if answer is None:
                raise TimeoutError(f"chromium does not answer to {method}")
            if answer.get("id") == self.count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def read(self, seconds):
        """The next message, or None when there is none for so long; events are kept."""
        end = time.monotonic() + seconds
        while b"\0" not in self.rest:
            if not select.select([self.back], [], [], max(end - time.monotonic(), 0))[0]:
                return None
            more = os.read(self.back, 1 << 20)
            if not more:
                raise RuntimeError("chromium has ended")
            self.rest += more
        text, self.rest = self.rest.split(b"\0", 1)
        message = json.loads(text)
        if "method" in message:
            self.events.append(message)
        return message

    def open(self, address):
        """Goes to a page, and waits until it is loaded. Only a new document is loaded anew."""
        self("Page.navigate", url="about:blank")
        self.events.clear()
        document = self("Page.navigate", url=address)["loaderId"]
        while not any(event["method"] == "Page.lifecycleEvent"
                      and event["params"]["loaderId"] == document
                      and event["params"]["name"] == "load" for event in self.events):
            if self.read(60) is None:
                raise TimeoutError(f"{address} does not load")

    def value(self, expression):
        """What a JavaScript expression gives, which may be a promise."""
        answer = self("Runtime.evaluate", expression=expression, awaitPromise=True,
                      returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def screen(self, width, height, dark=False):
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
             mobile=width < 600)
        self("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def press(self, key, code=0, text=""):
        for kind in ("keyDown", "keyUp"):
            self("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code,
                 text=text if kind == "keyDown" else "")

    def settled(self):
        """Waits for the page to be laid out twice."""
        self.value("new Promise(f => requestAnimationFrame(() => requestAnimationFrame(f)))")

    def complaints(self):
        """Errors of the console, and what was asked of a network."""
        found = []
        for event in self.events:
            params = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                found.append(params["exceptionDetails"])
            elif event["method"] == "Runtime.consoleAPICalled" and params["type"] == "error":
                found.append(params["args"])
            elif event["method"] == "Log.entryAdded" and params["entry"]["level"] == "error":
                found.append(params["entry"]["text"])
            elif event["method"] == "Network.requestWillBeSent":
                address = params["request"]["url"]
                if not address.startswith(("file:", "data:", "blob:")):
                    found.append(address)
        return found

    def close(self):
        try:
            self.session = None
            self("Browser.close")
            self.process.wait(20)
        except (OSError, RuntimeError, TimeoutError, subprocess.TimeoutExpired):
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        os.close(self.to)
        os.close(self.back)
        self.log.close()


# What of the page reaches beyond the screen's right edge, but for what scrolls in a box of its own.
TOO_WIDE = """[...document.querySelectorAll("body *")].filter(e => {
  const r = e.getBoundingClientRect();
  return r.width && r.right > innerWidth + 0.5
      && !e.closest(".box, pre, .contents, .unseen, .store");
}).map(e => e.outerHTML.slice(0, 90))"""


@unittest.skipUnless(CHROMIUM, "there is no chromium")
class InABrowser(Written):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = Browser(cls.work)
        cls.addClassCleanup(cls.browser.close)
        cls.address = cls.file.as_uri()

    def shown(self):
        """The panels that are seen."""
        return self.browser.value("[...document.querySelectorAll('.panel')].filter("
                                  "p => p.getBoundingClientRect().height > 100).map(p => p.id)")

    def test_it_fits_the_screen(self):
        for width, height in ((1280, 800), (390, 844)):
            for dark in (False, True):
                for where in ("", "#M1_-0.4", "#B1_-0.2", "#M3_0"):
                    self.browser.screen(width, height, dark)
                    self.browser.open(self.address + where)
                    self.browser.value("document.querySelectorAll('details').forEach("
                                       "d => d.open = true)")
                    self.browser.settled()
                    wide, inner = self.browser.value(
                        "[document.documentElement.scrollWidth, innerWidth]")
                    self.assertEqual(inner, width)
                    self.assertLessEqual(wide, inner, self.browser.value(TOO_WIDE))
                    self.assertEqual(self.browser.value(TOO_WIDE), [])
                    self.assertEqual(self.shown(), [where[1:]] if where else [])
                    self.assertEqual(self.browser.complaints(), [])

    def test_a_cell_opens_by_key_and_closes(self):
        self.browser.screen(1280, 800)
        self.browser.open(self.address)
        self.browser.value("document.querySelector('.map a[href=\"#B2_-0.4\"]').focus()")
        self.browser.press("Enter", 13, "\r")
        self.browser.settled()
        self.assertEqual(self.shown(), ["B2_-0.4"])
        self.assertEqual(self.browser.value("document.activeElement.id"), "B2_-0.4")
        self.assertEqual(self.browser.value(
            "[...document.querySelectorAll('[aria-current]')].map(a => a.hash)"), ["#B2_-0.4"])
        self.browser.value("document.querySelector('#B2_-0\\\\.4 nav a').click()")
        self.browser.settled()
        self.assertEqual(self.shown(), ["B2_-0.2"])
        self.browser.press("Escape", 27)
        self.browser.settled()
        self.assertEqual(self.shown(), [])
        self.assertEqual(self.browser.value("document.activeElement.hash"), "#B2_-0.2")
        self.assertEqual(self.browser.complaints(), [])

    @unittest.skipUnless(FFMPEG, "there is no ffmpeg to make a film")
    def test_films_open_with_their_cell_alone(self):
        self.browser.screen(1280, 800)
        self.browser.open(self.address + "#M2_0")
        self.assertEqual(self.browser.value(
            "[...document.querySelectorAll('video')].filter(v => v.src).map("
            "v => v.closest('.panel').id + ' ' + v.src.slice(0, 5))"), ["M2_0 blob:"] * 2)
        self.assertEqual(self.browser.value("""new Promise(done => {
            const film = document.querySelector("#M2_0 video");
            film.onloadeddata = () => done([film.videoWidth, film.videoHeight]);
            film.onerror = () => done(film.error.message);
            film.preload = "auto";
            film.load();
        })"""), [64, 36])
        self.assertEqual(self.browser.complaints(), [])

    def test_tables_are_filtered_by_outcome(self):
        self.browser.screen(1280, 800)
        self.browser.open(self.address)
        for part in ("statements", "numbers"):
            for outcome in (*report.FINDINGS, "all"):
                name = f"{part}-filter-{outcome.replace(' ', '-')}"
                self.browser.value(f"document.getElementById('{name}').click()")
                seen = self.browser.value(
                    f"[...document.querySelectorAll('#{part} [data-outcome]')].filter("
                    "e => e.getBoundingClientRect().height).length")
                wanted = [entry for entry in self.results[part]
                          if outcome in ("all", entry["outcome"])]
                if wanted:  # else it cannot be chosen
                    self.assertEqual(seen, len(wanted), name)

    def test_it_does_without_scripts(self):
        self.browser.screen(390, 844)
        self.browser("Emulation.setScriptExecutionDisabled", value=True)
        try:
            self.browser.open(self.address + "#B4_0.4")
            self.assertEqual(self.shown(), ["B4_0.4"])
            self.assertIn("which takes JavaScript to play", self.browser.value(
                "document.querySelector('#B4_0\\\\.4').innerText"))
        finally:
            self.browser("Emulation.setScriptExecutionDisabled", value=False)

    def test_texts_stand_out(self):
        """Contrasts of 4.5 to 1 of texts against what is behind them, and 3 to 1 of signs."""
        for dark in (False, True):
            self.browser.screen(1280, 800, dark)
            self.browser.open(self.address + "#B1_-0.2")
            self.assertEqual(self.browser.value("""(() => {
                const pixel = new OffscreenCanvas(1, 1).getContext("2d");
                const over = colours => {
                  pixel.clearRect(0, 0, 1, 1);
                  for (const colour of colours) {
                    pixel.fillStyle = colour;
                    pixel.fillRect(0, 0, 1, 1);
                  }
                  return [...pixel.getImageData(0, 0, 1, 1).data].slice(0, 3);
                };
                const light = rgb => rgb.map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92
                    : ((c + 0.055) / 1.055) ** 2.4).reduce((s, c, i) =>
                    s + c * [0.2126, 0.7152, 0.0722][i], 0);
                const behind = e => {
                  const colours = [];
                  for (; e; e = e.parentElement) {
                    colours.unshift(getComputedStyle(e).backgroundColor);
                  }
                  return colours;
                };
                const bad = new Set();
                const check = (e, least) => {
                  if (!e.getBoundingClientRect().width || e.closest(".unseen, .no")) return;
                  const back = behind(e), ink = getComputedStyle(e).color;
                  const [a, b] = [light(over(back)), light(over([...back, ink]))];
                  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
                  if (ratio < least) bad.add(ratio.toFixed(2) + " " + e.outerHTML.slice(0, 80));
                };
                const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
                while (walk.nextNode()) {
                  if (walk.currentNode.data.trim()) check(walk.currentNode.parentElement, 4.5);
                }
                for (const sign of document.querySelectorAll(".sign:not(.none)")) {
                  check(sign, 3);
                }
                return [...bad];
            })()"""), [])


if __name__ == "__main__":
    unittest.main()
