"""What a managing system sees."""

import copy
import inspect
import math
from collections.abc import Callable

import pytest

from sunset.managing import FloatOrNaN, Symptoms
from sunset.managing.symptoms import read_parameters
from sunset.system import current_system
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter, ParameterType, ParameterValue

KEY = "managed_subsystem_rgb_camera_freq"


def test_it_is_a_mapping_of_the_blackboard() -> None:
    symptoms = Symptoms({"camera_autofocus_needed": True, "segmentation_entropy": 0.2})
    assert symptoms.get("camera_autofocus_needed") is True
    assert dict(symptoms) == {"camera_autofocus_needed": True, "segmentation_entropy": 0.2}
    assert len(symptoms) == 2
    with pytest.raises(KeyError):
        symptoms["camera_sharpness"]


def test_what_it_does_not_have_is_answered_with_what_is_like_it() -> None:
    with pytest.raises(
        AttributeError, match=r"no 'unsur': did you mean 'unsure', or name one of age, autofocus_needed, "
    ):
        getattr(Symptoms({}), "unsur")  # noqa: B009  a type checker would complain
    assert not hasattr(Symptoms({}), "__len_hint__")
    assert copy.deepcopy(Symptoms({KEY: 9.0})).frequency("rgb_camera") == 9.0


def test_it_does_not_change_with_the_blackboard() -> None:
    blackboard: dict[str, bool | int | float | str] = {"segmentation_entropy": 0.2}
    symptoms = Symptoms(blackboard)
    blackboard["segmentation_entropy"] = 0.9
    assert symptoms.entropy == 0.2


@pytest.mark.parametrize("topic", ["rgb_camera", "/managed_subsystem/rgb_camera"])
def test_topics_have_short_and_full_names(topic: str) -> None:
    assert Symptoms({KEY: 9.0}).frequency(topic) == 9.0


def test_a_topic_outside_of_the_managed_system_has_its_full_name() -> None:
    assert Symptoms({"rgb_raw_freq": 10.0}).frequency("/rgb_raw") == 10.0


def test_the_last_message_on_a_topic_has_an_age() -> None:
    symptoms = Symptoms({"managed_subsystem_rgb_camera_age": 0.3})
    assert symptoms.age("rgb_camera") == 0.3
    assert math.isnan(symptoms.age("depth_camera"))
    with pytest.raises(ValueError, match="There is no topic 'rgb_camara': did you mean 'rgb_camera'"):
        symptoms.age("rgb_camara")


def test_a_topic_stops_only_after_it_was_heard() -> None:
    assert not Symptoms({}).stopped("rgb_camera")
    assert not Symptoms({KEY: 1.0}).stopped("rgb_camera")
    assert Symptoms({KEY: 0.0}).stopped("rgb_camera")


def test_what_is_not_measured_yet_has_a_default_that_triggers_nothing() -> None:
    symptoms = Symptoms({})
    assert math.isnan(symptoms.frequency("rgb_camera"))
    assert math.isnan(symptoms.entropy)
    assert math.isnan(symptoms.sharpness)
    assert math.isnan(symptoms.heartbeat("camera"))
    assert not symptoms.entropy > 0
    answers = (symptoms.unsure, symptoms.autofocus_needed, symptoms.stopped("rgb_camera"), symptoms.up)
    assert answers == (False, False, False, False)
    assert symptoms.state("camera") == "unknown"


@pytest.mark.parametrize(
    ("entropy", "unsure"), [(0.19, False), (0.2, False), (0.21, True), (math.nan, False)]
)
def test_the_segmentation_is_unsure_over_the_threshold(entropy: float, *, unsure: bool) -> None:
    assert Symptoms({"segmentation_entropy": entropy}, entropy_threshold=0.2).unsure is unsure


def test_the_system_has_come_up_when_there_was_a_segmentation() -> None:
    key = "managed_subsystem_segmentation_freq"
    assert not Symptoms({KEY: 10.0}).up
    assert Symptoms({key: 0.0}).up


