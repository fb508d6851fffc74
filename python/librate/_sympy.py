"""Expressions of the model language for SymPy."""

from __future__ import annotations

import ast
import itertools
import re
from typing import TYPE_CHECKING

import sympy

from ._errors import _request
from ._results import Result

if TYPE_CHECKING:
    from ._results import Derivation

_FUNCTIONS = {
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": sympy.tan,
    "asin": sympy.asin,
    "acos": sympy.acos,
    "atan": sympy.atan,
    "atan2": sympy.atan2,
    "sinh": sympy.sinh,
    "cosh": sympy.cosh,
    "tanh": sympy.tanh,
    "exp": sympy.exp,
    "ln": sympy.log,
    "sqrt": sympy.sqrt,
    "abs": sympy.Abs,
}
_TOKEN = re.compile(r"\s*(?:(?P<number>\d[\d.]*(?:e[+-]?\d+)?)|(?P<name>\w+(?:\[[\w, ]*\])?)(?P<primes>'*)|(?P<sign>.))")
_OPERATIONS = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: a**b,
}


# One of them is the imaginary unit of exponents: the first that is not a name of the model.
_UNITS = ("i", "j", "I")


class _Reader:
    """Reads expressions; each name of the model is one symbol, `m[1]` is `m_1`."""

    def __init__(self, coordinates: list[str], names: list[str]) -> None:
        self.time = sympy.Symbol("t")
        self.coordinates = set(coordinates)
        self.names = set(names)
        self.symbols: dict[str, sympy.Symbol] = {}

    def symbol(self, name: str) -> sympy.Symbol:
        """What a name stands for, at rest."""
        if name not in self.symbols:
            plain = "_".join(re.findall(r"\w+", name))
            taken = {own.name for own in self.symbols.values()} | self.names - {name}
            names = itertools.chain([plain], (name + "_" * more for more in itertools.count()))
            self.symbols[name] = sympy.Symbol(next(one for one in names if one not in taken))
        return self.symbols[name]

    def name(self, name: str, primes: int, moving: bool, unit: str | None) -> sympy.Expr:
        if name == "pi":
            return sympy.pi
        if name == unit:
            return sympy.I
        if moving and name == "t":
            return self.time
        symbol = self.symbol(name)
        if moving and name in self.coordinates:
            path = sympy.Function(symbol.name)(self.time)
            return path.diff(self.time, primes) if primes else path
        return sympy.Symbol(symbol.name + "'" * primes) if primes else symbol

    def read(self, text: str, moving: bool = False, unit: str | None = None) -> sympy.Expr:
        """Atoms become names of Python's, so that its own parser has the same precedences."""
        atoms: list[sympy.Expr] = []
        words: list[str] = []
        for token in _TOKEN.finditer(text.strip()):
            name = token["name"]
            if name in _FUNCTIONS and text[token.end() :].lstrip().startswith("("):
                words.append(name)
            elif token["sign"]:
                words.append("**" if token["sign"] == "^" else token["sign"])
            else:
                number = token["number"]
                atom = sympy.Rational(number) if number else self.name(name, len(token["primes"]), moving, unit)
                words.append(f" _{len(atoms)} ")
                atoms.append(atom)
        return self._walk(ast.parse("".join(words).strip(), mode="eval").body, atoms)

    def _walk(self, node: ast.expr, atoms: list[sympy.Expr]) -> sympy.Expr:
        match node:
            case ast.BinOp():
                return _OPERATIONS[type(node.op)](self._walk(node.left, atoms), self._walk(node.right, atoms))
            case ast.UnaryOp(op=ast.USub()):
                return -self._walk(node.operand, atoms)
            case ast.Call(func=ast.Name(id=name)):
                return _FUNCTIONS[name](*(self._walk(argument, atoms) for argument in node.args))
            case ast.Name(id=name):
                return atoms[int(name[1:])]
            case _:
                raise ValueError(f"an expression that SymPy is not given: {ast.unparse(node)}")


def _imaginary_unit(names: list[str]) -> str:
    taken = {name.split("[")[0] for name in names}
    for unit in _UNITS:
        if unit not in taken:
            return unit
    raise _request(
        "the model has the names i, j and I, so that exponents have no letter for the imaginary unit",
        '`derive(only=["mass", "stiffness"])` leaves them out',
    )


def converted(derivation: Derivation, names: list[str]) -> Result:
    """All that a derivation has of matrices, equations and closed forms; `names` are those of the model."""
    reader = _Reader(derivation.coordinates, names)
    fields: dict = {}
    for name in ("mass", "stiffness", "gyroscopic", "damping", "circulatory"):
        rows = derivation[name]
        fields[name] = None if rows is None else sympy.Matrix([[reader.read(entry) for entry in row] for row in rows])
    left = [equation.rsplit("=", 1)[0] for equation in derivation.equations]
    fields["equations"] = [sympy.Eq(reader.read(text, moving=True), 0, evaluate=False) for text in left]
    unit = _imaginary_unit(names) if derivation.exponents else None
    for name, key, letter in (("frequencies", "omega_squared", None), ("exponents", "exponent", unit)):
        fields[name] = [{**one, key: reader.read(one[key], unit=letter)} for one in derivation[name]]
    polynomial = derivation.get("characteristic")
    fields["characteristic"] = polynomial and [reader.read(text) for text in polynomial]
    result = Result({})
    result._fields = {**fields, "symbols": dict(reader.symbols), "t": reader.time}
    return result
