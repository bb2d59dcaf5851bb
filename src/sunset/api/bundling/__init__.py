"""Campaigns as one file that others can check: packing it and verifying it."""

from sunset.api.bundling.packing import bundle
from sunset.api.bundling.verifying import verify

__all__ = ["bundle", "verify"]
