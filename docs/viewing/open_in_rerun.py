"""Show the images and symptoms of a run in Rerun: python open_in_rerun.py RUN [FILE.rrd].

It needs `rerun-sdk` and `mcap-ros2-support`, in an environment of any kind. With a second argument, it writes what it
would show to a file.
"""

import sys
from pathlib import Path

import rerun
from mcap_ros2.reader import read_ros2_messages
from rerun.blueprint import Grid, Spatial2DView, TimeSeriesView, Vertical

run, *file = sys.argv[1:]
messages = list(read_ros2_messages(Path(run) / "images.mcap"))
topics = sorted({one.channel.topic for one in messages})
pictures = [topic for topic in topics if topic.endswith("/compressed")]
rates = [topic for topic in topics if topic.endswith("_freq")]
signals = [topic for topic in topics if topic not in pictures + rates]

rerun.init("sunset", spawn=not file)
if file:
    rerun.save(*file)
views = [Spatial2DView(origin=topic, name=topic.removeprefix("/managed_subsystem/")) for topic in pictures]
plots = [("messages per second", rates), ("signals", signals)]
series = [TimeSeriesView(origin="/", contents=contents, name=name) for name, contents in plots]
rerun.send_blueprint(Vertical(Grid(*views, grid_columns=4), *series, row_shares=[3, 1, 1]))
first = next(number for number, one in enumerate(messages) if one.channel.topic in pictures)
for one in messages[first:]:
    topic, content = one.channel.topic, one.ros_msg.data
    rerun.set_time("time", duration=one.log_time_ns / 1e9)
    if topic in pictures:
        png = {"blob" if "depth" in topic else "contents": bytes(content), "media_type": "image/png"}
        rerun.log(topic, rerun.EncodedDepthImage(**png) if "depth" in topic else rerun.EncodedImage(**png))
    else:
        rerun.log(topic, rerun.Scalars(content))
