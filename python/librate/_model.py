"""Models and their commands."""

from __future__ import annotations

import functools
import io
import json
import numbers
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from typing import TYPE_CHECKING, Any, SupportsFloat

import numpy as np

from . import _native
from ._errors import ArgumentError, ArgumentTypeError, Diagnostic, Error, _request, _unread, _warn
from ._results import Batch, Derivation, Modes, Page, Picture, Result, _escaped

# What few need is imported where it is used: it would take half of the time of an import.
if TYPE_CHECKING:
    from pathlib import Path

Number = str | SupportsFloat
# Of a parameter, or of the members of a family.
Values = Number | Iterable[Number | Iterable[Number]]
# A tuple has the ends and their count, all else the values.
_Ends = Mapping[str, Iterable[Number]]
Range = str | _Ends

_OUTCOMES = np.array(
    ["solved", "estimated", "not finite", "mass not positive", "no equilibrium", "not converged"], dtype=object
)
_PICTURES = ("modes", "spectrum", "sweep", "response", "period", "motion", "floquet", "equilibria")
# Larger matrices are sparse, where SciPy is there.
_DENSE = 500
# What has no values in an order.
_NO_LISTS = (Mapping, Set, bytes, bytearray, memoryview)
# As modes() has them.
_DIGITS = 10


def _ask(function: Callable, *arguments: Any) -> Any:
    """Calls what reads arguments; one of a wrong type is named as it is in Python."""
    try:
        return function(*arguments)
    except Error:
        raise
    except (TypeError, ValueError, OverflowError) as error:
        reason: BaseException | None = error
        message = str(error)
        if field := re.fullmatch(r"failed to extract field \w+[.](\w+)", message):
            name, reason = field[1], error.__cause__
            [value] = [own[name] for own in arguments if isinstance(own, dict)]
            message = f"`{name}` can't be {value!r}: {reason}"
        elif isinstance(error, OverflowError):
            message = f"a number is too large: {error}"
        raise _request(message, kind=ArgumentTypeError if isinstance(reason, TypeError) else ArgumentError) from None


def _items(value: Any, example: str) -> list[tuple[Any, Any]]:
    """The entries of a dict, or of a data frame."""
    if not hasattr(value, "items"):
        raise _request(f"{example} is needed, not {value!r}", kind=ArgumentTypeError)
    return _ask(lambda: list(value.items()))


def _list(value: Any) -> list:
    """Values in their order."""
    if isinstance(value, (str, *_NO_LISTS)):
        raise _request(f"a list or an array is needed, not {value!r}", kind=ArgumentTypeError)
    return _ask(list, value)


def _doubles(value: Any) -> np.ndarray:
    """An array of doubles, `nan` where it is masked."""
    array = _ask(np.ma.asarray, _list(value) if isinstance(value, _NO_LISTS) else value)
    if array.dtype.kind == "c":
        raise _request(f"real numbers are needed, not {value!r}", kind=ArgumentTypeError)
    return np.ma.filled(_ask(array.astype, float), np.nan)


def _plain(value: Any) -> Any:
    """The number in an array without dimensions; larger ones, as those of pandas, as an array of NumPy."""
    if np.ma.is_masked(value):
        raise _request(f"a number is needed, but {value!r} is masked", kind=ArgumentError)
    return _ask(np.asarray, value)[()] if hasattr(value, "__array__") else value


def _text(value: Any) -> str:
    """A number as the model language has it; a float is the decimal that Python prints."""
    value = _plain(value)
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_)):
        raise _request(f"a number is needed, not {value!r}", kind=ArgumentTypeError)
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Rational):
        return f"{value.numerator}/{value.denominator}"
    # A decimal, which is no Real.
    if isinstance(value, numbers.Number) and hasattr(value, "as_tuple"):
        return format(value, "f")
    if isinstance(value, numbers.Real):
        return repr(float(value))
    raise _request(f"a number is needed, not {value!r}", kind=ArgumentTypeError)


def _value(value: Any) -> str:
    """A number, or `[1, 2, 3]` for the members of a family in their order."""
    value = _plain(value)
    if isinstance(value, Iterable) and not isinstance(value, str):
        return f"[{', '.join(map(_value, _list(value)))}]"
    return _text(value)


