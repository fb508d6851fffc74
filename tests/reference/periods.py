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
