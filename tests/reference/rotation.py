"""Systems with rotation, friction, constraints and rigid bodies."""
import mpmath as mp
from exponents import ZERO, listed, pair, rolled, solved, squares, swings
from mpmath import acos, asin, cos, mpc, mpf, pi, sin, sqrt
from numerics import laguerre, quadratic, square
from register import family, system

g = mpf("9.81")
HOW = ("formula at 200 digits, which agrees with the exponents of the companion matrix "
       "from differences of a hand-written")


def exact(what, why, name=None):
    """Register a system with exponents by formula; `why` says what is exactly 0, and why."""
    return system(f"{HOW} {what}; {why}", name=name)


LAGRANGIAN = "Lagrangian"
FRICTION = "Lagrangian and dissipation function"
FORCED = "Lagrangian and forces"
ROLLING = "Lagrangian and conditions on velocities"
TIED = "Lagrangian with constraints (multipliers, null space of their Jacobian)"
PLAIN = "no term of odd order in the velocities, M and K symmetric: growth is exactly 0 because omega^2 > 0"
CYCLIC = ("the zero exponents are those of cyclic coordinates and their conserved momenta, growth is exactly 0 because "
          "the roots are real")


# Rotating frames and magnetic fields

@exact(LAGRANGIAN, "no friction: growth is exactly 0 because both roots for x + i*y are real")
def foucault_pendulum():
    m, l, W = 28, mpf(67), mpf("7.292115e-5") * sin(mpf("48.846") * pi / 180)
    L = lambda q, v: m * (square(v) / 2 + W * (q[0] * v[1] - q[1] * v[0]) - g / (2 * l) * square(q))
    w = sqrt(g / l + W**2)
    return family("x", "y"), [0, 0], solved(L, swings(w - W, w + W), [0, 0])


@exact(LAGRANGIAN, "no friction: growth is exactly 0 because wc^2 > 2*wz^2 makes all three roots real")
def penning_trap():
    m, e, B, U, d = mpf("1.67262192595e-27"), mpf("1.602176634e-19"), mpf(5), mpf(10), mpf("3.5e-3")
    wc, z2 = e * B / m, e * U / (m * d**2)

    def L(q, v):
        x, y, z = q
        return m * (square(v) / 2 + wc / 2 * (x * v[1] - y * v[0]) - z2 / 4 * (2 * z * z - x * x - y * y))

    assert wc**2 > 2 * z2
    root = sqrt(wc**2 - 2 * z2)
    return family("x", "y", "z"), [0] * 3, solved(L, swings((wc + root) / 2, z2 / (wc + root), sqrt(z2)), [0] * 3)


@exact(LAGRANGIAN, "the double exponent 0 is that of the free centre of the circle (K = 0, G invertible), "
                   "the other pair is ±i*e*B/m")
def cyclotron():
    m, e, B = mpf("9.1093837139e-31"), mpf("1.602176634e-19"), mpf("48e-6")
    # Landau's gauge: the Lagrangian differs from the symmetric one by a total derivative.
    L = lambda q, v: m * square(v) / 2 + e * B * q[0] * v[1]
    return family("x", "y"), [0, 0], solved(L, [ZERO] + swings(e * B / m), [0, 0])


def three_body(mu):
    """The restricted problem in the frame that turns at the rate 1, lengths in units of the distance."""
    def L(q, v):
        x, y, z = q if len(q) == 3 else (*q, mpf(0))
        potential = (1 - mu) / sqrt((x + mu) ** 2 + y**2 + z**2) + mu / sqrt((x - 1 + mu) ** 2 + y**2 + z**2)
        # Coriolis' and the centrifugal term written out.
        return square(v) / 2 + (x * v[1] - y * v[0]) + (x * x + y * y) / 2 + potential
    return L


@exact(LAGRANGIAN, "no friction: growth is exactly 0 because 27*mu*(1 - mu) < 1 makes the roots real")
def earth_moon_l4():
    mu = mpf("0.01215")
    assert 27 * mu * (1 - mu) < 1
    q0 = [1 / mpf(2) - mu, sqrt(mpf(3)) / 2]
    closed = squares(*quadratic(1, -1, mpf(27) / 4 * mu * (1 - mu)))
    return family("x", "y"), q0, solved(three_body(mu), closed, q0)


@exact("Lagrangian, in SI units and in units of the distance and the rate",
       "no friction: growth is exactly 0 because 27*mu*(1 - mu) < 1 makes the roots real")
