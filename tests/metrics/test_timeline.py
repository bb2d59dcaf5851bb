import numpy as np
import pytest

from sunset.errors import RecordError
from sunset.metrics import Samples, Timeline


def timeline(**more: object) -> Timeline:
    thresholds = {"entropy_threshold": 0.2, "sharpness_threshold": 0.5}
    values: dict[str, object] = {"thresholds": thresholds, **more}
    return Timeline(**values)  # type: ignore[arg-type]


def test_an_empty_experiment_is_a_timeline() -> None:
    assert timeline().duration_s == 20.0


def test_samples_are_finite() -> None:
    with pytest.raises(RecordError, match="values of samples must be finite"):
        Samples(np.array([0.0, 1.0]), np.array([1.0, np.nan]))
