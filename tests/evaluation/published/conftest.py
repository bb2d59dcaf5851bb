"""Stored runs, as those that are evaluated."""

from tests.evaluation.conftest import edit, store

__all__ = ["edit", "store"]
