"""What the commands answer."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from ._errors import Diagnostic

# Fields whose pairs are real and imaginary parts.
_COMPLEX = {"multipliers", "vector"}


def _escaped(text: str) -> str:
    """The text as HTML has it; the module for this is loaded where a notebook asks for it."""
    from html import escape

    return escape(text)


def _is_number(value: Any) -> bool:
    # An amplitude at a resonance is "inf", which NumPy reads.
    return value is None or value == "inf" or (isinstance(value, (int, float)) and not isinstance(value, bool))


def _value(name: str, value: Any) -> Any:
    """JSON as Python has it: lists of numbers are arrays, objects have their fields as attributes."""
    if isinstance(value, dict):
        return Result(value)
    if value == "inf":
        return float(value)
    if not isinstance(value, list) or not value:
        return value
    if all(_is_number(one) for one in value) and any(one is not None for one in value):
        return np.array(value, dtype=float)
    if all(isinstance(one, list) and one and all(map(_is_number, one)) for one in value):
        if len({len(one) for one in value}) == 1:
            rows = np.array(value, dtype=float)
            return rows[:, 0] + 1j * rows[:, 1] if name in _COMPLEX and rows.shape[1] == 2 else rows
    return [_value(name, one) for one in value]


class Result(Mapping):
    """Fields of an answer, as attributes and by name; numbers in a row are NumPy arrays.

    They are in SI, but for the values of what is moved over a range, which have the unit of its declaration.
    """

    warnings: list[Diagnostic]

    def __init__(self, fields: dict, text: str = "", warnings: Iterable[Diagnostic] = ()) -> None:
        self._fields = {name: _value(name, value) for name, value in fields.items()}
        self._text = text
        self.warnings = list(warnings)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._fields[name]
        except KeyError:
            raise AttributeError(f"there is no field {name!r}, but {', '.join(self._fields)}") from None

    def __getitem__(self, name: str) -> Any:
        return self._fields[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __repr__(self) -> str:
        if self._text:
            return self._text.rstrip()
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self._fields.items())})"

    def _repr_html_(self) -> str:
        return f"<pre>{_escaped(repr(self))}</pre>"


def _bound(value: float) -> str:
    """A bound, which has one digit, as the text has it: `5e-8`."""
    digit, _, exponent = f"{value:.0e}".partition("e")
    return f"{digit}e{int(exponent)}" if value and exponent else digit


class Modes(Result):
    """Frequencies, growth and shapes about an equilibrium: one entry, or one row, a mode."""

    model: str | None
    coordinates: list[str]
    equilibrium: np.ndarray
    stability: str
    secular: bool | None
    omega: np.ndarray
    growth: np.ndarray
    error_bound: np.ndarray
    digits: list[str]
    growth_digits: list[str]
    digits_error_bound: np.ndarray
    omega_squared: np.ndarray
    kind: list[str]
    symmetry: list[str | None]
    # `None` only on request, so that type checkers do not ask for a check.
    vectors: np.ndarray | Any

    _NUMBERS = ("omega", "growth", "error_bound", "digits_error_bound", "omega_squared")
    _TEXTS = ("omega_digits", "growth_digits", "kind", "symmetry")

    def __init__(self, fields: dict, text: Any = "", warnings: Iterable[Diagnostic] = (), vectors: Any = None) -> None:
        modes = fields.pop("modes")
        super().__init__(fields, "", warnings)
        self._fields["equilibrium"] = np.array(fields["equilibrium"], dtype=float)
        found = (name for mode in modes for name in mode if name != "vector")
        for name in dict.fromkeys((*self._NUMBERS, *self._TEXTS, *found)):
            column = [mode.get(name) for mode in modes]
            is_text = name in self._TEXTS or not all(map(_is_number, column))
            self._fields[name] = column if is_text else np.array(column, dtype=float)
        self._fields["digits"] = self._fields["omega_digits"]
        self._fields["vectors"] = vectors
        self._text = text

    def __repr__(self) -> str:
        if callable(self._text):
            self._text = self._text()
        return super().__repr__()

    def __getstate__(self) -> dict:
        return {**self.__dict__, "_text": repr(self)}

    def _repr_html_(self) -> str:
        omega, growth = ("ω (rad/s)", "growth (1/s)") if "units" in self else ("ω", "growth")
        columns = [(omega, "digits"), ("bound", "digits_error_bound"), ("kind", "kind")]
        if set(self.growth_digits) - {"0"}:
            columns.insert(1, (growth, "growth_digits"))
        if set(self.symmetry) - {None}:
            columns.append(("symmetry", "symmetry"))
        head = "".join(f"<th>{title}</th>" for title, _ in [("mode", ""), *columns])
        rows = []
        for at in range(len(self.kind)):
            cells = [_bound(self[name][at]) if title == "bound" else self[name][at] for title, name in columns]
            cells = ["" if cell is None else _escaped(str(cell)) for cell in cells]
            rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in [at + 1, *cells]) + "</tr>")
        name = _escaped(self.model or "")
        caption = f"<caption>{name + ': ' if name else ''}equilibrium {self.stability}</caption>"
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


class Derivation(Result):
    """Equations, matrices and closed forms; expressions are texts in the model language."""

    mass: list[list[str]] | None
    stiffness: list[list[str]] | None
    gyroscopic: list[list[str]] | None
    damping: list[list[str]] | None
    circulatory: list[list[str]] | None
    equations: list[str]
    frequencies: list[dict[str, Any]]
    exponents: list[dict[str, Any]]

    _OPTIONAL = {"gyroscopic": None, "damping": None, "circulatory": None, "mass": None, "stiffness": None}

    def __init__(self, native: Any, warnings: Iterable[Diagnostic], again: tuple, names: list[str]) -> None:
        super().__init__({}, "", warnings)
        self._again = again
        self._names = names
        # Expressions stay as they are.
        self._fields = {**self._OPTIONAL, **json.loads(native.json())}
        for name in ("equations", "frequencies", "exponents"):
            self._fields[name] = self._fields.get(name) or []
        self._native = native

    @property
    def latex(self) -> str:
        """The derivation for a LaTeX document that has amsmath."""
        return self._native.latex(False)

    @property
    def html(self) -> str:
        """The derivation as HTML with MathML."""
        return self._native.html()

    @property
    def typst(self) -> str:
        """The derivation as a Typst document."""
        return self._native.typst()

    def to_sympy(self) -> Result:
        """The same fields with SymPy's matrices and expressions, and `symbols`, by their names in the model."""
        from ._sympy import converted

        return converted(self, self._names)

    def __reduce__(self) -> tuple:
        return self._again

    def __repr__(self) -> str:
        return self._native.text(False).rstrip()

    def _repr_html_(self) -> str:
        return self.html

    def _repr_latex_(self) -> str:
        return self.latex


