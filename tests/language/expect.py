"""Writes the expected digits into the headers of the .lag files beside it and in ../problems.

Lines that begin with `#:` are Python; numbers in them are mpmath numbers of 60 digits. They set
`omega` and `growth` (lists), or `omega2` (the eigenvalues), and perhaps `equilibrium`. Everything
is worked out from closed forms or from energies written down again in Python; nothing is taken
from the project itself.
"""

import glob
import io
import os
import sys
import tokenize

import mpmath
from mpmath import mp, mpf, matrix

mp.dps = 80


class I(int):
    """An integer whose quotients are exact enough."""

    def __truediv__(self, other):
        return mpf(int(self)) / other

    def __rtruediv__(self, other):
        return mpf(int(other)) / int(self) if isinstance(other, int) else other / int(self)


for _name in ("add", "radd", "sub", "rsub", "mul", "rmul", "neg", "mod"):
    def _wrap(name):
        base = getattr(int, name)

        def method(self, *rest):
            value = base(self, *rest)
            return value if value is NotImplemented else I(value)
        return method
    setattr(I, f"__{_name}__", _wrap(f"__{_name}__"))


def _power(self, other):
    if isinstance(other, int) and other >= 0:
        return I(int(self) ** int(other))
    return mpf(int(self)) ** other


I.__pow__ = _power
I.__rpow__ = lambda self, other: I(int(other) ** int(self)) if self >= 0 else mpf(int(other)) ** int(self)


def irange(*bounds):
    return [I(i) for i in range(*[int(b) for b in bounds])]


def clean(values, zeros):
    """Sorts eigenvalues; the `zeros` smallest must vanish to 20 digits and become exact."""
    values = sorted(values, key=abs)
    top = max([abs(v) for v in values] + [mpf(1) / 10**40])
    for v in values[:zeros]:
        assert abs(v) < top * mpf(10) ** -20, v
    for v in values[zeros:]:
        assert abs(v) > top * mpf(10) ** -44, v
    return [0] * zeros + values[zeros:]


def eig(M, K, zeros=0):
    """The eigenvalues of K x = w2 M x."""
    M, K = matrix(M), matrix(K)
    L = mp.cholesky(M)
    inverse = mp.inverse(L)
    A = inverse * K * inverse.T
    A = (A + A.T) / 2
    return clean(list(mp.eigsy(A, eigvals_only=True)), zeros)


def modes(T, V, q0, zeros=0):
    """The eigenvalues of a model: T(q, v), V(q) differentiated numerically at q0 (error 1e-40)."""
    n = len(q0)
    q0 = [mpf(x) for x in q0]
    h = mpf(10) ** -12

    def hessian(f, at):
        def shifted(*moves):
            x = list(at)
            for i, s in moves:
                x[i] = x[i] + s * h
            return f(x)
        H = matrix(n, n)
        weight = {-2: mpf(1) / 12, -1: mpf(-2) / 3, 1: mpf(2) / 3, 2: mpf(-1) / 12}
        for i in range(n):
            for j in range(i, n):
                total = mpf(0)
                for a, wa in weight.items():
                    for b, wb in weight.items():
                        total += wa * wb * shifted((i, a), (j, b))
                H[i, j] = H[j, i] = total / h**2
        return H

    zero = [mpf(0)] * n
    M = hessian(lambda v: T(q0, v), zero)
    K = hessian(lambda q: V(q) - T(q, zero), q0)
    for i in range(n):
        e = [mpf(0)] * n
        e[i] = h
        force = ((V([a + b for a, b in zip(q0, e)]) - T([a + b for a, b in zip(q0, e)], zero))
                 - (V([a - b for a, b in zip(q0, e)]) - T([a - b for a, b in zip(q0, e)], zero))) / (2 * h)
        scale = max(abs(K[r, c]) for r in range(n) for c in range(n))
        assert abs(force) < mpf(10) ** -18 * (1 + scale), ("force", i, force)
    for r in range(n):
        for c in range(n):
            if abs(K[r, c]) < mpf(10) ** -30:
                K[r, c] = 0
    return eig(M, K, zeros)


