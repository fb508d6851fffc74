"""The tutorial is run: what its cells show is what happens. LIBRATE_WRITE=1 writes the outputs anew."""

import ast
import contextlib
import io
import json
import os

from conftest import ROOT

NOTEBOOK = ROOT / "docs/tutorial.ipynb"
RICH = {"_repr_svg_": "image/svg+xml", "_repr_html_": "text/html", "_repr_latex_": "text/latex"}
# Pages and pictures that are larger are not kept in the file.
MOST = 100_000


def shown(value):
    """A value as a notebook shows it."""
    data = {"text/plain": lines("picture" if hasattr(value, "_repr_svg_") else repr(value))}
    for method, kind in RICH.items():
        rich = getattr(value, method, lambda: None)()
        if rich and len(rich) < MOST:
            data[kind] = lines(rich)
    return {"output_type": "execute_result", "metadata": {}, "data": data}


def lines(text):
    return text.splitlines(keepends=True)


def run(source, names):
    """The outputs of a cell, without a notebook's own machinery."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    outputs, printed = [], io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": lines(printed.getvalue())})
    if value is not None:
        outputs.append(shown(value))
    return outputs


def test_the_tutorial(monkeypatch):
    monkeypatch.chdir(ROOT)
    notebook = json.loads(NOTEBOOK.read_text())
    names: dict = {}
    count = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        count += 1
        outputs = run("".join(cell["source"]), names)
        for output in outputs:
            if output["output_type"] == "execute_result":
                output["execution_count"] = count
        if os.environ.get("LIBRATE_WRITE"):
            cell.update(outputs=outputs, execution_count=count)
        else:
            assert cell["outputs"] == outputs, cell["source"]
    assert count >= 12
    if os.environ.get("LIBRATE_WRITE"):
        NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")
