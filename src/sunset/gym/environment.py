"""The environment: an agent repairs the managed system, an episode is a run."""

from collections.abc import Awaitable, Callable, Sequence
from contextvars import Context, copy_context
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, SupportsInt

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.error import ResetNeeded

from sunset.api.arguments import Extensions, extended
from sunset.api.options import run_spec_of
from sunset.classes import PALETTE
from sunset.errors import InvalidInputError
from sunset.experiments import RunSpec, World, describe, prepare
from sunset.experiments.resources import Resources
from sunset.gym.referee import PICTURES, Referee
from sunset.gym.spaces import FORMS
from sunset.image_messages import array_of_bgr, array_of_labels
from sunset.managing.actions import action_names
from sunset.managing.policy import Mask, Policy
from sunset.managing.symptoms import Symptoms
from sunset.processes.calls import call_isolated
from sunset.scenarios import Scenario, SplitSpec, draw_split, load_scenario, load_suite, with_strengths
from sunset.system import system_with
from sunset_ros.task import Future
from sunset_ros.texts import shown, suggestion

Scenarios = str | Path | Sequence[str | Path | Scenario]

_MOST_SEEDS: Final = 2**32
_FORK_LIMIT_S: Final = 3600.0
_SEE_THROUGH: Final = 0.5
"""The share of the colours of classes in a rendered frame."""


class _Seat(Policy):
    """The managing system of an episode, whose actions are told from outside."""

    is_asked = False
    """Whether an action is due."""
    answer: Future[int]

    def on_start(self) -> None:
        """Number the actions now, while the system has no unlisted faults."""
        _ = self.sight  # it is made when it is first used

    def view(self, _: Symptoms) -> Any:
        """Make no observation: the environment does, in the form that its user wants."""
        return None, None

    def act(self, observation: Any, action_mask: Mask) -> Awaitable[int]:
        """Wait for the action."""
        del observation, action_mask
        self.is_asked, self.answer = True, Future()
        return self.answer


class _Episode:
    """A run that is managed by decisions from outside.

    Attributes:
        seat: its managing system.
        referee: sees its truth.
        is_over: whether the measured time has ended.
        utility: at the present decision.
    """

    def __init__(self, spec: RunSpec, resources: Resources, patience: int, cure_reward: float) -> None:
        self.spec = spec
        self._cure_reward = cure_reward
        outside = copy_context()  # the managing system must not know unlisted faults
        with system_with(fault.name for fault in spec.scenario.faults):
            self._context = copy_context()
            self.referee = Referee(describe(spec, resources))
            self._world = World(spec, resources, self.referee)
        self.seat: _Seat = outside.run(self._world.manage, _Seat)
        self.seat.patience = patience
        self._context.run(self._advance)
        self._worth = 0.0

    def step(self, action: int) -> float:
        """Begin an action, go on to the next decision, and return the reward."""
        self.seat.is_asked = False
        self.seat.answer.set_result(action)
        before = self._worth
        self._context.run(self._advance)
        return self._worth - before

    def _advance(self) -> None:
        world, seat = self._world, self.seat
        self.is_over = not world.advance_until(lambda: seat.is_asked)
        if self.is_over:
            world.finish()
        start_ns = world.start_ns or world.now_ns
        self.utility = self.referee.utility(start_ns)
        cured = self.referee.cured(start_ns) if self._cure_reward else 0
        self._worth = self.utility + self._cure_reward * cured


