#!/usr/bin/env python3
"""Make the reference values of Lagrange's equations, or check the ones that are kept.

    python equations.py [NAME ...]          write equations/NAME.json (all without names)
    python equations.py --check [NAME ...]  compute again and compare; exit status 1 if anything differs

The systems are those of make.py without constraints, every T and V written by hand a second time.  At some points
(q, q', q'') the left sides d/dt dL/dq_i' - dL/dq_i + dF/dq_i' are computed by central differences alone, with 200
digits and the step 1e-45: the momenta by differences of L, their rate along q + q' s + q'' s^2/2.  No formula of
mechanics but Lagrange's equation itself is used, and no computer algebra.
"""
import argparse
import json
import sys
from pathlib import Path

import many          # noqa: F401 (fills the register)
import massless      # noqa: F401
import one_and_two   # noqa: F401
import rotation      # noqa: F401
from mpmath import mpf, nstr
from numerics import STEP, decimal, unit
from register import SYSTEMS

HERE = Path(__file__).resolve().parent / "equations"
MOST = 12     # coordinates
POINTS = 3

# What the hand-written energies are divided by, where they are per unit of something.
FACTOR = {
    "bead_on_hoop": mpf("0.01") * mpf("0.2") ** 2,    # m*R^2
    "bead_on_hoop_fast": mpf("0.2") ** 2,
    "bead_on_hoop_bottom": mpf("0.2") ** 2,
    "ball_in_bowl": mpf("0.02"),    # m
}


def draws(seed):
    """Decimals between -0.5 and 0.5, the same everywhere (Lehmer's generator)."""
    state = seed
    while True:
        state = state * 48271 % 2147483647
        yield mpf(state % 1000 - 500) / 1000


def left_sides(L, F, Q, q, v, a, scale):
    n, h = len(q), STEP * scale

    def at(s):
        return ([x + s * y + s * s / 2 * z for x, y, z in zip(q, v, a)], [y + s * z for y, z in zip(v, a)])

    def by_velocity(f, i, q, v):
        step = [h * c for c in unit(n, i)]
        return (f(q, [x + d for x, d in zip(v, step)]) - f(q, [x - d for x, d in zip(v, step)])) / (2 * h)

    def force(i):
        step = [h * c for c in unit(n, i)]
        return (L([x + d for x, d in zip(q, step)], v) - L([x - d for x, d in zip(q, step)], v)) / (2 * h)

    s = STEP
    friction = [0] * n if F is None else [by_velocity(F, i, q, v) for i in range(n)]
    rates = [(by_velocity(L, i, *at(s)) - by_velocity(L, i, *at(-s))) / (2 * s) for i in range(n)]
    return [rates[i] - force(i) + friction[i] - (Q(q, v)[i] if Q else 0) for i in range(n)]


def rounded(x):
    """A decimal of eight digits next to x."""
    return mpf(nstr(x, 8))


def short(x):
    """Such a decimal in writing."""
    return decimal(x).rstrip("0").rstrip(".") if "." in decimal(x) else decimal(x)


def reference(name):
    how, error, build = SYSTEMS[name]
    coordinates, q0, system = build()
    if error or system.get("constraints") or not {"T", "lagrangian"} & set(system) or len(coordinates) > MOST:
        return None
    scale, F = mpf(system.get("scale", 1)), system.get("dissipation")
    Q = system.get("force")
    L = system.get("lagrangian") or (lambda q, v: system["T"](q, v) - system["V"](q))
    factor = mpf(FACTOR.get(name, 1))
    draw, points = draws(20 + len(name)), []
    for _ in range(POINTS):
        q = [rounded(x0 + scale * next(draw)) for x0 in map(mpf, q0)]
        v = [rounded(scale * next(draw)) for _ in q]
        a = [rounded(scale * next(draw)) for _ in q]
        values = [factor * x for x in left_sides(L, F, Q, q, v, a, scale)]
        points.append({"q": [short(x) for x in q], "v": [short(x) for x in v], "a": [short(x) for x in a],
                       "lhs": [decimal(x) for x in values]})
    return {"model": name, "coordinates": coordinates, "points": points}


def text(entry):
    body = ",\n    ".join(json.dumps(point) for point in entry["points"])
    return ("{\n  " + ",\n  ".join(f"{json.dumps(key)}: {json.dumps(entry[key], ensure_ascii=False)}"
            for key in ("model", "coordinates")) + f',\n  "points": [\n    {body}\n  ]\n}}\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare with the kept files instead of writing them")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    wrong = []
    HERE.mkdir(exist_ok=True)
    for name in arguments.names or [n for n in SYSTEMS if "/" not in n]:
        entry = reference(name)
        if entry is None:
            continue
        made, path = text(entry), HERE / f"{name}.json"
        if not arguments.check:
            path.write_text(made)
        elif not path.exists() or path.read_text() != made:
            wrong.append(name)
    for line in wrong:
        print("differs:", line)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
