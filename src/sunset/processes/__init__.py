"""Processes that this package starts: isolated calls, forked servers' processes, and pools of workers.

`calls` calls a function in a copy of this process. `server` forks processes from a clean interpreter, for managing
systems and live nodes. Both give a `process.Process`, which a `keeper` ends. `workers` has pools of processes.
"""

__all__: list[str] = []
