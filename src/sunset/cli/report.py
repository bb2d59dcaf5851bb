"""`sunset report`: the table of stored runs, or the time line of one run."""

import argparse
import sys
from pathlib import Path

from sunset.api.site import write_site
from sunset.cli._options import add_format_options
from sunset.cli._progress import progress_bar
from sunset.errors import InvalidInputError, RecordError
from sunset.evaluation import (
    FORMATS,
    RUNS_FORMATS,
    render_report,
    render_runs,
    write_figures,
)
from sunset.experiments import count_runs
from sunset.published import paper_report
from sunset.recording import RUN_FILE, read_stored_run


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Read the runs below a folder and print their report; of the folder of one run, print its "
        "time line. Nothing is run again."
    )
    parser.add_argument(
        "path",
        type=Path,
        metavar="PATH",
        help="what 'sunset bench --out' or 'run --out' wrote; with --paper, also published logs",
    )
    add_format_options(
        parser, FORMATS, "how the table is printed (default: table; of one run, its time line)", default=None
    )
    parser.add_argument(
        "--paper",
        action="store_true",
        help="print the paper's five figures by the published evaluation script, with the published ones; PATH may be "
        "a log of the published exemplar, or a folder of logs",
    )
    parser.add_argument(
        "--runs",
        action="store_true",
        help=f"list the runs, a row each, in place of the table: --format {' or '.join(RUNS_FORMATS)} "
        f"(default: {RUNS_FORMATS[0]})",
    )
    parser.add_argument(
        "--all",
        action="store_true",
        dest="every",
        help="print every figure, and not the first page only; JSON, CSV and pages have all anyway",
    )
    parser.add_argument(
        "--site",
        type=Path,
        metavar="DIR",
        help="write a new folder to publish: the table, and a page for each run",
    )
    parser.add_argument(
        "--figures",
        type=Path,
        metavar="DIR",
        help="write a new folder with the figures of the table, each as PDF, SVG, PNG and CSV",
    )
    parser.add_argument(
        "--recompute",
        action="store_true",
        help="compute every metric from the recorded messages again instead of reading the stored ones",
    )


def execute(arguments: argparse.Namespace) -> None:
    """Print the report."""
    form, again = arguments.format, arguments.recompute
    folder = arguments.path
    if arguments.paper:
        _print_paper(folder, arguments)
    elif arguments.figures is not None:
        _write_figures(folder, arguments)
    elif arguments.site is not None:
        if form or again or arguments.runs:
            raise InvalidInputError(
                "A site has a format of its own: leave out --format, --json, --runs and --recompute."
            )
        with progress_bar("Writing pages") as progress:
            page = write_site(folder, arguments.site, progress=progress)
        print(f"The site begins with {page}.", file=sys.stderr)
    elif arguments.runs:
        with progress_bar("Reading runs") as progress:
            text = render_runs(
                folder, form or RUNS_FORMATS[0], recompute=again, progress=progress if again else None
            )
        print(text, end="")
    elif form is None and not again and not arguments.every and (folder / RUN_FILE).is_file():
        read_stored_run(folder).print_story()
    else:
        print_report(folder, form or "table", every=arguments.every, recompute=again)


def _print_paper(path: Path, arguments: argparse.Namespace) -> None:
    """Print the paper's figures by the published evaluation script."""
    if arguments.runs or arguments.recompute or arguments.site or arguments.figures:
        raise InvalidInputError("Leave out --runs, --site, --figures and --recompute with --paper.")
    with progress_bar("Reading logs") as progress:
        text = paper_report(path, arguments.format or "table", progress=progress)
    print(text.rstrip("\n"))


def _write_figures(folder: Path, arguments: argparse.Namespace) -> None:
    """Write the figures of stored runs."""
    if arguments.format or arguments.runs or arguments.site:
        raise InvalidInputError(
            "Figures have formats of their own: leave out --format, --json, --runs and --site with --figures."
        )
    again = arguments.recompute
    with progress_bar("Reading runs") as progress:
        written = write_figures(
            folder, arguments.figures, recompute=again, progress=progress if again else None
        )
    print(written, file=sys.stderr)


def print_report(folder: Path, form: str, *, every: bool = False, recompute: bool = False) -> None:
    """Print the report of a folder of runs on stdout."""
    with progress_bar("Reading runs") as progress:
        text = render_report(
            folder, form, every=every, recompute=recompute, progress=progress if recompute else None
        )
    print(text.rstrip("\n"))
    remarks = sys.stdout if form == "table" else sys.stderr
    try:
        counted = count_runs(folder)
    except RecordError as error:
        print(
            f"The campaign in {folder} may not be finished, since its plan cannot be read: {error}",
            file=remarks,
        )
        return
    if counted is not None and counted[0] < counted[1]:
        print(
            f"The campaign in {folder} is not finished: {counted[0]} of {counted[1]} runs are there.",
            file=remarks,
        )
