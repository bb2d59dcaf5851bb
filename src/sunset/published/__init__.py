"""The evaluation script of the published exemplar, and the logs that it reads; no run needs any of it."""

from sunset.published.table import PAPER_FORMATS, PUBLISHED, paper_report

__all__ = ["PAPER_FORMATS", "PUBLISHED", "paper_report"]
