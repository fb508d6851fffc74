"""From a hand-written Lagrangian, dissipation function and constraints to exponents, in many digits.

Nothing here knows the model language or Librate's methods.  For a hand-written Lagrangian L(q, v), a dissipation
function F(q, v), generalised forces Q(q, v) and constraints c(q) = 0, at an equilibrium q0 or a steady motion with the constant rates v0:

1. All second derivatives of L and F are central differences in (q, v), with 200 digits and the step 1e-50; they are
   wrong by about 1e-100 of their size.  M = L_vv, G = L_vq - L_vq^T, K = -L_qq, C = F_vv, N = F_vq; first derivatives
   of forces are central differences as well, -Q_v belongs to G + C and -Q_q to K + N.
2. The force there must be a combination of the gradients of the constraints; the factors are the multipliers, and
   K loses the sum of lambda*c_qq.
3. M, G + C and K + N are taken on the null space of the constraints' Jacobian, from Gaussian elimination.
4. The exponents are the eigenvalues of the companion matrix [[0, 1], [-M^-1 (K + N), -M^-1 (G + C)]].
5. Every one must agree with the closed form to 60 digits; where exponents coincide, to 40 digits, for a difference of
   1e-100 in a matrix moves a double eigenvalue by 1e-50.  The closed form is what the file holds.

A growth or an exponent is exactly 0 only by the closed form; each system says why.
"""
import mpmath as mp
from mpmath import mpc, mpf, sqrt
from numerics import decimal

STEP = mpf(10) ** -50


# Matrices

def second_derivatives(f, q0, v0):
    """The matrix of second derivatives of f(q, v) in (q, v)."""
    z0, n = list(q0) + list(v0), len(q0)

    def at(*moves):
        z = list(z0)
        for i, sign in moves:
            z[i] += sign * STEP
        return f(z[:n], z[n:])

    rest = at()
    single = [at((i, 1)) + at((i, -1)) for i in range(2 * n)]
    H = mp.matrix(2 * n, 2 * n)
    for i in range(2 * n):
        H[i, i] = (single[i] - 2 * rest) / STEP**2
        for j in range(i):
            both = at((i, 1), (j, 1)) + at((i, -1), (j, -1))
            H[i, j] = H[j, i] = (both - single[i] - single[j] + 2 * rest) / (2 * STEP**2)
    return H


def slope(f, q0, v0, i):
    """The derivative of f(q, v) by the i-th of (q, v)."""
    z0, n = list(q0) + list(v0), len(q0)
    plus, minus = list(z0), list(z0)
    plus[i] += STEP
    minus[i] -= STEP
    return (f(plus[:n], plus[n:]) - f(minus[:n], minus[n:])) / (2 * STEP)


def block(H, rows, columns, n):
    return mp.matrix(n, n) if H is None else H[rows * n:(rows + 1) * n, columns * n:(columns + 1) * n]


def tangents(J, n):
    """A basis of the null space of J, whose rows must be independent, by elimination with full pivoting."""
    rows, free, bound = [list(r) for r in J], list(range(n)), []
    for k in range(len(rows)):
        i, j = max(((i, j) for i in range(k, len(rows)) for j in free), key=lambda p: abs(rows[p[0]][p[1]]))
        assert abs(rows[i][j]) > mpf(10) ** -40, "the constraints depend on each other"
        rows[k], rows[i] = rows[i], rows[k]
        rows[k] = [x / rows[k][j] for x in rows[k]]
        for m in range(len(rows)):
            if m != k:
                rows[m] = [x - rows[m][j] * y for x, y in zip(rows[m], rows[k])]
        free.remove(j)
        bound.append(j)
    Z = mp.matrix(n, len(free))
    for c, j in enumerate(free):
        Z[j, c] = 1
        for k, b in enumerate(bound):
            Z[b, c] = -rows[k][j]
    return Z


