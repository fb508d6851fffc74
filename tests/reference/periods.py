#!/usr/bin/env python3
"""Make the reference periods, or check the ones that are kept.

    python periods.py            write periods.json
    python periods.py --check    compute again and compare; exit status 1 if anything differs

Needs mpmath.  Nothing here knows Librate: closed forms where there are any (elliptic integrals by the arithmetic-
geometric mean, Gamma functions), else tanh-sinh quadrature over an angle that takes out both turning points, with
60 and with 80 digits, which must agree to 45.  Each case is a model (a file, which is not read here, or a text), what is
asked for, and the period.
"""
import json
import sys
from pathlib import Path

import mpmath
from mpmath import mp, mpf

HERE = Path(__file__).resolve().parent
mp.dps = 200

BEAD = "param k = 2\ncoord x\nlet y = x^2/2\nT = 1/2*(x'^2 + y'^2)\nV = k*y"
COSH = "coord x\nT = 1/2*x'^2\nV = cosh(x)"
# Over a hump that is not in the middle: with E = 0, E - U = (x + 2)(1 - x)((x + 3/10)^2 + 1e-8).
UNEVEN = "coord x\nT = 1/2*x'^2\nV = (x + 2)*(x - 1)*((x + 3/10)^2 + 1e-8)\nguess x = 7/10"
RATIONAL = "coord s\nT = 1/2*s'^2\nV = s^2/(1 + s^2)"


def pendulum(amplitude):
    return 4 * mpmath.sqrt(1 / mpf("9.81")) * mpmath.ellipk(mpmath.sin(amplitude / 2) ** 2)


def rotation(energy):
    """E = phi'^2/2 + g (1 - cos phi): T = 2 k sqrt(1/g) K(k), k^2 = 2 g/E."""
    g = mpf("9.81")
    m = 2 * g / energy
    return 2 * mpmath.sqrt(m / g) * mpmath.ellipk(m)


def quartic(amplitude):
    """4 integral dx/sqrt((A^4 - x^4)/2)"""
    return mpmath.gamma(mpf(1) / 4) ** 2 / mpmath.sqrt(mpmath.pi) / amplitude


def morse(energy):
    D, a, m = mpf(5), mpf(3) / 2, mpf(2)
    return 2 * mpmath.pi / a * mpmath.sqrt(m / (2 * (D - energy)))


def morse_energy(amplitude):
    return 5 * (1 - mpmath.exp(-mpf(3) / 2 * amplitude)) ** 2


def kepler(energy):
    """The radial period of an orbit with E < 0: 2 pi/(-2 E)^(3/2)."""
    return 2 * mpmath.pi / (-2 * energy) ** mpf(1.5)


def quadrature(ratio, low, high, inside=None):
    """With a point `inside` that the integrand peaks at: 2 integral sqrt(1/(2 (E - U))) dx with x = middle + half sin s and E - U = (x - low)(high - x) ratio(x)."""
    def once(digits):
        with mp.workdps(digits):
            if inside is not None:
                ends = [-mpmath.pi / 2, mpmath.asin((inside - (low + high) / 2) * 2 / (high - low)), mpmath.pi / 2]
            middle, half = (low + high) / 2, (high - low) / 2
            f = lambda s: mpmath.sqrt(2 / ratio(middle + half * mpmath.sin(s)))
            if inside is not None:
                # The peak is as narrow as 1e-4: the angle less that of the peak grows as a power.
                total = mpf(0)
                for end in (ends[0], ends[2]):
                    way = end - ends[1]
                    places = [mpf(0)] + [way / 2 ** k for k in range(40, -1, -1)]
                    total += abs(mpmath.quad(lambda s: f(ends[1] + s), places))
                return total
            return mpmath.quad(f, mpmath.linspace(-mpmath.pi / 2, mpmath.pi / 2, 33))
    coarse, fine = once(60), once(80)
    assert abs(coarse - fine) < mpf(10) ** -45 * fine, mpmath.nstr(abs(coarse - fine) / fine)
    return fine


def cubic(amplitude):
    """U(b) - U(x) = (b - x)(x - a)(x - c)/3: a and c are the roots of (b^2 + b x + x^2)/3 + (b + x)/2."""
    b = mpf(amplitude)
    h = b / 3 + mpf(1) / 2
    disc = mpmath.sqrt(h * h - 4 * (b * b / 3 + b / 2) / 3)
    a, c = (-h + disc) * 3 / 2, (-h - disc) * 3 / 2
    # T = 2 integral dx/sqrt(2/3 (b - x)(x - a)(x - c))
    m = (b - a) / (b - c)
    return 2 * mpmath.sqrt(mpf(3) / 2) * 2 / mpmath.sqrt(b - c) * mpmath.ellipk(m)


