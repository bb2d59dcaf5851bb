"""The documentation as a site, made of the repository's Markdown; `scripts/build_docs` builds it."""

import json
import shutil
from pathlib import Path
from typing import Any, Final

from docutils.nodes import document
from myst_parser.parsers.sphinx_ import MystParser
from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, GoogleDocstring

import sunset

STYLE: Final[Any] = Config(napoleon_attr_annotations=False)
ROOT: Final = Path(__file__).parents[1]

order = {
    "First flight": ("docs/first_flight", "docs/faults", "docs/viewing", "docs/glossary"),
    "Your own managing system": (
        "docs/managing-systems",
        "docs/managing-reference",
        "docs/programs",
        "examples/gallery/README",
        "docs/behind-glass",
        "docs/learning",
    ),
    "Metrics": (
        "docs/campaigns",
        "docs/metrics",
        "docs/published",
        "docs/results",
        "docs/measurements",
        "docs/publishing",
        "docs/leaderboard",
        "docs/clusters",
        "ARTIFACT",
    ),
    "Scenarios": ("docs/scenarios", "docs/data"),
    "Extending": ("docs/extending", "docs/adding-a-node"),
    "Live": ("docs/live", "docs/agreement", "docs/containers"),
    "Models": ("docs/models",),
    "Internals": ("docs/architecture", "CONTRIBUTING", "docs/releasing", "CHANGELOG"),
    "From Python": (
        "docs/python",
        "docs/api/sunset",
        "docs/api/managing",
        "docs/api/system",
        "docs/api/nodes",
        "docs/api/faults",
        "docs/api/data",
        "packages/town/README",
        "docs/api/town",
        "packages/lab/README",
        "docs/api/metrics",
        "docs/api/recording",
        "packages/ros/README",
        "docs/api/ros",
        "docs/api/errors",
    ),
}
"""The pages, in the order in which a newcomer reads them."""

project = "SUNSET"
release = sunset.__version__
root_doc = "README"
include_patterns = ["*.md", "docs/**", "packages/*/README.md", "examples/*/README.md"]
exclude_patterns = ["docs/results/**"]
source_suffix = {".md": "markdown", ".ipynb": "notebook"}
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
default_role = "code"
suppress_warnings = ["ref.python"]  # a word in what describes a type may be the name of several attributes

myst_heading_anchors = 4

autodoc_typehints = "description"
autodoc_member_order = "bysource"
highlight_language = "text"
python_use_unqualified_type_names = True

html_theme = "furo"
html_title = f"SUNSET {release}"
html_show_sourcelink = False
html_show_copyright = False
html_copy_source = False
html_theme_options = {
    "sidebar_hide_name": False,
    "light_css_variables": {"color-brand-primary": "#0072B2", "color-brand-content": "#0072B2"},
    "dark_css_variables": {"color-brand-primary": "#56B4E9", "color-brand-content": "#56B4E9"},
}


class Notebook(MystParser):
    """Shows the cells of a notebook, and their outputs as text."""

    supported = ("notebook",)

    def parse(self, inputstring: str, document: document) -> None:
        """Parse the notebook's JSON as a page of Markdown."""
        texts = []
        for cell in json.loads(inputstring)["cells"]:
            text = "".join(cell["source"])
            texts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
            for output in cell.get("outputs", ()):
                shown = "".join(output["text"] if "text" in output else output["data"]["text/plain"])
                texts.append(f"```text\n{shown.rstrip()}\n```")
        super().parse("\n\n".join(texts), document)


def read_docstring(app: Sphinx, *event: Any) -> None:
    """Take a docstring for one of Google's style, but that of an attribute, whose colon stands before no type."""
    what, name, described, options, lines = event
    if what not in {"attribute", "data", "property"}:
        lines[:] = GoogleDocstring(lines, STYLE, app, what, name, described, options).lines()


def add_order(app: Sphinx, name: str, content: list[str]) -> None:
    """Put the order of the pages at the end of the README, where readers of the repository do not see it."""
    if name == root_doc:
        for caption, pages in app.config.order.items():
            there = [page for page in pages if any(ROOT.glob(f"{page}.*"))]
            lines = ["", "```{toctree}", ":hidden:", f":caption: {caption}", "", *there, "```", ""]
            content[0] += "\n".join(lines)


def add_index(app: Sphinx, error: Exception | None) -> None:
    """Make the README the page that a folder shows."""
    if error is None and app.builder.format == "html":
        shutil.copyfile(Path(app.outdir) / f"{root_doc}.html", Path(app.outdir) / "index.html")


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect what stands above."""
    app.add_source_parser(Notebook)
    app.add_config_value("order", {}, "env", dict)
    app.connect("autodoc-process-docstring", read_docstring)
    app.connect("source-read", add_order)
    app.connect("build-finished", add_index)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
