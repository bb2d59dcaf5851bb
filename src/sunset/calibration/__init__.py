"""What faults and cures make of frames, and which thresholds tell healthy frames from faulty ones."""

from sunset.calibration.conditions import (
    ENTROPY,
    SHARPNESS,
    Condition,
    CurvesPlan,
    Seen,
    cure_of,
    effects,
    is_seen,
    plan_curves,
    possible_pairs,
    signal_of,
    suite_strengths,
)
from sunset.calibration.flight import AUC, OVER, FlightThresholds, fit_to_flight, flight_thresholds
from sunset.calibration.flight_text import as_text as flights_text
from sunset.calibration.separation import (
    SAMPLES,
    Separation,
    Values,
    chosen_frames,
    roc_auc,
    separate,
    window_means,
)
from sunset.calibration.thresholds import (
    healthy_conditions,
    part_entropy,
    part_sharpness,
    unsure_faults,
)

__all__ = [
    "AUC",
    "ENTROPY",
    "OVER",
    "SAMPLES",
    "SHARPNESS",
    "Condition",
    "CurvesPlan",
    "FlightThresholds",
    "Seen",
    "Separation",
    "Values",
    "chosen_frames",
    "cure_of",
    "effects",
    "fit_to_flight",
    "flight_thresholds",
    "flights_text",
    "healthy_conditions",
    "is_seen",
    "part_entropy",
    "part_sharpness",
    "plan_curves",
    "possible_pairs",
    "roc_auc",
    "separate",
    "signal_of",
    "suite_strengths",
    "unsure_faults",
    "window_means",
]
