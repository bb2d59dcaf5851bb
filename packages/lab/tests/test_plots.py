import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sunset.calibration import plan_curves
from sunset.errors import OutputError
from sunset.perception import Modality, load_model
from sunset_lab.curves import Curves, curves_of
from sunset_lab.curves_text import draw

pytest.importorskip("matplotlib")

pytestmark = pytest.mark.thorough


def curves(*modalities: Modality) -> Curves:
    card = load_model("lite").card
    card = replace(card, networks={modality: card.networks[modality] for modality in modalities})
    plan = plan_curves(card)
    values = np.random.default_rng(3).uniform(0.1, 0.9, (8, len(plan.conditions()), 3))
    return curves_of(plan, card, values)


def test_the_same_curves_are_drawn_with_the_same_bytes(tmp_path: Path) -> None:
    found = curves(*Modality)
    first = {path.name: path.read_bytes() for path in draw(found, tmp_path)}
    assert set(first) == {"curves.png", "cures.png"}
    assert all(content.startswith(b"\x89PNG") for content in first.values())
    assert {path.name for path in tmp_path.iterdir()} == set(first)
    assert {path.name: path.read_bytes() for path in draw(found, tmp_path)} == first


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"The figure .*nowhere/curves.png cannot be written"):
        draw(curves(*Modality), tmp_path / "nowhere")


def test_without_matplotlib_the_extra_is_named() -> None:
    program = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from pathlib import Path\n"
        "from sunset_lab.curves_text import draw\n"
        "draw(None, Path('.'))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "MissingExtraError: The figures were left out because matplotlib is not installed" in done.stderr
