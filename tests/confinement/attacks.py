"""What a hostile managing system may try; each attack returns what it got, which is nothing if it failed.

A server of confined processes imports this file, so that it needs nothing but Python. `attempt` is what it calls.
"""

import ctypes
import errno
import gc
import importlib
import json
import mmap
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, Final

SECRET: Final = re.compile(r"scenario-[0-9a-f]{32}")
ATTACKS: Final[dict[str, Callable[..., object]]] = {}
_LIBRARY: Final = ctypes.CDLL(None, use_errno=True)
_X86: Final = os.uname().machine == "x86_64"


def attack(function: Callable[..., object]) -> Callable[..., object]:
    ATTACKS[function.__name__] = function
    return function


def attempt(connection: socket.socket, task: dict[str, Any]) -> None:
    """Carry out an attack, and send what it got, and what kept it from more."""
    connection.sendall(json.dumps(outcome(**task)).encode() + b"\n")
    connection.recv(1)  # until it is told to end


def outcome(name: str, **arguments: Any) -> dict[str, object]:
    try:
        return {"got": ATTACKS[name](**arguments)}
    except (OSError, ImportError, subprocess.SubprocessError, MemoryError) as error:
        return {"got": None, "why": f"{type(error).__name__}: {error}"}


def _found(value: object) -> str | None:
    try:
        match = SECRET.search(value if isinstance(value, str) else repr(value))
    except Exception:  # noqa: BLE001  it holds what cannot be shown, as something of so many does
        return None
    return match and match.group()


def _first(attempts: Iterator[Callable[[], object]] | list[Callable[[], object]]) -> list[object]:
    """Return what those of several attempts got that got anything."""
    got: list[object] = []
    for one in attempts:
        with suppress(OSError, ImportError, AttributeError, subprocess.SubprocessError):
            if result := one():
                got.append(result)
    return got


def _done(function: Callable[..., object], *arguments: object) -> bool:
    """Call a function; return that it could be called."""
    function(*arguments)
    return True


def _call(number: tuple[int, int], *arguments: object) -> int:
    """Make a system call, by its numbers on x86-64 and aarch64."""
    words = [ctypes.c_long(one) if isinstance(one, int) else one for one in arguments]
    result: int = _LIBRARY.syscall(ctypes.c_long(number[not _X86]), *words)
    if result < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result


# what the interpreter holds


@attack
def objects() -> object:
    held = [one for one in gc.get_objects() if isinstance(one, dict | list | tuple)]
    return next((secret for one in held if (secret := _found(one))), None)


@attack
def modules() -> object:
    return [
        name
        for name in sys.modules
        if name.startswith(
            ("sunset.scenarios", "sunset.experiments", "sunset.data", "sunset.recording", "sunset.metrics")
        )
        or name.partition(".")[0] in {"numpy", "onnxruntime", "cv2"}
    ]


@attack
def frames() -> object:
    for newest in sys._current_frames().values():
        frame: FrameType | None = newest
        while frame is not None:
            if secret := _found({**frame.f_locals, **frame.f_globals}):
                return secret
            frame = frame.f_back
    return None


@attack
def memory() -> object:
    """Read all memory around objects; a page that is not there makes the kernel, not this process, complain."""
    read, write = os.pipe()
    pattern = re.compile(SECRET.pattern.encode())
    for region in {id(one) >> 20 for one in (*gc.get_objects(), *map(str, range(10_000)))}:
        for page in range(region << 20, (region + 1) << 20, 4096):
            if _LIBRARY.write(write, ctypes.c_void_p(page), 4096) == 4096 and (
                match := pattern.search(os.read(read, 4096))
            ):
                return match.group().decode()
    return None


@attack
def environment() -> object:
    return _found(dict(os.environ))


@attack
def arguments() -> object:
    return _found([sys.argv, sys.orig_argv, sys.path, sys.flags])


