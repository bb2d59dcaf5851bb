"""The walls around processes that run foreign code: they see the files that they need, and the network.

`walls` puts them up from inside a process, before it runs anything; `sunset.processes` starts such processes.
"""

__all__: list[str] = []
