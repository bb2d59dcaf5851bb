"""The pages and the notebook about Python do what they say."""

import contextlib
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"

pytestmark = pytest.mark.usefixtures("flight")


@pytest.mark.parametrize("page", ["python.md", "learning.md"])
def test_the_page_prints_what_it_shows(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (DOCS / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```(python|text)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    names: dict[str, Any] = {"__name__": "page"}
    printed = ""

    for language, block in blocks:
        if language == "text":
            assert printed == block
            printed = ""
        else:
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(block, names)  # noqa: S102  the page is ours
            printed += out.getvalue()

    assert printed == ""


@pytest.mark.thorough
def test_the_notebook_runs_and_prints_what_it_shows() -> None:
    notebook = json.loads((DOCS / "first_flight.ipynb").read_text(encoding="utf-8"))
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names: dict[str, Any] = {"__name__": "__main__"}

    for cell in cells:
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec("".join(cell["source"]), names)  # noqa: S102  the notebook is ours
        shown = "".join(text for output in cell["outputs"] for text in output.get("text", ()))
        assert out.getvalue() == shown
        assert cell["outputs"]

    assert names["focused"].metrics.iou > names["idle"].metrics.iou
    assert [str(adaptation) for adaptation in names["focused"].adaptations] == [
        "set camera.perform_autofocus to true"
    ]
    gained = names["comparison"]["iou"].difference
    assert gained.low > 0
    assert gained.runs == 3
    assert names["check"].passed
