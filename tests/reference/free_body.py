#!/usr/bin/env python3
"""Make the tables of models/hard/free_body_100.lag: a hundred points in a box, bonds between neighbours.

    python free_body.py            write free_body_points.csv and free_body_bonds.csv
    python free_body.py --check    compare with the kept files; exit status 1 if one differs

The random numbers are those of a linear congruential generator written out here, so that the tables are the
same everywhere.  Every point is bonded to its eight nearest neighbours (at least).  Masses range over three powers of
ten, springs over six.
"""
import sys
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "models" / "hard" / "data"
POINTS, NEIGHBOURS = 100, 8


def generator(state=20):
    """Knuth's MMIX generator; the upper 31 bits are good enough."""
    while True:
        state = (6364136223846793005 * state + 1442695040888963407) % 2**64
        yield state >> 33


def tables():
    draw = generator()
    below = lambda n: next(draw) * n >> 31
    # Thousandths, so that squares of distances are exact integers.
    place = [[below(side) for side in (12000, 7000, 4000)] for _ in range(POINTS)]
    digit = lambda: f"{1 + below(90) / 10:.1f}"
    points = [f"{digit()}e{below(3) - 1}," + ",".join(f"{c / 1000:.3f}" for c in p) for p in place]
    apart = lambda i, j: sum((a - b) ** 2 for a, b in zip(place[i], place[j]))
    bonds = set()
    for i in range(POINTS):
        near = sorted((apart(i, j), j) for j in range(POINTS) if j != i)
        bonds |= {(min(i, j), max(i, j)) for _, j in near[:NEIGHBOURS]}
    rows = [f"{i + 1},{j + 1},{digit()}e{below(6) - 1}" for i, j in sorted(bonds)]
    return {"free_body_points.csv": ["mass,x,y,z"] + points, "free_body_bonds.csv": ["i,j,k"] + rows}


def main():
    differs = []
    for name, lines in tables().items():
        text, path = "\n".join(lines) + "\n", DATA / name
        if "--check" not in sys.argv:
            path.write_text(text, encoding="utf-8")
        elif path.read_text(encoding="utf-8") != text:
            differs.append(f"{name}: differs")
    print("\n".join(differs), file=sys.stderr, end="\n" if differs else "")
    return 1 if differs else 0


if __name__ == "__main__":
    sys.exit(main())
