"""References of tests/motions/motion.rs, to 40 digits (a disc to 23), by means that share nothing with the library.

    python3 tests/reference/motion.py > tests/reference/motion.json

Closed forms where there are any (Jacobi's elliptic functions for the pendulum, Kepler's equation for the planet, exponentials for
what is linear, parabolas and arcs of circles between kinks); the double pendulum and a chain by Taylor series of order 60 at 60 digits (of
order 80 at 80 digits where the pendulum is chaotic), their equations written by hand; a rolling disc by mpmath's odefun.
"""

import json

from mpmath import acos, asin, cos, cosh, ellipfun, exp, findroot, floor, log, mp, mpf, nstr, odefun, pi, quad, sin, sqrt, tan, tanh, workdps

mp.dps = 60


def digits(values):
    return [nstr(x, 40) for x in values]


def pendulum(g, l, start, times):
    """sin(theta/2) = k cd(w t | k^2) from rest (Whittaker, Analytical Dynamics, section 44)."""
    w, k = sqrt(g / l), sin(start / 2)
    rows = []
    for t in times:
        cd = ellipfun("cd", w * t, m=k * k)
        speed = -w * (1 - k * k) * ellipfun("sd", w * t, m=k * k) * ellipfun("nd", w * t, m=k * k)
        theta = 2 * asin(k * cd)
        rows.append(digits([theta, 2 * k * speed / sqrt(1 - (k * cd) ** 2)]))
    return rows


def kepler(mu, a, e, times):
    """From the pericentre, in the plane."""
    n = sqrt(mu / a**3)
    rows = []
    for t in times:
        mean = n * t
        ecc = findroot(lambda x: x - e * sin(x) - mean, mean + e * sin(mean))
        x, y = a * (cos(ecc) - e), a * sqrt(1 - e * e) * sin(ecc)
        rate = n / (1 - e * cos(ecc))
        rows.append(digits([x, y, -a * sin(ecc) * rate, a * sqrt(1 - e * e) * cos(ecc) * rate]))
    return rows


def damped(k, c, start, times):
    """x'' + c x' + k x = 0 from rest."""
    w = sqrt(k - c * c / 4)
    rows = []
    for t in times:
        decay = exp(-c * t / 2)
        x = start * decay * (cos(w * t) + c / (2 * w) * sin(w * t))
        v = -start * decay * k / w * sin(w * t)
        rows.append(digits([x, v]))
    return rows


def driven(k, f, w, times):
    """x'' + k x = f cos(w t) from rest at 0."""
    o = sqrt(k)
    size = f / (k - w * w)
    return [digits([size * (cos(w * t) - cos(o * t)), size * (o * sin(o * t) - w * sin(w * t))]) for t in times]


def free_fall(g, height, times):
    return [digits([height - g * t * t / 2, -g * t]) for t in times]


def bounce(times):
    """x'' = -sign(x) from rest at 1: parabolas, each of them gone through in 2 sqrt 2."""
    rows, half = [], 2 * sqrt(mpf(2))
    for t in times:
        number = int(floor((t + half / 2) / half))
        s = t - number * half
        sign = (-1) ** number
        rows.append(digits([sign * (1 - s * s / 2), -sign * s]))
    return rows


def edge(place, start, times):
    """x'' = -x - sign(x - place) from rest, arcs about -1 above the place and about 1 below it."""
    t, x, v, todo, rows = mpf(0), start, mpf(0), list(times), []
    side = 1 if x > place else -1
    while todo:
        centre = mpf(-side)
        size = sqrt((x - centre) ** 2 + v * v)
        # x = centre + size cos(s + phase), v = -size sin(s + phase)
        phase = acos((x - centre) / size) if v <= 0 else -acos((x - centre) / size)
        angle = acos((place - centre) / size)
        leaves = [a - phase + 2 * pi * k for a in (angle, -angle) for k in range(3)]
        leave = min(s for s in leaves if s > mpf(10) ** -40)
        while todo and todo[0] <= t + leave:
            s = todo.pop(0) - t
            rows.append(digits([centre + size * cos(s + phase), -size * sin(s + phase)]))
        x, v, t = place, -size * sin(leave + phase), t + leave
        side = 1 if v > 0 else -1
    return rows


