"""How fast images of 256x144 go from one process to another over DDS: latency at 10 and 30 Hz, and flat out.

Usage: python benchmarks/dds_images.py [SECONDS], the seconds of each of the three parts, 5 if left out.
"""

import multiprocessing
import os
import sys
import time
from collections import defaultdict
from statistics import median, quantiles

import numpy as np

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds.domains import free_domain_id
from sunset_ros.time import Time

HEIGHT, WIDTH = 144, 256
RATES = (10, 30)
FLAT_OUT, END = "flat out", "end"


class Sender(Node):
    """Sends at each rate in turn, then flat out; each image says when it was sent, and in which part."""

    def __init__(self, context: Context, seconds: float) -> None:
        super().__init__("sender", context=context, enable_rosout=False)
        self.sent = 0
        self._seconds = seconds
        pixels = np.random.default_rng(0).integers(0, 256, HEIGHT * WIDTH * 3, np.uint8)
        self._image = Image(height=HEIGHT, width=WIDTH, encoding="bgr8", step=3 * WIDTH, data=pixels)
        self._publisher = self.create_publisher(Image, "/images", 10)

    def send(self, part: str) -> None:
        """Send one image."""
        self._image.header.frame_id = part
        self._image.header.stamp = Time(nanoseconds=time.time_ns()).to_msg()
        self._publisher.publish(self._image)

    def run(self, executor: SingleThreadedExecutor) -> None:
        """Send all images."""
        while not self._publisher.get_subscription_count():
            executor.spin_once(timeout_sec=0.01)
        executor.spin_once(timeout_sec=0.5)
        for rate in RATES:
            timer = self.create_timer(1 / rate, lambda part=f"{rate} Hz": self.send(part))  # type: ignore[misc]
            end = time.monotonic() + self._seconds
            while time.monotonic() < end:
                executor.spin_once(timeout_sec=0.1)
            self.destroy_timer(timer)
        end = time.monotonic() + self._seconds
        while time.monotonic() < end:
            self.send(FLAT_OUT)
            self.sent += 1
        executor.spin_once(timeout_sec=0.5)
        self.send(END)


def join(domain_id: int) -> Context:
    """Return the context of this process in a domain."""
    context = Context()
    context.init([], middleware=CycloneDDS(domain_id=domain_id, environment={}))
    return context


def send(domain_id: int, seconds: float, sent: "multiprocessing.SimpleQueue[int]") -> None:
    """Be the process that sends."""
    context = join(domain_id)
    executor = SingleThreadedExecutor(context=context)
    sender = Sender(context, seconds)
    executor.add_node(sender)
    sender.run(executor)
    sent.put(sender.sent)
    context.shutdown()


def main() -> None:
    """Be the process that receives, and print."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    delays: dict[str, list[float]] = defaultdict(list)
    processor: dict[str, float] = {}

    def receive(image: Image) -> None:
        stamp = image.header.stamp
        part = image.header.frame_id
        processor.setdefault(part, time.process_time())
        delays[part].append(time.time_ns() / 1e6 - stamp.sec * 1e3 - stamp.nanosec / 1e6)

    spawn = multiprocessing.get_context("spawn")
    with free_domain_id() as domain_id:
        context = join(domain_id)
        node = Node("receiver", context=context, enable_rosout=False)
        node.create_subscription(Image, "/images", receive, 10)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        sent = spawn.SimpleQueue()
        process = spawn.Process(target=send, args=(domain_id, seconds, sent))
        process.start()
        while END not in delays:
            executor.spin_once(timeout_sec=1.0)
        process.join()
        context.shutdown()
    size = HEIGHT * WIDTH * 3
    print(f"images of {WIDTH}x{HEIGHT} bgr8 ({size} bytes) between two processes, {os.cpu_count()} cores")
    for rate in RATES:
        found = delays[f"{rate} Hz"]
        late = quantiles(found, n=100)[98]
        print(f"  {rate} Hz: latency median {median(found):.2f} ms, p99 {late:.2f} ms ({len(found)} images)")
    received = len(delays[FLAT_OUT])
    cost = (processor[END] - processor[FLAT_OUT]) / received * 1e3
    print(
        f"  flat out: {sent.get() / seconds:,.0f}/s sent, {received / seconds:,.0f}/s received "
        f"({received * size / seconds / 1e6:,.0f} MB/s), {cost:.3f} ms of processor time each to receive"
    )


if __name__ == "__main__":
    main()
