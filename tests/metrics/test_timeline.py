from sunset.metrics import Timeline


def timeline(**more: object) -> Timeline:
    thresholds = {"entropy_threshold": 0.2, "sharpness_threshold": 0.5}
    values: dict[str, object] = {"thresholds": thresholds, **more}
    return Timeline(**values)  # type: ignore[arg-type]


def test_an_empty_experiment_is_a_timeline() -> None:
    assert timeline().duration_s == 20.0
