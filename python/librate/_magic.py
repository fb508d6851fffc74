"""`%%librate [NAME]`: a model in a cell of a notebook."""

from __future__ import annotations

from typing import Any

from ._errors import Error
from ._model import Model
from ._results import Modes


def register(shell: Any) -> None:
    """Adds the magic to an IPython shell."""

    def librate(line: str, cell: str) -> Modes | Model:
        """Reads the cell as a model, keeps it under the name given, and shows its modes (of a driven model, the model)."""
        name = line.strip()
        if name and not name.isidentifier():
            raise ValueError(f"%%librate takes one name for the model, not {name!r}")
        try:
            model = Model(cell)
            shown = model if model.is_driven else model.modes()
        except Error as error:
            # What IPython prints instead of a traceback, which would lead into this package alone.
            error._render_traceback_ = str(error).splitlines  # type: ignore[attr-defined]
            raise
        if name:
            shell.user_ns[name] = model
        return shown

    shell.register_magic_function(librate, "cell", "librate")
