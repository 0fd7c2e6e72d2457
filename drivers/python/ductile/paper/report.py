"""The report that lays our reproduction beside the paper: one HTML file that needs no other, made
of report.html.j2, report.css and report.js beside this file.

`results`, all of whose parts must be there, is a dict of what JSON can hold:

    version     the program's version
    size        "quick", "default" or "paper"
    commands    the command lines that repeat it, a list
    duration_s  what it took, in seconds of wall time, or None
    methods     {"clean": METHOD, "paper": METHOD}; a METHOD has `title`, `summary`, and `settings`,
                {key: value} of texts
    counts      {"clean": COUNTS, "paper": COUNTS}; a COUNTS says of how many of the 35 pairs the
                outcome by this method is `same`, `differs`, `undecided` or `missing`. It must agree
                with the map
    map         35 entries, one for each pair and x_lag of the study: `pair`, `x_lag` [W];
                `paper`, with its `verdict`, the list `accepts` of verdicts that count as the same,
                and a `text` of what the paper says and where; `ours`, {"clean": RUN or None,
                "paper": RUN or None}; `finer`, {"clean": [RUN ...], "paper": [RUN ...]}, the same
                on finer lattices; `outcome`, one of those of COUNTS; `changes_with_resolution`;
                `explanation`, of a difference, or "". Rigid bodies are computed once: what is None of
                the pair M3 by the paper's is taken from "clean"
    statements  of the paper, in words: `id`, `figure` ("fig7") or None, `source` ("section 3.1.2"),
                what it `says`, `ours`, `outcome`: "confirmed", "not confirmed", "undecided",
                "not computed", or "depends on the method"; the `evidence`, and the `cases`
                that it rests on, a list of labels
    numbers     of the paper: `id`, `figure` or None, `source`, `quantity`, `unit`, the `paper`'s
                number or None and its `paper_text` ("close to 0.4"), `ours`, a list of dicts with
                `method`, `nodes`, `value`, `error` or None, and `case`; `outcome` as of a
                statement, or "ours alone" where the paper's text has no number; and a `remark`
                or ""

A RUN has the label of its `case`, `nodes` across the channel, `verdict` and `reason`, the `outcome`
against the paper ("same", "differs" or "undecided"), `time` [W^2/nu]; `dz`, `dz_limit` and
`dz_limit_error` [W]; of both bodies, {"lead": ..., "lag": ...}, their `x` [W], `strain_energy`
[k_s a^2], and whether that has settled, `strain_settled`. What is not known is None, as are
energies of rigid bodies.
"""
import base64
import math
import os
import re
import struct
from pathlib import Path

from .. import parameters
from ..errors import DuctileError
from ..runs import FOUR_TYPES
from ..style import VERDICT_COLOURS
from ..uncertainty import Value
from .study import METHODS, PAIRS, X_LAGS

_HERE = Path(__file__).resolve().parent
VERDICTS = tuple(VERDICT_COLOURS)
OUTCOMES = ("same", "differs", "undecided", "missing")
FINDINGS = ("confirmed", "not confirmed", "undecided", "not computed", "depends on the method",
            "ours alone")
# The outcome of a pair that has the shade of each.
_SHADES = (*OUTCOMES, "undecided", "missing")
_TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".mp4": "video/mp4", ".webm": "video/webm"}

# What a pair is made of.
_MADE_OF = {
    "M1": "two soft spheres, La = 10", "M2": "two stiff spheres, La = 100",
    "M3": "two rigid spheres", "B1": "soft sphere leads, soft biconcave cell lags, La = 10",
    "B2": "stiff sphere leads, stiff biconcave cell lags, La = 100",
    "B3": "soft sphere leads, La = 10, stiff one lags, La = 100",
    "B4": "stiff sphere leads, La = 100, soft one lags, La = 10",
}
RIGID = ("M3",)


def write(directory, results, figures, media, file):
    """Writes the report into `file`, by way of a file beside it, and gives its Path.

    `figures`: {id: {"file": svg or png, "title", "alt", "caption"}}, in their order, ids being
    "fig4" to "fig15". `media`: {label of a case: {"film", "poster", "trajectory", "shapes", each a
    file or None, "alt"}}. Relative paths are within `directory`. All files go into the report.
    Raises DuctileError where a part of the results or a file is missing.
    """
    validate(results)
    directory, file = Path(directory), Path(file)
    view = _view(results, _figures(directory, figures), _media(directory, media))
    part = file.with_name(file.name + ".part")
    try:
        with part.open("w", encoding="utf-8") as out:
            out.writelines(_template().generate(view))
        os.replace(part, file)
    except OSError as error:
        raise DuctileError(f"{file}: {error.strerror or error}") from error
    finally:
        part.unlink(missing_ok=True)
    return file


