"""What a record says of its run, where nothing else matters."""

from sunset.recording import RunRecord

RUN = RunRecord(
    scenario="rain",
    faults=[],
    suite="",
    manager="mine",
    seed=4,
    model="lite",
    model_checksums={},
    middleware="sim",
    entropy_threshold=0.06,
    sharpness_threshold=0.2,
    duration_s=20.0,
    period_s=0.1,
    expected_frames=200,
    metrics={},
    valid=True,
    reason="",
)
