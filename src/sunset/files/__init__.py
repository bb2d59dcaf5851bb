"""Users' files, atomic output, Python source, and compression."""

__all__: list[str] = []
