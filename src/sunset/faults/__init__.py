"""What faults do to images: the degradations as pure functions on arrays."""

from sunset.faults.degradations import (
    BLUR_SIGMA,
    DEPTH_COUNTS_PER_METRE,
    DEPTH_DEGRADATION_RANGE,
    IMAGE_DEGRADATION_RANGE,
    REFERENCE_WIDTH,
    blur,
    defocus_image,
    degrade_depth,
    degrade_image,
    enhance_image,
    misalign_image,
    sharpness,
    shift_image,
)

__all__ = [
    "BLUR_SIGMA",
    "DEPTH_COUNTS_PER_METRE",
    "DEPTH_DEGRADATION_RANGE",
    "IMAGE_DEGRADATION_RANGE",
    "REFERENCE_WIDTH",
    "blur",
    "defocus_image",
    "degrade_depth",
    "degrade_image",
    "enhance_image",
    "misalign_image",
    "sharpness",
    "shift_image",
]
