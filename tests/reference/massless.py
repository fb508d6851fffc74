"""Models with coordinates that have no inertia.

Nothing is condensed here: det(s^2*M + s*(G + C) + K + N) is a polynomial in s of the degree that the massless coordinates
leave. Its coefficients are interpolated from determinants with 200 digits, and its roots are the exponents.
"""
import mpmath as mp
from mpmath import mpf, sqrt
from exponents import ZERO, agree, all_exponents, entry, linearized, nullity, order, pair, squares
from register import family, system

HOW = ("exponents by formula at 200 digits, which agree to 60 digits with the roots of det(s^2 M + s D + S), interpolated; the matrices "
       "from differences of a hand-written Lagrangian")


def roots(M, D, S):
    """The zeros of the polynomial det(s^2 M + s D + S), in units of a typical rate."""
    n = M.rows
    size = lambda A: max(abs(x) for x in A)
    unit = sqrt(size(S) / size(M))
    points = [mp.expjpi(mpf(2 * k) / (2 * n + 1)) for k in range(2 * n + 1)]
    values = [mp.det((s * unit) ** 2 * M + s * unit * D + S) for s in points]
    # The discrete Fourier transform of the values has the coefficients.
    count = len(points)
    coefficients = [sum(v * p ** -k for v, p in zip(values, points)) / count for k in range(count)]
    largest = max(abs(c) for c in coefficients)
    while abs(coefficients[-1]) < mpf(10) ** -80 * largest:
        coefficients.pop()
    zeros = 0
    while abs(coefficients[0]) < mpf(10) ** -80 * largest:
        zeros += 1
        coefficients.pop(0)
    found = mp.polyroots([mp.re(c) for c in reversed(coefficients)], maxsteps=500, extraprec=600)
    return [mpf(0)] * zeros + [z * unit for z in found]


def massless(L, closed, n, F=None, zero_multiplicity=None):
    """As `solved` of exponents.py, about q = 0."""
    q0 = [mpf(0)] * n
    M, D, S = linearized(L, q0, q0, F)
    zeros = sum(mode == ZERO for mode in closed)
    if F is None:
        zero_multiplicity = 2 * zeros
    else:
        assert nullity(S) == zeros
        zero_multiplicity = zeros if zero_multiplicity is None else zero_multiplicity
    agree(roots(M, D, S), all_exponents(closed, F is not None, zero_multiplicity))
    closed = sorted(closed, key=order)
    assert all(growth <= 0 for growth, _ in closed)
    found = {"stability": "neutral" if zeros else "stable", "modes": [entry(*mode) for mode in closed]}
    return {"entries": found, "lagrangian": L, "dissipation": F}


def beam(EI, h, w, a, v, b):
    """The energy of a beam from deflection w and slope a to v and b."""
    d = v - w
    return EI / h**3 / 2 * (12 * d**2 - 12 * h * d * (a + b) + 4 * h**2 * (a * a + a * b + b * b))


@system(HOW)
def springs_in_series():
    m, k1, k2 = map(mpf, ("1.5", 20, 30))
    L = lambda q, v: m / 2 * v[0] ** 2 - k1 / 2 * q[1] ** 2 - k2 / 2 * (q[0] - q[1]) ** 2
    return family("x", "y"), [0, 0], massless(L, squares(1 / (1 / k1 + 1 / k2) / m), 2)


@system(HOW)
def cantilever_tip_mass():
    m, EI, length = map(mpf, (3, 70, 2))
    L = lambda q, v: m / 2 * v[0] ** 2 - beam(EI, length, 0, 0, q[0], q[1])
    return family("w", "theta"), [0, 0], massless(L, squares(3 * EI / (m * length**3)), 2)


@system(HOW)
def cantilever_two_masses():
    m, EI, h = map(mpf, ("1.2", 500, "0.5"))
    L = lambda q, v: (m * v[0] ** 2 + m / 2 * v[1] ** 2 - beam(EI, h, 0, 0, q[0], q[2])
                      - beam(EI, h, q[0], q[2], q[1], q[3]))
    both = [3 * EI / (7 * m * h**3) * (10 + sign * sqrt(mpf(86))) for sign in (-1, 1)]
    return family("w", 2) + family("theta", 2), [0] * 4, massless(L, squares(*both), 4)


@system(HOW)
def portal_frame():
    m, column, girder, h, length = map(mpf, (4000, "6e6", "9e6", "3.5", 7))
    L = lambda q, v: (m / 2 * v[0] ** 2 - beam(column, h, 0, 0, q[0], q[1]) - beam(column, h, 0, 0, q[0], q[2])
                      - beam(girder, length, 0, q[1], 0, q[2]))
    r = girder * h / (2 * column * length)
    return family("u", "a", "b"), [0] * 3, massless(
        L, squares(24 * column / (m * h**3) * (12 * r + 1) / (12 * r + 4)), 3)


@system(HOW)
def zener_element():
    m, k1, k2, c = map(mpf, (1, 6, 5, "1.25"))
    # m*c*s^3 + m*k2*s^2 + (k1 + k2)*c*s + k1*k2 is m*c*(s + 3)*(s^2 + s + 8).
    assert (k2 / c, (k1 + k2) / m, k1 * k2 / (m * c)) == (3 + 1, 3 + 8, 3 * 8)
    L = lambda q, v: m / 2 * v[0] ** 2 - k1 / 2 * q[0] ** 2 - k2 / 2 * (q[0] - q[1]) ** 2
    F = lambda q, v: c / 2 * v[1] ** 2
    return family("x", "y"), [0, 0], massless(L, [(mpf(-3), 0)] + pair(mpf(1), mpf(1), mpf(8)), 2, F)


@system(HOW + "; the exponent 0 is that of the kernel x = y of K")
def maxwell_element():
    m, k, c = map(mpf, ("1.5", 40, 8))
    L = lambda q, v: m / 2 * v[0] ** 2 - k / 2 * (q[0] - q[1]) ** 2
    F = lambda q, v: c / 2 * v[1] ** 2
    return family("x", "y"), [0, 0], massless(L, [ZERO] + pair(m * c, m * k, k * c), 2, F)
