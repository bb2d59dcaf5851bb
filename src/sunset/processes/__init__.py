"""Processes that this package starts: isolated calls, forked servers' processes, and pools of workers.

`calls` calls a function in a copy of this process. `server` forks processes from another interpreter, for managing
systems and live nodes. Both are a `process.Process`, which a `keeper` ends. `workers` has pools of processes.
"""

__all__: list[str] = []
