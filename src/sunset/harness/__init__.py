"""The surroundings of the managed system: bag player, monitor, evaluator, scenario executor, launcher, conductors."""

__all__: list[str] = []
