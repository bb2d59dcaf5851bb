"""The middleware port and its implementations; import these from `port`, `sim` and `cyclonedds`."""

__all__: list[str] = []
