"""Models that other distributions install: found by their entry points, and never executed."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.errors import ModelError
from sunset.perception import OFFERED, Model, is_installed, list_models, load_model

Install = Callable[..., Path]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Install a distribution that offers a model `heavy`, as an installer leaves it; return its package's folder."""

    def make(distribution: str = "some-model", value: str = "some_model") -> Path:
        site = tmp_path / distribution
        metadata = site / f"{distribution}-1.0.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text(f"Name: {distribution}\nVersion: 1.0\n", encoding="utf-8")
        (metadata / "entry_points.txt").write_text(f"[sunset.models]\nheavy = {value}\n", encoding="utf-8")
        monkeypatch.syspath_prepend(site)
        return site / "some_model"

    return make


def test_a_model_of_another_distribution_is_listed_and_loads_by_name(install: Install, lite: Model) -> None:
    folder = install()
    shutil.copytree(lite.folder, folder)

    assert {"heavy", "lite"} <= set(list_models())
    assert load_model("heavy").folder == folder
    assert load_model("heavy").card == lite.card


def test_no_code_of_the_distribution_is_executed(install: Install, lite: Model) -> None:
    folder = install()
    shutil.copytree(lite.folder, folder)
    (folder / "__init__.py").write_text("raise SystemExit('executed')\n", encoding="utf-8")

    assert load_model("heavy").folder == folder


def test_what_is_installed_is_told_from_a_copy(install: Install, lite: Model, tmp_path: Path) -> None:
    folder = install()
    shutil.copytree(lite.folder, folder)

    assert is_installed(folder)
    assert is_installed(lite.folder)
    assert not is_installed(tmp_path)


@pytest.mark.parametrize(
    "value", ["absent", "some_model", "some_model.weights", "some_model:weights", "some model"]
)
def test_a_broken_entry_point_is_said_in_a_sentence(value: str, install: Install) -> None:
    folder = install(value=value)
    folder.mkdir()
    (folder / "__init__.py").write_text("raise SystemExit('executed')\n", encoding="utf-8")

    with pytest.raises(
        ModelError, match=rf"'heavy' of .* 'some-model' is broken: .* package '{re.escape(value)}'"
    ):
        load_model("heavy")


def test_a_broken_one_does_not_hide_the_others(install: Install, capfd: pytest.CaptureFixture[str]) -> None:
    install()

    assert main(["models", "list"]) == 2

    out, err = capfd.readouterr()
    assert re.search(r"^lite +256x144", out, re.MULTILINE)
    assert "'heavy' of the installed distribution 'some-model' is broken" in err.splitlines()[-1]


@pytest.mark.skipif("reference" in list_models(), reason="sunset-model-reference is installed")
def test_a_model_that_could_be_installed_is_listed_and_says_how(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(
        ModelError, match=r"'reference' is not installed: .* run 'pip install \./models/reference'\."
    ):
        load_model("reference")

    assert main(["models", "list"]) == 0
    assert "reference is not installed; in a clone" in capsys.readouterr().out.splitlines()[-1]
    assert main(["models", "list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["not_installed"] == dict(OFFERED)


def test_the_repository_has_what_is_offered() -> None:
    root = Path(__file__).parents[2]
    for name, command in OFFERED.items():
        folder = root / command.removeprefix("pip install ")
        assert f'"sunset-model-{name}"' in (folder / "pyproject.toml").read_text(encoding="utf-8")
