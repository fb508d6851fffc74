"""Driven models drawn at random, with their multipliers to 40 digits: driven/random.json.

    python driven_random.py                 # make the file again (needs python-flint, scipy)
    python driven_random.py --check         # compute again, compare with the kept file
    python driven_random.py 300 7 FILE      # more of them, of another seed, to a file

Models are M q'' + D q' + S q + (cubic forces) = f cos(W t) with matrices that depend on cos(W t) and sin(2 W t), of 1 to 4
coordinates: parametric drives, masses that change, gyroscopic terms, friction, forces with a periodic motion, periods of several
cycles. The energies and the matrices are both written down here, from the same numbers, and the matrices alone are used: Taylor
series of 64 terms in numbers of 500 bits, at 32, 64, 128 places of a cycle until two agree to 60 digits; periodic motions by
Newton's method on the map over a period; multipliers by Arb's eigenvalues.
"""

import json
import random
import sys
from fractions import Fraction
from pathlib import Path

import flint
from flint import acb, acb_mat, arb, arb_mat, fmpq

HERE = Path(__file__).parent
ORDER = 64
flint.ctx.prec = 500


def number(x):
    x = Fraction(x)
    return arb(fmpq(x.numerator, x.denominator))


def zeros(n):
    return [[Fraction(0)] * n for _ in range(n)]


def to_mat(rows):
    return arb_mat([[number(x) for x in row] for row in rows])


def mid(matrix):
    return arb_mat([[matrix[i, j].mid() for j in range(matrix.ncols())] for i in range(matrix.nrows())])


