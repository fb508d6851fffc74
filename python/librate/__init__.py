"""Small oscillations: write T and V as on the blackboard, get normal frequencies in which every digit is right.

>>> import librate
>>> model = librate.Model("param k = 4  coord x  T = 1/2*x'^2  V = 1/2*k*x^2")
>>> model.modes(digits=5).digits
['2.0000']
"""

from . import _native
from ._errors import ArgumentError, ArgumentTypeError, Diagnostic, Error, FileError, MissingFileError, ModelWarning, Span
from ._model import Model, explain, fmt, inertia
from ._results import Batch, Derivation, Modes, Page, Picture, Result

__version__ = _native.version()

__all__ = [
    "ArgumentError",
    "ArgumentTypeError",
    "Batch",
    "Derivation",
    "Diagnostic",
    "Error",
    "FileError",
    "MissingFileError",
    "Model",
    "ModelWarning",
    "Modes",
    "Page",
    "Picture",
    "Result",
    "Span",
    "explain",
    "fmt",
    "inertia",
]


def load_ipython_extension(shell):
    """Adds `%%librate` to a notebook."""
    from ._magic import register

    register(shell)
