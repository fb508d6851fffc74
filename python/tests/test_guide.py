"""What the guide shows is what happens."""

import doctest
import re
from pathlib import Path

import pytest

import librate
from conftest import ROOT

# Behind the guide; the last line alone is wrong.
NUMBERS = """
import decimal
import fractions
model.period(1.5), model.period(np.float32(1.5)), model.period(np.array(1.5)), model.period("pi/2")
model.motion({"x": fractions.Fraction(1, 3)}, until=decimal.Decimal(2), at=np.linspace(0, 1, 3))
model.sweep({"k": np.linspace(0, 8, 5)}), model.equilibria({"x": (-2.0, "pi")}, over={"k": [np.int64(0), 1, 2]})
librate.Model("", set={"m": [1, "1/2", 0.5], "k": np.ones((2, 2)), "l": [[1, 2], [3, 4]]})
model.floquet(map={"k": (0, 1, 2), "m": [1, 2]}), model.show(over=["k=1..2:3", {"m": np.array([1, 2])}])
librate.inertia("", mass=1, density=2.0), model.derive(limit={"k": 0})
model.period(1j)
"""


def guide() -> doctest.DocTest:
    blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / "docs/python.md").read_text(), re.DOTALL | re.MULTILINE)
    # Within a block an empty line is one of the output.
    text = "\n".join(block.replace("\n\n", "\n<BLANKLINE>\n") for block in blocks)
    return doctest.DocTestParser().get_doctest(text, {}, "python.md", "docs/python.md", 0)


def test_the_guide(monkeypatch):
    monkeypatch.chdir(ROOT)
    test = guide()
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(test)
    assert len(test.examples) > 20 and runner.failures == 0


def test_types_of_the_guide_and_of_the_package(monkeypatch, tmp_path):
    api = pytest.importorskip("mypy.api")
    package = Path(librate.__file__).parent.parent
    if package.name != "site-packages":
        monkeypatch.setenv("MYPYPATH", str(package))
    code = "".join(example.source for example in guide().examples) + NUMBERS
    (tmp_path / "guide.py").write_text(code)
    arguments = ["--ignore-missing-imports", "--allow-redefinition", "--cache-dir", str(tmp_path / "cache")]
    told, _, _ = api.run([*arguments, str(tmp_path / "guide.py")])
    error = rf'.*:{len(code.splitlines())}: error: .*"complex".*\nFound 1 error.*\n'
    assert re.fullmatch(error, told), told


def test_the_readme(monkeypatch):
    monkeypatch.chdir(ROOT)
    for page in ("README.md", "python/README.md"):
        [block] = re.findall(r"^```python\n(.*?)^```$", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)
        exec(block, {})


def test_the_version():
    assert librate.__version__ == librate.Model("coord x  T = x'^2  V = x^2").derive()["librate"]


def test_the_first_page():
    assert doctest.testmod(librate).failed == 0
