import os
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


class Series:
    """As one of pandas: an array with labels, from 1, and without a truth value."""

    def __init__(self, values, labels=None):
        self.labels = list(labels or range(1, len(values) + 1))
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype)

    def __bool__(self):
        raise ValueError("the truth value of a Series is ambiguous")

    def __len__(self):
        return len(self.values)

    def __iter__(self):
        return iter(self.values)

    def __getitem__(self, label):
        return self.values[self.labels.index(label)]

    def items(self):
        return zip(self.labels, self.values)


@pytest.fixture
def models() -> Path:
    return ROOT / "models"


@pytest.fixture
def command_line() -> Path:
    """The command line of the same sources, where it is built."""
    places = [os.environ.get("LIBRATE", ""), ROOT / "target/debug/librate", ROOT / "target/release/librate"]
    for place in places:
        if place and Path(place).is_file():
            return Path(place)
    pytest.skip("the command line is not built; LIBRATE says where it is")
