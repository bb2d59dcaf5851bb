"""The published exemplar's evaluation script, and the logs that it reads."""

from sunset.evaluation.published.table import PAPER_FORMATS, PUBLISHED, paper_report

__all__ = ["PAPER_FORMATS", "PUBLISHED", "paper_report"]