def drag(start, times, order=60):
    """x'' = -x - |x'| x' from rest, by Taylor series from one turning point to the next."""

    def expand(x, v, sign):
        xs, vs = [x], [v]
        for k in range(order):
            square = sum(vs[j] * vs[k - j] for j in range(k + 1))
            xs.append(vs[k] / (k + 1))
            vs.append((-xs[k] - sign * square) / (k + 1))
        return xs, vs

    def at(row, h):
        total = mpf(0)
        for c in reversed(row):
            total = total * h + c
        return total

    t, x, v, rows, todo = mpf(0), start, mpf(0), [], list(times)
    sign = -1 if x > 0 else 1
    while todo:
        xs, vs = expand(x, v, sign)
        h = mpf(1) / 16
        end = at(vs, h)
        turns = end * sign < 0
        if turns:
            h = findroot(lambda s: at(vs, s), (0 if v else h / 2, h), solver="anderson" if v else "secant", tol=mpf(10) ** -110)
        while todo and todo[0] <= t + h:
            s = todo.pop(0) - t
            rows.append(digits([at(xs, s), at(vs, s)]))
        x, v, t = at(xs, h), mpf(0) if turns else at(vs, h), t + h
        if turns:
            sign = -sign
    return rows


def switched(times):
    """x'' + x = tanh(50 sin t) from rest at 0: a convolution with the sine."""
    rows = []
    for t in times:
        ends = {mpf(0), t}
        for k in range(int(t / pi) + 2):
            for off in (-0.6, -0.2, -0.06, -0.02, 0, 0.02, 0.06, 0.2, 0.6):
                place = k * pi + mpf(off)
                if 0 < place < t:
                    ends.add(place)
        ends = sorted(ends)
        force = lambda s: tanh(50 * sin(s))
        rows.append(digits([quad(lambda s: f(t - s) * force(s), ends) if t else t for f in (sin, cos)]))
    return rows


def double_pendulum(g, start, times, order=60, tolerance=-55):
    """Masses and lengths 1, from rest. c = cos(p - q), s = sin(p - q):
    2 p'' + c q'' + s q'^2 + 2 g sin p = 0,  c p'' + q'' - s p'^2 + g sin q = 0."""

    def conv(a, b, k):
        return sum(a[j] * b[k - j] for j in range(k + 1))

    def next_pair(sine, cosine, angle, k):
        sine.append(sum(j * angle[j] * cosine[k - j] for j in range(1, k + 1)) / k)
        cosine.append(-sum(j * angle[j] * sine[k - j] for j in range(1, k + 1)) / k)

    def expand(state):
        p, q, u, v = ([x] for x in state)
        d = [p[0] - q[0]]
        s, c = [sin(d[0])], [cos(d[0])]
        sp, cp, sq, cq = [sin(p[0])], [cos(p[0])], [sin(q[0])], [cos(q[0])]
        uu, vv, a, b = [], [], [], []
        for k in range(order):
            if k:
                d.append(p[k] - q[k])
                next_pair(s, c, d, k)
                next_pair(sp, cp, p, k)
                next_pair(sq, cq, q, k)
            uu.append(conv(u, u, k))
            vv.append(conv(v, v, k))
            first = -conv(s, vv, k) - 2 * g * sp[k] - sum(c[j] * b[k - j] for j in range(1, k + 1))
            second = conv(s, uu, k) - g * sq[k] - sum(c[j] * a[k - j] for j in range(1, k + 1))
            det = 2 - c[0] ** 2
            a.append((first - c[0] * second) / det)
            b.append((2 * second - c[0] * first) / det)
            u.append(a[k] / (k + 1))
            v.append(b[k] / (k + 1))
            p.append(u[k] / (k + 1))
            q.append(v[k] / (k + 1))
        return p, q, u, v

    def at(rows, h):
        values = []
        for row in rows:
            total = mpf(0)
            for x in reversed(row[: order + 1]):
                total = total * h + x
            values.append(total)
        return values

    t, state, rows, todo = mpf(0), [start[0], start[1], mpf(0), mpf(0)], [], list(times)
    while todo:
        series = expand(state)
        last = max(abs(row[order]) for row in series)
        h = (mpf(10) ** tolerance / last) ** (mpf(1) / order)
        while todo and todo[0] <= t + h:
            rows.append(digits(at(series, todo.pop(0) - t)))
        state, t = at(series, h), t + h
    return rows


