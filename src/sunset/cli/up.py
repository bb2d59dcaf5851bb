"""`sunset up`: run the whole system as processes on ROS 2's network, for other ROS 2 programs."""

import argparse
import sys
from contextlib import suppress
from typing import Final, NoReturn

from rich.console import Console
from rich.live import Live
from rich.table import Table

from sunset.api.options import run_spec_of
from sunset.cli.node import add_network_options
from sunset.cli.options import MODEL, add_settings
from sunset.cli.progress import rendering_progress
from sunset.experiments import Options, manager_checksum, prepare_runs, warn_of_walls
from sunset.experiments.live import LiveSystem
from sunset.harness.operator import NodeStatus, Operator
from sunset.managing import EXTERNAL, MANAGERS
from sunset.scenarios import Scenario
from sunset_ros.rmw.backends import LIVE, live_middleware

_REFRESH_S: Final = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Run every node as a process on Cyclone DDS until Ctrl-C, and let the flight repeat. Other ROS 2 "
        "nodes on this computer can connect: managing systems, the ros2 command line, viewers."
    )
    parser.add_argument("--scenario", metavar="S", help="inject these faults once, when the warm-up is over")
    parser.add_argument(
        "--manager",
        default=EXTERNAL,
        metavar="NAME|FILE.py:CLASS|MODULE:CLASS|exec:COMMAND",
        help=f"the managing system: {', '.join(MANAGERS)}, or your own (default: one that you start, or none)",
    )
    add_settings(parser, "rate", rate="seconds of /clock in a second")
    parser.add_argument(
        "--domain-id", type=int, metavar="N", help="domain of DDS (default: ROS_DOMAIN_ID, else 0)"
    )
    parser.add_argument(
        "--no-autostart",
        action="store_false",
        dest="autostart",
        help="leave the managed nodes unconfigured, for a lifecycle manager that configures and activates them",
    )
    add_settings(parser, *MODEL)
    add_network_options(parser)


def execute(arguments: argparse.Namespace) -> None:
    given = {name: value for name, value in vars(arguments).items() if name in Options.__annotations__}
    spec = run_spec_of(
        arguments.scenario or Scenario("none"), arguments.manager, 1, {"middleware": LIVE, **given}
    )
    if spec.manager != EXTERNAL:
        manager_checksum(spec.manager, spec.settings)  # a mistake in it is reported at once
    with rendering_progress() as progress:
        (resources,) = prepare_runs([spec], progress)
    warn_of_walls([spec])
    console = Console(highlight=False, markup=False)
    with (
        suppress(KeyboardInterrupt),
        LiveSystem(
            spec,
            resources,
            arguments.domain_id,
            network=arguments.network,
            distro=arguments.ros_distro,
            loop=True,
            autostart=arguments.autostart,
            on_line=lambda node, line: console.print(f"[{node}] {line}", soft_wrap=True),
        ) as system,
    ):
        operator = Operator(
            inject=bool(spec.scenario.faults),
            warm_up_s=spec.timing.warm_up_s,
            invites=spec.manager == EXTERNAL,
            context=system.context,
        )
        system.executor.add_node(operator)
        console.print(_how_to_connect(system.domain_id, network=arguments.network), soft_wrap=True)
        try:
            _show(console, system, operator)
        finally:
            print("Ending all nodes.", file=sys.stderr)


def _show(console: Console, system: LiveSystem, operator: Operator) -> NoReturn:
    """Show the nodes' states until a signal comes: drawn on a terminal, elsewhere a line for each change."""
    draws = console.is_terminal and not console.is_dumb_terminal
    shown: dict[str, tuple[str, int | None]] = {}
    with Live(console=console, auto_refresh=False, transient=True) as live:
        while True:
            system.spin_until(lambda: bool(operator.news), _REFRESH_S)
            while operator.news:
                console.print(operator.news.popleft(), soft_wrap=True)
            states = operator.status(system.processes)
            if draws:
                table = Table(box=None, padding=(0, 1), show_header=False)
                for node in states:
                    table.add_row(*_cells(node))
                live.update(table, refresh=True)
                continue
            for node in states:
                if shown.get(node.name) != (node.state, node.pid):
                    shown[node.name] = (node.state, node.pid)
                    line = "{:18} {:12} {:10} {}".format(*_cells(node))
                    console.print(line, soft_wrap=True)


def _cells(node: NodeStatus) -> tuple[str, str, str, str]:
    hertz = "" if node.hertz is None else f"{node.hertz:g} Hz"
    return node.name, node.state, "" if node.pid is None else f"pid {node.pid}", hertz


def _how_to_connect(domain_id: int, *, network: bool) -> str:
    reach = "" if network else " ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"
    older = "" if network else " (Humble: ROS_LOCALHOST_ONLY=1 for the last)"
    return (
        "Connect from another terminal: "
        f"export ROS_DOMAIN_ID={domain_id} RMW_IMPLEMENTATION={live_middleware().RMW_IMPLEMENTATION}{reach}{older}"
    )
