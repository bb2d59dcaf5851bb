import pytest

import sunset_ros as ros
from sunset_ros import Context
from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.dds.domains import free_domain_id
from sunset_ros.signals import SignalHandlerOptions


def test_a_context_without_a_middleware_is_live(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    with free_domain_id() as domain_id:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))
        context = Context()
        ros.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        node = ros.create_node("node", context=context)
        node.get_logger().info("hello")
        assert node.get_node_names() == ["node"]
        ros.shutdown(context=context)
        assert not context.ok()
    assert "[node]: hello" in capfd.readouterr().err


def test_a_domain_that_is_given_wins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "nonsense")
    context = Context()
    with pytest.raises(MiddlewareError, match="ROS_DOMAIN_ID must be a whole number from 0 to 232"):
        context.init([])
    assert not context.ok()
    with free_domain_id() as domain_id:
        context.init([], domain_id=domain_id, log_to_stderr=False)
        assert context.ok()
        context.shutdown()
