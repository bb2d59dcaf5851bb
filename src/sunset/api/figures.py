"""The figures of a report of stored runs, as files."""

from pathlib import Path

from sunset import evaluation
from sunset.api.options import Extensions, as_path, check_flags, check_progress, extended
from sunset.evaluation import WrittenFigures
from sunset.processes.workers import Progress


def write_figures(
    path: str | Path,
    out: str | Path,
    *,
    recompute: bool = False,
    progress: Progress | None = None,
    extensions: Extensions = (),
) -> WrittenFigures:
    """Write the figures of a report of stored runs, as `sunset report --figures` does.

    Each has a file as PDF, SVG and PNG, and its data as CSV; `captions.txt` has their captions.

    Args:
        path: what `run` or `bench`, or the command line, has written.
        out: the new folder, which must not exist, or be empty.
        recompute: compute every number from the recorded messages instead of reading the stored ones.
        progress: called with (runs that are read, runs in all).
        extensions: those of the managed system that the runs were made with.

    Raises:
        MissingExtraError: matplotlib is not installed.
        RecordError: there is no run, or one is damaged.
        OutputError: the folder exists and is not empty, or cannot be written.
    """
    check_progress(progress)
    check_flags(recompute=recompute)
    with extended(extensions):
        return evaluation.write_figures(
            as_path(path, "folder of stored runs"),
            as_path(out, "folder of the figures"),
            recompute=recompute,
            progress=progress,
        )
