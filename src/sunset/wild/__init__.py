"""Faults that no catalogue lists; confined processes cannot read this folder."""

__all__: list[str] = []
