import numpy as np
import pytest

from sunset.errors import RecordError
from sunset.metrics import Command, Frames, Injection, Samples, Timeline


def timeline(**more: object) -> Timeline:
    thresholds = {"entropy_threshold": 0.2, "sharpness_threshold": 0.5}
    values: dict[str, object] = {"thresholds": thresholds, **more}
    return Timeline(**values)  # type: ignore[arg-type]


def test_an_empty_experiment_is_a_timeline() -> None:
    assert timeline().duration_s == 20.0


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([0.0, 1.0], [1.0], r"must have shape \(2,\), got \(1,\)"),
        ([1.0, 0.5], [1.0, 1.0], r"must ascend, got 1 s before 0\.5 s"),
        ([0.0, np.nan], [1.0, 1.0], "times of samples must be finite"),
        ([0.0, 1.0], [1.0, np.nan], "values of samples must be finite"),
        ([[0.0]], [[1.0]], "one-dimensional"),
    ],
)
def test_samples_are_checked(times: list[float], values: list[float], message: str) -> None:
    with pytest.raises(RecordError, match=message):
        Samples(np.array(times), np.array(values))


def test_equal_times_are_in_order() -> None:
    assert len(Samples(np.array([1.0, 1.0]), np.array([2.0, 3.0])).times) == 2


@pytest.mark.parametrize("iou", [-0.1, 1.1, np.nan])
def test_iou_of_frames_is_checked(iou: float) -> None:
    counts = np.zeros((1, 28), dtype=np.int64)
    with pytest.raises(RecordError, match="IoU of a frame must be from 0 to 1"):
        Frames(np.array([0.0]), np.array([iou]), counts, counts, counts)


def test_counts_of_frames_are_checked() -> None:
    good, bad = np.zeros((1, 28), dtype=np.int64), np.zeros((1, 27), dtype=np.int64)
    with pytest.raises(RecordError, match=r"truth counts of frames must have shape \(1, 28\), got \(1, 27\)"):
        Frames(np.array([0.0]), np.array([0.5]), good, good, bad)


@pytest.mark.parametrize("name", ["duration_s", "period_s", "expected_frames"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_lengths_are_positive(name: str, value: float) -> None:
    with pytest.raises(RecordError, match=f"The {name} of a timeline must be finite and greater than 0"):
        timeline(**{name: value})


@pytest.mark.parametrize("name", ["entropy_threshold", "sharpness_threshold"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_thresholds_are_positive(name: str, value: float) -> None:
    thresholds = {"entropy_threshold": 0.2, "sharpness_threshold": 0.5, name: value}
    with pytest.raises(RecordError, match=f"The {name} of a timeline must be finite"):
        timeline(thresholds=thresholds)


def test_the_models_thresholds_must_be_there() -> None:
    with pytest.raises(RecordError, match="The sharpness_threshold of a timeline must be finite, got None"):
        timeline(thresholds={"entropy_threshold": 0.2})


def test_events_out_of_order_are_refused() -> None:
    with pytest.raises(RecordError, match="times of commands must ascend"):
        timeline(commands=(Command(2, "/m", "camera", "redeploy"), Command(1, "/m", "camera", "redeploy")))
    with pytest.raises(RecordError, match="times of injections must ascend"):
        timeline(injections=(Injection(2, "a", "F1", "camera"), Injection(1, "b", "F1", "camera")))
    with pytest.raises(RecordError, match="times of /x must ascend"):
        timeline(message_times={"/x": np.array([2.0, 1.0])})
