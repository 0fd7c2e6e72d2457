"""A place to draw in: VTK's window, out of sight, on an X server of its own.

Debian's VTK draws through GLX alone and so takes an X server, wherever its pictures go; without one
it ends the process. So Xvfb is started here, whatever DISPLAY says: pictures are the same on every
machine, processes that draw at the same time do not meet, and nothing appears on anybody's screen.
The server ends with the process, however that ends.
"""
import atexit
import contextlib
import errno
import importlib.util
import os
import random
import select
import shutil
import socket
import struct
import subprocess
import tempfile

from .errors import DuctileError

PATIENCE = 60  # seconds that the server may take to come up
NUMBERS = range(1000, 50000)  # of displays: above those that people use, below the ports' end
TRIES = 3  # numbers drawn, where one is taken
SAMPLES = 4  # of a pixel


def missing_packages():
    """Debian's packages that drawing takes and that are not here, as a list of names."""
    missing = []
    if importlib.util.find_spec("vtkmodules") is None:
        missing.append("python3-vtk9")
    if shutil.which("Xvfb") is None:
        missing.append("xvfb")
    return missing


def require(packages):
    """Raises DuctileError if any are missing: `packages`, as missing_packages() gives them."""
    if packages:
        names = " ".join(packages)
        raise DuctileError(f"films and pictures of surfaces take Debian's packages {names}, not "
                           f"installed here: apt-get install --no-install-recommends {names}")


def _client(number):
    """A connection to the X server of a display's number, as a socket. Raises OSError.

    The server ends when its last client has gone, and VTK comes and goes before it stays: this one
    stays as long as the process.
    """
    client = socket.socket(socket.AF_UNIX)
    client.settimeout(PATIENCE)
    try:
        try:
            client.connect(f"\0/tmp/.X11-unix/X{number}")
        except OSError:
            client.connect(f"/tmp/.X11-unix/X{number}")
        # X11's connection setup: byte order, version 11.0, no authorization. The answer begins with
        # 1 where the server takes the client.
        client.sendall(struct.pack("<BxHHHHxx", ord("l"), 11, 0, 0, 0))
        if client.recv(1) != b"\1":
            raise OSError(errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED))
    except OSError:
        client.close()
        raise
    return client


def _try_server(number):
    """An X server of a display's number, as a process. Gives it, or None where it did not come up,
    and what it said. Raises DuctileError where there is no Xvfb."""
    ready, tell = os.pipe()
    with tempfile.TemporaryFile() as said:
        try:
            server = subprocess.Popen(  # which ends when its last client has gone
                ["Xvfb", f":{number}", "-displayfd", str(tell), "-screen", "0", "64x64x24",
                 "-nolisten", "tcp", "-terminate"], pass_fds=[tell], stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=said, start_new_session=True)
        except OSError as error:
            os.close(ready)
            raise DuctileError(f"Xvfb: {error.strerror}") from None
        finally:
            os.close(tell)
        # It writes its number and a newline when it takes clients; whoever closes the pipe before the
        # newline ends it. The pipe ends with it.
        written = b""
        while not written.endswith(b"\n"):
            part = select.select([ready], [], [], PATIENCE)[0] and os.read(ready, 64)
            if not part:
                break
            written += part
        os.close(ready)
        if written.endswith(b"\n"):
            return server, ""
        server.kill()
        server.wait()
        said.seek(0)
        lines = said.read().decode(errors="replace").strip().splitlines()
        return None, lines[-1].strip() if lines else "without a word"


def _start_server():
    """An X server as a process, its display's name, and a client of it that stays. Raises
    DuctileError."""
    # The number is drawn: Xvfb's own choice is the lowest one free, and so that of a server which
    # is about to end, whose sockets it then shares.
    for number in random.SystemRandom().sample(NUMBERS, TRIES):
        server, said = _try_server(number)
        if server is not None:
            break
    else:
        raise DuctileError(f"Xvfb does not start: {said}")
    try:
        return server, f":{number}", _client(number)
    except OSError as error:
        server.kill()
        server.wait()
        raise DuctileError(f"Xvfb takes no client: {error.strerror or error}") from None


@contextlib.contextmanager
def _environment(name, value):
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


class Window:
    """A window out of sight, in which renderers are drawn one after the other. See window()."""

    def __init__(self):
        """Raises DuctileError where packages are missing or no X server comes up."""
        require(missing_packages())
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
        from vtkmodules.vtkRenderingOpenGL2 import vtkXOpenGLRenderWindow
        self._server, display, self._client = _start_server()
        self._window = vtkXOpenGLRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(SAMPLES)
        self._pixels = vtkUnsignedCharArray()
        self._shown = None
        with _environment("DISPLAY", display):
            self._window.SetSize(64, 64)
            self._window.Render()  # connects, once and for all
        atexit.register(self.close)

    def close(self):
        """Gives it up, and its server, once and for all."""
        atexit.unregister(self.close)
        # In this order: a client whose server goes first is ended by it.
        self._window.Finalize()
        self._window = None
        self._client.close()
        try:
            self._server.wait(5)
        except subprocess.TimeoutExpired:
            self._server.kill()
            self._server.wait()

    def draw(self, renderer, size):
        """What a vtkRenderer shows, as RGB of shape (height, width, 3), uint8. `size`: (width,
        height) in pixels."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        width, height = size
        self._window.SetSize(width, height)
        if renderer is not self._shown:  # one that leaves takes its time to come again
            if self._shown is not None:
                self._window.RemoveRenderer(self._shown)
            self._window.AddRenderer(renderer)
            self._shown = renderer
        self._window.Render()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 0, self._pixels, 0)
        return vtk_to_numpy(self._pixels).reshape(height, width, 3)[::-1].copy()


_window = None


def close():
    """Closes the window of the process, if there is one. Whoever prints a last word does it after
    this: VTK may have one of its own, on stderr."""
    global _window
    if _window is not None:
        _window.close()
        _window = None


def window():
    """The one window of the process, made when it is first asked for. Raises DuctileError."""
    global _window
    if _window is None:
        _window = Window()
    return _window