def slope(start, times):
    """x'' = exp(-x) from rest: x = start + 2 ln cosh(r t), r^2 = exp(-start)/2, by energy."""
    r = sqrt(exp(-start) / 2)
    return [digits([start + 2 * log(cosh(r * t)), 2 * r * tanh(r * t)]) for t in times]


def critical(c, times):
    """x'' + 2 c x' + c^2 x = 0 from rest at 1."""
    return [digits([(1 + c * t) * exp(-c * t), -c * c * t * exp(-c * t)]) for t in times]


def kicked(start, sharpness, times):
    """x'' + x = exp(-sharpness (t - 3)^2) from rest: a convolution with the sine."""
    rows = []
    for t in times:
        width = 1 / sqrt(mpf(sharpness))
        ends = sorted({min(max(3 + k * width, mpf(0)), t) for k in range(-12, 13, 2)} | {t})
        force = lambda s: exp(-sharpness * (s - 3) ** 2)
        kick = [quad(lambda s: f(t - s) * force(s), ends) if t else t for f in (sin, cos)]
        rows.append(digits([start * cos(t) + kick[0], -start * sin(t) + kick[1]]))
    return rows


def quartic_chain(n, times, order=50, tolerance=-45):
    """V = sum (x_(i+1) - x_i)^4/4 between walls, the first of n masses at 1, by Taylor series. What follows begins with
    powers 2, 8, 26, 80, ... of the time."""

    def conv(a, b, k):
        return sum(a[j] * b[k - j] for j in range(k + 1) if a[j] and b[k - j])

    t, x, v = mpf(0), [mpf(1)] + [mpf(0)] * (n - 1), [mpf(0)] * n
    rows, todo = [], list(times)
    while todo:
        xs, vs = [[c] for c in x], [[c] for c in v]
        ds, squares, cubes = ([[] for _ in range(n + 1)] for _ in range(3))
        for k in range(order):
            for i in range(n + 1):
                left = xs[i - 1][k] if i else mpf(0)
                right = xs[i][k] if i < n else mpf(0)
                ds[i].append(right - left)
                squares[i].append(conv(ds[i], ds[i], k))
                cubes[i].append(conv(squares[i], ds[i], k))
            for i in range(n):
                xs[i].append(vs[i][k] / (k + 1))
                vs[i].append((cubes[i + 1][k] - cubes[i][k]) / (k + 1))
        last = max(abs(row[order]) for row in xs + vs)
        h = min((mpf(10) ** tolerance / last) ** (mpf(1) / order), mpf(1) / 32)

        def at(row, s):
            total = mpf(0)
            for c in reversed(row[: order + 1]):
                total = total * s + c
            return total

        while todo and todo[0] <= t + h:
            rows.append(digits([at(row, todo[0] - t) for row in xs + vs]))
            todo.pop(0)
        x, v, t = [at(row, h) for row in xs], [at(row, h) for row in vs], t + h
    return rows


