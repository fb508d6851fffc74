"""Modes: values against closed forms and against the command line."""

import copy
import decimal
import errno
import json
import pickle
import subprocess
from fractions import Fraction

import numpy as np
import pytest

import librate
from conftest import Series

CHAIN = """
param N = 5  param k = 1  param m = 1
coord x[1..N]
T = sum(i in 1..N, 1/2*m*x[i]'^2)
V = sum(i in 1..N-1, 1/2*k*(x[i+1] - x[i])^2) + 1/2*k*x[1]^2 + 1/2*k*x[N]^2
"""
DAMPED = """
param c = 0.3
coord x, y
T = 1/2*x'^2 + y'^2
V = x^2 + 1/2*(x - y)^2
dissipation = 1/2*c*x'^2
"""


def test_a_chain_has_the_frequencies_of_the_closed_form():
    modes = librate.Model(CHAIN, set={"N": 40}).modes()
    expected = 2 * np.sin(np.arange(1, 41) * np.pi / 82)
    assert np.all(np.abs(modes.omega - expected) <= modes.error_bound + 4e-16)
    assert modes.omega.dtype == modes.growth.dtype == modes.error_bound.dtype == modes.vectors.dtype == np.float64
    assert modes.vectors.shape == (40, 40)
    assert np.allclose(modes.vectors @ modes.vectors.T, np.eye(40), atol=1e-13)
    assert modes.kind == ["oscillation"] * 40 and modes.stability == "stable"
    assert modes.symmetry[:2] == ["even", "odd"]
    assert np.all(modes.equilibrium == 0) and modes.coordinates[-1] == "x[40]"


def test_every_digit_is_right():
    digits = librate.Model("coord x  T = 1/2*x'^2  V = x^2").modes(digits=60).digits[0]
    with decimal.localcontext(decimal.Context(prec=60)):
        assert digits == str(decimal.Decimal(2).sqrt())


def test_some_modes_and_no_vectors():
    chain = librate.Model(CHAIN, set={"N": 3000})
    modes = chain.modes(lowest=3, vectors=False)
    assert modes.vectors is None
    assert np.allclose(modes.omega, 2 * np.sin(np.arange(1, 4) * np.pi / 6002), rtol=1e-12)
    near = chain.modes(near=1.0, count=2)
    assert near.vectors.shape == (2, 3000) and np.all(np.abs(near.omega - 1) < 1e-3)


def test_complex_shapes_of_a_damped_model():
    model = librate.Model(DAMPED)
    modes = model.modes()
    matrices = model.matrices()
    assert modes.vectors.dtype == np.complex128 and modes.kind == ["damped", "damped"]
    for omega, growth, shape in zip(modes.omega, modes.growth, modes.vectors):
        s = growth + 1j * omega
        residual = (s**2 * matrices["M"] + s * matrices["C"] + matrices["K"]) @ shape
        assert np.abs(residual).max() < 1e-14
        assert np.vdot(shape, matrices["M"] @ shape).real == pytest.approx(1, abs=1e-14)


def test_certified_vectors_of_another_solver():
    chain = librate.Model(CHAIN)
    matrices = chain.matrices()
    squares, columns = np.linalg.eigh(matrices["K"])
    modes = chain.modes(certify=columns[:, :2].T)
    assert np.all(np.abs(modes.omega - np.sqrt(squares[:2])) < 1e-14) and np.all(modes.error_bound < 1e-13)
    assert chain.modes(certify=columns[:, 0]).omega == modes.omega[:1]
    for shapes in (columns[:, :2], columns.ravel(), columns[None], np.eye(3)):
        with pytest.raises(librate.ArgumentTypeError, match=r"rows of 5 numbers(.|\n)*certify=v\.T"):
            chain.modes(certify=shapes)
    with pytest.raises(librate.ArgumentTypeError, match="real numbers"):
        chain.modes(certify=columns.T * 1j)


