import numpy as np
import pytest

from sunset.errors import RecordError
from sunset.metrics import Frames, Samples, Timeline


def timeline(**more: object) -> Timeline:
    thresholds = {"entropy_threshold": 0.2, "sharpness_threshold": 0.5}
    values: dict[str, object] = {"thresholds": thresholds, **more}
    return Timeline(**values)  # type: ignore[arg-type]


def test_an_empty_experiment_is_a_timeline() -> None:
    assert timeline().duration_s == 20.0


def test_samples_are_finite() -> None:
    with pytest.raises(RecordError, match="values of samples must be finite"):
        Samples(np.array([0.0, 1.0]), np.array([1.0, np.nan]))


@pytest.mark.parametrize("iou", [-0.1, 1.1, np.nan])
def test_iou_of_frames_is_checked(iou: float) -> None:
    counts = np.zeros((1, 28), dtype=np.int64)
    with pytest.raises(RecordError, match="IoU of a frame must be from 0 to 1"):
        Frames(np.array([0.0]), np.array([iou]), counts, counts, counts)


def test_the_models_thresholds_must_be_there() -> None:
    with pytest.raises(RecordError, match="The sharpness_threshold of a timeline must be finite, got None"):
        timeline(thresholds={"entropy_threshold": 0.2})
