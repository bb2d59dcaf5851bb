"""Domain ids that no other system uses, so that systems on one computer do not hear each other."""

import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import count

from sunset.common.errors import MiddlewareError

_DOMAINS = range(1, 102)
"""0 is the default of all ROS 2 programs; the ports of those above 101 may be taken by any program on Linux."""

_FIRST_PORT = 7400
_PORTS_PER_DOMAIN = 250
_LOCK_PORT = 249
"""Added to a domain's first port: beyond those of the 33 participants that a domain may have on one computer."""

_SYSTEM_PORT = 9
"""Added likewise, for a system that runs in the domain: before those of the participants, since 135 is the last one
that domain 232 has room for."""

_LOOPBACK = "127.0.0.1"

_OFFSETS = (0, *range(10, 76))
"""Added to a domain's first port: for multicast, and two for each of those participants."""

_turns = count(os.getpid())


@contextmanager
def free_domain_id() -> Iterator[int]:
    """Reserve, while the context lasts, a domain id from 1 to 101 in which no process of this computer is.

    Other callers are kept off it, whatever user or program they are of, and even if this process dies. A domain comes
    last in turn after its use, for participants that died in it are remembered by others for some seconds.

    Raises:
        MiddlewareError: all are in use.
    """
    turn = next(_turns)
    for index in range(len(_DOMAINS)):
        domain = _DOMAINS[(turn + index) % len(_DOMAINS)]
        with _reserve(domain) as reserved:
            if reserved:
                yield domain
                return
    raise MiddlewareError(f"All domain ids from {_DOMAINS[0]} to {_DOMAINS[-1]} are in use.")


@contextmanager
def sole_system(domain_id: int) -> Iterator[None]:
    """Keep other systems of this computer, whatever user they are of, out of a domain while the context lasts.

    Raises:
        MiddlewareError: one is there.
    """
    with ExitStack() as held:
        if not _bind(held, _FIRST_PORT + _PORTS_PER_DOMAIN * domain_id + _SYSTEM_PORT, _LOOPBACK):
            raise MiddlewareError(
                f"Another system runs in domain {domain_id} on this computer: end it, or choose another domain."
            )
        yield


@contextmanager
def _reserve(domain: int) -> Iterator[bool]:
    first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain
    with ExitStack() as held:
        if not _bind(held, first + _LOCK_PORT):
            yield False
            return
        with ExitStack() as probes:
            unused = all(_bind(probes, first + offset) for offset in _OFFSETS)
        yield unused


def _bind(stack: ExitStack, port: int, address: str = "") -> bool:
    """Take a UDP port, of all addresses or of one, until the stack is left; return whether it was free."""
    held = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    try:
        held.bind((address, port))
    except OSError:
        return False
    return True
