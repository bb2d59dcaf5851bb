"""What the adaptive base class gives to every node, on the example that its documentation promises."""

from itertools import groupby
from typing import TYPE_CHECKING

import pytest

from sunset.errors import ParameterError
from sunset.nodes import AdaptiveNode, Camera, FaultParameter, NodeParameter, TopicParameter, action
from sunset_ros import CallbackError, Parameter
from sunset_ros.exceptions import InvalidParameterValueException
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.lifecycle import LifecycleState, TransitionCallbackReturn

if TYPE_CHECKING:
    from tests.conftest import World

OUT = "/managed_subsystem/loud"


class Shouter(AdaptiveNode):
    """A node with one of everything."""

    node_name = "shouter"

    lifecycle_activation_delay = NodeParameter(
        0.5, "seconds to boot", minimum=-1.0, maximum=10.0, read_only=True
    )
    topic_input = TopicParameter("quiet", "topic of the texts")
    mark = NodeParameter("!", "what is appended")
    gain = NodeParameter(1.0, "how loud", minimum=0.0, maximum=2.0)
    pitch = NodeParameter(0.0, "how high")
    breath = NodeParameter(1.0, "seconds between two shouts", minimum=0.0)
    volume = NodeParameter(3, "how loud at most", maximum=11)
    hoarse = FaultParameter(False, "nothing comes out until a restart", cured_by_restart=True)
    mute = FaultParameter(False, "nothing comes out until a redeploy")
    stutter = FaultParameter(0, "repetitions", minimum=0, maximum=9, ends_with="calm_down")

    def set_up(self) -> None:
        self._loud = self.create_lifecycle_publisher(String, "loud", 10)
        self.create_switchable_subscription(String, "topic_input", self._on_text)

    @action
    def calm_down(self) -> None:
        """End the stutter."""
        self.write_parameter("stutter", 0)

    def _on_text(self, message: String) -> None:
        if message.data == "explode":
            raise RuntimeError("too loud")
        if self.hoarse or self.mute:
            return
        self.report("length", len(message.data))
        self._loud.publish(String(data=message.data.upper() * (1 + self.stutter) + self.mark))


@pytest.fixture
def shouter(world: "World") -> Shouter:
    node = world.start(Shouter)
    world.run(1.0)
    return node


def say(world: "World", text: str, topic: str = "/managed_subsystem/quiet") -> list[str]:
    """Let the tester publish a text; return what the node made of it."""
    before = len(world.messages[OUT])
    world.publish(topic, String(data=text))
    world.run(0.01)
    return [message.data for message in world.messages[OUT][before:]]


def states(world: "World") -> list[str]:
    return [message.status[0].message for message in world.messages["/diagnostics"]]


# Lifecycle


def test_it_configures_itself_and_activates_itself_after_the_delay(world: "World") -> None:
    world.start(Shouter)
    world.run(1.05)
    heartbeats = zip(world.times["/diagnostics"], states(world), strict=True)
    assert {state for time, state in heartbeats if time < 0.5} == {"inactive"}
    assert states(world)[5:] == ["active"] * 5


def test_the_delay_counts_from_when_the_time_is_known(world: "World") -> None:
    world.start(Shouter, parameters={"use_sim_time": True})
    world.run(3.0)  # nobody tells the time
    for step in range(100):
        world.publish("/clock", Clock(clock=Time(sec=100, nanosec=step * 10**7)))
        world.run(0.01)
    heartbeats = world.messages["/diagnostics"]
    stamps = [message.header.stamp.nanosec / 1e9 for message in heartbeats]
    assert stamps == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
    assert states(world) == ["inactive"] * 5 + ["active"] * 4


def test_a_negative_delay_leaves_it_inactive_until_somebody_activates_it(world: "World") -> None:
    world.start(Shouter, parameters={"lifecycle_activation_delay": -1.0})
    world.run(5.0)
    assert set(states(world)) == {"inactive"}
    assert world.transition("shouter", "activate")
    assert say(world, "a") == ["A!"]


