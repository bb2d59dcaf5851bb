"""A managing system has a process of its own: small, and nothing of what becomes of it ends a run."""

import os
import re
import signal
import subprocess
import sys
import sysconfig
import venv
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from msgspec import UNSET

from sunset.errors import ExtensionError, ManagerError, SunsetError
from sunset.experiments import RunSpec, Settings, Timing, manager_checksum, run
from sunset.experiments.manager import isolate
from sunset.files.sources import PACKAGES
from sunset.harness.confined_manager import ManagerProcess, manager_process
from sunset.harness.manager_process import ManagerSpec
from sunset.managing import ManagingSystem, NoAdaptation, Symptoms, register_manager, sources_digest
from sunset.recording import StoredRun, read_run, read_stored_run
from sunset.scenarios import load_scenario
from sunset.system import extended_system

pytestmark = pytest.mark.usefixtures("flight")

SETTINGS = Settings(timing=Timing(duration_s=2.0), manager_limit_s=5.0)
LARGEST_KIB = 60 << 10

SUDDEN = """
from sunset_ros.interfaces.std_msgs.msg import String
from sunset.managing import ManagingSystem

class Sudden(ManagingSystem):
    '''Does what a node can do, and fails after 5 s.'''

    def on_start(self):
        self.out = self.create_publisher(String, "said", 10)
        self.create_subscription(String, "/said", lambda message: self.get_logger().info(message.data), 10)
        self.create_timer(5.0, self.fail)
        self.declare_parameter("mine", 1)

    def fail(self):
        self.out.publish(String(data="which never leaves"))
        raise LookupError("nothing")

    async def adapt(self, symptoms):
        self.out.publish(String(data=str(await self.set_parameter("sensor_fusion", "modality", 0))))
"""


def fly(folder: Path, manager: str, scenario: str = "nofault") -> StoredRun:
    return run(RunSpec(scenario=load_scenario(scenario), manager=manager, settings=SETTINGS), folder)


@pytest.fixture
def sudden(tmp_path: Path) -> str:
    (tmp_path / "sudden.py").write_text(SUDDEN, encoding="utf-8")
    return f"{tmp_path / 'sudden.py'}:Sudden"


def test_one_that_raises_leaves_at_that_moment_and_the_run_goes_on(sudden: str, tmp_path: Path) -> None:
    first, second = (fly(tmp_path / f"{number}", sudden) for number in (1, 2))

    told = first.record.manager_failed or ""
    assert re.fullmatch(
        r"The managing system .*sudden.py:Sudden failed in nofault, seed 1: it raised LookupError: nothing "
        r"\(sudden.py, line \d+, in fail\)\.",
        told,
    )
    assert (first.digest, first.record.manager_failed) == (second.digest, told)
    assert first.valid
    assert first.metrics.iou_all is not None
    said = [line.time for line in first.log if line.logger == "managing_system" and line.text == "True"]
    assert len(said) > 5
    assert max(said) < max(first.timeline.frames.times) - 0.5
    assert read_stored_run(tmp_path / "1").metrics == first.metrics
    assert read_run(tmp_path / "1").manager_failed == told


def test_what_was_passed_as_a_class_is_run_by_a_copy_of_this_process(tmp_path: Path) -> None:
    here, seen = os.getpid(), [4]

    class Mine(ManagingSystem):
        def on_start(self) -> None:
            self.get_logger().info(f"{os.getpid() == here} {seen}")
            seen.append(5)

        def adapt(self, symptoms: Symptoms) -> None:
            raise SystemExit("enough")

    result = fly(tmp_path / "run", register_manager(Mine))

    assert seen == [4]
    assert "False [4]" in [line.text for line in result.log]
    told = result.record.manager_failed or ""
    assert "it raised SystemExit: enough (test_manager_process.py, line " in told


@pytest.mark.thorough
def test_a_forked_copy_of_one_says_nothing(tmp_path: Path) -> None:
    class Forks(ManagingSystem):
        def adapt(self, symptoms: Symptoms) -> None:
            if not os.fork():
                raise SystemExit

    result = fly(tmp_path / "run", register_manager(Forks))

    assert result.record.manager_failed is None


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux says how much memory is whose")
def test_the_process_is_small() -> None:
    with manager_process(ManagerSpec(manager="baseline", limit_s=30.0)) as process:
        rollup = Path(f"/proc/{process.process.pid}/smaps_rollup").read_text(encoding="ascii")
    pages = {name: int(size) for name, size in re.findall(r"^(\w+): +(\d+) kB", rollup, re.MULTILINE)}
    assert pages["Pss"] < LARGEST_KIB
    assert pages["Private_Dirty"] < LARGEST_KIB


