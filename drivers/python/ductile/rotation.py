"""How a body turns: its angles from surfaces or from the columns of trajectory.csv, and the name of
its motion.

The plane of the shear is x-z, z being the flow's direction; a positive rotation about y turns z
towards x. Angles are in degrees, rates in 1/(W^2/nu), that is nu/W^2, in radians.

    inclination  of the longest axis of the second moments in the plane x-z, from z towards x,
                 (-90, 90]: atan2(2 M_xz, M_zz - M_xx)/2
    phase        of a marker, a point of the surface, about the centroid, from z towards x,
                 (-180, 180]: atan2(x - x_c, z - z_c); its rate is omega_y for a rigid turn
    tilt         of the shortest principal axis out of the plane x-z, 0 to 90: 0 is a disc that
                 tumbles in the plane, 90 one that rolls

An inclination says nothing where the section of the body in the plane is round, such as that of a
capsule at rest, and a tilt nothing where the two shorter axes are alike, as of a rod.
"""
from dataclasses import dataclass, field

import numpy as np
from scipy import stats

from .errors import DuctileError
from .fits import fit_line
from .uncertainty import ONE_SIGMA, TWO_SIGMA, Value

# Up to which a turn that is not foreseen counts as known, of half of what the angle repeats after.
_SURE = 0.75
# Beyond so many degrees an inclination swings, and an axis wobbles.
SWINGS = 5.0
WOBBLES = 10.0


# ------------------------------------------------------------------------------------------------
# Surfaces


@dataclass(frozen=True)
class Moments:
    """Of the volume inside a closed surface: `volume` [W^3], `centroid` [W], and the second moments
    `second` [W^5], M_ij, the integral of (r - r_c)_i (r - r_c)_j, shape (3, 3). The inertia tensor
    of unit density is trace(M) 1 - M."""
    volume: float
    centroid: np.ndarray
    second: np.ndarray


def second_moments(vertices, triangles):
    """Moments of the volume inside a closed surface of triangles, exact but for round-off.

    `vertices` [W], shape (n, 3); `triangles`, shape (m, 3), counterclockwise from outside. By the
    divergence theorem the integral of r_i r_j is that of r_i r_j (r . n)/5 over the surface: for a
    triangle (a, b, c), on which r . n is constant, (a . b x c)/120 times the sum of v_i v_j over
    the corners, and of s_i s_j, s = a + b + c. Raises DuctileError for a surface that encloses nothing.
    """
    vertices = np.asarray(vertices, float)
    around = vertices.mean(axis=0)  # bodies are far down the channel: no digits are lost
    corners = (vertices - around)[np.asarray(triangles)]
    six = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = six.sum() / 6
    if not volume > 0:
        raise DuctileError("the surface encloses no volume: its triangles are not closed, or not "
                           "counterclockwise from outside")
    sums = corners.sum(axis=1)
    centroid = six @ sums / (24 * volume)
    second = (np.einsum("t,tki,tkj->ij", six, corners, corners)
              + np.einsum("t,ti,tj->ij", six, sums, sums)) / 120
    return Moments(volume, around + centroid, second - volume * np.outer(centroid, centroid))


def inclination(second):
    """Inclination [degrees] of second moments, of shape (..., 3, 3)."""
    second = np.asarray(second)
    return np.degrees(0.5 * np.arctan2(2 * second[..., 0, 2],
                                       second[..., 2, 2] - second[..., 0, 0]))


def tilt(second):
    """Tilt [degrees] of second moments, of shape (..., 3, 3)."""
    shortest = np.linalg.eigh(np.asarray(second))[1][..., :, 0]
    return np.degrees(np.arcsin(np.minimum(np.abs(shortest[..., 1]), 1)))


def phase(marker, centroid):
    """Phase [degrees] of points of shape (..., 3) about a centroid."""
    apart = np.asarray(marker) - np.asarray(centroid)
    return np.degrees(np.arctan2(apart[..., 0], apart[..., 2]))


