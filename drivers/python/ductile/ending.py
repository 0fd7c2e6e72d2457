"""How the scripts end that draw out of sight: with an exit code and one line."""
import signal
import sys

from . import display
from .errors import DuctileError


def exit_by(number, frame):
    """Takes a signal so that nothing half made is left; a second one does not disturb that."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)


def code_of(work, what):
    """Calls work(), and gives the exit code: 2 where DuctileError says that something is not as it
    should be, 1 where a file could not be written, `what` where that has no name. The display is
    closed before the complaint, so that this is the last line on stderr."""
    signal.signal(signal.SIGTERM, exit_by)
    try:
        work()
    except DuctileError as error:
        display.close()
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        display.close()
        print(f"{str(error.filename or what).removesuffix('.part')}: {error.strerror or error}",
              file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    return 0
