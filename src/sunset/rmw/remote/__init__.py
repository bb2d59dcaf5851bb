"""The middleware of a process that lives outside of the simulation that it is part of.

In the simulation a `Gateway` stands for it. The process itself, whose nodes are on a `RemoteProcess`, is at the other
end of a pipe. They take turns: the simulation calls a handler and waits until it has returned, so that every event has
the place and the time that it would have in one process, and a record the same bytes.
"""

from sunset.rmw.remote._gateway import Gateway
from sunset.rmw.remote._process import RemoteProcess
from sunset.rmw.remote._protocol import EndError, Pipe, PipeError, RaisedError, SilenceError

__all__ = ["EndError", "Gateway", "Pipe", "PipeError", "RaisedError", "RemoteProcess", "SilenceError"]
