"""YAML documents whose errors name the file and the line."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import yaml

from sunset.errors import MALFORMED_YAML, ScenarioError
from sunset.system import Value


def parse_yaml(text: str, source: str) -> "Item":
    """Parse a YAML text of exactly one document with the safe loader.

    Args:
        text: the YAML text.
        source: the file's name, for messages.
    """
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f", line {mark.line + 1}" if mark else ""
        problem = error.problem or error.context or "it cannot be parsed"
        raise ScenarioError(f"{source}{line}: this is not valid YAML: {problem}.") from error
    except yaml.YAMLError as error:
        raise ScenarioError(f"{source}: this is not valid YAML: {str(error).splitlines()[0]}.") from error
    except RecursionError as error:
        raise ScenarioError(f"{source}: this is not a scenario: it is nested too deeply.") from error
    if node is None:
        raise ScenarioError(f"{source} is empty; a scenario has a name and a list of faults.")
    return Item(source, loader, node)


@dataclass(frozen=True)
class Item:
    """A part of a YAML document, with its line and its key in a mapping."""

    source: str
    loader: yaml.SafeLoader
    node: yaml.Node
    key: str = ""

    @property
    def is_list(self) -> bool:
        """Whether it is a list."""
        return isinstance(self.node, yaml.SequenceNode)

    @property
    def is_scalar(self) -> bool:
        """Whether it is a single value."""
        return isinstance(self.node, yaml.ScalarNode)

    def error(self, problem: str) -> ScenarioError:
        """Return an exception that names the file and the line."""
        return ScenarioError(f"{self.source}, line {self.node.start_mark.line + 1}: {problem}")

    @contextmanager
    def located(self) -> Iterator[None]:
        """Add the file and the line to a `ScenarioError` that is raised in this context."""
        try:
            yield
        except ScenarioError as error:
            raise self.error(str(error)) from error

    def items(self) -> list["Item"]:
        """Return the entries of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self._type_error("a list")
        return [replace(self, node=node, key="") for node in self.node.value]

    def mapping(self, *, required: tuple[str, ...], optional: tuple[str, ...]) -> dict[str, "Item"]:
        """Return the entries of a mapping that must have the `required` keys and may have the others."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self._type_error(f"a mapping with {', '.join(required or optional)}")
        fields: dict[str, Item] = {}
        for key_node, node in self.node.value:
            key = replace(self, node=key_node)
            # the text of the file, since YAML takes the key on for a truth value
            name = key_node.value if isinstance(key_node, yaml.ScalarNode) else key.text()
            if name not in (*required, *optional):
                allowed = ", ".join((*required, *optional))
                raise key.error(f"the key {name!r} is not known here; there are {allowed}.")
            if name in fields:
                raise key.error(f"the key {name!r} is given twice.")
            fields[name] = replace(self, node=node, key=name)
        for name in required:
            if name not in fields:
                raise self.error(f"the key {name!r} is missing.")
        return fields

    def value(self) -> Value:
        """Return a truth value, a number or a text."""
        if isinstance(self.node, yaml.ScalarNode):
            text = self.node.value
            try:
                value = self.loader.construct_object(self.node)
            except (yaml.YAMLError, *MALFORMED_YAML) as error:
                raise self.error(f"{text!r} is not a value that a fault can have.") from error
            if isinstance(value, bool | int | float | str):
                return value
        raise self._type_error("a truth value, a number or a text")

    def number(self) -> float:
        """Return a number."""
        value = self.value()
        if isinstance(value, bool | str):
            raise self._type_error("a number", repr(value))
        return value

    def text(self) -> str:
        """Return a text."""
        value = self.value()
        if not isinstance(value, str):
            raise self._type_error("a text", repr(value))
        return value

    def _type_error(self, expected: str, got: str = "") -> ScenarioError:
        if isinstance(self.node, yaml.MappingNode):
            got = "a mapping"
        elif isinstance(self.node, yaml.SequenceNode):
            got = "a list"
        place = f"for {self.key!r}" if self.key else "here"
        scalar = f"{self.node.value!r}" if self.node.value else "nothing"
        return self.error(f"{expected} is expected {place}, got {got or scalar}.")