def surface_rotation(vertices, triangles, velocity):
    """Angular velocity [nu/W^2], shape (3,), of the rigid motion that fits the vertices' velocities
    [nu/W] best: least squares over the area, about the volume's centroid."""
    vertices = np.asarray(vertices, float)
    corners = vertices[np.asarray(triangles)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    thirds = np.linalg.norm(normals, axis=1) / 6
    areas = np.zeros(len(vertices))
    np.add.at(areas, np.asarray(triangles).ravel(), np.repeat(thirds, 3))
    apart = vertices - second_moments(vertices, triangles).centroid
    # v = V + omega x r: three rows a vertex, six unknowns.
    rows = np.zeros((len(vertices), 3, 6))
    rows[:, :, :3] = np.eye(3)
    x, y, z = apart.T
    rows[:, 0, 4], rows[:, 0, 5] = z, -y
    rows[:, 1, 3], rows[:, 1, 5] = -z, x
    rows[:, 2, 3], rows[:, 2, 4] = y, -x
    weight = np.sqrt(areas)[:, None]
    found = np.linalg.lstsq((rows * weight[:, :, None]).reshape(-1, 6),
                            (np.asarray(velocity) * weight).ravel(), rcond=None)[0]
    return found[3:]


def marker_of(vertices, centroid):
    """The index of the vertex whose phase is followed: of those nearest to the plane y = y_c the
    one furthest downstream, as the program chooses it at the start."""
    apart = np.asarray(vertices) - centroid
    # The plane may pass between vertices: all within half a mean spacing of it are near.
    near = np.sqrt(4 * np.pi / len(apart)) * np.abs(apart).max() / 2
    downstream = np.where(np.abs(apart[:, 1]) <= near, apart[:, 2], -np.inf)
    return int(np.argmax(downstream))


def surface_angles(run, body):
    """The angles of a body in all frames of a run, as a dict of arrays: "t" [W^2/nu],
    "inclination", "phase", "tilt" [degrees], and "omega_y" [nu/W^2] where frames have
    velocities."""
    columns = {name: [] for name in ("t", "inclination", "phase", "tilt", "omega_y")}
    marker = None
    for number in range(len(run.times)):
        surfaces = run.surfaces(number)
        if body not in surfaces:
            raise DuctileError(f"{run.directory}: has no surface of a body {body}")
        surface = surfaces[body]
        moments = second_moments(surface.vertices, surface.triangles)
        if marker is None:
            marker = marker_of(surface.vertices, moments.centroid)
        columns["t"].append(surface.time)
        columns["inclination"].append(inclination(moments.second))
        columns["tilt"].append(tilt(moments.second))
        columns["phase"].append(phase(surface.vertices[marker], moments.centroid))
        if surface.velocity is not None:
            columns["omega_y"].append(
                surface_rotation(surface.vertices, surface.triangles, surface.velocity)[1])
    if len(columns["omega_y"]) != len(columns["t"]):
        del columns["omega_y"]
    return {name: np.array(values) for name, values in columns.items()}


# ------------------------------------------------------------------------------------------------
# Series


def _unwrapped(t, angle, period, omega, what):
    t, angle = np.asarray(t, float), np.asarray(angle, float)
    if t.ndim != 1 or t.shape != angle.shape or len(t) < 2:
        raise DuctileError(f"a series of {what} has as many times as angles, two or more")
    steps = np.diff(angle)
    foreseen = np.zeros_like(steps)
    if omega is not None:
        omega = np.asarray(omega, float)
        foreseen = np.degrees(0.5 * (omega[1:] + omega[:-1]) * np.diff(t))
    steps -= period * np.round((steps - foreseen) / period)
    unsure = np.abs(steps - foreseen) > _SURE * period / 2
    if np.any(unsure):
        against = "" if omega is None else " against what omega_y says"
        raise DuctileError(
            f"the {what} turns by {steps[unsure][0]:.0f} degrees from t = "
            f"{t[:-1][unsure][0]:.4g} to {t[1:][unsure][0]:.4g}{against}, too far to tell which "
            "way: samples must be closer (output.every), or the body has no direction there")
    return angle[0] + np.concatenate([[0], np.cumsum(steps)])


def unwrapped_phase(t, angle, omega_y=None):
    """A phase [degrees] that goes on beyond 180, from one that repeats after 360.

    A step is the one nearest to what `omega_y` [nu/W^2] makes of it (by the trapezoid), without it
    the shortest: with it samples may be several turns apart, as long as omega_y is smooth. Raises
    DuctileError where a step is further than 135 degrees from that.
    """
    return _unwrapped(t, angle, 360, omega_y, "phase")


def unwrapped_inclination(t, angle, omega_y=None):
    """An inclination [degrees] that goes on beyond 90, from one that repeats after 180.

    The shortest steps are taken, or those nearest to `omega_y`, which is right only for a body
    that turns as a whole: a tank-treading one has omega_y and rests. Raises DuctileError where a
    step is further than 67.5 degrees from that.
    """
    return _unwrapped(t, angle, 180, omega_y, "inclination")


def angles(run, body):
    """The angles of a body against time: those of trajectory.csv where it has them, else those of
    the frames. A dict like that of surface_angles()."""
    table = run.table
    if f"{body}_x" not in table:
        raise DuctileError(f"{run.directory}: has no body {body}: there are "
                           f"{', '.join(run.bodies)}")
    names = ("inclination", "phase", "tilt", "omega_y")
    if all(f"{body}_{name}" in table for name in names):
        return {"t": table["t"].to_numpy(),
                **{name: table[f"{body}_{name}"].to_numpy() for name in names}}
    return surface_angles(run, body)


def _turning(t, unwrapped, turn):
    """Mean rate [radians per unit of time] of an unwrapped angle [degrees], as a Value.

    From three whole turns on (of `turn` degrees) their number over the time that they take, whose
    error is that of the mean of their durations; of fewer turns a straight line.
    """
    progress = unwrapped - unwrapped[0]
    sign = 1.0 if progress[-1] >= 0 else -1.0
    furthest = np.maximum.accumulate(sign * progress)
    count = int(furthest[-1] // turn)
    if count < 3:
        return fit_line(t, np.radians(unwrapped)).slope
    levels = turn * np.arange(count + 1)
    after = np.maximum(np.searchsorted(furthest, levels, side="right"), 1)
    after = np.minimum(after, len(t) - 1)
    low, high = furthest[after - 1], furthest[after]
    share = np.where(high > low, (levels - low) / np.where(high > low, high - low, 1), 0.0)
    times = t[after - 1] + np.clip(share, 0, 1) * (t[after] - t[after - 1])
    durations = np.diff(times)
    rate = sign * np.radians(turn) / durations.mean()
    error = abs(rate) * durations.std(ddof=1) / durations.mean() / np.sqrt(count)
    far = [stats.t.ppf(0.5 + 0.5 * level, count - 1) for level in (ONE_SIGMA, TWO_SIGMA)]
    return Value(rate, float(error * far[0]), float(error * far[1]))


@dataclass(frozen=True)
class Rotation:
    """How a body turns, over a window of time.

    `motion`: "tumbling", "wobbling", "swinging", "tank-treading", "rolling" or "resting"; see
    classify(). `shape_rate`, of the inclination, and `marker_rate`, of the phase [nu/W^2, radians];
    None where not even a mean is known. `inclination`, its mean, and `swing`, half its range
    [degrees], of a body whose shape does not turn, else None; `tilt`, its mean, and `wobble`, its
    range [degrees].
    """
    motion: str
    shape_rate: Value | None
    marker_rate: Value
    inclination: float | None
    swing: float | None
    tilt: float
    wobble: float
    t: np.ndarray = field(repr=False)
    unwrapped: dict = field(repr=False)

    def plot(self, axes):
        """Draws the unwrapped angles, and the mean turning of shape and marker."""
        styles = {"phase": ("#0072B2", self.marker_rate),
                  "inclination": ("#D55E00", self.shape_rate), "tilt": ("#009E73", None)}
        for name, values in self.unwrapped.items():
            colour, rate = styles[name]
            axes.plot(self.t, values, color=colour, linewidth=1.6, label=name)
            if rate is not None:
                middle = values.mean() - np.degrees(rate.value) * self.t.mean()
                axes.plot(self.t, middle + np.degrees(rate.value) * self.t, color=colour,
                          linewidth=0.9, linestyle=(0, (5, 2)))
        axes.set_xlabel(r"time  $t\,\nu/W^2$")
        axes.set_ylabel("angle  [degrees]")
        axes.legend(frameon=False)


def classify(series, start=None, end=None):
    """Names the motion of a body, from the dict that angles() gives, as a Rotation.

    Over the later half of the time by default. With the swing, half the range of the unwrapped
    inclination, and the wobble, the range of the tilt:

    rolling        the shortest axis stays within 30 degrees of y: the disc rolls like a wheel, and
                   has no longest axis in the plane
    wobbling       the tilt ranges over more than 10 degrees while the body turns: the axis about
                   which it tumbles varies, as the paper calls it (section 3.2.1)
    tumbling       the inclination goes through half a turn or more
    swinging       it does not, and swings by more than 5 degrees, while the marker goes round
    tank-treading  the inclination rests, and the marker goes round
    resting        neither turns

    "Goes round" is at least half a turn in the window. Raises DuctileError where samples are too
    far apart to follow the angles.
    """
    t = np.asarray(series["t"], float)
    kept = t >= (t[0] + 0.5 * (t[-1] - t[0]) if start is None else start)
    kept &= t <= (np.inf if end is None else end)
    if kept.sum() < 12:
        raise DuctileError(f"{kept.sum()} samples are too few to tell how a body turns")
    own = {name: np.asarray(values, float)[kept] for name, values in series.items()}
    t = own["t"]
    omega = own.get("omega_y")
    turned = unwrapped_phase(t, own["phase"], omega)
    marker = _turning(t, turned, 360)
    rounds = np.ptp(turned) >= 180
    tilts, wobble = own["tilt"], float(np.ptp(own["tilt"]))
    lines = {"phase": turned, "tilt": tilts}

    def result(motion, shape=None, mean=None, swing=None):
        return Rotation(motion, shape, marker, mean, swing, float(tilts.mean()), wobble, t, lines)
    if tilts.min() > 60:
        return result("rolling" if rounds else "resting")
    inclined = _inclined(t, own["inclination"], omega)
    lines["inclination"] = inclined
    shape = _turning(t, inclined, 180)
    tumbles = abs(inclined[-1] - inclined[0]) >= 180 or np.ptp(inclined) >= 180
    if (tumbles or rounds) and wobble > WOBBLES:
        return result("wobbling", shape)
    if tumbles:
        return result("tumbling", shape)
    mean, swing = float(inclined.mean()), float(np.ptp(inclined) / 2)
    if not rounds:
        return result("resting", shape, mean, swing)
    return result("swinging" if swing > SWINGS else "tank-treading", shape, mean, swing)


def _inclined(t, angle, omega):
    """The unwrapped inclination. The shortest steps are right for a shape that does not turn, about
    which omega_y says nothing; of one that does they may be wrong where samples are far apart, and
    omega_y tells."""
    try:
        shortest = unwrapped_inclination(t, angle)
    except DuctileError:
        if omega is None:
            raise
    else:
        if omega is None or np.ptp(shortest) < 180:
            return shortest
    return unwrapped_inclination(t, angle, omega)