def linearized(L, q0, v0, F=None, constraints=None, Q=None):
    """M, D = G + C and S = K + N on the tangent space of the constraints."""
    n = len(q0)
    H = second_derivatives(L, q0, v0)
    R = None if F is None else second_derivatives(F, q0, v0)
    M, B = block(H, 1, 1, n), block(H, 1, 0, n)
    D = B - B.T + block(R, 1, 1, n)
    S = -block(H, 0, 0, n) + block(R, 1, 0, n)
    # The steady motion: d/dt L_v = B v0 (rates of cyclic coordinates), against L_q - F_v.
    force = B * mp.matrix(v0) - mp.matrix([slope(L, q0, v0, i) for i in range(n)])
    if F is not None:
        force += mp.matrix([slope(F, q0, v0, n + i) for i in range(n)])
    if Q is not None:
        each = [lambda q, v, a=a: Q(q, v)[a] for a in range(n)]
        force -= mp.matrix(Q(q0, v0))
        S -= mp.matrix([[slope(own, q0, v0, i) for i in range(n)] for own in each])
        D -= mp.matrix([[slope(own, q0, v0, n + i) for i in range(n)] for own in each])
    size = max(1, max(abs(x) for x in S) * max(1, max(abs(x) for x in q0)))
    if constraints is None:
        assert mp.norm(force, mp.inf) < mpf(10) ** -80 * size, f"not an equilibrium: {force}"
        return M, D, S
    count = len(constraints(q0))
    each = [lambda q, v, a=a: constraints(q)[a] for a in range(count)]
    assert max(abs(c) for c in constraints(q0)) < mpf(10) ** -150, "a constraint does not hold"
    J = [[slope(c, q0, v0, i) for i in range(n)] for c in each]
    matrix = mp.matrix(J)
    factors = mp.lu_solve(matrix * matrix.T, matrix * force)
    assert mp.norm(force - matrix.T * factors, mp.inf) < mpf(10) ** -80 * size, "not an equilibrium"
    for c, factor in zip(each, factors):
        S -= factor * block(second_derivatives(c, q0, v0), 0, 0, n)
    Z = tangents(J, n)
    return Z.T * M * Z, Z.T * D * Z, Z.T * S * Z


def exponents(M, D, S):
    n = M.rows
    inverse = mp.inverse(M)
    MS, MD = inverse * S, inverse * D
    # Time in units of the fastest motion, so that the two halves of the matrix are of one size.
    unit = max(sqrt(max(abs(x) for x in MS)), max(abs(x) for x in MD))
    A = mp.matrix(2 * n, 2 * n)
    for i in range(n):
        A[i, n + i] = 1
        for j in range(n):
            A[n + i, j], A[n + i, n + j] = -MS[i, j] / unit**2, -MD[i, j] / unit
    return [z * unit for z in mp.eig(A, left=False, right=False)]


def rolling_exponents(L, q0, v0, conditions):
    """Exponents under conditions on velocities, f(q, v) = 0 linear in v, whose forces vanish at the equilibrium, without
    those zeros that stand for the conditions themselves: of [M, -A^T; A, 0][q''; factors] = [-D q' - S q; -B q']."""
    n = len(q0)
    M, D, S = linearized(L, q0, v0)
    each = [lambda q, v, a=a: conditions(q, v)[a] for a in range(len(conditions(q0, v0)))]
    assert max(abs(f(q0, v0)) for f in each) < mpf(10) ** -150, "a condition does not hold"
    A = mp.matrix([[slope(f, q0, v0, n + i) for i in range(n)] for f in each])
    B = mp.matrix([[slope(f, q0, v0, i) for i in range(n)] for f in each])
    m = A.rows
    left, right = mp.matrix(n + m, n + m), mp.matrix(n + m, 2 * n)
    for i in range(n):
        for j in range(n):
            left[i, j], right[i, j], right[i, n + j] = M[i, j], -S[i, j], -D[i, j]
        for a in range(m):
            left[i, n + a], left[n + a, i], right[n + a, n + i] = -A[a, i], A[a, i], -B[a, i]
    X = mp.inverse(left) * right
    state = mp.matrix(2 * n, 2 * n)
    for i in range(n):
        state[i, n + i] = 1
        for j in range(2 * n):
            state[n + i, j] = X[i, j]
    return mp.eig(state, left=False, right=False)


def rolled(L, closed, q0, v0, conditions):
    """What make.py needs under conditions on velocities: `closed` are the entries, a zero for each condition included."""
    rates = v0
    q0, v0 = [mpf(x) for x in q0], [mpf(x) for x in v0 or [0] * len(q0)]
    numbers = rolling_exponents(L, q0, v0, conditions)
    wanted = [z for z in all_exponents([mode for mode in closed if mode != ZERO], True, 0)]
    # Zeros come in Jordan blocks, which differences spread.
    beyond = [z for z in numbers if abs(z) > mpf(10) ** -15]
    agree(beyond, wanted)
    return listed(closed, rates and v0)