def _all_settings(values: Mapping[str, Any] | None) -> list[str]:
    given = _items({} if values is None else values, 'a dict of values, {"k": 8}')
    return [f"{name}={_value(value)}" for name, value in given]


def _optional(value: Any) -> str | None:
    return None if value is None else _text(value)


def _ends(values: Any) -> Any:
    """Equally spaced values as their ends and their count, as a tuple has them."""
    if isinstance(values, tuple):
        return values
    column = values if hasattr(values, "__array__") else _list(values)
    doubles = _doubles(column)
    if doubles.ndim == 1 and doubles.size and np.isfinite(doubles).all():
        column = np.asarray(column)
        spaced = np.linspace(doubles[0], doubles[-1], doubles.size)
        rounding = 4 * np.finfo(column.dtype).eps if column.dtype.kind == "f" else 0
        if np.allclose(doubles, spaced, rtol=0, atol=max(rounding, 1e-12) * np.abs(doubles).max()):
            return column[0], column[-1], column.size
    raise ValueError


def _range(value: Range) -> str:
    """`k=0..8:17`, or `{"k": (0, 8, 17)}`; where no count is wanted without it."""
    if isinstance(value, str):
        return value
    example = '"k=0..8:17" or {"k": (0, 8, 17)}'
    items = _items(value, example)
    try:
        [(name, ends)] = items
        first, last, *count = _ends(ends)
        if len(count) > 1:
            raise ValueError
    except (TypeError, ValueError):
        message = f"a range is {example}, or a list or an array of equally spaced values, not {value!r}"
        raise _request(message, kind=ArgumentError) from None
    return ":".join([f"{name}={_text(first)}..{_text(last)}", *map(_text, count)])


def _ranges(value: Any) -> list[str]:
    """One range or several, in one dict or a list."""
    if isinstance(value, str):
        return [value]
    if hasattr(value, "items"):
        return [_range({name: ends}) for name, ends in _items(value, "")]
    return [_range(one) for one in _list(value)]


def _box(value: str | Mapping[str, Iterable[Number]]) -> str:
    if isinstance(value, str):
        return value
    example = '"x=-2..2" or {"x": (-2, 2)}'
    items = _items(value, example)
    try:
        ranges = [(name, first, last) for name, ends in items for first, last in [_list(ends)]]
    except (TypeError, ValueError):
        raise _request(f"a box is {example}, not {value!r}", kind=ArgumentError) from None
    return ", ".join(f"{name}={_text(first)}..{_text(last)}" for name, first, last in ranges)


def _start(value: str | Mapping[str, Number] | None) -> str | None:
    if value is None or isinstance(value, str):
        return value
    return ", ".join(f"{name}={_text(one)}" for name, one in _items(value, '"x=1, x\'=0" or {"x": 1}'))


def _table(value: Any) -> str:
    """The text of a table: of a data frame, its rows."""
    text = value.to_csv(index=False) if hasattr(value, "to_csv") else value
    if not isinstance(text, str):
        kind = type(value).__name__
        message = f"a table is the text of a CSV file or a data frame of pandas, not of type {kind}"
        raise _request(message, "`Path(path).read_text()` reads a file", ArgumentTypeError)
    return text


def _tables(values: Mapping[str, Any] | None) -> dict[str, Any]:
    given = _items({} if values is None else values, 'a dict of texts, {"springs.csv": "k\\n1\\n"}')
    return {name: _table(table) for name, table in given}


def _array(data: bytes, *shape: int) -> np.ndarray:
    return np.frombuffer(data, dtype=float).reshape(shape).copy()


def _result(answer: dict, kind: type[Result] = Result) -> Result:
    fields = json.loads(answer["json"])
    return kind(fields, answer["text"], _warn(answer["warnings"], 3))


def _picture(answer: dict) -> Any:
    _warn(answer["warnings"], 4)
    return Picture(answer["text"])


def _check_unicode(text: str) -> None:
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise _request(f"the text is not Unicode: {error.reason}", "decode files as UTF-8") from None


def _read(folder: Path, path: str, roots: list[Path]) -> str:
    """A table in or below the folder of the model, or one that is allowed."""
    try:
        place = (folder / path).resolve(strict=True)
    except OSError:
        place = None
    if place is None or not any(place.is_relative_to(root) for root in roots):
        raise OSError(
            "there is no such file in or below the folder of the model; `allow_path` permits another folder"
        )
    return place.read_text(encoding="utf-8-sig")


