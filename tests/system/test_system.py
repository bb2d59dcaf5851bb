"""The description of the managed system against what nodes do, and descriptions that contradict themselves."""

import re
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest
from tests.conftest import World

import sunset.system
from sunset.errors import ExtensionError
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.parameters import FaultParameter, TopicParameter
from sunset.system import (
    Adaptation,
    AdaptationKind,
    Extension,
    Failure,
    Fault,
    NodeDescription,
    Signal,
    System,
    Topic,
    current_system,
    full_name,
)
from sunset.system.checks import check_extension, check_system
from sunset_ros import Node

PAPER = current_system().parts[0]
PLACES = sorted(
    {
        place
        for file in Path(sunset.system.__file__).parent.glob("*.py")
        for place in re.findall(r'"(sunset(?:\.\w+)+:\w+)"', file.read_text(encoding="utf-8"))
    }
)
"""What the description names as text and imports when it runs, so that no other check sees it."""


@pytest.mark.parametrize("place", PLACES)
def test_what_the_description_names_as_text_is_there(place: str) -> None:
    module, _, name = place.partition(":")
    assert callable(getattr(import_module(module), name))


def test_every_node_of_a_process_is_named_as_text() -> None:
    managed = {node.node_class for node in current_system().nodes.values()}
    harness = {node.node_class for node in sunset.system.HARNESS.values()} - {""}
    assert (len(managed), len(harness)) == (5, 5)
    assert managed | harness <= {*PLACES}


class Altimeter(AdaptiveNode):
    node_name = "altimeter"
    altimeter_drift = FaultParameter(0.0, "metres", minimum=0.0, maximum=100.0)


ALTIMETER = NodeDescription("altimeter", Altimeter, ("depth_camera",), ("altitude",))
ALTITUDE = Signal("altimeter", "altitude", unit="m", threshold=100.0)
DRIFT = Fault(
    name="altimeter_drift",
    failure="F6",
    node="altimeter",
    description="It drifts.",
    cures=((Adaptation(AdaptationKind.REDEPLOY, "altimeter"),),),
    value=60.0,
    limits=(0.0, 100.0),
)


def failure(**what: str) -> Failure:
    return Failure("F6", "the altitude cannot be", symptom="too high", gone="plausible again", **what)


@pytest.mark.parametrize("name", current_system().nodes)
def test_nodes_have_the_endpoints_that_the_description_says(world: World, name: str) -> None:
    system = current_system()
    node = world.start(system.node_class(name), parameters={"lifecycle_activation_delay": 0.0})
    assert isinstance(node, AdaptiveNode)
    world.run(0.5)
    graph = (node.get_subscriber_names_and_types_by_node, node.get_publisher_names_and_types_by_node)
    subscribed, published = ({topic for topic, _ in find(name, "/managed_subsystem")} for find in graph)
    assert subscribed & {*system.sensors, *system.publishers} == set(
        map(full_name, system.nodes[name].inputs)
    )
    assert published & set(system.publishers) == set(map(full_name, system.nodes[name].outputs))


@pytest.mark.parametrize("name", current_system().nodes)
def test_topic_parameters_are_those_that_the_description_changes(name: str) -> None:
    members = vars(current_system().node_class(name))
    topics = {(name, key) for key, value in members.items() if isinstance(value, TopicParameter)}
    assert topics == {pair for pair in current_system().topic_parameters if pair[0] == name}


def test_a_part_adds_to_what_is_there() -> None:
    system = System(
        PAPER,
        Extension(
            nodes=(ALTIMETER,),
            topics=(Topic("altitude", "std_msgs/msg/Float64"),),
            signals=(ALTITUDE,),
            failures=(failure(signal="altimeter_altitude"),),
            faults=(DRIFT,),
            suites={"heights": (("altimeter_drift",), ("altimeter_drift=30", "gpu_failure"))},
        ),
    )
    assert system.upstream["altimeter"] == {"depth"}
    assert system.failing_nodes["F6"] == "altimeter"
    assert Adaptation(AdaptationKind.RESTART, "altimeter") in system.adaptations
    assert ("/managed_subsystem/altimeter", "altimeter_drift") in system.fault_parameters
    assert system.faults["altimeter_drift"].healthy == 0.0
    assert system.node_class("altimeter") is Altimeter
    assert list(system.suites)[-1] == "heights"


def test_an_adaptation_that_rewires_makes_a_node_upstream() -> None:
    use = Adaptation(AdaptationKind.CHANGE_TOPIC, "sensor_fusion", "topic_camera_input", "altitude")
    system = System(PAPER, Extension(nodes=(ALTIMETER,), adaptations=(use,)))
    assert "altimeter" in system.upstream["segmentation"]
    assert "altimeter" not in current_system().upstream["segmentation"]


