"""Reference values for models that are driven periodically: multipliers and the borders of Mathieu's equation.

    python driven.py            # make all files again (some minutes)
    python driven.py --check    # compute again, compare with the kept files

Every system is its equations of motion, written down by hand as they stand in books, never derived from an energy and
never read from a model file. They are linear, u' = A(t) u, and A is a polynomial in t, cos(W t) and 1/(1 + eps cos(W t)); the
coefficients of u about each of many places follow from each other (Taylor series, 80 digits, steps so short that the
terms fall below 1e-75), the monodromy is the product of the steps, and multipliers are roots of its characteristic polynomial.
Numbers of steps n and 2 n agree to 60 digits. Equations that are reached by a periodic motion have it in closed form.

Borders of Mathieu's equation are eigenvalues of the tridiagonal matrices of Fourier coefficients (DLMF 28.4), 60 rows and 80
rows, which agree to 45 digits.
"""

import json
import sys
from pathlib import Path

from mpmath import mp, mpf, mpc, cos, sin, sqrt, pi, matrix, polyroots, log, nstr, eigsy, factorial

mp.dps = 80
HERE = Path(__file__).parent
ORDER = 60


def product(a, b, k):
    return sum((a[j] * b[k - j] for j in range(k + 1)), mpf(0))


def quotient(a, b):
    q = []
    for k in range(len(a)):
        q.append((a[k] - sum((b[j] * q[k - j] for j in range(1, k + 1)), mpf(0))) / b[0])
    return q


def cosine(rate, t, shift=0):
    """Coefficients of cos(rate (t + s) + shift) by s."""
    angle = rate * t + shift
    values = [cos(angle), -sin(angle), -cos(angle), sin(angle)]
    return [values[k % 4] * rate**k / factorial(k) for k in range(ORDER)]


def constant(value):
    return [mpf(value)] + [mpf(0)] * (ORDER - 1)


def combine(*parts):
    """The sum of factor times coefficients."""
    return [sum((f * c[k] for f, c in parts), mpf(0)) for k in range(ORDER)]


def step(entries, n, h):
    """The transition matrix over h, where entries(i, j) are coefficients of A_ij (None for 0)."""
    columns = []
    for start in range(n):
        u = [[mpf(int(i == start))] for i in range(n)]
        for k in range(ORDER - 1):
            nxt = []
            for i in range(n):
                total = mpf(0)
                for j in range(n):
                    if entries[i][j] is not None:
                        total += product(entries[i][j], u[j], k)
                nxt.append(total / (k + 1))
            for i in range(n):
                u[i].append(nxt[i])
        columns.append([sum((c * h**k for k, c in enumerate(row)), mpf(0)) for row in u])
    return matrix([[columns[j][i] for j in range(n)] for i in range(n)])


def monodromy(system, period, n, steps):
    total = mp.eye(n)
    h = period / steps
    for k in range(steps):
        total = step(system(k * h), n, h) * total
    return total


def characteristic(m):
    """Faddeev and Le Verrier."""
    n = m.rows
    coefficients = [mpf(1)]
    power = mp.eye(n)
    for k in range(1, n + 1):
        power = m * power
        c = -sum(power[i, i] for i in range(n)) / k
        coefficients.append(c)
        power = power + c * mp.eye(n)
    return coefficients


def multipliers(m):
    roots = polyroots(characteristic(m), maxsteps=500, extraprec=400)
    return sorted(roots, key=lambda z: (-abs(z), -z.imag))


def second_order(mass_rows):
    """u = (q, q') for q'' = -K(t) q - C(t) q'."""
    k, c = mass_rows
    n = len(k)
    rows = []
    for i in range(n):
        rows.append([None] * n + [constant(1) if i == j else None for j in range(n)])
    for i in range(n):
        row = [None if e is None else [-x for x in e] for e in k[i]]
        row += [None if e is None else [-x for x in e] for e in c[i]]
        rows.append(row)
    return rows


G = mpf("9.81")


def child_on_swing():
    l0, eps = mpf(2), mpf("0.1")
    w = 2 * sqrt(G / l0)

    def system(t):
        c = cosine(w, t)
        length = combine((l0, constant(1)), (l0 * eps, c))
        rate = [-(l0 * eps * w) * x for x in cosine(w, t, -pi / 2)]  # l' = -l0 eps w sin(w t)
        k = quotient(constant(G), length)
        d = quotient([2 * x for x in rate], length)
        return second_order(([[k]], [[d]]))

    return system, 2 * pi / w, 1, "phi'' + 2 l'/l phi' + g/l phi = 0"


def mathieu(a="1", q="1", c="0"):
    a, q, c = mpf(a), mpf(q), mpf(c)

    def system(t):
        k = combine((a, constant(1)), (-2 * q, cosine(mpf(2), t)))
        return second_order(([[k]], [[constant(2 * c)]]))

    return system, pi, 1, "y'' + 2 c y' + (a - 2 q cos 2t) y = 0"


