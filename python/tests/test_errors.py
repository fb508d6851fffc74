"""Errors, warnings, tables, and what no text may do."""

import errno
import inspect
import math
import os
import random
import re
import signal
import subprocess
import threading
import time
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

import librate
from conftest import Series

TABLED = """
table masses = "masses.csv"
coord x[1..rows(masses)]
T = sum(b in masses, 1/2*b.m*x[b]'^2)
V = sum(b in masses, 1/2*b.k*x[b]^2)
"""
ROWS = "m,k\n1,4\n1,9\n"
# Takes minutes.
LONG = """
param N = 200
coord x[1..N]
T = sum(i in 1..N, 1/2*x[i]'^2)
V = sum(i in 1..N, j in i+1..N, (x[i] - x[j])^2/(2*(i + j))) + sum(i in 1..N, 1/2*x[i]^2)
"""


def failed(text: str, **arguments) -> librate.Error:
    with pytest.raises(librate.Error) as caught:
        librate.Model(text, **arguments)
    return caught.value


def test_an_error_has_its_place_and_is_drawn_into_the_text():
    text = "# ½\ncoord x  T = 1/2*x'^2  V = 2 x"
    error = failed(text)
    [diagnostic] = error.diagnostics
    assert diagnostic.code == "E0007" and diagnostic.severity == "error" and diagnostic.help == "write `2*x`"
    [span] = diagnostic.spans
    assert text[span.start : span.end] == "2 x" and (span.line, span.column) == (2, 28)
    assert str(error).splitlines()[1:5] == [
        " --> model:2:28",
        "  |",
        "2 | coord x  T = 1/2*x'^2  V = 2 x",
        "  |                            ^^^ two factors without an operator between them",
    ]


def test_all_errors_are_there_at_once():
    error = failed("coord x  T = 1/2*a*x'^2  V = b*x^2")
    assert [diagnostic.message for diagnostic in error.diagnostics] == ["`a` is not declared", "`b` is not declared"]
    assert "model has 2 errors" in str(error)


def test_texts_that_are_no_models_at_all():
    many = failed("x = = 2 y\n" * 50_000)
    assert len(many.diagnostics) == 1000 and many.diagnostics[-1].spans[0].line == 1000
    for text in ("", "\0" * 1000, "coord x T = " + "(" * 100_000, "coord \ud800", "#" * 70_000_000):
        assert failed(text).diagnostics


def test_errors_are_drawn_as_the_command_line_does(command_line, tmp_path):
    path = tmp_path / "bad.lag"
    path.write_text("param l : m = 1\ncoord x : m\nT = 1/2*x'^2\nV = x + l^2 + q\n")
    told = subprocess.run([command_line, "check", path], capture_output=True, text=True, check=False).stderr
    with pytest.raises(librate.Error) as caught:
        librate.Model.open(path)
    assert str(caught.value) == told.rstrip()


@pytest.mark.parametrize(
    "arguments",
    [
        {"digits": 0},
        {"digits": 251},
        {"lowest": 0},
        {"lowest": -1},
        {"near": 1.0},
        {"lowest": 1, "near": 1.0, "count": 1},
        {"normalize": "long"},
        {"unit": "furlong"},
        {"certify": []},
        {"threads": 0},
    ],
)
def test_requests_that_can_not_be_met_are_errors(arguments):
    with pytest.raises(librate.Error) as caught:
        librate.Model("coord x  T = 1/2*x'^2  V = x^2").modes(**arguments)
    assert caught.value.diagnostics[0].help


