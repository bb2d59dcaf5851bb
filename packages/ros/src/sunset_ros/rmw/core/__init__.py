"""The port between the client library and middlewares, and the interface of observers."""

__all__: list[str] = []
