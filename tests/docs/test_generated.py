"""Pages that scripts write are as the scripts write them."""

import re
import sys
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

import pytest
from scripts.fault_pages import faults_page

from sunset.evaluation.layout import lead_blocks
from sunset.perception import list_models
from sunset.system import current_system

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


@pytest.fixture
def write_results(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    loader = SourceFileLoader("write_results", str(ROOT / "scripts" / "write_results"))
    spec = spec_from_loader(loader.name, loader)
    assert spec is not None
    module = module_from_spec(spec)
    monkeypatch.setitem(sys.modules, loader.name, module)
    loader.exec_module(module)
    return module


def test_the_page_of_faults_is_that_of_the_catalogue_and_each_has_its_picture() -> None:
    assert (DOCS / "faults.md").read_text(encoding="utf-8") == faults_page()
    pictures = {path.stem: path.stat().st_size for path in (DOCS / "pictures").iterdir()}
    assert set(pictures) == {"overview", *current_system().faults}
    assert pictures.pop("overview") <= 150_000
    assert max(pictures.values()) <= 60_000


@pytest.mark.parametrize(("name", "least"), [("results", 3), ("measurements", 4 + len(list_models()))])
def test_a_page_of_results_shows_what_the_files_beside_it_have(
    write_results: ModuleType, name: str, least: int
) -> None:
    page = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    sections = [section for section in write_results.PAGES[name][1] if section.details]
    assert len(sections) >= least
    if name == "results":  # the gallery is flown apart
        sections += [one for one in write_results.GALLERY if (DOCS / "results" / one.details).exists()]
    for section in sections:
        details = (DOCS / "results" / section.details).read_text(encoding="utf-8")
        assert section.page(details) in page
    with pytest.raises(SystemExit, match="printed nothing that fits"):
        sections[0].page("something else")


def test_the_tables_that_lead_the_results_have_the_columns_of_this_version() -> None:
    paper = (DOCS / "results" / "paper.txt").read_text(encoding="utf-8")
    heads = {tuple(re.split(" {2,}", line)) for line in paper.splitlines() if line.startswith("system ")}
    for block in lead_blocks([]):
        assert ("system", "runs", *(column.text for column in block.columns)) in heads
