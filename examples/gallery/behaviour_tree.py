"""A behaviour tree (py_trees): the failure furthest upstream first, its cures in turn until the failure is gone."""

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment
from sunset.system.vocabulary import Failure


class Due(Behaviour):
    """Succeeds if a failure is to be treated now."""

    def __init__(self, manager: "BehaviourTree", failure: Failure) -> None:
        super().__init__(f"{failure.name} is due")
        self.manager, self.failure = manager, failure

    def update(self) -> Status:
        return Status.SUCCESS if self.manager.due == self.failure else Status.FAILURE


class Cure(Behaviour):
    """Tries a cure of a failure, runs until its effect is known, and succeeds if it helped."""

    def __init__(self, manager: "BehaviourTree", failure: Failure, option: Option) -> None:
        super().__init__(str(option))
        self.manager, self.failure, self.option = manager, failure, option

    def initialise(self) -> None:
        manager = self.manager
        self.trial = manager.treatment.try_cure(self.failure, self.option)

    def update(self) -> Status:
        return {None: Status.RUNNING, True: Status.SUCCESS, False: Status.FAILURE}[self.trial.helped]


class BehaviourTree(ManagingSystem):
    """Ticks a tree: for each failure, a sequence of its condition and a selector over its cures."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        self.root = Selector("repair", memory=False)
        for failure in self.treatment.failures:
            cures = Selector(f"cure {failure.name}", memory=True)
            cures.add_children(Cure(self, failure, option) for option in self.treatment.options(failure))
            treat = Sequence(f"treat {failure.name}", memory=True)
            self.root.add_child(treat.add_children([Due(self, failure), cures]))

    def adapt(self, symptoms: Symptoms) -> None:
        self.due = self.treatment.due(symptoms)
        self.root.tick_once()
