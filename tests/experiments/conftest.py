import subprocess
from pathlib import Path

import pytest
from tests.experiments.campaigns import bench_command


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, flight: Path) -> Path:
    """A campaign that nothing has happened to."""
    del flight
    folder = tmp_path_factory.mktemp("bench")
    subprocess.run(bench_command(folder, "--jobs", "2"), check=True, capture_output=True)
    return folder
