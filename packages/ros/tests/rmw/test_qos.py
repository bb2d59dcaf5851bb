from itertools import product

import pytest

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    incompatibility,
)

RELIABILITY = {True: ReliabilityPolicy.RELIABLE, False: ReliabilityPolicy.BEST_EFFORT}
DURABILITY = {True: DurabilityPolicy.TRANSIENT_LOCAL, False: DurabilityPolicy.VOLATILE}


@pytest.mark.parametrize(("offered", "requested"), list(product([True, False], repeat=2)))
def test_a_reader_may_not_ask_for_more_than_is_offered(offered: bool, requested: bool) -> None:
    by_reliability = incompatibility(
        QoSProfile(reliability=RELIABILITY[offered]), QoSProfile(reliability=RELIABILITY[requested])
    )
    by_durability = incompatibility(
        QoSProfile(durability=DURABILITY[offered]), QoSProfile(durability=DURABILITY[requested])
    )
    matches = offered or not requested
    assert (by_reliability is None) is matches
    assert (by_durability is None) is matches
    assert (by_reliability, by_durability) == ((None, None) if matches else ("reliability", "durability"))


@pytest.mark.parametrize("depth", [0, -1, 1.5, True, None])
def test_a_depth_must_hold_at_least_one_sample(depth: object) -> None:
    with pytest.raises(MiddlewareError, match=r"QoS depth must be a whole number of at least 1, got"):
        QoSProfile(depth=depth)  # type: ignore[arg-type]


def test_keep_all_has_no_limit() -> None:
    assert QoSProfile(depth=7).limit == 7
    assert QoSProfile(depth=7, history=HistoryPolicy.KEEP_ALL).limit is None
