"""Errors and texts of the client library, which the rest of SUNSET uses too."""

__all__: list[str] = []
