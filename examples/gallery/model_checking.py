"""Model checking (stormpy): a Markov decision process of the cures; it follows the scheduler of least expected time."""

from collections.abc import Iterator
from pathlib import Path

import stormpy

from sunset.managing import ManagingSystem, Option, Symptoms, Treatment


def prism(options: tuple[Option, ...]) -> Iterator[str]:
    """Yield the lines of the model: `tried` has a bit for each cure, and its highest value is success."""
    done = 1 << len(options)
    yield f"mdp module repair tried : [0..{done}] init 0;"
    for tried in range(done - 1):
        chosen = [option for number, option in enumerate(options) if tried >> number & 1]
        excluded = {fault for option in chosen for fault in option.faults}
        suspects = {fault for option in options for fault in option.faults} - excluded
        for number, option in enumerate(options):
            if option not in chosen:
                cured, total = len(suspects.intersection(option.faults)) or 0.01, max(1, len(suspects))
                yield f"[c{number}] tried={tried} -> {cured}/{total} : (tried'={done})"
                yield f" + {total - cured}/{total} : (tried'={tried | 1 << number});"
    yield f"[stop] tried={done - 1} -> (tried'={done}); endmodule rewards"
    yield from (f"[c{number}] true : {option.seconds};" for number, option in enumerate(options))
    yield f'[stop] true : 20; endrewards label "done" = tried={done};'


class ModelChecking(ManagingSystem):
    """Solves the process of each failure once, and looks up the best cure for those that were tried."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)
        failures = self.treatment.failures
        self.best = {each.name: self.schedule(self.treatment.options(each)) for each in failures}

    def schedule(self, options: tuple[Option, ...]) -> dict[int, Option]:
        """Return the cures that were tried, as bits → the next cure, in the least expected time."""
        Path("repair.prism").write_text("\n".join(prism(options)), encoding="utf-8")
        program = stormpy.parse_prism_program("repair.prism")
        (goal,) = stormpy.parse_properties('Rmin=? [F "done"]', program)
        wanted = stormpy.BuilderOptions([goal.get_raw_formula()])
        wanted.set_build_choice_labels(True)
        wanted.set_build_state_valuations(True)
        model = stormpy.build_model(program, options=wanted)
        scheduler = stormpy.model_checking(model, goal, extract_scheduler=True).get_scheduler()
        (tried,) = model.state_valuations.get_all_variables()
        numbers = {state: scheduler.get_choice(state).get_deterministic_choice() for state in model.states}
        return {
            model.state_valuations.get_value(state.id, tried): options[int(label[1:])]
            for state, number in numbers.items()
            for label in list(state.actions)[number].labels - {"stop"}
        }

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        if failure is not None:
            untried = self.treatment.untried(failure)
            tried = sum(1 << n for n, one in enumerate(self.treatment.options(failure)) if one not in untried)
            self.treatment.try_cure(failure, self.best[failure.name][tried])