class Random:
    """Exact numbers of a model, its text, and its matrices as series in time."""

    def __init__(self, seed):
        draw = random.Random(seed)
        self.n = n = draw.choice([1, 1, 2, 2, 2, 3, 4])
        self.w = draw.choice([Fraction(1), Fraction(2), Fraction(3, 2), Fraction(7, 3), Fraction(5)])
        self.cycles = draw.choice([1, 1, 1, 1, 2, 3, 8])
        few = lambda low, high, by=20: Fraction(draw.randint(int(low * by), int(high * by)), by)
        self.mass, self.mass1 = zeros(n), zeros(n)
        self.stiff, self.stiff1, self.stiff2 = zeros(n), zeros(n), zeros(n)
        self.drag = zeros(n)
        self.gyro = []
        self.quartic = []
        self.force = [Fraction(0)] * n
        strength = draw.choice([Fraction(1, 4), Fraction(1), Fraction(3)])
        for i in range(n):
            self.mass[i][i] = few(1, 3)
            self.stiff[i][i] = few(0.5, 6)
            self.stiff1[i][i] = strength * few(-1, 1)
        for i in range(n - 1):
            j = i + 1
            if draw.random() < 0.4:
                self.mass[i][j] = self.mass[j][i] = few(-0.4, 0.4)
            k, k1 = few(0.1, 2), strength * few(-0.5, 0.5)
            for own, by in ((self.stiff, k), (self.stiff1, k1)):
                own[i][i] += by
                own[j][j] += by
                own[i][j] -= by
                own[j][i] -= by
        if draw.random() < 0.3:
            i = draw.randrange(n)
            self.mass1[i][i] = self.mass[i][i] * few(0.05, 0.3)
        if draw.random() < 0.4:
            i = draw.randrange(n)
            self.stiff2[i][i] = strength * few(-1, 1)
        if n > 1 and draw.random() < 0.4:
            self.gyro.append((0, 1, few(0.1, 1.5), few(0, 0.8)))
        if draw.random() < 0.4:
            for i in range(n):
                self.drag[i][i] = few(0.05, 0.5) if draw.random() < 0.8 else Fraction(0)
        if draw.random() < 0.35:
            self.force = [few(-1, 1) for _ in range(n)]
            self.cycles = 1
            for i in range(n):
                self.quartic.append((i, None, few(0.05, 0.6)))
            if n > 1:
                self.quartic.append((0, 1, few(0.05, 0.6)))
        self.forced = any(self.force)

    def text(self, guess=None):
        n, names = self.n, [f"x{i + 1}" for i in range(self.n)]
        drive, fast = f"cos({self.w}*t)", f"sin({2 * self.w}*t)"
        kinetic, potential, drag = [], [], []
        for i in range(n):
            for j in range(n):
                if self.mass[i][j] or self.mass1[i][j]:
                    kinetic.append(f"1/2*({self.mass[i][j]} + ({self.mass1[i][j]})*{drive})*{names[i]}'*{names[j]}'")
                own = f"({self.stiff[i][j]}) + ({self.stiff1[i][j]})*{drive} + ({self.stiff2[i][j]})*{fast}"
                if any(m[i][j] for m in (self.stiff, self.stiff1, self.stiff2)):
                    potential.append(f"1/2*({own})*{names[i]}*{names[j]}")
            if self.drag[i][i]:
                drag.append(f"1/2*({self.drag[i][i]})*{names[i]}'^2")
            if self.force[i]:
                potential.append(f"({-self.force[i]})*{names[i]}*{drive}")
        for i, j, g, b in self.gyro:
            kinetic.append(f"1/2*{g}*(1 + {b}*{drive})*({names[i]}*{names[j]}' - {names[j]}*{names[i]}')")
        for i, j, a in self.quartic:
            inner = names[i] if j is None else f"({names[i]} - {names[j]})"
            potential.append(f"1/4*({a})*{inner}^4")
        lines = ["coord " + ", ".join(names), "T = " + " + ".join(kinetic), "V = " + " + ".join(potential)]
        if drag:
            lines.append("dissipation = " + " + ".join(drag))
        lines.append(f"period {self.cycles}*2*pi/({self.w})")
        if guess:
            lines += [f"guess {name} = {x}" for name, x in zip(names, guess)]
        return "\n".join(lines)

    def matrices(self, t):
        """Coefficients of M, D, S by s at t + s."""
        n, w = self.n, number(self.w)
        c, s2 = waves(w, t)[0], waves(2 * w, t)[1]
        parts = {k: to_mat(getattr(self, k)) for k in ("mass", "mass1", "stiff", "stiff1", "stiff2", "drag")}
        zero = arb_mat(n, n)
        mass, drag, stiff = [], [], []
        for k in range(ORDER):
            first = k == 0
            dc = c[k + 1] * (k + 1)
            mass.append((parts["mass"] if first else zero) + parts["mass1"] * c[k])
            own = (parts["drag"] if first else zero) + parts["mass1"] * dc
            back = (parts["stiff"] if first else zero) + parts["stiff1"] * c[k] + parts["stiff2"] * s2[k]
            for i, j, g, b in self.gyro:
                turn = zeros(n)
                turn[i][j], turn[j][i] = Fraction(-1), Fraction(1)
                turn, g, b = to_mat(turn), number(g), number(b)
                own = own + turn * (g * ((1 if first else 0) + b * c[k]))
                back = back + turn * (g * b * dc / 2)
            drag.append(own)
            stiff.append(back)
        return mass, drag, stiff, c

    def step(self, t, h, x, v):
        """The state after h and its derivative by the state at t."""
        n = self.n
        mass, drag, stiff, c = self.matrices(t)
        inverse = mass[0].inv()
        force = arb_mat([[number(f)] for f in self.force])
        xs, vs = [x], [v]
        # Deviations: n rows, 2 n columns.
        ys = [arb_mat(n, 2 * n)]
        us = [arb_mat(n, 2 * n)]
        for i in range(n):
            ys[0][i, i] = 1
            us[0][i, n + i] = 1
        cubes = [[] for _ in self.quartic]
        slopes = [[] for _ in self.quartic]
        inner = [[] for _ in self.quartic]
        accelerations, turned = [], []
        for k in range(ORDER - 1):
            own, other = arb_mat(n, 1), arb_mat(n, 2 * n)
            if self.forced:
                own = own + force * c[k]
                own = own - sum((drag[j] * vs[k - j] + stiff[j] * xs[k - j] for j in range(k + 1)), arb_mat(n, 1))
                for at, (i, j, a) in enumerate(self.quartic):
                    y = inner[at]
                    y.append(xs[k][i, 0] - (xs[k][j, 0] if j is not None else 0))
                    square = sum((y[p] * y[k - p] for p in range(k + 1)), arb(0))
                    slopes[at].append(square)
                    cube = sum((slopes[at][p] * y[k - p] for p in range(k + 1)), arb(0)) * number(a)
                    cubes[at].append(cube)
                    own[i, 0] = own[i, 0] - cube
                    if j is not None:
                        own[j, 0] = own[j, 0] + cube
            other = other - sum((drag[j] * us[k - j] + stiff[j] * ys[k - j] for j in range(k + 1)), arb_mat(n, 2 * n))
            for at, (i, j, a) in enumerate(self.quartic):
                for column in range(2 * n):
                    total = arb(0)
                    for p in range(k + 1):
                        y = ys[k - p][i, column] - (ys[k - p][j, column] if j is not None else 0)
                        total += slopes[at][p] * y
                    total *= 3 * number(a)
                    other[i, column] = other[i, column] - total
                    if j is not None:
                        other[j, column] = other[j, column] + total
            for p in range(1, k + 1):
                own = own - mass[p] * accelerations[k - p]
                other = other - mass[p] * turned[k - p]
            accelerations.append(mid(inverse * own))
            turned.append(mid(inverse * other))
            xs.append(mid(vs[k] / (k + 1)))
            vs.append(mid(accelerations[k] / (k + 1)))
            ys.append(mid(us[k] / (k + 1)))
            us.append(mid(turned[k] / (k + 1)))
        total = lambda terms: mid(sum((term * h**k for k, term in enumerate(terms)), terms[0] * 0))
        slope = arb_mat(2 * n, 2 * n)
        y, u = total(ys), total(us)
        for i in range(n):
            for j in range(2 * n):
                slope[i, j], slope[n + i, j] = y[i, j], u[i, j]
        return total(xs), total(vs), slope

    def trip(self, places, x, v):
        """Over one cycle."""
        period = (2 * arb.pi() / number(self.w)).mid()
        h = (period / places).mid()
        slope = to_mat([[Fraction(int(i == j)) for j in range(2 * self.n)] for i in range(2 * self.n)])
        for k in range(places):
            x, v, own = self.step((h * k).mid(), h, x, v)
            slope = mid(own * slope)
        return x, v, slope


