"""The effects of faults and cures on frames, and thresholds that separate healthy from faulty frames."""

from sunset.calibration.conditions import SHARPNESS as SHARPNESS
from sunset.calibration.conditions import Condition as Condition
from sunset.calibration.conditions import CurvesPlan as CurvesPlan
from sunset.calibration.conditions import cure_of as cure_of
from sunset.calibration.conditions import effects as effects
from sunset.calibration.conditions import plan_curves as plan_curves
from sunset.calibration.conditions import possible_pairs as possible_pairs
from sunset.calibration.conditions import signal_of as signal_of
from sunset.calibration.conditions import suite_strengths as suite_strengths
from sunset.calibration.flight import AUC as AUC
from sunset.calibration.flight import FlightThresholds as FlightThresholds
from sunset.calibration.flight import fit_to_flight as fit_to_flight
from sunset.calibration.flight import flight_thresholds as flight_thresholds
from sunset.calibration.thresholds import Values as Values
from sunset.calibration.thresholds import chosen_frames as chosen_frames
from sunset.calibration.thresholds import part_entropy as part_entropy
from sunset.calibration.thresholds import part_sharpness as part_sharpness
from sunset.calibration.thresholds import roc_auc as roc_auc
from sunset.calibration.thresholds import separate as separate
from sunset.calibration.thresholds import window_means as window_means
from sunset.system import SAMPLES as SAMPLES
