"""What reasons about a managed system names no part of one: it takes all of them from the description."""

import ast
from pathlib import Path

import pytest

import sunset.managing
from sunset.system.paper import PAPER

GENERAL = ("diagnosing", "tools", "watching")
NAMES = {
    *(node.name for node in PAPER.nodes),
    *(topic.name.strip("/") for topic in PAPER.topics),
    *(fault.name for fault in PAPER.faults),
    *(failure.name for failure in PAPER.failures),
    *(adaptation.parameter for adaptation in PAPER.named_adaptations if adaptation.parameter),
}


def texts(source: str) -> set[str]:
    """Return the texts of a module that are not documentation, and its names of variables."""
    tree = ast.parse(source)
    documentation = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    constants = {
        str(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and id(node) not in documentation
    }
    return constants | {node.id.lower() for node in ast.walk(tree) if isinstance(node, ast.Name)}


@pytest.mark.parametrize("module", GENERAL)
def test_no_part_of_the_papers_system_is_named(module: str) -> None:
    source = Path(sunset.managing.__file__).with_name(f"{module}.py").read_text(encoding="utf-8")
    assert texts(source) & NAMES == set()


def test_a_name_would_be_found() -> None:
    source = Path(sunset.managing.__file__).with_name("reactive.py").read_text(encoding="utf-8")
    assert texts(source) & NAMES >= {"camera", "sensor_fusion", "modality"}
