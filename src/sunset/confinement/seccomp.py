"""A filter of system calls: what no managing system needs, and what Landlock leaves open, is refused with EPERM.

The filter is a program of the kernel's packet filter, made here: `seccomp(2)` says what it is run on. Numbers of system
calls are those of x86-64 and of aarch64.
"""

import ctypes
import errno
import os
import platform
import struct
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Final

from sunset.confinement._libc import checked, libc

_ARCHITECTURES: Final = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}

# name: (x86-64, aarch64); -1 where there is none
_DENIED: Final = {
    # other processes' memory and files
    "ptrace": (101, 117),
    "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271),
    "kcmp": (312, 272),
    "pidfd_getfd": (438, 438),
    "process_madvise": (440, 440),
    "process_mrelease": (448, 448),
    "perf_event_open": (298, 241),
    "bpf": (321, 280),
    "userfaultfd": (323, 282),
    "move_pages": (279, 239),
    "migrate_pages": (256, 238),
    # what outlives a process, or is shared with others that know its name
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
    # the process group is all that a process has started
    "setsid": (112, 157),
    "setpgid": (109, 154),
    # calls that no filter sees
    "io_uring_setup": (425, 425),
    "io_uring_enter": (426, 426),
    "io_uring_register": (427, 427),
    # another view of the file system
    "mount": (165, 40),
    "umount2": (166, 39),
    "pivot_root": (155, 41),
    "chroot": (161, 51),
    "open_tree": (428, 428),
    "move_mount": (429, 429),
    "fsopen": (430, 430),
    "fsconfig": (431, 431),
    "fsmount": (432, 432),
    "fspick": (433, 433),
    "mount_setattr": (442, 442),
    "open_tree_attr": (467, 467),
    "statmount": (457, 457),
    "listmount": (458, 458),
    "setns": (308, 268),
    "unshare": (272, 97),
    "name_to_handle_at": (303, 264),
    "open_by_handle_at": (304, 265),
    "quotactl": (179, 60),
    "quotactl_fd": (443, 443),
    # names of files in folders that are closed, as they are made and opened
    "inotify_add_watch": (254, 27),
    "fanotify_init": (300, 262),
    "fanotify_mark": (301, 263),
    # what Landlock does not govern of files
    "truncate": (76, 45),
    "chmod": (90, -1),
    "fchmod": (91, 52),
    "fchmodat": (268, 53),
    "fchmodat2": (452, 452),
    "chown": (92, -1),
    "fchown": (93, 55),
    "lchown": (94, -1),
    "fchownat": (260, 54),
    "utime": (132, -1),
    "utimes": (235, -1),
    "futimesat": (261, -1),
    "utimensat": (280, 88),
    "setxattr": (188, 5),
    "lsetxattr": (189, 6),
    "fsetxattr": (190, 7),
    "removexattr": (197, 14),
    "lremovexattr": (198, 15),
    "fremovexattr": (199, 16),
    "setxattrat": (463, 463),
    "removexattrat": (466, 466),
    "file_setattr": (469, 469),
    # memory that no limit counts
    "memfd_create": (319, 279),
    "memfd_secret": (447, 447),
    # other processes' share of the computer, and the computer itself
    "setpriority": (141, 140),
    "ioprio_set": (251, 30),
    "reboot": (169, 142),
    "swapon": (167, 224),
    "swapoff": (168, 225),
    "init_module": (175, 105),
    "finit_module": (313, 273),
    "delete_module": (176, 106),
    "kexec_load": (246, 104),
    "kexec_file_load": (320, 294),
    "acct": (163, 89),
    "settimeofday": (164, 170),
    "clock_settime": (227, 112),
    "clock_adjtime": (305, 266),
    "adjtimex": (159, 171),
    "sethostname": (170, 161),
    "setdomainname": (171, 162),
    "iopl": (172, -1),
    "ioperm": (173, -1),
    "syslog": (103, 116),
    "vhangup": (153, 58),
}

