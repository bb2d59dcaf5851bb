"""A line of the output of a program that is a managing system."""

from typing import Annotated

import msgspec
from msgspec import Meta

from sunset.managing.base import ManagingSystem
from sunset.managing.messages import HIGHEST_PRICE, LONGEST_MODEL, LONGEST_THOUGHT_S, MOST_TOKENS
from sunset_ros.task import Future


class _Adaptation(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    node: str
    id: int | str | None = None

    def do(self, manager: ManagingSystem) -> Future[bool]:
        """Call the method with the name of this kind."""
        *given, node, _ = msgspec.structs.astuple(self)  # fields of a subclass come first
        future: Future[bool] = getattr(manager, str(self.__struct_config__.tag))(node, *given)
        return future


class _SetParameter(_Adaptation, frozen=True, tag="set_parameter"):
    name: str
    value: bool | Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)] | float | str


class _ChangeTopic(_Adaptation, frozen=True, tag="change_topic"):
    name: str
    value: str


class _Activate(_Adaptation, frozen=True, tag="activate"):
    pass


class _Deactivate(_Adaptation, frozen=True, tag="deactivate"):
    pass


class _Restart(_Adaptation, frozen=True, tag="restart"):
    pass


class _Redeploy(_Adaptation, frozen=True, tag="redeploy"):
    pass


class _Cost(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    model: Annotated[str, Meta(max_length=LONGEST_MODEL)] = ""
    tokens_in: Annotated[int, Meta(ge=0, le=MOST_TOKENS)] = 0
    tokens_out: Annotated[int, Meta(ge=0, le=MOST_TOKENS)] = 0
    price: Annotated[float, Meta(ge=0, le=HIGHEST_PRICE)] = 0.0


class Answer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line of a program's output."""

    adaptations: Annotated[
        list[_SetParameter | _ChangeTopic | _Activate | _Deactivate | _Restart | _Redeploy],
        Meta(max_length=100),
    ] = []
    diagnosis: dict[str, Annotated[float, Meta(ge=0, le=1)]] | None = None
    think_s: Annotated[float, Meta(ge=0, le=LONGEST_THOUGHT_S)] = 0.0
    cost: _Cost | None = None