def test_the_type_says_what_stands_for_a_number_that_is_not_measured() -> None:
    properties = [vars(Symptoms)[name].fget for name in ("entropy", "sharpness")]
    for measured in (*properties, Symptoms.frequency, Symptoms.age, Symptoms.heartbeat):
        assert inspect.signature(measured).return_annotation is FloatOrNaN


def test_nodes_have_states_and_heartbeats() -> None:
    symptoms = Symptoms({"camera_lc_state": "active", "camera_heartbeat_freq": 10.0, "camera_sharpness": 0.5})
    assert symptoms.state("/managed_subsystem/camera") == "active"
    assert symptoms.heartbeat("camera") == 10.0
    assert symptoms.sharpness == 0.5


@pytest.mark.parametrize("ask", [Symptoms.frequency, Symptoms.stopped])
def test_a_topic_that_nothing_measures_is_refused(ask: Callable[[Symptoms, str], object]) -> None:
    with pytest.raises(ValueError, match=r"no topic 'rgb_kamera': did you mean 'rgb_camera', or name one of"):
        ask(Symptoms({KEY: 9.0}), "rgb_kamera")


@pytest.mark.parametrize("ask", [Symptoms.state, Symptoms.heartbeat])
def test_a_node_that_has_no_heartbeat_is_refused(ask: Callable[[Symptoms, str], object]) -> None:
    with pytest.raises(
        ValueError, match=r"no node 'sensors_fusion': did you mean 'sensor_fusion', or name one"
    ):
        ask(Symptoms({"camera_lc_state": "active"}), "sensors_fusion")


@pytest.mark.parametrize("name", [None, 3, "x" * 9999], ids=["none", "number", "long"])
@pytest.mark.parametrize("ask", [Symptoms.age, Symptoms.state, Symptoms.signal, Symptoms.__getitem__])
def test_what_is_no_name_is_one_short_sentence(
    ask: Callable[[Symptoms, object], object], name: object
) -> None:
    with pytest.raises((ValueError, KeyError), match=r" no \w+ (None|3|'x{99}…): name one of") as raised:
        ask(Symptoms({}), name)
    assert len(str(raised.value)) < 700


def test_a_signal_is_read_by_name() -> None:
    assert Symptoms({"camera_sharpness": 0.5}).signal("camera_sharpness") == 0.5
    assert math.isnan(Symptoms({}).signal("camera_sharpness"))
    assert Symptoms({"altimeter_height": 12.0}).signal("altimeter_height") == 12.0
    match = (
        r"There is no signal 'segmentation_entropie': did you mean 'segmentation_entropy', or name one of "
        r"segmentation_entropy, camera_sharpness\. If an extension adds it, pass --extension\."
    )
    with pytest.raises(ValueError, match=match):
        Symptoms({}).signal("segmentation_entropie")


def test_a_missing_entry_is_told_with_the_entries_that_there_are() -> None:
    symptoms = Symptoms({"altimeter_height": 12.0})
    with pytest.raises(
        KeyError, match=r"no entry 'altimeter_hight': did you mean 'altimeter_height', or name"
    ):
        symptoms["altimeter_hight"]
    with pytest.raises(KeyError, match=r"does not have 'segmentation_entropy' yet"):
        symptoms["segmentation_entropy"]
    assert symptoms.get("altimeter_hight") is None
    assert "altimeter_hight" not in symptoms


def test_whatever_the_monitor_and_the_launcher_know_is_known_before_it_is_heard() -> None:
    for topic in current_system().topics:
        assert math.isnan(Symptoms({}).frequency(topic))
    for node in current_system().managed_nodes:
        assert Symptoms({}).state(node) == "unknown"


def test_a_node_of_ones_own_is_known_once_it_is_heard() -> None:
    assert Symptoms({"thermal_lc_state": "active"}).state("thermal") == "active"


def test_parameters_of_the_four_types_are_read() -> None:
    def parameter(name: str, value: ParameterValue) -> Parameter:
        return Parameter(name=name, value=value)

    values = read_parameters(
        [
            parameter("b", ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)),
            parameter("i", ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=3)),
            parameter("d", ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=0.5)),
            parameter("s", ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="x")),
            parameter("n", ParameterValue()),
        ]
    )
    assert values == {"b": True, "i": 3, "d": 0.5, "s": "x"}