def earth_moon_l5():
    G, m1, m2, m, a = mpf("6.67430e-11"), mpf("5.9722e24"), mpf("7.346e22"), 1000, mpf("3.844e8")
    mu, W = m2 / (m1 + m2), sqrt(G * (m1 + m2) / a**3)
    q0 = [1 / mpf(2) - mu, -sqrt(mpf(3)) / 2, 0]
    closed = squares(*quadratic(1, -1, mpf(27) / 4 * mu * (1 - mu)), 1)
    solved(three_body(mu), closed, q0)    # asserts the agreement
    # The same in SI units.
    L = lambda q, v: m * (square(v) / 2 + W * (q[0] * v[1] - q[1] * v[0]) + W**2 * (q[0] ** 2 + q[1] ** 2) / 2
                          + G * m1 / sqrt((q[0] + mu * a) ** 2 + q[1] ** 2 + q[2] ** 2)
                          + G * m2 / sqrt((q[0] - (1 - mu) * a) ** 2 + q[1] ** 2 + q[2] ** 2))
    q0 = [a * x for x in q0]
    return family("x", "y", "z"), q0, solved(L, [(0, W * w) for _, w in closed], q0) | {"scale": a}


@exact(LAGRANGIAN, "27*mu*(1 - mu) > 1, so that the exponents are a quadruple ±a ± i*b")
def beyond_rouths_ratio():
    mu = mpf("0.1")
    assert 27 * mu * (1 - mu) > 1
    q0 = [1 / mpf(2) - mu, sqrt(mpf(3)) / 2]
    c = sqrt(mpf(27) / 4 * mu * (1 - mu))    # |s|^2
    growth, omega = sqrt((2 * c - 1) / 4), sqrt((2 * c + 1) / 4)
    return family("x", "y"), q0, solved(three_body(mu), [(growth, omega), (-growth, omega)], q0)


# Steady motions

m_top, l_top, A_top, C_top = mpf("0.2"), mpf("0.05"), mpf("7e-4"), mpf("2e-4")


def sleeping_top(S, fast):
    """Spin of rot_x(a)*rot_y(b)*rot_z(psi), before the last turn: (a' cos b, b', psi' + a' sin b)."""
    mgl = m_top * g * l_top
    L = lambda q, v: (A_top / 2 * ((v[0] * cos(q[1])) ** 2 + v[1] ** 2) + C_top / 2 * (v[2] + v[0] * sin(q[1])) ** 2
                      - mgl * cos(q[0]) * cos(q[1]))
    # A*s^2 - i*C*S*s - m*g*l = 0 for a + i*b
    d = (C_top * S) ** 2 - 4 * A_top * mgl
    assert (d > 0) == fast
    if fast:
        closed = swings((C_top * S - sqrt(d)) / (2 * A_top), (C_top * S + sqrt(d)) / (2 * A_top))
    else:
        growth, omega = sqrt(-d) / (2 * A_top), C_top * S / (2 * A_top)
        closed = [(growth, omega), (-growth, omega)]
    return family("a", "b", "psi"), [0] * 3, solved(L, [ZERO] + closed, [0] * 3, [0, 0, S])


@exact(LAGRANGIAN, CYCLIC)
def sleeping_top_fast():
    return sleeping_top(mpf(200), fast=True)


@exact(LAGRANGIAN, "the zero exponents are those of psi and its conserved momentum, the others a quadruple")
def sleeping_top_slow():
    return sleeping_top(mpf(50), fast=False)


def precessing_top(sign):
    mgl, n, th = m_top * g * l_top, mpf(200), pi / 6
    W = (C_top * n + sign * sqrt((C_top * n) ** 2 - 4 * A_top * mgl * cos(th))) / (2 * A_top * cos(th))
    L = lambda q, v: (A_top / 2 * (v[1] ** 2 + (v[0] * sin(q[1])) ** 2) + C_top / 2 * (v[2] + v[0] * cos(q[1])) ** 2
                      - mgl * cos(q[1]))
    nutation = W**2 - 2 * mgl * cos(th) / A_top + (mgl / (A_top * W)) ** 2
    closed = [ZERO, ZERO] + squares(nutation)
    q0 = [0, th, 0]
    return family("phi", "th", "psi"), q0, solved(L, closed, q0, [W, 0, n - W * cos(th)])


@exact(LAGRANGIAN, CYCLIC)
def precessing_top_slow():
    return precessing_top(-1)


@exact(LAGRANGIAN, CYCLIC)
def precessing_top_fast():
    return precessing_top(1)


@exact(LAGRANGIAN, CYCLIC)
def rotating_spring():
    m, k, l0, W = mpf("0.5"), mpf(80), mpf("0.4"), mpf(6)
    L = lambda q, v: m / 2 * (v[0] ** 2 + (q[0] * v[1]) ** 2) - k / 2 * (q[0] - l0) ** 2
    q0 = [k * l0 / (k - m * W**2), 0]
    return family("r", "phi"), q0, solved(L, [ZERO] + squares(k / m + 3 * W**2), q0, [0, W])


