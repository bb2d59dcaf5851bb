"""The effects of faults and cures on frames, and thresholds that separate healthy from faulty frames."""

from sunset.calibration.conditions import (
    SHARPNESS,
    Condition,
    CurvesPlan,
    cure_of,
    effects,
    plan_curves,
    possible_pairs,
    signal_of,
    suite_strengths,
)
from sunset.calibration.flight import AUC, FlightThresholds, fit_to_flight, flight_thresholds
from sunset.calibration.thresholds import (
    Values,
    chosen_frames,
    part_entropy,
    part_sharpness,
    roc_auc,
    separate,
    window_means,
)
from sunset.system import SAMPLES

__all__ = [
    "AUC",
    "SAMPLES",
    "SHARPNESS",
    "Condition",
    "CurvesPlan",
    "FlightThresholds",
    "Values",
    "chosen_frames",
    "cure_of",
    "effects",
    "fit_to_flight",
    "flight_thresholds",
    "part_entropy",
    "part_sharpness",
    "plan_curves",
    "possible_pairs",
    "roc_auc",
    "separate",
    "signal_of",
    "suite_strengths",
    "window_means",
]
