"""What a live middleware is: one on which processes of the operating system meet, in real time."""

from abc import ABC, abstractmethod
from contextlib import AbstractContextManager
from typing import Protocol, Self

from sunset.rmw.core.node import Middleware
from sunset.rmw.core.tap import Tap


class LiveProcess(Middleware):
    """This process on a network, in a domain; as a context manager it leaves the network when the context ends."""

    domain_id: int

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()


class LiveObserver(ABC):
    """Tells a tap what happens in a domain, and takes part in nothing; as a context manager it leaves at its end."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close()

    @abstractmethod
    def check(self) -> None:
        """Raise what the tap raised, if it did; it was told nothing since.

        Raises:
            Exception: what the tap raised.
        """

    @abstractmethod
    def finish(self) -> None:
        """Tell the tap what has come, and nothing more from now on.

        Raises:
            Exception: what the tap raised.
        """

    @abstractmethod
    def close(self) -> None:
        """Tell the tap what has come, and leave the network.

        Raises:
            Exception: what the tap raised.
        """


class LiveMiddleware(Protocol):
    """What a package of a live middleware offers; the package itself is one."""

    @property
    def RMW_IMPLEMENTATION(self) -> str:  # noqa: N802  the environment's name for it
        """What ROS 2 calls the middleware that its nodes must have to meet ours."""

    def join(
        self, *, domain_id: int | None = None, network: bool = False, distro: str | None = None
    ) -> LiveProcess:
        """Join the network.

        Args:
            domain_id: processes hear those of the same domain only; ROS_DOMAIN_ID, else 0, if None.
            network: whether to be heard beyond this computer.
            distro: the ROS 2 distribution of other nodes; None to find out.

        Raises:
            MiddlewareError: a setting cannot be used, or the domain cannot be entered.
        """

    def observe(self, tap: Tap, *, domain_id: int | None = None) -> LiveObserver:
        """Return what tells a tap everything that happens in a domain.

        Raises:
            MiddlewareError: as for `join`.
        """

    def prepare(self) -> None:
        """Make what every process needs, so that forks of this one have it; join no network, start no thread."""

    def free_domain_id(self) -> AbstractContextManager[int]:
        """Reserve a domain in which no process of this computer is.

        Raises:
            MiddlewareError: there is none.
        """

    def sole_system(self, domain_id: int) -> AbstractContextManager[None]:
        """Keep other systems of this computer out of a domain.

        Raises:
            MiddlewareError: one is there.
        """

    def versions(self) -> dict[str, str]:
        """Return what a live record depends on: distribution → version."""