@attack
def open_files() -> object:
    """Return the files that are open, but for the standard ones, the socket, and what it dies to."""
    held = []
    for number in range(3, 4096):
        with suppress(OSError):
            held.append((number, os.fstat(number).st_mode))
    return held[2:]


# what the system tells


@attack
def proc(pid: str) -> object:
    names = (
        "environ",
        "cmdline",
        "maps",
        "mem",
        "status",
        "stat",
        "mountinfo",
        "cgroup",
        "comm",
        "auxv",
        "limits",
    )
    return _first(
        [
            *((lambda name=name: Path(f"/proc/{pid}/{name}").open("rb").read(9) and name) for name in names),
            *(
                (lambda name=name: os.listdir(f"/proc/{pid}/{name}"))
                for name in ("fd", "task", "cwd", "root")
            ),
        ]
    )


@attack
def links(pid: int) -> object:
    return _first([partial(os.readlink, f"/proc/{pid}/{name}") for name in ("exe", "cwd", "root", "fd/0")])


@attack
def proc_parent() -> object:
    return [proc(str(os.getppid())), links(os.getppid())]


@attack
def listing(folder: str) -> object:
    return _first(
        [
            lambda: os.listdir(folder),
            lambda: list(Path(folder).iterdir()),
            lambda: os.open(folder, os.O_RDONLY | os.O_DIRECTORY),
            lambda: os.listdir(os.open(folder, os.O_PATH)),
            lambda: subprocess.run(["ls", folder], capture_output=True, check=True).stdout.decode(),
            lambda: list(Path(folder).glob("*")),
        ]
    )


@attack
def grepping(folder: str, words: list[str]) -> object:
    """Return which files in a folder hold one of some words, in source or in bytecode."""
    found = []
    for place in sorted(Path(folder).rglob("*")):
        with suppress(OSError):
            text = place.read_bytes()
            found += [place.name for word in words if word.encode() in text][:1]
    return found


@attack
def asking(words: list[str]) -> object:
    """Return which words stand in what a managing system is told, and in what its system would say."""
    system = importlib.import_module("sunset.system")
    greeting = importlib.import_module("sunset.managing.symptoms").make_greeting(0.1, {})
    known = system.current_system()
    told = repr([greeting, known.faults, known.suites, known.fault_parameters, system.all_suites()])
    return [word for word in words if word in told]


@attack
def importing(module: str, attribute: str) -> object:
    return repr(getattr(importlib.import_module(module), attribute))


@attack
def noticing(folder: str) -> object:
    """Watch a folder, which tells the names of what is opened in it."""
    return _first(
        [
            lambda: _call((254, 27), _LIBRARY.inotify_init(), folder.encode(), 0xFFF),
            lambda: _call((300, 262), 0x200, 0) + 1,
        ]
    )


# files


@attack
def reading(file: str) -> object:
    def handle() -> object:
        buffer, mount = ctypes.create_string_buffer(256), ctypes.c_int()
        ctypes.memmove(buffer, (128).to_bytes(4, "little"), 4)
        _call((303, 264), -100, file.encode(), buffer, ctypes.byref(mount), 0)
        folder = os.open(Path(file).parent, os.O_PATH | os.O_DIRECTORY)
        return _found(os.read(_call((304, 265), folder, buffer, 0), 99).decode())

    def bound(name: str, how: Callable[[str, str], object]) -> object:
        how(file, name)
        return _found(Path(name).read_text("utf-8"))

    def imported() -> object:
        sys.path.insert(0, str(Path(file).parent))
        importlib.invalidate_caches()
        return _found(vars(importlib.import_module(Path(file).stem)))

    def mapped() -> object:
        with Path(file).open("rb") as opened, mmap.mmap(opened.fileno(), 0, prot=mmap.PROT_READ) as page:
            return _found(bytes(page).decode())

    how = (ctypes.c_uint64 * 3)(0, 0, 0)
    return _first(
        [
            lambda: _found(Path(file).read_text("utf-8")),
            lambda: _found(os.read(os.open(f"/proc/self/fd/{os.open(file, os.O_PATH)}", 0), 99).decode()),
            lambda: _found(os.read(_call((437, 437), -100, file.encode(), how, 24), 99).decode()),
            lambda: _found(
                os.read(os.open(Path(file).name, 0, dir_fd=os.open(Path(file).parent, os.O_PATH)), 99)
            ),
            mapped,
            lambda: bound("a", os.link),
            lambda: bound("b", os.symlink),
            lambda: bound("c", shutil.copyfile),
            lambda: _found(subprocess.run(["cat", file], capture_output=True, check=True).stdout.decode()),
            lambda: _found(subprocess.run(["sh", file], capture_output=True, check=False).stderr.decode()),
            lambda: _found(
                subprocess.run([sys.executable, file], capture_output=True, check=False).stderr.decode()
            ),
            imported,
            handle,
        ]
    )


