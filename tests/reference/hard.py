"""Hard cases (models/hard): scales far apart, near and exact degeneracies, almost-zero and zero modes together.

Here 80 digits are not always enough, and "small beside the largest" says nothing: the eigenvalues of one model range
over forty powers of ten.  So the eigenvalues are found twice, with 150 and with 220 digits, and must agree to 60
digits *each*.  Where M and K are rational numbers they are also counted in exact arithmetic: K - s*M must have k
negative pivots just below the k-th eigenvalue and one more just above it (Sylvester's law of inertia), "just" being
1e-42 of the eigenvalue.
"""
import csv
from fractions import Fraction
from pathlib import Path

import mpmath as mp
from mpmath import acos, cos, cosh, exp, mpf, pi, sin, sinh, sqrt
from numerics import gradient, mass_matrix, newton, quadratic, square, stiffness_matrix
from register import family, system

g = mpf("9.81")
CLOSED = "formula at 200 digits; agrees to 50 digits of each with eigenvalues from differences of a hand-written T and V"
DIFFERENCES = "M and K from differences of a hand-written T and V at 200 digits; eigenvalues with mpmath at 150 and 220 digits"
NEWTON = "place by Newton's method; " + DIFFERENCES
DATA = Path(__file__).resolve().parents[2] / "models" / "hard" / "data"
TWICE = "M and K in exact numbers; eigenvalues with mpmath at 150 and 220 digits, counted by Sylvester's law in exact arithmetic"
SHORT = mpf(10) ** -60


def hard(name, how):
    return system(how, name=f"hard/{name}")


# Eigenvalues

def at_precision(M, K, digits):
    with mp.workdps(digits):
        n = len(M)
        exact = lambda x: mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else mpf(x)
        m, k = (mp.matrix([[exact(x) for x in row] for row in A]) for A in (M, K))
        if all(m[i, j] == 0 for i in range(n) for j in range(n) if i != j):
            s = [1 / sqrt(m[i, i]) for i in range(n)]
            a = mp.matrix(n, n)
            for i in range(n):
                for j in range(n):
                    a[i, j] = k[i, j] * s[i] * s[j]
        else:
            inverse = mp.inverse(mp.cholesky(m))
            a = inverse * k * inverse.T
        return sorted(mp.eigsy((a + a.T) / 2, eigvals_only=True))


def eigenvalues(M, K, zeros=0, closed=None):
    """All omega^2; `zeros` of them are exactly 0.  Each of the others is right to 60 digits."""
    first, values = at_precision(M, K, 150), at_precision(M, K, 220)
    size = max(abs(z) for z in values)
    small = [z for z in values if abs(z) < mpf(10) ** -120 * size]
    assert len(small) == zeros, f"{len(small)} zero modes, expected {zeros}"
    for a, b in zip(first, values):
        assert b in small or abs(a / b - 1) < SHORT, (mp.nstr(a, 30), mp.nstr(b, 30))
    values = [mpf(0) if z in small else z for z in values]
    if closed is not None:
        values = agree(values, closed)
    elif all(isinstance(x, (int, Fraction)) for A in (M, K) for row in A for x in row):
        count(M, K, values)
    return values


def agree(values, closed):
    """The closed forms, after comparing each with its eigenvalue."""
    closed = sorted(mpf(z) for z in closed)
    assert len(closed) == len(values)
    for z, c in zip(values, closed):
        assert (z == 0) == (c == 0) and abs(z - c) <= mpf(10) ** -50 * abs(c), (mp.nstr(z, 30), mp.nstr(c, 30))
    return closed


def rational(x):
    """The exact value of a number of mpmath."""
    sign, mantissa, exponent, _ = x._mpf_
    return (-1) ** sign * int(mantissa) * Fraction(2) ** int(exponent)


