"""The verbs of the command line: `sunset train`, and actions of `sunset models`."""
