"""The calls of the package `sunset`, in modules that are imported when a call is first used."""

__all__: list[str] = []