def negative_pivots(A):
    """How many eigenvalues of a symmetric matrix of fractions are negative; no pivot may vanish."""
    A, n, found = [row[:] for row in A], len(A), 0
    for p in range(n):
        assert A[p][p] != 0, "a pivot vanishes; take another shift"
        found += A[p][p] < 0
        rest = [j for j in range(p + 1, n) if A[p][j] != 0]
        for i in rest:
            factor = A[i][p] / A[p][p]
            for j in rest:
                A[i][j] -= factor * A[p][j]
    return found


def count(M, K, values):
    """Each eigenvalue is where it is said to be, proved by counting in fractions."""
    def below(s):
        return negative_pivots([[Fraction(k) - s * m for k, m in zip(*rows)] for rows in zip(K, M)])
    for position, z in enumerate(values):
        if z == 0:
            continue
        with mp.workdps(60):
            width = abs(+z) * mpf(10) ** -42
            low, high = rational(+z - width), rational(+z + width)
        assert below(low) == position and below(high) == position + 1, f"eigenvalue {position} of {len(values)}"


def differences(T, V, q0, scale=1):
    """M and K from differences of T and V, as in the other systems."""
    U = lambda q: V(q) - T(q, [mpf(0)] * len(q))
    force = max(abs(f) for f in gradient(U, q0, scale))
    K = stiffness_matrix(U, q0, scale)
    assert force * scale <= mpf(10) ** -60 * max(abs(k) for k in K) * scale**2, f"not an equilibrium: {force}"
    return mass_matrix(T, q0).tolist(), K.tolist()


# Chains

def chain(masses, springs):
    """springs[0] ties the first mass to a wall, springs[n] the last one; 0 is no spring."""
    m, k = [Fraction(x) for x in masses], [Fraction(x) for x in springs]
    n = len(m)
    M = [[m[i] if i == j else Fraction(0) for j in range(n)] for i in range(n)]
    K = [[Fraction(0)] * n for _ in range(n)]
    for i in range(n):
        K[i][i] = k[i] + k[i + 1]
        if i:
            K[i][i - 1] = K[i - 1][i] = -k[i]
    return M, K


def chain_model(masses, springs, zeros=0, closed=None):
    n = len(masses)
    M, K = chain(masses, springs)
    return family("x", n), [0] * n, dict(values=eigenvalues(M, K, zeros, closed))


def ten(exponent):
    return Fraction(10) ** exponent


def three_springs(order):
    @hard("springs_" + "_".join(map(str, order)), TWICE)
    def model():
        # Roots of the characteristic polynomial too.
        a, b, c = (ten(e) for e in order)
        coordinates, q0, found = chain_model([1] * 3, [a, b, c, 0])
        cubic = [1, -(a + 2 * b + 2 * c), a * b + 2 * a * c + 3 * b * c, -a * b * c]
        with mp.workdps(300):
            for z in found["values"]:
                value = sum(mpf(x.numerator) / x.denominator * z**p for x, p in zip(map(Fraction, cubic), (3, 2, 1, 0)))
                slope = sum(p * mpf(Fraction(x).numerator) / Fraction(x).denominator * z**(p - 1)
                            for x, p in zip(cubic, (3, 2, 1)))
                assert abs(value / slope) < SHORT * z
        return coordinates, q0, found


for order in ((0, 8, 16), (0, 16, 8), (8, 0, 16), (8, 16, 0), (16, 0, 8), (16, 8, 0)):
    three_springs(order)


@hard("chain_alternating", TWICE)
def chain_alternating():
    return chain_model([1] * 24, [1, ten(14)] * 12 + [0])


@hard("inerters_alternating", TWICE)
def inerters_alternating():
    # The chain of springs turned round: M adds the inerters up, K is diagonal.
    n = 20
    K, M = chain([i + 1 for i in range(n)], [1] + [1, ten(14)] * 9 + [1, 0])
    return family("x", n), [0] * n, dict(values=eigenvalues(M, K))


GRADES = (-12, -10, -8, -6, -3, -1, 1, 3, 6, 8, 10, 12)


