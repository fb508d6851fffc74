#!/usr/bin/env python3
"""Make the reference changes of frequencies with the amplitude, or check the ones that are kept.

    python amplitudes.py            write amplitudes.json
    python amplitudes.py --check    compute again and compare; exit status 1 if anything differs

Needs mpmath.  Nothing here knows Librate, and nothing is expanded: for each mode the periodic motion itself is found, with an
amplitude of 1e-25 and 260 digits, as q = c0 + c1 cos u + c2 cos 2u + c3 cos 3u, u = w t.  The mean Lagrangian over 16 phases is
made stationary in all coefficients but one, which is the amplitude (Newton's method with the linear part for its matrix, residuals
from central differences of a hand-written T and V).  What the harmonics above the third and the next power of the amplitude
change is a factor 1e-50, so that (w/w0 - 1)/A^2 has 40 digits.  Modes with a whole ratio of frequencies that matters have none: null.
"""
import json
import sys
from pathlib import Path

from mpmath import cholesky, cos, eigsy, inverse, lu_solve, matrix, mp, mpf, nstr, pi, sin, sqrt

HERE = Path(__file__).resolve().parent
mp.dps = 260
STEP = mpf(10) ** -70
AMPLITUDE = mpf(10) ** -25
PHASES = 16
HARMONICS = 4
g = mpf("9.81")


def pendulum():
    return [0], lambda q, v: 4 * v[0] ** 2 / 2, lambda q: -2 * g * cos(q[0])


def quartic_pair():
    return ([0, 0], lambda q, v: (v[0] ** 2 + v[1] ** 2) / 2,
            lambda q: q[0] ** 2 / 2 + 3 * q[1] ** 2 / 2 + q[0] ** 4 / 4 + q[1] ** 4 / 2 + q[0] ** 2 * q[1] ** 2 / 4)


def one_to_three():
    return ([0, 0], lambda q, v: (v[0] ** 2 + v[1] ** 2) / 2,
            lambda q: q[0] ** 2 / 2 + 9 * q[1] ** 2 / 2 + q[0] ** 3 * q[1] / 10 + q[0] ** 4 / 4)


def double_pendulum():
    l1, l2, m1, m2 = mpf(1), mpf("0.75"), 2, 1
    return ([0, 0],
            lambda q, v: (m1 + m2) * l1**2 * v[0] ** 2 / 2 + m2 * l2**2 * v[1] ** 2 / 2
            + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]),
            lambda q: -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]))


def spring(m, k, r0):
    """The spring's length r0 under the weight."""
    return ([r0, 0], lambda q, v: m * (v[0] ** 2 + q[0] ** 2 * v[1] ** 2) / 2,
            lambda q: k * (q[0] - r0 + m * g / k) ** 2 / 2 - m * g * q[0] * cos(q[1]))


def spring_pendulum():
    return spring(mpf(1), mpf(40), mpf("0.5") + g / 40)


def elastic_pendulum():
    m, l = mpf("0.5"), mpf("1.2")
    return spring(m, 4 * m * g / l, l)


def cubic_chain():
    def potential(q):
        u = [0, *q, 0]
        s = [b - a for a, b in zip(u, u[1:])]
        return sum(x**2 / 2 + x**3 / 12 + x**4 / 20 for x in s)
    return [0] * 4, lambda q, v: (2 * v[0] ** 2 + v[1] ** 2 + v[2] ** 2 + v[3] ** 2) / 2, potential


def bead():
    def height(x):
        return x**2 / 2 + x**3 / 5
    return ([0, 0], lambda q, v: (1 + (q[0] + 3 * q[0] ** 2 / 5) ** 2) * v[0] ** 2 / 2 + v[1] ** 2,
            lambda q: 2 * height(q[0]) + 3 * (q[1] - q[0]) ** 2 / 2)


# The file, the system, and the modes (by rising frequency) that have no such change.
CASES = [
    ("models/amplitude/pendulum.lag", pendulum, []),
    ("models/amplitude/quartic_pair.lag", quartic_pair, []),
    ("models/amplitude/one_to_three.lag", one_to_three, [0]),
    ("models/amplitude/double_pendulum.lag", double_pendulum, []),
    ("models/amplitude/spring_pendulum.lag", spring_pendulum, []),
    ("models/elastic_pendulum.lag", elastic_pendulum, [0]),
    ("models/amplitude/cubic_chain.lag", cubic_chain, []),
    ("models/amplitude/bead.lag", bead, []),
]