# Validation: a check takes a value and the place where it was found, and raises DuctileError.

def _refuse(place, what):
    raise DuctileError(f"results of the report: {place}: {what}")


def _text(value, place):
    if not isinstance(value, str):
        _refuse(place, f"is not a text but {value!r}")


def _name(value, place):
    """What becomes an anchor in the page."""
    _text(value, place)
    if not re.fullmatch(r"[\w.+-]+", value):
        _refuse(place, f"'{value}' is no identifier: letters, digits and _ . + - make one")


def _flag(value, place):
    if not isinstance(value, bool):
        _refuse(place, f"is neither true nor false but {value!r}")


def _number(value, place):
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        _refuse(place, f"is not a finite number but {value!r}")


def _count(value, place):
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        _refuse(place, f"is not a count but {value!r}")


def _word_of(*words):
    def check(value, place):
        if value not in words:
            _refuse(place, f"is none of {', '.join(words)} but {value!r}")
    return check


def _or_none(check):
    return lambda value, place: value is None or check(value, place)


def _list_of(check):
    def check_all(value, place):
        if not isinstance(value, (list, tuple)):
            _refuse(place, f"is not a list but {value!r}")
        for n, entry in enumerate(value):
            check(entry, f"{place}[{n}]")
    return check_all


def _texts_by_key(value, place):
    if not isinstance(value, dict):
        _refuse(place, f"is not a dict but {value!r}")
    for key, text in value.items():
        _text(text, f"{place}.{key}")


def _record(**fields):
    def check(value, place):
        if not isinstance(value, dict):
            _refuse(place, f"is not a dict but {value!r}")
        for key, check_field in fields.items():
            if key not in value:
                _refuse(place, f"has no '{key}'")
            check_field(value[key], f"{place}.{key}" if place != "all" else key)
    return check


def _both(check):
    return _record(**{method: check for method in METHODS})


def _of_bodies(check):
    return _record(lead=check, lag=check)


_RUN = _record(
    case=_text, nodes=_count, verdict=_word_of(*VERDICTS), reason=_text,
    outcome=_word_of("same", "differs", "undecided"), time=_or_none(_number), dz=_or_none(_number),
    dz_limit=_or_none(_number), dz_limit_error=_or_none(_number), x=_of_bodies(_or_none(_number)),
    strain_energy=_of_bodies(_or_none(_number)), strain_settled=_of_bodies(_or_none(_flag)))

_RESULTS = _record(
    version=_text, size=_text, commands=_list_of(_text), duration_s=_or_none(_number),
    methods=_both(_record(title=_text, summary=_text, settings=_texts_by_key)),
    counts=_both(_record(**{outcome: _count for outcome in OUTCOMES})),
    map=_list_of(_record(
        pair=_word_of(*PAIRS), x_lag=_number,
        paper=_record(verdict=_word_of(*VERDICTS), accepts=_list_of(_word_of(*VERDICTS)),
                      text=_text),
        ours=_both(_or_none(_RUN)), finer=_both(_list_of(_RUN)), outcome=_word_of(*OUTCOMES),
        changes_with_resolution=_flag, explanation=_text)),
    statements=_list_of(_record(
        id=_name, figure=_or_none(_name), source=_text, says=_text, ours=_text,
        outcome=_word_of(*FINDINGS), evidence=_text, cases=_list_of(_text))),
    numbers=_list_of(_record(
        id=_name, figure=_or_none(_name), source=_text, quantity=_text, unit=_text,
        paper=_or_none(_number), paper_text=_text,
        ours=_list_of(_record(method=_text, nodes=_count, value=_number, error=_or_none(_number),
                              case=_text)),
        outcome=_word_of(*FINDINGS), remark=_text)))