@attack
def guessing(file: str) -> object:
    """Find out whether there is a file of a guessed name, and when it was used."""
    path = Path(file)
    return _first(
        [path.stat, path.exists, lambda: os.access(path, 0), partial(os.chdir, path.parent), path.lstat]
    )


@attack
def many_files() -> int:
    """Return how many mebibytes fit into all files together, those that have no name any more included."""
    mebibyte, files = bytes(1 << 20), []
    with suppress(OSError):
        for number in range(600):
            if not number % 30:
                files.append(Path("file").open("wb", buffering=0))  # noqa: SIM115  all stay open
                Path("file").unlink()
            files[-1].write(mebibyte)
    return sum(os.fstat(file.fileno()).st_size for file in files) >> 20


@attack
def writing(file: str) -> object:
    """Change a file, or what is beside it."""
    path = Path(file)

    def linked() -> bool:
        Path("mine").write_text("mine", "utf-8")
        os.link("mine", path.with_name("linked"))
        return True

    def moved() -> bool:
        Path("mine").write_text("mine", "utf-8")
        Path("mine").rename(path.with_name("moved"))
        return True

    return _first(
        [
            lambda: path.open("ab").write(b"!"),
            lambda: os.open(path, os.O_RDWR),
            lambda: os.open(path, os.O_RDONLY | os.O_TRUNC),
            lambda: _done(os.truncate, path, 1),
            lambda: path.with_name("new").write_bytes(b"!"),
            lambda: _done(path.with_name("folder").mkdir),
            lambda: _done(path.with_name("link").symlink_to, "/"),
            lambda: _done(os.mkfifo, path.with_name("pipe")),
            linked,
            moved,
            lambda: bool(path.rename(path.with_name("renamed"))),
            lambda: _done(path.unlink),
        ]
    )


@attack
def marking(file: str) -> object:
    """Change the attributes of a file."""
    path = Path(file)
    return _first(
        [
            lambda: _done(os.utime, path, (1, 1)),
            lambda: _done(os.setxattr, path, "user.mine", b"!"),
            lambda: _done(path.chmod, 0o444),
            lambda: _done(os.chown, path, os.getuid(), -1),
        ]
    )


@attack
def making_devices() -> object:
    """Make devices of the memory and of the disk in one's own folder."""
    disk = os.stat("/").st_dev
    return _first(
        [
            lambda: _done(os.mknod, "null", 0o20666, os.makedev(1, 3)),
            lambda: _done(os.mknod, "disk", 0o60666, disk),
            lambda: os.open("/dev/mem", 0),
            lambda: os.open("/dev/kmsg", 0),
            lambda: os.open("/dev/ptmx", os.O_RDWR),
            lambda: os.open("/dev/tty", 0),
        ]
    )


@attack
def large_file(size: int) -> object:
    with suppress(OSError), Path("large").open("wb") as file:
        file.seek(size)
        file.write(b"!")
        file.flush()
        return Path("large").stat().st_size
    return None


# other processes


