"""What a live system forks its nodes from: `python -m sunset.cli._forks`, see `sunset.forks`."""

import gc
import os
import socket
import sys

import setproctitle  # noqa: F401  what is forked gets its name from it

import sunset.managing
import sunset.scenarios  # noqa: F401  these are what nodes need
from sunset.cli import main
from sunset.cli.node import MANAGER
from sunset.forks import await_order
from sunset.rmw.backends import live_middleware

__all__: list[str] = []

if __name__ == "__main__":
    live_middleware().prepare()
    gc.freeze()  # the garbage collector would write to the pages that all forked processes share
    with socket.socket(fileno=os.dup(0)) as orders:
        words = await_order(orders)
    code = 0 if words is None else main(words)
    if words is not None and MANAGER in words:
        sys.exit(code)  # whatever others wrote may have to tidy up
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # the node has left the network; the interpreter would take a tenth of a second to tidy up
