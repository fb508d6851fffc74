"""Parameter sets on a cluster of Dask's, where that is installed: models travel to its processes."""

import numpy as np
import pytest

import librate

MODEL = """
param g = 9.81  param l = 1  param k = 4  param a = 0.3  param m = 1
coord phi[1..2]
T = 1/2*m*l^2*dot(phi', phi')
V = m*g*l*(2 - cos(phi[1]) - cos(phi[2])) + 1/2*k*a^2*(phi[2] - phi[1])^2
"""


def test_a_hundred_thousand_sets_as_a_bag():
    bag = pytest.importorskip("dask.bag")
    distributed = pytest.importorskip("distributed")
    model = librate.Model(MODEL)
    k = np.linspace(0.5, 8, 100_000)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster):
            parts = bag.from_sequence(np.array_split(k, 20), npartitions=20)
            found = parts.map(lambda part: model.batch({"k": part}, threads=1).omega).compute()
    omega = np.concatenate(found)
    assert omega.shape == (100_000, 2)
    assert np.all(np.abs(omega[:, 1] ** 2 - (9.81 + 2 * k * 0.3**2)) < 1e-13 * 20)
