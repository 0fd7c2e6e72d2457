"""Pictures of bodies in the channel, in three dimensions, with VTK.

    rendering.image(run, frame)              the bodies of a frame in the channel
    rendering.Scene(run, frames)             the same for many frames, one after the other
    rendering.shape(run, body, frame)        a body's shape alone
    rendering.shape_strip(run, body, times)  its shapes at some times, side by side

All give RGB arrays of shape (height, width, 3), uint8, on white. The projection is parallel: a
length in W is so many pixels wherever it lies, and a sphere is a disc. They take Debian's packages
python3-vtk9 and xvfb: see display.py.

A run's frames are told by their numbers, as in Run.surfaces; -1 is the last.
"""
import functools

import numpy as np

from . import display, refinement
from .errors import DuctileError
from .style import BLACK, COLOURS, GREY, SETTINGS

COLOUR_BY = {  # what colours can show: label of the colour bar, and map
    "body": None,
    "speed": (r"$|v - \overline{v}|$  [$\nu/W$]", "viridis"),
    "force": (r"$|f|$  [$\rho\nu^2/W^2$]", "viridis"),
    "x": (r"$x$  [$W$]", "coolwarm"),
}
RAISED = np.radians(20)
VIEWS = {  # the axes that point to the right, and upwards; the eye is on the side of their product
    "raised": ((0, 0, 1), (np.cos(RAISED), -np.sin(RAISED), 0)),
    "side": ((0, 0, 1), (1, 0, 0)),
    "top": ((0, 0, 1), (0, -1, 0)),
    "front": ((0, 1, 0), (1, 0, 0)),
}
WALL, FLOOR, SHADOW, EDGE, FAR_EDGE = "#f1f3f5", "#e7eaed", "#c9ced3", "#7f8890", "#b9c0c6"
PALER = 0.55  # share of white in the colour of a periodic image
MARGIN = 1.24  # of the picture's height, against the channel's
ROOM = 1.0  # W: beside the bodies, where they set the width
FAR = 100.0  # W: from the eye to the middle
MARKERS = 0.026  # W: radius of the points that show how a surface turns


def available():
    """Whether pictures can be made here: if VTK and Xvfb are installed."""
    return not display.missing_packages()


def _rgb(colour):
    from matplotlib.colors import to_rgb
    return np.array(to_rgb(colour))


class _Surface:
    """A surface for VTK, whose points are moved from picture to picture."""

    def __init__(self, triangles, count):
        from vtkmodules.util import numpy_support
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
        self.triangles = np.asarray(triangles)
        # VTK reads and does not own the arrays.
        self._points = np.zeros((count, 3), np.float32)
        self._normals = np.zeros((count, 3), np.float32)
        self._colours = np.zeros((count, 3), np.uint8)
        self._cells = np.ascontiguousarray(self.triangles, np.int64)
        own = [numpy_support.numpy_to_vtk(array) for array in (self._points, self._normals,
                                                               self._colours)]
        points = vtkPoints()
        points.SetData(own[0])
        cells = vtkCellArray()
        cells.SetData(3, numpy_support.numpy_to_vtkIdTypeArray(self._cells.ravel()))
        self.data = vtkPolyData()
        self.data.SetPoints(points)
        self.data.SetPolys(cells)
        self.data.GetPointData().SetNormals(own[1])
        self.data.GetPointData().SetScalars(own[2])
        self._arrays = own

    def move(self, vertices, normals, colours=None):
        """`colours`: RGB, 0 to 1."""
        self._points[...] = vertices
        self._normals[...] = normals
        if colours is not None:
            self._colours[...] = np.round(255 * colours)
        for array in (*self._arrays, self.data.GetPoints(), self.data):
            array.Modified()

    def actor(self, colour=None, lit=True):
        """Draws it in a colour, or with None in those of its points."""
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(self.data)
        mapper.SetScalarVisibility(colour is None)
        actor = vtkActor()
        actor.SetMapper(mapper)
        own = actor.GetProperty()
        own.SetInterpolationToPhong()
        own.SetLighting(lit)
        # Of a field the colour is to be read, of a body the shape.
        own.SetAmbient(1 if not lit else 0.36 if colour is not None else 0.55)
        own.SetDiffuse(0 if not lit else 0.7 if colour is not None else 0.56)
        own.SetSpecular(0.16)
        own.SetSpecularPower(16)
        if colour is not None:
            own.SetColor(*colour)
        return actor