def node(name: str, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> NodeDescription:
    return NodeDescription(name, type(name, (Node,), {"node_name": name}), inputs, outputs)


def check_all(system: System, extension: Extension) -> None:
    check_system(system)
    check_extension(extension, system, System(PAPER))


def test_the_papers_system_fits_together() -> None:
    check_all(current_system(), replace(PAPER, signals=()))  # whose thresholds the model's card has


@pytest.mark.parametrize(
    ("extension", "sentence"),
    [
        (Extension(nodes=(node("camera", (), ()),)), r"name of the node 'camera' is taken: choose another\."),
        (Extension(nodes=(node("a", (), ("rgb_camera",)),)), r"name of the topic '/.*/rgb_camera' is taken"),
        (Extension(nodes=(node("a", (), ("/clock",)),)), "name of the topic '/clock' is taken"),
        (Extension(suites={"paper": (("gpu_failure",),)}), "name of the suite 'paper' is taken"),
        (
            Extension(nodes=(node("a", ("rgb_camra",), ()),)),
            r"on the topic /managed_subsystem/rgb_camra: did you mean '/managed_subsystem/rgb_camera'",
        ),
        (
            Extension(topics=(Topic("altitude"),)),
            "No node publishes on the topic /managed_subsystem/altitude",
        ),
        (
            Extension(nodes=(node("a", ("y",), ("x",)), node("b", ("x",), ("y",)))),
            r"The wiring of the nodes has a cycle: (a feeds b feeds a|b feeds a feeds b)\.",
        ),
        (
            Extension(nodes=(NodeDescription("a", "", ()),)),
            "The class  of the node a cannot be imported: Empty module name",
        ),
        (
            Extension(nodes=(NodeDescription("a", Altimeter, ()),)),
            "The class of the node a must have its node_name, got 'altimeter'",
        ),
        (
            Extension(failures=(failure(signal="altimeter_altitude"),)),
            "The failure F6 refers to the signal 'altimeter_altitude', which is not there: name one of segmentation",
        ),
        (
            Extension(
                nodes=(ALTIMETER,),
                signals=(Signal("altimeter", "x"),),
                failures=(failure(signal="altimeter_x"),),
            ),
            "The failure F6 needs a threshold of the signal altimeter_x.",
        ),
        (Extension(failures=(failure(),)), "must name either a topic that stops or a signal that is off"),
        (
            Extension(failures=(failure(topic="sonar"),)),
            "The failure F6 is of the topic sonar: add it to the topics that are watched",
        ),
        (
            Extension(failures=(failure(topic="rgb_camera"),), faults=(DRIFT,)),
            "The adaptation 'redeploy altimeter' refers to the node 'altimeter', which is not there",
        ),
        (Extension(signals=(ALTITUDE,)), "The signal altimeter_altitude refers to the node 'altimeter'"),
        (
            Extension(signals=(Signal("camera", "entropy", threshold=1.0),)),
            "segmentation_entropy and camera_entropy have thresholds of the same name, entropy_threshold",
        ),
        (
            Extension(nodes=(ALTIMETER,), faults=(DRIFT,)),
            "The fault altimeter_drift refers to the failure 'F6', which is not there",
        ),
        (
            Extension(
                nodes=(node("altimeter", (), ()),), failures=(failure(topic="rgb_camera"),), faults=(DRIFT,)
            ),
            "of the node altimeter does not have the parameter 'altimeter_drift'",
        ),
        (
            Extension(adaptations=(Adaptation(AdaptationKind.RESTART, "radar"),)),
            r"The adaptation 'restart radar' refers to the node 'radar', which is not there",
        ),
        (
            Extension(adaptations=(Adaptation(AdaptationKind.SET_PARAMETER, "camera"),)),
            "must name a parameter, got ''",
        ),
        (
            Extension(
                adaptations=(
                    Adaptation(AdaptationKind.CHANGE_TOPIC, "sensor_fusion", "topic_camera_input", "x"),
                )
            ),
            "No node publishes on the topic /managed_subsystem/x",
        ),
        (Extension(suites={"mine": ()}), "The suite mine has no scenario"),
        (
            Extension(node_classes={"cammera": Altimeter}),
            "A class in node_classes refers to the node 'cammera', which is not there: did you mean 'camera'",
        ),
        (
            Extension(node_classes={"camera": Altimeter}),
            "The class of the node camera is Camera: Altimeter must be a subclass of it, or be left out",
        ),
    ],
)
def test_what_contradicts_itself_gets_one_sentence(extension: Extension, sentence: str) -> None:
    with pytest.raises(ExtensionError, match=sentence) as caught:
        check_all(System(PAPER, extension), extension)
    assert str(caught.value).endswith(".")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["2a", "a b", "a-b", "", "ä"])
def test_a_name_is_an_identifier(name: str) -> None:
    sentence = "The name must be a name of letters, digits and _ that does not begin with a digit, got "
    with pytest.raises(ExtensionError, match=sentence):
        NodeDescription(name, Altimeter, ())
