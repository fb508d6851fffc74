"""Systems of one or a few coordinates."""
from mpmath import acos, cos, exp, mpf, pi, sin, sqrt
from numerics import laguerre, newton, quadratic, rate, square, squares
from register import family, system

g = mpf("9.81")


@system("closed form")
def simple_pendulum():
    l, m = 1, 2
    return family("phi"), [0], dict(
        T=lambda q, v: m * l**2 * v[0] ** 2 / 2,
        V=lambda q: m * g * l * (1 - cos(q[0])),
        closed=[g / l])


@system("closed form")
def physical_pendulum():
    m, l, s = mpf("0.5"), mpf("0.8"), mpf("0.3")
    J = m * l**2 / 12 + m * s**2
    return family("φ"), [0], dict(
        T=lambda q, v: J * v[0] ** 2 / 2,
        V=lambda q: -m * g * s * cos(q[0]),
        closed=[m * g * s / J])


@system("closed form")
def tapered_rod():
    L, c, A = mpf("0.8"), mpf("0.6"), 700 * pi * mpf("0.03") ** 2
    mu = A * L**3 * (mpf(1) / 3 - c / 2 + c**2 / 5)
    weight = A * g * L**2 * (mpf(1) / 2 - 2 * c / 3 + c**2 / 4)
    return family("phi"), [0], dict(
        T=lambda q, v: mu * v[0] ** 2 / 2,
        V=lambda q: weight * (1 - cos(q[0])),
        closed=[weight / mu])


@system("closed form")
def spring_pendulum():
    m, k, l0 = 1, 40, mpf("0.5")
    r0 = l0 + m * g / k
    return family("r", "phi"), [r0, 0], dict(
        T=lambda q, v: mpf(m) / 2 * (v[0] ** 2 + q[0] ** 2 * v[1] ** 2),
        V=lambda q: mpf(k) / 2 * (q[0] - l0) ** 2 - m * g * q[0] * cos(q[1]),
        closed=[k / mpf(m), g / r0])


@system("closed form")
def elastic_pendulum():
    m, l = mpf("0.5"), mpf("1.2")
    k = 4 * m * g / l
    return family("r", "phi"), [l, 0], dict(
        T=lambda q, v: m / 2 * (v[0] ** 2 + q[0] ** 2 * v[1] ** 2),
        V=lambda q: k / 2 * (q[0] - l + m * g / k) ** 2 - m * g * q[0] * cos(q[1]),
        closed=[k / m, g / l])


@system("closed form")
def double_pendulum():
    T = lambda q, v: v[0] ** 2 + v[1] ** 2 / 2 + v[0] * v[1] * cos(q[0] - q[1])
    V = lambda q: -2 * g * cos(q[0]) - g * cos(q[1])
    return family("th", 2), [0, 0], dict(T=T, V=V, closed=[(2 - sqrt(2)) * g, (2 + sqrt(2)) * g])


@system("closed form")
def triple_pendulum():
    l, m = mpf("0.4"), mpf("0.25")
    T = lambda q, v: m * l**2 / 2 * sum(
        (3 - max(i, j)) * v[i] * v[j] * cos(q[i] - q[j]) for i in range(3) for j in range(3))
    V = lambda q: -m * g * l * sum((3 - i) * cos(q[i]) for i in range(3))
    return family("th", 3), [0] * 3, dict(T=T, V=V, closed=[g / l * z for z in laguerre(3)])


def coupled_pendulums(m, l, L, k12, k23):
    T = lambda q, v: sum(m[i] * l[i] ** 2 * v[i] ** 2 / 2 for i in range(3))
    V = lambda q: (sum(m[i] * g * l[i] * (1 - cos(q[i])) for i in range(3))
                   + L**2 / 2 * (k12 * (q[1] - q[0]) ** 2 + k23 * (q[2] - q[1]) ** 2))
    return T, V


@system("closed form")
def three_pendulums():
    L, k = mpf("0.3"), 4
    T, V = coupled_pendulums([1, 2, 1], [mpf(1)] * 3, L, k, k)
    return family("phi", 3), [0] * 3, dict(
        T=T, V=V, closed=[g, g + k * L**2, g + 2 * k * L**2], symmetry=["even", "odd", "even"])


@system("differences of T and V")
def three_pendulums_unequal():
    T, V = coupled_pendulums([1, 2, mpf("1.5")], [mpf(1), mpf("0.8"), mpf("1.2")], mpf("0.3"), 4, 7)
    return family("phi", 3), [0] * 3, dict(T=T, V=V)


