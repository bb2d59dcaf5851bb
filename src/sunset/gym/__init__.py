"""The managed system as an environment of Gymnasium, `sunset/Repair-v0`, which this package registers."""

from sunset.errors import MissingExtraError

try:
    import gymnasium
except ImportError as error:
    raise MissingExtraError(
        "The environment needs Gymnasium, which is not installed: pip install 'sunset-exemplar[gym]'."
    ) from error

from sunset.gym.environment import RepairEnv as RepairEnv
from sunset.managing.policy import Policy as Policy

gymnasium.register("sunset/Repair-v0", entry_point="sunset.gym.environment:RepairEnv")
