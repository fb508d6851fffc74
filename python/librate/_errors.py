"""Errors and warnings, with their places in the text of a model."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Span:
    """A place in the text of a model: `text[start:end]`; `line` and `column` count from 1."""

    start: int
    end: int
    line: int
    column: int
    label: str


@dataclass(frozen=True)
class Diagnostic:
    """An error or a warning. The first of `spans` is its place, the others are what it has to do with."""

    severity: str
    code: str | None
    message: str
    help: str | None
    spans: tuple[Span, ...] = ()

    def __str__(self) -> str:
        kind = f"{self.severity}[{self.code}]" if self.code else self.severity
        place = f" (line {self.spans[0].line}, column {self.spans[0].column})" if self.spans else ""
        return f"{kind}: {self.message}{place}"


class Error(Exception):
    """What is wrong with a model or a request; `str()` draws all of it into the text of the model."""

    diagnostics: list[Diagnostic]

    def __init__(self, drawn: str, diagnostics: Iterable[Diagnostic] = ()) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__(drawn, self.diagnostics)

    def __str__(self) -> str:
        return self.args[0]


class FileError(Error, OSError):
    """A file that can't be read."""

    def __reduce__(self) -> tuple:
        # An OSError has the name of the file among its arguments.
        own = {name: getattr(self, name) for name in ("errno", "strerror", "filename")}
        return type(self), self.args, {**self.__dict__, **own}


class MissingFileError(FileError, FileNotFoundError):
    """A file that does not exist."""


class ArgumentError(Error, ValueError):
    """An argument that can't be used, whatever the model."""


class ArgumentTypeError(ArgumentError, TypeError):
    """An argument of a wrong type."""


class ModelWarning(UserWarning):
    """Something legal, but suspicious, in a model."""


# An option of the command line with its value, if it has one; commands and options.
_OPTION = r"""--([a-z]{2,})(?: ('[^']*'|"[^"]*"|[^\s`-][^\s`]*))?"""
_CALL = f"`(?:librate ([a-z]+))?(?: FILE)?((?: ?{_OPTION})*)`"


def _call(words: re.Match) -> str:
    """`librate motion FILE --start "x=1"` as `motion(start="x=1")`, `--lowest 3` as `lowest=3`."""
    command, options = words[1], words[2]
    arguments = []
    for name, value in re.findall(_OPTION, options):
        # Numbers and `OMEGA` stay as they are, all else is a text.
        plain = re.fullmatch(r"[\d./]+|[A-Z]+", value)
        shown = value if plain else '"' + value.strip("'\"") + '"'
        arguments.append(f"{name}={shown}" if value else f"{name}=…" if command else name)
    return f"`{command}({', '.join(arguments)})`" if command else f"`{', '.join(arguments)}`"


def _help(message: str, help: str) -> str:
    """Help for the command line, as it is in Python."""
    # Where a file could not be read, the reason follows.
    if table := re.fullmatch("the table `(.*)` can't be read", message):
        return f'give its text, `tables={{"{table[1]}": …}}`, or read the model with `librate.Model.open(path)`'
    help = re.sub(r"(?:on the command line: )?`?--set '?([^\s=]+)=([^\s'`]+)'?`?", r'`set={"\1": "\2"}`', help)
    return re.sub(_CALL, _call, help)


def _diagnostics(shown: dict) -> tuple[str, list[Diagnostic]]:
    """All of them drawn into the text, and one by one."""
    drawn, found = shown["drawn"], []
    for told in shown["told"]:
        help = told["help"] and _help(told["message"], told["help"])
        if help != told["help"]:
            # Long lines are broken there.
            lines = r"\s+".join(map(re.escape, told["help"].split()))
            drawn = re.sub(lines, lambda _: help, drawn, count=1)
        found.append(Diagnostic(**{**told, "help": help, "spans": tuple(Span(**span) for span in told["spans"])}))
    return drawn, found


def _error(shown: dict) -> Error:
    return Error(*_diagnostics(shown))


def _request(message: str, help: str | None = None, kind: type[Error] = Error) -> Error:
    """An error in a request that Python sees at once."""
    drawn = f"error: {message}" + (f"\nhelp: {help}" if help else "")
    return kind(drawn, [Diagnostic("error", None, message, help)])


def _unread(path: object, error: OSError) -> FileError:
    kind = MissingFileError if isinstance(error, FileNotFoundError) else FileError
    message = f"can't read `{path}`: {error.strerror or error}"
    found = kind(f"error: {message}", [Diagnostic("error", None, message, None)])
    found.errno, found.strerror, found.filename = error.errno, error.strerror, error.filename
    return found


def _warn(shown: dict, level: int) -> list[Diagnostic]:
    """Issues warnings about a model, `level` callers up, and gives them as a list."""
    drawn, found = _diagnostics(shown)
    if found:
        warnings.warn(f"\n{drawn}", ModelWarning, stacklevel=level + 1)
    return found