@exact(LAGRANGIAN, CYCLIC)
def conical_pendulum():
    m, l, W = mpf("0.3"), mpf("0.8"), mpf(5)
    th = acos(g / (l * W**2))
    L = lambda q, v: m * l**2 * (v[0] ** 2 + (sin(q[0]) * v[1]) ** 2) / 2 + m * g * l * cos(q[0])
    return family("th", "phi"), [th, 0], solved(L, [ZERO] + squares(W**2 * (1 + 3 * cos(th) ** 2)), [th, 0], [0, W])


@exact(LAGRANGIAN, "K = 0: of the six exponents four are 0 (alpha, beta, psi and its rate), the others are ±i*omega")
def gyroscope_in_gimbals():
    J, B1, B2, B3, A, C, S = map(mpf, ("3e-3", "1e-3", "1.4e-3", "1.1e-3", "2e-3", "3.6e-3", "250"))

    def L(q, v):
        across, along = v[0] * cos(q[1]), v[0] * sin(q[1])
        return (J * v[0] ** 2 + (B1 + A) * across**2 + (B2 + A) * v[1] ** 2 + B3 * along**2
                + C * (v[2] + along) ** 2) / 2

    nutation = C * S / sqrt((J + B1 + A) * (B2 + A))
    closed = [ZERO, ZERO] + swings(nutation)
    return family("alpha", "beta", "psi"), [0] * 3, solved(L, closed, [0] * 3, [0, 0, S])


@exact(LAGRANGIAN, "the zero exponents are those of phi and its conserved momentum, ±i*S that of the whole motion tilted, "
                   "the others are real")
def tennis_racket():
    I1, I2, I3, S = map(mpf, ("1.2e-3", "1.64e-2", "1.54e-2", "10"))

    def L(q, v):
        # Spin of rot_z(phi)*rot_x(b), turned back by rot_y(c).
        x, y, z = v[1], v[0] * sin(q[1]), v[0] * cos(q[1])
        s, c = sin(q[2]), cos(q[2])
        return (I1 * (c * x - s * z) ** 2 + I2 * (y + v[2]) ** 2 + I3 * (s * x + c * z) ** 2) / 2

    closed = [ZERO, (S * sqrt((I2 - I3) * (I3 - I1) / (I1 * I2)), 0)] + swings(S)
    return family("phi", "b", "c"), [0] * 3, solved(L, closed, [0] * 3, [S, 0, 0])


# Friction

@exact(FRICTION, "friction acts on every motion: no exponent is 0 or imaginary")
def damped_pair():
    m, k, c, kappa, d = map(mpf, ("0.5", "20", "0.3", "7", "0.4"))
    L = lambda q, v: m / 2 * square(v) - k / 2 * square(q) - kappa / 2 * (q[1] - q[0]) ** 2
    F = lambda q, v: c / 2 * square(v) + d / 2 * (v[1] - v[0]) ** 2
    closed = pair(m, c, k) + pair(m, c + 2 * d, k + 2 * kappa)
    return family("x1", "x2"), [0, 0], solved(L, closed, [0, 0], F=F)


@exact(FRICTION, "here the formula is the quartic (m1*s^2 + c*s + k1 + k2)*(m2*s^2 + c*s + k2) = (c*s + k2)^2, "
                 "its roots by mpmath's polyroots; none is 0 or imaginary")
def vibration_absorber():
    m1, m2, k1, k2, c = map(mpf, (10, 1, 1000, 80, 3))
    L = lambda q, v: (m1 * v[0] ** 2 + m2 * v[1] ** 2 - k1 * q[0] ** 2 - k2 * (q[1] - q[0]) ** 2) / 2
    F = lambda q, v: c / 2 * (v[1] - v[0]) ** 2
    quartic = [m1 * m2, (m1 + m2) * c, m1 * k2 + m2 * (k1 + k2), c * k1, k1 * k2]
    roots = mp.polyroots(quartic, maxsteps=400, extraprec=400)
    closed = [(mp.re(z), mp.im(z)) for z in roots if mp.im(z) > 0]
    return family("x1", "x2"), [0, 0], solved(L, closed, [0, 0], F=F)


def damped_one(name, m, k, c):
    assert c * c >= 4 * m * k
    L = lambda q, v: m / 2 * v[0] ** 2 - k / 2 * q[0] ** 2
    F = lambda q, v: c / 2 * v[0] ** 2
    return family(name), [0], solved(L, pair(m, c, k), [0], F=F)


@exact(FRICTION, "omega is exactly 0 because c^2 > 4*J*D: both roots are real")
def overdamped_oscillator():
    return damped_one("phi", mpf(12), mpf(30), mpf(90))


@exact(FRICTION, "omega is exactly 0 because c^2 = 4*m*k in integers: one real root, twice")
def critically_damped_oscillator():
    assert 28**2 == 4 * 2 * 98
    return damped_one("x", mpf(2), mpf(98), mpf(28))