class _Body:
    """A body as it is drawn: its surface, finer than the mesh, and points that go with it.

    The points are the mesh's vertices with other than six neighbours: of a divided icosahedron its
    twelve corners.
    """

    def __init__(self, surface, colour, markers, scale):
        """`colour`: RGB, 0 to 1, or None where a field gives it. `scale`: pixels for a W."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkFiltersSources import vtkSphereSource
        # Edges whose chords are a tenth of a pixel off, on a sphere of the same width.
        radius = np.ptp(surface.vertices, axis=0).max() / 2 if _whole(surface) else 0.0
        self._refinement = refinement.Refinement(surface.triangles, 36 * radius * scale)
        count = len(self._refinement.positions(surface.vertices))
        self._skin = _Surface(self._refinement.triangles, count)
        self._parts = [(self._skin, colour)]
        valence = np.bincount(surface.triangles.ravel())
        self._marked = np.flatnonzero(valence != 6) if markers else []
        if len(self._marked):
            source = vtkSphereSource()
            source.SetThetaResolution(12)
            source.SetPhiResolution(9)
            source.Update()
            ball = source.GetOutput()
            self._ball = vtk_to_numpy(ball.GetPoints().GetData()) / source.GetRadius()
            triangles = vtk_to_numpy(ball.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            several = np.arange(len(self._marked))[:, None, None] * len(self._ball)
            self._balls = _Surface((triangles + several).reshape(-1, 3),
                                   len(self._marked) * len(self._ball))
            self._parts.append((self._balls, _rgb("white")))

    def move(self, surface, vertices, field=None):
        """To these vertices, with the colours that the field has on the surface."""
        fine = self._refinement.positions(vertices)
        normals = refinement.normals(fine, self._skin.triangles)
        self._skin.move(fine, normals, None if field is None
                        else field.rgb(self._refinement.values(field.values(surface))))
        if len(self._marked):
            # Flat on the surface, and lit as it is.
            up = normals[self._marked][:, None]
            height = (self._ball * up).sum(axis=2, keepdims=True)
            flat = vertices[self._marked][:, None] + MARKERS * (self._ball - 0.75 * height * up)
            self._balls.move(flat.reshape(-1, 3),
                             np.broadcast_to(up, flat.shape).reshape(-1, 3))

    def actors(self, paler=0.0):
        """Those of one copy; `paler`: the share of white in its colour."""
        return [surface.actor(None if colour is None else colour + paler * (1 - colour))
                for surface, colour in self._parts]

    def shadow(self, colour):
        return self._skin.actor(colour, lit=False)


class _Stage:
    """A renderer with soft light, a camera of parallel projection, and a white background."""

    def __init__(self, view):
        """Raises DuctileError for views that are not, and where packages are missing."""
        if view not in VIEWS:
            raise DuctileError(f"view '{view}': there are {', '.join(VIEWS)}")
        self._window = display.window()  # first: it brings what draws to VTK's classes
        from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer
        self.right, self.up = (np.array(axis, float) for axis in VIEWS[view])
        self.towards = np.cross(self.right, self.up)
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(1, 1, 1)
        self.renderer.SetAutomaticLightCreation(False)
        for place, strength in (((-0.45, 0.75, 1), 0.8), ((0.9, -0.2, 0.6), 0.3),
                                ((0, -0.6, 1), 0.22)):
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*place)
            light.SetFocalPoint(0, 0, 0)
            light.SetIntensity(strength)
            self.renderer.AddLight(light)
        camera = self.renderer.GetActiveCamera()
        camera.SetParallelProjection(True)
        camera.SetFocalPoint(0, 0, 0)
        camera.SetPosition(*(FAR * self.towards))
        camera.SetViewUp(*self.up)
        camera.SetClippingRange(FAR / 2, 3 * FAR / 2)

    def add(self, *actors):
        for actor in actors:
            self.renderer.AddActor(actor)

    def draw(self, size, width):
        """The picture, of so many pixels and so many W across."""
        self.renderer.GetActiveCamera().SetParallelScale(width * size[1] / size[0] / 2)
        return self._window.draw(self.renderer, size)


def _flat(corners, colour):
    """A polygon, or a line between two points, without shading."""
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
    points, cells, data = vtkPoints(), vtkCellArray(), vtkPolyData()
    for corner in corners:
        points.InsertNextPoint(*corner)
    cells.InsertNextCell(len(corners))
    for n in range(len(corners)):
        cells.InsertCellPoint(n)
    data.SetPoints(points)
    if len(corners) > 2:
        data.SetPolys(cells)
    else:
        data.SetLines(cells)
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(data)
    actor.SetMapper(mapper)
    actor.GetProperty().SetLighting(False)
    actor.GetProperty().SetColor(*_rgb(colour))
    return actor


def _whole(surface):
    """Whether a surface can be drawn: one of a run that blew up may hold anything."""
    return bool(np.all(np.abs(surface.vertices) < 1e6))  # false of nan


def _nice(value):
    """The next number up that is a single digit, or a digit and a half, times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return next(step * power for step in (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)
                if step * power >= value * (1 - 1e-9))


