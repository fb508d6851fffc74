"""The integrators that Python has, on the double pendulum of the example beside this file: one trip at a time.

Reads JSON lines and answers with JSON lines. First it tells the versions of what is installed. {"run": integrator,
"tolerance": number, "until": seconds, "patience": seconds} is answered with CPU seconds of the fastest of several trips, those
of what is prepared once, and the state at the end, or with what went wrong.
"""
import json
import math
import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "speed_and_error"))
from peers import fastest, find, version  # noqa: E402

np, scipy, heyoka = (find(name) for name in ("numpy", "scipy", "heyoka"))
if scipy:
    import scipy.integrate

G = 9.81
START = [0.3, 0.3, 0.0, 0.0]


def rates(_, state):
    """Masses and lengths 1. c = cos(p - q), s = sin(p - q):
    2 p'' + c q'' + s q'^2 + 2 g sin p = 0,  c p'' + q'' - s p'^2 + g sin q = 0."""
    p, q, u, v = state
    c, s = math.cos(p - q), math.sin(p - q)
    first = -s * v * v - 2 * G * math.sin(p)
    second = s * u * u - G * math.sin(q)
    det = 2 - c * c
    return u, v, (first - c * second) / det, (2 * second - c * first) / det


def of_scipy(method):
    def prepare(tolerance, until):
        def call():
            found = scipy.integrate.solve_ivp(rates, (0, until), START, method=method, rtol=tolerance, atol=tolerance)
            if not found.success:
                raise ArithmeticError(found.message)
            return found.y[:, -1]

        return call

    return prepare


def of_heyoka(kind):
    def prepare(tolerance, until):
        real = np.longdouble if kind == "longdouble" else float
        # The parameters are those doubles that 9.81 and 0.3 round to in doubles, and better ones where numbers are better.
        g, start = (real("9.81"), [real("0.3"), real("0.3"), real(0), real(0)])
        p, q, u, v = heyoka.make_vars("p", "q", "u", "v")
        c, s = heyoka.cos(p - q), heyoka.sin(p - q)
        first = -s * v * v - 2 * g * heyoka.sin(p)
        second = s * u * u - g * heyoka.sin(q)
        det = 2 - c * c
        system = [(p, u), (q, v), (u, (first - c * second) / det), (v, (2 * second - c * first) / det)]
        stepper = heyoka.taylor_adaptive(system, start, tol=real(tolerance), fp_type=real)

        def call():
            stepper.time = real(0)
            stepper.state[:] = start
            outcome = stepper.propagate_until(real(until))[0]
            if outcome != heyoka.taylor_outcome.time_limit:
                raise ArithmeticError(str(outcome))
            return stepper.state.copy()

        return call

    return prepare


INTEGRATORS = {
    "SciPy DOP853": of_scipy("DOP853"),
    "SciPy LSODA": of_scipy("LSODA"),
    "SciPy Radau": of_scipy("Radau"),
    "heyoka": of_heyoka("float"),
    "heyoka, 80 bits": of_heyoka("longdouble"),
}


def run(request):
    begin = time.process_time()
    call = INTEGRATORS[request["run"]](request["tolerance"], request["until"])
    prepared = time.process_time() - begin
    seconds, state = fastest(request["patience"], call)
    if not all(np.isfinite(state)):
        raise ArithmeticError("not a number")
    digits = [np.format_float_scientific(x, unique=True, trim="0") for x in state]
    return {"seconds": seconds, "prepared": prepared, "state": digits}


def main():
    versions = {"numpy": version(np), "scipy": version(scipy), "heyoka": version(heyoka)}
    versions["python"] = ".".join(map(str, sys.version_info[:3]))
    print(json.dumps(versions), flush=True)
    for line in sys.stdin:
        try:
            answer = run(json.loads(line))
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
