"""The other commands, against closed forms and the command line."""

import csv
import io
import html
import json
import math
import subprocess
from fractions import Fraction

import numpy as np
import pytest

import librate
from conftest import Series
from librate import _native

PENDULUM = """
param g = 9.81  param l = 1
coord phi
T = 1/2*l^2*phi'^2
V = g*l*(1 - cos(phi))
"""
PAIR = """
param k = 1  param c = 2  param m[1..2] = 1
coord x[1..2]
T = 1/2*m[1]*x[1]'^2 + 1/2*m[2]*x[2]'^2
V = 1/2*k*(x[1]^2 + x[2]^2) + 1/2*c*(x[1] - x[2])^2
"""


def test_period_of_a_pendulum():
    from scipy.special import ellipk

    pendulum = librate.Model(PENDULUM)
    found = pendulum.period(amplitude=2)
    assert found.period == pytest.approx(4 / math.sqrt(9.81) * ellipk(math.sin(1) ** 2), rel=1e-14)
    assert found["small_amplitude_period"] == pytest.approx(2 * math.pi / math.sqrt(9.81), rel=1e-15)
    assert "2.5" in repr(found) or "period" in repr(found)
    curve = pendulum.period(over={"amplitude": (1, 3, 3)})
    assert curve.over.tolist() == [1, 2, 3] and curve.period[1] == found.period


def test_sweep():
    sweep = librate.Model(PAIR).sweep({"c": (0, 4, 5)})
    assert sweep.parameter == "c" and sweep.over.tolist() == [0, 1, 2, 3, 4]
    expected = np.sqrt(np.stack([np.ones(5), 1 + 2 * sweep.over], axis=1))
    assert np.all(np.abs(sweep.omega - expected) <= sweep.error_bound + 3e-16)
    assert sweep.digits[2] == ["1.000000000", "2.236067977"] and sweep.kind[0] == ["oscillation"] * 2
    assert sweep.places[1].stability == "stable"
    assert next(csv.reader(io.StringIO(repr(sweep)))) == ["c", "omega1", "omega2"]


def test_a_range_is_a_list_or_an_array_of_equally_spaced_values():
    pair = librate.Model(PAIR)
    known = pair.sweep({"c": (0, 0.3, 4)})
    assert repr(pair.sweep({"c": np.linspace(0, 0.3, 4)})) == repr(known)
    assert repr(pair.sweep({"c": np.array([0, 4, 8])})) == repr(pair.sweep("c=0..8:3"))
    # Only a tuple has the ends and their count.
    assert pair.sweep({"c": (1, 2, 3)}).over.tolist() == [1, 1.5, 2]
    for values in ([1, 2, 3], range(1, 4), ["1", 2, Fraction(3)], np.array([1, 2, 3]), Series([1.0, 2.0, 3.0])):
        assert pair.sweep({"c": values}).over.tolist() == [1, 2, 3]
    assert repr(pair.sweep({"c": np.linspace(0, 1, 11, dtype=np.float32)})) == repr(pair.sweep("c=0..1:11"))
    masked = np.ma.array([1, 2, 3], mask=[0, 1, 0])
    wrong = [np.geomspace(1, 8, 4), [0, 2, 5, 6], np.array([np.nan, 1.0]), np.eye(2), np.array([]), masked, {0, 1}, "123", [1j]]
    for values in wrong:
        with pytest.raises(ValueError, match=r"\(0, 8, 17\).* equally spaced"):
            pair.sweep({"c": values})


def test_sweep_beyond_an_instability():
    well = librate.Model("param k = 1  coord x  T = 1/2*x'^2  V = 1/4*x^4 - 1/2*k*x^2  equilibrium x = sqrt(k)")
    with pytest.warns(librate.ModelWarning, match="at k = -1"):
        sweep = well.sweep("k=-1..1:3")
    assert np.isnan(sweep.omega[0, 0]) and sweep.kind[1] == ["zero"] and sweep.omega[2, 0] == math.sqrt(2)


