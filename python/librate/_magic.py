"""`%%librate [NAME]`: a model in a cell of a notebook."""

from __future__ import annotations

from typing import Any

from ._errors import ArgumentError, Error, _request
from ._model import Model
from ._results import Derivation, Modes


def register(shell: Any) -> None:
    """Adds the magic to an IPython shell."""

    def librate(line: str, cell: str) -> Modes | Derivation | Model:
        """Reads the cell as a model, keeps it under the name given, and shows its modes: its derivation where parameters
        have no values, the model itself if it is driven."""
        name = line.strip()
        if name and not name.isidentifier():
            raise _request(f"%%librate takes one name for the model, not {name!r}", kind=ArgumentError)
        try:
            model = Model(cell)
            if name:
                shell.user_ns[name] = model
            if model.is_driven:
                return model
            return model.derive() if None in model.parameters.values() else model.modes()
        except Error as error:
            # What IPython prints instead of a traceback, which would lead into this package alone.
            error._render_traceback_ = str(error).splitlines  # type: ignore[attr-defined]
            raise

    shell.register_magic_function(librate, "cell", "librate")
