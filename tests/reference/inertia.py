#!/usr/bin/env python3
"""Make the meshes of models/data and the reference tensors of inertia/, or check the ones that are kept.

    python inertia.py            write models/data/*.stl and inertia/*.json
    python inertia.py --check    compute again and compare; exit status 1 if anything differs

Needs mpmath.  Integrals are exact fractions of the single-precision coordinates: surface integrals by the divergence
theorem (Mirtich 1996; Eberly, Polyhedral mass properties), over each triangle in barycentric coordinates.  (Librate adds up
tetrahedra instead.)  Principal moments are mpmath's at 80 digits, which must be zeros of the characteristic polynomial to 60.
"""
import csv
import json
import struct
import sys
from fractions import Fraction
from itertools import product
from math import cos, factorial, sin, sqrt
from pathlib import Path

import mpmath as mp

mp.mp.dps = 100
HERE = Path(__file__).resolve().parent
DATA = HERE.parents[1] / "models" / "data"


# Meshes

def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def box(low, high):
    """Twelve triangles, counterclockwise from outside."""
    corner = [tuple(h if bit else l for l, h, bit in zip(low, high, bits)) for bits in product((0, 1), repeat=3)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return [tuple(corner[i] for i in t) for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def turned_over(mesh):
    return [(a, c, b) for a, b, c in mesh]


def icosphere(rounds):
    t = (1 + sqrt(5)) / 2
    v = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
         (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    f = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
         (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7),
         (9, 8, 1)]
    unit = lambda p: tuple(x / sqrt(sum(y * y for y in p)) for x in p)
    mesh = [tuple(unit(v[i]) for i in t) for t in f]
    for _ in range(rounds):
        middle = lambda p, q: unit(tuple((x + y) / 2 for x, y in zip(*sorted((p, q)))))
        mesh = [t for a, b, c in mesh for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
                for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    return mesh


def moved(mesh, scale, by):
    return [tuple(tuple(s * x + d for s, x, d in zip(scale, p, by)) for p in t) for t in mesh]


def turned(mesh, angle):
    """About y."""
    c, s = cos(angle), sin(angle)
    return [tuple((c * x + s * z, y, c * z - s * x) for x, y, z in t) for t in mesh]


TETRAHEDRON = [((0, 0, 0), (0, 2, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 3)), ((0, 0, 0), (0, 0, 3), (0, 2, 0)),
               ((1, 0, 0), (0, 2, 0), (0, 0, 3))]
MESHES = {
    "tetrahedron": (True, TETRAHEDRON),
    "box": (False, box((-0.1, -0.2, -0.3), (0.3, 0.1, -0.1))),
    "box_with_cavity": (True, box((0, 0, 0), (4, 3, 2)) + turned_over(box((1, 1, 0.5), (3, 2, 1.25)))),
    "ellipsoid": (False, moved(turned(moved(icosphere(2), (0.1, 0.15, 0.25), (0, 0, 0)), 0.5), (1, 1, 1), (0.05, 0.02, -0.4))),
}


def ascii_stl(name, mesh):
    lines = [f"solid {name}"]
    for t in mesh:
        lines += ["facet normal 0 0 0", "  outer loop"]
        lines += ["    vertex " + " ".join(f"{x:g}" for x in p) for p in t]
        lines += ["  endloop", "endfacet"]
    return "\n".join(lines + [f"endsolid {name}", ""]).encode()


def binary_stl(name, mesh):
    out = f"{name}, made by tests/reference/inertia.py".encode().ljust(80, b" ") + struct.pack("<I", len(mesh))
    for t in mesh:
        out += struct.pack("<12fH", 0, 0, 0, *(x for p in t for x in p), 0)
    return out


# Integrals

def over_triangle(points, powers):
    """The integral of x^i y^j z^k over u, v >= 0, u + v <= 1, exactly."""
    factors = [axis for axis, power in enumerate(powers) for _ in range(power)]
    total = Fraction(0)
    for choice in product(range(3), repeat=len(factors)):
        counts = [choice.count(corner) for corner in range(3)]
        weight = Fraction(factorial(counts[0]) * factorial(counts[1]) * factorial(counts[2]), factorial(len(factors) + 2))
        term = Fraction(1)
        for corner, axis in zip(choice, factors):
            term *= points[corner][axis]
        total += weight * term
    return total


def solid(mesh):
    """Volume, first and second moments, from fluxes through the surface."""
    size, first, second = Fraction(0), [Fraction(0)] * 3, [[Fraction(0)] * 3 for _ in range(3)]
    for t in mesh:
        p = [[Fraction(single(x)) for x in corner] for corner in t]
        u, v = ([p[k][i] - p[0][i] for i in range(3)] for k in (1, 2))
        normal = [u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)]
        power = lambda *axes: tuple(axes.count(i) for i in range(3))
        size += normal[0] * over_triangle(p, power(0))
        for i in range(3):
            j = (i + 1) % 3
            first[i] += normal[i] * over_triangle(p, power(i, i)) / 2
            second[i][i] += normal[i] * over_triangle(p, power(i, i, i)) / 3
            mixed = normal[i] * over_triangle(p, power(i, i, j)) / 2
            second[i][j] += mixed
            second[j][i] += mixed
    return size, first, second


def points(path):
    rows = list(csv.DictReader(line for line in path.read_text().splitlines() if not line.startswith("#")))
    mass = [Fraction(row["mass"]) for row in rows]
    place = [[Fraction(row[axis]) for axis in "xyz"] for row in rows]
    first = [sum(m * r[i] for m, r in zip(mass, place)) for i in range(3)]
    return sum(mass), first, [[sum(m * r[i] * r[j] for m, r in zip(mass, place)) for j in range(3)] for i in range(3)]


def digits(x):
    if x == 0:
        return "0"
    x = mp.mpf(x.numerator) / x.denominator if isinstance(x, Fraction) else x
    return mp.nstr(x, 40, strip_zeros=False, min_fixed=-400, max_fixed=400)


def reference(size, first, second):
    centre = [x / size for x in first]
    spread = [[second[i][j] - size * centre[i] * centre[j] for j in range(3)] for i in range(3)]
    trace = sum(spread[i][i] for i in range(3))
    tensor = [[(trace if i == j else 0) - spread[i][j] for j in range(3)] for i in range(3)]
    exact = mp.matrix([[mp.mpf(x.numerator) / x.denominator for x in row] for row in tensor])
    moments = sorted(mp.eigsy(exact, eigvals_only=True))
    for moment in moments:
        assert abs(mp.det(exact - moment * mp.eye(3))) < mp.mpf(10) ** -60 * max(moments) ** 3
    return {"mass": digits(size), "centre": [digits(x) for x in centre],
            "tensor": [[digits(x) for x in row] for row in tensor], "moments": [digits(x) for x in moments]}


def main():
    files = {}
    for name, (text, mesh) in MESHES.items():
        files[DATA / f"{name}.stl"] = (ascii_stl if text else binary_stl)(name, mesh)
        files[HERE / "inertia" / f"{name}.json"] = reference(*solid(mesh))
    files[HERE / "inertia" / "body_points.json"] = reference(*points(DATA / "body_points.csv"))
    wrong = 0
    for path, content in files.items():
        if isinstance(content, dict):
            content = (json.dumps(content, indent=1) + "\n").encode()
        if "--check" not in sys.argv:
            path.write_bytes(content)
        elif not path.exists() or path.read_bytes() != content:
            wrong += 1
            print(f"{path.name} differs")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
