"""A small campaign with a managing system of its own, packed; and what others may do to it."""

import hashlib
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from sunset.api.bundling import bundle
from sunset.experiments import BenchSpec, Settings, Timing, bench

DATE = "2026-03-14"
SETTINGS = Settings(timing=Timing(duration_s=2.0, warm_up_s=0.5))

HELPER = "GREETING = 'here'\n"
IMPORTED = "mine was imported"
"""What the managing system prints when its file is run, which is shown on stderr."""
MINE = f"""
import helper
from sunset.managing import ManagingSystem

print("{IMPORTED}")


class Mine(ManagingSystem):
    def adapt(self, symptoms):
        self.get_logger().info(helper.GREETING, once=True)
"""

Forge = Callable[..., Path]


def campaign(folder: Path, *, seed: int = 1) -> Path:
    """Run a campaign over a folder of scenarios, with `none` and a managing system of two files; return its folder."""
    (folder / "rain").mkdir()
    (folder / "rain/wet.yaml").write_text("name: wet\nfaults: [gpu_failure]\n")
    (folder / "helper.py").write_text(HELPER)
    (folder / "mine.py").write_text(MINE)
    spec = BenchSpec(
        suite=str(folder / "rain"),
        managers=("none", f"mine={folder / 'mine.py'}:Mine"),
        references=False,
        score=False,
        repetitions=2,
        seed=seed,
        settings=SETTINGS,
    )
    bench(spec, folder / "results", jobs=1)
    return folder / "results"


@pytest.fixture(scope="session")
def results(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert flight.exists()
    return campaign(tmp_path_factory.mktemp("bundling"))


@pytest.fixture(scope="session")
def packed(results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("packed") / "results.zip"
    bundle(results, out, date=DATE)
    return out


@pytest.fixture
def forge(tmp_path: Path) -> Forge:
    """Return what does something to the files of a bundle, and packs them again."""

    def call(packed: Path, edit: Callable[[Path], object], *, sums: bool = True) -> Path:
        """Edit a bundle's files; with `sums` the list of checksums fits them afterwards."""
        folder, out = tmp_path / "opened", tmp_path / "forged.zip"
        with zipfile.ZipFile(packed) as archive:
            archive.extractall(folder)
        edit(folder)
        names = sorted(file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file())
        if sums:
            lines = (
                f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n"
                for name in names
                if name != "SHA256SUMS"
            )
            (folder / "SHA256SUMS").write_text("".join(lines))
        with zipfile.ZipFile(out, "w") as archive:
            for name in names:
                archive.write(folder / name, name)
        return out

    return call
