"""The middleware port in `core`, and its implementations in `sim` and `dds`."""

__all__: list[str] = []
