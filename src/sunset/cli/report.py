"""`sunset report`: the table of stored runs, or the time line of a run."""

import argparse
import sys
from pathlib import Path

import sunset
from sunset.api.results import FORMATS, RUNS_FORMATS, is_run, print_story, unfinished_remark
from sunset.cli.options import add_flag, add_format_options, add_path, call
from sunset.cli.progress import progress_bar
from sunset.errors import InvalidInputError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Read the runs below a folder and print their report; of the folder of one run, print its "
        "time line. Nothing is run again."
    )
    add_path(
        parser,
        "path",
        "PATH",
        "what 'sunset bench --out' or 'run --out' wrote; with --paper, also published logs",
    )
    add_format_options(
        parser, FORMATS, "how the table is printed (default: table; of one run, its time line)", default=None
    )
    add_flag(
        parser,
        "--paper",
        "print the paper's five figures by the published evaluation script, with the published ones; PATH may be "
        "a log of the published exemplar, or a folder of logs",
    )
    add_flag(
        parser,
        "--runs",
        f"list the runs, a row each, in place of the table: --format {' or '.join(RUNS_FORMATS)} "
        f"(default: {RUNS_FORMATS[0]})",
    )
    parser.add_argument(
        "--all",
        action="store_true",
        dest="every",
        help="print every figure, and not the first page only; JSON, CSV and pages have all anyway",
    )
    recompute = "compute every metric from the recorded messages again instead of reading the stored ones"
    add_flag(parser, "--recompute", recompute)
    add_path(parser, "--site", "DIR", "write a new folder to publish: the table, and a page for each run")
    figures = "write a new folder with the figures of the table, each as PDF, SVG, PNG and CSV"
    add_path(parser, "--figures", "DIR", figures)


def execute(arguments: argparse.Namespace) -> None:
    form, recompute, path = arguments.format, arguments.recompute, arguments.path
    if arguments.paper and (arguments.runs or recompute or arguments.site or arguments.figures):
        raise InvalidInputError("Leave out --runs, --site, --figures and --recompute with --paper.")
    if arguments.figures and (form or arguments.runs or arguments.site):
        raise InvalidInputError(
            "Figures have formats of their own: leave out --format, --json, --runs and --site with --figures."
        )
    if arguments.site and (form or recompute or arguments.runs):
        raise InvalidInputError(
            "A site has a format of its own: leave out --format, --json, --runs and --recompute."
        )
    if arguments.figures:
        with progress_bar("Reading runs") as progress:
            written = call(sunset.write_figures, arguments, out=arguments.figures, progress=progress)
        print(written, file=sys.stderr)
    elif arguments.site:
        with progress_bar("Writing pages") as progress:
            page = call(sunset.write_site, arguments, out=arguments.site, progress=progress)
        print(f"The site begins with {page}.", file=sys.stderr)
    elif is_run(path) and not (form or recompute or arguments.paper or arguments.runs or arguments.every):
        print_story(path)
    else:
        with progress_bar("Reading logs" if arguments.paper else "Reading runs") as progress:
            text = call(sunset.report, arguments, form=form, progress=progress)
        if arguments.paper or arguments.runs:
            print(text.rstrip("\n"))
        else:
            print_table(path, text, form or FORMATS[0])


def print_table(folder: Path, text: str, form: str) -> None:
    """Print the report of a folder on stdout, and a remark if its campaign is not finished."""
    print(text.rstrip("\n"))
    if remark := unfinished_remark(folder):
        print(remark, file=sys.stdout if form == "table" else sys.stderr)
