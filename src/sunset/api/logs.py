"""Stored runs as logs that the paper's evaluation script reads."""

from pathlib import Path

from sunset import evaluation
from sunset.api.options import Extensions, as_path, check_progress, extended
from sunset.evaluation import WrittenLogs
from sunset.workers import Progress


def write_logs(
    path: str | Path,
    out: str | Path,
    *,
    progress: Progress | None = None,
    extensions: Extensions = (),
) -> WrittenLogs:
    """Write a log of each stored run in the published columns, as `sunset report --format original-csv` does.

    Args:
        path: what `run` or `bench`, or the command line, has written.
        out: the new folder, which must not exist, or be empty: it gets a folder of logs for each managing system.
        progress: called with (runs that are read, runs in all).
        extensions: those of the managed system that the runs were made with.

    Raises:
        RecordError: there is no run, one is damaged, or the script would refuse all logs.
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    check_progress(progress)
    with extended(extensions):
        return evaluation.write_logs(
            as_path(path, "folder of stored runs"), as_path(out, "folder of the logs"), progress=progress
        )