@pytest.mark.parametrize(
    "name", ["three_pendulums", "water", "cyclotron", "damped_pair", "two_masses_free", "body_from_table", "governor"]
)
def test_modes_are_those_of_the_command_line(models, command_line, name):
    path = models / f"{name}.lag"
    known = json.loads(subprocess.run([command_line, "modes", path, "--json"], capture_output=True, check=True).stdout)
    modes = librate.Model.open(path).modes()
    for field in ("coordinates", "stability", "secular", "model"):
        assert modes[field] == known[field]
    assert modes.digits == [mode["omega_digits"] for mode in known["modes"]]
    assert modes.kind == [mode["kind"] for mode in known["modes"]]
    assert modes.symmetry == [mode.get("symmetry") for mode in known["modes"]]
    assert modes.omega.tolist() == [mode["omega"] for mode in known["modes"]]
    assert modes.error_bound.tolist() == [mode["error_bound"] for mode in known["modes"]]
    for row, mode in zip(modes.vectors, known["modes"]):
        shape = np.array(mode["vector"])
        assert np.array_equal(row, shape[:, 0] + 1j * shape[:, 1] if shape.ndim == 2 else shape)
    printed = subprocess.run([command_line, "modes", path], capture_output=True, text=True, check=True).stdout
    assert repr(modes) == printed.rstrip()


def test_parameters_are_set_by_numbers_and_texts():
    text = "param m[1..2] = 1  param k = 1  coord x[1..2]  T = 1/2*m[1]*x[1]'^2 + 1/2*m[2]*x[2]'^2  V = k*dot(x, x)"
    model = librate.Model(text, set={"m": [0.1, "1/3"], "k": np.float64(0.5)})
    assert model.parameters == {"m[1]": 0.1, "m[2]": 1 / 3, "k": 0.5}
    again = librate.Model(text, set={"m": [np.array(0.1), Fraction(1, 3)], "k": np.array(0.5)})
    assert again.parameters == model.parameters
    # The members in their order, wherever the indices begin, and all of them.
    family = "param m[0..2, 1..2] = 1  coord x  T = 1/2*m[0,1]*x'^2  V = 1/2*m[2,2]*x^2"
    values = librate.Model(family, set={"m": [[1, 2], [3, 4], (5, "6")]}).parameters
    assert values == {f"m[{i},{j}]": 2.0 * i + j for i in range(3) for j in (1, 2)}
    with pytest.raises(librate.Error, match="has 2 members, but a vector of 3 is given"):
        librate.Model(text, set={"m": [1, 2, 3]})
    assert librate.Model(text, set={"m": Series([2, 3])}).parameters["m[2]"] == 3
    assert librate.Model(text, set=Series([8], ["k"])).parameters["k"] == 8
    # What has no order, or characters for numbers.
    for values in ({1: 5, 2: 7}, {5, 7}, frozenset([5, 7]), b"57", bytearray(b"57"), memoryview(b"57"), [{1: 5}, 7]):
        with pytest.raises(librate.ArgumentTypeError, match="a list or an array is needed"):
            librate.Model(text, set={"m": values})
    # One tenth, not its nearest double.
    assert model.modes(digits=30).digits[1] == "3.16227766016837933199889354443"


def test_models_results_and_errors_are_pickled(models):
    pendulums = librate.Model.open(models / "three_pendulums.lag")
    for result in (pendulums.modes(), pendulums.derive(limit={"k12": 0}), pendulums.sweep("k12=0..8:3")):
        again = pickle.loads(pickle.dumps(result))
        assert repr(again) == repr(result) and list(again) == list(result)
    model = pickle.loads(pickle.dumps(librate.Model.open(models / "body_from_table.lag")))
    assert model.modes().digits == librate.Model.open(models / "body_from_table.lag").modes().digits
    with pytest.raises(librate.Error) as caught:
        librate.Model("coord x  T = 1/2*y'^2")
    with pytest.raises(librate.FileError) as unread:
        librate.Model.open(models / "none.lag")
    for error in (caught.value, unread.value):
        for again in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
            assert type(again) is type(error) and str(again) == str(error) and again.diagnostics == error.diagnostics
    assert (again.errno, again.filename) == (errno.ENOENT, str(models / "none.lag")) and again.strerror


def test_modes_are_a_table_in_a_notebook(models):
    html = librate.Model.open(models / "three_pendulums.lag").modes()._repr_html_()
    assert html.startswith("<table>") and "3.132091953" in html and "even" in html
    stiff = librate.Model("param k = 1e30  coord x, y  T = 1/2*x'^2 + 1/2*y'^2  V = 1/2*k*(x - y)^2").modes()
    assert "<td>0</td><td>0</td>" in stiff._repr_html_() and "<td>5e5</td>" in stiff._repr_html_()