@hard("masses_sorted", TWICE)
def masses_sorted():
    return chain_model([ten(e) for e in GRADES], [1] * 13)


@hard("masses_shuffled", TWICE)
def masses_shuffled():
    return chain_model([ten(GRADES[5 * i % 12]) for i in range(12)], [1] * 13)


@hard("masses_and_springs", TWICE)
def masses_and_springs():
    springs = [ten(e) for e in (2, -10, 4, -8, 6, -6, 8, -4, 10, -2, 12, -12)] + [0]
    return chain_model([ten(GRADES[5 * i % 12]) for i in range(12)], springs)


@hard("chain_free_50", "formula at 200 digits; agrees to 50 digits with eigenvalues at 150 and 220 digits")
def chain_free_50():
    return chain_model([1] * 50, [0] + [1] * 49 + [0], 1, [4 * sin(j * pi / 100) ** 2 for j in range(50)])


@hard("chain_2000", "formula at 200 digits; the sums of omega^2 and omega^4 and the product of omega^2 agree with "
                    "trace and determinant")
def chain_2000():
    n = 2000
    values = [4 * sin(j * pi / (2 * (n + 1))) ** 2 for j in range(1, n + 1)]
    assert abs(sum(values) / (2 * n) - 1) < SHORT
    assert abs(sum(z * z for z in values) / (4 * n + 2 * (n - 1)) - 1) < SHORT
    assert abs(mp.fprod(values) / (n + 1) - 1) < SHORT
    return family("x", n), [0] * n, dict(values=values)


@hard("wilkinson_chain", TWICE)
def wilkinson_chain():
    # Two more than the eigenvalues of Wilkinson's matrix W21+.
    M, K = chain([1] * 21, [1] * 22)
    for i in range(21):
        K[i][i] += abs(i - 10)
    values = eigenvalues(M, K)
    with mp.workdps(30):
        # J. H. Wilkinson, The Algebraic Eigenvalue Problem (1965), p. 309: the two largest.
        assert abs(values[20] - 2 - mpf("10.74619418290339")) < mpf("1e-14")
        assert abs(values[19] - 2 - mpf("10.74619418290332")) < mpf("1e-14")
    return family("x", 21), [0] * 21, dict(values=values)


@hard("weak_bond", TWICE)
def weak_bond():
    return chain_model([1, 2, 3, 3, 2, 1], [0, 1, 1, ten(-12), 1, 1, 0], 1)


@hard("nearly_massless_bead", TWICE)
def nearly_massless_bead():
    return chain_model([1, ten(-30), 2], [1, 2, 3, 1])


def gears(ratios, closed=None):
    n, a = len(ratios) + 1, [Fraction(r) for r in ratios]
    M = [[Fraction(i == j) for j in range(n)] for i in range(n)]
    K = [[Fraction(0)] * n for _ in range(n)]
    for i in range(n - 1):
        K[i][i] += 1
        K[i + 1][i + 1] += a[i] ** 2
        K[i][i + 1] = K[i + 1][i] = -a[i]
    return family("theta", n), [0] * n, dict(values=eigenvalues(M, K, 1, closed))


@hard("gear_train", "formula at 200 digits; agrees to 50 digits of each with eigenvalues at 150 and 220 digits")
def gear_train():
    n, a = 40, mpf("1.9")
    return gears(["1.9"] * (n - 1), [0] + [1 + a**2 - 2 * a * cos(j * pi / n) for j in range(1, n)])


@hard("gear_train_uneven", TWICE)
def gear_train_uneven():
    return gears(["1.9", "3.1", "2.3", "0.37", "0.7", "1.3", "1.7", "2.9", "0.53", "0.59"])


# Degeneracies

@hard("pendulums_barely_coupled", CLOSED)
def pendulums_barely_coupled():
    k = mpf("1e-13")
    T = lambda q, v: (v[0] ** 2 + v[1] ** 2) / 2
    V = lambda q: -g * (cos(q[0]) + cos(q[1])) + k / 2 * (q[0] - q[1]) ** 2
    values = eigenvalues(*differences(T, V, [0, 0]), closed=[g, g + 2 * k])
    return family("phi", 2), [0, 0], dict(values=values, symmetry=["even", "odd"])