def waves(w, t):
    angle = w * t
    s, c = angle.sin().mid(), angle.cos().mid()
    cosines, sines, power = [], [], arb(1)
    for k in range(ORDER + 1):
        cosines.append((power * [c, -s, -c, s][k % 4]).mid())
        sines.append((power * [s, c, -s, -c][k % 4]).mid())
        power = (power * w / (k + 1)).mid()
    return cosines, sines


def shoot(model):
    """A periodic motion in doubles, from rest at 0; None where Newton's method is lost."""
    import numpy as np
    from scipy.integrate import solve_ivp

    n, w = model.n, float(model.w)
    flat = lambda name: np.array([[float(x) for x in row] for row in getattr(model, name)])
    mass, mass1, drag = flat("mass"), flat("mass1"), flat("drag")
    stiff, stiff1, stiff2 = flat("stiff"), flat("stiff1"), flat("stiff2")
    force = np.array([float(f) for f in model.force])

    def right(t, u):
        x, v = u[:n], u[n:]
        c, s = np.cos(w * t), np.sin(w * t)
        total = force * c - drag @ v - (stiff + stiff1 * c + stiff2 * np.sin(2 * w * t)) @ x + mass1 @ v * w * s
        for i, j, g, b in model.gyro:
            g, b = float(g), float(b)
            rate = g * (1 + b * c)
            total[i] += rate * v[j] - g * b * w * s * x[j] / 2
            total[j] -= rate * v[i] - g * b * w * s * x[i] / 2
        for i, j, a in model.quartic:
            y = x[i] - (x[j] if j is not None else 0)
            total[i] -= float(a) * y**3
            if j is not None:
                total[j] += float(a) * y**3
        return np.concatenate([v, np.linalg.solve(mass + mass1 * c, total)])

    def image(u):
        return solve_ivp(right, (0, 2 * np.pi / w), u, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]

    u = np.zeros(2 * n)
    for _ in range(40):
        there = image(u)
        jacobian = np.array([(image(u + 1e-6 * e) - there) / 1e-6 for e in np.eye(2 * n)]).T - np.eye(2 * n)
        step = np.linalg.solve(jacobian, there - u)
        u = u - step * min(1.0, 1.0 / max(1e-9, np.linalg.norm(step)))
        if np.linalg.norm(step) < 1e-9:
            return u
    return None