_CLONE: Final = (56, 220)
_CLONE3: Final = (435, 435)
_SOCKET: Final = (41, 198)
_SOCKETPAIR: Final = (53, 199)
_PRCTL: Final = (157, 167)
_MMAP: Final = (9, 222)
_FCNTL: Final = (72, 25)
_IOCTL: Final = (16, 29)
_OWN_ONLY: Final = ((302, 261), (203, 122), (144, 119), (142, 118), (314, 274))
"""prlimit64, sched_setaffinity, sched_setscheduler, sched_setparam, sched_setattr: of the caller itself, which is 0."""
_CLOCKS: Final = ((228, 113), (229, 114), (230, 115), (222, 107))
"""clock_gettime, clock_getres, clock_nanosleep, timer_create."""
_SIGNALS: Final = ((62, 129), (234, 131), (129, 138), (297, 240))
"""kill, tgkill, rt_sigqueueinfo, rt_tgsigqueueinfo: the first argument says to which process."""
_SIGNALS_ELSEWHERE: Final = ((200, 130), (424, 424))
"""tkill, pidfd_send_signal."""

_NAMESPACES: Final = 0x7E020080  # time, mount, cgroup, UTS, IPC, user, process, network
_INET, _INET6, _NETLINK = 2, 10, 16
_STREAM, _SEQPACKET, _TYPE = 1, 5, 0xF
_SET_DEATH_SIGNAL, _KILL = 1, 9
_OWNED: Final = (8, 15, 1024, 1026)
"""F_SETOWN, F_SETOWN_EX, F_SETLEASE, F_NOTIFY: signals to others, others' waiting, and what they read."""
_OWNING: Final = (0x8901, 0x8902, 0x5412)
"""FIOSETOWN, SIOCSPGRP; TIOCSTI."""
_SHARED, _ANONYMOUS, _GROWS_DOWN = 0x01, 0x20, 0x100
_NEGATIVE, _OF_A_THREAD = 0x80000000, 4

_ALLOW: Final = 0x7FFF0000
_DENY: Final = 0x00050000 | errno.EPERM
_UNKNOWN: Final = 0x00050000 | errno.ENOSYS
_LOAD, _RETURN, _AND = 0x20, 0x06, 0x54
_EQUAL, _AT_LEAST, _ANY_BIT = 0x15, 0x35, 0x45
_NUMBER, _ARCHITECTURE, _ARGUMENTS = 0, 4, 16
_X32: Final = 0x40000000

_GET_SECCOMP, _SET_SECCOMP, _FILTER, _NO_NEW_PRIVILEGES = 21, 22, 2, 38

_INSTRUCTION: Final = struct.Struct("=HBBI")
Instruction = tuple[int, int, int, int]
"""Code, instructions to skip if true, if false, value."""


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_ushort), ("code", ctypes.c_char_p))


def can_filter_calls() -> bool:
    """Return whether this system has filters of system calls, and this module knows its calls."""
    if sys.platform != "linux" or platform.machine() not in _ARCHITECTURES:
        return False
    return int(libc().prctl(_GET_SECCOMP, 0, 0, 0, 0)) >= 0


def forgo_privileges() -> None:
    """Never let this process, nor what it starts, gain privileges by executing a file, where the system can.

    Raises:
        OSError: the system refuses.
    """
    if sys.platform == "linux":
        checked(libc().prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0))