@hard("pendulums_barely_different", CLOSED)
def pendulums_barely_different():
    k, l = mpf("1e-13"), [mpf(1), 1 + mpf("1e-14")]
    T = lambda q, v: sum(a**2 * b**2 / 2 for a, b in zip(l, v))
    V = lambda q: -g * sum(a * cos(b) for a, b in zip(l, q)) + k / 2 * (q[0] - q[1]) ** 2
    a, b = ((g * x + k) / x**2 for x in l)
    closed = quadratic(1, -(a + b), a * b - (k / (l[0] * l[1])) ** 2)
    return family("phi", 2), [0, 0], dict(values=eigenvalues(*differences(T, V, [0, 0]), closed=closed))


@hard("complete_graph", "n*k/m for all but the translation; agrees to 50 digits with eigenvalues at 150 and 220 digits")
def complete_graph():
    n, k, m = 61, 2, 3
    M = [[m * (i == j) for j in range(n)] for i in range(n)]
    K = [[k * (n - 1) if i == j else -k for j in range(n)] for i in range(n)]
    return family("x", n), [0] * n, dict(values=eigenvalues(M, K, 1, [0] + [mpf(n * k) / m] * (n - 1)))


@hard("lieb_lattice", "formula at 200 digits; agrees to 50 digits with eigenvalues at 80 digits")
def lieb_lattice():
    # Masses at the corners and in the middles of the sides of a square lattice on a torus, one spring from each
    # middle to each of its two corners.
    n = 8
    corner = lambda i, j: n * (i % n) + j % n
    ends = [(corner(i, j), corner(i + 1, j)) for i in range(n) for j in range(n)]
    ends += [(corner(i, j), corner(i, j + 1)) for i in range(n) for j in range(n)]
    size = n * n + len(ends)
    K = mp.matrix(size, size)
    for middle, corners in enumerate(ends, n * n):
        for c in corners:
            for p, q, sign in ((middle, middle, 1), (c, c, 1), (c, middle, -1), (middle, c, -1)):
                K[p, q] += sign
    # The middles alone, every corner at rest: 2*n^2 unknowns and n^2 - 1 independent conditions.
    closed = [mpf(2)] * (n * n + 1)
    for a in range(n):
        for b in range(n):
            root = sqrt(5 + 2 * cos(2 * pi * a / n) + 2 * cos(2 * pi * b / n))
            # At the far corner of the zone the corners move alone.
            closed += [mpf(4)] if 2 * a == 2 * b == n else [mpf(0) if a == b == 0 else 3 - root, 3 + root]
    with mp.workdps(80):
        values = sorted(mp.eigsy(K, eigvals_only=True))
    values = [mpf(0) if abs(z) < mpf(10) ** -70 else z for z in values]
    names = family("u", n, n) + family("h", n, n) + family("v", n, n)
    return names, [0] * size, dict(values=agree(values, closed))


# Ill-conditioned masses

def hilbert(n):
    return [[Fraction(1, i + j + 1) for j in range(n)] for i in range(n)]


@hard("hilbert_mass", TWICE)
def hilbert_mass():
    n = 12
    _, K = chain([1] * n, [1] * (n + 1))
    return family("x", n), [0] * n, dict(values=eigenvalues(hilbert(n), K))


def hilbert_rounded():
    with open(DATA / "hilbert_12_rounded.csv", newline="") as file:
        entries = {(int(r["i"]), int(r["j"])): Fraction(r["m"]) for r in csv.DictReader(file)}
    M = [[entries[i, j] for j in range(1, 13)] for i in range(1, 13)]
    assert all(M[i][j] == Fraction(float(Fraction(1, i + j + 1))) for i in range(12) for j in range(12))
    return M