@system("closed form")
def two_masses_walls():
    m1, m2, k1, k2, k3 = map(mpf, (1, 3, 2, 1, 5))
    a, b = (k1 + k2) / m1, (k2 + k3) / m2
    d = sqrt((a - b) ** 2 / 4 + k2**2 / (m1 * m2))
    return family("x1", "x2"), [0, 0], dict(
        T=lambda q, v: (m1 * v[0] ** 2 + m2 * v[1] ** 2) / 2,
        V=lambda q: (k1 * q[0] ** 2 + k2 * (q[1] - q[0]) ** 2 + k3 * q[1] ** 2) / 2,
        closed=[(a + b) / 2 - d, (a + b) / 2 + d])


@system("closed form")
def two_masses_free():
    m1, m2, k = map(mpf, (1, 3, 2))
    return family("x1", "x2"), [0, 0], dict(
        T=lambda q, v: (m1 * v[0] ** 2 + m2 * v[1] ** 2) / 2,
        V=lambda q: k / 2 * (q[1] - q[0]) ** 2,
        zeros=1, closed=[0, k * (1 / m1 + 1 / m2)])


@system("closed form")
def coupled_oscillators_equal():
    m, l, L, k = 1, 1, mpf("0.25"), mpf("1.6")
    return family("a", "b"), [0, 0], dict(
        T=lambda q, v: m * l**2 * mpf(1) / 2 * (v[0] ** 2 + v[1] ** 2),
        V=lambda q: -m * g * l * (cos(q[0]) + cos(q[1])) + k / 2 * L**2 * (q[0] - q[1]) ** 2,
        closed=[g / l, g / l + 2 * k * L**2 / (m * l**2)], symmetry=["even", "odd"])


def hoop(R, W):
    """Per unit mass and R^2."""
    T = lambda q, v: (v[0] ** 2 + W**2 * sin(q[0]) ** 2) / 2
    V = lambda q: -g / R * cos(q[0])
    return T, V


@system("closed form")
def bead_on_hoop():
    R, W = mpf("0.2"), 5
    T, V = hoop(R, W)
    return family("th"), [0], dict(T=T, V=V, closed=[g / R - W**2])


@system("closed form")
def bead_on_hoop_fast():
    R, W = mpf("0.2"), 10
    T, V = hoop(R, W)
    return family("th"), [acos(g / (W**2 * R))], dict(T=T, V=V, closed=[W**2 - (g / (W * R)) ** 2])


@system("closed form")
def bead_on_hoop_bottom():
    R, W = mpf("0.2"), 10
    T, V = hoop(R, W)
    return family("th"), [0], dict(T=T, V=V, closed=[g / R - W**2])


@system("closed form")
def governor():
    a, m1, m2, W = mpf("0.3"), mpf(1), mpf("0.5"), 10
    th0 = acos((m1 + m2) * g / (m1 * a * W**2))
    T = lambda q, v: (m1 * a**2 * (v[0] ** 2 + W**2 * sin(q[0]) ** 2)
                      + 2 * m2 * a**2 * sin(q[0]) ** 2 * v[0] ** 2)
    V = lambda q: -2 * (m1 + m2) * g * a * cos(q[0])
    return family("th"), [th0], dict(
        T=T, V=V, closed=[m1 * W**2 * sin(th0) ** 2 / (m1 + 2 * m2 * sin(th0) ** 2)])


@system("closed form")
def pendulum_with_moving_support():
    l, m1, m2 = mpf("0.5"), mpf(2), mpf(1)
    T = lambda q, v: ((m1 + m2) * v[0] ** 2 + m2 * (l**2 * v[1] ** 2 + 2 * l * v[0] * v[1] * cos(q[1]))) / 2
    V = lambda q: -m2 * g * l * cos(q[1])
    return family("x", "phi"), [0, 0], dict(T=T, V=V, zeros=1, closed=[0, g * (m1 + m2) / (m1 * l)])


@system("closed form")
def two_pendulums_on_a_cart():
    l, m, M = mpf("0.5"), mpf("0.3"), mpf(1)
    T = lambda q, v: M * v[0] ** 2 / 2 + sum(
        m / 2 * (v[0] ** 2 + 2 * l * v[0] * v[i] * cos(q[i]) + l**2 * v[i] ** 2) for i in (1, 2))
    V = lambda q: -m * g * l * (cos(q[1]) + cos(q[2]))
    return family("X") + family("th", 2), [0] * 3, dict(
        T=T, V=V, zeros=1, closed=[0, g / l, g / l * (1 + 2 * m / M)], symmetry=["even", "odd", "even"])


@system("closed form")
def pendulum_on_spring_cart():
    l, m1, m2, k = mpf("0.5"), mpf(2), mpf(1), mpf(30)
    T = lambda q, v: ((m1 + m2) * v[0] ** 2 + m2 * (l**2 * v[1] ** 2 + 2 * l * v[0] * v[1] * cos(q[1]))) / 2
    V = lambda q: -m2 * g * l * cos(q[1]) + k / 2 * q[0] ** 2
    return family("x", "phi"), [0, 0], dict(
        T=T, V=V, closed=quadratic(m1 * l, -(k * l + (m1 + m2) * g), k * g))


