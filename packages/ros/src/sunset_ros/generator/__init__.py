"""The .msg and .srv files: their language, and the Python modules that are generated from them."""

__all__: list[str] = []