@attack
def tracing(pid: int) -> object:
    buffer = ctypes.create_string_buffer(16)
    area = (ctypes.c_void_p * 2)(ctypes.addressof(buffer), 16)
    there = (ctypes.c_void_p * 2)(id(None), 16)
    nowhere = (ctypes.c_void_p * 2)(8, 16)

    def traced() -> bool:
        _call((101, 117), 0x4206, pid, 0, 0)  # PTRACE_SEIZE, which does not stop it
        return True

    def written() -> bool:
        try:
            _call((311, 271), pid, area, 1, nowhere, 1, 0)
        except OSError as error:
            return error.errno == errno.EFAULT  # it may write, but not to this address
        return True

    return _first(
        [
            traced,
            lambda: _call((310, 270), pid, area, 1, there, 1, 0),
            written,
            lambda: _call((312, 272), pid, pid, 0, 0, 0) + 1,
            lambda: _call((438, 438), os.pidfd_open(pid), 0, 0),
            lambda: os.open(f"/proc/{pid}/mem", 0),
            lambda: _call((308, 268), os.open(f"/proc/{pid}/ns/mnt", 0), 0) + 1,
        ]
    )


@attack
def signalling(pid: int) -> object:
    """Signal a process that does not mind, with a signal that is ignored."""
    number = signal.SIGWINCH

    return _first(
        [
            lambda: _done(os.kill, pid, 0),
            lambda: _done(os.kill, pid, number),
            lambda: _done(os.killpg, pid, number),
            lambda: _call((234, 131), pid, pid, int(number)) == 0,
            lambda: _call((200, 130), pid, int(number)) == 0,
            lambda: _done(signal.pidfd_send_signal, os.pidfd_open(pid), number),
            lambda: _call((129, 138), pid, int(number), ctypes.create_string_buffer(128)) == 0,
        ]
    )


@attack
def escaping() -> object:
    """Leave the process group."""
    return _first(
        [
            lambda: os.setsid(),
            lambda: _done(os.setpgid, 0, 0),
            lambda: subprocess.run(["true"], start_new_session=True, check=True),
            lambda: subprocess.run(["setsid", "--wait", "true"], check=True, capture_output=True),
        ]
    )


@attack
def daemon() -> list[int]:
    """Start what would go on: threads, and processes that ignore signals and have lost their parents."""
    pids = []
    read, write = os.pipe()
    for _ in range(3):
        if os.fork() == 0:
            for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGABRT):
                signal.signal(number, signal.SIG_IGN)
            with suppress(OSError):
                os.setsid()
            if os.fork() == 0:
                os.write(write, os.getpid().to_bytes(4, "little"))
                while True:
                    time.sleep(1)  # noqa: TID251  it is to be there
            os._exit(0)
        os.wait()
        pids.append(int.from_bytes(os.read(read, 4), "little"))
    for _ in range(3):
        threading.Thread(target=threading.Event().wait).start()
    return [*pids, os.getpid()]


@attack
def bomb() -> int:
    """Return how many processes could be started."""
    count = 0
    with suppress(OSError):
        while count < 2000:
            if os.fork() == 0:
                while True:
                    signal.pause()
            count += 1
    return count


# others that one can speak to, and what outlives a process


@attack
def sockets(path: str, abstract: str) -> object:
    def connected(address: str) -> bool:
        with socket.socket(socket.AF_UNIX) as one:
            one.connect(address)
        return True

    def sent() -> bool:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        with ours, theirs:
            return ours.sendto(b"!", f"{path}.datagrams") == 1

    def bound() -> bool:
        ours, theirs = socket.socketpair()
        with ours, theirs:
            theirs.close()
            ours.connect(path)
        return True

    def family(number: int, protocol: int = 0) -> bool:
        socket.socket(number, socket.SOCK_RAW, protocol).close()
        return True

    return _first(
        [
            lambda: connected(path),
            lambda: connected(f"\0{abstract}"),
            sent,
            bound,
            *((lambda number=number: family(number)) for number in (17, 38, 40)),
            lambda: family(16, 4),  # it lists the computer's sockets
        ]
    )


