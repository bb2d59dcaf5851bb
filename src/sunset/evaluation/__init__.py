"""Tables, figures and reports of stored records; nothing is run."""

__all__: list[str] = []
