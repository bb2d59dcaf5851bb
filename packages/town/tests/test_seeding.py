import pytest

from sunset_town import TownError
from sunset_town.seeding import check_seed, generator


def test_the_streams_of_a_seed_never_change() -> None:
    assert generator(7, "town", "plan", 246).integers(2**32) == 185559221
    assert generator(8, "town", "plan", 246).integers(2**32) == 3662176428


@pytest.mark.parametrize("seed", [-1, 2**32, 1.0, True, "1"])
def test_a_seed_that_is_not_a_whole_number_in_its_range_is_refused(seed: object) -> None:
    with pytest.raises(TownError, match="whole number from 0 to 4294967295"):
        check_seed(seed)  # type: ignore[arg-type]