def double(energy):
    """E - U = (b/4) (x^2 - s)(u - x^2), two wells below 0, one motion over the hump above."""
    a, b = mpf(3), mpf(2)
    E = mpf(energy)
    d = mpmath.sqrt(a * a + 4 * b * E)
    u, s = (a + d) / b, (a - d) / b
    if E < 0:
        # 2 integral_sqrt(s)^sqrt(u) dx/sqrt((b/2)(x^2 - s)(u - x^2)) = 2 sqrt(2/b)/sqrt(u) K(1 - s/u)
        return 2 * mpmath.sqrt(2 / b) / mpmath.sqrt(u) * mpmath.ellipk(1 - s / u)
    return 4 * mpmath.sqrt(2 / b) / mpmath.sqrt(u - s) * mpmath.ellipk(u / (u - s))


def bead(amplitude):
    """M = 1 + x^2, U = x^2: T = 4/sqrt(2) integral sqrt(1 + A^2 sin^2) over a quarter = 4 sqrt((1 + A^2)/2) E(A^2/(1 + A^2))."""
    A = mpf(amplitude)
    return 4 * mpmath.sqrt(1 + A * A) / mpmath.sqrt(2) * mpmath.ellipe(A * A / (1 + A * A))


def cosh(amplitude):
    A = mpf(amplitude)

    def part(y):
        """sinh(y/2)/(y/2)"""
        return mpmath.sinh(y / 2) / (y / 2) if y else mpf(1)
    return quadrature(lambda x: part(A + x) * part(A - x) / 2, -A, A)


def rational(amplitude):
    A = mpf(amplitude)
    return quadrature(lambda x: 1 / ((1 + A * A) * (1 + x * x)), -A, A)


def uneven():
    a = mpf(3) / 10
    return quadrature(lambda x: (x + a) ** 2 + mpf(10) ** -8, mpf(-2), mpf(1), -a)


# At rest on a corner of V.
WEDGE = "coord x\nT = 1/2*x'^2\nV = abs(x)"
ROOF = "param a = 1/3\nparam g = 981/100\ncoord x\nequilibrium x = 2*a\nT = x'^2\nV = g*(abs(x/2 - a) - 7) + abs(x)/4"
SLOPES = "coord x\nT = 1/2*x'^2\nV = 2*abs(x) + x"
PRESSED = "coord x\nT = 1/2*x'^2\nV = 1/2*x^2 + abs(x)"
NOTCH = "coord x\nguess x = 1\nT = 1/2*x'^2\nV = x^2 + 2*abs(x - 1/4)"
CUBE = "coord x\nT = 1/2*x'^2\nV = abs(x)^3"
# Free between two springs, of k = 1 from x = 1 on and of k = 16 from x = -1/2 on.
BALL = "coord x\nT = 1/2*x'^2\nV = 1/8*(x - 1 + abs(x - 1))^2 + 2*(abs(x + 1/2) - x - 1/2)^2"
SHELF = "coord x\nT = 1/2*x'^2\nV = 1/2*x^2 + abs(x - 1/2)/10"
STIFFER = "coord x\nT = 1/2*x'^2\nV = 1/2*x^2 + abs(x)^3"
HEAVIER = "coord x\nT = 1/2*(1 + abs(x - 1/4))*x'^2\nV = 1/2*x^2"
EDGES = "coord x\nT = 1/2*x'^2\nV = 1/2*x^2 + abs(x - 1/2)/10 + abs(2*x - 1)/20 + abs(x + 1/3)/7"


def cube(amplitude):
    """4 integral dx/sqrt(2 (A^3 - x^3))"""
    whole = mpmath.sqrt(mpmath.pi) * mpmath.gamma(mpf(4) / 3) / mpmath.gamma(mpf(5) / 6)
    return 2 * mpmath.sqrt(2 / amplitude) * whole


def ball(energy):
    """Half a period in each spring, and twice the way between them."""
    return mpmath.pi + mpmath.pi / 4 + 3 / mpmath.sqrt(2 * energy)


def shelf(amplitude):
    """Parts of two harmonic motions, about 1/10 and -1/10, that meet at 1/2."""
    upper = amplitude + mpf(1) / 5
    lower = mpmath.sqrt(upper ** 2 - mpf(1) / 5)
    return 2 * (mpmath.pi / 2 + mpmath.asin(mpf(2) / 5 / lower) + mpmath.acos(mpf(3) / 5 / upper))


