"""The record of the last run without a folder of its own."""

import errno
import shutil
import tempfile
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Final

from sunset.data import cache_folder
from sunset.errors import OutputError

_TAKEN: Final = frozenset({errno.ENOTEMPTY, errno.EEXIST})
"""Errors for a name that another process has given to its folder meanwhile."""


def last_run() -> Path:
    """Return the folder of the last run without a folder of its own, in the user's cache; it need not exist yet."""
    return cache_folder() / "last-run"


def keep_last_run(record: Path) -> Path:
    """Move a record to `last_run`, in place of the earlier record, and return its folder.

    If two processes do so at the same time, the record of the later process is kept.
    """
    home = last_run()
    try:
        home.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".last-run-", dir=home.parent) as folder:
            draft = Path(folder) / "new"
            shutil.move(record, draft)
            for number in count():
                with suppress(FileNotFoundError):
                    home.rename(Path(folder) / f"old-{number}")
                try:
                    draft.rename(home)
                except OSError as error:
                    if error.errno not in _TAKEN:
                        raise
                else:
                    break
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"The record cannot be kept in {home}: {reason}; '--out DIR' keeps it.") from error
    return home
