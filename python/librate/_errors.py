"""Errors and warnings, with their places in the text of a model."""

from __future__ import annotations

import warnings
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
    spans: tuple[Span, ...]
    drawn: str

    def __str__(self) -> str:
        return self.drawn


def _diagnostic(told: dict | Diagnostic) -> Diagnostic:
    if isinstance(told, Diagnostic):
        return told
    return Diagnostic(**{**told, "spans": tuple(Span(**span) for span in told["spans"])})


class Error(Exception):
    """What is wrong with a model or a request; `str()` draws all of it into the text of the model."""

    diagnostics: list[Diagnostic]

    def __init__(self, drawn: str, diagnostics: list = ()) -> None:
        self.diagnostics = [_diagnostic(told) for told in diagnostics]
        super().__init__(drawn, self.diagnostics)

    def __str__(self) -> str:
        return self.args[0]


def _request(message: str, help: str | None = None) -> Error:
    """An error in a request that Python sees at once."""
    drawn = f"error: {message}" + (f"\nhelp: {help}" if help else "")
    return Error(drawn, [Diagnostic("error", None, message, help, (), drawn)])


class ModelWarning(UserWarning):
    """Something legal, but suspicious, in a model."""


def _warn(told: list[dict], level: int) -> list[Diagnostic]:
    """Issues warnings about a model, `level` callers up, and gives them as a list."""
    diagnostics = [_diagnostic(one) for one in told]
    for diagnostic in diagnostics:
        warnings.warn(f"\n{diagnostic}", ModelWarning, stacklevel=level + 1)
    return diagnostics
