#!/usr/bin/env python3
"""Steady responses of the models in models/response, with 40 digits, from matrices written down by hand: response.json.

Needs mpmath. Each entry: the model, settings, the input (or none), the range as it is given to librate (its ends only), and
for each end and output the amplitude and the phase.
"""
import json
from pathlib import Path

from mpmath import mp, mpc, mpf, matrix, lu_solve, pi, sqrt, arg

mp.dps = 60


def solved(M, D, S, f, w):
    A = matrix(len(M), len(M))
    for i in range(len(M)):
        for j in range(len(M)):
            A[i, j] = S[i][j] - w**2 * M[i][j] + mpc(0, 1) * w * D[i][j]
    return list(lu_solve(A, matrix(f)))


def written(x):
    return [mp.nstr(abs(x), 40), mp.nstr(arg(x) if x != 0 else mpf(0), 40)]


def absorber(w, c):
    m1, m2, k1 = mpf(20), mpf(1), mpf(2000)
    mu = m2 / m1
    k2 = k1 * mu / (1 + mu) ** 2
    M = [[m1, 0], [0, m2]]
    D = [[c, -c], [-c, c]]
    S = [[k1 + k2, -k2], [-k2, k2]]
    return solved(M, D, S, [1, 0], w)


def base(w):
    m, k, c, a = 2, 800, 8, mpf(1) / 100
    return [a * mpc(k, c * w) / mpc(k - m * w**2, c * w)]


def unbalance(n):
    w = 2 * pi * n
    # y + e sin(w t): the force m e w^2 sin(w t), which is -i e^(i w t).
    return [mpf(1) / 10 * w**2 * mpc(0, -1) / mpc(20000 - 50 * w**2, 100 * w)]


def pair(w):
    a = 8 - w**2
    return [a / (a**2 - 16), 4 / (a**2 - 16)]


def rotor(w):
    m, k, W, c = 3, 300, 4, mpf(6) / 10
    M = [[m, 0], [0, m]]
    D = [[c, -2 * m * W], [2 * m * W, c]]
    S = [[k - m * W**2, 0], [0, k - m * W**2]]
    return solved(M, D, S, [1, 0], w)


def slider(w):
    x = 1 / (1 + mpf(9) / 16) / mpc(50 - 2 * w**2, w)
    return [x, x * 3 / 4]


def chain(w, n):
    k, c = 100, mpf(1) / 2
    K = [[2 if i == j else -1 if abs(i - j) == 1 else 0 for j in range(n)] for i in range(n)]
    M = [[int(i == j) for j in range(n)] for i in range(n)]
    D = [[c * x for x in row] for row in K]
    S = [[k * x for x in row] for row in K]
    return solved(M, D, S, [1] + [0] * (n - 1), w)


def entry(model, over, input, values, names, settings=()):
    ends = []
    for value in values:
        ends.append({name: written(x) for name, x in zip(names, value)})
    return {"model": model, "over": over, "input": input, "settings": list(settings), "ends": ends}


mu = mpf(1) / 20
f = 1 / (1 + mu)
b, d = 1 + f**2 * (1 + mu), sqrt((1 + f**2 * (1 + mu)) ** 2 - 2 * f**2 * (2 + mu))
P, Q = (10 * sqrt((b + s * d) / (2 + mu)) for s in (-1, 1))
assert abs(abs(absorber(P, mpf(2))[0]) * 2000 - sqrt(41)) < mpf(10) ** -50

names = ["x1", "x2"]
chained = [f"x[{i}]" for i in range(1, 21)]
rational = [(mpf(3) / 10, mpf(25) / 2), (mpf(7), mpf(93) / 10)]
entries = []
for c in (2, 5):
    for a, z in rational:
        values = [absorber(a, mpf(c)), absorber(z, mpf(c))]
        over = f"omega={mp.nstr(a, 10)}..{mp.nstr(z, 10)}:2"
        entries.append(entry("damped_absorber", over, "x1", values, names, [f"c={c}"]))
entries.append(entry("shaken_base", "W=3..20:2", None, [base(mpf(3)), base(mpf(20))], ["x"]))
entries.append(entry("shaken_base", "W=sqrt(800)..100:2", None, [base(sqrt(800)), base(mpf(100))], ["x"]))
entries.append(entry("unbalance", "n=1/2..7:2", None, [unbalance(mpf(1) / 2), unbalance(mpf(7))], ["y"]))
entries.append(entry("two_masses_driven", "omega=0..3:2", "x[1]", [pair(mpf(0)), pair(mpf(3))], ["x[1]", "x[2]"]))
entries.append(entry("two_masses_driven", "omega=sqrt(8)..100:2", "x[1]", [[mpf(0), mpf(-1) / 4], pair(mpf(100))], ["x[1]", "x[2]"]))
entries.append(entry("whirling_rotor", "omega=2..14:2", "x", [rotor(mpf(2)), rotor(mpf(14))], ["x", "y"]))
entries.append(entry("slider_on_incline", "omega=5..6:2", "x", [slider(mpf(5)), slider(mpf(6))], ["x", "y"]))
entries.append(entry("driven_chain", "omega=1..30:2", "x[1]", [chain(mpf(1), 20), chain(mpf(30), 20)], chained))
Path(__file__).with_name("response.json").write_text(json.dumps(entries, indent=1) + "\n")
