"""From the record of a run to the log that the published exemplar would have written of it."""

from collections.abc import Sequence

from sunset.interfaces.system_interfaces.msg import FaultInjection, FrameEvaluation
from sunset.metrics import LogRow, LogSource, Timeline, rule_rows
from sunset.recording.timelines import start_of
from sunset.recording.values import RecordedMessage
from sunset.system import LOG_TOPIC


def published_log(messages: Sequence[RecordedMessage], observed: Timeline) -> list[LogRow]:
    """Return the rows of a run's log in order of time.

    Args:
        messages: of the record, those of `measured_topics` among them.
        observed: the time line that was made of them.
    """
    start_ns = start_of([one for one in messages if one.topic == LOG_TOPIC])
    rows = []
    for recorded in messages:
        match recorded.message:
            case FrameEvaluation(iou=iou):
                rows.append(LogRow(recorded.time_ns, LogSource.EVALUATOR, iou=iou))
            case FaultInjection(fault=fault):
                rows.append(LogRow(recorded.time_ns, LogSource.SCENARIO_EXECUTOR, fault=fault))
    return sorted([*rows, *rule_rows(observed, start_ns)], key=lambda row: row.time_ns)
