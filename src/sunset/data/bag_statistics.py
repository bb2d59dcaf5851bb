"""Statistics of a bag: its frames, topics, classes and depths."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from sunset.classes import CARLA_IDS
from sunset.data.bag import BagReader
from sunset.data.pixels import FAR
from sunset_town import DEPTH_RANGE_M


@dataclass(frozen=True, slots=True, kw_only=True)
class BagStatistics:
    """Statistics of a bag.

    Attributes:
        path: the bag.
        frames: number of frames.
        size: height and width in pixels.
        seconds: from the first frame to the last.
        rate_hz: frames a second; None for a single moment.
        topics: topic → type and number of messages.
        encodings: topic of images → their encoding.
        dropped: topic → number of images outside frames.
        classes: class → share of the pixels, the largest first; absent classes are left out.
        ignored: share of pixels without a class.
        unlabelled: number of frames without labels.
        depth_m: least and greatest known depth [m].
        depth_far: share of pixels whose depth is greater or unknown.
    """

    path: Path
    frames: int
    size: tuple[int, int]
    seconds: float
    rate_hz: float | None
    topics: Mapping[str, tuple[str, int]]
    encodings: Mapping[str, str]
    dropped: Mapping[str, int]
    classes: Mapping[str, float]
    ignored: float
    unlabelled: int
    depth_m: tuple[float, float]
    depth_far: float

    def to_json(self) -> dict[str, object]:
        """Return the statistics as JSON values."""
        values = asdict(self)
        height, width = values.pop("size")
        head = {"bag": str(values.pop("path")), "frames": self.frames, "width": width, "height": height}
        topics = {topic: {"type": kind, "messages": count} for topic, (kind, count) in self.topics.items()}
        return {**head, **values, "topics": topics, "depth_m": list(self.depth_m)}


def bag_statistics(reader: BagReader, *, progress: Callable[[int, int], None] | None = None) -> BagStatistics:
    """Return the statistics of all frames of a bag; `progress` is called with (frames done, frames in all).

    Raises:
        DataError: a frame cannot be read.
    """
    ids, nearest, furthest, far = np.zeros(256, dtype=np.int64), FAR, 0, 0
    for index in range(len(reader)):
        frame = reader.frame(index)
        ids += np.bincount(frame.labels.ravel(), minlength=256)
        near = frame.depth[frame.depth < FAR]
        far += frame.depth.size - near.size
        if near.size:
            nearest, furthest = min(nearest, int(near.min())), max(furthest, int(near.max()))
        if progress is not None:
            progress(index + 1, len(reader))
    total = len(reader) * reader.size[0] * reader.size[1]
    stamps = reader.stamps_ns
    seconds = (stamps[-1] - stamps[0]) / 1e9
    shares = Counter({name: int(ids[number]) / total for name, number in CARLA_IDS.items()})
    return BagStatistics(
        path=reader.path,
        frames=len(reader),
        size=reader.size,
        seconds=seconds,
        rate_hz=(len(stamps) - 1) / seconds if seconds else None,
        topics=dict(reader.topics),
        encodings=dict(reader.encodings),
        dropped=dict(reader.dropped),
        classes={name: share for name, share in shares.most_common() if share},
        ignored=(total - int(ids[list(CARLA_IDS.values())].sum())) / total,
        unlabelled=reader.unlabelled,
        depth_m=(nearest * DEPTH_RANGE_M / FAR, furthest * DEPTH_RANGE_M / FAR),
        depth_far=far / total,
    )
