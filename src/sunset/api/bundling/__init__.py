"""Campaigns as one file that others can check: packing it and verifying it."""

from sunset.api.bundling.packing import Bundle, bundle
from sunset.api.bundling.rerunning import Rerun
from sunset.api.bundling.verifying import Verification, verify

__all__ = ["Bundle", "Rerun", "Verification", "bundle", "verify"]
