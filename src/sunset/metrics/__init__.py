"""How well a managing system did, measured from outside: pure functions from a timeline to figures."""

from sunset.metrics.adaptations import ExecutedAdaptation, executed_adaptations, unnecessary_redeploys
from sunset.metrics.confusion import ClassCounts, accumulated_iou, class_iou, count_classes, image_iou
from sunset.metrics.downtime import downtime
from sunset.metrics.entropy import normalised_entropy
from sunset.metrics.episodes import Episode, Spell, excesses, failure_episodes, silences
from sunset.metrics.score import RunMetrics, score
from sunset.metrics.timeline import NUMBER_OF_CLASSES, Command, Frames, Injection, Samples, Timeline

__all__ = [
    "NUMBER_OF_CLASSES",
    "ClassCounts",
    "Command",
    "Episode",
    "ExecutedAdaptation",
    "Frames",
    "Injection",
    "RunMetrics",
    "Samples",
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
    "unnecessary_redeploys",
]
