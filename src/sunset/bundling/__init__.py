"""Campaigns as one file that others can check: packing it and verifying it."""

from sunset.bundling.packing import Bundle, bundle
from sunset.bundling.rerunning import Rerun
from sunset.bundling.verifying import Verification, verify

__all__ = ["Bundle", "Rerun", "Verification", "bundle", "verify"]
