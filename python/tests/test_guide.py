"""What the guide shows is what happens."""

import doctest
import re

import librate
from conftest import ROOT


def test_the_guide(monkeypatch):
    monkeypatch.chdir(ROOT)
    blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / "docs/python.md").read_text(), re.DOTALL | re.MULTILINE)
    # Within a block an empty line is one of the output.
    text = "\n".join(block.replace("\n\n", "\n<BLANKLINE>\n") for block in blocks)
    test = doctest.DocTestParser().get_doctest(text, {}, "python.md", "docs/python.md", 0)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(test)
    assert len(test.examples) > 20 and runner.failures == 0


def test_the_readme(monkeypatch):
    monkeypatch.chdir(ROOT)
    for page in ("README.md", "python/README.md"):
        [block] = re.findall(r"^```python\n(.*?)^```$", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)
        exec(block, {})


def test_the_first_page():
    assert doctest.testmod(librate).failed == 0
