"""What all middlewares share: the port that the client library knows, and what an observer may see."""

__all__: list[str] = []
