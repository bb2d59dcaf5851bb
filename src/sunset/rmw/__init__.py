"""The middleware port and its implementations; import these from `sunset.rmw.port` and `sunset.rmw.sim`."""

__all__: list[str] = []
