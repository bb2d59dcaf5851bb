"""Planning (unified-planning with Pyperplan): the shortest plan that ends all failures; the first step is done."""

from unified_planning.shortcuts import (
    BoolType,
    Fluent,
    InstantaneousAction,
    OneshotPlanner,
    Problem,
    UserType,
    get_environment,
)

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment
from sunset.system.vocabulary import Failure

get_environment().credits_stream = None


class Planning(ManagingSystem):
    """Believes that each cure that was not tried in vain ends its failures, and plans again when it does not."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)

    def adapt(self, symptoms: Symptoms) -> None:
        due = self.treatment.due(symptoms)
        if due is not None:
            later = [failure for failure in self.treatment.showing if failure != due]
            self.treatment.try_cure(due, self.first_step([due, *later]))

    def first_step(self, failures: list[Failure]) -> Option:
        """Return the first cure of a plan that ends the failures, in their order."""
        kind = UserType("failure")
        gone = Fluent("gone", BoolType(), failure=kind)
        problem = Problem("repair")
        problem.add_fluent(gone, default_initial_value=False)
        actions: dict[tuple[object, ...], InstantaneousAction] = {}
        cures: dict[str, Option] = {}
        before = None
        for failure in failures:
            goal = gone(problem.add_object(failure.name, kind))
            for option in self.treatment.untried(failure):
                action = actions.get(option.steps)
                if action is None:
                    action = actions[option.steps] = InstantaneousAction(f"cure_{len(actions)}")
                    cures[action.name] = option
                    if before is not None:
                        action.add_precondition(before)
                action.add_effect(goal, True)
            if self.treatment.untried(failure):
                problem.add_goal(goal)
                before = goal
        problem.add_actions(actions.values())
        with OneshotPlanner(name="pyperplan") as planner:
            plan = planner.solve(problem).plan
        return cures[plan.actions[0].action.name]
