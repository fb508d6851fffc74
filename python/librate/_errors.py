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


class MissingFileError(FileError, FileNotFoundError):
    """A file that does not exist."""


class ModelWarning(UserWarning):
    """Something legal, but suspicious, in a model."""


def _help(message: str, help: str) -> str:
    """Help for the command line, as it is in Python."""
    # Where a file could not be read, the reason follows.
    if table := re.fullmatch("the table `(.*)` can't be read", message):
        return f'give its text, `tables={{"{table[1]}": …}}`, or read the model with `librate.Model.open(path)`'
    help = re.sub(r"(?:on the command line: )?`?--set '?([^\s=]+)=([^\s'`]+)'?`?", r'`set={"\1": "\2"}`', help)
    return re.sub(r"`librate (\w+)`", r"`\1()`", help)


def _diagnostics(shown: dict) -> tuple[str, list[Diagnostic]]:
    """All of them drawn into the text, and one by one."""
    drawn, found = shown["drawn"], []
    for told in shown["told"]:
        help = told["help"] and _help(told["message"], told["help"])
        if help != told["help"]:
            drawn = drawn.replace(told["help"], help, 1)
        found.append(Diagnostic(**{**told, "help": help, "spans": tuple(Span(**span) for span in told["spans"])}))
    return drawn, found


def _error(shown: dict) -> Error:
    return Error(*_diagnostics(shown))


def _request(message: str, help: str | None = None) -> Error:
    """An error in a request that Python sees at once."""
    drawn = f"error: {message}" + (f"\nhelp: {help}" if help else "")
    return Error(drawn, [Diagnostic("error", None, message, help)])


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
