"""Images are recorded as digests of their pixels: enough to tell whether two runs saw the same."""

from sunset.image_digests import digest_of, image_digest
from sunset.interfaces import Message
from sunset.interfaces.sensor_msgs.msg import Image
from sunset.interfaces.system_interfaces.msg import ImageDigest, SensorFusion


def without_pixels(message: Message) -> Message:
    """Return `message` as a record has it: with digests in place of images."""
    if isinstance(message, Image):
        return _digest_message(message, image_digest(message.data))
    if isinstance(message, SensorFusion):
        parts = image_digest(message.depth.data), image_digest(message.rgb.data)
        modality = bytes([message.modality.fusion_type])
        fused = _digest_message(message.rgb, digest_of(b"".join([*parts, modality])))
        fused.header = message.header
        return fused
    return message


def _digest_message(image: Image, digest: bytes) -> ImageDigest:
    return ImageDigest(
        header=image.header, height=image.height, width=image.width, encoding=image.encoding, digest=digest
    )
