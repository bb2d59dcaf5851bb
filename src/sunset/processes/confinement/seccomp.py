"""A filter of system calls, which denies the calls that Landlock, namespaces and the user leave open.

The filter is a program of the kernel's packet filter; `seccomp(2)` describes its input. System calls have the numbers
of x86-64 and of aarch64.
"""

import ctypes
import errno
import os
import platform
import struct
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Final

from sunset.processes.confinement.privileges import checked, libc

_ARCHITECTURES: Final = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}

Numbers = tuple[int, int]
"""Numbers of a system call on both architectures."""

_DENIED: Final[Mapping[str, Numbers]] = {
    # a process must not leave its group, which the keeper ends
    "setsid": (112, 157),
    "setpgid": (109, 154),
    # names that outlive a process, and that other processes can know or guess
    "shmget": (29, 194),
    "shmat": (30, 196),
    "shmctl": (31, 195),
    "msgget": (68, 186),
    "msgsnd": (69, 189),
    "msgrcv": (70, 188),
    "msgctl": (71, 187),
    "semget": (64, 190),
    "semop": (65, 193),
    "semtimedop": (220, 192),
    "semctl": (66, 191),
    "mq_open": (240, 180),
    "mq_unlink": (241, 181),
    "add_key": (248, 217),
    "request_key": (249, 218),
    "keyctl": (250, 219),
    # a process has all capabilities in a new namespace
    "unshare": (272, 97),
    "setns": (308, 268),
    # no filter sees its operations
    "io_uring_setup": (425, 425),
    # it opens files by their numbers, past the mounts, with the right to read files that a former root keeps
    "open_by_handle_at": (304, 265),
    # they show which files are used in folders that the process cannot list
    "inotify_add_watch": (254, 27),
    "fanotify_init": (300, 262),
    # Landlock denies it only from version 3 on
    "truncate": (76, 45),
}

_CLONE, _CLONE3, _SOCKET, _SOCKETPAIR, _PRCTL = (56, 220), (435, 435), (41, 198), (53, 199), (157, 167)
_SET_SIGNAL_OF_PARENTS_DEATH: Final = 1
"""PR_SET_PDEATHSIG: a process must not outlive its keeper."""
_SIGNALS: Final = ((62, 129), (234, 131), (129, 138), (297, 240))
"""kill, tgkill, rt_sigqueueinfo, rt_tgsigqueueinfo: the first argument is the process."""
_OTHER_SIGNALS: Final = ((200, 130), (424, 424))
"""tkill, pidfd_send_signal."""
_NAMESPACES: Final = 0x7E020080  # time, mount, cgroup, UTS, IPC, user, process, network
_FAMILIES: Final = (2, 10)
"""AF_INET and AF_INET6."""
_NETLINK: Final = 16
"""AF_NETLINK; by its protocol 0 the C library finds addresses, and others show processes and sockets."""
_STREAM, _SEQPACKET, _TYPE = 1, 5, 0xF

_ALLOW: Final = 0x7FFF0000
_DENY: Final = 0x00050000 | errno.EPERM
_UNKNOWN: Final = 0x00050000 | errno.ENOSYS
_LOAD, _RETURN, _AND = 0x20, 0x06, 0x54
_EQUAL, _AT_LEAST, _ANY_BIT = 0x15, 0x35, 0x45
_NUMBER, _ARCHITECTURE, _ARGUMENTS = 0, 4, 16
_X32: Final = 0x40000000

_GET_SECCOMP, _SET_SECCOMP, _FILTER = 21, 22, 2

_INSTRUCTION: Final = struct.Struct("=HBBI")
Instruction = tuple[int, int, int, int]
"""Code, instructions to skip if true, if false, value."""
_RETURN_DENY: Final = (_RETURN, 0, 0, _DENY)
_RETURN_ALLOW: Final = (_RETURN, 0, 0, _ALLOW)


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_ushort), ("code", ctypes.c_char_p))


