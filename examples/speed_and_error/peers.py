"""The peers that Python has, timed one call at a time for the example beside this file.

Reads JSON lines and answers with JSON lines. First it tells the versions of what is installed. {"case": ...} sets
M and K (lists of doubles, column by column, and strings of 300 digits) and is not answered, nor is {"large": ...}, which
names an archive with sparse ones; {"run": peer, "patience": seconds} is answered with CPU seconds of the fastest of
several calls and the eigenvalues, or with what went wrong.
"""
import importlib
import json
import os
import sys
import time
import warnings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")
warnings.simplefilter("ignore")


def find(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


np, scipy, mp, flint = (find(name) for name in ("numpy", "scipy", "mpmath", "flint"))
cholmod = find("sksparse.cholmod")
if scipy:
    import scipy.linalg as sl
    import scipy.sparse as sp
    import scipy.sparse.linalg as ssl


class Case:
    def __init__(self, data):
        n = self.n = data["n"]
        self.singular = data["singular"]
        if np:
            self.mass = np.array(data["mass"]).reshape(n, n)
            self.stiffness = np.array(data["stiffness"]).reshape(n, n)
        rows = lambda a: [a[i * n : (i + 1) * n] for i in range(n)]
        self.mass_text, self.stiffness_text = (rows(data[key]) for key in ("mass_text", "stiffness_text"))
        self.count, self.range = 10, {}
        # Where K is singular the shift has to be beside zero: a millionth of a typical square.
        if np:
            typical = np.mean(self.stiffness.diagonal() / self.mass.diagonal())
            self.shift = -1e-6 * typical if self.singular else 0.0


class Large:
    """The lowest modes of sparse matrices."""

    def __init__(self, data):
        with np.load(data["file"]) as file:
            matrix = lambda name: sp.csr_matrix(
                tuple(file[f"{name}_{part}"] for part in ("data", "indices", "indptr")), shape=file[f"{name}_shape"]
            )
            self.mass, self.stiffness = matrix("M"), matrix("K")
        self.count = data["count"]
        self.range = {"select": "i", "select_range": (0, self.count - 1)}
        self.shift = -1e-3 if data["singular"] else 0.0


# Each peer prepares its own kind of matrix outside of the time, and returns the call.


def numpy_eigh(case):
    K, M = case.stiffness, case.mass

    def call():
        L = np.linalg.cholesky(M)
        values, vectors = np.linalg.eigh(np.linalg.solve(L, np.linalg.solve(L, K).T))
        return values, np.linalg.solve(L.T, vectors)

    return call


def scipy_eigh(case):
    K, M = case.stiffness, case.mass
    return lambda: sl.eigh(K, M)


def tridiagonal(case):
    m, d, e = case.mass.diagonal(), case.stiffness.diagonal(), case.stiffness.diagonal(1)

    def call():
        s = 1 / np.sqrt(m)
        values, vectors = sl.eigh_tridiagonal(d * s * s, e * s[1:] * s[:-1], **case.range)
        return values, vectors * s[:, None]

    return call


def arpack(case):
    K, M = sp.csc_matrix(case.stiffness), sp.csc_matrix(case.mass)
    return lambda: ssl.eigsh(K, k=case.count, M=M, sigma=case.shift)


def arpack_cholmod(case):
    K, M = sp.csc_matrix(case.stiffness), sp.csc_matrix(case.mass)

    def call():
        # Positive definite, as the shift is not above the lowest.
        factor = cholmod.cholesky((K - case.shift * M).tocsc())
        inverse = ssl.LinearOperator(K.shape, matvec=factor.solve_A, dtype=float)
        return ssl.eigsh(K, k=case.count, M=M, sigma=case.shift, OPinv=inverse)

    return call


def mpmath_eigsy(digits):
    def prepare(case):
        mp.mp.dps = digits
        matrix = lambda rows: mp.matrix([[mp.mpf(x) for x in row] for row in rows])
        K, M = matrix(case.stiffness_text), matrix(case.mass_text)

        def call():
            inverse = mp.inverse(mp.cholesky(M))
            reduced = inverse * K * inverse.T
            return mp.eigsy((reduced + reduced.T) / 2, eigvals_only=True), None

        return call

    return prepare


def flint_eig(digits):
    def prepare(case):
        flint.ctx.prec = int(digits * 3.3219281) + 1
        matrix = lambda rows: flint.arb_mat([[flint.arb(x) for x in row] for row in rows])
        K, M = matrix(case.stiffness_text), matrix(case.mass_text)
        return lambda: (flint.acb_mat(M.solve(K)).eig(multiple=True), None)

    return prepare


PEERS = {
    "numpy": numpy_eigh,
    "scipy eigh": scipy_eigh,
    "LAPACK tridiagonal": tridiagonal,
    "ARPACK": arpack,
    "ARPACK with CHOLMOD": arpack_cholmod,
    "mpmath, 30 digits": mpmath_eigsy(30),
    "mpmath, 50 digits": mpmath_eigsy(50),
    "mpmath, 100 digits": mpmath_eigsy(100),
    "python-flint, 50 digits": flint_eig(50),
    "python-flint, 100 digits": flint_eig(100),
}


def fastest(patience, call):
    """As `clock::fastest`."""

    def sample(calls):
        start = time.process_time()
        for _ in range(calls):
            result = call()
        return (time.process_time() - start) / calls, result

    first, result = sample(1)
    calls = int(min(max(1e-3 / max(first, 1e-7), 1), 1e4))
    best, spent, samples = first, 0.0, 0
    while first < patience and samples < 50 and (samples < 3 or spent < patience):
        seconds, result = sample(calls)
        best = min(best, seconds)
        spent += seconds * calls
        samples += 1
    return best, result


def text(value):
    if isinstance(value, float):
        return repr(float(value))
    if flint and isinstance(value, flint.acb):
        value = value.real
        if not value.is_finite():
            raise ArithmeticError("no finite enclosure")
        # All the digits of the midpoint.
        return value.mid().str(int(flint.ctx.prec / 3.3) + 10, radius=False)
    return mp.nstr(value, mp.mp.dps + 10, min_fixed=0, max_fixed=0)


def rising(values):
    if flint and values and isinstance(values[0], flint.acb):
        return sorted(values, key=lambda value: value.real.mid())
    return sorted(values)


def run(case, peer, patience):
    seconds, (values, _) = fastest(patience, PEERS[peer](case))
    values = [text(value) for value in rising(list(values))]
    if any("n" in value for value in values):
        raise ArithmeticError("not a number")
    return {"seconds": seconds, "values": values}


def version(module):
    return getattr(module, "__version__", "unknown") if module else None


def main():
    names = {"numpy": np, "scipy": scipy, "mpmath": mp, "python-flint": flint}
    versions = {name: version(module) for name, module in names.items()}
    versions["scikit-sparse"] = version(find("sksparse")) if cholmod else None
    versions["python"] = ".".join(map(str, sys.version_info[:3]))
    print(json.dumps(versions), flush=True)
    case = None
    for line in sys.stdin:
        request = json.loads(line)
        if "case" in request:
            case = Case(request["case"])
            continue
        if "large" in request:
            case = Large(request["large"])
            continue
        try:
            answer = run(case, request["run"], request["patience"])
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
