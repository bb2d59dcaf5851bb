"""How well a managing system did, measured from outside: pure functions from a timeline to figures."""

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations, unnecessary_redeploys
from sunset.metrics.confusion import ClassCounts, accumulated_iou, class_iou, count_classes, image_iou
from sunset.metrics.downtime import downtime
from sunset.metrics.entropy import normalised_entropy
from sunset.metrics.episodes import Episode, Spell, excesses, failure_episodes, silences
from sunset.metrics.published_log import (
    SCRIPT_FIGURES,
    WALL_NS,
    LogFigures,
    LogRow,
    LogSource,
    Pool,
    StrategyStatus,
    log_figures,
)
from sunset.metrics.published_rules import rule_rows
from sunset.metrics.score import RunMetrics, score, utility_of
from sunset.metrics.settings import Settings
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
from sunset.metrics.treatments import FATES, FaultOutcome

__all__ = [
    "FATES",
    "NUMBER_OF_CLASSES",
    "SCRIPT_FIGURES",
    "WALL_NS",
    "ClassCounts",
    "Command",
    "Diagnosis",
    "Episode",
    "Evidence",
    "ExecutedAdaptation",
    "FaultOutcome",
    "Frames",
    "Injection",
    "LogFigures",
    "LogRow",
    "LogSource",
    "Pool",
    "RunMetrics",
    "Samples",
    "Setting",
    "Settings",
    "Spell",
    "StrategyStatus",
    "Timeline",
    "accumulated_iou",
    "class_iou",
    "count_classes",
    "downtime",
    "excesses",
    "executed_adaptations",
    "failure_episodes",
    "image_iou",
    "log_figures",
    "normalised_entropy",
    "rule_rows",
    "score",
    "silences",
    "unnecessary_redeploys",
    "utility_of",
]