def test_the_boot_time_cannot_be_skipped(world: "World") -> None:
    world.start(Shouter)
    world.run(0.3)
    assert not world.transition("shouter", "activate")
    assert states(world)[-1] == "inactive"
    assert "still booting" in world.messages["/rosout"][-1].msg
    world.run(0.4)
    assert states(world)[-1] == "active"


def test_another_node_configures_and_activates_it_where_it_does_not_start_itself(world: "World") -> None:
    world.start(Shouter, parameters={"autostart": False})
    world.run(0.2)
    assert states(world)[-1] == "unconfigured"
    assert world.transition("shouter", "configure")
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_ACTIVATE))  # while it boots
    assert world.call(ChangeState, "/managed_subsystem/shouter/change_state", request, within=1.0).success
    assert [state for state, _ in groupby(states(world))] == ["unconfigured", "inactive", "active"]
    assert world.transition("shouter", "deactivate")
    assert world.transition("shouter", "activate")


def levels(world: "World") -> list[int]:
    """Return the levels of the heartbeats so far, each once in a row."""
    statuses = [message.status[0] for message in world.messages["/diagnostics"]]
    return [level[0] for level, _ in groupby(status.level for status in statuses)]


def test_its_level_is_a_warning_while_it_is_not_active_or_reports_a_flag(world: "World") -> None:
    shouter = world.start(Shouter)
    world.run(1.0)
    assert levels(world) == [1, 0]
    for value in (True, False):
        shouter.report("hoarseness", value)
        world.run(0.5)
    assert levels(world) == [1, 0, 1, 0]
    world.set("shouter", "mute", value=True)  # which does not show
    world.run(0.5)
    assert levels(world) == [1, 0, 1, 0]


def test_it_is_no_warning_that_a_node_waits_to_be_activated(world: "World") -> None:
    world.start(Shouter, parameters={"lifecycle_activation_delay": -1.0})
    world.run(0.5)
    assert levels(world) == [0]


def test_it_stays_as_it_was_left_when_the_delay_is_over(world: "World") -> None:
    world.start(Shouter)
    world.run(0.3)
    assert world.transition("shouter", "cleanup")
    world.run(1.0)
    assert states(world)[-1] == "unconfigured"


@pytest.mark.usefixtures("shouter")
def test_while_inactive_it_has_no_subscription_and_publishes_nothing(world: "World") -> None:
    topic = ("/managed_subsystem/quiet", "std_msgs/msg/String")
    assert topic in world.subscriptions_of("/managed_subsystem/shouter")
    assert world.transition("shouter", "deactivate")
    assert topic not in world.subscriptions_of("/managed_subsystem/shouter")
    assert say(world, "a") == []
    assert world.transition("shouter", "activate")
    assert say(world, "b") == ["B!"]


@pytest.mark.usefixtures("shouter")
def test_shutdown_is_answered_and_ends_the_process(world: "World") -> None:
    assert world.transition("shouter", "shutdown")
    assert world.sim.node_names() == ["/tester"]
    heartbeats = len(states(world))
    world.run(1.0)
    assert len(states(world)) == heartbeats


# Heartbeat


@pytest.mark.usefixtures("shouter")
def test_it_beats_ten_times_a_second_in_every_state(world: "World") -> None:
    for label in ("deactivate", "cleanup", "configure"):
        assert world.transition("shouter", label)
        before = len(states(world))
        world.run(1.0)
        assert len(states(world)) == before + 10


@pytest.mark.usefixtures("shouter")
def test_every_value_is_reported_once(world: "World") -> None:
    say(world, "abc")
    say(world, "de")
    world.run(0.5)
    statuses = [message.status[0] for message in world.messages["/diagnostics"]]
    reported = [[(item.key, item.value) for item in status.values] for status in statuses]
    assert [values for values in reported if values] == [[("length", "3.0"), ("length", "2.0")]]
    assert {(status.name, status.hardware_id) for status in statuses} == {("shouter: heartbeat", "shouter")}


# Parameters


def test_a_parameter_is_an_attribute_that_follows(world: "World", shouter: Shouter) -> None:
    assert shouter.mark == "!"
    assert world.set("shouter", "mark", "?").successful
    assert shouter.mark == "?"
    assert say(world, "a") == ["A?"]


