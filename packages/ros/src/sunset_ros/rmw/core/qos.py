"""Quality of service: profiles, and which profiles match."""

from dataclasses import dataclass
from enum import IntEnum

from sunset_ros.errors import MiddlewareError


class HistoryPolicy(IntEnum):
    """How many samples an endpoint keeps."""

    KEEP_LAST = 1
    KEEP_ALL = 2


class ReliabilityPolicy(IntEnum):
    """Whether lost samples are sent again."""

    RELIABLE = 1
    BEST_EFFORT = 2


class DurabilityPolicy(IntEnum):
    """Whether a writer keeps samples for readers that come later."""

    TRANSIENT_LOCAL = 1
    VOLATILE = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class QoSProfile:
    """The policies of one endpoint."""

    depth: int = 10  #: samples kept when `history` is KEEP_LAST, at least 1
    history: HistoryPolicy = HistoryPolicy.KEEP_LAST
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE
    lifespan_ns: int | None = (
        None  #: the age from which late readers do not receive a kept sample; None for no limit
    )

    def __post_init__(self) -> None:
        """Raise a `MiddlewareError` if the depth is not a whole number of at least 1."""
        if isinstance(self.depth, bool) or not isinstance(self.depth, int) or self.depth < 1:
            raise MiddlewareError(f"A QoS depth must be a whole number of at least 1, got {self.depth!r}.")

    @property
    def limit(self) -> int | None:
        """The number of samples kept, or None for all."""
        return self.depth if self.history is HistoryPolicy.KEEP_LAST else None


def incompatibility(offered: QoSProfile, requested: QoSProfile) -> str | None:
    """Return the policy for which a reader requests more than a writer offers, or None when the two match.

    >>> incompatibility(QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT), QoSProfile())
    'reliability'
    """
    if offered.reliability > requested.reliability:
        return "reliability"
    if offered.durability > requested.durability:
        return "durability"
    return None
