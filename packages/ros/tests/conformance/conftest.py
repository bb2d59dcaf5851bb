"""Runs every test of this folder over every middleware: add yours to `HARNESSES`."""

from collections.abc import Iterator

import pytest

from conformance.harness import CycloneHarness, Harness, HostedHarness, RemoteHarness, SimHarness

HARNESSES: dict[str, type[Harness]] = {
    "sim": SimHarness,
    "remote": RemoteHarness,
    "cyclonedds": CycloneHarness,
    "hosted": HostedHarness,
}


SLOW = {"hosted"}


@pytest.fixture(
    params=[pytest.param(name, marks=[pytest.mark.thorough] if name in SLOW else []) for name in HARNESSES]
)
def harness(request: pytest.FixtureRequest) -> Iterator[Harness]:
    made = HARNESSES[request.param]()
    yield made
    made.close()
