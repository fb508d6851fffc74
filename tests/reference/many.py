"""Chains, lattices, molecules and networks."""
import csv
from pathlib import Path

import mpmath as mp
from mpmath import acos, cos, mpf, pi, quad, sin, sqrt
from numerics import decimal, eigenvalues, laguerre, newton, settle, square, squares
from register import family, system

g = mpf("9.81")
DATA = Path(__file__).resolve().parents[2] / "models" / "data"


def kinetic(masses):
    return lambda q, v: sum(m * a * a for m, a in zip(masses, v)) / 2


def springs(k, *, left=False, right=False, ring=False):
    """The energy of equal springs along a row, tied to a wall on the left or right, or closed to a ring."""
    def V(q):
        row = ([mpf(0)] if left else []) + list(q) + ([mpf(0)] if right else []) + ([q[0]] if ring else [])
        return sum((b - a) ** 2 for a, b in zip(row, row[1:])) * k / 2
    return V


def mirror(n, first="even"):
    other = {"even": "odd", "odd": "even"}[first]
    return [first if j % 2 == 0 else other for j in range(n)]


def between_walls(n, k, m):
    return [4 * k / m * sin(j * pi / (2 * (n + 1))) ** 2 for j in range(1, n + 1)]


def one_end_fixed(n, k, m):
    return [4 * k / m * sin((2 * j - 1) * pi / (2 * (2 * n + 1))) ** 2 for j in range(1, n + 1)]


@system("closed form")
def chain_walls():
    n, k, m = 100, mpf(1), mpf(1)
    return family("x", n), [0] * n, dict(
        T=kinetic([m] * n), V=springs(k, left=True, right=True), closed=between_walls(n, k, m), symmetry=mirror(n))


@system("closed form")
def chain_free():
    n, k, m = 12, mpf(3), mpf(2)
    return family("x", n), [0] * n, dict(
        T=kinetic([m] * n), V=springs(k), zeros=1, symmetry=mirror(n),
        closed=[4 * k / m * sin(j * pi / (2 * n)) ** 2 for j in range(n)])


@system("closed form")
def chain_fixed_free():
    n, k, m = 15, mpf(1), mpf("0.5")
    return family("x", n), [0] * n, dict(T=kinetic([m] * n), V=springs(k, left=True), closed=one_end_fixed(n, k, m))


@system("closed form")
def ring():
    n, k, m = 12, mpf(1), mpf(1)
    return family("x", n), [0] * n, dict(
        T=kinetic([m] * n), V=springs(k, ring=True), zeros=1,
        closed=[4 * k / m * sin(j * pi / n) ** 2 for j in range(n)])


