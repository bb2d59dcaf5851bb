"""The middleware of a process that names none: the live one, as its environment says."""

from sunset.rmw.core.port import Middleware

__all__ = ["default_middleware"]


def default_middleware(domain_id: int | None = None) -> Middleware:
    """Join ROS 2's network on this computer.

    Args:
        domain_id: processes hear those of the same domain only; ROS_DOMAIN_ID, else 0, if None.

    Raises:
        MissingExtraError: the extra `live` is not installed.
        MiddlewareError: the environment has a setting that cannot be used, or the domain cannot be entered.
    """
    from sunset.rmw.dds import CycloneDDS  # noqa: PLC0415  an optional extra

    return CycloneDDS(domain_id=domain_id)