def validate(results):
    """Raises DuctileError, with a line that names the place, for results that lack a part, are not
    of all 35 pairs, or whose counts are not those of their map."""
    _RESULTS(results, "all")
    places = [(entry["pair"], _place(entry["x_lag"])) for entry in results["map"]]
    for pair in PAIRS:
        for x_lag in X_LAGS:
            found = places.count((pair, x_lag))
            if found != 1:
                _refuse("map", f"has {found or 'no'} entries of {pair} at x_lag = {x_lag:g}")
    if len(places) != len(PAIRS) * len(X_LAGS):
        _refuse("map", f"has {len(places)} entries, and the study has {len(PAIRS) * len(X_LAGS)}")
    for method in METHODS:
        outcomes = [run["outcome"] if run else "missing"
                    for run in (_ours(entry)[method] for entry in results["map"])]
        for outcome in OUTCOMES:
            said = results["counts"][method][outcome]
            if said != outcomes.count(outcome):
                _refuse(f"counts.{method}.{outcome}",
                        f"is {said}, and the map has {outcomes.count(outcome)}")
    for part in ("statements", "numbers"):
        names = [entry["id"] for entry in results[part]]
        for n, name in enumerate(names):
            if name in names[:n]:
                _refuse(f"{part}[{n}].id", f"'{name}' is there twice")


def _place(x_lag):
    """The x_lag of the study that this one is, or itself."""
    return next((x for x in X_LAGS if abs(x - x_lag) < 1e-9), x_lag)


def _ours(entry):
    """The runs of an entry of the map by method."""
    ours = dict(entry["ours"])
    if entry["pair"] in RIGID and ours["paper"] is None:
        ours["paper"] = ours["clean"]
    return ours


# Files, as they stand in the page.

def _read(directory, file, what):
    """(bytes, media type) of a file. Raises DuctileError."""
    path = directory / file
    kind = _TYPES.get(path.suffix.lower())
    if kind is None:
        raise DuctileError(f"{path}: {what} must end in {', '.join(_TYPES)}")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DuctileError(f"{path}: {what}: {error.strerror or error}") from error
    return content, kind


def _pixels(content, kind):
    """(width, height) of a picture in CSS pixels, or None where it does not say."""
    if kind == "image/png" and content[12:16] == b"IHDR":
        return struct.unpack(">II", content[16:24])
    if kind == "image/svg+xml":
        head = re.search(rb"<svg\b[^>]*>", content)
        size = [re.search(rb'\s%s="([\d.]+)(pt|px|)"' % name, head[0]) if head else None
                for name in (b"width", b"height")]
        if all(size):
            return tuple(round(float(found[1]) * (4 / 3 if found[2] == b"pt" else 1))
                         for found in size)
    return None


def _picture(directory, file, alt, what):
    """What an <img> needs: `source`, `alt`, `size`; None of no file."""
    if file is None:
        return None
    if not alt.strip():
        raise DuctileError(f"{file}: {what} has no text that says what it shows")
    content, kind = _read(directory, file, what)
    if not kind.startswith("image/"):
        raise DuctileError(f"{file}: {what} is no picture")
    return {"source": f"data:{kind};base64,{base64.b64encode(content).decode()}", "alt": alt,
            "size": _pixels(content, kind)}


def _figures(directory, figures):
    found = []
    for name, figure in figures.items():
        for part in ("file", "title", "alt", "caption"):
            if figure.get(part) is None:
                raise DuctileError(f"figures of the report: {name} has no {part}")
        found.append({"id": name, "title": figure["title"], "caption": figure["caption"],
                      "picture": _picture(directory, figure["file"], figure["alt"],
                                          f"the picture of {name}")})
    return found


def _media(directory, media):
    found = {}
    for case, parts in media.items():
        alt = parts.get("alt") or case
        film = None
        if parts.get("film") is not None:
            content, kind = _read(directory, parts["film"], f"the film of {case}")
            if not kind.startswith("video/"):
                raise DuctileError(f"{parts['film']}: the film of {case} is no film")
            film = {"base64": base64.b64encode(content).decode(), "type": kind,
                    "label": f"Film: {alt}",
                    "poster": _picture(directory, parts.get("poster"), alt,
                                       f"the first picture of the film of {case}")}
        found[case] = {"film": film} | {
            part: _picture(directory, parts.get(part), f"{title}: {alt}", f"the {part} of {case}")
            for part, title in (("trajectory", "Trajectories"), ("shapes", "Shapes"))}
    return found


# What the template is given.

def _anchor(entry):
    return f"{entry['pair']}_{_place(entry['x_lag']):g}"