@system("closed form")
def diatomic_ring():
    n, k, m1, m2 = 6, mpf(1), mpf(1), mpf(3)
    s = 1 / m1 + 1 / m2
    closed = []
    for j in range(n):
        d = sqrt(s**2 - 4 * sin(pi * j / n) ** 2 / (m1 * m2))
        closed += [k * (s + d), k * (s - d) if j else 0]
    along = springs(k, ring=True)
    V = lambda q: along([q[i // 2 + (n if i % 2 else 0)] for i in range(2 * n)])
    return family("x", n) + family("y", n), [0] * (2 * n), dict(
        T=kinetic([m1] * n + [m2] * n), V=V, zeros=1, closed=closed)


@system("closed form")
def lc_ladder():
    n, L, C = 8, mpf("2e-3"), mpf("5e-8")
    return family("Q", n), [0] * n, dict(
        T=kinetic([L] * n), V=springs(1 / C, left=True), closed=one_end_fixed(n, 1 / C, L))


@system("closed form")
def beaded_string():
    n, S, m, a = 5, mpf(12), mpf("0.002"), mpf("0.1")

    def V(q):
        row = [mpf(0)] + list(q) + [mpf(0)]
        return S * sum(sqrt(a**2 + (y - x) ** 2) - a for x, y in zip(row, row[1:]))

    return family("y", n), [0] * n, dict(
        T=kinetic([m] * n), V=V, closed=between_walls(n, S / a, m), symmetry=mirror(n))


@system("closed form")
def beam_simply_supported():
    n, k, m = 9, mpf(20), mpf("0.5")

    def V(q):
        row = [mpf(0)] + list(q) + [mpf(0)]
        return k / 2 * sum((row[i - 1] - 2 * row[i] + row[i + 1]) ** 2 for i in range(1, n + 1))

    return family("y", n), [0] * n, dict(
        T=kinetic([m] * n), V=V, symmetry=mirror(n),
        closed=[16 * k / m * sin(j * pi / (2 * (n + 1))) ** 4 for j in range(1, n + 1)])


@system("integrals of the shapes by quadrature")
def cantilever_ritz():
    n, L, rho, EI = 3, mpf("1.2"), mpf("2.5"), mpf(80)
    f = [lambda x, j=j: (x / L) ** (j + 1) for j in range(1, n + 1)]
    bent = [lambda x, j=j: j * (j + 1) * (x / L) ** (j - 1) / L**2 for j in range(1, n + 1)]
    M, K = ([[quad(lambda x: a(x) * b(x), [0, L]) for a in own] for b in own] for own in (f, bent))
    form = lambda A, q: sum(A[i][j] * q[i] * q[j] for i in range(n) for j in range(n)) / 2
    return family("q", n), [0] * n, dict(T=lambda q, v: rho * form(M, v), V=lambda q: EI * form(K, q))


@system("closed form")
def fput_chain():
    n, k, m, beta = 32, mpf(1), mpf(1), mpf("0.3")

    def V(q):
        row = [mpf(0)] + list(q) + [mpf(0)]
        return sum(k / 2 * (b - a) ** 2 + beta / 4 * (b - a) ** 4 for a, b in zip(row, row[1:]))

    return family("x", n), [0] * n, dict(
        T=kinetic([m] * n), V=V, closed=between_walls(n, k, m), symmetry=mirror(n))


@system("zeros of the Laguerre polynomial L_10, from its coefficients")
def n_pendulum():
    n = 10
    T = lambda q, v: sum(
        (n - max(i, j)) * v[i] * v[j] * cos(q[i] - q[j]) for i in range(n) for j in range(n)) / 2
    V = lambda q: -g * sum((n - i) * cos(q[i]) for i in range(n))
    return family("theta", n), [0] * n, dict(T=T, V=V, closed=[g * z for z in laguerre(n)])


@system("zeros of the Laguerre polynomial L_8, from its coefficients")
def hanging_chain():
    n, a, m = 8, mpf("0.125"), mpf("0.01")

    def V(q):
        row = [mpf(0)] + list(q)
        return sum((n - i) * m * g / (2 * a) * (row[i + 1] - row[i]) ** 2 for i in range(n))

    return family("x", n), [0] * n, dict(T=kinetic([m] * n), V=V, closed=[g / a * z for z in laguerre(n)])


@system("closed form")
def square_lattice():
    n, k, m, a = 6, mpf(1), mpf(1), mpf("0.8")

    def V(q):
        def place(i, j):
            if 1 <= i <= n and 1 <= j <= n:
                at = (i - 1) * n + j - 1
                return i + q[at], j + q[n * n + at]
            return mpf(i), mpf(j)
        bonds = [((i, j), (i + 1, j)) for i in range(n + 1) for j in range(1, n + 1)]
        bonds += [((j, i), (j, i + 1)) for i in range(n + 1) for j in range(1, n + 1)]
        return k / 2 * sum((distance(place(*p), place(*r)) - a) ** 2 for p, r in bonds)

    s = [sin(j * pi / (2 * (n + 1))) ** 2 for j in range(1, n + 1)]
    closed = [4 * k / m * (x + (1 - a) * y) for x in s for y in s] * 2
    return family("u", n, n) + family("v", n, n), [0] * (2 * n * n), dict(
        T=kinetic([m] * (2 * n * n)), V=V, closed=closed)


@system("equilibrium by Newton's method from the guess; omega = 1 and sqrt(3) also in closed form")
def ion_chain():
    n = 5
    V = lambda q: sum(x * x for x in q) / 2 + sum(1 / (q[j] - q[i]) for j in range(n) for i in range(j))
    q0 = newton(V, [i - 2 for i in range(n)])
    assert q0 == sorted(q0)
    values = squares(q0, kinetic([1] * n), V, q0)
    assert abs(values[0] - 1) < mpf(10) ** -70 and abs(values[1] - 3) < mpf(10) ** -70
    return family("x", n), q0, dict(T=kinetic([1] * n), V=V)


# Molecules and networks.  Coordinates are all x, y, z of the first point, then of the second, …

def points(q, dim=3):
    return [q[i:i + dim] for i in range(0, len(q), dim)]


def distance(p, r):
    return sqrt(square([a - b for a, b in zip(p, r)]))


def repeat(masses, dim=3):
    return [mpf(m) for m in masses for _ in range(dim)]


def bond_energy(bonds, dim=3):
    """bonds: (i, j, k, rest length), counted from 0."""
    def V(q):
        p = points(q, dim)
        return sum(k * (distance(p[i], p[j]) - d) ** 2 for i, j, k, d in bonds) / 2
    return V


@system("closed form")
def dumbbell():
    k, d = mpf(5), 2
    return family("r", 2, 2), [0, 0, d, 0], dict(
        T=kinetic(repeat([1, 4], 2)), V=bond_energy([(0, 1, k, d)], 2), zeros=3, closed=[0] * 3 + [k * mpf("1.25")])


@system("closed form")
def tetrahedron():
    corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    bonds = [(i, j, 1, sqrt(8)) for j in range(4) for i in range(j)]
    return family("r", 4, 3), sum(corners, []), dict(
        T=kinetic(repeat([1] * 4)), V=bond_energy(bonds), zeros=6, closed=[0] * 6 + [1] * 2 + [2] * 3 + [4])


U, ANGSTROM = mpf("1.66053906892e-27"), mpf("1e-10")


@system("closed form; u of CODATA 2022")
def co2():
    mO, mC, d, k1, k2 = mpf("15.999") * U, mpf("12.011") * U, mpf("1.16") * ANGSTROM, mpf(1420), mpf(57)
    stretch = bond_energy([(0, 1, k1, d), (1, 2, k1, d)])

    def V(q):
        O1, C, O2 = points(q)
        a, b = distance(O1, C), distance(O2, C)
        cosine = sum((x - z) * (y - z) for x, y, z in zip(O1, O2, C)) / (a * b)
        return stretch(q) + k2 * d**2 * (1 + cosine)       # |e1 + e2|^2 = 2 + 2*cos

    mu = 2 * mO + mC
    closed = [0] * 5 + [k1 / mO, k1 * mu / (mO * mC)] + [2 * k2 * mu / (mO * mC)] * 2
    return family("r", 3, 3), [0, 0, -d, 0, 0, 0, 0, 0, d], dict(
        T=kinetic(repeat([mO, mC, mO])), V=V, zeros=5, scale=ANGSTROM, closed=closed)


@system("closed form; u of CODATA 2022")
def water():
    mH, mO, d, k1, k2 = mpf("1.008") * U, mpf("15.999") * U, mpf("0.958") * ANGSTROM, mpf(776), mpf(69)
    alpha = mpf("52.26") * pi / 180
    stretch = bond_energy([(0, 1, k1, d), (1, 2, k1, d)])

    def V(q):
        H1, O, H2 = points(q)
        cosine = sum((x - z) * (y - z) for x, y, z in zip(H1, H2, O)) / (distance(H1, O) * distance(H2, O))
        return stretch(q) + k2 / 2 * d**2 * (acos(cosine) - 2 * alpha) ** 2

    s, c = sin(alpha), cos(alpha)
    plus = k1 / mH * (1 + 2 * mH / mO * c**2) + 2 * k2 / mH * (1 + 2 * mH / mO * s**2)
    times = 2 * (2 * mH + mO) * k1 * k2 / (mO * mH**2)
    root = sqrt(plus**2 - 4 * times)
    closed = [0] * 6 + [k1 / mH * (1 + 2 * mH / mO * s**2), (plus - root) / 2, (plus + root) / 2]
    return family("r", 3, 3), [-d * s, d * c, 0, 0, 0, 0, d * s, d * c, 0], dict(
        T=kinetic(repeat([mH, mO, mH])), V=V, zeros=6, scale=ANGSTROM, closed=closed)


def minus(p, r):
    return [a - b for a, b in zip(p, r)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def volume(a, b, c):
    """The determinant of three vectors."""
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]))


def valence(central, outer, k1, k2, d, angle):
    """Springs along the bonds of one atom and one for each angle between two of them."""
    def V(q):
        p = points(q)
        e = [minus(p[i], p[central]) for i in outer]
        length = [sqrt(square(x)) for x in e]
        stretch = sum(k1 * (s - d) ** 2 for s in length) / 2
        pairs = [(i, j) for j in range(len(e)) for i in range(j)]
        return stretch + sum(k2 / 2 * d**2 * (acos(dot(e[i], e[j]) / (length[i] * length[j])) - angle) ** 2 for i, j in pairs)
    return V


def two(total, product):
    """The two numbers with this sum and product."""
    root = sqrt(total**2 - 4 * product)
    return [(total - root) / 2, (total + root) / 2]


@system("closed form; u of CODATA 2022")
def ammonia():
    mN, mH, d, k1, k2 = mpf("14.007") * U, mpf("1.008") * U, mpf("1.012") * ANGSTROM, mpf(640), mpf(150)
    beta = mpf("67.87") * pi / 180
    s, c, x = sin(beta), cos(beta), mH / mN
    place = [[0, 0, 0]] + [[d * s * cos(2 * pi * i / 3), d * s * sin(2 * pi * i / 3), -d * c] for i in (2, 3, 4)]
    bonds = [(0, i, k1, d) for i in (1, 2, 3)] + [(i, j, k2, sqrt(mpf(3)) * d * s) for i, j in ((1, 2), (1, 3), (2, 3))]
    a1 = two(k1 / mH * (1 + 3 * x * c**2) + 3 * k2 / mH, 3 * k1 * k2 / mH**2 * (1 + 3 * x) * c**2)
    e = two(k1 / mH * (1 + 3 * x * s**2 / 2) + 3 * k2 / (2 * mH), 3 * k1 * k2 / (2 * mH**2) * (1 - s**2 / 2 + 3 * x * s**2 / 2))
    return family("r", 4, 3), sum(place, []), dict(
        T=kinetic(repeat([mN, mH, mH, mH])), V=bond_energy(bonds), zeros=6, scale=ANGSTROM, closed=[0] * 6 + a1 + e * 2)


@system("closed form; u of CODATA 2022")
def methane():
    mC, mH, d, k1, k2 = mpf("12.011") * U, mpf("1.008") * U, mpf("1.087") * ANGSTROM, mpf(500), mpf(46)
    corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    place = [[0, 0, 0]] + [[d / sqrt(mpf(3)) * x for x in p] for p in corners]
    t2 = two(k1 / mH * (1 + 4 * mH / (3 * mC)) + 2 * k2 / mH * (1 + 8 * mH / (3 * mC)), 2 * k1 * k2 / mH**2 * (1 + 4 * mH / mC))
    closed = [0] * 6 + [k1 / mH] + [3 * k2 / mH] * 2 + t2 * 3
    return family("r", 5, 3), sum(place, []), dict(
        T=kinetic(repeat([mC, mH, mH, mH, mH])), V=valence(0, [1, 2, 3, 4], k1, k2, d, acos(-mpf(1) / 3)), zeros=6,
        scale=ANGSTROM, closed=closed)


@system("differences of T and V; u of CODATA 2022")
def ethylene():
    mC, mH, a, d = mpf("12.011") * U, mpf("1.008") * U, mpf("1.339") * ANGSTROM, mpf("1.087") * ANGSTROM
    alpha = mpf("121.3") * pi / 180
    up, out = d * sin(alpha), a / 2 - d * cos(alpha)
    C = [[0, 0, -a / 2], [0, 0, a / 2]]
    H = [[0, -up, -out], [0, up, -out], [0, -up, out], [0, up, out]]
    place = C + H
    pairs = [(0, 1, 900)] + [(i // 2, 2 + i, 500) for i in range(4)] + [(1 - i // 2, 2 + i, 40) for i in range(4)]
    pairs += [(2, 3, 20), (4, 5, 20)]
    plane = bond_energy([(i, j, mpf(k), distance(place[i], place[j])) for i, j, k in pairs])

    def V(q):
        c1, c2, h1, h2, h3, h4 = points(q)
        e = minus(c2, c1)
        wag = volume(minus(h1, c1), minus(h2, c1), e) ** 2 + volume(minus(h3, c2), minus(h4, c2), e) ** 2
        twist = sum(volume(minus(i, c1), minus(j, c2), e) ** 2 for i in (h1, h2) for j in (h3, h4))
        return plane(q) + (6 * wag + 4 * twist) / (a * d) ** 2

    return family("c", 2, 3) + family("h", 4, 3), sum(place, []), dict(
        T=kinetic(repeat([mC] * 2 + [mH] * 4)), V=V, zeros=6, scale=ANGSTROM)


@system("differences of T and V; u of CODATA 2022")
def benzene():
    mC, mH, a, d = mpf("12.011") * U, mpf("1.008") * U, mpf("1.397") * ANGSTROM, mpf("1.084") * ANGSTROM
    around = [(cos(pi * i / 3), sin(pi * i / 3)) for i in range(1, 7)]
    place = [[r * x, r * y, 0] for r in (a, a + d) for x, y in around]
    pairs = [(i, (i + 1) % 6, 650) for i in range(6)] + [(i, (i + 2) % 6, 70) for i in range(6)]
    pairs += [(i, 6 + i, 510) for i in range(6)] + [((i + s) % 6, 6 + i, 45) for i in range(6) for s in (1, 5)]
    plane = bond_energy([(i, j, mpf(k), distance(place[i], place[j])) for i, j, k in pairs])

    def V(q):
        p = points(q)
        c, h = p[:6], p[6:]
        e = [minus(c[(i + 1) % 6], c[i]) for i in range(6)]
        wag = sum(volume(e[i], e[i - 1], minus(h[i], c[i])) ** 2 for i in range(6))
        twist = sum(volume(e[i], e[i - 1], e[(i + 1) % 6]) ** 2 for i in range(6))
        return plane(q) + (6 * wag + 5 * twist) / a**4

    return family("c", 6, 3) + family("h", 6, 3), sum(place, []), dict(
        T=kinetic(repeat([mC] * 6 + [mH] * 6)), V=V, zeros=6, scale=ANGSTROM)


def rows(name):
    with open(DATA / name, newline="") as file:
        return list(csv.DictReader(file))


@system("differences of T and V; the tables are read, nothing else")
def body_from_table():
    body = rows("body_points.csv")
    place = [[mpf(p[c]) for c in "xyz"] for p in body]
    bonds = []
    for b in rows("body_bonds.csv"):
        i, j = int(b["i"]) - 1, int(b["j"]) - 1
        bonds.append((i, j, mpf(b["k"]), distance(place[i], place[j])))
    return family("r", len(body), 3), sum(place, []), dict(
        T=kinetic(repeat([p["mass"] for p in body])), V=bond_energy(bonds), zeros=6)


@system("K summed as k*e*e^T over the unit vectors e of the bonds (unstressed, so nothing is left out), eigenvalues "
        "with mpmath at 80 digits; the published ones agree to the five digits given there and their own noise of 1e-6")
def ubiquitin():
    place = [[mpf(p[c]) for c in "xyz"] for p in rows("ubiquitin_atoms.csv")]
    n = 3 * len(place)
    K, M = mp.matrix(n, n), mp.eye(n)
    for j in range(len(place)):
        for i in range(j):
            e = [a - b for a, b in zip(place[i], place[j])]
            if square(e) > 225:
                continue
            for a in range(3):
                for b in range(3):
                    block = e[a] * e[b] / square(e)
                    for s, t, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                        K[3 * s + a, 3 * t + b] += sign * block
    values = settle(eigenvalues(M, K), 6, None)
    published = [mpf(r["eigenvalue"]) for r in csv.DictReader(PUBLISHED.splitlines())]
    for z, p in zip(values, published):
        fifth = mpf(10) ** (mp.floor(mp.log10(abs(p))) - 4)
        assert abs(z - p) < fifth / 2 + mpf("1e-6"), (z, p)     # the published zeros show the noise
    return family("r", len(place), 3), sum(place, []), dict(
        values=values, extra={"published_eigenvalues": [decimal(p, 5) for p in published]})


# The 36 lowest eigenvalues as kept in ProDy's tests (MIT licence): five digits, the first six are zero.
PUBLISHED = """index,eigenvalue
1,-0.17645E-06
2,-0.15107E-06
3,-0.21952E-07
4,0.14747E-06
5,0.21549E-06
6,0.24566E-06
7,0.33933E-01
8,0.15243E+00
9,0.35979E+00
10,0.71644E+00
11,0.15448E+01
12,0.16734E+01
13,0.17472E+01
14,0.21088E+01
15,0.26287E+01
16,0.27101E+01
17,0.34322E+01
18,0.36169E+01
19,0.38034E+01
20,0.40122E+01
21,0.41684E+01
22,0.45047E+01
23,0.46214E+01
24,0.47206E+01
25,0.48334E+01
26,0.50606E+01
27,0.53962E+01
28,0.57940E+01
29,0.59457E+01
30,0.60696E+01
31,0.62235E+01
32,0.63581E+01
33,0.63971E+01
34,0.65122E+01
35,0.66829E+01
36,0.67006E+01"""
