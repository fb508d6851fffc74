"""From a hand-written T and V to frequencies, in many digits and by the plainest means.

Nothing here knows the model language or Librate's methods.  The matrices come from differences, the
equilibrium from Newton's method or a formula, the eigenvalues from mpmath:

1. M is read off the quadratic form T(q0, v): M_ij = T(e_i + e_j) - T(e_i) - T(e_j) + T(0).  Velocities of
   positions are central differences along v (`rate`).
2. K is the matrix of central second differences of V - T(q, 0) at q0.
3. With the step 1e-45 and 200 working digits the differences are wrong by about 1e-90 of their size.
4. M = C C^T, and the eigenvalues of C^-1 K C^-T are found at 80 digits.
"""
import mpmath as mp
from mpmath import mpf

WORK, EIGEN = 200, 80
STEP = mpf(10) ** -45
mp.mp.dps = WORK


def rate(positions, q, v, scale=1):
    """d/dt of a list of functions of q, when q moves with velocity v."""
    h = STEP * scale
    plus = positions([a + h * b for a, b in zip(q, v)])
    minus = positions([a - h * b for a, b in zip(q, v)])
    return [(a - b) / (2 * h) for a, b in zip(plus, minus)]


def square(vector):
    return sum(c * c for c in vector)


def unit(n, *members):
    return [mpf(sum(i == k for k in members)) for i in range(n)]


def mass_matrix(T, q0):
    n = len(q0)
    rest = T(q0, [mpf(0)] * n)
    single = [T(q0, unit(n, i)) for i in range(n)]
    M = mp.matrix(n, n)
    for i in range(n):
        for j in range(i + 1):
            M[i, j] = M[j, i] = T(q0, unit(n, i, j)) - single[i] - single[j] + rest
    return M


def gradient(U, q, scale):
    n, h = len(q), STEP * scale
    e = [[h * c for c in unit(n, i)] for i in range(n)]
    at = lambda d, s: U([a + s * b for a, b in zip(q, d)])
    return [(at(d, 1) - at(d, -1)) / (2 * h) for d in e]


def stiffness_matrix(U, q0, scale):
    n, h = len(q0), STEP * scale
    at = lambda s, *k: U([a + s * h * b for a, b in zip(q0, unit(n, *k))])
    rest = U(q0)
    single = [at(1, i) + at(-1, i) for i in range(n)]
    K = mp.matrix(n, n)
    for i in range(n):
        for j in range(i + 1):
            both = at(1, i, j) + at(-1, i, j)
            K[i, j] = K[j, i] = (both - single[i] - single[j] + 2 * rest) / (2 * h * h)
    return K


def newton(U, guess):
    """The stationary point of U next to the guess."""
    q = [mpf(x) for x in guess]
    for _ in range(60):
        step = mp.lu_solve(stiffness_matrix(U, q, 1), mp.matrix(gradient(U, q, 1)))
        q = [a - b for a, b in zip(q, step)]
        if mp.norm(step, mp.inf) < mpf(10) ** -70:
            return q
    raise ArithmeticError("Newton's method did not settle")


def eigenvalues(M, K):
    """The squares omega^2, rising, of K x = omega^2 M x."""
    with mp.workdps(EIGEN):
        C = mp.cholesky(M)
        n = M.rows
        if all(C[i, j] == 0 for i in range(n) for j in range(i)):
            A = mp.matrix(n, n)
            for i in range(n):
                for j in range(n):
                    A[i, j] = K[i, j] / (C[i, i] * C[j, j])
        else:
            inverse = mp.inverse(C)
            A = inverse * K * inverse.T
        A = (A + A.T) / 2
        return sorted(mp.eigsy(A, eigvals_only=True))


def squares(coordinates, T, V, q0, zeros=0, closed=None, scale=1):
    """All omega^2, those of the `zeros` zero modes exactly 0.  Closed forms, where given, must agree and win."""
    U = lambda q: V(q) - T(q, [mpf(0)] * len(q))
    assert len(q0) == len(coordinates)
    K, M = stiffness_matrix(U, q0, scale), mass_matrix(T, q0)
    force = max(abs(f) for f in gradient(U, q0, scale))
    assert force * scale <= mpf(10) ** -60 * max(abs(k) for k in K) * scale**2, f"not an equilibrium: {force}"
    return settle(eigenvalues(M, K), zeros, closed)


def settle(values, zeros, closed):
    """Put exact zeros in, and the closed forms after comparing."""
    size = max(abs(z) for z in values)
    small = [z for z in values if abs(z) < mpf(10) ** -50 * size]
    assert len(small) == zeros, f"{len(small)} zero modes, expected {zeros}"
    assert all(abs(z) > mpf(10) ** -20 * size for z in values if z not in small)
    values = sorted(mpf(0) if z in small else z for z in values)
    if closed is None:
        return values
    closed = sorted(mpf(z) for z in closed)
    assert len(closed) == len(values), f"{len(closed)} closed forms for {len(values)} modes"
    for z, c in zip(values, closed):
        assert abs(z - c) < mpf(10) ** -50 * size, f"closed form {mp.nstr(c, 20)}, numbers {mp.nstr(z, 20)}"
    return [c if z != 0 else mpf(0) for z, c in zip(values, closed)]


def laguerre(n):
    """The zeros of the Laguerre polynomial L_n, from its coefficients."""
    coefficients = [mpf(-1) ** k * mp.binomial(n, k) / mp.factorial(k) for k in range(n, -1, -1)]
    return sorted(mp.re(z) for z in mp.polyroots(coefficients, maxsteps=400, extraprec=400))


def quadratic(a, b, c):
    """Both roots of a*z^2 + b*z + c = 0."""
    d = mp.sqrt(b * b - 4 * a * c)
    return [(-b - d) / (2 * a), (-b + d) / (2 * a)]


def decimal(x, digits=40):
    """x with 40 significant digits, rounded to nearest, written without an exponent."""
    if abs(x) < mpf(10) ** -60:
        return "0"
    sign = "-" if x < 0 else ""
    x = abs(mpf(x))
    exponent = int(mp.floor(mp.log10(x)))
    n = int(mp.nint(x * mpf(10) ** (digits - 1 - exponent)))
    if n >= 10**digits:
        n, exponent = n // 10, exponent + 1
    text = str(n)
    if exponent < 0:
        return sign + "0." + "0" * (-exponent - 1) + text
    if exponent >= digits - 1:
        return sign + text + "0" * (exponent - digits + 1)
    return sign + text[: exponent + 1] + "." + text[exponent + 1 :]


def modes(values):
    """The entries in the order they are printed: unstable by falling growth, zero, rising omega."""
    unstable = [{"kind": "unstable", "omega": "0", "growth": decimal(mp.sqrt(-z))} for z in values if z < 0]
    zero = [{"kind": "zero", "omega": "0", "growth": "0"} for z in values if z == 0]
    rest = [{"kind": "oscillation", "omega": decimal(mp.sqrt(z)), "growth": "0"} for z in values if z > 0]
    return unstable + zero + rest


def stability(values):
    if any(z < 0 for z in values):
        return "unstable"
    return "neutral" if any(z == 0 for z in values) else "stable"