def _columns(entry):
    """The runs of an entry in the order in which they are shown, with what each is called: the two
    methods' own, and those on finer lattices. A run that stands for both methods is there once."""
    ours = _ours(entry)
    if ours["clean"] and ours["paper"] and ours["clean"]["case"] == ours["paper"]["case"]:
        shown = [("both", ours["clean"])]
    else:
        shown = [(method, ours[method]) for method in METHODS if ours[method]]
    own = [dict(run, method=method, finer=False) for method, run in shown]
    seen = {run["case"] for run in own}
    for method in METHODS:
        for run in sorted(entry["finer"][method], key=lambda run: run["nodes"]):
            if run["case"] not in seen:
                seen.add(run["case"])
                own.append(dict(run, method="both" if entry["pair"] in RIGID else method,
                                finer=True))
    return [dict(run, n=n) for n, run in enumerate(own)]


def _cells(results, media):
    """{pair: [cell of each x_lag]}, with what the template shows of each."""
    by_place = {(entry["pair"], _place(entry["x_lag"])): entry for entry in results["map"]}
    names = {place: _anchor(entry) for place, entry in by_place.items()}
    rows = {}
    for p, pair in enumerate(PAIRS):
        rows[pair] = []
        for n, x_lag in enumerate(X_LAGS):
            entry = by_place[pair, x_lag]
            ours, columns = _ours(entry), _columns(entry)
            around = {"left": (p, n - 1), "right": (p, n + 1), "up": (p - 1, n),
                      "down": (p + 1, n)}
            computed = [run for run in ours.values() if run]
            own = {run["method"]: run["verdict"] for run in columns if not run["finer"]}
            rows[pair].append(dict(
                entry, x_lag=x_lag, id=names[pair, x_lag], ours=ours, columns=columns,
                neighbours={way: {"id": names[PAIRS[q], X_LAGS[m]], "pair": PAIRS[q],
                                  "x_lag": X_LAGS[m]}
                            for way, (q, m) in around.items()
                            if 0 <= q < len(PAIRS) and 0 <= m < len(X_LAGS)},
                same_on_finer=all(own.get(run["method"], run["verdict"]) == run["verdict"]
                                  for run in columns if run["finer"]),
                media={run["case"]: media[run["case"]] for run in columns if run["case"] in media},
                discussed=any(run["outcome"] != "same" for run in computed)
                or entry["outcome"] in ("differs", "undecided")
                or entry["changes_with_resolution"]))
    return rows


def _lattices(rows):
    """{method: the numbers of nodes across of its own runs, in words}, and those of finer ones."""
    said = {}
    for method in METHODS:
        for finer in (False, True):
            nodes = sorted({run["nodes"] for cells in rows.values() for cell in cells
                            for run in cell["columns"]
                            if run["finer"] == finer and
                            (run["method"] == method or (run["method"], method) == ("both",
                                                                                    "clean"))})
            said["finer" if finer else "own", method] = _listed([str(n) for n in nodes])
    return said


def _listed(words):
    """"a", "a and b", "a, b and c"."""
    return " and ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def _duration(seconds):
    """Wall time in words."""
    minutes = round(seconds / 60)
    if seconds < 100:
        return f"{seconds:.0f} s"
    if minutes < 120:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60:02d} min"


def _summary(counts):
    """What came of it, in a sentence."""
    said, verb = [], False
    for method, name in (("clean", "the clean method"), ("paper", "the paper's own")):
        same, missing = counts[method]["same"], counts[method]["missing"]
        computed = sum(counts[method].values()) - missing
        if not computed:
            said.append(f"by {name} none has been computed")
            continue
        of = f" of the {computed} computed" if missing else ""
        end = "" if verb else f" end{'s' if same == 1 else ''} as in the paper"
        said.append(f"{same or 'none'}{of}{end} by {name}")
        verb = True
    return (f"Of the {len(PAIRS) * len(X_LAGS)} pairs of the paper's Fig. 4, {said[0]}, and "
            f"{said[1]}.")


def _difference(number, ours):
    """How far a number of ours is from the paper's, in words; "" where it gives none."""
    if number["paper"] is None:
        return ""
    away = ours["value"] - number["paper"]
    if number["paper"] == 0:
        return parameters.number(float(f"{away:+.2g}"))
    share = 100 * away / abs(number["paper"])
    if abs(share) < 0.05:
        return "0%"
    sign = "+" if share > 0 else "\N{MINUS SIGN}"
    return f"{sign}{abs(share):.{1 if abs(share) < 1 else 0}f}%"