@exact(FRICTION, "no exponent is 0 or imaginary")
def belt_oscillator():
    m, k, c, u = map(mpf, ("0.4", "25", "0.6", "1.5"))
    L = lambda q, v: m / 2 * v[0] ** 2 - k / 2 * q[0] ** 2
    F = lambda q, v: c / 2 * (v[0] - u) ** 2
    q0 = [c * u / k]
    return family("x"), q0, solved(L, pair(m, c, k), q0, F=F)


def whirling_shaft(W):
    m, k, ce, ci = map(mpf, (5, 50000, 30, 20))
    L = lambda q, v: m / 2 * square(v) - k / 2 * square(q)
    F = lambda q, v: ce / 2 * square(v) + ci / 2 * ((v[0] + W * q[1]) ** 2 + (v[1] - W * q[0]) ** 2)
    # z = x + i*y; the exponents of x and y are these two and their conjugates.
    root = mp.sqrt(mpc((ce + ci) ** 2 - 4 * m * k, 4 * m * ci * W))
    roots = [(-(ce + ci) + sign * root) / (2 * m) for sign in (1, -1)]
    assert all(mp.im(z) != 0 for z in roots)
    return family("x", "y"), [0, 0], solved(L, [(mp.re(z), abs(mp.im(z))) for z in roots], [0, 0], F=F)


@exact(FRICTION, "no exponent is 0 or imaginary")
def whirling_shaft_below():
    return whirling_shaft(mpf(120))


@exact(FRICTION, "no exponent is 0 or imaginary")
def whirling_shaft_above():
    return whirling_shaft(mpf(260))


@exact(FRICTION, "K = 0 and c > 0: the exponents are exactly 0 and -c/m, each once")
def boat_coasting():
    m, c = mpf(300), mpf(45)
    L = lambda q, v: m / 2 * v[0] ** 2
    F = lambda q, v: c / 2 * v[0] ** 2
    return family("x"), [0], solved(L, [ZERO, (-c / m, 0)], [0], F=F)


@exact(FRICTION, "no force acts on the centre of mass: 0 is a double exponent with one vector; K has one null vector")
def buffers():
    m1, m2, k, c = map(mpf, (8000, 12000, 400000, 20000))
    L = lambda q, v: (m1 * v[0] ** 2 + m2 * v[1] ** 2) / 2 - k / 2 * (q[1] - q[0]) ** 2
    F = lambda q, v: c / 2 * (v[1] - v[0]) ** 2
    closed = [ZERO] + pair(m1 * m2 / (m1 + m2), c, k)
    return family("x1", "x2"), [0, 0], solved(L, closed, [0, 0], F=F, zero_multiplicity=2)


# Forces that no energy gives

@exact(FORCED, "a + ib, a > 0 and b > 0 by the formula: circulatory forces alone leave quadruples ±a ± ib")
def ziegler_column():
    m, l, k, P = map(mpf, ("2", "0.5", "30", "150"))
    T = lambda q, v: m * l**2 / 2 * (3 * v[0] ** 2 + v[1] ** 2 + 2 * v[0] * v[1] * cos(q[0] - q[1]))
    L = lambda q, v: T(q, v) - k / 2 * (q[0] ** 2 + (q[1] - q[0]) ** 2)
    Q = lambda q, v: [P * l * sin(q[0] - q[1]), mpf(0)]
    # 2 a^2 + (7 k - 2 P l) a + k^2 = 0 with a = m l^2 s^2.
    a = mp.sqrt(mpc((7 * k - 2 * P * l) ** 2 - 8 * k**2)) - (7 * k - 2 * P * l)
    s = mp.sqrt(a / (4 * m * l**2))
    assert mp.re(s) > 0 and mp.im(s) != 0
    return family("phi", 2), [0, 0], solved(L, [(mp.re(s), abs(mp.im(s))), (-mp.re(s), abs(mp.im(s)))], [0, 0], Q=Q)


@exact(FORCED, "no exponent is 0 or imaginary")
def controlled_pendulum():
    m, l, kp, kd = map(mpf, ("0.3", "0.5", "4", "0.2"))
    L = lambda q, v: m * l**2 / 2 * v[0] ** 2 - m * g * l * cos(q[0])
    Q = lambda q, v: [-kp * q[0] - kd * v[0]]
    return family("phi"), [0], solved(L, pair(m * l**2, kd, kp - m * g * l), [0], Q=Q, friction=True)


@exact(FORCED, "no exponent is 0 or imaginary")
def van_der_pol():
    m, k, c, a = map(mpf, ("0.5", "8", "0.6", "0.1"))
    L = lambda q, v: m / 2 * v[0] ** 2 - k / 2 * q[0] ** 2
    Q = lambda q, v: [c * (1 - q[0] ** 2 / a**2) * v[0]]
    return family("x"), [0], solved(L, pair(m, -c, k), [0], Q=Q, friction=True)


