"""What a computer lacks is said as such, and is not taken for damage."""

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from tests.data.material import make_frames, record, rows_of

from sunset.data import read_bag
from sunset.errors import DataError
from sunset.shortage import shortage


@pytest.mark.parametrize(
    ("error", "word"),
    [
        (OSError(errno.EMFILE, os.strerror(errno.EMFILE)), "ulimit -n"),
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), "TMPDIR"),
        (OSError(errno.ENOMEM, os.strerror(errno.ENOMEM)), "memory"),
        (MemoryError(), "memory"),
        (ImportError("libx.so: failed to map segment from shared object"), "memory"),
        (RuntimeError("can't start new thread"), "ulimit -u"),
        (BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)), "ulimit -u"),
    ],
)
def test_what_helps_is_said_even_of_what_led_to_an_error(error: BaseException, word: str) -> None:
    assert word in shortage(error)
    later = ValueError("the file is damaged")
    later.__cause__ = error
    assert word in shortage(later)


@pytest.mark.parametrize("error", [FileNotFoundError(errno.ENOENT, "No such file"), ValueError("damaged")])
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
    assert result.returncode in {0, 2}
