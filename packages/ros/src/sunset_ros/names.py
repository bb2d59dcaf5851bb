"""Names of nodes, topics, services and parameters: the rules, expansion and remapping.

The rules: https://design.ros2.org/articles/topic_and_service_names.html.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from sunset_ros.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidParameterException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NameValidationException,
)

_TOKEN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_ALLOWED: Final = re.compile(r"[A-Za-z0-9_/~{}]*")
_SUBSTITUTIONS: Final = frozenset({"node", "ns", "namespace"})
_MAX_LENGTH: Final = 255
_MAX_TOPIC_LENGTH: Final = 247
"""DDS has names of at most 255 characters, of which ROS 2 keeps 8 for itself."""


@dataclass(frozen=True, slots=True)
class RemapRule:
    """Replaces a name by another.

    Attributes:
        source: the replaced name: a topic or service name, `__node` or `__ns`.
        target: the new name.
        node: the only node to which it applies, by its name without namespace; None for all.
    """

    source: str
    target: str
    node: str | None = None


def validate_node_name(node_name: str) -> None:
    """Check the name of a node: letters, digits and underscores, not starting with a digit.

    Raises:
        InvalidNodeNameException: it breaks the rules.
    """
    _check_token(node_name, node_name, 0, "node name", InvalidNodeNameException)
    if len(node_name) > _MAX_LENGTH:
        raise InvalidNodeNameException(
            "node name", node_name, f"longer than {_MAX_LENGTH} characters", _MAX_LENGTH
        )


def validate_namespace(namespace: str) -> None:
    """Check an absolute namespace, such as `/` or `/managed_subsystem`.

    Raises:
        InvalidNamespaceException: it breaks the rules.
    """
    kind = "namespace"
    if not namespace.startswith("/"):
        raise InvalidNamespaceException(kind, namespace, "must start with a slash", 0)
    if namespace != "/":
        _check_tokens(namespace, namespace[1:], 1, kind, InvalidNamespaceException)


def validate_topic_name(name: str, *, is_service: bool = False) -> None:
    """Check a topic or service name before expansion; it may be relative and start with `~`.

    Raises:
        InvalidTopicNameException: it breaks the rules.
        InvalidServiceNameException: likewise, for a service.
    """
    kind, error = _kind(is_service=is_service)
    if not name:
        raise error(kind, name, "must not be empty", 0)
    allowed = _ALLOWED.match(name)
    end = allowed.end() if allowed else 0
    if end < len(name):
        raise error(kind, name, f"must not contain {name[end]!r}", end)
    if name == "~":
        return
    start = 0
    if name[0] == "~":
        if name[1] != "/":
            raise error(kind, name, "a tilde must be followed by a slash", 1)
        start = 2
    elif name[0] == "/":
        start = 1
    plain = re.sub(r"\{(\w+)\}", lambda match: _substitute_checked(match, name, kind, error), name[start:])
    _check_tokens(name, plain, start, kind, error)


def validate_parameter_name(name: str) -> None:
    """Check the name of a parameter.

    Raises:
        InvalidParameterException: it is empty or no text.
    """
    if not isinstance(name, str) or not name:
        raise InvalidParameterException(f"A parameter's name must be a text that is not empty, got {name!r}.")


def expand_name(name: str, node_name: str, namespace: str) -> str:
    """Return the absolute form of a valid topic or service name.

    >>> expand_name("~/state", "camera", "/uav"), expand_name("image", "camera", "/"), expand_name("/a", "camera", "/")
    ('/uav/camera/state', '/image', '/a')
    """
    root = namespace.rstrip("/")
    if "{" in name:
        values = {"node": node_name, "ns": root or "/", "namespace": root or "/"}
        name = re.sub(r"\{(\w+)\}", lambda match: values[match[1]], name).replace("//", "/")
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        return f"{root}/{node_name}{name[1:]}"
    return f"{root}/{name}"


def remap_name(name: str, node_name: str, namespace: str, rules: Iterable[RemapRule]) -> str:
    """Return an absolute name after the first matching rule, as an absolute name."""
    for rule in rules:
        applies = rule.node in {None, node_name} and not rule.source.startswith("__")
        if applies and expand_name(rule.source, node_name, namespace) == name:
            return expand_name(rule.target, node_name, namespace)
    return name


def resolve_name(
    name: str, node_name: str, namespace: str, rules: Iterable[RemapRule], *, is_service: bool = False
) -> str:
    """Validate, expand and remap a topic or service name.

    Raises:
        InvalidTopicNameException: it breaks the rules, or is too long.
        InvalidServiceNameException: likewise, for a service.
    """
    validate_topic_name(name, is_service=is_service)
    resolved = remap_name(expand_name(name, node_name, namespace), node_name, namespace, rules)
    if len(resolved) > _MAX_TOPIC_LENGTH:
        kind, error = _kind(is_service=is_service)
        raise error(kind, resolved, f"longer than {_MAX_TOPIC_LENGTH} characters", _MAX_TOPIC_LENGTH)
    return resolved


def _kind(*, is_service: bool) -> tuple[str, type[NameValidationException]]:
    return (
        ("service name", InvalidServiceNameException)
        if is_service
        else ("topic name", InvalidTopicNameException)
    )


def _substitute_checked(
    match: re.Match[str], name: str, kind: str, error: type[NameValidationException]
) -> str:
    if match[1] not in _SUBSTITUTIONS:
        raise error(kind, name, f"unknown substitution {match[0]}", name.index(match[0]))
    return "s" * len(match[0])


def _check_tokens(
    whole: str, tokens: str, start: int, kind: str, error: type[NameValidationException]
) -> None:
    for token in tokens.split("/"):
        if not token:
            end = start >= len(whole)
            raise error(kind, whole, "must not end with a slash" if end else "must not contain //", start - 1)
        _check_token(whole, token, start, kind, error)
        start += len(token) + 1


def _check_token(whole: str, token: str, start: int, kind: str, error: type[NameValidationException]) -> None:
    if not isinstance(whole, str) or not token:
        raise error(kind, whole, "must not be empty", 0)
    if token[0].isdigit():
        raise error(kind, whole, "a part must not start with a digit", start)
    match = _TOKEN.match(token)
    end = match.end() if match else 0
    if end < len(token):
        raise error(kind, whole, f"must not contain {token[end]!r}", start + end)


def rename_node(node_name: str, namespace: str, rules: Sequence[RemapRule]) -> tuple[str, str]:
    """Return a node's name and namespace as rules for `__node` and `__ns` make them.

    Raises:
        NameValidationException: a name breaks the rules.
    """
    validate_node_name(node_name)
    namespace = namespace if namespace.startswith("/") else f"/{namespace}"
    applying = [rule for rule in rules if rule.node in {None, node_name}]
    node_name = next((rule.target for rule in applying if rule.source == "__node"), node_name)
    applying = [rule for rule in rules if rule.node in {None, node_name}]
    namespace = next((rule.target for rule in applying if rule.source == "__ns"), namespace)
    validate_node_name(node_name)
    validate_namespace(namespace)
    return node_name, namespace
