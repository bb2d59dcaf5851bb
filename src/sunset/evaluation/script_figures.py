"""The paper's evaluation script: its figures, of all logs of a managing system together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, pstdev
from types import MappingProxyType
from typing import Final, Self

from sunset.metrics import SCRIPT_FIGURES, LogFigures, Pool

SCRIPT_METHOD: Final = (
    "By the paper's evaluation script: mean ± population standard deviation over logs; of t_react and IoU over the "
    "values of all logs at once."
)
"""How these figures come about, in words."""


@dataclass(frozen=True, slots=True)
class ScriptFigures:
    """What the script gives for several logs.

    Attributes:
        logs: how many there are.
        refused: why it counts only the redeploys of some of them, a reason each.
        figures: each of `SCRIPT_FIGURES` → its mean and standard deviation; None where no log has one.
    """

    logs: int
    refused: tuple[str, ...]
    figures: Mapping[str, tuple[float, float] | None]

    @classmethod
    def of(cls, logs: Sequence[LogFigures]) -> Self:
        """Return the figures of logs."""
        counted = [log for log in logs if not log.refused]
        values = (
            _spread([log.succeeded / log.executed for log in counted if log.executed]),
            _pooled([log.reactions_s for log in counted]),
            _spread([log.redeploys_unnecessary for log in logs]),
            _spread([log.t_down_s for log in counted]),
            _pooled([log.ious for log in counted]),
        )
        return cls(
            logs=len(logs),
            refused=tuple(log.refused for log in logs if log.refused),
            figures=MappingProxyType(dict(zip(SCRIPT_FIGURES, values, strict=True))),
        )

    @property
    def counts(self) -> bool:
        """Whether the script counts all figures of at least one log."""
        return len(self.refused) < self.logs

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        figures = {
            name: None if pair is None else dict(zip(("mean", "std"), pair, strict=True))
            for name, pair in self.figures.items()
        }
        return {"logs": self.logs, "logs_refused": len(self.refused), **figures}


def _spread(values: Sequence[float]) -> tuple[float, float] | None:
    return (fmean(values), pstdev(values)) if values else None


def _pooled(pools: Sequence[Pool]) -> tuple[float, float] | None:
    pool = sum(pools, Pool())
    return (pool.mean, pool.deviation) if pool.number else None