def test_an_attribute_cannot_be_assigned(shouter: Shouter) -> None:
    with pytest.raises(AttributeError, match="Set the parameter mark with set_parameters"):
        shouter.mark = "?"


def test_overrides_are_the_initial_values(world: "World") -> None:
    assert world.start(Shouter, parameters={"gain": 1.5, "stutter": 2}).stutter == 2


def test_a_bad_override_is_refused(world: "World") -> None:
    with pytest.raises(InvalidParameterValueException, match="gain"):
        world.start(Shouter, parameters={"gain": 3.0})
    with pytest.raises(ParameterError, match="topic_input must be a topic's name such as quiet, got 'a b'"):
        world.start(Shouter, parameters={"topic_input": "a b"})


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("gain", 2.5, "gain"),
        ("gain", float("nan"), "gain"),
        ("gain", "loud", "gain"),
        ("pitch", float("nan"), "pitch must be a finite number"),
        ("pitch", float("-inf"), "pitch must be a finite number"),
        ("stutter", 10, "stutter"),
        ("stutter", -1, "stutter"),
        ("topic_input", "", "a topic's name"),
        ("topic_input", "9lives", "a topic's name"),
        ("topic_input", "a//b", "a topic's name"),
        ("topic_input", "a" * 240, "longer than"),
        ("lifecycle_activation_delay", 0.1, "read"),
        ("colour", "red", "declared"),
    ],
)
def test_a_bad_value_is_refused_with_a_reason(
    world: "World", shouter: Shouter, name: str, value: object, said: str
) -> None:
    before = dict(shouter.parameter_values)
    result = world.set("shouter", name, value)
    assert not result.successful
    assert said in result.reason
    assert shouter.parameter_values == before
    assert say(world, "a") == ["A!"]


# Change of communication


@pytest.mark.usefixtures("shouter")
def test_setting_the_topic_replaces_the_subscription(world: "World") -> None:
    assert world.set("shouter", "topic_input", "other").successful
    subscriptions = world.subscriptions_of("/managed_subsystem/shouter")
    assert ("/managed_subsystem/other", "std_msgs/msg/String") in subscriptions
    assert ("/managed_subsystem/quiet", "std_msgs/msg/String") not in subscriptions
    assert say(world, "a") == []
    assert say(world, "b", "/managed_subsystem/other") == ["B!"]


@pytest.mark.usefixtures("shouter")
def test_an_absolute_topic_is_taken_as_it_is(world: "World") -> None:
    assert world.set("shouter", "topic_input", "/else/where").successful
    assert say(world, "b", "/else/where") == ["B!"]


@pytest.mark.usefixtures("shouter")
def test_a_topic_set_while_inactive_holds_when_active(world: "World") -> None:
    assert world.transition("shouter", "deactivate")
    assert world.set("shouter", "topic_input", "other").successful
    assert world.transition("shouter", "activate")
    assert say(world, "b", "/managed_subsystem/other") == ["B!"]


# Faults and actions


@pytest.mark.usefixtures("shouter")
def test_a_restart_ends_the_faults_that_it_cures_and_no_other(world: "World") -> None:
    for fault in ("hoarse", "mute"):
        assert world.set("shouter", fault, value=True).successful
        assert say(world, "a") == []
        assert world.transition("shouter", "deactivate")
        assert world.transition("shouter", "activate")
        assert say(world, "a") == ([] if fault == "mute" else ["A!"])


def test_a_redeploy_ends_every_internal_fault(world: "World", shouter: Shouter) -> None:
    for fault, value in (("hoarse", True), ("mute", True), ("stutter", 3)):
        assert world.set("shouter", fault, value).successful
    assert shouter.stutter == 3
    assert world.transition("shouter", "shutdown")
    world.start(Shouter)
    world.run(1.0)
    assert say(world, "a") == ["A!"]


