"""Equilibria in 40 digits, by Newton's method on forces that are differentiated by hand (mpmath): tests/equilibria/boxes.rs."""
from mpmath import mp, mpf, findroot, exp

mp.dps = 40

mu = mpf("0.01215")


def euler(x):
    return -x + (1 - mu) * (x + mu) / abs(x + mu) ** 3 + mu * (x - 1 + mu) / abs(x - 1 + mu) ** 3


print("L3, L1, L2")
for start in ("-1.005", "0.8369", "1.1557"):
    print(findroot(euler, mpf(start)))

h = [-200, -100, -170, 15]
a = [-1, -1, mpf("-6.5"), mpf("0.7")]
b = [0, 0, 11, mpf("0.6")]
c = [-10, -10, mpf("-6.5"), mpf("0.7")]
x0 = [1, 0, mpf("-0.5"), -1]
y0 = [0, mpf("0.5"), mpf("1.5"), 1]


def slope(x, y):
    gx = gy = 0
    for k in range(4):
        u, v = x - x0[k], y - y0[k]
        e = h[k] * exp(a[k] * u * u + b[k] * u * v + c[k] * v * v)
        gx += e * (2 * a[k] * u + b[k] * v)
        gy += e * (b[k] * u + 2 * c[k] * v)
    return gx, gy


print("Müller and Brown")
for start in ((-0.822, 0.6243), (-0.5582, 1.4417), (-0.05, 0.4667), (0.2125, 0.293), (0.6235, 0.028)):
    print(findroot(slope, start).T)
