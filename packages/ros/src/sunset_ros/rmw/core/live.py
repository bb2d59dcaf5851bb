"""The interface of live middlewares, on which operating system processes communicate in real time."""

from abc import ABC, abstractmethod
from contextlib import AbstractContextManager
from typing import Protocol, Self

from sunset_ros.rmw.core.node import Middleware
from sunset_ros.rmw.core.tap import Tap


class LiveProcess(Middleware):
    """This process in a domain; as a context manager it leaves the network at the end."""

    domain_id: int

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()


class LiveObserver(ABC):
    """Passes the events of a domain to a tap; as a context manager it finishes and leaves at the end."""

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None: ...

    @abstractmethod
    def check(self) -> None:
        """Raise the exception of the tap, if it raised."""

    @abstractmethod
    def finish(self) -> None:
        """Pass the remaining events to the tap, and no more from now on; raise the exception of the tap."""


class LiveMiddleware(Protocol):
    """The interface of a live middleware's package."""

    @property
    def RMW_IMPLEMENTATION(self) -> str:  # noqa: N802  the environment's name for it
        """The RMW_IMPLEMENTATION of ROS 2 nodes that can communicate with ours."""

    def join(
        self, *, domain_id: int | None = None, network: bool = False, distro: str | None = None
    ) -> LiveProcess:
        """Join the network, of this computer unless `network`; None to find the domain and distribution out.

        Raises:
            MiddlewareError: a setting cannot be used, or the domain cannot be entered.
        """

    def observe(self, tap: Tap, *, domain_id: int | None = None) -> LiveObserver:
        """Return an observer that passes the events of a domain to a tap; raise as `join`."""

    def prepare(self) -> None:
        """Do the work that all forks of this process share; join no network, start no thread."""

    def free_domain_id(self) -> AbstractContextManager[int]:
        """Reserve an unused domain of this computer; raise a `MiddlewareError` if all are in use."""

    def sole_system(self, domain_id: int) -> AbstractContextManager[None]:
        """Keep other systems of this computer out of a domain; raise a `MiddlewareError` if one is there."""

    def versions(self) -> dict[str, str]:
        """Return the versions that a live record depends on, by distribution."""
