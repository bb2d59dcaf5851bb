"""Texts for sentences, tables in terminals and Markdown, and names on the ROS graph."""

__all__: list[str] = []
