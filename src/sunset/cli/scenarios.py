"""`sunset scenarios`: list, show and generate."""

import argparse
import json
import sys
from pathlib import Path

from sunset.errors import OutputError
from sunset.output_files import write_text
from sunset.scenarios import generate, load_scenario, load_suite, suite_names


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
    generating = actions.add_parser("generate", help="write a scenario file of given faults")
    generating.add_argument(
        "faults", nargs="+", metavar="FAULT[=VALUE]", help="fault, with a strength if wanted"
    )
    generating.add_argument(
        "--name", default="", help="the scenario's name (default: the faults joined by +)"
    )
    generating.add_argument("--out", type=Path, metavar="FILE", help="where to write (default: stdout)")
    generating.set_defaults(execute=generate_scenario)


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
    """Write one scenario as YAML."""
    text = generate(arguments.faults, name=arguments.name).to_yaml()
    if arguments.out is None:
        sys.stdout.write(text)
    else:
        if arguments.out.exists():
            raise OutputError(f"The file {arguments.out} exists: name a new one with --out.")
        write_text(arguments.out, text)
        print(f"The scenario is in {arguments.out}.", file=sys.stderr)