class Batch(Result):
    """The modes of many parameter sets: arrays whose first index is the set, `vectors` with one row a mode.

    Models with friction, forces or terms linear in the velocities have complex `exponents` and `vectors`, and no `omega`
    and `growth`.
    """

    coordinates: list[str]
    # Arrays of a conservative model, else `None`.
    omega: np.ndarray | Any
    growth: np.ndarray | Any
    error_bound: np.ndarray | Any
    omega_squared: np.ndarray | Any
    omega_squared_error_bound: np.ndarray | Any
    # Arrays of any other model.
    exponents: np.ndarray | Any
    exponent_error_bound: np.ndarray | Any
    outcome: np.ndarray
    equilibrium: np.ndarray
    # Arrays where they are asked for, else `None`; `velocity` is C + G, `stiffness` K + N.
    vectors: np.ndarray | Any
    mass: np.ndarray | Any
    stiffness: np.ndarray | Any
    velocity: np.ndarray | Any


class Picture(str):
    """SVG text, drawn in a notebook."""

    def _repr_svg_(self) -> str:
        return str(self)


class Page(str):
    """An HTML page of its own, shown in a notebook in a frame."""

    def _repr_html_(self) -> str:
        frame = 'width="100%" height="720" style="border: 0"'
        return f'<iframe srcdoc="{_escaped(self)}" {frame}></iframe>'
