"""What a picture says of a run's parameters: the few that make the case, what is not as usual, and
what differs between several runs."""
import re

# Defaults of the keys that a picture mentions only where a run has something else. Those of
# tests/python/pictures_test.py are the program's own (`ductile keys`).
DEFAULTS = {
    "channel.walls": "halfway", "channel.side_walls": True, "channel.symmetry": "none",
    "channel.half_width_y": 1.0, "channel.length": 12.0, "channel.wall_velocity": [0.0, 0.0],
    "channel.gravity": [0.0, 0.0, 0.0], "channel.start": "developed",
    "fluid.tau": 1.0, "fluid.collision": "bgk", "fluid.magic": 0.1875, "fluid.storage": "single",
    "fluid.equilibrium": "incompressible", "fluid.frame": "bodies",
    "membrane.retraction": "felt", "rigid.retraction": "felt", "rigid.slip": "felt",
    "body.law": "skalak", "body.area_ratio": 2.0, "body.bending": 0.00287, "body.mobility": 0.001,
    "body.integrator": "explicit-euler", "body.theta": 0.5, "body.substeps": 1, "body.edge": 1.2,
    "body.frequency": 0, "body.iterations": 5, "body.memory": 0.0, "body.roughness": 0.001,
    "body.interior": "fluid",
    "body.density_ratio": 1.0, "body.shape": "sphere", "body.radius": 0.4, "body.y": 0.0,
}

# What a key is called, and its unit; others by their own name.
_CALLED = {
    "channel.reynolds": ("Re", ""), "channel.length": ("$L$", "W"), "fluid.tau": (r"$\tau$", ""),
    "channel.half_width_y": ("half-width along y", "W"),
    "channel.wall_velocity": ("walls at", "nu/W"),
    "laplace": ("La", ""), "radius": ("$a$", "W"), "x": ("$x$", "W"), "y": ("$y$", "W"),
    "z": ("$z$", "W"), "area_ratio": ("$k_a/k_s$", ""), "bending": ("$k_b/k_s a^2$", ""),
    "theta": (r"$\theta$", ""), "edge": ("edge", "dx"), "retraction": ("retraction", "dx"),
    "rotation_angle": ("angle", "degrees"), "roughness": ("roughness", "radii"),
    "membrane.retraction": ("membrane retraction", "dx"),
    "rigid.retraction": ("rigid retraction", "dx"), "rigid.slip": ("rigid slip", "dx"),
}
# Neither physics nor method, or said otherwise: tables whose keys every body has for itself, and
# what follows from the lattice unless it is set. Where a surface is felt is told by the tables, in
# which it is as it was asked for, and a body's own value follows from the lattice.
_LEFT_OUT = re.compile(
    r"name|(run|output|petsc)\..*|membrane\.(?!retraction).*|rigid\.(?!retraction|slip).*|"
    r"body\.[^.]+\.(volume_modulus|retraction|slip)")


def bodies(parameters):
    """The names of the bodies, in the order of the parameters."""
    found = (re.match(r"body\.([^.]+)\.", key) for key in parameters)
    return list(dict.fromkeys(match[1] for match in found if match))


def number(value):
    """A value as a picture shows it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")
    if isinstance(value, list):
        return "(" + ", ".join(number(v) for v in value) + ")"
    return str(value)


def called(key):
    """(name, unit) of a key such as channel.reynolds, body.lag.x or, of all bodies, body.x; with
    matplotlib's mathematical text."""
    parts = key.split(".")
    own = key if parts[0] != "body" else parts[-1]
    name, unit = _CALLED.get(own, (parts[-1].replace("_", " "), ""))
    if parts[0] != "body" or len(parts) == 2:
        return name, unit
    if len(name.strip("$")) <= 2:
        body = parts[1].replace("_", r"\_")
        sign = name.strip("$") if name.startswith("$") else f"\\mathrm{{{name}}}"
        return f"${sign}_{{\\mathrm{{{body}}}}}$", unit
    return f"{name} of {parts[1]}", unit


def said(key, value):
    """A key and its value as a picture says it."""
    if value is None:
        return f"no {called(key)[0]}"
    if key == "channel.nodes":
        return f"{number(value)} nodes"
    if key == "channel.symmetry" and value == "y":
        return "half channel"
    if key == "channel.side_walls":
        return "walls at the sides" if value else "no side walls"
    if value == "felt":
        return f"{called(key)[0]} felt"
    if isinstance(value, str):
        if key == "fluid.frame":
            return f"lattice with the {value}"
        return {"regularized": "regularized walls", "halfway": "half-way walls",
                "rest": "from rest", "single": "single precision",
                "double": "double precision"}.get(value, value)
    name, unit = called(key)
    return f"{name} = {number(value)}{' ' if unit else ''}{unit}"


