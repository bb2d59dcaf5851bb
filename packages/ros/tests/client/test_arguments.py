from pathlib import Path

import pytest

from sunset_ros._parameter_files import matches, parse_value, read_parameter_file
from sunset_ros.arguments import Arguments
from sunset_ros.errors import ParameterError
from sunset_ros.exceptions import UnknownROSArgsError
from sunset_ros.logging import LoggingSeverity
from sunset_ros.names import RemapRule


def test_ros_arguments_stand_between_their_mark_and_a_double_dash() -> None:
    arguments = Arguments.parse(
        ["program", "-p", "--ros-args", "-r", "a:=b", "--", "-r", "--ros-args", "-p", "x:=1"]
    )
    assert arguments.others == ["program", "-p", "-r"]
    assert arguments.remaps == [RemapRule("a", "b")]
    assert [override.parameter.name for override in arguments.overrides] == ["x"]


def test_all_options_are_understood() -> None:
    arguments = Arguments.parse(
        [
            "--ros-args",
            *("--remap", "image:=/camera/image", "-r", "__name:=camera", "-r", "depth:__ns:=/uav"),
            *("--param", "speed:=1.5", "-p", "camera:names:=[a, b]"),
            *("--log-level", "debug", "--enable-stdout-logs", "--disable-rosout-logs"),
        ]
    )
    assert arguments.remaps == [
        RemapRule("image", "/camera/image"),
        RemapRule("__node", "camera"),
        RemapRule("__ns", "/uav", "depth"),
    ]
    given = [(each.nodes, each.parameter.name, each.parameter.value) for each in arguments.overrides]
    assert given == [("/**", "speed", 1.5), ("/**/camera", "names", ["a", "b"])]
    assert arguments.log_level is LoggingSeverity.DEBUG
    assert (arguments.log_to_stderr, arguments.log_to_rosout) == (True, False)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--nonsense"], "ROS argument '--nonsense' is unknown; after --ros-args may come -r, --remap"),
        (["stray"], "ROS argument 'stray' is unknown"),
        (["-r"], "ROS argument -r needs a value after it"),
        (["-r", "a=b"], "must be FROM:=TO or NODE:FROM:=TO, got 'a=b'"),
        (["-r", ":=b"], "must be FROM:=TO"),
        (["-r", "a:="], "must be FROM:=TO"),
        (["-r", "a:=b c"], "The remapping 'a:=b c' cannot be used: Invalid topic name 'b c'"),
        (["-r", "__node:=a/b"], "Invalid node name 'a/b'"),
        (["-r", "__ns:=uav"], "Invalid namespace 'uav': must start with a slash"),
        (["-p", "speed"], "must be NAME:=VALUE or NODE:NAME:=VALUE, got 'speed'"),
        (["-p", ":=1"], "must be NAME:=VALUE"),
        (["--log-level", "loud"], "must be one of UNSET, DEBUG, INFO, WARN, ERROR, FATAL, got 'loud'"),
    ],
)
def test_what_is_not_understood_is_refused(words: list[str], message: str) -> None:
    with pytest.raises(UnknownROSArgsError) as caught:
        Arguments.parse(["--ros-args", *words])
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("off", False),
        ("7", 7),
        ("-0x1f", -31),
        ("007", 7),
        ("1.0", 1.0),
        ("1e3", 1000.0),
        ("-.5", -0.5),
        (".inf", float("inf")),
        ("rgb_camera", "rgb_camera"),
        ("'7'", "7"),
        ("2026-01-01", "2026-01-01"),
        ("1:30", "1:30"),
        ("[1, 2]", [1, 2]),
        ("[1, 2.5]", [1.0, 2.5]),
        ("[true, false]", [True, False]),
        ("[a, b]", ["a", "b"]),
    ],
)
def test_values_are_read_as_ros_reads_them(text: str, value: object) -> None:
    read = parse_value(text, "parameter 'p'")
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no value"),
        ("~", "has no value"),
        ("[1, a]", "the elements of a list must all be of one type"),
        ("{a: 1}", "a parameter cannot hold {'a': 1}"),
        ("[1", "line 1 is not valid YAML"),
        ("!!python/object:os.system x", "is not valid YAML"),
        ("!!timestamp foo", "is not valid YAML"),
        ("99999999999999999999", "must fit into 64 bits"),
    ],
)
def test_what_is_no_value_is_refused(text: str, message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        parse_value(text, "parameter 'p'")
    assert message.lower() in str(caught.value).lower()
    assert "parameter 'p'" in str(caught.value)


@pytest.mark.parametrize(
    ("pattern", "node", "matched"),
    [
        ("/**", "/camera", True),
        ("/**", "/uav/camera", True),
        ("/*", "/camera", True),
        ("/*", "/uav/camera", False),
        ("/*/camera", "/uav/camera", True),
        ("/**/camera", "/camera", True),
        ("/**/camera", "/a/b/camera", True),
        ("/uav/**", "/uav/a/b", True),
        ("camera", "/camera", True),
        ("/camera", "/uav/camera", False),
        ("/cam.ra", "/camera", False),
    ],
)
def test_patterns_name_nodes(pattern: str, node: str, matched: bool) -> None:
    assert matches(pattern, node) is matched


def test_a_parameter_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(
        "/**:\n  ros__parameters: {seed: 3}\n"
        "/uav:\n  camera:\n    ros__parameters:\n      image: {shift: 20, blur: {sigma: 1.5}}\n"
        "depth:\n  ros__parameters: {}\n"
    )
    read = [(each.nodes, each.parameter.name, each.parameter.value) for each in read_parameter_file(file)]
    assert read == [
        ("/**", "seed", 3),
        ("/uav/camera", "image.shift", 20),
        ("/uav/camera", "image.blur.sigma", 1.5),
    ]


def test_an_empty_parameter_file_says_nothing(tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text("# nothing\n")
    assert read_parameter_file(file) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]", "must map node names to 'ros__parameters', got [1, 2]"),
        ("camera:\n  speed: 1\n", "'speed' at /camera must hold 'ros__parameters' before any value, got 1"),
        ("camera: 1\n", "'camera' at the top level must hold 'ros__parameters'"),
        ("camera:\n  ros__parameters: 1\n", "ros__parameters of /camera must be a map, got 1"),
        ("camera:\n  ros__parameters:\n    a: [1, x]\n", "parameter 'a' of /camera in"),
        ("camera:\n  ros__parameters:\n    a: 1\n    a: 2\n", "line 4 is not valid YAML: 'a' is given twice"),
        ("camera:\n  ros__parameters: {a: 1\n", "line 3 is not valid YAML"),
        ("? [1]\n: 2\n", "line 1 is not valid YAML: found unhashable key"),
    ],
)
def test_a_malformed_parameter_file_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(text)
    with pytest.raises(ParameterError) as caught:
        read_parameter_file(file)
    assert message in str(caught.value)
    assert str(file) in str(caught.value)


def test_a_parameter_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="cannot be read"):
        Arguments.parse(["--ros-args", "--params-file", str(tmp_path / "missing.yaml")])
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ParameterError, match="cannot be read"):
        read_parameter_file(tmp_path / "binary.yaml")