@hard("hilbert_mass_rounded", TWICE)
def hilbert_mass_rounded():
    _, K = chain([1] * 12, [1] * 13)
    return family("x", 12), [0] * 12, dict(values=eigenvalues(hilbert_rounded(), K))


def laguerre(n):
    """The zeros of the Laguerre polynomial L_n: eigenvalues of the Jacobi matrix of its recurrence, made exact by
    Newton's method on the recurrence itself."""
    J = mp.matrix(n, n)
    for i in range(n):
        J[i, i] = 2 * i + 1
        if i:
            J[i, i - 1] = J[i - 1, i] = -i
    zeros = []
    for z in sorted(mp.eigsy(J, eigvals_only=True)):
        p, before = 1 - z, mpf(1)
        for k in range(1, n):
            p, before = ((2 * k + 1 - z) * p - k * before) / (k + 1), p
        step = p * z / (n * (p - before))
        assert abs(step) < mpf(10) ** -120 * z
        zeros.append(z - step)
    return zeros


def links(n):
    M = [[Fraction(n - max(i, j)) for j in range(n)] for i in range(n)]
    K = [[Fraction(981, 100) * (n - i) * (i == j) for j in range(n)] for i in range(n)]
    return family("theta", n), [0] * n, dict(values=eigenvalues(M, K, closed=[g * z for z in laguerre(n)]))


LAGUERRE = "g times the zeros of the Laguerre polynomial L_n, from its recurrence; agree to 50 digits with eigenvalues at 150 and 220 digits"


@hard("pendulum_20_links", LAGUERRE)
def pendulum_20_links():
    return links(20)


@hard("pendulum_50_links", LAGUERRE)
def pendulum_50_links():
    return links(50)


@hard("nearly_massless_support", CLOSED)
def nearly_massless_support():
    mu, m, l, k = mpf("1e-20"), mpf(1), mpf("0.5"), mpf(30)
    T = lambda q, v: mu * v[0] ** 2 / 2 + m / 2 * (v[0] ** 2 + 2 * l * v[0] * v[1] * cos(q[1]) + l**2 * v[1] ** 2)
    V = lambda q: k / 2 * q[0] ** 2 - m * g * l * cos(q[1])
    closed = quadratic(mu * l, -(k * l + (mu + m) * g), k * g)
    closed[0] = k * g / (mu * l) / closed[1]
    return family("x", "phi"), [0, 0], dict(values=eigenvalues(*differences(T, V, [0, 0]), closed=closed))


# Bifurcations and wells

def hoop(factor):
    R = mpf("0.2")
    W = factor * sqrt(g / R)
    T = lambda q, v: R**2 * (v[0] ** 2 + W**2 * sin(q[0]) ** 2) / 2
    V = lambda q: -g * R * cos(q[0])
    return R, W, T, V


def bead_up():
    R, W, T, V = hoop(1 + mpf("1e-8"))
    q0 = [acos(g / (W**2 * R))]
    return family("th"), q0, dict(values=eigenvalues(*differences(T, V, q0), closed=[W**2 - (g / (W * R)) ** 2]))


@hard("bead_just_above", CLOSED)
def bead_just_above():
    return bead_up()


@hard("bead_just_above_searched", CLOSED)
def bead_just_above_searched():
    return bead_up()


@hard("bead_just_below", CLOSED)
def bead_just_below():
    R, W, T, V = hoop(1 - mpf("1e-8"))
    return family("th"), [0], dict(values=eigenvalues(*differences(T, V, [0]), closed=[g / R - W**2]))


def column(factor):
    """A rigid column on a spring hinge, per unit mass; it buckles when the spring is weaker than the weight."""
    l = mpf("0.5")
    k = factor * g * l
    T = lambda q, v: l**2 * v[0] ** 2 / 2
    V = lambda q: g * l * cos(q[0]) + k / 2 * q[0] ** 2
    return l, k, T, V