def test_batch_agrees_with_numpy_and_with_certified_modes():
    random = np.random.default_rng(22)
    sets = {"k": random.uniform(0.5, 2, 1000), "m": random.uniform(0.5, 2, (1000, 2)), "c": 1.5}
    found = librate.Model(PAIR).batch(sets, vectors=True, matrices=True)
    k, m = sets["k"], sets["m"]
    mass = np.zeros((1000, 2, 2))
    mass[:, 0, 0], mass[:, 1, 1] = m.T
    stiffness = np.empty((1000, 2, 2))
    stiffness[:, 0, 0] = stiffness[:, 1, 1] = k + 1.5
    stiffness[:, 0, 1] = stiffness[:, 1, 0] = -1.5
    assert np.allclose(found.mass, mass, rtol=1e-15) and np.allclose(found.stiffness, stiffness, rtol=1e-15)
    root = np.sqrt(m)
    squares = np.linalg.eigvalsh(stiffness / (root[:, :, None] * root[:, None, :]))
    assert np.allclose(found.omega_squared, squares, rtol=1e-12)
    assert np.allclose(found.omega**2, squares, rtol=1e-12) and set(found.outcome) == {"solved"}
    ones = np.einsum("smi,sij,snj->smn", found.vectors, mass, found.vectors)
    assert np.allclose(ones, np.eye(2), atol=1e-12)
    # Doubles are exact as fractions.
    exact = {"k": k[7], "m[1]": m[7, 0], "m[2]": m[7, 1], "c": 1.5}
    exact = {name: "/".join(map(str, float(value).as_integer_ratio())) for name, value in exact.items()}
    certified = librate.Model(PAIR, set=exact).modes()
    assert np.all(np.abs(found.omega[7] - certified.omega) <= found.error_bound[7] + certified.error_bound)
    assert np.all(found.error_bound < 1e-12)


DAMPED_PAIR = """
param k = 1  param c = 0.1  param W = 0.3  param p = 0.2
coord x, y
T = 1/2*((x' - W*y)^2 + (y' + W*x)^2)
V = 1/2*k*(x^2 + y^2)
dissipation = 1/2*c*x'^2
force y = -p*x
"""


def test_batch_of_exponents_agrees_with_numpy_and_with_certified_modes():
    random = np.random.default_rng(23)
    sets = {name: random.uniform(0.5, 2, 1000) for name in "kcWp"}
    found = librate.Model(DAMPED_PAIR).batch(sets, vectors=True, matrices=True)
    k, c, W, p = sets.values()
    stiffness, velocity = np.zeros((2, 1000, 2, 2))
    stiffness[:, 0, 0] = stiffness[:, 1, 1] = k - W**2
    stiffness[:, 1, 0], velocity[:, 0, 0], velocity[:, 0, 1], velocity[:, 1, 0] = p, c, -2 * W, 2 * W
    assert np.allclose(found.mass, np.eye(2)) and np.allclose(found.stiffness, stiffness, rtol=1e-15)
    assert np.allclose(found.velocity, velocity, rtol=1e-15) and set(found.outcome) == {"solved"}
    first_order = np.block([[np.zeros((1000, 2, 2)), np.tile(np.eye(2), (1000, 1, 1))], [-stiffness, -velocity]])
    known = np.linalg.eigvals(first_order)
    apart = np.abs(found.exponents[:, :, None] - known[:, None, :])
    assert found.exponents.shape == (1000, 4)
    assert np.all(apart.min(axis=2) < 1e-12) and np.all(apart.min(axis=1) < 1e-12)
    s, x = found.exponents[:, :, None], found.vectors
    rest = s**2 * x + s * np.einsum("sij,smj->smi", velocity, x) + np.einsum("sij,smj->smi", stiffness, x)
    assert np.all(np.abs(rest) < 1e-12) and np.allclose(np.abs(x**2).sum(axis=2), 1, rtol=1e-14)
    exact = {name: "/".join(map(str, float(values[7]).as_integer_ratio())) for name, values in sets.items()}
    certified = librate.Model(DAMPED_PAIR, set=exact).modes()
    for growth, omega in zip(certified.growth, certified.omega):
        off = np.abs(found.exponents[7] - complex(growth, omega))
        assert np.any(off <= found.exponent_error_bound[7] + 1e-15)
    assert np.all(found.exponent_error_bound < 1e-12) and found.omega is None and found.growth is None
    plain = librate.Model(DAMPED_PAIR).batch({"c": [0.1, np.nan, 0.2]}, bounds=False)
    assert plain.outcome.tolist() == ["solved", "not finite", "solved"] and np.isnan(plain.exponents[1]).all()
    assert np.isinf(plain.exponent_error_bound[0]).all() and plain.vectors is None and plain.velocity is None