class Model:
    """A model, from its text. No file is read: `tables` has the text of each CSV file that the model names.

    `set` replaces the values of parameters; a float stands for the decimal that Python prints, a string for any exact
    constant expression. `budget` permits more time or memory: `"10min,8GB"`, `"none"`.
    """

    def __init__(
        self,
        text: str,
        tables: Mapping[str, Any] | None = None,
        set: Mapping[str, Values] | None = None,
        *,
        budget: str | None = None,
    ) -> None:
        if not isinstance(text, str):
            message = f"a model is made from its text, not from {text!r}"
            raise _request(message, "`librate.Model.open(path)` reads a file", ArgumentTypeError)
        if text.strip().endswith(".lag") and "=" not in text:
            path = text.strip()
            raise _request(f"{path!r} is a path, not the text of a model", f"`librate.Model.open({path!r})` reads a file")
        texts = _tables(tables)
        settings = _all_settings(set)
        self._make(text, "model", texts, {}, settings, budget)

    def _make(
        self,
        text: str,
        name: str,
        tables: dict[str, str],
        failures: dict[str, str],
        settings: list[str],
        budget: str | None,
    ) -> None:
        _check_unicode(text)
        self.text = text
        self._arguments = (name, tables, failures, settings, budget)
        self._native = _ask(_native.Model, (name, text), tables, failures, settings, budget)
        content = _ask(_native.check, self._native, True)
        #: From the `model` statement.
        self.name: str | None = content["name"]
        #: Names, in the order of declaration.
        self.coordinates: list[str] = content["coordinates"]
        #: Values in SI; `None` where there is none.
        self.parameters: dict[str, float | None] = {one["name"]: one["value"] for one in content["parameters"]}
        #: Whether the energies depend on the time.
        self.is_driven: bool = content["driven"]

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        tables: Mapping[str, Any] | None = None,
        set: Mapping[str, Values] | None = None,
        *,
        allow_path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
        budget: str | None = None,
    ) -> Model:
        """Reads a model file and the tables that it names, in or below its folder or those of `allow_path`.

        What is in `tables` is not read.
        """
        from pathlib import Path

        path = _ask(Path, path)
        try:
            data = _ask(path.read_bytes)
        except OSError as error:
            raise _unread(path, error) from error
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError as error:
            raise _request(f"can't read the model file `{path}`: it is not UTF-8 text ({error.reason})") from None
        allowed = [allow_path] if isinstance(allow_path, (str, os.PathLike)) else _ask(list, allow_path)
        roots = [path.parent.resolve(), path.resolve().parent, *(Path(_ask(os.path.realpath, one)) for one in allowed)]
        given = _tables(tables)
        texts, failures = {}, {}
        for name in _native.Model((str(path), text), {}, {}, [], None).paths():
            try:
                if name not in given:
                    texts[name] = _read(path.parent, name, roots)
            except (OSError, ValueError) as error:
                failures[name] = str(error)
        settings = _all_settings(set)
        return _again(cls, text, (str(path), {**texts, **given}, failures, settings, budget))

    def __reduce__(self) -> tuple:
        return _again, (type(self), self.text, self._arguments)

    def __repr__(self) -> str:
        count = len(self.coordinates)
        return f"<Model {self.name or ''}: {count} coordinate{'' if count == 1 else 's'}>".replace(" :", ":")

    def _repr_html_(self) -> str:
        """The page of `show`, or the text of a model that has none."""
        try:
            return Page(_native.show(self._native, _DIGITS, None, [])["text"])._repr_html_()
        except Error:
            return f"<pre>{_escaped(self.text)}</pre>"

    def check(self) -> list[Diagnostic]:
        """Checks the model; what is suspicious in it is in the list."""
        return _warn(_ask(_native.check, self._native, False)["warnings"], 2)

    def modes(
        self,
        digits: int = 10,
        lowest: int | None = None,
        vectors: bool = True,
        *,
        near: float | None = None,
        count: int | None = None,
        certify: Any = None,
        normalize: str = "mass",
        unit: str | None = None,
        threads: int | None = None,
        _svg: bool = False,
        _spectrum: bool = False,
    ) -> Modes:
        """Frequencies and shapes about the equilibrium.

        `certify` has approximate shapes, one a row (`v.T` of SciPy's columns), of which only the bounds are computed.
        """
        if certify is not None:
            rows, length = np.atleast_2d(_doubles(certify)), len(self.coordinates)
            if rows.shape[1:] != (length,):
                message = f"`certify` has shapes as rows of {length} numbers, not dimensions {rows.shape}"
                raise _request(message, "`certify=v.T` where each column of `v` is a shape", ArgumentTypeError)
            certify = rows.tobytes()
        arguments = dict(
            digits=digits,
            lowest=lowest,
            vectors=vectors,
            near=near,
            count=count,
            certify=certify,
            normalize=normalize,
            unit=unit,
            threads=threads,
        )
        if _svg:
            return _picture(_ask(_native.plot_modes, self._native, arguments, _spectrum))
        native, told = _ask(_native.modes, self._native, arguments)
        fields = json.loads(native.json())
        shapes = None
        if vectors:
            numbers = native.vectors()
            shapes = _array(numbers["data"], len(fields["modes"]), -1) if fields["modes"] else np.empty((0, 0))
            shapes = shapes.view(complex) if numbers["complex"] else shapes
        return Modes(fields, native.text, _warn(told, 2), shapes)

    def derive(
        self,
        only: Sequence[str] | None = None,
        *,
        cubic: bool = False,
        quartic: bool = False,
        limit: Mapping[str, Number] | None = None,
        expand: tuple[str, int] | None = None,
    ) -> Derivation:
        """Equations of motion, matrices and closed forms, as expressions in the parameters."""
        limits = {name: _text(value) for name, value in _items({} if limit is None else limit, '{"m2": 0}')}
        only = only.split(",") if isinstance(only, str) else only
        arguments: dict[str, Any] = dict(cubic=cubic, quartic=quartic, limit=limits, expand=expand, only=only)
        native, told = _ask(_native.derivation, self._native, {**arguments, "limit": list(limits.items())})
        again = (functools.partial(Model.derive, **arguments), (self,))
        return Derivation(native, _warn(told, 2), again, [*self.parameters, *self.coordinates])

    def sweep(
        self,
        over: Range,
        digits: int = 10,
        lowest: int | None = None,
        vectors: bool = False,
        *,
        threads: int | None = None,
        _svg: bool = False,
        _orders: Sequence[float] = (),
        _root_locus: bool = False,
    ) -> Result:
        """The modes over a range of a parameter, `"k=0..8:17"`, `{"k": (0, 8, 17)}` or `{"k": np.linspace(0, 8, 17)}`.

        `over` has the values; `omega`, `growth` and `error_bound` one row a value, `nan` where there is no mode; `places`
        all of it, value by value.
        """
        over = _range(over)
        arguments = dict(over=over, digits=digits, lowest=lowest, vectors=vectors, threads=threads, svg=_svg)
        arguments |= dict(orders=_list(_orders), root_locus=_root_locus)
        answer = _ask(_native.sweep, self._native, arguments)
        if _svg:
            return _picture(answer)
        name = over.split("=", 1)[0].strip()
        places = json.loads(answer["json"])
        most = max(len(place.get("modes", [])) for place in places)
        fields: dict = {"parameter": name, "over": [place[name] for place in places]}
        result = Result(fields, answer["text"], _warn(answer["warnings"], 2))
        for field in ("omega", "growth", "error_bound"):
            columns = [[mode[field] for mode in place.get("modes", [])] for place in places]
            rows = [column + [None] * (most - len(column)) for column in columns]
            result._fields[field] = np.array(rows, dtype=float).reshape(len(places), most)
        for field in ("kind", "omega_digits"):
            result._fields[field.replace("omega_", "")] = [
                [mode[field] for mode in place.get("modes", [])] for place in places
            ]
        result._fields["places"] = [Result(place) for place in places]
        return result

    def batch(
        self,
        sets: Mapping[str, Any],
        *,
        vectors: bool = False,
        matrices: bool = False,
        bounds: bool = True,
        threads: int | None = None,
    ) -> Batch:
        """The modes of many sets of parameters, in doubles with rigorous bounds, on all cores.

        Each parameter has an array with a value for each set, in SI, or one value for all; a family has a row for each
        set, or one value for all its members. Masked values are `nan`. Modes are in the order of rising omega squared.

        Models with friction, forces or terms linear in the velocities have `exponents` instead, two for each
        coordinate: growth + i omega, in the order of rising frequency, then of rising growth, conjugates beside
        each other. How many of them are real differs from set to set, so that `omega` and `growth` are `None`.
        """
        columns = {name: _doubles(value) for name, value in _items(sets, "a dict of arrays")}
        count = max((len(column) for column in columns.values() if column.ndim), default=1)
        rows = []
        for name, column in columns.items():
            if column.ndim == 0:
                column = np.full(count, column)
            if column.ndim > 2 or len(column) != count:
                raise _request(f"`{name}` has {len(column)} values for {count} sets")
            rows.append((name, column.tobytes()))
        arguments = dict(columns=rows, sets=count, vectors=vectors, matrices=matrices, bounds=bounds, threads=threads)
        found = _ask(_native.solve_sets, self._native, arguments)
        n = len(found["coordinates"])
        result = Batch({"coordinates": found["coordinates"]})
        result._fields = dict.fromkeys(Batch.__annotations__) | result._fields
        result._fields.update(
            outcome=_OUTCOMES[np.frombuffer(found["outcome"], dtype=np.uint8)],
            equilibrium=_array(found["equilibrium"], count, n),
        )
        if matrices:
            names = ["mass", "stiffness"] + ["velocity"] * (not found["is_conservative"])
            result._fields.update({name: _array(found[name], count, n, n) for name in names})
        if not found["is_conservative"]:
            result._fields.update(
                exponents=_array(found["exponents"], count, 4 * n).view(complex),
                exponent_error_bound=_array(found["exponent_error_bound"], count, 2 * n),
                vectors=_array(found["shapes"], count, 2 * n, 2 * n).view(complex) if vectors else None,
            )
            return result
        squared = _array(found["omega_squared"], count, n)
        result._fields.update(
            omega=np.sqrt(np.where(squared > 0, squared, np.where(np.isnan(squared), squared, 0))),
            growth=np.sqrt(np.where(squared < 0, -squared, np.where(np.isnan(squared), squared, 0))),
            error_bound=_array(found["error_bound"], count, n),
            omega_squared=squared,
            omega_squared_error_bound=_array(found["omega_squared_error_bound"], count, n),
            vectors=_array(found["vectors"], count, n, n) if vectors else None,
        )
        return result

    def period(
        self,
        amplitude: Number | None = None,
        energy: Number | None = None,
        over: Range | None = None,
        digits: int = 10,
        *,
        _svg: bool = False,
    ) -> Result:
        """The exact period of one coordinate at finite amplitude; with `over` a curve."""
        curve = None if over is None else _range(over)
        amount = dict(amplitude=_optional(amplitude), energy=_optional(energy))
        answer = _ask(_native.periods, self._native, dict(**amount, over=curve, digits=digits, svg=_svg))
        if _svg:
            return _picture(answer)
        if over is None:
            return _result(answer)
        places = json.loads(answer["json"])
        fields = {field: [place.get(field) for place in places] for field in ("given", "period", "error_bound")}
        result = Result(fields, answer["text"], _warn(answer["warnings"], 2))
        result._fields["over"] = result._fields.pop("given")
        return result

    def floquet(self, map: _Ends | Sequence[Range] | None = None, digits: int = 10, *, _svg: bool = False) -> Result:
        """Floquet multipliers of a driven model; with a `map` over two parameters a chart of stability.

        `map` has two ranges, `("a=0..4:5", "q=0..2:3")` or `{"a": (0, 4, 5), "q": (0, 2, 3)}`. A chart has the values of
        both parameters, and `stable` (1, 0, or `nan` where there is no periodic motion or motions may grow as powers
        of the time) and `growth_rate` with one row a value of the first.
        """
        ranges = None if map is None else tuple(_ranges(map))
        if ranges is not None and len(ranges) != 2:
            raise _request(f"a map has two ranges, not {map!r}", kind=ArgumentError)
        answer = _ask(_native.multipliers, self._native, ranges, digits, _svg)
        if _svg:
            return _picture(answer)
        if ranges is None:
            return _result(answer)
        from fractions import Fraction

        [head, *lines] = (line.split(",") for line in answer["text"].splitlines())
        codes = {"true": 1.0, "false": 0.0, "": np.nan}
        cells = np.array([[codes[cell] if cell in codes else float(cell) for cell in line] for line in lines])
        rows = int(Fraction(ranges[0].rsplit(":", 1)[1]))
        slow, fast, stable, rate = (cells[:, at].reshape(rows, -1) for at in range(4))
        result = Result({}, answer["text"], _warn(answer["warnings"], 2))
        result._fields = {head[0]: slow[:, 0], head[1]: fast[0], "stable": stable, "growth_rate": rate}
        return result

    def response(
        self,
        over: Range,
        input: str | None = None,
        output: str | Sequence[str] = (),
        digits: int = 10,
        *,
        threads: int | None = None,
        _svg: bool = False,
    ) -> Result:
        """The steady response to a harmonic force on `input`, or to the model's own drive.

        Its fields are called as the columns of the command line, `found["x amplitude"]` and `found["x phase"]`; `outputs`
        has them with their bounds.
        """
        outputs = [output] if isinstance(output, str) else _ask(list, output)
        arguments = dict(over=_range(over), input=input, output=outputs, digits=digits, threads=threads)
        answer = _ask(_native.steady_response, self._native, arguments | dict(svg=_svg, peaks=False))
        if _svg:
            return _picture(answer)
        found = _result(answer)
        for own in found.outputs:
            for part in ("amplitude", "phase"):
                found._fields[f"{own.coordinate} {part}"] = own[part]
        return found

    def peaks(
        self,
        over: Range,
        input: str | None = None,
        output: str | Sequence[str] = (),
        digits: int = 10,
        *,
        threads: int | None = None,
    ) -> Result:
        """All maxima and minima of the steady response between the ends of a range, none missed: `outputs`, each with its
        `peaks` and the pieces of the range that are `undecided`.
        """
        outputs = [output] if isinstance(output, str) else _ask(list, output)
        arguments = dict(over=_range(over), input=input, output=outputs, digits=digits, threads=threads)
        return _result(_ask(_native.steady_response, self._native, arguments | dict(svg=False, peaks=True)))

    def motion(
        self,
        start: str | Mapping[str, Number] | None = None,
        until: Number | None = None,
        samples: int = 101,
        *,
        mode: int | None = None,
        amplitude: Number | None = None,
        at: Iterable[Number] | None = None,
        digits: int = 10,
        proved: bool = False,
        tolerance: float | None = None,
        _svg: bool = False,
    ) -> Result:
        """The motion from `start` (`"x=1, x'=0"` or a dict) or of a mode: `t`, and a field for each coordinate and
        each velocity (`motion["x'"]`), in SI."""
        arguments = dict(
            start=_start(start),
            until=_optional(until),
            samples=samples,
            mode=mode,
            amplitude=_optional(amplitude),
            at=None if at is None else [_text(one) for one in _list(at)],
            digits=digits,
            proved=proved,
            tolerance=tolerance,
            svg=_svg,
        )
        answer = _ask(_native.trajectory, self._native, arguments)
        if _svg:
            return _picture(answer)
        fields = json.loads(answer["json"])
        columns = fields.pop("columns")
        fields = {"t": fields.pop("times"), **{one["name"]: one["values"] for one in columns}, **fields}
        for name in ("error_bounds", "error_estimates"):
            if columns and name in columns[0]:
                fields[name] = {one["name"]: one[name] for one in columns}
        return Result(fields, answer["text"], _warn(answer["warnings"], 2))

    def equilibria(
        self, box: str | Mapping[str, Iterable[Number]], over: Range | None = None, *, _svg: bool = False
    ) -> Result:
        """Every equilibrium in a box, `"x=-2..2, phi=-pi..pi"` or `{"x": (-2, 2)}`, none missed; with `over` the
        `branches` of equilibria over a parameter, and their `bifurcations`."""
        arguments = dict(region=_box(box), over=None if over is None else _range(over), svg=_svg)
        answer = _ask(_native.all_equilibria, self._native, arguments)
        return _picture(answer) if _svg else _result(answer)

    def sensitivity(self, digits: int = 10, lowest: int | None = None) -> Result:
        """How much each frequency changes with each parameter: `modes` with their `derivatives`."""
        return _result(_ask(_native.sensitivities, self._native, digits, lowest))

    def amplitude(self, digits: int = 10) -> Result:
        """How the frequencies begin to change with the amplitudes of their modes."""
        return _result(_ask(_native.amplitudes, self._native, digits))

    def inertia(self, digits: int = 10) -> Result:
        """Principal moments and axes of every constant tensor of the model."""
        return _result(_ask(_native.tensors, self._native, digits))

    def show(
        self, digits: int = 10, lowest: int | None = None, over: Range | Sequence[Range] | None = None
    ) -> Page:
        """A page with the modes in motion, their digits, the model and its derivation.

        Sliders move one or two parameters `over` ranges, `"k=1..4:9"` or `{"k": (1, 4, 9), "m": (1, 2, 5)}`.
        """
        answer = _ask(_native.show, self._native, digits, lowest, [] if over is None else _ranges(over))
        _warn(answer["warnings"], 2)
        return Page(answer["text"])

    def plot(self, kind: str, **arguments: Any) -> Picture:
        """A picture of what a command answers: `modes`, `sweep`, `response`, `period`, `motion`, `floquet` or
        `equilibria`, with the arguments of that command; `spectrum` has those of `modes`.

        A sweep takes `orders`, lines for multiples of a rate of rotation (Campbell diagram), and `root_locus`, too.
        """
        if not isinstance(kind, str) or kind not in _PICTURES:
            raise _request(f"there is no picture of {kind!r}", f"one of {', '.join(_PICTURES)}", ArgumentError)
        own = {f"_{name}": arguments.pop(name) for name in ("orders", "root_locus") if name in arguments}
        if kind == "spectrum":
            kind, own["_spectrum"] = "modes", True
        return getattr(self, kind)(**arguments, **own, _svg=True)

    def matrices(self) -> dict[str, Any]:
        """M and K, and what there is of G, C and N; SciPy's sparse arrays for large models, where SciPy is there."""
        data, told = _ask(_native.archive, self._native)
        _warn(told, 2)
        with np.load(io.BytesIO(data)) as archive:
            parts = dict(archive)
        return {name[:-5]: _matrix(parts, name[:-5]) for name in parts if name.endswith("_data")}

    def export(self, code: str) -> str:
        """M, K and accelerations as source code: `"c"`, `"rust"` or `"python"`."""
        answer = _ask(_native.source_code, self._native, code)
        _warn(answer["warnings"], 2)
        return answer["text"]

    def fmt(self) -> str:
        """The text in canonical layout."""
        return _ask(_native.format, self.text)


