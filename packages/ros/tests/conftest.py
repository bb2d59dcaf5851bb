"""Settings of all tests of the library."""

import signal

from hypothesis import settings

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as a shell does for what it starts with "&"
    signal.signal(signal.SIGINT, signal.default_int_handler)  # tests, and what they start, are interrupted

settings.register_profile("untimed", deadline=None)  # a busy computer is no failure
settings.load_profile("untimed")