def test_batch_of_sets_that_fail():
    found = librate.Model(PAIR).batch({"k": [1.0, np.nan], "m": [1.0, -1.0]})
    assert found.outcome.tolist() == ["solved", "not finite"] and np.all(np.isnan(found.omega[1]))
    assert librate.Model(PAIR).batch({"k": []}).omega.shape == (0, 2)
    masked = librate.Model(PAIR).batch({"k": np.ma.array([1.0, 2.0], mask=[False, True])})
    assert masked.outcome.tolist() == ["solved", "not finite"]
    for values in (np.array([1, 1j]), [1j], b"12", bytearray(b"12"), {0: 1.0}):
        with pytest.raises(librate.ArgumentTypeError):
            librate.Model(PAIR).batch({"k": values})


def test_motion_of_an_oscillator():
    oscillator = librate.Model("coord x  T = 1/2*x'^2  V = 2*x^2")
    for arguments in ({}, {"proved": True}, {"tolerance": 1e-14}):
        motion = oscillator.motion({"x": 1}, until=3, samples=31, **arguments)
        assert motion.t.shape == (31,) and motion.coordinates == ["x"]
        assert np.allclose(motion["x"], np.cos(2 * motion.t), atol=1e-11)
        assert np.allclose(motion["x'"], -2 * np.sin(2 * motion.t), atol=1e-11)
    assert np.allclose(oscillator.motion(mode=1, amplitude="1/2", at=[0, 1]).x, [0.5, 0.5 * math.cos(2)], rtol=1e-13)


def test_floquet_of_a_pumped_swing_and_a_chart(models):
    swing = librate.Model.open(models / "child_on_swing.lag")
    found = swing.floquet()
    assert found.multipliers.dtype == np.complex128
    assert found.growth_rate == pytest.approx(math.log(abs(found.multipliers).max()) / found.period, rel=1e-12)
    chart = librate.Model.open(models / "mathieu.lag").floquet(map=({"a": (4, 0, 5)}, "q=0..2:3"))
    assert chart.a.tolist() == [4, 3, 2, 1, 0] and chart.q.tolist() == [0, 1, 2]
    # Without any force a body drifts away.
    expected = [[1, 0, 0], [1, 1, 1], [1, 1, 0], [1, 0, 0], [np.nan, 0, 0]]
    assert np.array_equal(chart.stable, expected, equal_nan=True)
    mathieu = librate.Model.open(models / "mathieu.lag")
    assert repr(mathieu.floquet(map={"a": (4, 0, 5), "q": (0, 2, 3)})) == repr(chart)
    # Both axes may be one value, again and again.
    assert mathieu.floquet(map=({"a": (1, 1, 3)}, {"q": (0.3, 0.3, 2)})).stable.shape == (3, 2)
    with pytest.raises(librate.Error) as caught:
        swing.modes()
    assert "floquet" in str(caught.value) and swing.is_driven


def test_an_infinite_amplitude_is_a_number():
    model = librate.Model("coord x T = 1/2*x'^2 V = 2*x^2")
    with pytest.warns(librate.ModelWarning, match="infinite"):
        amplitude = model.response(over={"omega": (1, 3, 3)}, input="x")["x amplitude"]
    assert amplitude.tolist() == pytest.approx([1 / 3, math.inf, 1 / 5])


def test_response_of_a_damped_oscillator():
    model = librate.Model("coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/20*x'^2")
    found = model.response("omega=0..2:21", input="x", output="x")
    [output] = found.outputs
    exact = 1 / (1 - found.omega**2 + 0.1j * found.omega)
    assert np.allclose(output.amplitude, abs(exact), rtol=1e-14)
    assert np.allclose(np.nan_to_num(output.phase), np.angle(exact), atol=1e-14)


def test_peaks_of_a_damped_oscillator():
    model = librate.Model("coord x  T = 1/2*x'^2  V = 1/2*x^2  dissipation = 1/20*x'^2")
    [output] = model.peaks({"omega": (0, 2)}, input="x").outputs
    [peak] = output.peaks
    assert peak.kind == "maximum" and output.undecided == []
    assert peak.at == pytest.approx(np.sqrt(1 - 0.1**2 / 2), rel=1e-15)
    assert peak.half_power_from < peak.at < peak.half_power_to