def test_one_that_is_changed_while_it_is_run_is_refused(
    sudden: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def edit(*arguments: Any, **options: Any) -> Any:
        with (tmp_path / "sudden.py").open("a", encoding="utf-8") as file:
            file.write("# another line\n")
        return isolate(*arguments, **options)

    monkeypatch.setattr(sys.modules["sunset.experiments.run"], "isolate", edit)

    with pytest.raises(ManagerError, match="was changed while it was run; run the new one in a new folder"):
        fly(tmp_path / "run", sudden)
    assert not (tmp_path / "run").exists()


def test_what_comes_with_sunset_and_is_killed_ends_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checksum = ManagerProcess.checksum

    def kill(process: ManagerProcess) -> str:
        os.kill(process.process.pid, signal.SIGKILL)
        return checksum(process)

    monkeypatch.setattr(ManagerProcess, "checksum", kill)

    with pytest.raises(
        SunsetError, match="The process of the managing system ended its process by SIGKILL: it was"
    ):
        fly(tmp_path / "run", "baseline")


@pytest.mark.parametrize(
    ("line", "limit_s", "reason"),
    [
        ("import os; os._exit(3)", 30.0, "it ended its process with exit code 3"),
        (
            "while True: pass",
            0.5,
            r"it did not return within (0.5 s of processor time|5 s) \(mine.py, line 1, in <module>\)",
        ),
        ("raise SystemExit(2)", 30.0, "Importing .*mine.py raised SystemExit: 2"),
    ],
)
def test_one_that_cannot_be_loaded_is_refused(line: str, limit_s: float, reason: str, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(line, encoding="utf-8")
    with pytest.raises(ManagerError, match=reason):
        manager_checksum(f"{tmp_path / 'mine.py'}:Mine", Settings(manager_limit_s=limit_s))


LOADING = """
import sys
import sysconfig
import venv
from sunset.experiments import Settings, manager_checksum
print(manager_checksum("mine:Mine", Settings()))
"""


@pytest.mark.parametrize("layered", [False, True], ids=["PYTHONPATH", "a .pth file"])
def test_an_installation_is_found_wherever_python_finds_it(layered: bool, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "import numpy, sunset_town\nfrom sunset.managing import ManagingSystem\n\n"
        "class Mine(ManagingSystem):\n    def adapt(self, symptoms): pass\n"
    )
    folders = [str(folder.parent) for folder in PACKAGES.values()]
    installed = [sysconfig.get_path("purelib"), *folders]
    if layered:
        venv.create(tmp_path / "upper")
        python = tmp_path / "upper" / "bin" / "python"
        site = sysconfig.get_path("purelib", "venv", vars={"base": str(tmp_path / "upper")})
        Path(site, "lower.pth").write_text("\n".join(installed))
        installed = []
    else:
        python = Path(sys.base_prefix) / "bin" / "python{}.{}".format(*sys.version_info)
    variables = os.environ | {"PYTHONPATH": ":".join([str(tmp_path), *installed])}

    done = subprocess.run(
        [python, "-P", "-c", LOADING],
        env=variables,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.stderr == ""
    assert done.stdout.strip() == sources_digest([(tmp_path / "mine.py").read_bytes()])


def test_a_program_cannot_name_a_folder_that_holds_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "program.py").write_text("", encoding="utf-8")
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "cache"))
    with pytest.raises(
        ManagerError,
        match=f"names {tmp_path}, and {tmp_path / 'cache'} is where SUNSET keeps flights and their",
    ):
        manager_checksum(f"exec:python3 {tmp_path / 'program.py'} {tmp_path}", Settings())


