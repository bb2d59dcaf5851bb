"""`sunset node`: a node as a process of its own, on DDS."""

import argparse

from sunset.cli.options import add_flag
from sunset.harness.node_process import NodeSpec, node_names, run_node
from sunset.system import MANAGING_SYSTEM


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Run one node as a process on Cyclone DDS, until it is interrupted or shut down through its "
        "lifecycle. Other ROS 2 nodes on this computer see it like their own. If 'sunset up' or a live run is in the "
        "same domain, it has the parameters of that system's own nodes."
    )
    names = node_names()
    parser.add_argument("node", choices=names, metavar="NAME", help=f"one of {', '.join(names)}")
    parser.add_argument(
        "--manager",
        metavar="SPEC",
        help=f"which managing system {MANAGING_SYSTEM} is: none, random, baseline, reactive, diagnosing, inspecting, "
        "oracle, or your own",
    )
    add_network_options(parser)
    parser.add_argument(
        "--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS arguments: -r, -p, --params-file, …"
    )


def add_network_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for the network of a live system."""
    add_flag(parser, "--network", "be heard beyond this computer, which is the default's limit")
    parser.add_argument(
        "--ros-distro",
        metavar="NAME",
        help="ROS 2 distribution of the other nodes (default: found out from what they announce)",
    )


def execute(arguments: argparse.Namespace) -> None:
    run_node(
        NodeSpec(
            node=arguments.node,
            manager=arguments.manager,
            network=arguments.network,
            distro=arguments.ros_distro,
            ros_arguments=arguments.ros_args,
        )
    )