def slopes(f, x):
    """Central differences."""
    out = []
    for i in range(len(x)):
        ends = [f([y + (sign * STEP if j == i else 0) for j, y in enumerate(x)]) for sign in (1, -1)]
        out.append((ends[0] - ends[1]) / (2 * STEP))
    return out


def second(f, n, at):
    """The matrix of second derivatives: differences of differences."""
    out = matrix(n, n)
    for i in range(n):
        for j in range(n):
            total = 0
            for a in (1, -1):
                for b in (1, -1):
                    x = list(at)
                    x[i] += a * STEP
                    x[j] += b * STEP
                    total += a * b * f(x)
            out[i, j] = total / (4 * STEP**2)
    return out


def modes(M, K):
    """Squares of frequencies, ascending, and shapes."""
    inner = inverse(cholesky(M))
    values, vectors = eigsy(inner * K * inner.T)
    shapes = inner.T * vectors
    return [(values[k], [shapes[i, k] for i in range(M.rows)]) for k in sorted(range(M.rows), key=lambda k: values[k])]


def change(q0, T, V, M, K, square, shape):
    n = len(q0)
    size = max(abs(x) for x in shape)
    own = next(i for i in range(n) if abs(shape[i]) >= size * (1 - mpf(10) ** -6))
    c = [[mpf(0)] * n for _ in range(HARMONICS)]
    c[1] = [AMPLITUDE * x / shape[own] for x in shape]
    start = square
    phases = [2 * pi * j / PHASES for j in range(PHASES)]
    for _ in range(20):
        omega = sqrt(square)
        rest = [[mpf(0)] * n for _ in range(HARMONICS)]
        for u in phases:
            cosines = [cos(h * u) for h in range(HARMONICS)]
            sines = [h * omega * sin(h * u) for h in range(HARMONICS)]
            q = [q0[i] + sum(c[h][i] * cosines[h] for h in range(HARMONICS)) for i in range(n)]
            v = [-sum(c[h][i] * sines[h] for h in range(HARMONICS)) for i in range(n)]
            forces = slopes(lambda x: T(x, v) - V(x), q)
            momenta = slopes(lambda x: T(q, x), v)
            for h in range(HARMONICS):
                for i in range(n):
                    part = forces[i] * cosines[h] - momenta[i] * sines[h]
                    rest[h][i] += part * (1 if h == 0 else 2) / PHASES
        moved = mpf(0)
        for h in range(HARMONICS):
            linear = K - h * h * square * M
            if h == 1:
                # The amplitude stays; the square of the frequency takes its place.
                inertia = M * matrix(c[1])
                for i in range(n):
                    linear[i, own] = -inertia[i] / AMPLITUDE
            step = lu_solve(linear, matrix(rest[h]))
            for i in range(n):
                if h == 1 and i == own:
                    square += step[i] / AMPLITUDE
                else:
                    c[h][i] += step[i]
                moved = max(moved, abs(step[i]))
        if moved < AMPLITUDE ** 3 * mpf(10) ** -45:
            break
    else:
        raise ArithmeticError("no convergence")
    return (sqrt(square / start) - 1) / AMPLITUDE**2


def reference(file, build, without):
    q0, T, V = build()
    q0 = [mpf(x) for x in q0]
    n = len(q0)
    K = second(V, n, q0)
    M = second(lambda v: T(q0, v), n, [mpf(0)] * n)
    found = []
    for k, (square, shape) in enumerate(modes(M, K)):
        value = None if k in without else change(q0, T, V, M, K, square, shape)
        if value is not None and abs(value) < mpf(10) ** -45:
            value = mpf(0)
        found.append(None if value is None else nstr(value, 40, min_fixed=-100, max_fixed=100))
    return {"file": file, "changes": found}


def main():
    made = json.dumps([reference(*case) for case in CASES], indent=1) + "\n"
    path = HERE / "amplitudes.json"
    if "--check" in sys.argv[1:]:
        if path.read_text(encoding="utf-8") != made:
            sys.exit("amplitudes.json differs")
    else:
        path.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()
