"""Chromium and Firefox, without a screen, driven over their own protocols: no driver and no library is needed."""

import base64
import fcntl
import json
import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic
from typing import Any, Protocol

WAIT_S = 60.0
"""How long a browser may take to answer; only what hangs takes so long."""


class Browser(Protocol):
    """A page in a browser."""

    def open(self, url: str) -> None:
        """Open a page, and wait until it is loaded."""

    def evaluate(self, script: str) -> Any:
        """Return what the body of an asynchronous function returns in the page."""

    def resize(self, width: int, height: int) -> None:
        """Make the window another size."""

    def screenshot(self) -> bytes:
        """Return a picture of the window as a PNG file."""

    def complaints(self) -> list[str]:
        """Return what was written to the console as an error or a warning, and what was not caught."""

    def requests(self) -> list[str]:
        """Return the addresses that were asked for, but the page's own."""


PROGRAMS = {
    "chromium": ("chromium", "chromium-browser", "google-chrome"),
    "firefox": ("firefox", "firefox-esr"),
}


def program_of(name: str) -> str | None:
    """Return the path of a browser's program; None where it is not installed."""
    return next(filter(None, map(shutil.which, PROGRAMS[name])), None)


@contextmanager
def started(name: str) -> Iterator[Browser]:
    """Start a browser, and end it."""
    program = program_of(name)
    assert program is not None
    with tempfile.TemporaryDirectory(prefix="sunset-browser-", ignore_cleanup_errors=True) as profile:
        browser = (Chromium if name == "chromium" else Firefox)(program, Path(profile))
        try:
            yield browser
        finally:
            browser.close()


