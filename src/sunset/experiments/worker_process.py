"""The process of a worker that does runs in turn; `worker.do_run` starts it."""

import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
import traceback
from contextlib import suppress
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from select import poll
from typing import Final

from sunset.errors import SunsetError
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import prepare
from sunset.experiments.run import record_run
from sunset.experiments.settings import Settings
from sunset.experiments.worker import Order, check_same, facts_of
from sunset.processes.calls import UnexpectedError
from sunset.system import extended_system

_IDLE_S: Final = 60
"""A process ends after so long without an order."""
_GRACE_S: Final = 5
"""How long a process in the middle of a run may take to end."""


def serve(pipe: Connection) -> None:
    """Serve runs until the pipe closes or stays idle for a minute."""
    os.dup2(2, 1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    threading.Thread(target=_end_with_the_other_side, args=(pipe,), daemon=True).start()
    with tempfile.TemporaryDirectory(prefix="sunset-worker-") as folder, suppress(EOFError, OSError):
        while pipe.poll(_IDLE_S):
            pipe.send(_answer(pipe.recv_bytes(), Path(folder, "record")))


def _end_with_the_other_side(pipe: Connection) -> None:
    """End this process, even during a run, when the process that orders its runs has ended."""
    end = poll()
    end.register(pipe.fileno(), 0)  # it wakes up for the end only
    end.poll()
    os.kill(os.getpid(), signal.SIGTERM)  # the run's process ends first, and then its folder is removed
    threading.Event().wait(_GRACE_S)
    os._exit(1)


def _answer(order: bytes, folder: Path) -> dict[str, bytes] | Exception:
    try:
        return _do(pickle.loads(order), folder)  # noqa: S301  the sender may run anything here
    except SunsetError as error:
        return error
    except Exception:  # noqa: BLE001  the sender raises it
        return UnexpectedError(traceback.format_exc())
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _do(order: Order, folder: Path) -> dict[str, bytes]:
    """Do a run, if model, flight and managing system are as expected; return the files of its record."""
    spec = order.spec
    if Path(order.folder).is_dir():
        os.chdir(order.folder)
    sys.path += [place for place in order.search if place not in sys.path]
    with extended_system(()):
        spec.load_extensions()
        resources = prepare(spec)
        check_same(facts_of(resources), order.facts)
        if order.known is not None:
            _check_manager(spec.manager, spec.settings, order.known, order.folder)
        record_run(spec, resources, folder, order.known)
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@cache
def _check_manager(manager: str, settings: Settings, known: str, _: str) -> None:
    """Check, once per folder, that a managing system has not changed since the campaign was begun."""
    name = f"managing system {manager}"
    check_same({name: manager_checksum(manager, settings)}, {name: known})


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
