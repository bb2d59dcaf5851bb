"""The exceptions of the town."""


class TownError(ValueError):
    """A town, a flight or a view cannot be rendered; the text is a sentence for the user."""


class MissingEmbreeError(TownError):
    """The package embreex, which follows rays, is not installed."""