def digits(x):
    return x.mid().str(45, radius=False)


def reference(seed):
    model = Random(seed)
    n = model.n
    zero = arb_mat(n, 1)
    x, v, guess = zero, zero, None
    if model.forced:
        start = shoot(model)
        if start is None or max(abs(start)) > 20:
            return None
        guess = [f"{value:.6f}" for value in start[:n]]
        x = arb_mat([[arb(value)] for value in start[:n]])
        v = arb_mat([[arb(value)] for value in start[n:]])
        for turn in range(6):
            there = model.trip(64, x, v)
            jacobian = there[2] - to_mat([[Fraction(int(i == j)) for j in range(2 * n)] for i in range(2 * n)])
            rest = arb_mat([[there[0][i, 0] - x[i, 0]] for i in range(n)] + [[there[1][i, 0] - v[i, 0]] for i in range(n)])
            step = jacobian.inv() * rest
            x = mid(arb_mat([[x[i, 0] - step[i, 0]] for i in range(n)]))
            v = mid(arb_mat([[v[i, 0] - step[n + i, 0]] for i in range(n)]))
            size = max(float(abs(step[i, 0]).upper()) for i in range(2 * n))
            if size < 1e-60:
                break
        assert size < 1e-60, seed
    off = lambda a, b: max(
        float((abs(a[i, j] - b[i, j]) / (1 + abs(b[i, j]))).upper()) for i in range(a.nrows()) for j in range(a.ncols())
    )
    places, fine = 32, model.trip(32, x, v)
    while places < 512:
        places, coarse, fine = 2 * places, fine, model.trip(2 * places, x, v)
        if max(off(a, b) for a, b in zip(coarse, fine)) < 1e-60:
            break
    assert max(off(a, b) for a, b in zip(coarse, fine)) < 1e-60, seed
    values = acb_mat(fine[2]).eig(algorithm="approx")
    values = [value**model.cycles for value in values]
    moduli = [abs(value) for value in values]
    tiny = arb("1e-30")
    largest = max(moduli, key=lambda m: float(m.log().mid()))
    conservative = not any(model.drag[i][i] for i in range(n))
    if largest.mid() > 1 + tiny:
        stable = False
    elif conservative:
        close = any(abs(a - b).mid() < 1e-12 for i, a in enumerate(values) for b in values[:i])
        stable = None if close else True
    else:
        stable = True if largest.mid() < 1 - tiny else None
    return {
        "text": model.text(guess),
        "stable": stable,
        "place": [digits(x[i, 0]) for i in range(n)],
        "velocities": [digits(v[i, 0]) for i in range(n)],
        "multipliers": [
            [digits(z.real), digits(z.imag) if abs(z.imag).mid() > tiny * abs(z).mid() else "0"] for z in values
        ],
    }


def draw(count, seed):
    found, place = [], 0
    while len(found) < count:
        own = reference(seed * 100000 + place)
        place += 1
        if own:
            found.append(own)
    return found


def main():
    path = HERE / "driven/random.json"
    how = "driven_random.py: Taylor series of 64 terms in numbers of 500 bits"
    if len(sys.argv) == 4:
        models = draw(int(sys.argv[1]), int(sys.argv[2]))
        Path(sys.argv[3]).write_text(json.dumps({"how": how, "models": models}, indent=1) + "\n")
        return
    written = json.dumps({"how": how, "models": draw(40, 1)}, indent=1) + "\n"
    if "--check" in sys.argv:
        same = path.exists() and path.read_text() == written
        print("random.json", "same" if same else "DIFFERS")
        sys.exit(0 if same else 1)
    path.write_text(written)


if __name__ == "__main__":
    main()