class _Field:
    """A field that colours show, and which colours, `map`, from which value to which, `limits`."""

    def __init__(self, colour, surfaces):
        """`surfaces`, for which the colours are to do. Raises DuctileError where a surface has no
        such field."""
        from matplotlib import colormaps
        from matplotlib.colors import ListedColormap
        self._colour = colour
        self.label, name = COLOUR_BY[colour]
        self.map = colormaps[name]
        if colour != "x":  # shading does not show in the darkest part
            self.map = ListedColormap(self.map(np.linspace(0.2, 1, 256)))
        values = [self.values(surface) for surface in surfaces if _whole(surface)]
        # A few vertices, or an instant, are not to darken all else.
        highest = np.nanpercentile(np.abs(np.concatenate(values)), 97) if values else 0.0
        highest = _nice(highest) if highest > 0 else 1.0
        self.limits = -highest if colour == "x" else 0.0, highest

    def values(self, surface):
        """At its vertices."""
        if self._colour == "x":
            return surface.vertices[:, 0]
        if self._colour == "speed":
            if surface.velocity is None:
                raise DuctileError("colour 'speed': the frames have no velocities")
            relative = surface.velocity - surface.velocity.mean(axis=0)
            return np.linalg.norm(relative, axis=1)
        if surface.force is None:
            raise DuctileError("colour 'force': the frames have no forces")
        return np.linalg.norm(surface.force, axis=1) \
            / refinement.vertex_areas(surface.vertices, surface.triangles)

    def rgb(self, values):
        low, high = self.limits
        return self.map(np.clip((values - low) / (high - low), 0, 1))[:, :3]


def _decimals(times):
    """So many that times are told apart, and shown as they are but for a twentieth of a step; no
    less than one."""
    steps = np.diff(np.unique(times))
    allowed = 0.05 * min(steps.min(initial=0.1), 0.1)
    return next((n for n in (1, 2) if np.abs(times - np.round(times, n)).max() < allowed), 3)


