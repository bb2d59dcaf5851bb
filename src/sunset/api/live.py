"""A live system that lasts, as `sunset up` runs it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Unpack

from sunset.api.options import run_spec_of
from sunset.experiments import Options, Resources, RunSpec, manager_checksum, prepare_runs, warn_of_walls
from sunset.experiments.live import LiveSystem
from sunset.harness.operator import NodeStatus, Operator
from sunset.managing import EXTERNAL, MANAGERS
from sunset.rmw.backends import LIVE, live_middleware
from sunset.scenarios import Scenario

__all__ = [
    "EXTERNAL",
    "MANAGERS",
    "LiveSystem",
    "NodeStatus",
    "Operator",
    "live_middleware",
    "operated_system",
    "prepare_system",
]


def prepare_system(
    scenario: str | None, manager: str, **options: Unpack[Options]
) -> tuple[RunSpec, Resources]:
    """Return the specification and the resources of a live system, with options as of `sunset.run`."""
    spec = run_spec_of(scenario or Scenario("none"), manager, 1, {"middleware": LIVE, **options})
    if spec.manager != EXTERNAL:
        manager_checksum(spec.manager, spec.settings)  # a mistake in it is reported at once
    (resources,) = prepare_runs([spec], options.get("preparing"))
    warn_of_walls([spec])
    return spec, resources


@contextmanager
def operated_system(
    spec: RunSpec,
    resources: Resources,
    domain_id: int | None,
    *,
    network: bool,
    distro: str | None,
    autostart: bool,
    on_line: Callable[[str, str], object],
) -> Iterator[tuple[LiveSystem, Operator]]:
    """Give a live system, with arguments as of `LiveSystem`, and the operator that injects its faults."""
    with LiveSystem(
        spec,
        resources,
        domain_id,
        network=network,
        distro=distro,
        loop=True,
        autostart=autostart,
        on_line=on_line,
    ) as system:
        operator = Operator(
            inject=bool(spec.scenario.faults),
            warm_up_s=spec.timing.warm_up_s,
            invites=spec.manager == EXTERNAL,
            context=system.context,
        )
        system.executor.add_node(operator)
        yield system, operator
