"""What surrounds the managed system: bag player, monitor, evaluator, scenario executor, launcher, who conducts."""

__all__: list[str] = []
