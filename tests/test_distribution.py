"""What a built distribution says of itself."""

import runpy
import shutil
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.thorough
def test_links_of_the_readme_lead_to_the_repository_that_the_citation_names(tmp_path: Path) -> None:
    pytest.importorskip("hatchling")
    shutil.copy(ROOT / "README.md", tmp_path)
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    (tmp_path / "CITATION.cff").write_text(
        citation.replace("github.com/OWNER", "host.example/group"), "utf-8"
    )
    metadata: dict[str, Any] = {}

    runpy.run_path(str(ROOT / "hatch_build.py"))["Metadata"](str(tmp_path), {}).update(metadata)

    text, here = metadata["readme"]["text"], "https://host.example/group/sunset"
    assert metadata["urls"]["Repository"] == here
    assert f"]({here}/blob/v0.1.0/docs/metrics.md)" in text
    assert f"]({here}/raw/v0.1.0/docs/pictures/overview.webp)" in text
    assert f"git clone {here} sunset" in text
    assert "](docs/" not in text
    assert "](#the-paper)" in text


def test_the_weights_that_are_apart_have_the_licence_of_the_whole() -> None:
    folder = ROOT / "models" / "reference"
    if not folder.is_dir():
        pytest.skip("a source distribution has no weights that are apart")
    assert (folder / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
