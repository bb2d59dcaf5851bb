"""A language model is asked once: its answers and costs are recorded, and replayed without its key and the network."""

import json
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import sunset

pytestmark = pytest.mark.usefixtures("flight")

GALLERY = Path(__file__).parents[2] / "examples" / "gallery"
KEY = "sk-7c3e90"
SCENARIO = "gpu_failure"


SERVICE = f"""
import json, sys
from http.server import BaseHTTPRequestHandler, HTTPServer

class Service(BaseHTTPRequestHandler):
    def do_POST(self):
        question = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(200 if self.headers["Authorization"] == "Bearer {KEY}" else 401)
        self.end_headers()
        (message,) = question["messages"]
        lines = message["content"].splitlines()
        redeploy = next(line for line in lines if "redeploy segmentation" in line)
        document = {{
            "model": question["model"],
            "choices": [{{"message": {{"content": redeploy.partition(" (")[0]}}}}],
            "usage": {{"prompt_tokens": len(lines), "completion_tokens": 3}},
        }}
        self.wfile.write(json.dumps(document).encode())

HTTPServer(("localhost", int(sys.argv[1])), Service).serve_forever()
"""
"""A service that answers as services of language models do, to those who have the key."""


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port: int = probe.getsockname()[1]
        return port


def wait_until_open(port: int) -> None:
    for _ in range(600):
        with socket.socket() as probe:
            if probe.connect_ex(("localhost", port)) == 0:
                return
        time.sleep(0.05)  # noqa: TID251  another process starts
    pytest.fail("The recorder has not started within 30 s.")


@contextmanager
def recorder(answers: Path) -> Iterator[int]:
    """Start a service and a recorder in front of it; give the recorder's port."""
    ports = free_port(), free_port()
    address = f"http://localhost:{ports[0]}/chat/completions"
    service = [sys.executable, "-c", SERVICE, str(ports[0])]
    between = [
        sys.executable,
        str(GALLERY / "recorder.py"),
        str(answers),
        str(ports[1]),
        address,
        "tiny",
        "2",
        "10",
    ]
    with (
        subprocess.Popen(service, stderr=subprocess.DEVNULL) as first,
        subprocess.Popen(between, stderr=subprocess.DEVNULL) as second,
    ):
        try:
            for port in ports:
                wait_until_open(port)
            yield ports[1]
        finally:
            first.kill()
            second.kill()


@pytest.mark.parametrize("written_as", ["class", "program"])
def test_a_replay_without_key_and_network_is_the_run(
    written_as: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded, answers = tmp_path / "recorded.jsonl", tmp_path / "answers.jsonl"
    answers.touch()
    for file in ("language_model.py", "language_model_program.py"):
        shutil.copy(GALLERY / file, tmp_path)
    program = f"exec:{sys.executable} {tmp_path}/language_model_program.py"
    of_class = f"{tmp_path}/language_model.py:LanguageModel"
    monkeypatch.setenv("LANGUAGE_MODEL_KEY", KEY)
    with recorder(recorded) as port:
        address = f"http://localhost:{port}"
        monkeypatch.setenv("LANGUAGE_MODEL_URL", address)
        asked = sunset.run(
            SCENARIO,
            of_class if written_as == "class" else f"{program} {address}",
            manager_env=("LANGUAGE_MODEL_KEY", "LANGUAGE_MODEL_URL"),
            duration=4,
            out=tmp_path / "asked",
        )
    monkeypatch.delenv("LANGUAGE_MODEL_KEY")
    shutil.copy(recorded, answers)
    again = of_class if written_as == "class" else f"{program} {answers}"
    replayed = sunset.run(SCENARIO, again, duration=4, out=tmp_path / "replayed")

    assert asked.record.manager_failed is None
    assert replayed.digest == asked.digest
    (answer,) = map(json.loads, answers.read_text(encoding="utf-8").splitlines())
    for run in (asked, replayed):
        assert run.record.models_asked == ("tiny",)
        assert (run.metrics.tokens_in, run.metrics.tokens_out) == (answer["tokens_in"], 3)
        assert run.metrics.price == pytest.approx((2 * answer["tokens_in"] + 10 * 3) / 1e6)
        assert run.metrics.think_s == answer["seconds"]
    report = sunset.report(tmp_path / "replayed")
    assert f"{answer['tokens_in']} tokens in, 3 out, of tiny" in report
    holding = [file for file in tmp_path.rglob("*") if file.is_file() and KEY.encode() in file.read_bytes()]
    assert holding == []