@exact(FORCED, PLAIN)
def charge_in_field():
    m, k, qB = map(mpf, ("0.2", "3", "0.7"))
    L = lambda q, v: m / 2 * square(v) - k / 2 * square(q)
    Q = lambda q, v: [qB * v[1], -qB * v[0]]
    # (k - m w^2)^2 = (qB w)^2
    w = [(sign * qB + sqrt(qB**2 + 4 * m * k)) / (2 * m) for sign in (-1, 1)]
    return family("x", "y"), [0, 0], solved(L, swings(*w), [0, 0], Q=Q)


# Conditions on velocities

@exact(ROLLING, "no friction: growth is exactly 0 because omega^2 > 0; the heading and the turn of the disc are free, and it "
       "rests or rolls at any place", name="rolling/disc")
def rolling_disc(m="2", r="0.5", v="2", rim=1):
    m, r, v = map(mpf, (m, r, v))
    A, C = rim * m * r**2 / 4, rim * m * r**2 / 2

    def L(q, u):
        x, y, psi, theta, phi = q
        # The centre is r*(sin theta*(sin psi, -cos psi), cos theta) from where the disc touches.
        cx = u[0] + r * (cos(theta) * u[3] * sin(psi) + sin(theta) * cos(psi) * u[2])
        cy = u[1] + r * (-cos(theta) * u[3] * cos(psi) + sin(theta) * sin(psi) * u[2])
        cz = -r * sin(theta) * u[3]
        turning = A * (u[3] ** 2 + (u[2] * cos(theta)) ** 2) + C * (u[4] + u[2] * sin(theta)) ** 2
        return (m * (cx**2 + cy**2 + cz**2) + turning) / 2 - m * g * r * cos(theta)

    rolls = lambda q, u: [u[0] - r * u[4] * cos(q[2]), u[1] - r * u[4] * sin(q[2])]
    square_of = (C * (C + m * r**2) * (v / r) ** 2 - A * m * g * r) / (A * (A + m * r**2))
    closed = [ZERO] * 4 + squares(square_of)
    return family("x", "y", "psi", "theta", "phi"), [0] * 5, rolled(L, closed, [0] * 5, [v, 0, 0, 0, v / r], rolls)


@exact(ROLLING, "no friction: growth is exactly 0 because omega^2 > 0; heading, turn and place are free", name="rolling/hoop")
def rolling_hoop():
    return rolling_disc("1.2", "0.4", "1.5", 2)


@exact(ROLLING, "no friction: growth is exactly 0 because omega^2 > 0; it rests at the post at any heading", name="rolling/knife_edge")
def knife_edge():
    m, J, k = map(mpf, ("0.8", "0.05", "30"))
    L = lambda q, u: (m * square(u[:2]) + J * u[2] ** 2 - k * square(q[:2])) / 2
    slides = lambda q, u: [sin(q[2]) * u[0] - cos(q[2]) * u[1]]
    return family("x", "y", "th"), [0] * 3, rolled(L, [ZERO] * 2 + squares(k / m), [0] * 3, None, slides)


@exact(ROLLING, "no friction: growth is exactly 0 because omega^2 > 0; it rests at any place", name="rolling/skate_on_spring")
def skate_on_spring():
    m, J, a, k = map(mpf, ("1.5", "0.3", "0.2", "2"))

    def L(q, u):
        cx, cy = u[0] - a * sin(q[2]) * u[2], u[1] + a * cos(q[2]) * u[2]
        return (m * (cx**2 + cy**2) + J * u[2] ** 2 - k * q[2] ** 2) / 2

    slides = lambda q, u: [cos(q[2]) * u[1] - sin(q[2]) * u[0]]
    closed = [ZERO] * 2 + squares(k / (J + m * a**2))
    return family("x", "y", "th"), [0] * 3, rolled(L, closed, [0] * 3, None, slides)


@exact(ROLLING, "no friction: growth is exactly 0 because omega^2 > 0; it rests at the bottom in any orientation", name="rolling/ball_in_paraboloid")
def ball_rolling_in_paraboloid():
    m, r, R = map(mpf, ("0.4", "0.1", "1.5"))

    def spin(q, u):
        # Of rot_x(a)*rot_y(b)*rot_z(c): a' along x, b' along the y axis turned by a, c' along z turned by both.
        a, b, _ = q[2:]
        axis = [sin(b), -sin(a) * cos(b), cos(a) * cos(b)]
        return [u[2] + u[4] * axis[0], u[3] * cos(a) + u[4] * axis[1], u[3] * sin(a) + u[4] * axis[2]]

    L = lambda q, u: (m * square(u[:2]) + mpf(2) / 5 * m * r**2 * square(spin(q, u)) - m * g / R * square(q[:2])) / 2
    rolls = lambda q, u: [u[0] - r * spin(q, u)[1], u[1] + r * spin(q, u)[0]]
    closed = [ZERO] * 3 + squares(*[5 * g / (7 * R)] * 2)
    return family("x", "y", "a", "b", "c"), [0] * 5, rolled(L, closed, [0] * 5, None, rolls)


