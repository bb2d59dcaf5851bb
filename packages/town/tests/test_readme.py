import contextlib
import io
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("towns")  # each is built once


def test_the_example_of_the_readme_renders_frames() -> None:
    text = (Path(__file__).parents[1] / "README.md").read_text("utf-8")
    (source,) = re.findall(r"^```python\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(source, {})  # noqa: S102  the example is ours
    assert re.fullmatch(
        r"\(144, 256, 3\) uint16 100 poses\n[3-6]\d m to the nearest point, 0 pixels of sky\n",
        output.getvalue(),
    )