@hard("column_just_stands", CLOSED)
def column_just_stands():
    l, k, T, V = column(1 + mpf("1e-8"))
    return family("phi"), [0], dict(values=eigenvalues(*differences(T, V, [0]), closed=[(k - g * l) / l**2]))


@hard("column_just_falls", CLOSED)
def column_just_falls():
    l, k, T, V = column(1 - mpf("1e-8"))
    return family("phi"), [0], dict(values=eigenvalues(*differences(T, V, [0]), closed=[(k - g * l) / l**2]))


@hard("column_just_buckled", "place from sin(phi)/phi = 1 - 1e-8, omega^2 = (k - g*l*cos(phi))/l^2; "
                             "agrees to 50 digits with differences of a hand-written T and V")
def column_just_buckled():
    l, k, T, V = column(1 - mpf("1e-8"))
    phi = mp.findroot(lambda x: mp.sinc(x) - (1 - mpf("1e-8")), (mpf("2.4e-4"), mpf("2.5e-4")), solver="anderson",
                      tol=mpf(10) ** -300)
    q0 = newton(V, [phi])
    assert abs(q0[0] - phi) < mpf(10) ** -70
    return family("phi"), q0, dict(values=eigenvalues(*differences(T, V, q0), closed=[(k - g * l * cos(q0[0])) / l**2]))


def two_wells(guess):
    deep, narrow, shallow, wide, apart = mpf(1000), mpf("1e-3"), mpf(1), mpf(1), mpf(2)
    T = lambda q, v: v[0] ** 2 / 2
    V = lambda q: -deep * exp(-(q[0] / narrow) ** 2) - shallow * exp(-((q[0] - apart) / wide) ** 2)

    def slope(x):
        return (2 * deep * x / narrow**2 * exp(-(x / narrow) ** 2)
                + 2 * shallow * (x - apart) / wide**2 * exp(-((x - apart) / wide) ** 2))

    def stiffness(x):
        a, b = x / narrow, (x - apart) / wide
        return (2 * deep / narrow**2 * (1 - 2 * a * a) * exp(-a * a) + 2 * shallow / wide**2 * (1 - 2 * b * b) * exp(-b * b))

    q0 = newton(V, guess)
    assert abs(slope(q0[0])) < mpf(10) ** -70
    return family("x"), q0, dict(values=eigenvalues(*differences(T, V, q0), closed=[stiffness(q0[0])]))


WELL = "place by Newton's method from a place in the well; omega^2 from the formula for V'' and from differences"


@hard("well_deep_narrow", WELL)
def well_deep_narrow():
    return two_wells(["1e-5"])


@hard("well_shallow_wide", WELL)
def well_shallow_wide():
    return two_wells(["1.9"])


# Cancellation and searched equilibria

def cancelling(A):
    # The terms in A cancel identically but for a constant.
    T = lambda q, v: (v[0] ** 2 + 2 * v[1] ** 2) / 2
    V = lambda q: (q[0] - 1) ** 2 / 2 + 3 * (q[1] - q[0] ** 2 / 2) ** 2 / 2 + q[1] / 5
    full = lambda q: (A + A * sin(q[0]) ** 2 + A * cos(q[0]) ** 2 + A * cosh(q[1]) ** 2 - A * sinh(q[1]) ** 2
                      + A * (sqrt(2) * q[0] + q[1]) ** 2 - A * (2 * q[0] ** 2 + 2 * sqrt(2) * q[0] * q[1] + q[1] ** 2) + V(q))
    q0 = newton(V, [1, "0.4"])
    plain = eigenvalues(*differences(T, V, q0))
    values = eigenvalues(*differences(T, full, q0))
    for a, b in zip(plain, values):
        assert abs(a / b - 1) < mpf(10) ** -45
    return family("x", "y"), q0, dict(values=plain)


@hard("cancelling_energies", DIFFERENCES + ", with the cancelling parts and without")
def cancelling_energies():
    return cancelling(mpf("1e10"))


