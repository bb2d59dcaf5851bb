"""Whoever computes with SUNSET is not reported to anybody."""

import os
import subprocess
import sys
from pathlib import Path

SEGMENT = """
import numpy as np
from sunset.perception import Modality, Segmenter, load_model
model = load_model("lite")
depth = np.ones((model.card.height, model.card.width), np.uint16)
Segmenter(model).segment(Modality.DEPTH, None, depth)
"""


def test_inference_leaves_no_identifier_on_this_computer(tmp_path: Path) -> None:
    environment = {"PATH": os.environ["PATH"], "HOME": str(tmp_path)}  # none of CI's, which silence it too
    subprocess.run([sys.executable, "-c", SEGMENT], check=True, env=environment)
    assert list(tmp_path.rglob("*")) == []