def filter_calls(*, network: bool, signals: bool) -> None:
    """Refuse system calls to this thread and to what it starts, for ever, where the system can.

    Args:
        network: whether it may have sockets of the internet.
        signals: whether something else keeps it from signalling processes that are not its own; if not, it can signal
            itself and its process group only.

    Raises:
        OSError: the system can, but refuses.
    """
    if not can_filter_calls():
        return
    code = filter_program(network=network, signals=signals)
    program = _Program(len(code) // _INSTRUCTION.size, code)
    checked(libc().prctl(_SET_SECCOMP, _FILTER, ctypes.byref(program), 0, 0))


@cache
def filter_program(*, network: bool, signals: bool) -> bytes:
    """Return the filter of this machine's architecture, without `signals` for this process only; as `filter_calls`."""
    machine = platform.machine()
    column = [*_ARCHITECTURES].index(machine)
    program: list[Instruction] = [
        (_LOAD, 0, 0, _ARCHITECTURE),
        (_EQUAL, 1, 0, _ARCHITECTURES[machine]),
        (_RETURN, 0, 0, _DENY),
        (_LOAD, 0, 0, _NUMBER),
    ]
    if machine == "x86_64":  # the same calls have other numbers there
        program += [(_AT_LEAST, 0, 1, _X32), (_RETURN, 0, 0, _DENY)]
    for calls, test in _tests(network=network, signals=signals):
        if calls[column] >= 0:
            program += [(_EQUAL, 0, len(test), calls[column]), *test]
    return b"".join(_INSTRUCTION.pack(*instruction) for instruction in [*program, _allow()])


def _tests(*, network: bool, signals: bool) -> Iterator[tuple[tuple[int, int], list[Instruction]]]:
    """Yield numbers of calls, and what is run of each; all of it ends in a return."""
    deny: list[Instruction] = [(_RETURN, 0, 0, _DENY)]
    for numbers in _DENIED.values():
        yield numbers, deny
    yield _CLONE3, [(_RETURN, 0, 0, _UNKNOWN)]  # its flags are out of sight; the C library then takes clone
    yield _CLONE, [_argument(0), (_ANY_BIT, 1, 0, _NAMESPACES), _allow(), *deny]
    families = [_INET, _INET6] if network else []
    yield (
        _SOCKET,
        [
            _argument(0),
            *_allow_any(families),
            (_EQUAL, 0, 3, _NETLINK),  # of the routes only, which the C library asks for addresses
            _argument(2),
            *_allow_any([0]),
            *deny,
        ],
    )
    # one of datagrams could be sent to any path
    yield (
        _SOCKETPAIR,
        [_argument(1), (_AND, 0, 0, _TYPE), *_allow_any([_STREAM, _SEQPACKET]), *deny],
    )
    yield (
        _PRCTL,
        [
            _argument(0),
            (_EQUAL, 1, 0, _SET_DEATH_SIGNAL),
            _allow(),
            _argument(1),
            *_allow_any([_KILL]),
            *deny,
        ],
    )
    yield _FCNTL, [_argument(1), *_deny_any(_OWNED), _allow()]
    yield _IOCTL, [_argument(1), *_deny_any(_OWNING), _allow()]
    yield (
        _MMAP,
        [
            _argument(3),
            (_ANY_BIT, 0, 1, _GROWS_DOWN),  # a stack, which the limit of memory does not count
            *deny,
            (_ANY_BIT, 1, 0, _ANONYMOUS),
            _allow(),
            (_ANY_BIT, 1, 0, _SHARED),
            _allow(),
            *deny,
        ],
    )
    for numbers in _OWN_ONLY:
        yield numbers, [_argument(0), *_allow_any([0]), *deny]
    for numbers in _CLOCKS:  # not those of other processes
        yield (
            numbers,
            [
                _argument(0),
                (_ANY_BIT, 1, 0, _NEGATIVE),
                _allow(),
                (_ANY_BIT, 0, 1, _OF_A_THREAD),
                _allow(),
                *deny,
            ],
        )
    if not signals:
        own = os.getpid()
        for numbers in _SIGNALS:
            yield numbers, [_argument(0), *_allow_any([0, own, -own & 0xFFFFFFFF]), *deny]
        for numbers in _SIGNALS_ELSEWHERE:
            yield numbers, deny


def _argument(index: int) -> Instruction:
    """Load the lower half of an argument; both architectures have the lower half first."""
    return _LOAD, 0, 0, _ARGUMENTS + 8 * index


def _allow() -> Instruction:
    return _RETURN, 0, 0, _ALLOW


def _allow_any(values: Iterable[int]) -> list[Instruction]:
    return [part for value in values for part in ((_EQUAL, 0, 1, value), _allow())]


def _deny_any(values: Iterable[int]) -> list[Instruction]:
    return [part for value in values for part in ((_EQUAL, 0, 1, value), (_RETURN, 0, 0, _DENY))]