def test_other_requests_that_can_not_be_met():
    model = librate.Model("param k = 1  coord x  T = 1/2*x'^2  V = k*x^2")
    requests = [
        lambda: model.period(),
        lambda: model.period(amplitude="one"),
        lambda: model.period(amplitude=1, energy=1),
        lambda: model.sweep("k"),
        lambda: model.sweep("q=1..2:3"),
        lambda: model.response("omega=1..2:3", input="y"),
        lambda: model.motion("x=1"),
        lambda: model.motion(until=1),
        lambda: model.motion("x=1", until=1, tolerance=1.0),
        lambda: model.equilibria("y=1..2"),
        lambda: model.floquet(),
        lambda: model.floquet(map=("k=1..2:3", "k=1..2:3")),
        lambda: model.derive(limit={"q": 0}),
        lambda: model.derive(only=["summary"]),
        lambda: model.batch({"q": [1.0]}),
        lambda: model.batch({}),
        lambda: model.batch({"k": [[1.0, 2.0]]}),
        lambda: model.modes(certify=np.full((1, 1), np.nan)),
        lambda: model.plot("sound"),
        lambda: model.plot("period", amplitude=1),
        lambda: model.export("cobol"),
        lambda: model.inertia(),
        lambda: librate.explain("E9999"),
        lambda: librate.fmt("coord"),
        lambda: librate.inertia(),
        lambda: librate.inertia("m,x\n1,2\n"),
        lambda: librate.inertia(mesh=b"solid\n"),
        lambda: librate.Model(model.text, set={"k": "one"}),
        lambda: librate.Model(model.text, set={"q": 1}),
        lambda: librate.Model(model.text, budget="ten"),
    ]
    for request in requests:
        with pytest.raises(librate.Error) as caught:
            request()
        assert str(caught.value).startswith("error") and caught.value.diagnostics


# Of every kind that somebody may hand over by mistake.
STRANGE = [
    None, 0, -1, 5, 2**70, -(2**70), 1.5, math.nan, math.inf, True, "", "x", "k=1..2:3", "nul\0", "\ud800", b"x", [], [1], ["k", "x"],
    (1, 2), (1, 2, 3), {}, {"k": 1}, {"k": (1, 2, 3)}, {1: 2}, {"k": "a"}, {"k": [[1]]}, object(), np.array([[1.0]]), np.array(["a"]),
    1j, Decimal("NaN"), range(3), {"k"}, len, dict, np.array([1.0, 2.0]), Series([1.0, 2.0]), Series(["1"], ["k"]), np.ma.masked,
    {"k": Series([1, 2])}, {"k": (1, 2, 2), "x": (1, 2, 2)}, {"k=1..2:3", "x=1..2:3"}, {"k": {1: 2}}, {"k": np.ma.masked},
]  # fmt: skip


def test_whatever_is_handed_over_the_error_is_one_of_librate(models):
    """Those for what no argument can be are a `ValueError` or a `TypeError`, too."""
    spring = librate.Model("param k = 1  coord x  T = 1/2*x'^2  V = k*x^2 + x^4", budget="2s")
    driven = librate.Model(
        "param W = 2  coord x  T = 1/2*x'^2  V = 1/2*(1 + cos(W*t)/10)*x^2  period 2*pi/W", budget="2s"
    )
    needed = {
        "sweep": {"over": "k=1..2:3"}, "batch": {"sets": {"k": [1.0]}}, "period": {"amplitude": 1}, "export": {"code": "c"},
        "response": {"over": "omega=1..2:3", "input": "x"}, "peaks": {"over": "omega=1..2", "input": "x"},
        "motion": {"start": "x=1", "until": 1}, "equilibria": {"box": "x=-1..1"}, "plot": {"kind": "modes"},
    }  # fmt: skip
    calls = []
    for model in (spring, driven):
        for name, method in inspect.getmembers(model, inspect.ismethod):
            if not name.startswith("_") and name != "open":
                parameters = inspect.signature(method).parameters
                calls += [(method, needed.get(name, {}), one) for one in parameters if one != "arguments" and not one.startswith("_")]
    calls += [(librate.Model, {"text": spring.text}, one) for one in ("text", "tables", "set", "budget")]
    calls += [(librate.Model.open, {"path": models / "water.lag"}, one) for one in ("path", "tables", "set", "allow_path", "budget")]
    calls += [(librate.inertia, {}, one) for one in ("points", "mesh")]
    calls += [(librate.inertia, {"points": "m,x,y,z\n1,2,3,4\n"}, one) for one in ("density", "mass", "digits")]
    calls += [(librate.fmt, {}, "text"), (librate.explain, {}, "code")]
    refused = 0
    for call, needed, name in calls:
        for value in STRANGE:
            try:
                call(**{**needed, name: value})
            except librate.Error as error:
                assert "extract field" not in str(error) and "unpack" not in str(error), (call, name, value)
                assert error.diagnostics and str(error).startswith("error"), (call, name, value)
                refused += 1
    assert len(calls) > 120 and refused > 3000
    for kind, code in {TypeError: 5, ValueError: "\ud800"}.items():
        with pytest.raises(kind):
            spring.export(code)