def disc(m, r, g, start, times):
    """A thin disc that rolls, by Euler's equations about its point of contact in the frame that leans and does not spin."""
    A, C, rolling = m * r * r / 4, m * r * r / 2, m * r * r

    def rates(t, s):
        x, y, psi, th, phi, w1, w2, w3 = s
        spin = w3 * tan(th)
        turn = w2 - spin
        leans = (-A * spin * w3 + (C + rolling) * w3 * w2 + m * g * r * sin(th)) / (A + rolling)
        return [r * turn * cos(psi), r * turn * sin(psi), w3 / cos(th), w1, turn,
                leans, -rolling * w3 * w1 / (C + rolling), (A * spin * w1 - C * w1 * w2) / A]

    with workdps(30):
        at, rows = odefun(rates, 0, start), []
        for t in times:
            state = at(t)
            rows.append([nstr(x, 23) for x in state[:5] + rates(t, state)[:5]])
    return rows


def pulled_chain(n, k, times):
    """n masses between walls, the first at 1: the sum of the modes sin(pi i j/(n + 1)). Mass i begins with the power 2 (i - 1) of the time."""
    modes = range(1, n + 1)
    rates = [2 * sqrt(k) * sin(pi * j / (2 * (n + 1))) for j in modes]
    shapes = [[2 * sin(pi * j / (n + 1)) * sin(pi * i * j / (n + 1)) / (n + 1) for j in modes] for i in modes]
    rows = []
    for t in times:
        at = [cos(w * t) for w in rates]
        speeds = [-w * sin(w * t) for w in rates]
        rows.append(digits([sum(a * b for a, b in zip(shape, part)) for part in (at, speeds) for shape in shapes]))
    return rows


g = mpf(981) / 100
cases = {
    "pendulum": pendulum(g, mpf(1) / 2, mpf(3), [mpf(5) * i / 4 for i in range(5)]),
    "kepler": kepler(mpf(1), mpf(2), mpf(9) / 10, [mpf(20) * i / 5 for i in range(6)]),
    "damped": damped(mpf(4), mpf(1) / 5, mpf(1), [mpf(60) * i / 4 for i in range(5)]),
    "driven": driven(mpf(4), mpf(1) / 2, mpf(19) / 10, [mpf(100) * i / 4 for i in range(5)]),
    "free_fall": free_fall(g, mpf(10), [mpf(2) * i / 2 for i in range(3)]),
    "double_pendulum": double_pendulum(g, [mpf(3) / 10] * 2, [mpf(25) * i for i in range(5)]),
    "bounce": bounce([mpf(20) * i / 4 for i in range(5)]),
    "edge": edge(mpf(1) / 3, mpf(2), [mpf(20) * i / 4 for i in range(5)]),
    "drag": drag(mpf(1), [mpf(10) * i / 4 for i in range(5)]),
    "switched": switched([mpf(30) * i / 3 for i in range(4)]),
    "slope": slope(mpf(700), [mpf(5) * i for i in range(3)]),
    "far_slope": slope(mpf(760), [mpf(5) * i for i in range(3)]),
    "critical": critical(mpf(1), [mpf(500) * i for i in range(3)]),
    "tiny": [digits([mpf("1e-310") * cos(t), -mpf("1e-310") * sin(t)]) for t in (mpf(0), mpf(1) / 2, mpf(1))],
    "kicked": kicked(mpf(0), 10000, [mpf(3) * i for i in range(3)]),
    "kicked_from_one": kicked(mpf(1), 10000, [mpf(3) * i for i in range(3)]),
    "disc": disc(mpf(2), mpf(1) / 2, g, [mpf(0)] * 3 + [mpf(1) / 10, mpf(0), mpf(0), mpf(4), mpf(0)], [mpf(5) * i for i in range(3)]),
    "quartic_chain": quartic_chain(12, [mpf(i) / 2 for i in range(3)]),
}
mp.dps = 80
g = mpf(981) / 100
cases["pulled_chain"] = pulled_chain(20, 100, [mpf(i) / 20 for i in range(5)])
cases["chaotic"] = double_pendulum(g, [mpf(2), mpf(5) / 2], [mpf(10) * i for i in range(2)], 80, -75)
print(json.dumps(cases, indent=1))
