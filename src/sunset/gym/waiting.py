"""A wrapper that asks for a decision only when there is something new to decide about."""

from typing import Any, SupportsFloat

import gymnasium

from sunset.gym.environment import RepairEnv


class UntilSymptomsChange(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Does nothing after each action until the situation has changed, and returns the sum of the rewards.

    The situation is `RepairEnv.situation`.

    Args:
        env: the environment, or a wrapper of it.
        longest: decisions after which it returns in any case, at least 1.
    """

    def __init__(self, env: "gymnasium.Env[Any, Any]", longest: int = 10) -> None:
        super().__init__(env)
        self._longest = longest

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Do an action, and wait."""
        env = self.unwrapped
        assert isinstance(env, RepairEnv)  # noqa: S101  no other has a situation
        before, total, waited = env.situation, 0.0, 0
        while True:
            observation, reward, terminated, truncated, info = super().step(0 if waited else action)
            total, waited = total + float(reward), waited + 1
            if terminated or truncated or env.situation != before or waited >= self._longest:
                return observation, total, terminated, truncated, info
