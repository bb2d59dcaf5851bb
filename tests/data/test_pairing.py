from hypothesis import given
from hypothesis import strategies as st

from sunset.data.bag import pair

STAMPS = st.lists(st.integers(0, 10_000), unique=True, min_size=1, max_size=12).map(sorted)


def test_equal_stamps_belong_together() -> None:
    assert pair([1, 2, 3], [1, 2, 3], [1, 2, 3]) == [(0, 0, 0), (1, 1, 1), (2, 2, 2)]


def test_a_moment_that_one_sensor_lacks_is_left_out() -> None:
    assert pair([0, 100, 200], [0, 200], [0, 100, 200]) == [(0, 0, 0), (2, 1, 2)]


def test_half_a_period_is_too_far() -> None:
    assert pair([0, 100, 200], [49, 150, 200]) == [(0, 0), (2, 2)]


def test_the_period_is_the_usual_one_where_images_are_missing() -> None:
    assert pair([0, 100, 200, 900], [0, 100, 251, 900]) == [(0, 0), (1, 1), (3, 3)]


def test_an_image_belongs_to_one_moment_only() -> None:
    assert pair([0, 60, 200, 300], [59]) == [(1, 0)]


def test_a_lone_image_is_paired_within_a_twentieth_of_a_second() -> None:
    assert pair([0], [49_999_999]) == [(0, 0)]
    assert pair([0], [50_000_000]) == []


def test_without_images_of_one_sensor_there_is_no_moment() -> None:
    assert pair([], [1], [1]) == []
    assert pair([1], [], [1]) == []


@given(STAMPS, STAMPS)
def test_pairs_are_in_order_each_image_once_and_nothing_nearer_is_left(
    first: list[int], other: list[int]
) -> None:
    matches = pair(first, other)
    for column in zip(*matches, strict=True):
        assert list(column) == sorted(set(column))
    for own, theirs in matches:
        apart = abs(first[own] - other[theirs])
        assert apart == min(abs(first[own] - stamp) for stamp in other)
        assert apart == min(abs(other[theirs] - stamp) for stamp in first)
