"""Exponents of models/rolling/rattleback.lag, to 30 digits, for tests/modes/rolling.rs.

    python3 tests/reference/rattleback.py

Newton's and Euler's equations in the body (A. Garcia and M. Hubbard, Proceedings of the Royal Society A 418 (1988) 165): with the vertical u,
the angular velocity w and the arm rho(u) from the centre to the point of contact, v = rho x w, u' = u x w,
F = m*(v' + w x v + g*u) and I w' + w x I w = rho x F. Derivatives are central differences at 60 digits.
"""

from mpmath import eig, lu_solve, matrix, mp, mpf, nstr, sqrt

mp.dps = 60
m, g = mpf(1), mpf("9.81")
axes = [mpf("0.2") ** 2, mpf("0.03") ** 2, mpf("0.02") ** 2]
inertia = matrix([["0.0002", "-0.00002", 0], ["-0.00002", "0.0016", 0], [0, 0, "0.0017"]])
step = mpf(10) ** -20


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def arm(u):
    height = sqrt(sum(axis * x * x for axis, x in zip(axes, u)))
    return [-axis * x / height for axis, x in zip(axes, u)]


def rates(state):
    w, u = state[:3], state[3:]
    du, rho = cross(u, w), arm(u)
    ahead, behind = (arm([x + s * step * dx for x, dx in zip(u, du)]) for s in (1, -1))
    drho = [(x - y) / (2 * step) for x, y in zip(ahead, behind)]
    v = cross(rho, w)

    def left(dw):
        dv = [x + y for x, y in zip(cross(drho, w), cross(rho, dw))]
        force = [m * (x + y + g * z) for x, y, z in zip(dv, cross(w, v), u)]
        momentum = list(inertia * matrix(w))
        turned = [x + y for x, y in zip(inertia * matrix(dw), cross(w, momentum))]
        return [x - y for x, y in zip(turned, cross(rho, force))]

    rest = left([mpf(0)] * 3)
    columns = [[x - y for x, y in zip(left([mpf(i == j) for j in range(3)]), rest)] for i in range(3)]
    dw = lu_solve(matrix(columns).T, -matrix(rest))
    return list(dw) + du


for spin in (mpf(5), mpf(-5), mpf(1) / 2):
    still = [mpf(0), mpf(0), spin, mpf(0), mpf(0), mpf(1)]
    jacobian = matrix(6, 6)
    for j in range(6):
        moved = [[x + s * step * (i == j) for i, x in enumerate(still)] for s in (1, -1)]
        for i, (ahead, behind) in enumerate(zip(*map(rates, moved))):
            jacobian[i, j] = (ahead - behind) / (2 * step)
    found = [s for s in eig(jacobian, left=False, right=False) if s.imag > mpf(10) ** -9]
    print(nstr(spin, 5), [(nstr(s.real, 16), nstr(s.imag, 16)) for s in sorted(found, key=lambda s: s.imag)])