@hard("cancelling_energies_severe", DIFFERENCES + ", with the cancelling parts and without")
def cancelling_energies_severe():
    return cancelling(mpf("1e20"))


@hard("cancelling_energies_extreme", DIFFERENCES + ", with the cancelling parts and without")
def cancelling_energies_extreme():
    return cancelling(mpf("1e40"))


def stiff_rod(K):
    T = lambda q, v: (v[0] ** 2 + v[1] ** 2) / 2
    length = lambda x, y: sqrt(x**2 + y**2)
    V = lambda q: (K / 2 * (length(*q) - 1) ** 2 + (length(q[0] - 2, q[1] - 1) - mpf("0.5")) ** 2 / 2 + g * q[1] / 10)
    q0 = newton(V, ["0.98", "-0.2"])
    assert abs(length(*q0) - 1) < mpf("0.01")
    return family("x", "y"), q0, dict(values=eigenvalues(*differences(T, V, q0)))


@hard("irrational_equilibrium", NEWTON)
def irrational_equilibrium():
    return stiff_rod(mpf("1e8"))


@hard("irrational_equilibrium_stiff", NEWTON)
def irrational_equilibrium_stiff():
    return stiff_rod(mpf("1e14"))


@hard("irrational_equilibrium_extreme", NEWTON)
def irrational_equilibrium_extreme():
    return stiff_rod(mpf("1e24"))


def stiff_beside_soft(K, light=1):
    T = lambda q, v: (light * v[0] ** 2 + v[1] ** 2) / 2
    V = lambda q: K * (cosh(q[0]) - 2 * q[0]) - cos(q[1]) - mpf("0.3") * q[1]
    q0 = [mp.asinh(2), mp.asin(mpf("0.3"))]
    closed = [K / light * cosh(q0[0]), cos(q0[1])]
    return family("x", "y"), q0, dict(values=eigenvalues(*differences(T, V, q0), closed=closed))


@hard("stiff_beside_soft", CLOSED)
def stiff_beside_soft_14():
    return stiff_beside_soft(mpf("1e14"))


@hard("stiff_beside_soft_extreme", CLOSED)
def stiff_beside_soft_25():
    return stiff_beside_soft(mpf("1e25"))


@hard("light_beside_heavy", CLOSED)
def light_beside_heavy():
    return stiff_beside_soft(mpf(1), mpf("1e-30"))


@hard("molecule_in_si", CLOSED)
def molecule_in_si():
    D, a, r0, mu = mpf("7.4e-19"), mpf("1.87e10"), mpf("1.275e-10"), mpf("1.62e-27")
    T = lambda q, v: mu * v[0] ** 2 / 2
    V = lambda q: D * (1 - exp(-a * (q[0] - r0))) ** 2
    values = eigenvalues(*differences(T, V, [r0], scale=r0), closed=[2 * D * a**2 / mu])
    return family("r"), [r0], dict(values=values)


@hard("hidden_force", CLOSED)
def hidden_force():
    T = lambda q, v: v[0] ** 2 / 2
    V = lambda q: q[0] ** 2 / 2 + q[0] ** 3 / 3 - mpf("1e-8") * q[0]
    root = sqrt(1 + 4 * mpf("1e-8"))
    q0 = [(root - 1) / 2]
    return family("x"), q0, dict(values=eigenvalues(*differences(T, V, q0), closed=[root]))


# Free bodies.  Unstressed bonds: K is the sum of k*e*e^T over their unit vectors e.

def network(place, bonds):
    d = len(place[0])
    n = d * len(place)
    K = [[0] * n for _ in range(n)]
    for i, j, k in bonds:
        e = [a - b for a, b in zip(place[i], place[j])]
        for a in range(d):
            for b in range(d):
                block = k * e[a] * e[b] / square(e)
                for s, t, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    K[d * s + a][d * t + b] += sign * block
    return K


