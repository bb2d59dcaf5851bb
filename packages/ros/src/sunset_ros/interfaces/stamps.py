"""Between stamps, which have seconds and nanoseconds, and whole nanoseconds."""

from typing import Final

from sunset_ros.interfaces.builtin_interfaces.msg import Duration, Time

NS_PER_S: Final = 10**9


def ns_of(stamp: Time | Duration) -> int:
    """Return a stamp in nanoseconds.

    >>> ns_of(Time(sec=2, nanosec=7))
    2000000007
    """
    return stamp.sec * NS_PER_S + stamp.nanosec


def stamp_of(time_ns: int) -> Time:
    """Return the stamp of a time in nanoseconds, of at least 0.

    >>> stamp_of(2_000_000_007)
    Time(sec=2, nanosec=7)
    """
    seconds, nanoseconds = divmod(time_ns, NS_PER_S)
    return Time(sec=seconds, nanosec=nanoseconds)