def kapitza_pendulum():
    l, a, w = mpf("0.2"), mpf("0.01"), mpf(300)

    def system(t):
        k = combine((-G / l, constant(1)), (a * w**2 / l, cosine(w, t)))
        return second_order(([[k]], [[None]]))

    return system, 2 * pi / w, 1, "psi'' - (g - a W^2 cos W t)/l psi = 0, psi from upright"


def combination_resonance():
    m, k, kc, eps, w = (mpf(1), mpf(3)), mpf(10), mpf(4), mpf("0.3"), mpf("5.85")

    def system(t):
        coupling = combine((kc, constant(1)), (kc * eps, cosine(w, t)))
        rows = []
        for i in range(2):
            row = []
            for j in range(2):
                sign = 1 if i == j else -1
                own = k if i == j else mpf(0)
                row.append(combine((own / m[i], constant(1)), (sign / m[i], coupling)))
            rows.append(row)
        return second_order((rows, [[None, None], [None, None]]))

    return system, 2 * pi / w, 2, "m_i x_i'' + k x_i + kc (1 + eps cos W t)(x_i - x_j) = 0"


def driven_spring_pendulum():
    l, m, k, a, w = mpf(1), mpf("0.5"), mpf(40), mpf("0.02"), mpf(6)
    # r'' = g - k/m (r - l) - a W² cos W t has the periodic solution l + m g/k + A cos W t.
    amplitude = -a * w**2 / (k / m - w**2)

    def system(t):
        c = cosine(w, t)
        r = combine((l + m * G / k, constant(1)), (amplitude, c))
        rate = [-(amplitude * w) * x for x in cosine(w, t, -pi / 2)]
        gravity = combine((G, constant(1)), (-a * w**2, c))
        swing = quotient(gravity, r)
        drag = quotient([2 * x for x in rate], r)
        return second_order(([[constant(k / m), None], [None, swing]], [[None, None], [None, drag]]))

    start = [l + m * G / k + amplitude, mpf(0)]
    how = "about r = l + m g/k + A cos W t, A = -a W²/(k/m - W²): s'' + k/m s = 0, r phi'' + 2 r' phi' + (g - a W² cos W t) phi = 0"
    return system, 2 * pi / w, 2, how, start


SYSTEMS = {
    "child_on_swing": child_on_swing,
    "mathieu": mathieu,
    "mathieu_damped": lambda: mathieu("1", "0.3", "0.2"),
    "kapitza_pendulum": kapitza_pendulum,
    "combination_resonance": combination_resonance,
    "driven_spring_pendulum": driven_spring_pendulum,
}


def text(x):
    return nstr(mpf(x), 50, min_fixed=-mp.inf, max_fixed=mp.inf, strip_zeros=False)


def reference(name):
    system, period, n, how, *start = SYSTEMS[name]()
    coarse = monodromy(system, period, 2 * n, 24)
    fine = monodromy(system, period, 2 * n, 48)
    assert max(abs(x) for x in (coarse - fine)) < mpf(10) ** -60, name
    found = multipliers(fine)
    for a, b in zip(found, multipliers(coarse)):
        assert abs(a - b) < mpf(10) ** -50, name
    tiny = mpf(10) ** -45
    largest = max(abs(z) for z in found)
    unstable = largest > 1 + tiny
    growth = log(largest) / period if abs(largest - 1) > tiny else mpf(0)
    return {
        "model": name,
        "how": how + "; Taylor series of 60 terms at 48 places of a period, 80 digits",
        "error": "depends on the time explicitly",
        "period": text(period),
        "place": [text(x) for x in (start[0] if start else [pi if name == "kapitza_pendulum" else 0] * n)],
        "multipliers": [
            [text(z.real), text(z.imag if abs(mpc(z).imag) > tiny else 0)] for z in map(mpc, found)
        ],
        "stable": not unstable,
        "growth_rate": text(growth),
    }


# x'' + c x' + (1 + h cos 2t) x + x³ = F cos(W t) or F sin(W t): several motions of one period, each from a guess.
DUFFING = {
    "cosine": {
        "model": "coord x  T = 1/2*x'^2  V = 1/2*x^2 + 1/4*x^4 - 3/10*x*cos(3/2*t)  dissipation = 1/40*x'^2  period 4*pi/3",
        "force": ("0.05", "0", "0.3", "0"),
        "starts": [("", "-0.248", "0.023"), ("guess x = 1  guess x' = 1", "1.307", "0.873"), ("guess x = -1  guess x' = 1", "-1.108", "0.569"), ("guess x' = 2", "1.307", "0.873")],
    },
    "sine": {
        "model": "coord x  T = 1/2*x'^2  V = 1/2*x^2 + 1/4*x^4 - 3/10*x*sin(3/2*t)  period 4*pi/3",
        "force": ("0", "0", "0", "0.3"),
        "starts": [("", "0", "-0.373"), ("guess x' = -3/2", "0", "-1.611"), ("guess x' = 2", "0", "1.895")],
    },
    "parametric": {
        "model": "coord x  T = 1/2*x'^2  V = 1/2*(1 + 2/5*cos(2*t))*x^2 + 1/4*x^4  period 2*pi",
        "force": ("0", "0.4", "0", "0"),
        "starts": [("guess x' = 1/2", "0", "0.543"), ("guess x' = -1", "0", "-0.543")],
    },
}