@system("roots at 200 digits of det(M*s^2 + v*C1*s + g*K0 + v^2*K2) with the matrices of appendix A of Meijaard, "
        "Papadopoulos, Ruina and Schwab (2007), which agree with their numbers; wheels, place and heading are free", name="rolling/bicycle")
def whipple_bicycle():
    v = mpf(5)
    w, c, lean = mpf("1.02"), mpf("0.08"), pi / 10
    rR, mR, IRx, IRy = map(mpf, ("0.3", "2", "0.0603", "0.12"))
    rF, mF, IFx, IFy = map(mpf, ("0.35", "3", "0.1405", "0.28"))
    xB, zB, mB, Bxx, Bxz, Bzz = map(mpf, ("0.3", "-0.9", "85", "9.2", "2.4", "2.8"))
    xH, zH, mH, Hxx, Hxz, Hzz = map(mpf, ("0.9", "-0.7", "4", "0.05892", "-0.00756", "0.00708"))
    m = mR + mB + mH + mF
    xT, zT = (xB * mB + xH * mH + w * mF) / m, (-rR * mR + zB * mB + zH * mH - rF * mF) / m
    Txx = IRx + Bxx + Hxx + IFx + mR * rR**2 + mB * zB**2 + mH * zH**2 + mF * rF**2
    Txz = Bxz + Hxz - mB * xB * zB - mH * xH * zH + mF * w * rF
    Tzz = IRx + Bzz + Hzz + IFx + mB * xB**2 + mH * xH**2 + mF * w**2
    mA = mH + mF
    xA, zA = (xH * mH + w * mF) / mA, (zH * mH - rF * mF) / mA
    Axx = Hxx + IFx + mH * (zH - zA) ** 2 + mF * (rF + zA) ** 2
    Axz = Hxz - mH * (xH - xA) * (zH - zA) + mF * (w - xA) * (rF + zA)
    Azz = Hzz + IFx + mH * (xH - xA) ** 2 + mF * (w - xA) ** 2
    s, k = sin(lean), cos(lean)
    u = (xA - w - c) * k - zA * s
    All = mA * u**2 + Axx * s**2 + 2 * Axz * s * k + Azz * k**2
    Alx = -mA * u * zA + Axx * s + Axz * k
    Alz = mA * u * xA + Axz * s + Azz * k
    mu = c / w * k
    SR, SF = IRy / rR, IFy / rF
    ST, SA = SR + SF, mA * u + mu * m * xT
    M = [[Txx, Alx + mu * Txz], [Alx + mu * Txz, All + 2 * mu * Alz + mu**2 * Tzz]]
    K0 = [[m * zT, -SA], [-SA, -SA * s]]
    K2 = [[0, (ST - m * zT) / w * k], [0, (SA + SF * s) / w * k]]
    C1 = [[0, mu * ST + SF * k + Txz / w * k - mu * m * zT],
          [-(mu * ST + SF * k), Alz / w * k + mu * (SA + Tzz / w * k)]]
    published = [(M[0][1], "2.31941332208709"), (M[1][1], "0.29784188199686"), (K0[1][1], "-0.80329488458618"),
                 (K2[0][1], "76.59734589573222"), (C1[0][1], "33.86641391492494"), (C1[1][1], "1.68540397397560")]
    assert all(abs(own - mpf(their)) < mpf("6e-15") * 10 for own, their in published)
    K = [[g * K0[i][j] + v**2 * K2[i][j] for j in (0, 1)] for i in (0, 1)]
    row = lambda i, j: [M[i][j], v * C1[i][j], K[i][j]]
    times = lambda a, b: [sum(a[i] * b[n - i] for i in range(3) if 0 <= n - i < 3) for n in range(5)]
    determinant = [x - y for x, y in zip(times(row(0, 0), row(1, 1)), times(row(0, 1), row(1, 0)))]
    roots = mp.polyroots(determinant, maxsteps=500, extraprec=2000)
    closed = [(mp.re(z), abs(mp.im(z))) for z in roots if mp.im(z) > -mpf(10) ** -150]
    closed = [(growth, omega if omega > mpf(10) ** -150 else 0) for growth, omega in closed] + [ZERO] * 5
    names = family("x", "y", "psi", "phi", "theta", "delta", "a", "b")
    return names, [0] * 8, listed(closed, [v, 0, 0, 0, 0, 0, -v / rR, -v / rF])


