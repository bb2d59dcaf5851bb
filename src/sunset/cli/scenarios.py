"""`sunset scenarios`: list, show, generate and check."""

import argparse
import json
import sys
from pathlib import Path

from sunset.api.splits import check_split, generate_split
from sunset.cli._options import add_count_option
from sunset.errors import InvalidInputError, OutputError
from sunset.output_files import write_text
from sunset.scenarios import SPLITS, SplitDescription, generate, load_scenario, load_suite, suite_names
from sunset.texts import counted


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser("list", help="list the scenarios of the suites")
    listing.add_argument("--suite", metavar="NAME|DIR", help="of one suite, or of a folder of scenario files")
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    listing.set_defaults(execute=list_scenarios)
    showing = actions.add_parser("show", help="print a scenario as YAML")
    showing.add_argument("scenario", help="a scenario's name, a YAML file, or faults joined by +")
    showing.set_defaults(execute=show)
    generating = actions.add_parser(
        "generate",
        help="write a scenario file of given faults, or a split",
        description="Write a scenario file of given faults; or, with --split, a folder of scenarios drawn at random. "
        "The splits never share a scenario, and test has what train never has.",
    )
    generating.add_argument(
        "faults", nargs="*", metavar="FAULT[=VALUE]", help="fault, with a strength if wanted"
    )
    generating.add_argument(
        "--name", default="", help="the scenario's name (default: the faults joined by +)"
    )
    generating.add_argument(
        "--out", type=Path, metavar="PATH", help="file to write (default: stdout); folder of a split"
    )
    generating.add_argument("--split", metavar="NAME", help=f"draw scenarios: {', '.join(SPLITS)}")
    add_count_option(generating, "--count", "split: how many scenarios")
    generating.add_argument("--seed", type=int, metavar="N", help="split: of the draws (default: 0)")
    generating.add_argument(
        "--flights",
        action="store_true",
        help="split: a flight for each scenario, in place of the default one",
    )
    _add_salt(generating, "split: a secret that the draws depend on")
    generating.set_defaults(execute=generate_scenario)
    checking = actions.add_parser("check", help="generate a split anew, and compare its scenarios")
    checking.add_argument("folder", type=Path, metavar="DIR", help="that 'generate --split' has written")
    _add_salt(checking, "the secret that it was made with")
    checking.set_defaults(execute=check)


def _add_salt(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("--salt-file", type=Path, metavar="FILE", help=text)


def list_scenarios(arguments: argparse.Namespace) -> None:
    """Print the names."""
    chosen = suite_names() if arguments.suite is None else [arguments.suite]
    suites = {name: [scenario.name for scenario in load_suite(name)] for name in chosen}
    if arguments.json:
        print(json.dumps(suites, sort_keys=True))
    else:
        print("\n".join(name for suite in suites.values() for name in suite))


def show(arguments: argparse.Namespace) -> None:
    """Print one scenario as YAML."""
    sys.stdout.write(load_scenario(arguments.scenario).to_yaml())


def generate_scenario(arguments: argparse.Namespace) -> None:
    """Write one scenario as YAML, or a split."""
    of_split = {
        "--split": arguments.split,
        "--count": arguments.count,
        "--seed": arguments.seed,
        "--flights": arguments.flights or None,
        "--salt-file": arguments.salt_file,
    }
    given = [name for name, value in of_split.items() if value is not None]
    if given and (arguments.faults or arguments.name):
        raise InvalidInputError(
            f"A split is drawn, not made of given faults: leave out the faults and --name, or {given[0]}."
        )
    if given:
        _generate_split(arguments)
        return
    if not arguments.faults:
        raise InvalidInputError("A scenario is made of faults: name some, or draw scenarios with --split.")
    text = generate(arguments.faults, name=arguments.name).to_yaml()
    if arguments.out is None:
        sys.stdout.write(text)
    else:
        if arguments.out.exists():
            raise OutputError(f"The file {arguments.out} exists: name a new one with --out.")
        write_text(arguments.out, text)
        print(f"The scenario is in {arguments.out}.", file=sys.stderr)


def _generate_split(arguments: argparse.Namespace) -> None:
    """Write a split, and print by which hash it is pinned."""
    for name in ("split", "count", "out"):
        if getattr(arguments, name) is None:
            raise InvalidInputError(f"A split needs --split, --count and --out: add --{name}.")
    described = generate_split(
        arguments.split,
        arguments.count,
        arguments.out,
        seed=arguments.seed or 0,
        flights=arguments.flights,
        salt_file=arguments.salt_file,
    )
    print(
        f"{counted(described.count, 'scenario')} of {described.split} are in {arguments.out}.",
        file=sys.stderr,
    )
    _print_hashes(described)


def check(arguments: argparse.Namespace) -> None:
    """Generate a split anew, and say that its scenarios are those."""
    described = check_split(arguments.folder, salt_file=arguments.salt_file)
    print(f"The scenarios in {arguments.folder} are those that its description makes.", file=sys.stderr)
    _print_hashes(described)


def _print_hashes(described: SplitDescription) -> None:
    print(f"scenarios  SHA-256 {described.sha256}")
    if described.salt_sha256 is not None:
        print(f"salt       SHA-256 {described.salt_sha256}")