def test_a_path_is_no_text():
    for path in ("models/none.lag", "models/water.lag"):
        with pytest.raises(librate.Error, match="is a path") as caught:
            librate.Model(path)
        assert caught.value.diagnostics[0].help == f"`librate.Model.open({path!r})` reads a file"
    with pytest.raises(TypeError, match="Model.open"):
        librate.Model(Path("models/none.lag"))
    assert failed("V = b.lag").diagnostics[0].code


def test_what_is_suspicious_is_a_warning():
    model = librate.Model("param a = 1  param b = 2  coord x  T = 1/2*x'^2  V = a*x^2")
    with pytest.warns(librate.ModelWarning, match="the parameter `b` is never used"):
        modes = model.modes()
    assert [warning.code for warning in modes.warnings] == ["W0001"]


def test_tables_are_handed_over_by_the_name_of_the_file_or_of_the_table():
    class Frame:
        def to_csv(self, index):
            assert not index
            return ROWS

    for tables in ({"masses.csv": ROWS}, {"masses": ROWS}, {"masses": Frame()}):
        assert librate.Model(TABLED, tables).modes().omega.tolist() == [2, 3]
    error = failed(TABLED)
    [diagnostic] = error.diagnostics
    assert diagnostic.help.startswith('give its text, `tables={"masses.csv": …}`')
    assert f"= help: {diagnostic.help}" in str(error) and "relative" not in str(error)
    for table in ({"m": [1, 1]}, Path("masses.csv"), ROWS.encode(), np.eye(2), None):
        with pytest.raises(TypeError, match="the text of a CSV file or a data frame"):
            librate.Model(TABLED, {"masses.csv": table})


def test_help_names_arguments_of_python():
    spring = librate.Model("param k  coord x  T = 1/2*x'^2  V = 1/2*k*x^2")
    pendulum = librate.Model("coord x  T = 1/2*x'^2  V = 1 - cos(x)")
    requests = {
        lambda: spring.modes(): '`set={"k": "VALUE"}`',
        lambda: librate.Model(spring.text, set={"k": "one"}): '`set={"m[2]": "3/2"}`',
        lambda: librate.Model(spring.text, set={"k": 1}).floquet(): "use `modes()`",
        lambda: pendulum.response("omega=1..2:3"): '`input="x", over="omega=a..b:n"`, or',
        lambda: pendulum.response("omega=1..2:3", input="y"): '`input="x", output="x"`',
        lambda: pendulum.motion("x=1, x=2", until=1): """: `start="phi[1]=0.1, phi[1]'=0"`""",
        lambda: pendulum.motion("x=1", until=-1): "`until=10, samples=101`",
        lambda: pendulum.motion("x=1", until=1e9, proved=True): "without `proved` the",
        lambda: pendulum.period(-1): "`amplitude=1/2`, `energy=3`",
        lambda: pendulum.period(4): "; `energy` accepts",
        lambda: pendulum.equilibria("x=1"): '`box="x=-2..2, phi=-pi..pi"`',
        lambda: librate.Model(LONG, budget="1s").modes(digits=60): '`budget` raises it: `budget="10s"`',
        lambda: librate.Model("coord x[1..5000]  T = dot(x', x')  V = dot(x, x)").modes(): "`modes(lowest=10)`",
        lambda: librate.Model("start x = 1  coord x  T = x'^2"): "by `motion(start=…)`; `guess`",
    }
    for request, help in requests.items():
        with pytest.raises(librate.Error) as caught:
            request()
        told = caught.value.diagnostics[0].help
        assert help in told and told in str(caught.value) and not re.search(r"`?--[a-z]|`librate ", str(caught.value))