def can_filter_calls() -> bool:
    """Return whether this system has filters of system calls, and an architecture that this module knows."""
    if sys.platform != "linux" or platform.machine() not in _ARCHITECTURES:
        return False
    return int(libc().prctl(_GET_SECCOMP, 0, 0, 0, 0)) >= 0


def filter_calls(*, signals: bool) -> None:
    """Deny system calls to this thread and its children for ever, where `can_filter_calls`.

    Args:
        signals: whether Landlock restricts signals; if not, the process can signal only itself and its group.
    """
    if can_filter_calls():
        code = filter_program(signals=signals)
        program = _Program(len(code) // _INSTRUCTION.size, code)
        checked(libc().prctl(_SET_SECCOMP, _FILTER, ctypes.byref(program), 0, 0))


@cache
def filter_program(*, signals: bool) -> bytes:
    """Return the filter for this machine; without `signals` for this process only."""
    machine = platform.machine()
    column = [*_ARCHITECTURES].index(machine)
    program: list[Instruction] = [
        (_LOAD, 0, 0, _ARCHITECTURE),
        (_EQUAL, 1, 0, _ARCHITECTURES[machine]),
        _RETURN_DENY,
        (_LOAD, 0, 0, _NUMBER),
    ]
    if machine == "x86_64":  # the same calls have other numbers there
        program += [(_AT_LEAST, 0, 1, _X32), _RETURN_DENY]
    tests = [*_tests(), *([] if signals else _signal_tests())]
    for numbers, test in tests:
        program += [(_EQUAL, 0, len(test), numbers[column]), *test]
    return b"".join(_INSTRUCTION.pack(*instruction) for instruction in [*program, _RETURN_ALLOW])


def _tests() -> Iterator[tuple[Numbers, list[Instruction]]]:
    """Yield numbers of calls, and the instructions for each, which end in a return."""
    for numbers in _DENIED.values():
        yield numbers, [_RETURN_DENY]
    # a filter cannot see its flags; the C library then calls clone
    yield _CLONE3, [(_RETURN, 0, 0, _UNKNOWN)]
    yield _CLONE, [_argument(0), (_ANY_BIT, 0, 1, _NAMESPACES), _RETURN_DENY, _RETURN_ALLOW]
    # other families are local: D-Bus, Docker, X11
    netlink = [(_EQUAL, 0, 4, _NETLINK), _argument(2), *_allow_any([0])]
    yield _SOCKET, [_argument(0), *netlink, *_allow_any(_FAMILIES)]
    # a pair for datagrams could send to any path
    yield _SOCKETPAIR, [_argument(1), (_AND, 0, 0, _TYPE), *_allow_any((_STREAM, _SEQPACKET))]
    yield _PRCTL, [_argument(0), (_EQUAL, 0, 1, _SET_SIGNAL_OF_PARENTS_DEATH), _RETURN_DENY, _RETURN_ALLOW]


def _signal_tests() -> Iterator[tuple[Numbers, list[Instruction]]]:
    """Yield as `_tests` for signals, which Landlock restricts from Linux 6.12 on."""
    own = os.getpid()
    for numbers in _SIGNALS:
        yield numbers, [_argument(0), *_allow_any([0, own, -own & 0xFFFFFFFF])]
    for numbers in _OTHER_SIGNALS:
        yield numbers, [_RETURN_DENY]


def _argument(index: int) -> Instruction:
    """Return an instruction that loads the lower half of an argument, which is first on both architectures."""
    return _LOAD, 0, 0, _ARGUMENTS + 8 * index


def _allow_any(values: Iterable[int]) -> list[Instruction]:
    """Allow the call for some loaded values, and deny it for all others."""
    allowed = [part for value in values for part in ((_EQUAL, 0, 1, value), _RETURN_ALLOW)]
    return [*allowed, _RETURN_DENY]