class _Labels:
    """What is written over pictures of one size: the time, the axes, and a colour bar."""

    def __init__(self, size, decimals):
        import matplotlib
        from matplotlib.figure import Figure
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        self._settings = functools.partial(matplotlib.rc_context, SETTINGS)
        self.size, self._decimals = size, decimals
        self.font = float(np.clip(0.044 * size[1], 10, 48))  # pixels
        self._figure = functools.partial(Figure, dpi=100, facecolor="none")
        self._canvas = FigureCanvasAgg
        self._still = []  # (place, layer)
        self._about = {}  # by the number of a time's digits

    def _drawn(self, figure):
        """(colour times opacity, transparency), as floats of shape (height, width, 3 and 1)."""
        with self._settings():
            canvas = self._canvas(figure)
            canvas.draw()
        rgba = np.asarray(canvas.buffer_rgba()).astype(np.float32) / 255
        return rgba[..., :3] * rgba[..., 3:], 1 - rgba[..., 3:]

    def _text(self, figure, x, y, text, **others):
        """A text at a place in pixels, from the lower left."""
        width, height = figure.get_size_inches() * 100
        with self._settings():
            figure.text(x / width, y / height, text, fontsize=0.72 * self.font,
                        **{"color": BLACK, **others})

    def _put(self, image, place, layer):
        # What does not fit is cut off at the right and below.
        (left, bottom), (ink, clear) = place, layer
        top = max(image.shape[0] - bottom - ink.shape[0], 0)
        part = image[top:top + ink.shape[0], max(left, 0):max(left, 0) + ink.shape[1]]
        seen = slice(part.shape[0]), slice(part.shape[1])
        part[...] = np.round(part * clear[seen] + 255 * ink[seen])

    def add_axes(self, right, up):
        """Two arrows with their names, at the lower left."""
        side = int(5.5 * self.font)
        figure = self._figure(figsize=(side / 100, side / 100))
        origin, length = 1.2 * self.font, 2.2 * self.font
        axes = figure.add_axes([0, 0, 1, 1], xlim=(0, side), ylim=(0, side))
        axes.set_axis_off()
        for dx, dy in ((1, 0), (0, 1)):
            axes.annotate("", (origin + dx * length, origin + dy * length), (origin, origin),
                          arrowprops={"arrowstyle": "-|>,head_width=0.16,head_length=0.32",
                                      "color": GREY, "linewidth": self.font / 14,
                                      "shrinkA": 0, "shrinkB": 0})
        self._text(figure, origin + length + 0.3 * self.font, origin, right, va="center",
                   color=GREY)
        self._text(figure, origin, origin + length + 0.25 * self.font, up, ha="center",
                   va="bottom", color=GREY)
        self._still.append(((0, 0), self._drawn(figure)))

    def add_bar(self, field):
        """A colour bar at the upper right, with its ends and what it shows."""
        width, height = int(21 * self.font), int(2.2 * self.font)
        figure = self._figure(figsize=(width / 100, height / 100))
        ends = [f"{value:.3g}".replace("-", "\N{MINUS SIGN}") for value in field.limits]
        long, high = 7 * self.font, 0.6 * self.font
        left = width - long - (1.2 + 0.65 * len(ends[1])) * self.font
        middle = 0.45 * height + 0.36 * self.font
        bar = figure.add_axes([left / width, (middle - high / 2) / height, long / width,
                               high / height])
        bar.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=field.map)
        bar.set_axis_off()
        low = left - 0.4 * self.font
        for x, text, side in (
                (left + long + 0.4 * self.font, ends[1], "left"), (low, ends[0], "right"),
                (low - (0.65 * len(ends[0]) + 0.6) * self.font, field.label, "right")):
            self._text(figure, x, 0.45 * height, text, ha=side, va="baseline")
        self._still.append(((self.size[0] - width, self.size[1] - height), self._drawn(figure)))

    def _beside_time(self, digits):
        """What stands about a time of so many digits, and where these end."""
        if digits not in self._about:
            height, number = int(2.2 * self.font), 2.4 * self.font
            end = number + (0.636 * digits - 0.318) * self.font  # DejaVu's digits, and its point
            figure = self._figure(figsize=((end + 5 * self.font) / 100, height / 100))
            for x, text, side in ((number - 0.3 * self.font, "$t =$", "right"),
                                  (end, r"$\;W^2/\nu$", "left")):
                self._text(figure, x, 0.45 * height, text, ha=side, va="baseline")
            self._about[digits] = self._drawn(figure), end
        return self._about[digits]

    def _write_time(self, image, time):
        # Its digits as plain text: mathematical text takes its time.
        text = f"{time:.{self._decimals}f}"
        about, end = self._beside_time(len(text))
        height = int(2.2 * self.font)
        figure = self._figure(figsize=(end / 100, height / 100))
        self._text(figure, end, 0.45 * height, text, ha="right", va="baseline")
        for layer in (about, self._drawn(figure)):
            self._put(image, (0, self.size[1] - height), layer)

    def onto(self, image, time):
        """Writes over a picture, with the time [W^2/nu]."""
        for place, layer in self._still:
            self._put(image, place, layer)
        self._write_time(image, time)
        return image


