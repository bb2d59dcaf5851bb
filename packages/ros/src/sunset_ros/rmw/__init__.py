"""The middleware port in `core`, and its implementations in `sim`, `dds` and `remote`."""

__all__: list[str] = []