# Constraints

@exact(TIED, PLAIN)
def pendulum_in_x_and_y():
    l, m = mpf("0.5"), mpf("0.2")
    L = lambda q, v: m / 2 * square(v) - m * g * q[1]
    q0 = [0, -l]
    return family("x", "y"), q0, solved(L, squares(g / l), q0, constraints=lambda q: [square(q) - l**2])


@exact(TIED, PLAIN)
def four_bar_linkage():
    a, b, d, ms, mc = map(mpf, ("0.5", "0.4", "0.8", "0.6", "1.1"))

    def L(q, v):
        # The middle of the coupler moves with a*th1'*(cos th1, sin th1) + b/2*psi'*(-sin psi, cos psi).
        T = (ms * a**2 / 6 * (v[0] ** 2 + v[2] ** 2) + mc * b**2 / 24 * v[1] ** 2
             + mc / 2 * (a**2 * v[0] ** 2 + b**2 / 4 * v[1] ** 2 + a * b * v[0] * v[1] * sin(q[0] - q[1])))
        return T + ms * g * a / 2 * (cos(q[0]) + cos(q[2])) + mc * g * (a * cos(q[0]) - b / 2 * sin(q[1]))

    closing = lambda q: [a * sin(q[0]) + b * cos(q[1]) - d - a * sin(q[2]),
                         -a * cos(q[0]) + b * sin(q[1]) + a * cos(q[2])]
    beta = asin((d - b) / (2 * a))
    s, c = sin(beta), cos(beta)
    closed = g * (ms + mc) * (1 + 2 * a / b * s**3) / (a * c * (2 * ms / 3 + mc * (c**2 + s**2 / 3)))
    q0 = [beta, 0, -beta]
    return family("th1", "psi", "th2"), q0, solved(L, squares(closed), q0, constraints=closing)


@exact(TIED, PLAIN)
def swing_seat():
    a, b, m1, m2 = map(mpf, ("1.8", "0.6", "12", "20"))
    L = lambda q, v: (m1 * (v[0] ** 2 + v[2] ** 2) + m2 * (v[1] ** 2 + v[3] ** 2)) / 2 - g * (m1 * q[2] + m2 * q[3])
    # As lengths, not as their squares.
    ties = lambda q: [sqrt(q[0] ** 2 + q[2] ** 2) - a, sqrt((q[1] - b) ** 2 + q[3] ** 2) - a,
                      sqrt((q[1] - q[0]) ** 2 + (q[3] - q[2]) ** 2) - b]
    q0 = [0, b, -a, -a]
    return family("x", 2) + family("y", 2), q0, solved(L, squares(g / a), q0, constraints=ties)


@exact(TIED, PLAIN)
def beads_on_rods():
    n, l, m = 4, mpf("0.25"), mpf("0.1")
    L = lambda q, v: m / 2 * square(v) - m * g * sum(q[n:])

    def ties(q):
        x, y = [mpf(0)] + list(q[:n]), [mpf(0)] + list(q[n:])
        return [sqrt((x[k + 1] - x[k]) ** 2 + (y[k + 1] - y[k]) ** 2) - l for k in range(n)]

    q0 = [0] * n + [-l * (k + 1) for k in range(n)]
    closed = squares(*(g / l * z for z in laguerre(n)))
    return family("x", n) + family("y", n), q0, solved(L, closed, q0, constraints=ties)


@exact(TIED, PLAIN)
def rolling_disc_on_spring():
    m, r, k = mpf("1.2"), mpf("0.15"), mpf(60)
    L = lambda q, v: m / 2 * (v[0] ** 2 + r**2 * v[1] ** 2 / 2) - k / 2 * q[0] ** 2
    closed = squares(2 * k / (3 * m))
    return family("x", "theta"), [0, 0], solved(L, closed, [0, 0], constraints=lambda q: [q[0] / r - q[1]])


@exact(TIED, PLAIN)
def roller_on_incline():
    m, R, k, down = mpf(50), mpf("0.4"), mpf(900), g * sin(pi / 9)
    L = lambda q, v: m / 2 * (v[0] ** 2 + R**2 * v[1] ** 2 / 2) - k / 2 * q[0] ** 2 + m * down * q[0]
    q0 = [m * down / k, m * down / (k * R)]
    return family("s", "phi"), q0, solved(L, squares(2 * k / (3 * m)), q0, constraints=lambda q: [q[0] - R * q[1]])


@exact(TIED, PLAIN)
def ball_rolling_in_bowl():
    R, r, m = mpf("0.3"), mpf("0.02"), mpf("0.26")
    L = lambda q, v: m / 2 * ((R - r) ** 2 * v[0] ** 2 + 2 * r**2 / 5 * v[1] ** 2) + m * g * (R - r) * cos(q[0])
    tie = lambda q: [(R / r - 1) * q[0] - q[1]]
    return family("phi", "chi"), [0, 0], solved(L, squares(5 * g / (7 * (R - r))), [0, 0], constraints=tie)


