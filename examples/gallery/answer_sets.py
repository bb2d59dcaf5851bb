"""Answer sets (clingo): rules say which faults are suspects and which cures serve; the quickest of these is best."""

import clingo

from sunset.managing import ManagingSystem, Symptoms, Treatment
from sunset.system.vocabulary import Failure

RULES = """
excluded(Fault) :- tried(Cure), cures(Cure, Fault).
suspect(Fault) :- cures(_, Fault), not excluded(Fault).
serves(Cure) :- offered(Cure), cures(Cure, Fault), suspect(Fault).
serves(Cure) :- offered(Cure), not cures(Cure, _).

{ do(Cure) : serves(Cure) } = 1.
covered(Fault) :- do(Cure), cures(Cure, Fault), suspect(Fault).
#minimize { Time@2 : do(Cure), time(Cure, Time) }.
#maximize { 1@1, Fault : covered(Fault) }.
#show do/1. #show suspect/1.
"""


class AnswerSets(ManagingSystem):
    """Asks for an answer set whenever a failure is due; does the cure in it, and diagnoses the suspects in it."""

    def on_start(self) -> None:
        self.treatment = Treatment(self)

    def adapt(self, symptoms: Symptoms) -> None:
        failure = self.treatment.due(symptoms)
        if failure is None:
            return
        atoms = self.solve(failure)
        suspects = [atom.arguments[0].string for atom in atoms if atom.name == "suspect"]
        self.diagnose({fault: 1 / len(suspects) for fault in sorted(suspects)})
        chosen = {atom.arguments[0].string for atom in atoms if atom.name == "do"}
        for option in self.treatment.untried(failure):
            if str(option) in chosen:
                self.treatment.try_cure(failure, option)

    def solve(self, failure: Failure) -> list[clingo.Symbol]:
        """Return the atoms of the best answer set; an empty list if no cure serves."""
        offered = self.treatment.untried(failure)
        facts = []
        for option in self.treatment.options(failure):
            facts.append(f'time("{option}", {round(10 * option.seconds)}).')
            facts.append(f'{"offered" if option in offered else "tried"}("{option}").')
            facts += [f'cures("{option}", "{fault}").' for fault in option.faults]
        control = clingo.Control(["--warn=none"])
        control.add("base", [], RULES + "\n".join(facts))
        control.ground([("base", [])])
        best: list[clingo.Symbol] = []
        control.solve(on_model=lambda model: best.__setitem__(slice(None), model.symbols(shown=True)))
        return best