def _checked(colour, size):
    if colour not in COLOUR_BY:
        raise DuctileError(f"colour '{colour}': there are {', '.join(COLOUR_BY)}")
    if len(size) != 2 or not all(int(n) == n and 64 <= n <= 4096 for n in size):
        raise DuctileError(f"size {'x'.join(map(str, size))}: width and height are from 64 to 4096 "
                           "pixels")
    return int(size[0]), int(size[1])


def frame_numbers(run, frames=None):
    """Frames of a run by their numbers from 0. Raises DuctileError for those that it has not, and
    where it has none. None: all."""
    count = len(run.times)
    if count == 0:
        raise DuctileError(f"{run.directory}: has no frames")
    numbers = list(range(count)) if frames is None else [int(frame) for frame in frames]
    for number in numbers:
        if not -count <= number < count:
            raise DuctileError(f"{run.directory}: has no frame {number}: there are {count}")
    if not numbers:
        raise DuctileError(f"{run.directory}: no frames were chosen")
    return [number % count for number in numbers]


def nearest_frame(run, time):
    """The number of the frame next to a time [W^2/nu]."""
    frame_numbers(run)
    return int(np.argmin(np.abs(run.times - time)))


def _colours_of(run):
    return {body: _rgb(COLOURS[n % len(COLOURS)]) for n, body in enumerate(run.bodies)}