@attack
def internet(port: int) -> bool:
    with socket.create_connection(("127.0.0.1", port)):
        return True


@attack
def shared_memory(key: int) -> object:
    """Make what a later process could find by its key."""
    return _first(
        [
            lambda: _call((29, 194), key, 4096, 0o1666) + 1,
            lambda: _call((68, 186), key, 0o1666) + 1,
            lambda: _call((64, 190), key, 1, 0o1666) + 1,
            lambda: _call((71, 187), 0, 12, ctypes.create_string_buffer(256)) + 1,  # about all queues
            lambda: _call((240, 180), f"sunset-{key}".encode(), 0o102, 0o666, None) + 1,
            lambda: _call((248, 217), b"user", f"sunset-{key}".encode(), b"!", 1, -4),
            lambda: Path(f"/dev/shm/sunset-{key}").write_bytes(b"!"),  # noqa: S108  that is the attack
            lambda: Path(f"/tmp/sunset-{key}").write_bytes(b"!"),  # noqa: S108
            lambda: Path(f"/var/tmp/sunset-{key}").write_bytes(b"!"),  # noqa: S108
        ]
    )


def remove_shared_memory(key: int) -> None:
    """Remove what `shared_memory` has made, of whatever it could make."""
    name = f"sunset-{key}"
    removals: list[Callable[[], object]] = [
        lambda: _call((31, 195), _call((29, 194), key, 0, 0), 0, None),
        lambda: _call((71, 187), _call((68, 186), key, 0), 0, None),
        lambda: _call((66, 191), _call((64, 190), key, 0, 0), 0, 0),
        lambda: _call((241, 181), name.encode()),
        lambda: _call((250, 219), 9, _call((250, 219), 10, -4, b"user", name.encode(), 0), -4),
    ]
    for remove in removals:
        with suppress(OSError):  # there is none
            remove()
    for folder in ("/dev/shm", "/tmp", "/var/tmp"):  # noqa: S108  that was the attack
        Path(folder, name).unlink(missing_ok=True)


# root's ways


@attack
def root() -> object:
    """Gain privileges, or another view of the system. Nothing of this changes anything for others if it succeeds."""
    here = os.getcwd().encode()
    return _first(
        [
            lambda: _done(os.setuid, 0) and os.access("/etc/shadow", os.W_OK),
            lambda: _done(os.chroot, "."),
            lambda: _call((272, 97), 0x10000000) + 1,
            lambda: _call((272, 97), 0x00020000) + 1,
            lambda: _call((272, 97), 0x40000000) + 1,
            lambda: _call((56, 220), 0x10000011, 0, 0, 0, 0) and "clone",
            lambda: _call((165, 40), b"none", here, b"tmpfs", 0, None) + 1,
            lambda: _call((428, 428), -100, b"/", 1),
            lambda: _call((430, 430), b"tmpfs", 0),
            lambda: _call((321, 280), 0, ctypes.create_string_buffer(128), 128),
            lambda: _call((323, 282), 0),
            lambda: _call((425, 425), 1, ctypes.create_string_buffer(128)),
            lambda: _call((298, 241), ctypes.create_string_buffer(128), 0, -1, -1, 0),
            lambda: _call((103, 116), 3, ctypes.create_string_buffer(64), 64),
            lambda: _call((458, 458), ctypes.create_string_buffer(24), ctypes.create_string_buffer(64), 8, 0),
            lambda: subprocess.run(["unshare", "--user", "true"], check=True, capture_output=True),
        ]
    )


@attack
def patching() -> object:
    """Replace functions, which another process must not notice."""
    before = json.loads("1") == 1
    json.loads = lambda *_, **__: "patched"
    os.getcwd = lambda: "patched"
    return [] if before else ["patched"]


@attack
def patching_twice() -> object:
    """Replace functions, and notice it, as the next run would in the same process."""
    patching()
    return patching()