class RepairEnv(gymnasium.Env[Any, SupportsInt]):
    """Repair the managed system while a scenario's faults come; an episode is a run in the simulation.

    An agent sees what a managing system may see. It decides every 0.2 s of the experiment, unless it has patience, from
    the first segmented frame on; the measured time begins some seconds later. The rewards of an episode add up to the
    run's `utility`, which `sunset.bench` reports for the same decisions. Episodes are truncated, not terminated: the
    measurement ends, and the mission goes on.

    Actions are numbered as in `action_names`; 0 does nothing. Masks, in `info["action_mask"]` and by `action_masks`,
    say which can have an effect. The last `info` has `utility`, and every one `scenario` and `seed`.

    Args:
        split: the split that the scenarios are drawn from, as in `sunset.generate_split`.
        count: how many scenarios the split has.
        split_seed: of the split.
        flights: whether each scenario of the split has a flight of its own.
        scenarios: in place of a split, a suite or a folder, or a list of scenarios.
        seeds: of the runs; an episode draws one of them, or any seed if there are none.
        observation: the form of observations: `arrays`, `graph` or `text`, as `sunset.managing.policy.Sight` has them.
        cure_reward: is paid for each fault that is cured besides, and taken back if the cure is undone early; for
            training, since it depends on the truth.
        patience: as in `Policy`.
        render_mode: `rgb_array` or None.
        extensions: as in `sunset.Options`, like the options.
        **options: of the runs, such as `model` and `duration`.

    Attributes:
        action_names: the actions, in words.

    Raises:
        InvalidInputError: an argument is not usable.
        ScenarioError: a scenario or suite does not exist.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}  # noqa: RUF012  as Gymnasium declares it

    def __init__(
        self,
        split: str = "train",
        *,
        count: int = 200,
        split_seed: int = 0,
        flights: bool = False,
        scenarios: Scenarios = (),
        seeds: Sequence[int] = (),
        observation: str = "arrays",
        cure_reward: float = 0.0,
        patience: int = 1,
        render_mode: str | None = None,
        extensions: Extensions = (),
        **options: Any,
    ) -> None:
        if observation not in FORMS:
            raise InvalidInputError(
                f"There is no observation {shown(observation)}: {suggestion(observation, FORMS)}choose one of "
                f"{', '.join(FORMS)}."
            )
        with extended(extensions):
            self._context: Context = copy_context()
            make_space, self._observe = FORMS[observation]
            self.observation_space = make_space()
            self.action_names = action_names()
            self.scenarios = (
                _named(scenarios)
                if scenarios
                else draw_split(SplitSpec(split=split, count=count, seed=split_seed, flights=flights))
            )
        self.action_space = gymnasium.spaces.Discrete(len(self.action_names))
        self.render_mode = render_mode
        self._seeds, self._options = tuple(seeds), options
        self._patience, self._cure_reward = patience, cure_reward
        self._prepared: dict[object, Resources] = {}
        self._running: _Episode | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, and let the managed system come up.

        Args:
            seed: of everything that is drawn from now on.
            options: `scenario` and `seed` of the run, which are drawn if they are missing.
        """
        super().reset(seed=seed)
        chosen = options or {}
        drawn = self.scenarios[int(self.np_random.integers(len(self.scenarios)))]
        run_seed = (
            self._seeds[int(self.np_random.integers(len(self._seeds)))]
            if self._seeds
            else int(self.np_random.integers(_MOST_SEEDS))
        )
        self._context.run(self._begin, chosen.get("scenario", drawn), chosen.get("seed", run_seed))
        return self._context.run(self._observed)

    def _begin(self, scenario: str | Path | Scenario, seed: int) -> None:
        spec = run_spec_of(scenario, _Seat, seed, self._options)
        key = spec.flight, spec.timing.frames
        if key not in self._prepared:
            self._prepared[key] = prepare(spec)
            self._prepared[key].frames.keep()
        card = self._prepared[key].model.card
        known = with_strengths(spec.scenario, card.severities, card.name)
        resources = replace(self._prepared[key], scenario=known)
        self._running = _Episode(spec, resources, self._patience, self._cure_reward)

    def step(self, action: SupportsInt) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Do an action, and go on to the next decision that is due.

        Raises:
            ResetNeeded: the episode is over, or none has begun.
            InvalidInputError: there is no such action.
        """
        if self._episode.is_over:
            raise ResetNeeded("The episode is over: reset the environment before the next step.")
        if not 0 <= int(action) < len(self.action_names):
            raise InvalidInputError(
                f"An action must be a whole number from 0 to {len(self.action_names) - 1}, got {shown(action)}."
            )
        reward = self._episode.step(int(action))
        observation, info = self._context.run(self._observed)
        return observation, reward, False, self._episode.is_over, info

    def action_masks(self) -> npt.NDArray[np.bool_]:
        """Return which actions can have an effect, (number of actions,)."""
        return self._context.run(lambda: self._episode.seat.mask).astype(np.bool_)

    @property
    def situation(self) -> tuple[str, ...]:
        """What differs from a healthy system at the last decision, in words; empty for a healthy one."""
        return self._context.run(lambda: self._episode.seat.situation)

    def play(self, policy: Callable[[Any, Mask], SupportsInt]) -> tuple[float, dict[str, Any]]:
        """Let a policy act to the end of the episode; return the sum of the rewards, and the last `info`.

        Args:
            policy: returns an action for an observation and the mask of actions.
        """
        total, (observation, info) = 0.0, self._context.run(self._observed)
        while not self._episode.is_over:
            observation, reward, _, _, info = self.step(policy(observation, info["action_mask"]))
            total += reward
        return total, info

    def fork(self, function: "Callable[[RepairEnv], object]") -> Any:
        """Call a function with a copy of this environment, in the middle of its episode, and return the result.

        The copy is in a forked process, so that the call has no effect here.

        Args:
            function: such as `lambda env: env.play(policy)`; returns what JSON can hold, in which tuples become lists.

        Raises:
            SunsetError: the function raised it.
            UnexpectedError: it raised another exception.
            ProcessDeath: its process ended early.
        """
        return call_isolated(lambda _: function(self), limit_s=_FORK_LIMIT_S)

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return the camera's last frame under the last segmentation, (H, W, 3) uint8 in RGB; None unless asked for."""
        if self.render_mode is None:
            return None
        colour, labels = (self._episode.referee.pictures[topic] for topic in PICTURES)
        rgb = array_of_bgr(colour)[..., ::-1]
        mixed = (1 - _SEE_THROUGH) * rgb + _SEE_THROUGH * PALETTE[array_of_labels(labels)]
        return mixed.astype(np.uint8)

    @property
    def _episode(self) -> _Episode:
        if self._running is None:
            raise ResetNeeded("No episode has begun: reset the environment first.")
        return self._running

    def _observed(self) -> tuple[Any, dict[str, Any]]:
        episode = self._episode
        info = {"scenario": episode.spec.scenario.name, "seed": episode.spec.seed}
        if episode.is_over:
            info["utility"] = episode.utility
        else:
            info["action_mask"] = episode.seat.mask
        return self._observe(episode.seat.sight, episode.seat.symptoms), info


def _named(scenarios: Scenarios) -> tuple[Scenario, ...]:
    if isinstance(scenarios, str | Path):
        return load_suite(scenarios)
    return tuple(each if isinstance(each, Scenario) else load_scenario(each) for each in scenarios)
