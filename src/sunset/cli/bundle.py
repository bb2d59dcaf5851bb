"""`sunset bundle`: a campaign as a file that others can check."""

import argparse

import sunset
from sunset.cli.options import add_path, call
from sunset.cli.progress import progress_bar


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Pack a finished campaign into one zip file: the records, the plan, the table, the sources of its managing "
        "systems and extensions, checksums, and what to cite. The same campaign, options and "
        "date give the same bytes. 'sunset verify' checks the file."
    )
    add_path(parser, "folder", "DIR", "what 'sunset bench --out' wrote")
    add_path(parser, "--out", "FILE.zip", "the file to write", required=True)
    parser.add_argument(
        "--title", default="", help="of the bundle (default: one made of the campaign's plan)"
    )
    parser.add_argument(
        "--author",
        action="append",
        default=[],
        dest="authors",
        metavar="'NAME [ORCID]'",
        help="may be repeated (default: anonymous)",
    )
    parser.add_argument(
        "--licence",
        "--license",
        default="",
        metavar="NAME|URL",
        help="of the bundle, as SPDX calls it, such as CC-BY-4.0 (default: none, and it says so)",
    )
    parser.add_argument("--date", metavar="YYYY-MM-DD", help="day of publication (default: today)")


def execute(arguments: argparse.Namespace) -> None:
    with progress_bar("Checking the campaign") as progress:
        bundle = call(sunset.bundle, arguments, progress=progress)
    print(bundle)