class Scene:
    """The channel and the bodies of a run in it, for pictures of several frames.

    The camera goes along with the bodies. How many W the pictures are across is one number for all
    frames, by which the channel fills the height, unless bodies get further apart than that: then
    it follows their distance.

    Bodies are in the periods of the channel that have them nearest to each other at the run's
    start, and move on from there without jumps. Where the picture is so wide that further periodic
    images of them are in it, these are paler, unless a field gives the colours.
    """

    def __init__(self, run, frames=None, size=(800, 300), colour="body", view="raised",
                 markers=True, labels=True):
        """`frames`: that will be drawn, all by default; zoom and colours are made for them.

        `size`: width and height in pixels. `colour`: "body", by body; "speed", of the surface
        against the body's mean; "force", on the fluid by area; "x". `view`: "raised", from the side
        and from a little above; "side", along y; "top", along x; "front", along the flow.
        `markers`: with points that go with the surface. `labels`: with time, axes and colour bar.

        Raises DuctileError where the run has no such frames or no such field, for unknown names,
        and where packages are missing.
        """
        self.size = _checked(colour, size)
        self.run = run
        self.frames = frame_numbers(run, frames)
        self._stage = _Stage(view)
        first = run.surfaces(self.frames[0])
        self._names = [body for body in run.bodies if body in first]
        self._read_channel()
        self._place(first)
        self._field = None
        if COLOUR_BY[colour]:
            some = self.frames[::max(1, len(self.frames) // 20)]
            self._field = _Field(colour, (surface for frame in some
                                          for surface in run.surfaces(frame).values()))
        self._build(first, markers)
        self._labels = None
        if labels:
            self._labels = _Labels(self.size, _decimals(run.times[self.frames]))
            self._labels.add_axes(_named(self._stage.right), _named(self._stage.up))
            if self._field:
                self._labels.add_bar(self._field)

    @property
    def limits(self):
        """The range of the colours, in the unit of the field; None of colours by body."""
        return self._field.limits if self._field else None

    def _read_channel(self):
        with self.run._frames() as file:
            if "channel/corners" not in file:
                raise DuctileError(f"{self.run.directory / 'run.h5'}: does not say what the "
                                   "channel is")
            corners = file["channel/corners"][...]
        self.half_width_y, self.length = corners[:, 1].max(), 2 * corners[:, 2].max()
        try:
            self._side_walls = self.run.parameters.get("channel.side_walls", True)
        except DuctileError:
            self._side_walls = True

    def _place(self, first):
        """Where the camera is in each frame, how wide it looks, and in which period bodies are."""
        rows = self.run.table
        t = rows["t"].to_numpy()
        z = []
        for body in self._names:
            own = rows[f"{body}_z"].to_numpy()
            good = np.isfinite(own)
            z.append(np.interp(self.run.times, t[good], own[good]) if good.any()
                     else np.zeros(len(self.run.times)))
        z = np.array(z)
        turn = np.exp(2j * np.pi * z[:, 0] / self.length).mean()
        middle = self.length * np.angle(turn) / (2 * np.pi)
        self._shifts = -self.length * np.round((z[:, 0] - middle) / self.length)
        z = (z + self._shifts[:, None])[:, self.frames]
        self._centres = dict(zip(self.frames, z.mean(axis=0)))
        # What the channel takes of the height, and what bodies take of the width.
        corners = np.array([(x, y, 0) for x in (-1, 1) for y in (-1, 1)]) \
            * (1, self.half_width_y, 0)
        self._extent = np.ptp(corners @ self._stage.up)
        usual = max(MARGIN * self._extent * self.size[0] / self.size[1],
                    np.ptp(corners @ self._stage.right) * MARGIN)
        widths = np.full(len(self.frames), usual)
        if self._stage.right[2] > 0:
            radius = max((np.ptp(surface.vertices[:, 2]) / 2 for surface in first.values()
                          if _whole(surface)), default=0.0)
            taken = np.ptp(z, axis=0) + 2 * radius + ROOM
            widths = np.maximum(usual, _followed(np.minimum(taken, 2 * self.length)))
        self._widths = dict(zip(self.frames, widths))

    def view(self, frame):
        """(z, width): the camera's place along the flow, in the frame of trajectory.csv but for
        whole periods, and how much of the channel the picture shows, both in W."""
        number, = frame_numbers(self.run, [frame])
        if number not in self._centres:
            raise DuctileError(f"frame {number} is none of those that the scene was made for")
        return self._centres[number], self._widths[number]

    def _build(self, first, markers):
        self._build_walls()
        colours = _colours_of(self.run)
        reach = max(self._widths.values()) / 2
        scale = self.size[0] / min(self._widths.values())
        self._copies = []  # (actor, body, its z from where the body is)
        self._bodies = {}
        for name in self._names:
            body = _Body(first[name], None if self._field else colours[name], markers, scale)
            self._bodies[name] = body
            most = int(np.ceil((2 * reach + 2) / self.length))
            for period in range(-most, most + 1):
                actors = body.actors(PALER if period else 0.0)
                if 0.1 < self._stage.towards[0] < 1:
                    shadow = body.shadow(_rgb(SHADOW))
                    shadow.SetScale(1e-3, 1, 1)
                    shadow.SetPosition(-0.995, 0, 0)
                    actors.append(shadow)
                for actor in actors:
                    x, y, _ = actor.GetPosition()
                    actor.SetPosition(x, y, period * self.length)
                    self._stage.add(actor)
                    self._copies.append((actor, name, period * self.length))

    def _build_walls(self):
        """Those that the eye sees from inside, and all edges."""
        end, y = max(self._widths.values()) / 2 + 1, self.half_width_y
        towards = self._stage.towards
        walls = [((-sign, 0, 0), [(sign, -y, -end), (sign, y, -end), (sign, y, end),
                                  (sign, -y, end)]) for sign in (-1, 1)]
        if self._side_walls:
            walls += [((0, -sign, 0), [(-1, sign * y, -end), (1, sign * y, -end),
                                       (1, sign * y, end), (-1, sign * y, end)])
                      for sign in (-1, 1)]
        for inwards, corners in walls:
            if np.dot(inwards, towards) > 0.1:
                self._stage.add(_flat(corners, FLOOR if inwards[0] else WALL))
        for sign_x in (-1, 1):
            for sign_y in (-1, 1):
                # In front of the bodies a line is hardly there.
                front = sign_x * towards[0] + sign_y * towards[1] > 0.9 and towards[0] > 0.1
                edge = _flat([(sign_x, sign_y * y, -end), (sign_x, sign_y * y, end)],
                             FAR_EDGE if front else EDGE)
                edge.GetProperty().SetLineWidth(1.0 if front else 1.4)
                edge.GetProperty().SetOpacity(0.5 if front else 1.0)
                self._stage.add(edge)
        if abs(towards[2]) > 0.1:
            ring = [(-1, -y), (1, -y), (1, y), (-1, y)]
            for n in range(4):
                edge = _flat([(*ring[n], end), (*ring[(n + 1) % 4], end)], EDGE)
                edge.GetProperty().SetLineWidth(1.4)
                self._stage.add(edge)

    def image(self, frame):
        """The picture of a frame: RGB, shape (height, width, 3), uint8. Raises DuctileError where
        the frame cannot be read."""
        centre, width = self.view(frame)
        surfaces = self.run.surfaces(frame)
        ends = {}  # of the bodies that can be drawn, along z
        for name, shift in zip(self._names, self._shifts):
            surface = surfaces[name]
            if not _whole(surface):
                continue
            vertices = surface.vertices + (0, 0, shift - centre)
            self._bodies[name].move(surface, vertices, self._field)
            ends[name] = vertices[:, 2].min(), vertices[:, 2].max()
        for actor, name, away in self._copies:
            low, high = ends.get(name, (np.inf, -np.inf))
            seen = low + away < width / 2 and high + away > -width / 2
            actor.SetVisibility(int(seen))
        image = self._stage.draw(self.size, width)
        time = float(self.run.times[frame])
        return self._labels.onto(image, time) if self._labels else image


def _named(axis):
    """The coordinate that grows along an axis of the picture, or that falls."""
    largest = int(np.argmax(np.abs(axis)))
    return f"${'-' if axis[largest] < 0 else ''}{'xyz'[largest]}$"


def _followed(widths, reach=12):
    """A smooth curve over frames that is nowhere under the given one."""
    padded = np.pad(widths, 2 * reach, mode="edge")
    highest = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=1)
    weights = np.hanning(2 * reach + 3)[1:-1]
    return np.convolve(highest, weights / weights.sum(), mode="valid")


def image(run, frame, **options):
    """The bodies of one frame of a run in the channel: RGB, shape (height, width, 3), uint8.

    Options are those of Scene: size, colour, view, markers, labels. Raises DuctileError.
    """
    return Scene(run, [frame], **options).image(frame)


def _centroid(surface):
    """Of the surface's area."""
    areas = refinement.vertex_areas(surface.vertices, surface.triangles)
    return areas @ surface.vertices / areas.sum()


def _shapes(run, body, frames, size, colour, view, across, markers):
    """Pictures of one body's shapes at one scale, and that scale in pixels for a W."""
    size = _checked(colour, size)
    frames = frame_numbers(run, frames)
    if body not in run.bodies:
        raise DuctileError(f"{run.directory}: has no body '{body}': there are "
                           f"{', '.join(run.bodies)}")
    surfaces = [run.surfaces(frame)[body] for frame in frames]
    for frame, surface in zip(frames, surfaces):
        if not _whole(surface):
            raise DuctileError(f"{run.directory}: the surface of body {body} in frame {frame} is "
                               "not finite")
    stage = _Stage(view)
    field = _Field(colour, surfaces) if COLOUR_BY[colour] else None
    relative = [surface.vertices - _centroid(surface) for surface in surfaces]
    if across is None:
        axes = np.array([stage.right, stage.up])
        across = 2.12 * max((np.abs(r @ axes.T) / np.array(size)).max() for r in relative) * size[0]
    drawn = _Body(surfaces[0], None if field else _colours_of(run)[body], markers,
                  size[0] / across)
    stage.add(*drawn.actors())
    pictures = []
    for surface, own in zip(surfaces, relative):
        drawn.move(surface, own, field)
        pictures.append(stage.draw(size, across))
    return pictures, size[0] / across


def shape(run, body, frame, size=(300, 300), colour="body", view="side", across=None,
          markers=True):
    """The shape of one body alone in a frame: RGB, shape (height, width, 3), uint8.

    `across`: so many W are the picture's width; by default the body fills it. `view` and `colour`
    are Scene's: by default the eye looks along y, the flow goes to the right and x upwards. The
    middle is the centroid of the surface. Raises DuctileError.
    """
    pictures, _ = _shapes(run, body, [frame], size, colour, view, across, markers)
    return pictures[0]


def shape_strip(run, body, times=None, frames=None, size=(180, 180), colour="body", view="side",
                across=None, markers=True, labels=True):
    """The shapes of one body at some times, side by side at one scale: RGB, uint8, of shape
    (height, width, 3).

    `times` [W^2/nu], of which the nearest frames are shown, or else `frames` by their numbers.
    `size`: of each shape, in pixels. `labels`: with the time of its frame under each, and in the
    first a bar that is W/2 long. The others are shape()'s. Raises DuctileError.
    """
    if (times is None) == (frames is None):
        raise DuctileError("a strip of shapes takes either times or frames")
    if times is not None:
        frames = [nearest_frame(run, time) for time in times]
    pictures, scale = _shapes(run, body, frames, size, colour, view, across, markers)
    strip = np.concatenate(pictures, axis=1)
    if not labels:
        return strip
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    font = float(np.clip(0.085 * size[1], 10, 40))
    wide, high = strip.shape[1], int(3.2 * font)
    shown = run.times[frame_numbers(run, frames)]
    decimals = _decimals(shown)
    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(wide / 100, high / 100), dpi=100, facecolor="white")
        axes = figure.add_axes([0, 0, 1, 1], xlim=(0, wide), ylim=(0, high))
        axes.set_axis_off()
        for n, time in enumerate(shown):
            axes.text((n + 0.5) * size[0], 1.5 * font, f"$t = {time:.{decimals}f}\\;W^2/\\nu$",
                      fontsize=0.72 * font, ha="center")
        left = (size[0] - scale / 2) / 2
        axes.plot([left, left + scale / 2], [0.7 * font] * 2, color=BLACK, linewidth=font / 7,
                  solid_capstyle="butt")
        axes.text(left + scale / 2 + 0.4 * font, 0.7 * font, "$W/2$", fontsize=0.6 * font,
                  va="center_baseline")
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    return np.concatenate([strip, np.asarray(canvas.buffer_rgba())[..., :3]])