def together(parameters):
    """The parameters that a picture may mention, with those that all bodies share as body.KEY, and
    the fluid's precisions as one."""
    kept = {key: value for key, value in parameters.items() if not _LEFT_OUT.fullmatch(key)}
    kinds = {value for key, value in parameters.items() if re.fullmatch(r"body\..*\.kind", key)}
    for table, kind in (("membrane", "capsule"), ("rigid", "rigid")):
        for key in [key for key in kept if key.startswith(f"{table}.") and kind not in kinds]:
            del kept[key]
    if kept.get("fluid.collision") == "bgk":
        kept.pop("fluid.magic", None)
    # A body's own retraction is told where it is another than the table's: "felt" is never 0.
    for key, value in parameters.items():
        if own := re.fullmatch(r"body\.([^.]+)\.retraction", key):
            rigid = parameters.get(f"body.{own[1]}.kind") == "rigid"
            table = parameters.get("rigid.retraction" if rigid else "membrane.retraction", "felt")
            if value == 0 if table == "felt" else value != table:
                kept[key] = value
    arithmetic = kept.pop("fluid.arithmetic", "double")  # as it was before it had a key
    if kept.get("fluid.storage", arithmetic) != arithmetic:
        kept["fluid.storage"] = f"{kept['fluid.storage']} storage, {arithmetic} arithmetic"
    names = bodies(kept)
    for own in dict.fromkeys(key.split(".", 2)[2] for key in kept if key.startswith("body.")):
        having = [f"body.{name}.{own}" for name in names if f"body.{name}.{own}" in kept]
        values = [kept[key] for key in having]
        if all(value == values[0] for value in values):
            for key in having:
                del kept[key]
            kept[f"body.{own}"] = values[0]
    return kept


def headline(parameters, leave_out=()):
    """What a picture of one run says of it, as a list of short texts."""
    kept = together(parameters)
    own = [key.split(".")[-1] for key in kept if key.startswith("body.")]
    texts, mentioned = [], set(leave_out)

    def mention(key):
        if key in kept and key not in mentioned:
            texts.append(said(key, kept[key]))
        mentioned.add(key)
    mention("channel.reynolds")
    names = bodies(parameters)
    for field in ("kind", "shape", "laplace", "x"):
        if field not in own:
            continue
        for key in [f"body.{field}"] + [f"body.{name}.{field}" for name in names]:
            usual = {"kind": "capsule", "shape": "sphere"}.get(field)
            # The leading particle of the paper's pairs always starts at 0.2.
            paper = key == "body.lead.x" and names == ["lead", "lag"] and kept.get(key) == 0.2
            if kept.get(key) == usual or paper:
                mentioned.add(key)
            elif field in ("kind", "shape") and key != f"body.{field}" and key in kept:
                texts.append(f"{kept[key]} {key.split('.')[1]}")
                mentioned.add(key)
            else:
                mention(key)
    mention("channel.nodes")
    for key in kept:
        general = re.sub(r"^body\.[^.]+\.(?=[^.]+$)", "body.", key)
        if general in DEFAULTS and kept[key] != DEFAULTS[general]:
            mention(key)
    return texts


def differences(runs, at_most=4):
    """What differs between runs, given their parameters: {key: value or None} for each of them.

    Empty where nothing that a picture may mention differs, or too much to say.
    """
    merged = [together(parameters) for parameters in runs]
    # What bodies share is said as shared only where they share it in all runs.
    for kept, parameters in zip(merged, runs):
        for key in [key for key in kept if key.startswith("body.") and key.count(".") == 1]:
            if all(key in other for other in merged):
                continue
            value = kept.pop(key)
            for name in bodies(parameters):
                if f"body.{name}.{key[5:]}" in parameters:
                    kept[f"body.{name}.{key[5:]}"] = value
    keys = [key for key in dict.fromkeys(key for kept in merged for key in kept)
            if any(kept.get(key) != merged[0].get(key) for kept in merged)]
    return [{key: kept.get(key) for key in keys} if len(keys) <= at_most else {} for kept in merged]


def length(text):
    """About how many characters a text with mathematical text shows."""
    return len(re.sub(r"\$|\\(mathrm|tau|theta)|[{}_^]", "", text))


def wrapped(texts, width, most=2):
    """Texts with commas between, in lines of at most so many characters."""
    lines = [""]
    for n, text in enumerate(texts):
        text += "," if n + 1 < len(texts) else ""
        if lines[-1] and length(lines[-1]) + 1 + length(text) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + text
    if len(lines) > most:
        lines = lines[:most - 1] + [lines[most - 1].rstrip(",") + " ..."]
    return [line for line in lines if line]
