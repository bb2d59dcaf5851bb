"""Data frames and figures, for which a user installs pandas and matplotlib."""

__all__: list[str] = []
