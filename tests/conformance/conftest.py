"""Runs every test of this folder over every middleware: add yours to `HARNESSES`."""

from collections.abc import Iterator

import pytest
from tests.conformance.harness import Harness, SimHarness

HARNESSES = {"sim": SimHarness}


@pytest.fixture(params=list(HARNESSES))
def harness(request: pytest.FixtureRequest) -> Iterator[Harness]:
    made = HARNESSES[request.param]()
    yield made
    made.node.context.try_shutdown()
