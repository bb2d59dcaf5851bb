"""Modelled durations of callbacks."""

from collections.abc import Callable, Mapping
from math import isfinite

from sunset_ros.errors import MiddlewareError
from sunset_ros.seeding import check_seed, generator

OTHER_CALLBACK_NS = 200_000
"""Nanoseconds of all callbacks but subscriptions of listed nodes."""


class ComputeModel:
    """Draws the duration of callbacks.

    Args:
        seconds: full name of a node → mean duration of a subscription callback.
        jitter: half-width of the uniform factor, in [0, 1): a callback takes seconds * (1 ± jitter).
        seed: a whole number in [0, 2**32 - 1].

    Raises:
        MiddlewareError: a duration is negative or not finite, or the jitter is out of range.
    """

    def __init__(self, seconds: Mapping[str, float], jitter: float, seed: int) -> None:
        for node, duration in seconds.items():
            if not (isfinite(duration) and duration >= 0):
                raise MiddlewareError(
                    f"The modelled duration of node {node!r} must be at least 0 s, got {duration}."
                )
        if not 0 <= jitter < 1:
            raise MiddlewareError(f"The jitter of modelled durations must be in [0, 1), got {jitter}.")
        self._seconds = dict(seconds)
        self._jitter = jitter
        self._seed = check_seed(seed)
        self._samplers: dict[str, Callable[[], int]] = {}

    def sampler(self, node: str) -> Callable[[], int] | None:
        """Return a function that draws durations in ns for a node; None if the node is not listed.

        A redeployed node continues the stream of random numbers.
        """
        if node not in self._seconds:
            return None
        if node not in self._samplers:
            random = generator(self._seed, "compute", node.rpartition("/")[2]).random
            low = self._seconds[node] * 1e9 * (1 - self._jitter)
            width = self._seconds[node] * 1e9 * 2 * self._jitter
            self._samplers[node] = lambda: round(low + width * random())
        return self._samplers[node]
