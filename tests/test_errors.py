"""What a computer lacks is said as such, and is not taken for damage."""

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import cv2
import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from tests.data.material import make_frames, record, rows_of

from sunset.data import read_bag
from sunset.errors import DataError, shortage


@pytest.mark.parametrize(
    ("error", "word"),
    [
        (OSError(errno.EMFILE, os.strerror(errno.EMFILE)), "ulimit -n"),
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), "TMPDIR"),
        (OSError(errno.ENOMEM, os.strerror(errno.ENOMEM)), "memory"),
        (MemoryError(), "memory"),
        (ImportError("libx.so: failed to map segment from shared object"), "memory"),
        (cv2.error("(-4:Insufficient memory) Failed to allocate 8 bytes"), "memory"),
        (RuntimeError("can't start new thread"), "ulimit -u"),
    ],
)
def test_what_helps_is_said_even_of_what_led_to_an_error(error: BaseException, word: str) -> None:
    assert word in shortage(error)
    later = ValueError("the file is damaged")
    later.__cause__ = error
    assert word in shortage(later)


def test_a_process_that_cannot_be_started_is_told_from_a_file_that_is_locked(tmp_path: Path) -> None:
    code = (
        "import fcntl, os, resource, subprocess, sys\n"
        "from sunset.errors import shortage\n"
        "def lock_twice():\n"
        "    with open(sys.argv[1], 'w') as one, open(sys.argv[1]) as other:\n"
        "        fcntl.flock(one, fcntl.LOCK_EX)\n"
        "        fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)\n"
        "def told(start):\n"
        "    try:\n"
        "        start()\n"
        "    except BlockingIOError as error:\n"
        "        print(repr(shortage(error)))\n"
        "told(lock_twice)\n"
        "if os.getuid() == 0:\n"
        "    os.setuid(65534)  # root may start as many as it likes\n"
        "resource.setrlimit(resource.RLIMIT_NPROC, (0, 0))\n"
        "told(lambda: os.fork())\n"
        "told(lambda: subprocess.run('/bin/true', preexec_fn=lambda: None))\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "file")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    locked, *started = done.stdout.splitlines()
    assert locked == "''"
    assert ["no thread or process" in line for line in started] == [True, True]


@pytest.mark.parametrize(
    "error",
    [
        FileNotFoundError(errno.ENOENT, "No such file"),
        FileNotFoundError(errno.ENOENT, "No such file", "bad_alloc.yaml"),
        ValueError("damaged"),
        ValueError("bad_alloc.yaml is damaged"),
        KeyError("can't start new thread"),
        BlockingIOError(errno.EINPROGRESS, os.strerror(errno.EINPROGRESS)),
    ],
)
def test_other_errors_are_no_shortage(error: Exception) -> None:
    assert shortage(error) == ""


def test_a_bag_for_which_no_file_can_be_opened_is_not_damaged(tmp_path: Path) -> None:
    bag = record(tmp_path / "bag", rows_of(make_frames()), StoragePlugin.MCAP, CompressionMode.FILE)
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, limits[1]))
        with pytest.raises(
            DataError, match=r"cannot be read now: too many open files; allow more .*'ulimit -n'"
        ):
            read_bag(bag)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)


@pytest.mark.parametrize("command", [["run"], ["up"], ["bench", "--out", "results"]])
@pytest.mark.parametrize("limit_mb", [200, 300])
def test_little_memory_ends_in_a_sentence(command: list[str], limit_mb: int, tmp_path: Path) -> None:
    code = (
        "import resource, sys\n"
        "from sunset.cli import main\n"
        f"resource.setrlimit(resource.RLIMIT_AS, ({limit_mb} * 2**20,) * 2)\n"
        "sys.exit(main(sys.argv[1:]))\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code, *command],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=tmp_path,
        env=os.environ | {"ROS_DOMAIN_ID": "78"},
    )
    assert "Traceback" not in result.stderr
    # numpy's library for linear algebra ends the process by itself where it gets no memory at its start
    assert result.returncode in {0, 2} or result.stderr.startswith("OpenBLAS error")
