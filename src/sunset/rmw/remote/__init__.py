"""The middleware of a process that lives outside of the network that it is part of.

On the network a `Gateway` stands for it. The process itself, whose nodes are on a `RemoteProcess`, is at the other end
of a pipe. They take turns: the gateway calls a handler and waits until it has returned. In a simulation every event so
has the place and the time that it would have in one process, and a record the same bytes. Live, time goes on meanwhile.
"""

from sunset.rmw.remote._gateway import Gateway
from sunset.rmw.remote._process import RemoteProcess
from sunset.rmw.remote._protocol import EndError, Pipe, PipeError, RaisedError, SilenceError

__all__ = ["EndError", "Gateway", "Pipe", "PipeError", "RaisedError", "RemoteProcess", "SilenceError"]