@system("closed form")
def cylinder_in_trough():
    R, r, m = mpf(1), mpf("0.1"), 2
    return family("phi"), [0], dict(
        T=lambda q, v: mpf(3) / 4 * m * (R - r) ** 2 * v[0] ** 2,
        V=lambda q: -m * g * (R - r) * cos(q[0]),
        closed=[2 * g / (3 * (R - r))])


@system("V = -m*g*sin(alpha)*s has a constant slope, so no point is stationary", error="no equilibrium")
def heavy_roller_on_incline():
    return family("s"), None, {}


@system("closed form")
def lc_circuit():
    L, C = mpf("0.01"), mpf("1e-7")
    return family("Q"), [0], dict(
        T=lambda q, v: L * v[0] ** 2 / 2, V=lambda q: q[0] ** 2 / (2 * C), closed=[1 / (L * C)])


@system("closed form")
def lc_coupled():
    L, C, Cm = mpf("0.01"), mpf("1e-7"), mpf("4e-7")
    return family("Q", 2), [0, 0], dict(
        T=lambda q, v: L * (v[0] ** 2 + v[1] ** 2) / 2,
        V=lambda q: (q[0] ** 2 + q[1] ** 2) / (2 * C) + (q[0] - q[1]) ** 2 / (2 * Cm),
        closed=[1 / (L * C), 1 / (L * C) + 2 / (L * Cm)], symmetry=["even", "odd"])


@system("closed form")
def inverted_pendulum():
    l = mpf("0.5")
    return family("phi"), [0], dict(
        T=lambda q, v: l**2 * v[0] ** 2 / 2, V=lambda q: g * l * cos(q[0]), closed=[-g / l])


@system("closed form")
def compound_pendulum_disc():
    m, R, d = mpf("1.5"), mpf("0.2"), mpf("0.15")
    J = m * R**2 / 2 + m * d**2
    return family("phi"), [0], dict(
        T=lambda q, v: J * v[0] ** 2 / 2, V=lambda q: -m * g * d * cos(q[0]), closed=[g * d / (R**2 / 2 + d**2)])


@system("closed form")
def bifilar_pendulum():
    m, a, l = mpf("0.2"), mpf("0.15"), mpf("0.6")
    z = lambda q: [-sqrt(l**2 - (2 * a * sin(q[0] / 2)) ** 2)]
    T = lambda q, v: m * a**2 / 3 * v[0] ** 2 / 2 + m / 2 * square(rate(z, q, v))
    return family("phi"), [0], dict(T=T, V=lambda q: m * g * z(q)[0], closed=[3 * g / l])


@system("closed form")
def torsion_discs():
    J1, J2, J3, k1, k2 = map(mpf, (2, 5, 3, 400, 250))
    T = lambda q, v: (J1 * v[0] ** 2 + J2 * v[1] ** 2 + J3 * v[2] ** 2) / 2
    V = lambda q: (k1 * (q[1] - q[0]) ** 2 + k2 * (q[2] - q[1]) ** 2) / 2
    roots = quadratic(1, -(k1 * (1 / J1 + 1 / J2) + k2 * (1 / J2 + 1 / J3)),
                      k1 * k2 * (J1 + J2 + J3) / (J1 * J2 * J3))
    return family("phi", 3), [0] * 3, dict(T=T, V=V, zeros=1, closed=[0] + roots)


@system("closed form")
def ball_in_bowl():
    R = mpf("0.3")
    T = lambda q, v: (v[0] ** 2 + v[1] ** 2 + ((q[0] * v[0] + q[1] * v[1]) / R) ** 2) / 2
    return family("x", "y"), [0, 0], dict(
        T=T, V=lambda q: g * (q[0] ** 2 + q[1] ** 2) / (2 * R), closed=[g / R, g / R])


@system("closed form")
def rod_on_two_springs():
    m, a, k1, k2 = mpf(10), mpf("0.6"), mpf(500), mpf(800)
    T = lambda q, v: m / 2 * v[0] ** 2 + m * a**2 / 6 * v[1] ** 2
    V = lambda q: k1 / 2 * (q[0] - a * sin(q[1])) ** 2 + k2 / 2 * (q[0] + a * sin(q[1])) ** 2
    return family("y", "theta"), [0, 0], dict(
        T=T, V=V, closed=quadratic(1, -4 * (k1 + k2) / m, 12 * k1 * k2 / m**2))