def test_equilibria_of_a_double_well():
    found = librate.Model("coord x  T = 1/2*x'^2  V = 1/4*x^4 - 1/2*x^2").equilibria({"x": (-2, 2)})
    assert found.complete
    assert [one.point[0] for one in found.equilibria] == pytest.approx([-1, 0, 1])
    assert [one.stability for one in found.equilibria] == ["stable", "unstable", "stable"]


def test_branches_of_equilibria_and_a_pitchfork():
    well = librate.Model("param k = 1  coord x  T = 1/2*x'^2  V = 1/4*x^4 - 1/2*k*x^2")
    found = well.equilibria({"x": (-2, 2)}, over={"k": (-1, 1, 11)})
    assert len(found.branches) >= 2
    [pitchfork] = found.bifurcations
    assert pitchfork.kind == "pitchfork" and pitchfork.k == pytest.approx(0, abs=1e-9)


def test_sensitivity_and_amplitude_of_a_pendulum():
    pendulum = librate.Model(PENDULUM)
    [mode] = pendulum.sensitivity().modes
    assert mode.derivatives["l"] == pytest.approx(-0.5 * math.sqrt(9.81), rel=1e-14)
    [mode] = pendulum.amplitude().modes
    assert mode.frequency_change == pytest.approx(-1 / 16, abs=1e-15)


def test_inertia_of_a_model_points_and_a_mesh(models):
    tensor = librate.Model("param m = 3  param a = 2  let I = inertia_sphere(m, a)").inertia()
    assert "4.8" in repr(tensor)
    points = librate.inertia("m,x,y,z\n1,1,0,0\n1,-1,0,0\n")
    assert points.mass == 2 and points.centre.tolist() == [0, 0, 0]
    box = librate.inertia(mesh=(models / "data/box.stl").read_bytes(), mass=3)
    assert box.mass == pytest.approx(3)


def test_matrices_are_arrays_and_sparse_where_large():
    matrices = librate.Model(PAIR).matrices()
    assert sorted(matrices) == ["K", "M"]
    assert matrices["K"].tolist() == [[3, -2], [-2, 3]] and matrices["M"].tolist() == [[1, 0], [0, 1]]
    sparse = pytest.importorskip("scipy.sparse")
    chain = "coord x[1..2000]  T = sum(i in 1..2000, 1/2*x[i]'^2)  V = sum(i in 2..2000, 1/2*(x[i] - x[i-1])^2)"
    stiffness = librate.Model(chain).matrices()["K"]
    assert sparse.issparse(stiffness) and stiffness.nnz == 2 + 2 * 1999 + 1998
    assert stiffness[5, 5] == 2 and stiffness[5, 6] == -1


def test_derivation(models):
    derivation = librate.Model.open(models / "three_pendulums.lag").derive()
    assert derivation.mass[1] == ["0", "m[2]*l[2]^2", "0"] and derivation.damping is None
    assert derivation.stiffness[0][1] == "-L^2*k12" and derivation.gyroscopic is None
    assert [one["omega_squared"] for one in derivation.frequencies][0] == "g/l[1]"
    assert len(derivation.equations) == 3 and derivation.equations[0].endswith("= 0")
    assert "\\ddot" in derivation.latex and derivation._repr_latex_() == derivation.latex
    assert "<math" in derivation._repr_html_() and "Lagrange" in repr(derivation)


def test_typst_compiles(models, tmp_path):
    typst = pytest.importorskip("typst")
    page = tmp_path / "page.typ"
    for path in sorted(models.glob("*.lag"))[::4]:
        page.write_text(librate.Model.open(path).derive().typst, encoding="utf-8")
        assert typst.compile(page), path


def test_a_derivation_is_that_of_the_command_line(models, command_line):
    path = models / "foucault_pendulum.lag"
    known = subprocess.run([command_line, "derive", path, "--json"], capture_output=True, check=True).stdout
    derivation = librate.Model.open(path).derive()
    for name, value in json.loads(known).items():
        assert derivation[name] == value


