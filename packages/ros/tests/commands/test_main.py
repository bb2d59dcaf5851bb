"""The command line on a graph of another process."""

import subprocess
import sys
from collections.abc import Iterator

import pytest

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.__main__ import main
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds.domains import free_domain_id

pytestmark = pytest.mark.xdist_group("ros")


@pytest.fixture
def domain_id() -> Iterator[int]:
    with free_domain_id() as domain:
        context = Context()
        context.init([], middleware=CycloneDDS(domain_id=domain, environment={}))
        SingleThreadedExecutor(context=context).add_node(Node("talker", context=context))
        yield domain
        context.shutdown()


def test_nodes_are_listed(domain_id: int, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["node", "list", "--domain-id", str(domain_id)]) == 0
    assert capfd.readouterr().out == "/talker\n"


def test_a_node_that_is_not_there_is_one_sentence_and_code_1(
    domain_id: int, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["node", "info", "/other", "--domain-id", str(domain_id), "--timeout", "0.5"]) == 1
    assert capfd.readouterr().err == "sunset-ros: Unable to find node '/other'.\n"


def test_an_option_that_cannot_be_used_is_one_sentence_and_code_2(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["node", "list", "--domain-id", "233"]) == 2
    assert capfd.readouterr().err.startswith("sunset-ros: The domain id must be a whole number from 0 to 232")


def test_the_package_is_a_program() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sunset_ros", "topic", "--help"], check=True, capture_output=True, text=True
    )
    assert "usage: sunset-ros topic" in done.stdout