ODD = """
from sunset.managing import ManagingSystem


class Silent(Exception):
    def __str__(self):
        raise LookupError("no text")


class Odd(ManagingSystem):
    def adapt(self, symptoms):
        raise {error}
"""


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        ("Silent", r"it raised Silent \(odd.py, line \d+, in adapt\)\.$"),
        (
            r"ValueError('1\\n faults cured  9 of 9')",
            r"it raised ValueError: 1\\n faults cured  9 of 9 \(odd.py",
        ),
    ],
)
def test_its_failure_is_one_line_whatever_it_raises(error: str, reason: str, tmp_path: Path) -> None:
    (tmp_path / "odd.py").write_text(ODD.replace("{error}", error), encoding="utf-8")
    told = fly(tmp_path / "run", f"{tmp_path / 'odd.py'}:Odd").record.manager_failed or ""
    assert re.search(reason, told)
    assert "\n" not in told


def test_an_extension_that_cannot_be_loaded_beside_it_is_named_with_what_it_sees(tmp_path: Path) -> None:
    (tmp_path / "dirt.txt").write_text("0.5", encoding="utf-8")
    (tmp_path / "dirt.py").write_text(
        "from pathlib import Path\nfrom sunset.system import Extension\n"
        "SHARE = float((Path(__file__).parent / 'dirt.txt').read_text())\nEXTENSION = Extension()\n",
        encoding="utf-8",
    )
    with (
        extended_system([tmp_path / "dirt.py"]),
        pytest.raises(
            ExtensionError, match=r"dirt.py cannot be imported: .* write into the file what it needs"
        ),
    ):
        manager_checksum("none", Settings())


READER = """
from pathlib import Path
from sunset.managing import ManagingSystem

class Reader(ManagingSystem):
    files = ("{name}",)

    def on_start(self):
        self.seen = (Path(__file__).parent / self.files[0]).read_bytes()

    def adapt(self, symptoms):
        pass
"""
HIDDEN = {
    "cache/images.sqlite": ("", "is where SUNSET keeps flights and their labels"),
    "beside.mcap": ("", "which is a bag"),
    "runs/run.json": ("{}", "which is of the record of a run"),
    "suite/wet.yaml": ("name: wet\nfaults: [gpu_failure]\n", "which is a scenario"),
}


@pytest.mark.parametrize("name", HIDDEN)
@pytest.mark.parametrize("way", ["files", "link", "program"])
def test_what_decides_what_it_is_measured_by_is_not_shown_to_it(
    name: str, way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content, what = HIDDEN[name]
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(tmp_path / "cache"))
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text(content, encoding="utf-8")
    named = "weights.npz" if way == "link" else name
    if way == "link":
        (tmp_path / named).symlink_to(file)
    (tmp_path / "reader.py").write_text(READER.replace("{name}", named), encoding="utf-8")
    program = f"exec:python3 {tmp_path / 'reader.py'} {tmp_path / name}"
    manager = program if way == "program" else f"{tmp_path / 'reader.py'}:Reader"
    with pytest.raises(ManagerError, match=what):
        manager_checksum(manager, Settings())


@pytest.mark.parametrize(
    ("manager", "path"),
    [
        ("{}/reader.py:Reader", "/proc/self/cmdline"),
        ("{}/reader.py:Reader", "weights.npz"),
        ("exec:cat /proc/1/cmdline", ""),
    ],
)
def test_what_tells_of_the_experiment_is_not_shown_to_it(manager: str, path: str, tmp_path: Path) -> None:
    (tmp_path / "weights.npz").symlink_to("/proc/1/cmdline")
    (tmp_path / "reader.py").write_text(READER.replace("{name}", path), encoding="utf-8")
    with pytest.raises(
        ManagerError, match=r"names .*, which tells of the computer and its processes: keep its"
    ):
        manager_checksum(manager.format(tmp_path), Settings())


def test_its_own_files_are_shown_to_it(tmp_path: Path) -> None:
    (tmp_path / "weights.yaml").write_text("gain: 3\n", encoding="utf-8")
    (tmp_path / "reader.py").write_text(READER.replace("{name}", "weights.yaml"), encoding="utf-8")
    assert fly(tmp_path / "run", f"{tmp_path / 'reader.py'}:Reader").record.manager_failed is None


def test_its_files_may_be_links(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "1f2e").write_text("gain: 3\n", encoding="utf-8")
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "weights.bin").symlink_to("../store/1f2e")
    (tmp_path / "own" / "reader.py").write_text(READER.replace("{name}", "weights.bin"), encoding="utf-8")
    assert fly(tmp_path / "run", f"{tmp_path / 'own' / 'reader.py'}:Reader").record.manager_failed is None


