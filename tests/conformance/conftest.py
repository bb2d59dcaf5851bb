"""Runs every test of this folder over every middleware: add yours to `HARNESSES`."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.conformance.harness import Harness, SimHarness

HARNESSES = {"sim": SimHarness}


@pytest.fixture(params=list(HARNESSES))
def harness(request: pytest.FixtureRequest) -> Iterator[Harness]:
    made = HARNESSES[request.param]()
    yield made
    made.node.context.try_shutdown()
