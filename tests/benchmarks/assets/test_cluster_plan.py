"""The simulated cluster: what can be computed by hand comes out, and the busiest part sets the pace."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.assets.cluster_plan import forecast, saturation

N = 1000


def test_one_worker_takes_the_sum_of_everything() -> None:
    work_s = np.linspace(0.5, 1.5, N)
    assert forecast(work_s, np.full(N, 0.1), 0.0, 1).wall_s == pytest.approx(N * 1.1)


def test_equal_items_come_in_rounds() -> None:
    result = forecast(np.full(N, 2.0), np.zeros(N), 0.0, 10)
    assert result.wall_s == pytest.approx(N / 10 * 2.0)
    assert result.busy["workers"] == pytest.approx(1.0)


@pytest.mark.parametrize(("part", "storage", "driver"), [("storage", 0.1, 0.01), ("driver", 0.01, 0.1)])
def test_beyond_saturation_more_workers_do_not_help(part: str, storage: float, driver: float) -> None:
    work_s, storage_s = np.full(N, 1.0), np.full(N, storage)
    limits = saturation(work_s, storage_s, driver)
    assert min(limits, key=lambda name: limits[name]) == part
    assert limits[part] == pytest.approx(10.0, rel=0.11)
    below, above, far = (forecast(work_s, storage_s, driver, count) for count in (5, 20, 200))
    assert below.busy["workers"] > 0.85
    assert above.wall_s == pytest.approx(N * 0.1, rel=0.02)
    assert far.wall_s == pytest.approx(above.wall_s, rel=0.02)
    assert far.busy[part] > 0.98


def test_more_workers_than_items_wait_for_the_longest() -> None:
    assert forecast(np.array([1.0, 5.0, 2.0]), np.zeros(3), 0.0, 50).wall_s == pytest.approx(5.0)
