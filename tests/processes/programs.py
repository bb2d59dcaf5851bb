"""What confined processes run in tests: `run` is imported by their server."""

import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any


def run(connection: socket.socket, task: dict[str, Any]) -> None:
    """Run the function that a task names, and send its result as text."""
    result = globals()[task["name"]](**task.get("arguments", {}))
    connection.sendall(f"{result}\n".encode())
    connection.recv(1)


def execute(connection: socket.socket, code: str) -> None:
    """Run Python code, which has its connection and some modules."""
    exec(code, {"connection": connection, "os": os, "sys": sys})  # noqa: S102  a test's own


def nothing() -> str:
    return "ready"


def leave(code: int) -> None:
    os._exit(code)


def leave_in_order() -> None:
    sys.exit(4)


def fail() -> None:
    raise ValueError("a mistake")


def die(number: int) -> None:
    os.kill(os.getpid(), number)


def hang() -> None:
    sys.stdout.write("hanging\n")
    sys.stdout.flush()
    while True:
        with suppress(BaseException):
            threading.Event().wait()


def refuse() -> None:
    signal.signal(signal.SIGABRT, signal.SIG_IGN)
    hang()


def chatter() -> None:
    while True:
        sys.stdout.write("and so on\n")


def fill_memory() -> int:
    return len(bytearray(5 << 30))


def say(text: str, times: int) -> str:
    for _ in range(times):
        sys.stdout.write(text)
    return "said"


def dig() -> str:
    """Make folders that are deeper than Python can go, and one that is closed."""
    Path("closed/inner").mkdir(parents=True)
    here = Path.cwd()
    for _ in range(1100):
        Path("d").mkdir()
        os.chdir("d")
    os.chdir(here)
    Path("shut").mkdir(mode=0)
    return "deep"


def use_modules(names: list[str]) -> list[str]:
    return [str(__import__(name, fromlist=["VALUE"]).VALUE) for name in names]


def use_file(path: str) -> str:
    return Path(path).read_text("utf-8")


def use_folder() -> str:
    """Do what programs do in a folder of their own."""
    Path("a/b").mkdir(parents=True)
    Path("a/b/c").write_text("text", "utf-8")
    Path("a/b/c").rename("c")
    with Path("c").open("r+") as file:
        file.truncate(2)
    Path("d").symlink_to("c")
    shutil.copy2("c", "e")
    Path("e").unlink()
    shutil.rmtree("a")
    text = subprocess.run(["/bin/cat", "d"], capture_output=True, check=True).stdout.decode()
    at_home = os.environ["HOME"] == os.environ["TMPDIR"] == str(Path.cwd())
    return f"{text} {sorted(map(str, Path().iterdir()))} {at_home}"


def limits() -> list[int]:
    return [resource.getrlimit(what)[0] for what in (resource.RLIMIT_DATA, resource.RLIMIT_CORE)]
