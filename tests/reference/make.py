#!/usr/bin/env python3
"""Make the reference frequencies of every model, or check the ones that are kept.

    python make.py [NAME ...]            write NAME.json (all without names)
    python make.py --check [NAME ...]    compute again and compare; exit status 1 if anything differs

Needs mpmath; gmpy2 makes it faster.  The model files are not read: every T and V is written by hand once more
in one_and_two.py, many.py, massless.py, hard.py and rotation.py, with the parameter values repeated there.  See README.md.
"""
import argparse
import json
import sys
import time
from pathlib import Path

import hard          # noqa: F401 (fills the register)
import many          # noqa: F401
import massless      # noqa: F401
import one_and_two   # noqa: F401
import rotation      # noqa: F401
from mpmath import mpf
from numerics import decimal, modes, squares, stability
from register import SYSTEMS

HERE = Path(__file__).resolve().parent
MODELS = HERE.parents[1] / "models"
CLOSED = "closed form at 200 digits, which agrees to 50 digits with eigenvalues from differences of a hand-written T and V"


def reference(name):
    how, error, build = SYSTEMS[name]
    coordinates, q0, system = build()
    if how.startswith("closed form"):
        how = CLOSED + how.removeprefix("closed form")
    elif how.startswith("zeros"):
        how += "; they agree to 50 digits with eigenvalues from differences of a hand-written T and V"
    elif how.startswith(("equilibrium", "differences")):
        how = how.removeprefix("differences of T and V; ").removeprefix("differences of T and V")
        how += ("; " if how else "") + "M and K from differences of a hand-written T and V, eigenvalues with mpmath at 80 digits"
    entry = {"model": name.rpartition("/")[2], "how": how, "coordinates": coordinates}
    if error:
        return entry | {"error": error}
    symmetry, extra = system.pop("symmetry", None), system.pop("extra", {})
    q0 = [mpf(x) for x in q0]
    if "entries" in system:    # exponents, not squares of frequencies
        return entry | {"equilibrium": [decimal(x) for x in q0]} | system["entries"]
    values = system["values"] if "values" in system else squares(coordinates, q0=q0, **system)
    entry |= {"equilibrium": [decimal(x) for x in q0], "stability": stability(values), "modes": modes(values)}
    if symmetry:
        assert len(symmetry) == len(values)
        entry["symmetry"] = symmetry
    return entry | extra


def text(entry):
    """JSON with one mode to a line."""
    lines = []
    for key, value in entry.items():
        if key == "modes":
            body = ",\n    ".join(json.dumps(m) for m in value)
            lines.append(f'"modes": [\n    {body}\n  ]')
        else:
            lines.append(f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}")
    return "{\n  " + ",\n  ".join(lines) + "\n}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare with the kept files instead of writing them")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    names = arguments.names or list(SYSTEMS)
    if unknown := [n for n in names if n not in SYSTEMS]:
        parser.error("no such system: " + ", ".join(unknown))
    wrong = []
    if not arguments.names:
        models = {str(path.relative_to(MODELS).with_suffix("")) for path in MODELS.rglob("*.lag")}
        wrong += [f"{n}: a model without a reference" for n in sorted(models - set(SYSTEMS))]
        wrong += [f"{n}: a reference without a model" for n in sorted(set(SYSTEMS) - models)]
    for name in names:
        start = time.monotonic()
        made, path = text(reference(name)), HERE / f"{name}.json"
        if not arguments.check:
            path.parent.mkdir(exist_ok=True)
            path.write_text(made, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != made:
            wrong.append(f"{name}: differs")
        print(f"{name} {time.monotonic() - start:.1f} s", flush=True)
    print("\n".join(wrong), file=sys.stderr, end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
