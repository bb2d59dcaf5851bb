"""Reading YAML such that every complaint names the file and the line."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Final

import yaml

from sunset.errors import MALFORMED_YAML, ScenarioError
from sunset.system import Value

_DECIMAL: Final = re.compile(
    r"[-+]?(?:0|[1-9][0-9]*|[0-9]*\.[0-9]*(?:[eE][-+][0-9]+)?|\.(?:inf|Inf|INF))|\.(?:nan|NaN|NAN)"
)
"""Numbers that mean the same in every version of YAML."""


def is_ambiguous(text: str, value: object) -> bool:
    """Return whether a text is this number in YAML 1.1 only, which is read here, and surprises.

    >>> is_ambiguous("1:30", 90), is_ambiguous("010", 8), is_ambiguous("10", 10)
    (True, True, False)
    """
    return isinstance(value, int | float) and not isinstance(value, bool) and not _DECIMAL.fullmatch(text)


def parse_yaml(text: str, source: str) -> "Item":
    """Read a YAML text with the safe loader, which can make numbers, texts, lists and mappings only.

    Args:
        text: the YAML text, of exactly one document.
        source: the file's name, for messages.

    Raises:
        ScenarioError: it is not valid YAML, or empty.
    """
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
    except yaml.MarkedYAMLError as error:
        if isinstance(error, yaml.composer.ComposerError) and error.problem == "but found another document":
            raise ScenarioError(
                f"{source}: it holds several YAML documents, divided by ---; a file has one, which may be a list of "
                "scenarios."
            ) from error
        mark = error.problem_mark or error.context_mark
        line = f", line {mark.line + 1}" if mark else ""
        problem = error.problem or error.context or "it cannot be parsed"
        raise ScenarioError(f"{source}{line}: this is not valid YAML: {problem}.") from error
    except yaml.YAMLError as error:
        reason = str(error).splitlines()[0]
        raise ScenarioError(f"{source}: this is not valid YAML: {reason}.") from error
    except RecursionError as error:
        raise ScenarioError(f"{source}: this is not a scenario: it is nested too deeply.") from error
    if node is None:
        raise ScenarioError(f"{source} is empty; a scenario has a name and a list of faults.")
    return Item(source, loader, node)


@dataclass(frozen=True)
class Item:
    """A part of a YAML text, which knows its line, and its key in a mapping."""

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

    def error(self, what: str) -> ScenarioError:
        """Return an exception that says where it was found."""
        return ScenarioError(f"{self.source}, line {self.node.start_mark.line + 1}: {what}")

    @contextmanager
    def located(self) -> Iterator[None]:
        """Let a `ScenarioError` raised in this context name the file and the line."""
        try:
            yield
        except ScenarioError as error:
            raise self.error(str(error)) from error

    def items(self) -> list["Item"]:
        """Return the entries of a list."""
        if not isinstance(self.node, yaml.SequenceNode):
            raise self.error(f"a list is expected {self._place}, got {self._kind}.")
        return [replace(self, node=node, key="") for node in self.node.value]

    def mapping(self, *, required: tuple[str, ...], optional: tuple[str, ...]) -> dict[str, "Item"]:
        """Return the entries of a mapping that must have the `required` keys and may have the others."""
        if not isinstance(self.node, yaml.MappingNode):
            raise self.error(
                f"a mapping with {', '.join(required or optional)} is expected {self._place}, got {self._kind}."
            )
        fields: dict[str, Item] = {}
        for key_node, node in self.node.value:
            key = replace(self, node=key_node)
            # as it is written: the key on would be a truth value
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
            try:
                value = self.loader.construct_object(self.node)
            except (yaml.YAMLError, *MALFORMED_YAML) as error:
                raise self.error(f"{self.node.value!r} is not a value that a fault can have.") from error
            if is_ambiguous(self.node.value, value):
                raise self.error(
                    f"{self.node.value!r} would be {value!r}, by a rule of YAML 1.1; write a number in decimal digits "
                    "without a 0 in front, a text in quotes."
                )
            if isinstance(value, bool | int | float | str):
                return value
        raise self.error(f"a truth value, a number or a text is expected {self._place}, got {self._kind}.")

    def number(self) -> float:
        """Return a number."""
        value = self.value()
        if isinstance(value, bool | str):
            raise self.error(f"a number is expected {self._place}, got {value!r}.")
        return value

    def text(self) -> str:
        """Return a text."""
        value = self.value()
        if not isinstance(value, str):
            raise self.error(f"a text is expected {self._place}, got {value!r}.")
        return value

    @property
    def _place(self) -> str:
        return f"for {self.key!r}" if self.key else "here"

    @property
    def _kind(self) -> str:
        if isinstance(self.node, yaml.MappingNode):
            return "a mapping"
        if isinstance(self.node, yaml.SequenceNode):
            return "a list"
        return f"{self.node.value!r}" if self.node.value else "nothing"