def _again(kind: type[Model], text: str, arguments: tuple) -> Model:
    """A model from a pickle."""
    model = kind.__new__(kind)
    model._make(text, *arguments)
    return model


def _matrix(parts: dict[str, np.ndarray], name: str) -> Any:
    values, columns, starts, shape = (parts[f"{name}_{part}"] for part in ("data", "indices", "indptr", "shape"))
    if shape[0] > _DENSE:
        try:
            from scipy.sparse import csr_array
        except ImportError:
            pass
        else:
            return csr_array((values, columns, starts), tuple(int(count) for count in shape))
    matrix = np.zeros(shape)
    matrix[np.repeat(np.arange(shape[0]), np.diff(starts)), columns] = values
    return matrix


def fmt(text: str) -> str:
    """The text of a model in canonical layout."""
    if not isinstance(text, str):
        raise _request(f"a text is needed, not {text!r}", kind=ArgumentTypeError)
    _check_unicode(text)
    return _ask(_native.format, text)


def explain(code: str | None = None) -> str:
    """What an error or a warning means, with an example; without a code, the list of codes."""
    if code is None:
        return "\n".join(_native.codes())
    page = _ask(_native.page, code)
    if page is None:
        raise _request(f"there is no code `{code}`", "`librate.explain()` lists them")
    return page


def inertia(
    points: str | Any = None,
    mesh: bytes | None = None,
    *,
    density: Number | None = None,
    mass: Number | None = None,
    digits: int = 10,
) -> Result:
    """Mass, centre of mass and tensor of a table of points (CSV text or a data frame with `m x y z`) or of a mesh (the
    bytes of an STL file)."""
    if (points is None) == (mesh is None):
        raise _request("either points or a mesh are needed")
    if density is not None and mass is not None:
        raise _request("`density` and `mass` exclude each other")
    amount = None
    if density is not None or mass is not None:
        amount = (mass is not None, _text(density if mass is None else mass))
    return _result(_ask(_native.body, None if points is None else _table(points), mesh, amount, digits))
