"""What the graph of a live system tells a managing system."""

import pytest

from conformance.processes import join_domain
from sunset.harness.executor import ScenarioExecutor
from sunset.scenarios import Scenario, suite
from sunset_ros.rmw.dds.domains import free_domain_id

pytestmark = pytest.mark.xdist_group("processes")


@pytest.mark.thorough
def test_the_graph_tells_nothing_of_the_scenario() -> None:
    found = []
    with free_domain_id() as domain:
        for scenario in (Scenario("nofault"), *suite("paper")):
            context = join_domain(domain)
            node = ScenarioExecutor(scenario, context=context)
            about = (node.get_name(), node.get_namespace())
            found.append(
                [
                    node.get_publisher_names_and_types_by_node(*about),
                    node.get_subscriber_names_and_types_by_node(*about),
                    node.get_service_names_and_types_by_node(*about),
                    node.get_client_names_and_types_by_node(*about),
                ]
            )
            context.shutdown()

    assert len(found) == 55
    assert len(found[0][3]) > 10
    assert found[1:] == found[:1] * 54