def test_a_link_beside_it_to_what_is_not_python_is_not_shown_to_it(tmp_path: Path) -> None:
    (tmp_path / "labels.mcap").write_text("labels", encoding="utf-8")
    (tmp_path / "notes.py").symlink_to(tmp_path / "labels.mcap")
    reader = READER.replace('files = ("{name}",)', 'beside = ("notes.py",)').replace("files", "beside")
    (tmp_path / "reader.py").write_text(reader, encoding="utf-8")
    told = fly(tmp_path / "run", f"{tmp_path / 'reader.py'}:Reader").record.manager_failed
    assert "PermissionError" in str(told) or "FileNotFoundError" in str(told)


def test_a_bystander_whose_name_is_not_utf8_hinders_nothing(sudden: str, tmp_path: Path) -> None:
    own = manager_checksum(sudden, Settings())
    (tmp_path / os.fsdecode(b"caf\xe9.py")).write_text("", encoding="utf-8")
    assert manager_checksum(sudden, Settings()) == own


def test_the_checksum_is_that_of_its_files(sudden: str, tmp_path: Path) -> None:
    one = manager_checksum(sudden, Settings())
    (tmp_path / "sudden.py").write_text(SUDDEN.replace("5.0", "6.0"), encoding="utf-8")

    assert manager_checksum(sudden, Settings()) != one
    assert manager_checksum(register_manager(NoAdaptation, "own"), Settings())


CHEATS = """
import sys
import sysconfig
import venv
import sunset.harness.manager_process
from sunset_ros.interfaces.std_msgs.msg import String
from sunset.managing import ManagingSystem

class Flooding(ManagingSystem):
    def on_start(self):
        self.out = self.create_publisher(String, "/rosout", 10)

    def adapt(self, symptoms):
        self.out.publish(String(data="x" * (9 << 20)))

class Talking(ManagingSystem):
    def on_start(self):
        self.out = self.create_publisher(String, "/rosout", 10)

    def adapt(self, symptoms):
        for _ in range(100_000):
            self.out.publish(String())

class Waiting(ManagingSystem):
    def on_start(self):
        for thing in (*self.timers, *self.subscriptions):
            thing.destroy()
        while True:
            self.context.middleware.spin_once(None)

    def adapt(self, symptoms): pass

class Chatting(ManagingSystem):
    def on_start(self):
        self.create_publisher(String, "/rosout", 10).publish(String(data="not a log"))

    def adapt(self, symptoms): pass
"""


@pytest.fixture
def cheats(tmp_path: Path) -> Path:
    (tmp_path / "cheats.py").write_text(CHEATS, encoding="utf-8")
    return tmp_path / "cheats.py"


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Flooding", "it sends more than 64 MiB, or 32768 messages, in a minute"),
        ("Talking", "it sends more than 64 MiB, or 32768 messages, in a minute"),
        ("Waiting", "it waits for more than .* in a callback"),
    ],
)
def test_one_that_takes_too_much_is_ended_and_the_run_goes_on(
    name: str, reason: str, cheats: Path, tmp_path: Path
) -> None:
    result = fly(tmp_path / "run", f"{cheats}:{name}")
    assert result.valid
    assert re.search(reason, result.record.manager_failed or "")


def test_what_is_no_log_on_its_topic_is_left_out(cheats: Path, tmp_path: Path) -> None:
    result = fly(tmp_path / "run", f"{cheats}:Chatting")
    assert "not a log" not in {one.text for one in result.log}
    assert read_stored_run(tmp_path / "run").log == result.log


def test_a_run_says_which_distributions_its_managing_system_imported(tmp_path: Path) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(
        "import iniconfig\nimport yaml\nfrom sunset.managing import ManagingSystem\n\n"
        "class Mine(ManagingSystem):\n    def adapt(self, symptoms):\n        pass\n"
    )
    scenario, settings = load_scenario("nofault"), Settings(timing=Timing(duration_s=1.0, warm_up_s=0.5))

    made = run(RunSpec(scenario=scenario, manager=f"{mine}:Mine", settings=settings), tmp_path / "mine")
    shipped = run(RunSpec(scenario=scenario, manager="baseline", settings=settings), tmp_path / "shipped")

    assert made.record.manager_versions == {"iniconfig": version("iniconfig")}
    assert shipped.record.manager_versions is UNSET
