"""Which sensors a network looks at."""

from enum import IntEnum


class Modality(IntEnum):
    """The sensors that a network looks at; the values are those of `system_interfaces/msg/FusionType`.

    >>> Modality.FUSION.key, Modality.DEPTH.needs_rgb, Modality.DEPTH.needs_depth
    ('fusion', False, True)
    """

    FUSION = 0
    RGB = 1
    DEPTH = 2

    @property
    def key(self) -> str:
        """The name in a model's card and files."""
        return self.name.lower()

    @property
    def needs_rgb(self) -> bool:
        """Whether the network takes a colour image."""
        return self is not Modality.DEPTH

    @property
    def needs_depth(self) -> bool:
        """Whether the network takes a depth image."""
        return self is not Modality.RGB