@pytest.mark.parametrize(
    ("fault", "value", "back", "said"),
    [
        ("hoarse", True, False, "hoarse is True and ends only with a restart or a redeploy of shouter."),
        ("mute", True, False, "mute is True and ends only with a redeploy of shouter."),
        ("stutter", 3, 0, "stutter is 3 and ends only with calm_down or a redeploy of shouter."),
        ("stutter", 3, 1, "stutter is 3"),
    ],
)
@pytest.mark.usefixtures("shouter")
def test_a_fault_is_not_wished_away(
    world: "World", fault: str, value: object, back: object, said: str
) -> None:
    assert world.set("shouter", fault, value).successful
    result = world.set("shouter", fault, back)
    assert not result.successful
    assert said in result.reason
    assert world.set("shouter", fault, value).successful


def test_an_action_is_done_and_its_parameter_becomes_false_again(world: "World", shouter: Shouter) -> None:
    world.set("shouter", "stutter", 2)
    for _ in range(2):
        assert world.set("shouter", "calm_down", value=True).successful
        assert shouter.stutter == 0
        assert shouter.get_parameter("calm_down").value is False
    assert world.set("shouter", "calm_down", value=False).successful


def test_an_action_comes_after_all_that_is_set_with_it(shouter: Shouter) -> None:
    both = [Parameter("calm_down", value=True), Parameter("stutter", value=5)]
    assert shouter.set_parameters_atomically(both).successful
    assert (shouter.stutter, shouter.get_parameter("stutter").value) == (0, 0)


@pytest.mark.parametrize(("name", "refused", "accepted"), [("breath", -0.5, 1e300), ("volume", 12, -(2**63))])
def test_a_bound_on_one_side_holds(
    name: str, refused: float, accepted: float, world: "World", shouter: Shouter
) -> None:
    assert not world.set("shouter", name, refused).successful
    assert world.set("shouter", name, accepted).successful
    assert getattr(shouter, name) == accepted


def test_an_activation_that_failed_leaves_no_second_subscription(world: "World") -> None:
    class Timid(Shouter):
        """Dares at the second try only."""

        tries = 0

        def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
            super().on_activate(state)
            self.tries += 1
            return TransitionCallbackReturn.SUCCESS if self.tries > 1 else TransitionCallbackReturn.FAILURE

    world.start(Timid)
    world.run(1.0)
    assert world.transition("shouter", "activate")
    assert say(world, "a") == ["A!"]
    assert world.transition("shouter", "deactivate")
    assert say(world, "b") == []


def test_what_an_action_does_is_seen_by_everyone(world: "World", shouter: Shouter) -> None:
    world.set("shouter", "stutter", 2)
    before = len(world.messages["/parameter_events"])
    world.set("shouter", "calm_down", value=True)
    changes = [
        (parameter.name, parameter.value.bool_value, parameter.value.integer_value)
        for event in world.messages["/parameter_events"][before:]
        for parameter in event.changed_parameters
    ]
    assert sorted(changes) == [("calm_down", False, 0), ("calm_down", True, 0), ("stutter", False, 0)]
    assert changes[-1] == ("calm_down", False, 0)
    assert shouter.describe_parameter("calm_down").description == "End the stutter."


# Errors


@pytest.mark.usefixtures("shouter")
def test_an_exception_in_a_callback_surfaces(world: "World") -> None:
    with pytest.raises(CallbackError, match=r"Shouter\._on_text.*/managed_subsystem/shouter.*too loud"):
        say(world, "explode")


def test_an_exception_in_a_lifecycle_callback_surfaces(world: "World") -> None:
    class Broken(Shouter):
        def on_configure(self, state: object) -> object:  # type: ignore[override]
            raise RuntimeError(f"no such file, after {state}")

    world.start(Broken)
    with pytest.raises(CallbackError, match="no such file"):
        world.run(0.1)


class Mistyping(Camera):
    def set_up(self) -> None:
        super().set_up()
        self.report("sharpnes", 3.0)


def test_a_node_of_the_system_reports_no_number_that_nobody_described(world: "World") -> None:
    with pytest.raises(
        ValueError, match=r"got 'sharpnes': did you mean 'sharpness', or add Signal\('camera', "
    ):
        world.start(Mistyping)
