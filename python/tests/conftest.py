import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


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
