"""Names of nodes, topics, services and parameters: the rules, expansion and remapping.

The rules: https://design.ros2.org/articles/topic_and_service_names.html. A name that breaks them, or is too long,
raises the `NameValidationException` of its kind.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from sunset_ros.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NameValidationException,
)

_KINDS: Final = (("topic name", InvalidTopicNameException), ("service name", InvalidServiceNameException))
_MAX_LENGTH: Final = 255
_MAX_TOPIC_LENGTH: Final = 247
"""DDS has names of at most 255 characters, of which ROS 2 keeps 8 for itself."""

_PARTS: Final = (
    (r"\A\Z", "must not be empty"),
    (r"/(?=/)", "must not contain //"),
    (r"/\Z", "must not end with a slash"),
    (r"(?<![^/])[0-9]", "a part must not start with a digit"),
)
_NODE: Final = (*_PARTS, (r"[^A-Za-z0-9_]", "must not contain {!r}"))
_NAMESPACE: Final = (
    (r"\A(?!/)", "must start with a slash"),
    *_PARTS,
    (r"[^A-Za-z0-9_/]", "must not contain {!r}"),
)
_TOPIC: Final = (
    (r"[^A-Za-z0-9_/~{}]", "must not contain {!r}"),
    (r"(?<=\A~)[^/]", "a tilde must be followed by a slash"),
    (r"\{\w+\}", "unknown substitution {}"),
    *_PARTS,
    (r"[{}]|(?!\A)~", "must not contain {!r}"),
)
"""Expressions that find an error in a name, and the rules that it breaks; `{}` is the text found."""


@dataclass(frozen=True, slots=True)
class RemapRule:
    """Replaces a name by another."""

    source: str  #: the replaced name: a topic or service name, `__node` or `__ns`
    target: str  #: the new name
    node: str | None = None  #: the only node to which it applies, by its name without namespace; None for all


def validate_node_name(node_name: str) -> None:
    """Check the name of a node: letters, digits and underscores, not starting with a digit."""
    _check(node_name, node_name, _NODE, "node name", InvalidNodeNameException)
    _check_length(node_name, _MAX_LENGTH, "node name", InvalidNodeNameException)


def validate_namespace(namespace: str) -> None:
    """Check an absolute namespace, such as `/` or `/managed_subsystem`."""
    if namespace != "/":
        _check(namespace, namespace, _NAMESPACE, "namespace", InvalidNamespaceException)


def validate_topic_name(name: str, *, is_service: bool = False) -> None:
    """Check a topic or service name before expansion; it may be relative and start with `~`."""
    plain = re.sub(r"\{(?:node|ns|namespace)\}", lambda match: "s" * len(match[0]), name)
    _check(name, plain, _TOPIC, *_KINDS[is_service])


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
    """Validate, expand and remap a topic or service name."""
    validate_topic_name(name, is_service=is_service)
    resolved = remap_name(expand_name(name, node_name, namespace), node_name, namespace, rules)
    _check_length(resolved, _MAX_TOPIC_LENGTH, *_KINDS[is_service])
    return resolved


def _check(
    name: str,
    plain: str,
    rules: Sequence[tuple[str, str]],
    kind: str,
    error: type[NameValidationException],
) -> None:
    """Check a name by its form without substitutions."""
    for pattern, rule in rules:
        match = re.search(pattern, plain)
        if match:
            raise error(kind, name, rule.format(match[0]), match.start())


def _check_length(name: str, longest: int, kind: str, error: type[NameValidationException]) -> None:
    if len(name) > longest:
        raise error(kind, name, f"longer than {longest} characters", longest)


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
