"""Domain ids that separate systems on a computer."""

import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import count

from sunset_ros.errors import MiddlewareError

_DOMAINS = range(1, 102)
"""0 is the default of ROS 2; on Linux, any program may take the ports of ids above 101."""

_FIRST_PORT = 7400
_PORTS_PER_DOMAIN = 250
_LOCK_PORT = 249
"""Offset from a domain's first port, beyond the ports of its 33 participants."""

_SYSTEM_PORT = 9
"""The same for a system that runs in the domain, before the ports of participants: domain 232 ends at offset 135."""

_LOOPBACK = "127.0.0.1"

_OFFSETS = (0, *range(10, 76))
"""Offsets from a domain's first port: for multicast, and two for each participant."""

_turns = count(os.getpid())


@contextmanager
def free_domain_id() -> Iterator[int]:
    """Reserve an unused domain id from 1 to 101 of this computer while the context lasts.

    Callers of other users and programs do not get it, even if this process dies. A domain is used again as late as
    possible, since participants remember lost participants for some seconds.

    Raises:
        MiddlewareError: all are in use.
    """
    turn = next(_turns)
    for index in range(len(_DOMAINS)):
        domain = _DOMAINS[(turn + index) % len(_DOMAINS)]
        first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain
        with ExitStack() as held:
            if _bind(held, first + _LOCK_PORT) and _is_unused(first):
                yield domain
                return
    raise MiddlewareError(f"All domain ids from {_DOMAINS[0]} to {_DOMAINS[-1]} are in use.")


@contextmanager
def sole_system(domain_id: int) -> Iterator[None]:
    """Keep other systems of this computer, of any user, out of a domain while the context lasts.

    Raises:
        MiddlewareError: another system is there.
    """
    with ExitStack() as held:
        if not _bind(held, _FIRST_PORT + _PORTS_PER_DOMAIN * domain_id + _SYSTEM_PORT, _LOOPBACK):
            raise MiddlewareError(
                f"Another system runs in domain {domain_id} on this computer: end it, or choose another domain."
            )
        yield


def _is_unused(first: int) -> bool:
    with ExitStack() as probes:
        return all(_bind(probes, first + offset) for offset in _OFFSETS)


def _bind(stack: ExitStack, port: int, address: str = "") -> bool:
    """Take a UDP port, of all addresses or a given address, until the stack is left; return whether it was free."""
    port_holder = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    try:
        port_holder.bind((address, port))
    except OSError:
        return False
    return True
