"""Matching two streams: against a slow independent model, and the traps one by one."""

from hypothesis import given, settings
from hypothesis import strategies as st

from sunset.nodes.sensor_fusion import PairMatcher

TOLERANCE = 10


def feed(*arrivals: tuple[str, int]) -> list[tuple[int, int]]:
    """Feed a fresh matcher with ("l" or "r", stamp); return the pairs of stamps in the order they came."""
    matcher: PairMatcher[int] = PairMatcher()
    pairs = []
    for side, stamp in arrivals:
        add = matcher.add_left if side == "l" else matcher.add_right
        pair = add(stamp, stamp, tolerance=TOLERANCE)
        if pair:
            pairs.append(pair)
    return pairs


def test_items_within_the_tolerance_make_a_pair_in_either_order() -> None:
    assert feed(("l", 0), ("r", 10)) == [(0, 10)]
    assert feed(("r", 10), ("l", 0)) == [(0, 10)]
    assert feed(("l", 0), ("r", 11)) == []


def test_a_pair_is_given_once() -> None:
    assert feed(("l", 0), ("r", 0), ("r", 0), ("l", 0), ("r", 5), ("l", 5)) == [(0, 0), (5, 5)]


def test_an_item_is_used_once() -> None:
    assert feed(("l", 0), ("r", 2), ("r", 4)) == [(0, 2)]


def test_the_closest_partner_is_taken_and_of_two_the_newer() -> None:
    assert feed(("l", 0), ("l", 8), ("r", 6)) == [(8, 6)]
    assert feed(("l", 0), ("l", 8), ("r", 2)) == [(0, 2)]
    assert feed(("l", 0), ("l", 8), ("r", 4)) == [(8, 4)]


def test_what_is_older_than_the_last_pair_is_never_given() -> None:
    assert feed(("l", 0), ("l", 100), ("r", 100), ("r", 0)) == [(100, 100)]
    assert feed(("r", 0), ("l", 100), ("r", 100), ("l", 0)) == [(100, 100)]


def test_items_may_arrive_out_of_order() -> None:
    assert feed(("l", 100), ("l", 0), ("r", 0), ("r", 100)) == [(0, 0), (100, 100)]


def test_items_without_a_partner_are_forgotten() -> None:
    matcher: PairMatcher[int] = PairMatcher(size=3)
    for stamp in range(0, 10_000, 100):
        assert matcher.add_left(stamp, stamp, tolerance=TOLERANCE) is None
    assert len(matcher._left.waiting) == 3
    assert matcher.add_right(9600, 9600, tolerance=TOLERANCE) is None
    assert matcher.add_right(9700, 9700, tolerance=TOLERANCE) == (9700, 9700)


def test_items_of_a_far_future_do_not_crowd_out_the_present() -> None:
    matcher: PairMatcher[int] = PairMatcher(size=3)
    for stamp in range(10**9, 10**9 + 1000, 100):
        assert matcher.add_left(stamp, stamp, tolerance=TOLERANCE) is None
    assert matcher.add_left(5, 5, tolerance=TOLERANCE) is None
    assert matcher.add_right(5, 5, tolerance=TOLERANCE) == (5, 5)


def test_a_stream_can_be_forgotten_without_forgetting_what_was_given() -> None:
    matcher: PairMatcher[str] = PairMatcher()
    matcher.add_left(0, "old", tolerance=TOLERANCE)
    assert matcher.add_right(0, "depth", tolerance=TOLERANCE) == ("old", "depth")
    matcher.add_left(100, "old", tolerance=TOLERANCE)
    matcher.clear_left()
    assert matcher.add_right(100, "depth", tolerance=TOLERANCE) is None
    assert matcher.add_left(0, "new", tolerance=TOLERANCE) is None
    assert matcher.add_left(100, "new", tolerance=TOLERANCE) == ("new", "depth")


def test_after_a_reset_old_stamps_are_taken_again() -> None:
    matcher: PairMatcher[int] = PairMatcher()
    for _ in range(2):
        assert matcher.add_left(5, 5, tolerance=TOLERANCE) is None
        assert matcher.add_right(5, 5, tolerance=TOLERANCE) == (5, 5)
        matcher.reset()


def test_after_a_false_stamp_or_when_time_was_set_back_pairs_go_on() -> None:
    future, second = 2**31 * 10**9, 10**9
    once = [("l", 100), ("r", 100)]
    assert feed(("l", future), ("r", future), *once) == [(future, future), (100, 100)]
    assert feed(("r", future), ("l", future), *reversed(once)) == [(future, future), (100, 100)]
    assert (
        feed(*[("l", 3 * second), ("r", 3 * second), *once] * 2) == [(3 * second, 3 * second), (100, 100)] * 2
    )
    assert feed(("l", second + 100), ("r", second + 100), *once) == [
        (second + 100, second + 100)
    ]  # just late


def test_what_waited_when_time_was_set_back_is_forgotten() -> None:
    second = 10**9
    before = [("l", 8 * second), ("r", 8 * second), ("l", 9 * second)]
    assert feed(*before, ("r", 0), ("l", 0), ("r", 9 * second)) == [(8 * second, 8 * second), (0, 0)]


@settings(max_examples=300)
@given(st.lists(st.tuples(st.sampled_from("lr"), st.integers(0, 60)), max_size=40))
def test_pairs_are_close_unique_and_ever_newer(arrivals: list[tuple[str, int]]) -> None:
    pairs = feed(*arrivals)
    assert all(abs(left - right) <= TOLERANCE for left, right in pairs)
    lefts, rights = [left for left, _ in pairs], [right for _, right in pairs]
    assert lefts == sorted(set(lefts))
    assert rights == sorted(set(rights))
    assert set(lefts) <= {stamp for side, stamp in arrivals if side == "l"}
    assert set(rights) <= {stamp for side, stamp in arrivals if side == "r"}


@settings(max_examples=100)
@given(st.lists(st.integers(0, 9), min_size=1, max_size=20))
def test_two_complete_streams_in_order_lose_nothing(gaps: list[int]) -> None:
    stamps = [sum(gaps[: index + 1]) + 30 * index for index in range(len(gaps))]
    arrivals = [arrival for stamp in stamps for arrival in (("l", stamp), ("r", stamp + 3))]
    assert feed(*arrivals) == [(stamp, stamp + 3) for stamp in stamps]
