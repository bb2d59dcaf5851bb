"""The lock on a campaign's folder: for a process that runs all of it, or for several that run a shard each."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

from sunset.errors import OutputError
from sunset.experiments.shards import Shard
from sunset.output_files import make_folder
from sunset.recording import PLAN_FILE

_LOCK_FILE: Final = ".lock"


@contextmanager
def locked_campaign(out: Path, shard: Shard | None = None) -> Iterator[None]:
    """Make a campaign's folder, if there is none, and keep other processes from running the same runs in it."""
    import fcntl  # noqa: PLC0415  not on every system

    make_folder(out)
    beside = (_LOCK_FILE, f".{PLAN_FILE}.")  # another shard may have just begun
    names = [path.name for path in out.iterdir() if not path.name.startswith(beside)]
    if names and not (out / PLAN_FILE).exists():
        raise OutputError(f"The folder {out} is not empty and holds no campaign; name a new folder.")
    locks = {_LOCK_FILE: fcntl.LOCK_SH if shard else fcntl.LOCK_EX}
    if shard:
        locks[f"{_LOCK_FILE}-{shard.number}-of-{shard.count}"] = fcntl.LOCK_EX
    with ExitStack() as files:
        for name, kind in locks.items():
            file = files.enter_context((out / name).open("a+b"))  # network drives need both permissions
            try:
                fcntl.flock(file, kind | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OutputError(
                    f"The campaign in {out} is being run by another process: wait for its end, or name another folder."
                ) from error
            except OSError as error:
                raise OutputError(
                    f"The file system of {out} has no locks for files ({error.strerror}), without which two processes "
                    "could write to it: name a folder on another one."
                ) from error
        yield
