"""References of tests/motion.rs, to 40 digits, by means that share nothing with the library.

    python3 tests/reference/motion.py > tests/reference/motion.json

Closed forms where there are any (Jacobi's elliptic functions for the pendulum, Kepler's equation for the planet, exponentials for
what is linear); the double pendulum by Taylor series of order 60 at 60 digits, its equations written by hand.
"""

import json

from mpmath import acos, asin, cos, ellipfun, exp, findroot, mp, mpf, nstr, sin, sqrt

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


def double_pendulum(g, start, times, order=60):
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
        h = (mpf(10) ** -55 / last) ** (mpf(1) / order)
        while todo and todo[0] <= t + h:
            rows.append(digits(at(series, todo.pop(0) - t)))
        state, t = at(series, h), t + h
    return rows


g = mpf(981) / 100
cases = {
    "pendulum": pendulum(g, mpf(1) / 2, mpf(3), [mpf(5) * i / 4 for i in range(5)]),
    "kepler": kepler(mpf(1), mpf(2), mpf(9) / 10, [mpf(20) * i / 5 for i in range(6)]),
    "damped": damped(mpf(4), mpf(1) / 5, mpf(1), [mpf(60) * i / 4 for i in range(5)]),
    "driven": driven(mpf(4), mpf(1) / 2, mpf(19) / 10, [mpf(100) * i / 4 for i in range(5)]),
    "free_fall": free_fall(g, mpf(10), [mpf(2) * i / 2 for i in range(3)]),
    "double_pendulum": double_pendulum(g, [mpf(3) / 10] * 2, [mpf(25) * i for i in range(5)]),
}
print(json.dumps(cases, indent=1))
