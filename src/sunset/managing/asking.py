"""A managing system whose decisions are made outside of its process, by a user of the simulation that it is in."""

from collections.abc import Iterable

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import request
from sunset.system.vocabulary import Adaptation
from sunset_ros.task import Future


class AskTell(ManagingSystem):
    """Waits for each decision until it is told.

    When a decision is due, `asked` has the symptoms; let no time pass until `tell` answers. A decision that was not
    told when the next is due is dropped.
    """

    asked: Symptoms | None = None
    """The symptoms for which a decision is due; None while none is due."""
    _answer: Future[Iterable[Adaptation]]

    async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]  # it may be a coroutine
        """Wait for the decision, and do it."""
        self.asked, self._answer = symptoms, Future()
        for adaptation in await self._answer:
            request(self, adaptation)

    def tell(self, adaptations: Iterable[Adaptation]) -> None:
        """Do adaptations now, or nothing, in answer to `asked`.

        Raises:
            RuntimeError: no decision is due.
        """
        if self.asked is None:
            raise RuntimeError("tell answers a question, and no decision is due")
        self.asked = None
        self._answer.set_result(adaptations)