def over_a_period(force, period, start, steps):
    """The state after a period and its derivative by the initial one."""
    c, h, along, across = map(mpf, force)
    length = period / steps
    state, turned = list(start), mp.eye(2)
    for k in range(steps):
        t = k * length
        spring = combine((mpf(1), constant(1)), (h, cosine(mpf(2), t)))
        drive = combine((along, cosine(mpf(3) / 2, t)), (across, cosine(mpf(3) / 2, t, -pi / 2)))
        x, square, cube = [state[0], state[1]], [], []
        for n in range(ORDER - 2):
            square.append(product(x, x, n))
            cube.append(product(square, x, n))
            rest = drive[n] - product(spring, x, n) - cube[n] - c * (n + 1) * x[n + 1]
            x.append(rest / ((n + 1) * (n + 2)))
        square = [product(x, x, n) for n in range(ORDER)]
        stiffness = combine((mpf(1), spring), (mpf(3), square))
        turned = step(second_order(([[stiffness]], [[constant(c)]])), 2, length) * turned
        state = [
            sum((a * length**n for n, a in enumerate(x)), mpf(0)),
            sum((n * a * length ** (n - 1) for n, a in enumerate(x) if n), mpf(0)),
        ]
    return state, turned


def coexisting():
    cases = []
    for own in DUFFING.values():
        period = 2 * pi if own["force"][1] != "0" else 4 * pi / 3
        for guess, x, v in own["starts"]:
            state, found = matrix([mpf(x), mpf(v)]), None
            for _ in range(9):
                end, turned = over_a_period(own["force"], period, state, 48)
                gap = mp.lu_solve(turned - mp.eye(2), matrix(end) - state)
                state -= gap
            assert max(map(abs, gap)) < mpf(10) ** -60, own
            end, coarse = over_a_period(own["force"], period, state, 40)
            assert max(abs(a - b) for a, b in zip(end, state)) < mpf(10) ** -55, own
            assert max(abs(a) for a in coarse - turned) < mpf(10) ** -50, own
            found = multipliers(turned)
            cases.append(
                {
                    "model": (own["model"] + "  " + guess).strip(),
                    "start": [text(a if abs(a) > mpf(10) ** -50 else 0) for a in state],
                    "multipliers": [[text(z.real), text(z.imag if abs(z.imag) > mpf(10) ** -45 else 0)] for z in map(mpc, found)],
                }
            )
    return cases


def tridiagonal(kind, q, size):
    """The matrices of DLMF 28.4 for even and odd solutions of period pi and 2 pi."""
    even, odd = kind[0] == "a", kind[1] == "1"
    m = mp.zeros(size)
    for k in range(size):
        order = 2 * k + (1 if odd else (0 if even else 2))
        m[k, k] = mpf(order) ** 2
        if k + 1 < size:
            m[k, k + 1] = m[k + 1, k] = q
    if odd:
        m[0, 0] += q if even else -q
    elif even:
        m[0, 1] = m[1, 0] = sqrt(mpf(2)) * q
    return m


def borders(q):
    """a_0..a_10 and b_1..b_10."""
    result = {}
    for size in (40, 50):
        found = {}
        for kind in ("a0", "a1", "b0", "b1"):
            values = sorted(eigsy(tridiagonal(kind, q, size), eigvals_only=True))
            first = {"a0": 0, "a1": 1, "b0": 2, "b1": 1}[kind]
            for k in range(6):
                if first + 2 * k <= 10:
                    found[f"{kind[0]}{first + 2 * k}"] = values[k]
        for name, value in found.items():
            assert name not in result or abs(result[name] - value) < mpf(10) ** -45, (q, name)
        result = found
    return {name: nstr(value, 40, min_fixed=-mp.inf, max_fixed=mp.inf) for name, value in sorted(result.items())}


def main():
    check = "--check" in sys.argv
    files = {f"{name}.json": reference(name) for name in SYSTEMS}
    mp.dps = 60
    files["driven/mathieu_borders.json"] = {
        "how": "eigenvalues of the tridiagonal matrices of DLMF 28.4 with 40 and 50 rows, 60 digits",
        "borders": [
            {"q": q, **borders(mpf(q))} for q in ("-10", "-7.3", "-2.5", "-0.1", "0.5", "1", "4", "10")
        ],
    }
    mp.dps = 80
    files["driven/coexisting.json"] = {
        "how": "Newton's method on the map over a period; Taylor series of 60 terms at 48 places of a period, 80 digits",
        "motions": coexisting(),
    }
    bad = 0
    for name, data in files.items():
        path = HERE / name
        written = json.dumps(data, indent=2, ensure_ascii=False) + "\n"
        if check:
            same = path.exists() and path.read_text() == written
            bad += not same
            print(name, "same" if same else "DIFFERS")
        else:
            path.write_text(written)
            print(name)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
