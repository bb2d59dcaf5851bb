"""Figures of a run, measured from outside: pure functions of a timeline."""

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations, unnecessary_redeploys
from sunset.metrics.confusion import (
    ClassCounts,
    accumulated_iou,
    class_iou,
    count_classes,
    image_iou,
    normalised_entropy,
)
from sunset.metrics.episodes import Episode, Spell, excesses, failure_episodes, silences, spells_of
from sunset.metrics.score import RunMetrics, downtime, score, utility_of
from sunset.metrics.timeline import (
    NUMBER_OF_CLASSES,
    Command,
    Diagnosis,
    Evidence,
    Frames,
    Injection,
    Samples,
    Setting,
    Timeline,
)
from sunset.metrics.treatments import FATES, FaultOutcome, Settings

__all__ = [
    "FATES",
    "NUMBER_OF_CLASSES",
    "ClassCounts",
    "Command",
    "Diagnosis",
    "Episode",
    "Evidence",
    "ExecutedAdaptation",
    "FaultOutcome",
    "Frames",
    "Injection",
    "RunMetrics",
    "Samples",
    "Setting",
    "Settings",
    "Spell",
    "Timeline",
    "accumulated_iou",
    "class_iou",
    "count_classes",
    "downtime",
    "excesses",
    "executed_adaptations",
    "failure_episodes",
    "image_iou",
    "normalised_entropy",
    "score",
    "silences",
    "spells_of",
    "unnecessary_redeploys",
    "utility_of",
]
