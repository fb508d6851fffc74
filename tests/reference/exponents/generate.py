"""Exponents of random problems M q'' + D q' + S q = 0 to 40 digits, enclosed by python-flint (Arb).

The matrices come from a seed by the generator that tests/modes/exponents_random.rs has too: entries are exact doubles.
Usage: generate.py OUT FIRST_SEED COUNT KINDS SIZES, e.g. generate.py random.txt 0 200 01234 2-8
"""

import sys
from fractions import Fraction

from flint import acb_mat, arb, ctx, fmpq, fmpq_mat

MASK = (1 << 64) - 1


class Draw:
    def __init__(self, seed):
        self.state = (seed * 2 + 1) & MASK
        for _ in range(4):
            self.entry()

    def entry(self):
        """A multiple of 2^-13 in [-4, 4)."""
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) & MASK
        return Fraction((self.state >> 48) - 32768, 8192)

    def matrix(self, n):
        columns = [[self.entry() for _ in range(n)] for _ in range(n)]
        return [[columns[j][i] for j in range(n)] for i in range(n)]


def gram(a, shift, weight):
    n = len(a)
    return [
        [
            sum(a[k][i] * a[k][j] for k in range(n)) * weight + (shift if i == j else 0)
            for j in range(n)
        ]
        for i in range(n)
    ]


def problem(kind, n, seed):
    draw = Draw(seed * 1000 + n * 10 + kind)
    m = gram(draw.matrix(n), 1, Fraction(1, 16))
    a, b = draw.matrix(n), draw.matrix(n)
    skew = [[a[i][j] - a[j][i] for j in range(n)] for i in range(n)]
    symmetric = [[b[i][j] + b[j][i] for j in range(n)] for i in range(n)]
    if kind == 0:  # gyroscopic, definite
        d, s = skew, gram(b, 1, 1)
    elif kind == 1:  # gyroscopic, indefinite
        d, s = [[4 * x for x in row] for row in skew], symmetric
    elif kind == 2:  # damped
        d, s = gram(a, 0, Fraction(1, 64)), gram(b, 1, 1)
    elif kind == 3:  # anything
        d, s = a, b
    elif kind == 4:  # damped, frequencies over eight decades
        d, s = gram(a, 0, Fraction(1, 64)), gram(b, 1, 1)
        e = [(27 * i) // max(n - 1, 1) for i in range(n)]
        m = [[m[i][j] if i == j else m[i][j] / 2**abs(e[i] - e[j]) / 64 for j in range(n)] for i in range(n)]
        d = [[d[i][j] * Fraction(2) ** min(e[i], e[j]) / 2**abs(e[i] - e[j]) for j in range(n)] for i in range(n)]
        s = [[s[i][j] * Fraction(4) ** min(e[i], e[j]) / 2**abs(e[i] - e[j]) for j in range(n)] for i in range(n)]
    else:
        raise ValueError(kind)
    return m, d, s


def exponents(m, d, s):
    n = len(m)
    q = lambda a: fmpq_mat(n, n, [fmpq(x.numerator, x.denominator) for row in a for x in row])
    inverse = q(m).inv()
    top, low, left = q(m) * 0, inverse * q(s), inverse * q(d)
    rows = []
    for i in range(n):
        rows.append([fmpq(0)] * n + [fmpq(1 if j == i else 0) for j in range(n)])
    for i in range(n):
        rows.append([-low[i, j] for j in range(n)] + [-left[i, j] for j in range(n)])
    for prec in (400, 800, 1600):
        ctx.prec = prec
        a = acb_mat([[arb(x) for x in row] for row in rows])
        try:
            return a.eig()
        except ValueError:
            continue
    raise ValueError("not separated")


def text(x):
    return x.mid().str(40, radius=False)


def main():
    out, first, count, kinds, sizes = sys.argv[1:6]
    least, most = (int(x) for x in sizes.split("-"))
    with open(out, "w") as file:
        for seed in range(int(first), int(first) + int(count)):
            kind = int(kinds[seed % len(kinds)])
            n = least + (seed // len(kinds)) % (most - least + 1)
            values = exponents(*problem(kind, n, seed))
            file.write(f"{kind} {n} {seed}\n")
            for value in values:
                file.write(f"{text(value.real)} {text(value.imag)}\n")


main()
