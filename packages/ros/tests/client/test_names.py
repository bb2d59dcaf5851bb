import pytest

from sunset_ros.errors import SunsetError
from sunset_ros.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)
from sunset_ros.names import (
    RemapRule,
    expand_name,
    resolve_name,
    validate_namespace,
    validate_node_name,
    validate_topic_name,
)


@pytest.mark.parametrize(
    ("name", "expanded"),
    [
        ("image", "/uav/front/image"),
        ("sub/image", "/uav/front/sub/image"),
        ("/image", "/image"),
        ("~", "/uav/front/camera"),
        ("~/image", "/uav/front/camera/image"),
        ("{node}/image", "/uav/front/camera/image"),
        ("{ns}/image", "/uav/front/image"),
        ("/all/{node}", "/all/camera"),
    ],
)
def test_names_expand(name: str, expanded: str) -> None:
    validate_topic_name(name)
    assert expand_name(name, "camera", "/uav/front") == expanded


@pytest.mark.parametrize(
    ("name", "expanded"), [("image", "/image"), ("~/image", "/camera/image"), ("{ns}/x", "/x")]
)
def test_names_expand_in_the_root(name: str, expanded: str) -> None:
    assert expand_name(name, "camera", "/") == expanded


@pytest.mark.parametrize(
    ("name", "reason", "position"),
    [
        ("", "must not be empty", 1),
        ("a b", "must not contain ' '", 2),
        ("a-b", "must not contain '-'", 2),
        ("/a//b", "must not contain //", 3),
        ("a/", "must not end with a slash", 2),
        ("/", "must not end with a slash", 1),
        ("1a", "must not start with a digit", 1),
        ("/a/2b", "must not start with a digit", 4),
        ("~a", "a tilde must be followed by a slash", 2),
        ("a~", "must not contain '~'", 2),
        ("{unknown}/a", "unknown substitution {unknown}", 1),
        ("a{node", "must not contain '{'", 2),
        ("bild/größe", "must not contain 'ö'", 8),
    ],
)
def test_wrong_topic_names_are_refused_with_reason_and_position(
    name: str, reason: str, position: int
) -> None:
    with pytest.raises(InvalidTopicNameException) as caught:
        validate_topic_name(name)
    assert reason in str(caught.value)
    assert f"(at character {position} of {len(name)})" in str(caught.value)
    assert isinstance(caught.value, (SunsetError, ValueError))
    with pytest.raises(InvalidServiceNameException, match="Invalid service name"):
        validate_topic_name(name, is_service=True)


@pytest.mark.parametrize("name", ["", "a/b", "1a", "a b", "~", "x" * 256])
def test_wrong_node_names_are_refused(name: str) -> None:
    with pytest.raises(InvalidNodeNameException, match="Invalid node name"):
        validate_node_name(name)


@pytest.mark.parametrize("namespace", ["", "uav", "/uav/", "//", "/1", "/a b"])
def test_wrong_namespaces_are_refused(namespace: str) -> None:
    with pytest.raises(InvalidNamespaceException, match="Invalid namespace"):
        validate_namespace(namespace)


@pytest.mark.parametrize("namespace", ["/", "/uav", "/uav/front_1"])
def test_right_namespaces_are_accepted(namespace: str) -> None:
    validate_namespace(namespace)


def test_the_first_rule_that_matches_is_used() -> None:
    rules = [
        RemapRule("image", "other", node="depth"),
        RemapRule("__node", "image"),
        RemapRule("image", "~/first"),
        RemapRule("/uav/image", "/second"),
        RemapRule("~/state", "/state"),
    ]
    assert resolve_name("image", "camera", "/uav", rules) == "/uav/camera/first"
    assert resolve_name("image", "depth", "/uav", rules) == "/uav/other"
    assert resolve_name("/uav/camera/state", "camera", "/uav", rules) == "/state"
    assert resolve_name("/image", "camera", "/uav", rules) == "/image"


def test_a_topic_is_no_longer_than_dds_has_room_for() -> None:
    assert len(resolve_name("x" * 242, "camera", "/uav", [])) == 247
    with pytest.raises(InvalidTopicNameException, match="longer than 247 characters"):
        resolve_name("x" * 243, "camera", "/uav", [])
    with pytest.raises(InvalidServiceNameException, match="longer than 247 characters"):
        resolve_name("x" * 243, "camera", "/uav", [], is_service=True)
