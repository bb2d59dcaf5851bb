"""Writing the record of a run."""

import os
import shutil
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Self

import msgspec

from sunset.errors import OutputError
from sunset.files.outputs import flush, unwritable
from sunset.files.schemas import document_text
from sunset.recording._bag import Payload, RecordedMessage, digest_of, write_bag
from sunset.recording.images import ImageWriter, without_pixels
from sunset.recording.schema import RunRecord
from sunset.texts.names import RUN_FILE
from sunset_ros.interfaces import Message, serialize, type_name

_SUFFIX: Final = ".partial"
_HANDED_OVER: Final = "messages"


class RecordWriter:
    """Collects the messages of a run and writes its record.

    Messages are kept in memory, serialized, until `close`, and stored in order of time, and of `write` for the same
    time. Until then, a hidden folder reserves the place. As a context manager, the writer removes it without `close`.

    Args:
        folder: the record's folder, which must not exist, or be empty.
        images: whether images are kept, too.
        wanted: whether the images of a topic are kept; None for all.

    Raises:
        OutputError: the folder holds something already, or cannot be made.
    """

    def __init__(
        self, folder: Path, *, images: bool = False, wanted: Callable[[str], bool] | None = None
    ) -> None:
        self._folder = Path(folder).absolute()
        if not self._folder.name:
            raise OutputError(f"A record needs a folder of its own, got {folder}.")
        self._partial = self._folder.with_name(f".{self._folder.name}{_SUFFIX}")
        self._payloads: list[Payload] = []
        self._keeps_images = images
        self._wanted = wanted
        self._images: ImageWriter | None = None  # opened by the process that writes
        self._closed = False
        with _translated(self._folder):
            if self._folder.exists() and (not self._folder.is_dir() or any(self._folder.iterdir())):
                raise OutputError(f"The record {folder} exists already; remove it or name another folder.")
            self._lock = _take_folder(self._partial, self._folder)

    def write(self, topic: str, time_ns: int, message: Message) -> None:
        """Add a message, of an image the digest.

        Args:
            topic: the full name of the topic.
            time_ns: when the message left its publisher, in nanoseconds on the experiment's clock.
            message: the message, which may be changed afterwards.

        Raises:
            InterfaceError: the message does not fit its definition.
        """
        kept = without_pixels(message)
        if self._keeps_images:
            with _translated(self._folder):
                self._images = self._images or ImageWriter(self._partial, self._wanted)
                self._images.add(topic, time_ns, message)
        self._payloads.append(Payload(topic, type_name(type(kept)), time_ns, serialize(kept)))

    @property
    def digest(self) -> str:
        """SHA-256 over topic, type, time and bytes of all messages so far, in hexadecimal."""
        return digest_of(self._in_order())

    def messages(self, topics: Collection[str]) -> tuple[RecordedMessage, ...]:
        """Return the messages on some topics so far, as `read_messages` does."""
        return tuple(payload.decoded() for payload in self._in_order() if payload.topic in topics)

    def hand_over(self) -> None:
        """Leave the messages in the hidden folder, for the writer of the process that forked this process."""
        with _translated(self._folder):
            if self._images is not None:
                self._images.close()
            (self._partial / _HANDED_OVER).write_bytes(msgspec.msgpack.encode(self._payloads))

    def take_over(self) -> None:
        """Take the messages that a forked process left."""
        left = self._partial / _HANDED_OVER
        self._payloads = msgspec.msgpack.decode(left.read_bytes(), type=list[Payload])
        left.unlink()

    def close(self, run: RunRecord) -> RunRecord:
        """Write the record, give it its final name, and return `run` with the `digest` of the messages.

        Raises:
            OutputError: the record cannot be written, or the folder was filled meanwhile.
        """
        run = msgspec.structs.replace(run, digest=self.digest)
        with _translated(self._folder):
            write_bag(self._partial, self._in_order())
            if self._images is not None:
                self._images.close()
        self.adopt({RUN_FILE: document_text(run).encode()})
        return run

    def adopt(self, files: Mapping[str, bytes]) -> None:
        """Write files, name → content, and give the record its final name.

        For a record from another computer, pass all its files.
        """
        with _translated(self._folder):
            for name, content in files.items():
                (self._partial / name).write_bytes(content)
            flush(self._partial)
            self._partial.rename(self._folder)
        self._release()

    def abort(self) -> None:
        """Remove an unfinished record."""
        if not self._closed:
            if self._images is not None:
                self._images.abort()
            shutil.rmtree(self._partial, ignore_errors=True)
            self._release()

    def _release(self) -> None:
        self._closed = True
        os.close(self._lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.abort()

    def _in_order(self) -> list[Payload]:
        self._payloads.sort(key=lambda payload: payload.time_ns)  # stable, and quick where they are in order
        return self._payloads


def _take_folder(folder: Path, record: Path) -> int:
    """Make an empty folder, without the files of a run that was killed; return an open file that reserves it.

    Raises:
        OutputError: another process has reserved the folder.
    """
    import fcntl  # noqa: PLC0415  not on every system

    folder.mkdir(parents=True, exist_ok=True)
    lock = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(lock)
        raise OutputError(f"Another process writes the record {record}: name another folder.") from error
    for left in folder.iterdir():
        shutil.rmtree(left) if left.is_dir() else left.unlink()
    return lock


@contextmanager
def _translated(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise unwritable(f"The record {folder}", error) from error