@system("closed form")
def plate_on_springs():
    m, a, b, c, k = mpf(12), mpf("0.5"), mpf("0.3"), mpf("0.1"), mpf(900)

    def T(q, v):
        # Body-frame spin of Rx(roll)*Ry(pitch): Ry turned back on the roll, plus the pitch.
        w = [v[1] * cos(q[2]), v[2], v[1] * sin(q[2])]
        I = [m / 3 * (b**2 + c**2 / 4), m / 3 * (a**2 + c**2 / 4), m / 3 * (a**2 + b**2)]
        return m / 2 * v[0] ** 2 + sum(I[i] * w[i] ** 2 / 2 for i in range(3))

    def V(q):
        height = lambda x, y: q[0] + y * sin(q[1]) - x * cos(q[1]) * sin(q[2])
        return m * g * q[0] + k / 2 * sum(height(x, y) ** 2 for x in (a, -a) for y in (b, -b))

    return family("z", "roll", "pitch"), [-m * g / (4 * k), 0, 0], dict(
        T=T, V=V, closed=[4 * k / m, 12 * k * b**2 / (m * (b**2 + c**2 / 4)), 12 * k * a**2 / (m * (a**2 + c**2 / 4))])


@system("closed form")
def double_well():
    m, a, b = 1, mpf(3), mpf(2)
    return family("x"), [sqrt(a / b)], dict(
        T=lambda q, v: m * v[0] ** 2 / 2, V=lambda q: -a / 2 * q[0] ** 2 + b / 4 * q[0] ** 4, closed=[2 * a / m])


@system("closed form")
def double_well_barrier():
    m, a, b = 1, mpf(3), mpf(2)
    return family("x"), [0], dict(
        T=lambda q, v: m * v[0] ** 2 / 2, V=lambda q: -a / 2 * q[0] ** 2 + b / 4 * q[0] ** 4, closed=[-a / m])


@system("closed form")
def egg_box_saddle():
    V0, q0, b = mpf(2), mpf(3), mpf("1.5")
    return family("x", "y"), [pi / q0, 0], dict(
        T=lambda q, v: (v[0] ** 2 + v[1] ** 2) / 2,
        V=lambda q: -V0 * (cos(q0 * q[0]) + cos(b * q0 * q[1])),
        closed=[-V0 * q0**2, V0 * (b * q0) ** 2])


@system("equilibrium by Newton's method from the guess; the frequency of the even mode also in closed form")
def charged_pendulums():
    l, m, c = mpf(1), mpf("0.1"), mpf("0.05")
    T = lambda q, v: m * l**2 * (v[0] ** 2 + v[1] ** 2) / 2
    V = lambda q: -m * g * l * (cos(q[0]) + cos(q[1])) + c / (2 * l * sin((q[1] - q[0]) / 2))
    q0 = newton(V, [mpf("-0.3"), mpf("0.3")])
    th = q0[1]
    assert abs(q0[0] + th) < mpf(10) ** -80
    assert abs(m * g * l * sin(th) - c * cos(th) / (4 * l * sin(th) ** 2)) < mpf(10) ** -80
    values = squares("ab", T, V, q0)
    assert min(abs(z - g / l * cos(th)) for z in values) < mpf(10) ** -70
    return family("th", 2), q0, dict(T=T, V=V)


@system("closed form; u and eV of CODATA 2022")
def morse_molecule():
    u, eV, angstrom = mpf("1.66053906892e-27"), mpf("1.602176634e-19"), mpf("1e-10")
    m1, m2, D = mpf("1.008") * u, mpf("34.969") * u, mpf("4.618") * eV
    a, d = mpf("1.869") / angstrom, mpf("1.275") * angstrom
    return family("x1", "x2"), [0, d], dict(
        T=lambda q, v: (m1 * v[0] ** 2 + m2 * v[1] ** 2) / 2,
        V=lambda q: D * (1 - exp(-a * (q[1] - q[0] - d))) ** 2,
        zeros=1, scale=angstrom, closed=[0, 2 * D * a**2 * (1 / m1 + 1 / m2)])


@system("closed form")
def u_tube():
    rho, A, L = mpf(13546), mpf("1.5e-4"), mpf("0.45")
    return family("x"), [0], dict(
        T=lambda q, v: rho * A * L * v[0] ** 2 / 2, V=lambda q: rho * A * g * q[0] ** 2, closed=[2 * g / L])


@system("closed form")
def half_disc_rocking():
    m, R = mpf("0.7"), mpf("0.12")
    e = 4 * R / (3 * pi)
    # About the point of contact the moment is J_c + m*(R^2 + e^2 - 2*R*e*cos(phi)).
    T = lambda q, v: (m * R**2 / 2 - m * e**2 + m * (R**2 + e**2 - 2 * R * e * cos(q[0]))) * v[0] ** 2 / 2
    return family("phi"), [0], dict(
        T=T, V=lambda q: -m * g * e * cos(q[0]), closed=[8 * g / ((9 * pi - 16) * R)])