def heavier():
    """With x = sin u: 2 integral sqrt(M) du."""
    edge = mpmath.asin(mpf(1) / 4)
    f = lambda u: 2 * mpmath.sqrt(1 + abs(mpmath.sin(u) - mpf(1) / 4))
    with mp.workdps(60):
        return mpmath.quad(f, [-mpmath.pi / 2, -1, 0, edge, 1, mpmath.pi / 2])


def pieces(potential, ends, kinks):
    """2 integral dx/sqrt(2 (E - U)) piece by piece, with x = low + s^2 and x = high - s^2 beside the turning points; E - U with
    so many digits that none of those needed cancels."""
    def inverse(place):
        with mp.workdps(500):
            low, high = ends()
            x = place(low, high)
            return 1 / mpmath.sqrt(2 * (potential(high) - potential(x)))
    with mp.workdps(60):
        low, high = ends()
        first, last = (low + kinks[0]) / 2, (kinks[-1] + high) / 2
        quad = lambda f, places: mpmath.quad(f, places, maxdegree=12)
        total = quad(lambda s: 2 * s * inverse(lambda low, _: low + s * s), [0, mpmath.sqrt(first - low)])
        total += quad(lambda s: 2 * s * inverse(lambda _, high: high - s * s), [0, mpmath.sqrt(high - last)])
        return 2 * (total + quad(lambda x: inverse(lambda *_: x), [first] + kinks + [last]))


def edges(amplitude):
    third, half = (lambda: mpf(1) / 3), (lambda: mpf(1) / 2)
    u = lambda x: x * x / 2 + abs(x - half()) / 5 + abs(x + third()) / 7

    def ends():
        high = mpf(2) / 35 + amplitude
        # On the left U = x^2/2 - (1/5 + 1/7) x + 1/10 - 1/21.
        b = mpf(12) / 35
        return b - mpmath.sqrt(b * b - 2 * (mpf(1) / 10 - mpf(1) / 21 - u(high))), high
    return pieces(u, ends, [-mpf(1) / 3, mpf(1) / 2])


def stiffer(amplitude):
    ends = lambda: (-mpf(amplitude) / 10, mpf(amplitude) / 10)
    return pieces(lambda x: x * x / 2 + abs(x) ** 3, ends, [mpf(0)])


def falls(force, height, mass):
    """Down from a height and up again, twice: each 2 sqrt(2 m h)/F."""
    return 2 * mpmath.sqrt(2 * mass * height) / force


def roof(g, height):
    """With m = 2."""
    quarter = mpf(1) / 4
    total = falls(g / 2 + quarter, height, 2)
    behind = height - (g / 2 - quarter) * 2 / 3
    if behind < 0:
        return total + falls(g / 2 - quarter, height, 2)
    fast, slow = mpmath.sqrt(height), mpmath.sqrt(behind)
    return total + 2 * (fast - slow) * mpmath.sqrt(4) / (g / 2 - quarter) + falls(g / 2 + quarter, behind, 2)


def pressed(amplitude):
    """Parts of two harmonic motions about -1 and 1, of amplitude A + 1."""
    return 4 * mpmath.acos(1 / (1 + amplitude))


def notch(amplitude):
    """On the right U = x^2 + 2 x - 1/2, harmonic about -1; on the left x^2 - 2 x + 1/2, about 1; omega^2 = 2."""
    edge = mpf(1) / 4
    high = edge + amplitude
    right = mpmath.acos((edge + 1) / (high + 1))
    energy = high ** 2 + 2 * amplitude
    radius = mpmath.sqrt(energy + mpf(1) / 2)
    return mpmath.sqrt(2) * (right + mpmath.acos((1 - edge) / radius))