def test_a_derivation_in_sympy(models):
    sympy = pytest.importorskip("sympy")
    k, c, m1, m2 = sympy.symbols("k c m_1 m_2")
    found = librate.Model(PAIR).derive().to_sympy()
    assert found.mass == sympy.diag(m1, m2)
    assert (found.stiffness - sympy.Matrix([[k + c, -c], [-c, k + c]])).expand().is_zero_matrix
    pendulum = librate.Model(PENDULUM).derive().to_sympy()
    g, l, t = sympy.symbols("g l t")
    phi = sympy.Function("phi")(t)
    assert sympy.simplify(pendulum.equations[0].lhs - (l**2 * phi.diff(t, 2) + g * l * sympy.sin(phi))) == 0
    assert sympy.simplify(pendulum.frequencies[0]["omega_squared"] - g / l) == 0
    assert sympy.simplify(pendulum.exponents[0]["exponent"] ** 2 + g / l) == 0
    assert pendulum.symbols["g"] == g


def test_names_stay_different_in_sympy():
    sympy = pytest.importorskip("sympy")
    text = """param m[1..2] = 1  param m_1 = 5  coord x[1..2]  V = 1/2*dot(x, x)
        T = 1/2*m[1]*x[1]'^2 + 1/2*(m[2] + m_1)*x[2]'^2"""
    found = librate.Model(text).derive().to_sympy()
    one, two, other = (found.symbols[name] for name in ("m[1]", "m[2]", "m_1"))
    assert len({one, two, other}) == 3 and found.mass == sympy.diag(one, two + other)
    text = "param t_ = 2  param _t = 3  param _ = 4  param x_ = 5  coord x  T = 1/2*t_*_*x'^2  V = 1/2*_t*x_*x^2"
    found = librate.Model(text).derive().to_sympy()
    names = ["t_", "_t", "_", "x_", "x"]
    assert {name: found.symbols[name].name for name in names} == {name: name for name in names}
    assert found.equations[0].lhs.coeff(sympy.Function("x")(found.t)) == sympy.Symbol("_t") * sympy.Symbol("x_")


def test_letters_of_the_imaginary_unit_are_names_of_a_model():
    sympy = pytest.importorskip("sympy")
    i, j, k = sympy.symbols("i j k")
    energies = {
        "param i = 2  param k = 3  coord x  T = 1/2*i*x'^2  V = 1/2*k*x^2": (i, k),
        "param i = 2  param j = 3  coord x  T = 1/2*i*x'^2  V = 1/2*j*x^2": (i, j),
        "param k = 3  param i = k  coord x  T = 1/2*x'^2  V = 1/2*i*x^2": (1, k),
        "param k = 3  let i = k  coord x  T = 1/2*x'^2  V = 1/2*i*x^2": (1, k),
        "param k = 3  coord i  T = 1/2*i'^2  V = 1/2*k*i^2": (1, k),
        "param i[1..2] = 2  coord x  T = 1/2*i[1]*x'^2  V = 1/2*i[2]*x^2": sympy.symbols("i_1 i_2"),
    }
    for text, (mass, stiffness) in energies.items():
        found = librate.Model(text).derive().to_sympy()
        assert found.mass[0] == mass and found.stiffness[0] == stiffness
        exponents = [one["exponent"] for one in found.exponents]
        assert len(exponents) == 2 and all(sympy.simplify(mass * one**2 + stiffness) == 0 for one in exponents)
    full = librate.Model("param i = 1  param j = 2  param I = 3  coord x  T = 1/2*i*j*x'^2  V = 1/2*I*x^2")
    with pytest.raises(librate.Error, match="no letter for the imaginary unit"):
        full.derive().to_sympy()
    assert full.derive(only=["mass", "stiffness"]).to_sympy().stiffness[0] == sympy.Symbol("I")


def test_all_models_go_to_sympy_at_their_values(models):
    """What SymPy is given has the numbers of M and K."""
    pytest.importorskip("sympy")
    for name in ["double_pendulum", "bead_on_hoop", "rotating_spring", "water", "damped_pair", "body_from_table"]:
        model = librate.Model.open(models / f"{name}.lag")
        derivation = model.derive().to_sympy()
        values = {derivation.symbols[name]: value for name, value in model.parameters.items() if name in derivation.symbols}
        matrices = model.matrices()
        for own, field in (("M", "mass"), ("K", "stiffness"), ("G", "gyroscopic"), ("C", "damping")):
            if own in matrices:
                numbers = np.array(derivation[field].subs(values).evalf().tolist(), dtype=float)
                assert np.allclose(numbers, matrices[own], rtol=1e-12, atol=1e-12), (name, own)