class Chromium:
    """Chromium, over the DevTools protocol on two pipes."""

    def __init__(self, program: str, profile: Path) -> None:
        ends = [*os.pipe(), *os.pipe()]
        # above 4, so that none is overwritten before it is copied
        theirs, self._out, self._in, answers = (fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends)
        for end in ends:
            os.close(end)

        def pass_pipes() -> None:
            os.dup2(theirs, 3)
            os.dup2(answers, 4)

        command = [
            program,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--hide-scrollbars",
            "--remote-debugging-pipe",
            f"--user-data-dir={profile}",
            "about:blank",
        ]
        self._process = subprocess.Popen(
            command,
            preexec_fn=pass_pipes,  # noqa: PLW1509  nothing else runs here meanwhile
            pass_fds=(3, 4),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs)
        os.close(answers)
        self._buffer = b""
        self._number = 0
        self._events: list[dict[str, Any]] = []
        self._session = ""
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self._call(f"{domain}.enable")
        self._page = ""

    def _call(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        result: dict[str, Any] = self._until(lambda answer: answer.get("id") == self._number)["result"]
        return result

    def _until(self, is_wanted: Any) -> Any:
        until = monotonic() + WAIT_S
        while monotonic() < until:
            text, separator, rest = self._buffer.partition(b"\0")
            if not separator:
                read = os.read(self._in, 1 << 20)
                assert read, "Chromium has ended."
                self._buffer += read
                continue
            self._buffer = rest
            message = json.loads(text)
            assert "error" not in message, message
            if is_wanted(message):
                return message
            self._events.append(message)
        raise TimeoutError

    def open(self, url: str) -> None:
        self._page = url
        self._call("Page.navigate", url=url)
        self._until(lambda message: message.get("method") == "Page.loadEventFired")

    def evaluate(self, script: str) -> Any:
        expression = f"(async () => {{ {script} }})()"
        answer = self._call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def resize(self, width: int, height: int) -> None:
        self._call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def emulate_dark(self, *, dark: bool) -> None:
        """Prefer dark pages, or light ones."""
        value = "dark" if dark else "light"
        self._call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": value}])

    def screenshot(self) -> bytes:
        return base64.b64decode(self._call("Page.captureScreenshot")["data"])

    def complaints(self) -> list[str]:
        self.evaluate("await new Promise(requestAnimationFrame)")
        kinds = {"Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"}
        found = [json.dumps(event) for event in self._events if event.get("method") in kinds]
        return [
            text for text in found if "getImageData" not in text
        ]  # that only tests read pixels is no fault

    def requests(self) -> list[str]:
        asked = [
            event["params"]["request"]["url"]
            for event in self._events
            if event.get("method") == "Network.requestWillBeSent"
        ]
        return [url for url in asked if url.partition("#")[0] != self._page.partition("#")[0]]

    def close(self) -> None:
        self._process.terminate()
        self._process.wait(WAIT_S)
        os.close(self._out)
        os.close(self._in)


class Firefox:
    """Firefox, over Marionette."""

    def __init__(self, program: str, profile: Path) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        preferences = {
            "marionette.port": port,
            "datareporting.policy.dataSubmissionEnabled": False,
            "app.update.enabled": False,
            "browser.shell.checkDefaultBrowser": False,
            "toolkit.telemetry.enabled": False,
            "network.captive-portal-service.enabled": False,
            "network.connectivity-service.enabled": False,
            "services.settings.server": "data:,",
            "extensions.systemAddon.update.enabled": False,
        }
        lines = [
            f"user_pref({json.dumps(key)}, {json.dumps(value)});\n" for key, value in preferences.items()
        ]
        (profile / "user.js").write_text("".join(lines), encoding="utf-8")
        self._process = subprocess.Popen(
            [
                program,
                "--headless",
                "--marionette",
                "--remote-allow-system-access",
                "--no-remote",
                "--profile",
                str(profile),
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "HOME": str(profile)},
        )
        self._socket = self._connected(port)
        self._file = self._socket.makefile("rb")
        self._number = 0
        self._answer()  # it says who it is
        self._call("WebDriver:NewSession", capabilities={})

    def _connected(self, port: int) -> socket.socket:
        until = monotonic() + WAIT_S
        while monotonic() < until:
            assert self._process.poll() is None, "Firefox has ended."
            with suppress(ConnectionRefusedError):
                return socket.create_connection(("127.0.0.1", port), WAIT_S)
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(0.1)
        raise TimeoutError

    def _answer(self) -> Any:
        digits = b""
        while (digit := self._file.read(1)) != b":":
            assert digit, "Firefox has ended."
            digits += digit
        return json.loads(self._file.read(int(digits)))

    def _call(self, command: str, **parameters: Any) -> Any:
        self._number += 1
        text = json.dumps([0, self._number, command, parameters])
        self._socket.sendall(f"{len(text.encode())}:{text}".encode())
        _, _, error, result = self._answer()
        assert error is None, error
        return result

    def open(self, url: str) -> None:
        self._call("WebDriver:Navigate", url=url)

    def evaluate(self, script: str) -> Any:
        wrapped = (
            "const done = arguments[arguments.length - 1];"
            f"(async () => {{ {script} }})()"
            ".then(value => done([value ?? null]), error => done([null, String(error)]));"
        )
        answer = self._call("WebDriver:ExecuteAsyncScript", script=wrapped, args=[], sandbox=None)
        value, *error = answer["value"]
        assert not error, error
        return value

    def resize(self, width: int, height: int) -> None:
        self._call("WebDriver:SetWindowRect", width=width, height=height)

    def screenshot(self) -> bytes:
        return base64.b64decode(self._call("WebDriver:TakeScreenshot", full=False)["value"])

    def complaints(self) -> list[str]:
        self._call("Marionette:SetContext", value="chrome")
        script = (
            "return Services.console.getMessageArray()"
            ".filter(one => one instanceof Ci.nsIScriptError && one.sourceName.startsWith('file:'))"
            ".map(one => `${one.sourceName}: ${one.errorMessage}`)"
        )
        found: list[str] = self._call("WebDriver:ExecuteScript", script=script, args=[])["value"]
        self._call("Marionette:SetContext", value="content")
        return found

    def requests(self) -> list[str]:
        found: list[str] = self.evaluate(
            "return performance.getEntriesByType('resource').map(one => one.name)"
        )
        return found

    def close(self) -> None:
        with suppress(OSError, AssertionError):
            self._call("Marionette:Quit", flags=["eForceQuit"])
        self._process.terminate()
        self._process.wait(WAIT_S)
        self._file.close()
        self._socket.close()