# Rigid bodies

@exact(LAGRANGIAN, PLAIN)
def roller_on_incline_contact():
    m, k, down = mpf(50), mpf(900), g * sin(pi / 9)
    L = lambda q, v: mpf(3) / 4 * m * v[0] ** 2 - k / 2 * q[0] ** 2 + m * down * q[0]
    return family("s"), [m * down / k], solved(L, squares(2 * k / (3 * m)), [m * down / k])


@exact(LAGRANGIAN, PLAIN)
def cylinder_in_trough_contact():
    R, r, m = mpf(1), mpf("0.1"), 2
    # I = 3/2*m*r^2 about the line of contact.
    L = lambda q, v: m * (mpf(3) / 4 * r**2 * ((R / r - 1) * v[0]) ** 2 + g * (R - r) * cos(q[0]))
    return family("phi"), [0], solved(L, squares(2 * g / (3 * (R - r))), [0])


@exact(LAGRANGIAN, PLAIN)
def physical_pendulum_steiner():
    m, l, s = mpf("0.5"), mpf("0.8"), mpf("0.3")
    # The parts of the rod on both sides of the pivot.
    a, b = l / 2 + s, l / 2 - s
    L = lambda q, v: m * ((a**3 + b**3) / (3 * l) * v[0] ** 2 / 2 + g * (a**2 - b**2) / (2 * l) * cos(q[0]))
    return family("phi"), [0], solved(L, squares(g * s / (l**2 / 12 + s**2)), [0])


@exact(LAGRANGIAN, PLAIN)
def clock_pendulum():
    mr, l, md, r, d = map(mpf, ("0.3", "1.1", "4", "0.09", "0.995"))

    def L(q, v):
        # The disc's centre goes round with d*v while the disc turns with v.
        T = mr * l**2 / 6 * v[0] ** 2 + md / 2 * (d * v[0]) ** 2 + md * r**2 / 4 * v[0] ** 2
        return T + (md * d + mr * l / 2) * g * cos(q[0])

    closed = g * (mr * l / 2 + md * d) / (mr * l**2 / 3 + md * (r**2 / 2 + d**2))
    return family("phi"), [0], solved(L, squares(closed), [0])


@exact(LAGRANGIAN, PLAIN)
def pendulum_from_mesh():
    m, c1, c3, I22 = map(mpf, ("40.97632726", "0.04999999891", "-0.4000000001", "0.5807056258"))
    s2 = c1**2 + c3**2
    L = lambda q, v: (I22 + m * s2) / 2 * v[0] ** 2 - m * g * (c3 * cos(q[0]) - c1 * sin(q[0]))
    q0 = [-mp.atan(c1 / c3)]
    return family("phi"), q0, solved(L, squares(m * g * sqrt(s2) / (I22 + m * s2)), q0)


@exact(LAGRANGIAN, PLAIN)
def box_on_torsion_wire():
    D, m, a, b, c, beta = map(mpf, ("0.02", "1.5", "0.3", "0.2", "0.1", "40"))
    beta *= pi / 180
    # The wire's direction in the box's axes, and what lies across it.
    n = [0, sin(beta), cos(beta)]
    J = m / 12 * sum(square((a, b, c)) * x * x - (k * x) ** 2 for k, x in zip((a, b, c), n))
    L = lambda q, v: J / 2 * v[0] ** 2 - D / 2 * q[0] ** 2
    closed = D / (m / 12 * ((a**2 + c**2) * sin(beta) ** 2 + (a**2 + b**2) * cos(beta) ** 2))
    return family("phi"), [0], solved(L, squares(closed), [0])


@exact(LAGRANGIAN, PLAIN)
def box_on_gimbals():
    m, a, b, c, h, D1, D2 = map(mpf, ("3", "0.4", "0.3", "0.2", "0.05", "2", "5"))
    I = [m / 12 * (b**2 + c**2) + m * h**2, m / 12 * (a**2 + c**2) + m * h**2, m / 12 * (a**2 + b**2)]

    def L(q, v):
        # About the fixed point, in the box's axes.
        w = [v[0] * cos(q[1]), v[1], v[0] * sin(q[1])]
        return (sum(i * x * x for i, x in zip(I, w)) / 2 + m * g * h * cos(q[0]) * cos(q[1])
                - D1 / 2 * q[0] ** 2 - D2 / 2 * q[1] ** 2)

    closed = squares((m * g * h + D1) / I[0], (m * g * h + D2) / I[1])
    return family("roll", "pitch"), [0, 0], solved(L, closed, [0, 0])