def tidy(source):
    """Wraps the numbers of a piece of Python."""
    out = []
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        kind, text = token.type, token.string
        if kind == tokenize.NUMBER:
            exact = "." in text or ("e" in text.lower() and not text.lower().startswith("0x"))
            out += [(tokenize.NAME, "mpf" if exact else "I"), (tokenize.OP, "("),
                    (tokenize.STRING, f"'{text}'"), (tokenize.OP, ")")]
        else:
            out.append((kind, text))
    return tokenize.untokenize(out)


def digits(value):
    if isinstance(value, int) and value == 0:
        return "0"
    value = mpf(value)
    return "0" if value == 0 else mpmath.nstr(value, 34, min_fixed=-mpmath.inf, max_fixed=mpmath.inf, strip_zeros=True).removesuffix(".0")


def expect(source):
    space = {name: getattr(mpmath, name) for name in dir(mpmath) if not name.startswith("_")}
    space.update(I=I, range=irange, eig=eig, modes=modes, clean=clean, mp=mp,
                 len=lambda x: I(len(x)), sum=lambda x, s=I(0): __import__("functools").reduce(lambda a, b: a + b, x, s))
    space.pop("eigen", None)
    exec(tidy(source), space)
    lines = []
    if "omega2" in space:
        values = list(space["omega2"])
        down = sorted([v for v in values if v < 0])
        zeros = [v for v in values if v == 0]
        up = sorted([v for v in values if v > 0])
        omega = [0] * (len(down) + len(zeros)) + [mp.sqrt(v) for v in up]
        growth = [mp.sqrt(-v) for v in down] + [0] * (len(zeros) + len(up))
    elif "entries" in space:
        # Of damped models: (growth, omega), one for a conjugate pair, in the order of the modes.
        down, up = [], []
        entries = sorted(((mpf(g), mpf(w)) for g, w in space["entries"]),
                         key=lambda own: (0, -own[0], own[1]) if own[0] > 0 else (1, own[1], -own[0]))
        growth, omega = [g for g, _ in entries], [w for _, w in entries]
    else:
        up = sorted(space.get("omega", []))
        down = sorted(space.get("growth", []), reverse=True)
    if "entries" not in space and "omega2" not in space:
        omega = [0] * len(down) + up
        growth = down + [0] * len(up)
    kinds = ["unstable" if g > 0 else "damped" if g < 0 and w != 0 else "overdamped" if g < 0 else "zero" if w == 0 else "oscillation" for w, g in zip(omega, growth)]
    lines.append("# omega: " + " ".join(map(digits, omega)))
    if any(g != 0 for g in growth):
        lines.append("# growth: " + " ".join(map(digits, growth)))
    lines.append("# kinds: " + " ".join(kinds))
    # Zeros that rolling leaves (`rolled`, so many) do not count.
    zeros = kinds.count("zero") - space.get("rolled", 0)
    stability = "unstable" if "unstable" in kinds else "neutral" if zeros else "stable"
    lines.append("# stability: " + stability)
    if "equilibrium" in space:
        lines.append("# equilibrium: " + " ".join(map(digits, space["equilibrium"])))
    return lines


def fill(path):
    raw = open(path, newline="").read()
    end = "\r\n" if "\r\n" in raw else "\n"
    lines = raw.split(end)
    own = [line for line in lines if line.lstrip("\ufeff").startswith("#:")]
    if not own:
        return
    source = "\n".join(line.lstrip("\ufeff")[2:].removeprefix(" ") for line in own) + "\n"
    written = ("# omega:", "# growth:", "# kinds:", "# stability:", "# equilibrium:")
    kept = [line for line in lines if not line.startswith(written)]
    last = max(i for i, line in enumerate(kept) if line.lstrip("\ufeff").startswith("#:"))
    new = kept[:last + 1] + expect(source) + kept[last + 1:]
    text = end.join(new)
    if text != raw:
        open(path, "w", newline="").write(text)
        print(os.path.basename(path))


if __name__ == "__main__":
    folder = os.path.dirname(os.path.abspath(__file__))
    wanted = sys.argv[1:]
    problems = os.path.join(os.path.dirname(folder), "problems")
    for path in sorted(glob.glob(os.path.join(folder, "*.lag")) + glob.glob(os.path.join(problems, "*.lag"))):
        if not wanted or any(w in path for w in wanted):
            try:
                fill(path)
            except Exception as error:
                print(os.path.basename(path), "FAILED", type(error).__name__, error)
