"""A stored run as a page that replays it: pictures, labels and truth over time, faults, failures and adaptations."""

from sunset.viewing.collecting import is_shown
from sunset.viewing.page import Viewed, check_comparable, check_page_file, page_text

__all__ = ["Viewed", "check_comparable", "check_page_file", "is_shown", "page_text"]