def listed(closed, rates):
    """Entries by formula in their order; zeros count for stability unless said otherwise."""
    closed = sorted(closed, key=order)
    unstable = any(growth > 0 for growth, _ in closed)
    neutral = any(mode == ZERO for mode in closed)
    found = {"stability": "unstable" if unstable else "neutral" if neutral else "stable",
             "modes": [entry(*mode) for mode in closed]}
    if rates:
        found["rates"] = [decimal(x) for x in rates]
    return {"entries": found}


def nullity(S):
    size = max(abs(x) for x in S)
    if size < mpf(10) ** -60:
        return S.rows
    values = mp.svd_r(S, compute_uv=False)
    return sum(1 for s in values if s < mpf(10) ** -60 * size)


# Entries

def pair(a, b, c):
    """One exponent of each conjugate pair of a*s^2 + b*s + c = 0, or both real ones, as (growth, omega)."""
    d = b * b - 4 * a * c
    if d < 0:
        return [(-b / (2 * a), sqrt(-d) / (2 * a))]
    return [((-b + sqrt(d)) / (2 * a), 0), ((-b - sqrt(d)) / (2 * a), 0)]


def swings(*omegas):
    """Entries that neither grow nor decay."""
    assert all(isinstance(mpf(w), mpf) and w > 0 for w in omegas)
    return [(0, w) for w in omegas]


def squares(*values):
    """Entries of squares omega^2 > 0."""
    return swings(*(sqrt(z) for z in values))


ZERO = (0, 0)


def all_exponents(entries, friction, zero_multiplicity):
    """Every exponent that the entries stand for."""
    found = [mpc(0)] * zero_multiplicity
    for growth, omega in entries:
        if omega != 0:
            found += [mpc(growth, omega), mpc(growth, -omega)]
        elif growth != 0:
            found += [mpc(growth)] if friction else [mpc(growth), mpc(-growth)]
    return found


def agree(numbers, closed):
    size = max(abs(z) for z in closed)
    assert len(numbers) == len(closed), f"{len(numbers)} exponents, {len(closed)} by formula"
    numbers = list(numbers)
    for c in closed:
        z = min(numbers, key=lambda z: abs(z - c))
        alone = sum(abs(c - d) < mpf(10) ** -40 * size for d in closed) == 1
        allowed = mpf(10) ** -60 * abs(c) if alone else mpf(10) ** -40 * (abs(c) or size)
        assert abs(z - c) <= allowed, f"closed form {mp.nstr(c, 20)}, numbers {mp.nstr(z, 20)}"
        numbers.remove(z)


def entry(growth, omega):
    if growth > 0:
        kind = "unstable"
    elif growth < 0:
        kind = "damped" if omega else "overdamped"
    else:
        kind = "oscillation" if omega else "zero"
    return {"kind": kind, "omega": decimal(mpf(omega)), "growth": decimal(mpf(growth))}


def order(mode):
    growth, omega = mode
    return (0, -growth, omega) if growth > 0 else (1, omega, -growth)


def solved(L, closed, q0, v0=None, F=None, constraints=None, zero_multiplicity=None, Q=None, friction=None):
    """What make.py and equations.py need.  `closed` are the entries by formula, zero ones included."""
    rates = v0
    q0, v0 = [mpf(x) for x in q0], [mpf(x) for x in v0 or [0] * len(q0)]
    M, D, S = linearized(L, q0, v0, F, constraints, Q)
    friction = F is not None if friction is None else friction
    zeros = sum(mode == ZERO for mode in closed)
    if not friction:
        # Exponents come in pairs ±s: a zero entry stands for two.
        assert len(closed) == M.rows, "one entry a degree of freedom"
        zero_multiplicity = 2 * zeros
    else:
        assert nullity(S) == zeros, "with friction there are as many zero entries as K has null vectors"
        zero_multiplicity = zeros if zero_multiplicity is None else zero_multiplicity
    agree(exponents(M, D, S), all_exponents(closed, friction, zero_multiplicity))
    closed = sorted(closed, key=order)
    unstable = any(growth > 0 for growth, _ in closed)
    found = {"stability": "unstable" if unstable else "neutral" if zeros else "stable",
             "modes": [entry(*mode) for mode in closed]}
    if rates:
        found["rates"] = [decimal(x) for x in v0]
    return {"entries": found, "lagrangian": L, "dissipation": F, "force": Q, "constraints": constraints}