def test_tables_are_read_beside_the_model_and_nowhere_else(tmp_path):
    folder, other = tmp_path / "models", tmp_path / "other"
    folder.mkdir()
    other.mkdir()
    (folder / "model.lag").write_text(TABLED)
    (folder / "masses.csv").write_text(ROWS)
    assert librate.Model.open(folder / "model.lag").modes().omega.tolist() == [2, 3]
    (folder / "masses.csv").rename(other / "masses.csv")
    (folder / "model.lag").write_text(TABLED.replace("masses.csv", "../other/masses.csv"))
    with pytest.raises(librate.Error, match="allow_path"):
        librate.Model.open(folder / "model.lag")
    assert librate.Model.open(folder / "model.lag", allow_path=other).modes().omega.tolist() == [2, 3]
    with pytest.raises(FileNotFoundError) as caught:
        librate.Model.open(folder / "none.lag")
    assert isinstance(caught.value, librate.Error)
    assert caught.value.errno == errno.ENOENT
    assert caught.value.diagnostics[0].message.endswith("none.lag`: No such file or directory")
    with pytest.raises(librate.Error, match="Is a directory") as caught:
        librate.Model.open(folder)
    assert isinstance(caught.value, OSError)
    (folder / "model.lag").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(librate.Error, match="UTF-8"):
        librate.Model.open(folder / "model.lag")


def test_other_threads_run_meanwhile():
    """The interpreter is not held: a thread of Python's counts while another computes."""
    done = threading.Event()
    counted = 0

    def compute():
        with pytest.raises(librate.Error, match="budget"):
            librate.Model(LONG, budget="1s").modes(digits=60)
        done.set()

    thread = threading.Thread(target=compute)
    start = time.monotonic()
    thread.start()
    while not done.is_set() and time.monotonic() - start < 60:
        counted += 1
        time.sleep(0.001)
    thread.join()
    assert counted > 100


def test_an_interrupt_ends_a_computation():
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    start = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        librate.Model(LONG, budget="none").modes(digits=60)
    assert time.monotonic() - start < 10
    # The model is as good as before.
    assert librate.Model(LONG, set={"N": 5}).modes().kind == ["oscillation"] * 5


def test_work_in_many_parts_has_the_time_for_each_and_is_interrupted():
    chain = """
    param N = 10  param k = 1
    coord x[1..N]
    T = sum(i in 1..N, 1/2*x[i]'^2)
    V = sum(i in 1..N-1, 1/2*k*(x[i+1] - x[i])^2)
    """
    model = librate.Model(chain, budget="1s")
    requests = [lambda: model.sweep("k=1..2:100000", digits=40), lambda: model.batch({"k": [1.0] * 5_000_000})]
    for request in requests:
        # Beyond the budget of a part, and far from the end.
        timer = threading.Timer(2.5, lambda: os.kill(os.getpid(), signal.SIGINT))
        start = time.monotonic()
        timer.start()
        try:
            with pytest.raises(KeyboardInterrupt):
                request()
        finally:
            timer.cancel()
        assert 2 < time.monotonic() - start < 10


def test_a_budget_ends_what_takes_too_long_and_too_much():
    model = librate.Model(LONG, budget="1s")
    with pytest.raises(librate.Error) as caught:
        model.modes(digits=60)
    assert caught.value.diagnostics[0].code == "E0901"
    assert model.modes(lowest=1, vectors=False).omega[0] == pytest.approx(1)
    assert failed("coord x[1..1000000000]  T = sum(i in 1..1000000000, x[i]'^2)").diagnostics


def test_no_text_does_worse_than_an_error(models):
    """Models with pieces cut out, doubled and exchanged: an error or an answer, soon."""
    chance = random.Random(22)
    names = ["three_pendulums", "double_pendulum", "bead_on_hoop", "mathieu", "water", "governor"]
    texts = [(models / f"{name}.lag").read_text() for name in names]
    answered = refused = 0
    for _ in range(150):
        text = chance.choice(texts)
        for _ in range(chance.randint(1, 3)):
            start = chance.randrange(len(text))
            end = min(len(text), start + chance.randint(1, 12))
            new = chance.choice(["", text[start:end] * 2, chance.choice(["(", "'", "^^", "½", "\0", "1e999", "sum(", "-"])])
            text = text[:start] + new + text[end:]
        start = time.monotonic()
        try:
            librate.Model(text, budget="20s").modes()
            answered += 1
        except librate.Error as error:
            assert error.diagnostics
            refused += 1
        assert time.monotonic() - start < 30
    assert answered > 5 and refused > 50