@hard("free_body_weak_pair", "K summed as k*e*e^T over the unit vectors e of the bonds, in exact numbers; eigenvalues with "
                             "mpmath at 150 and 220 digits, counted by Sylvester's law in exact arithmetic")
def free_body_weak_pair():
    place = [[0, 0], [4, 0], [0, 3], [9, 1], [13, 2], [10, 5]]
    weak = Fraction(1, 10**13)
    bonds = [(0, 1, 1), (1, 2, 2), (0, 2, 3), (3, 4, 2), (4, 5, 1), (3, 5, 2), (1, 3, weak), (2, 5, weak), (1, 5, weak)]
    place = [[Fraction(c) for c in p] for p in place]
    m = [1, 2, 1, 3, 1, 2]
    M = [[m[i // 2] * (i == j) for j in range(12)] for i in range(12)]
    return family("r", 6, 2), sum(place, []), dict(values=eigenvalues(M, network(place, bonds), 3))


@hard("body_off_origin", "K summed as k*e*e^T over the unit vectors e of the bonds, in exact numbers; eigenvalues with "
                         "mpmath at 150 and 220 digits, counted by Sylvester's law in exact arithmetic")
def body_off_origin():
    d = Fraction(1, 10**9)
    place = [[1 + d * a, 1 + d * b] for a, b in ((0, 0), (1, 0), (0, 2), (3, 5))]
    K = network(place, [(i, j, 1) for j in range(4) for i in range(j)])
    M = [[int(i == j) for j in range(8)] for i in range(8)]
    q0 = [mpf(c.numerator) / c.denominator for c in sum(place, [])]
    return family("r", 4, 2), q0, dict(values=eigenvalues(M, K, 3))


@hard("slack_network", "K summed as k*e*e^T over the unit vectors e of the bonds, in exact numbers; eigenvalues with "
                       "mpmath at 150 and 220 digits, counted by Sylvester's law in exact arithmetic")
def slack_network():
    def rows(name):
        with open(DATA / name, newline="") as file:
            return list(csv.DictReader(file))
    points = rows("slack_points.csv")
    place = [[Fraction(p[c]) for c in "xy"] for p in points]
    m = [Fraction(p["mass"]) for p in points]
    n = 2 * len(m)
    M = [[m[i // 2] * (i == j) for j in range(n)] for i in range(n)]
    K = network(place, [(int(b["i"]) - 1, int(b["j"]) - 1, Fraction(b["k"])) for b in rows("slack_bonds.csv")])
    q0 = [mpf(c.numerator) / c.denominator for c in sum(place, [])]
    return family("r", len(m), 2), q0, dict(values=eigenvalues(M, K, 5))


@hard("free_body_100", "K summed as k*e*e^T over the unit vectors e of the bonds; eigenvalues with mpmath at 80 and 100 digits")
def free_body_100():
    def rows(name):
        with open(DATA / name, newline="") as file:
            return list(csv.DictReader(file))
    points = rows("free_body_points.csv")
    place = [[mpf(p[c]) for c in "xyz"] for p in points]
    K = network(place, [(int(b["i"]) - 1, int(b["j"]) - 1, mpf(b["k"])) for b in rows("free_body_bonds.csv")])
    m = [sqrt(mpf(p["mass"])) for p in points for _ in range(3)]
    n = len(m)
    found = []
    for digits in (80, 100):
        with mp.workdps(digits):
            A = mp.matrix(n, n)
            for i in range(n):
                for j in range(n):
                    A[i, j] = K[i][j] / (m[i] * m[j])
            found.append(sorted(mp.eigsy(A, eigvals_only=True)))
    size = found[0][-1]
    zero = [abs(z) < mpf(10) ** -70 * size for z in found[0]]
    assert sum(zero) == 6
    for a, b, none in zip(*found, zero):
        assert none or abs(a / b - 1) < mpf(10) ** -50
    values = sorted(mpf(0) if none else b for b, none in zip(found[1], zero))
    return family("r", len(place), 3), sum(place, []), dict(values=values)