def cases():
    pi = mpmath.pi
    for text, value in [
        ("1e-3", mpf("1e-3")), ("1/10", mpf(1) / 10), ("1", mpf(1)), ("pi/2", pi / 2), ("2", mpf(2)), ("3", mpf(3)),
        ("pi - 1e-3", pi - mpf("1e-3")), ("pi - 1e-6", pi - mpf("1e-6")), ("pi - 1e-10", pi - mpf("1e-10")),
        ("pi - 1e-20", pi - mpf("1e-20")), ("pi - 1e-60", pi - mpf("1e-60")),
    ]:
        yield "models/period/pendulum.lag", ["amplitude", text], pendulum(value)
    for text, value in [("20", 20), ("981/50 + 1e-6", mpf("19.620001")),
                        ("981/50 + 1e-15", mpf("19.62") + mpf("1e-15")), ("981/50 + 1e-40", mpf("19.62") + mpf("1e-40")),
                        ("1e6", mpf(10) ** 6)]:
        yield "models/period/pendulum.lag", ["energy", text], rotation(mpf(value))
    for text in ["1e-6", "1", "1000"]:
        yield "models/period/quartic.lag", ["amplitude", text], quartic(mpf(text))
    for text in ["1/10", "1", "5", "20"]:
        value = mpf(1) / 10 if text == "1/10" else mpf(text)
        yield "models/period/morse.lag", ["amplitude", text], morse(morse_energy(value))
    yield "models/period/morse.lag", ["energy", "5 - 1e-8"], morse(5 - mpf("1e-8"))
    for text in ["1/100", "1", "3"]:
        yield "models/period/cycloid.lag", ["amplitude", text], 4 * pi * mpmath.sqrt(2 / mpf("9.81"))
    for text, value in [("1/10", mpf(1) / 10), ("1/4", mpf(1) / 4), ("0.49", mpf("0.49")),
                        ("1/2 - 1e-7", mpf(1) / 2 - mpf("1e-7"))]:
        yield "models/period/cubic.lag", ["amplitude", text], cubic(value)
    for text, value in [("-1", -1), ("-1/10", mpf(-1) / 10), ("-1e-9", -mpf("1e-9")), ("1e-9", mpf("1e-9")), ("-1e-40", -mpf("1e-40")),
                        ("1e-40", mpf("1e-40")), ("1", 1)]:
        yield "models/period/double_well.lag", ["energy", text], double(value)
    for text, value in [("-1/5", mpf(-1) / 5), ("-1/10", mpf(-1) / 10), ("-1/100", mpf(-1) / 100)]:
        yield "models/period/radial.lag", ["energy", text], kepler(value)
    yield UNEVEN, ["energy", "0"], uneven()
    for text in ["1/2", "3"]:
        value = mpf(1) / 2 if text == "1/2" else mpf(text)
        yield BEAD, ["amplitude", text], bead(value)
    yield COSH, ["amplitude", "2"], cosh(2)
    yield COSH, ["amplitude", "30"], cosh(30)
    yield RATIONAL, ["amplitude", "3"], rational(3)
    for text, value in [("1/10", mpf(1) / 10), ("1", mpf(1)), ("1000", mpf(1000))]:
        yield CUBE, ["amplitude", text], cube(value)
    yield BALL, ["amplitude", "3/2"], ball(mpf(1) / 8)
    yield BALL, ["energy", "1e-6"], ball(mpf("1e-6"))
    yield BALL, ["energy", "2"], ball(mpf(2))
    yield SHELF, ["amplitude", "1/3"], 2 * pi
    yield SHELF, ["amplitude", "1"], shelf(mpf(1))
    yield SHELF, ["amplitude", "1e3"], shelf(mpf(1000))
    yield STIFFER, ["amplitude", "1/10"], stiffer(1)
    yield STIFFER, ["amplitude", "7"], stiffer(70)
    yield HEAVIER, ["amplitude", "1"], heavier()
    yield EDGES, ["amplitude", "1"], edges(mpf(1))
    yield EDGES, ["amplitude", "20"], edges(mpf(20))
    yield WEDGE, ["amplitude", "1e-200"], 2 * falls(1, mpf(10) ** -200, 1)
    yield WEDGE, ["amplitude", "1"], 2 * falls(1, mpf(1), 1)
    yield WEDGE, ["energy", "1e6"], 2 * falls(1, mpf(10) ** 6, 1)
    # Forces of g/2 + 1/4 to the right of 2/3, of g/2 - 1/4 as far as 0 and of g/2 + 1/4 behind.
    g = mpf(981) / 100
    yield ROOF, ["amplitude", "1/2"], roof(g, (g / 2 + mpf(1) / 4) / 2)
    yield ROOF, ["amplitude", "3"], roof(g, (g / 2 + mpf(1) / 4) * 3)
    yield SLOPES, ["amplitude", "1"], falls(3, mpf(3), 1) + falls(1, mpf(3), 1)
    for text, value in [("1e-30", mpf(10) ** -30), ("1", mpf(1)), ("1000", mpf(1000))]:
        yield PRESSED, ["amplitude", text], pressed(value)
    for text, value in [("1/10", mpf(1) / 10), ("1", mpf(1))]:
        yield NOTCH, ["amplitude", text], notch(value)


def digits(value):
    return mpmath.nstr(value, 40, strip_zeros=False, min_fixed=-1000, max_fixed=1000)


def text():
    entries = []
    for model, request, period in cases():
        key = "file" if model.endswith(".lag") else "model"
        entries.append(json.dumps({key: model, request[0]: request[1], "period": digits(period)}))
    return "[\n" + ",\n".join(entries) + "\n]\n"


def main():
    path = HERE / "periods.json"
    own = text()
    if "--check" in sys.argv:
        sys.exit(0 if path.read_text() == own else 1)
    path.write_text(own)


if __name__ == "__main__":
    main()
