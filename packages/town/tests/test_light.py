import numpy as np
import pytest

from sunset_town import TIMES, WEATHERS, TownError
from sunset_town.light import light


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("weather", WEATHERS)
def test_the_sun_stands_above_the_horizon(time: str, weather: str) -> None:
    sun = light(time, weather).sun_direction
    assert np.linalg.norm(sun) == pytest.approx(1)
    assert 0 < sun[2] < 1


def test_clouds_take_the_sun_and_haze_the_distance() -> None:
    assert sum(light("noon", "overcast").sun) < 0.3 * sum(light("noon", "clear").sun)
    assert light("noon", "hazy").haze_m < 0.5 * light("noon", "clear").haze_m


def test_evening_light_is_redder_and_lower_than_at_noon() -> None:
    evening, noon = light("evening", "clear"), light("noon", "clear")
    assert evening.sun[0] / evening.sun[2] > 1.5 * noon.sun[0] / noon.sun[2]
    assert evening.sun_direction[2] < noon.sun_direction[2]


def test_unknown_light_is_refused_with_what_there_is() -> None:
    with pytest.raises(TownError, match="morning, noon, evening, got 'night'"):
        light("night", "clear")
    with pytest.raises(TownError, match="clear, hazy, overcast, got 'snow'"):
        light("noon", "snow")
