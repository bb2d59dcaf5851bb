"""What a shell completes a command line with, asked of bash itself."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sunset.cli import main

pytest.importorskip("shtab")

ASK = """\
source completion.bash
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}
_shtab_sunset sunset "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def script(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Path:
    assert main(["completion", "bash"]) == 0
    (tmp_path / "completion.bash").write_text(capsys.readouterr().out, encoding="utf-8")
    (tmp_path / "results").mkdir()
    return tmp_path


@pytest.mark.skipif(shutil.which("bash") is None, reason="asks bash")
def test_bash_completes_verbs_actions_options_names_and_files(script: Path) -> None:
    def completed(*words: str) -> set[str]:
        command = ["bash", "-c", ASK, "bash", "sunset", *words]
        done = subprocess.run(command, cwd=script, capture_output=True, text=True, check=True)
        return set(done.stdout.split())

    assert completed("re") == {"report"}
    assert completed("faults", "") == {"list", "show", "figure"}
    assert completed("run", "--mid") == {"--middleware"}
    assert completed("run", "--middleware", "") == {"sim", "cyclonedds"}
    assert completed("run", "--manager", "b") == {"baseline"}
    assert completed("run", "sync") == {"sync_issue"}
    assert completed("models", "show", "l") == {"lite"}
    assert completed("bench", "--suite", "pa") == {"paper"}
    assert completed("report", "re") == {"results"}


@pytest.mark.skipif(shutil.which("bash") is None, reason="asks bash")
def test_where_no_name_fits_bash_completes_files(script: Path) -> None:
    command = ["bash", "-c", "source completion.bash; complete -p sunset"]
    told = subprocess.run(command, cwd=script, capture_output=True, text=True, check=True)
    assert "-o default" in told.stdout


@pytest.mark.parametrize("shell", ["zsh", "fish", "tcsh"])
def test_other_shells_have_a_script_too(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0

    assert "sunset" in capsys.readouterr().out