def _view(results, figures, media):
    rows = _cells(results, media)
    cells = [cell for row in rows.values() for cell in row]
    homes = {run["case"]: cell["id"] for cell in cells for run in cell["columns"]}
    tallies = {part: {outcome: sum(entry["outcome"] == outcome for entry in results[part])
                      for outcome in FINDINGS} for part in ("statements", "numbers")}
    own = [results["methods"][method]["settings"] for method in METHODS]
    return {
        "results": results, "summary": _summary(results["counts"]), "rows": rows, "cells": cells,
        "homes": homes, "figures": figures,
        "figure_ids": {figure["id"] for figure in figures}, "tallies": tallies,
        "duration": _duration(results["duration_s"]) if results["duration_s"] is not None else None,
        "lattices": _lattices(rows),
        "settings": [(key, [settings.get(key) for settings in own])
                     for key in dict.fromkeys(key for settings in own for key in settings)],
        "total": len(cells), "made_of": _MADE_OF, "x_lags": X_LAGS, "methods": METHODS,
        "verdicts": [(verdict, FOUR_TYPES.get(verdict, "not clear by the end of the run"))
                     for verdict in VERDICTS],
        "colours": VERDICT_COLOURS, "outcomes": OUTCOMES, "findings": FINDINGS, "shades": _SHADES,
        "css": (_HERE / "report.css").read_text(encoding="utf-8"),
        "js": (_HERE / "report.js").read_text(encoding="utf-8"),
    }


# Texts.

# What our texts and the program's write in ASCII, in text that is HTML already.
_PROSE = (
    (r"\b(La|Re|[a-z]_[a-z]+|dz) = (?=[-\d])", "\\1\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"),
    (r"&#34;(.*?)&#34;", "\N{LEFT DOUBLE QUOTATION MARK}\\1\N{RIGHT DOUBLE QUOTATION MARK}"),
    (r"(?<=\w)&#39;(?=\w)", "\N{RIGHT SINGLE QUOTATION MARK}"),
    (r"\+-", "\N{PLUS-MINUS SIGN}"), (r"(?<![\w.-])-(?=\d)", "\N{MINUS SIGN}"),
    (r"\bW\^2/nu\b", "W²/ν"), (r"\bnu/W\b", "ν/W"),
    (r"\bdz_([a-z]+)\b", r"Δ<i>z</i><sub>\1</sub>"), (r"\bdz\b", "Δ<i>z</i>"),
    (r"\b([A-Za-z])_([a-z]+)\b", r"<i>\1</i><sub>\2</sub>"),
    (r"(\w)\^-(\d+)", "\\1<sup>\N{MINUS SIGN}\\2</sup>"), (r"(\w)\^(\w+)", r"\1<sup>\2</sup>"),
)


def _prose(text):
    """A text as HTML, with its quantities set as such: x_lag, dz, W^2/nu, +-, -0.2, 10^-3."""
    from markupsafe import Markup, escape
    text = str(escape(text))
    for pattern, instead in _PROSE:
        text = re.sub(pattern, instead, text)
    return Markup(text)


def _shown(value, error=None):
    """A number with its error, both to two digits of that, or to four digits without."""
    from markupsafe import Markup
    if value is None:
        return "\N{EM DASH}"
    text = f"{value:.4g}" if not error or error < 0 else str(Value(value, error, error))
    text = text.replace("+-", "\N{PLUS-MINUS SIGN}").replace("-", "\N{MINUS SIGN}")
    return Markup(re.sub("e([+\N{MINUS SIGN}])0*(\\d+)",
                         lambda found: f"\N{THIN SPACE}·\N{THIN SPACE}10<sup>"
                         f"{found[1].replace('+', '')}{found[2]}</sup>", text))


def _template():
    try:
        import jinja2
    except ImportError as error:
        raise DuctileError("the report takes Debian's package python3-jinja2, which is not "
                           "installed") from error
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(_HERE), autoescape=True,
                                     undefined=jinja2.StrictUndefined, trim_blocks=True,
                                     lstrip_blocks=True)
    environment.filters |= {"prose": _prose, "shown": _shown, "listed": _listed,
                            "slug": lambda word: word.replace(" ", "-"),
                            "zip_with": lambda words, others: list(zip(words, others))}
    environment.globals["difference"] = _difference
    return environment.get_template("report.html.j2")
