"""Reading, analysing and drawing the results of ductile: doc/analysis.md.

Everything is in the units of the program's files: lengths in W, half the channel's width, times in
W^2/nu, angles in degrees. What cannot be done raises DuctileError.

Names are loaded when they are first used: pictures need neither pandas nor scipy.
"""
from .errors import DuctileError

_HOME = {
    "runs": ("Campaign", "Run", "Surface", "four_way", "read_campaign", "read_run"),
    "uncertainty": ("Value",),
    "fits": ("fit_line", "fit_oscillation", "fit_relaxation", "migration_time"),
    "rotation": ("angles", "classify", "inclination", "phase", "second_moments", "surface_angles",
                 "surface_rotation", "tilt", "unwrapped_inclination", "unwrapped_phase"),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}

__all__ = ["DuctileError", *sorted(_MODULE_OF)]


def __getattr__(name):
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'ductile' has no attribute '{name}'")
    import importlib
    value = getattr(importlib.import_module("." + _MODULE_OF[name], __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted([*globals(), *_MODULE_OF])