def test_pictures_and_pages(models):
    pendulums = librate.Model.open(models / "three_pendulums.lag")
    requests = {
        "modes": {},
        "sweep": {"over": "k12=0..8:5"},
        "response": {"over": "omega=0..5:11", "input": "phi[1]"},
        "equilibria": {"box": {"phi[1]": (-1, 1), "phi[2]": (-1, 1), "phi[3]": (-1, 1)}},
        "motion": {"start": "phi[1]=0.1", "until": 2},
    }
    pictures = [pendulums.plot(kind, **arguments) for kind, arguments in requests.items()]
    pictures.append(pendulums.plot("spectrum"))
    pictures.append(librate.Model(PENDULUM).plot("period", over="amplitude=1..3:5"))
    pictures.append(pendulums.plot("sweep", over="k12=0..8:3", orders=[0.5]))
    assert "order 0.5" in pictures[-1] and "Campbell" in pictures[-1]
    pictures.append(pendulums.plot("sweep", over="k12=0..8:3", root_locus=True))
    pictures.append(librate.Model.open(models / "mathieu.lag").plot("floquet", map=("a=0..4:5", "q=0..2:3")))
    for picture in pictures:
        assert picture.startswith("<svg") and "viewBox" in picture and picture._repr_svg_() == picture
    page = pendulums.show()
    assert page.startswith("<!DOCTYPE html>") and "<canvas" in page and "3.132091953" in page
    assert page._repr_html_().startswith("<iframe") and "<canvas" not in page._repr_html_()
    moved = pendulums.show(over={"k12": (0, 8, 3), "k23": (1, 2, 2)})
    assert "k12" in moved and moved.count('type="range"') > page.count('type="range"')
    for over, message in (("k12=0..8:1", "not for a slider"), ({"q": (0, 1, 2)}, "`q` can't be moved")):
        with pytest.raises(librate.Error, match=message):
            pendulums.show(over=over)
    # A notebook shows a model as its page, or as its text where it has none.
    assert pendulums._repr_html_() == page._repr_html_()
    driven = librate.Model.open(models / "mathieu.lag")
    assert driven._repr_html_() == f"<pre>{html.escape(driven.text)}</pre>"


def test_layout_explanations_and_code():
    text = "coord x\nT=1/2*x'^2"
    assert librate.fmt(text) == librate.Model(text).fmt() == "coord x\nT = 1/2*x'^2\n"
    assert librate.explain("E0007").startswith("# E0007") and "E0201" in librate.explain()
    functions: dict = {}
    exec(librate.Model(PAIR).export("python"), functions)
    assert functions["stiffness"](functions["PARAMETERS"]) is not None
    assert librate.Model(PENDULUM).check() == []


def test_cell_magic():
    class Shell:
        def __init__(self):
            self.user_ns, self.magics = {}, {}

        def register_magic_function(self, function, kind, name):
            self.magics[kind, name] = function

    shell = Shell()
    librate.load_ipython_extension(shell)
    magic = shell.magics["cell", "librate"]
    shown = magic("pendulum", PENDULUM)
    assert shown.digits == ["3.132091953"] and shell.user_ns["pendulum"].coordinates == ["phi"]
    derived = magic("symbolic", PENDULUM.replace("l = 1", "l"))
    assert derived.frequencies[0]["omega_squared"] == "g/l" and shell.user_ns["symbolic"].parameters["l"] is None
    with pytest.raises(librate.Error):
        magic("falling", "coord x  T = x'^2  V = -x")
    assert shell.user_ns["falling"].coordinates == ["x"]
    with pytest.raises(librate.Error) as caught:
        magic("", "coord x  T = y")
    assert caught.value._render_traceback_() == str(caught.value).splitlines()


def test_the_stubs_list_the_native_half():
    from pathlib import Path

    stubs = Path(librate.__file__).with_name("_native.pyi").read_text()
    for name in vars(_native):
        if not name.startswith("_"):
            assert f"def {name}(" in stubs or f"class {name}:" in stubs, name
