"""The middleware of a process outside of the network.

A `Gateway` represents the process on the network. The process itself has a `RemoteProcess` at the other end of a pipe.
They take turns: the gateway calls a handler, and waits until it returns. In a simulation, events have the same order
and times as in a single process. Live, time goes on meanwhile.
"""

from sunset_ros.rmw.remote._gateway import Gateway
from sunset_ros.rmw.remote._process import RemoteProcess
from sunset_ros.rmw.remote._protocol import EndError, Pipe, PipeError, RaisedError, SilenceError

__all__ = ["EndError", "Gateway", "Pipe", "PipeError", "RaisedError", "RemoteProcess", "SilenceError"]
