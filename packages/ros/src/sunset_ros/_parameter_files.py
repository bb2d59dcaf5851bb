"""Parameter values and files as ROS writes them: YAML, read safely."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml

from sunset_ros.errors import MALFORMED_YAML, ParameterError
from sunset_ros.exceptions import InvalidParameterTypeException
from sunset_ros.parameter import Parameter, Value

_SECTION = "ros__parameters"


@dataclass(frozen=True, slots=True)
class Override:
    """The value that a parameter gets in the nodes that a pattern names.

    `*` in the pattern of fully qualified names stands for a part, `**` for any number of parts.
    """

    nodes: str
    parameter: Parameter


class _Loader(yaml.SafeLoader):
    """YAML with ROS's idea of scalars: bool, integer, float and text; no dates, no base 60."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[object, object]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for index, (key, _) in enumerate(node.value):
            if keys[index] in keys[:index]:
                problem = f"{keys[index]!r} is given twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
        return super().construct_mapping(node, deep)


_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern in {
    "null": r"~|null|Null|NULL|",
    "bool": r"y|Y|yes|Yes|YES|n|N|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF",
    "int": r"[-+]?(?:[0-9]+|0x[0-9a-fA-F]+|0b[01]+)",
    "float": (
        r"[-+]?(?:(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[0-9]+[eE][-+]?[0-9]+|\.(?:inf|Inf|INF))"
        r"|\.(?:nan|NaN|NAN)"
    ),
}.items():
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(rf"(?:{_pattern})\Z"), None)
_Loader.add_constructor(
    "tag:yaml.org,2002:bool", lambda _, node: str(node.value).lower() in {"y", "yes", "true", "on"}
)


_Loader.add_constructor("tag:yaml.org,2002:int", lambda _, node: _int_of(str(node.value)))


def _int_of(text: str) -> int:
    return int(text, {"0x": 16, "0b": 2}.get(text.lstrip("+-")[:2], 10))


def parse_value(text: str, what: str) -> Value:
    """Read the value of a parameter from YAML: a bool, integer, float, text, or a list of them.

    >>> parse_value("1e-3", "p"), parse_value("[1, 2]", "p"), parse_value("rgb_camera", "p")
    (0.001, [1, 2], 'rgb_camera')
    """
    return _checked(_load(text, what), what)


def read_parameter_file(path: Path) -> list[Override]:
    """Read a ROS parameter file: node name (or a pattern) → `ros__parameters` → name → value."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"Parameter file {path} cannot be read: {error}.") from error
    content = _load(text, f"parameter file {path}")
    if content is None:
        return []
    if not isinstance(content, dict):
        raise ParameterError(f"Parameter file {path} must map node names to {_SECTION!r}, got {content!r}.")
    return list(_walk(content, "", path))


def matches(pattern: str, node: str) -> bool:
    """Return whether a pattern names a node, given by its fully qualified name.

    >>> matches("/**", "/uav/camera"), matches("/*/camera", "/uav/camera"), matches("/camera", "/uav/camera")
    (True, True, False)
    """
    parts = pattern.strip("/").split("/")
    translated = [".*" if part == "**" else "[^/]*" if part == "*" else re.escape(part) for part in parts]
    expression = "/" + "/".join(translated)
    return re.fullmatch(expression.replace(".*/", "(?:.*/)?"), node) is not None


def _load(text: str, what: str) -> object:
    try:
        return yaml.load(text, Loader=_Loader)  # noqa: S506  a subclass of the safe loader
    except yaml.MarkedYAMLError as error:
        line = f", line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise ParameterError(f"The {what}{line} is not valid YAML: {error.problem}.") from error
    except (yaml.YAMLError, *MALFORMED_YAML) as error:
        raise ParameterError(f"The {what} is not valid YAML: {error}.") from error


def _walk(content: dict[object, object], nodes: str, path: Path) -> Iterator[Override]:
    for key, value in content.items():
        if key == _SECTION and nodes:
            if not isinstance(value, dict):
                raise ParameterError(
                    f"Parameter file {path}: {_SECTION} of {nodes} must be a map, got {value!r}."
                )
            yield from _parameters(value, "", nodes, path)
        elif isinstance(value, dict):
            yield from _walk(value, f"{nodes}/{str(key).strip('/')}", path)
        else:
            where = nodes or "the top level"
            raise ParameterError(
                f"Parameter file {path}: {key!r} at {where} must hold {_SECTION!r} before any value, got {value!r}."
            )


def _parameters(content: dict[object, object], prefix: str, nodes: str, path: Path) -> Iterator[Override]:
    for key, value in content.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _parameters(value, f"{name}.", nodes, path)
        else:
            checked = _checked(value, f"parameter {name!r} of {nodes} in {path}")
            yield Override(nodes, Parameter(name, value=checked))


def _checked(value: object, what: str) -> Value:
    if value is None:
        raise ParameterError(f"The {what} has no value.")
    if isinstance(value, list) and {type(item) for item in value} == {int, float}:
        value = [float(item) for item in value]
    try:
        return Parameter("value", value=value).value
    except InvalidParameterTypeException as error:
        raise ParameterError(f"The {what} cannot be used: {error}") from error
