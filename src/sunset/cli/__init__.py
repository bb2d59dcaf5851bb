"""The command line: parse and print. Everything it does can be done from Python as well."""

from sunset.cli._main import main

__all__ = ["main"]
