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
    """

    def __init__(self, spec: RunSpec, resources: Resources) -> None:
        self.spec = spec
        outside = copy_context()  # the managing system must not know unlisted faults
        with system_with(fault.name for fault in spec.scenario.faults):
            self._context = copy_context()
            self.referee = Referee(describe(spec, resources))
            self._world = World(spec, resources, self.referee)
        self.seat: _Seat = outside.run(self._world.manage, _Seat)
        self._score = 0.0, 0
        self.advance()

    def advance(self) -> bool:
        """Go on to the next decision; return whether the run is over."""
        return self._context.run(self._advance)

    def _advance(self) -> bool:
        seat = self.seat
        goes_on = self._world.advance_until(lambda: seat.is_asked)
        if not goes_on:
            self._world.finish()
        return not goes_on

    def begin(self, action: int) -> None:
        """Begin an action."""
        self.seat.is_asked = False
        self.seat.answer.set_result(action)

    def gain(self, cure_reward: float) -> float:
        """Return the increase of utility and of the number of cured faults, which is weighted, since the last call."""
        return self._context.run(self._gain, cure_reward)

    def _gain(self, cure_reward: float) -> float:
        start_ns = self._world.start_ns or self._world.now_ns
        cured = self.referee.cured(start_ns) if cure_reward else 0
        (utility, before), self._score = self._score, (self.referee.utility(start_ns), cured)
        return self._score[0] - utility + cure_reward * (cured - before)

    @property
    def utility(self) -> float:
        """The utility at the last `gain`."""
        return self._score[0]


class RepairEnv(gymnasium.Env[Any, SupportsInt]):
    """Repair the managed system while a scenario's faults come; an episode is a run in the simulation.

    An agent sees what a managing system may see. It decides every 0.2 s of the experiment, from the first segmented
    frame on; the measured time begins some seconds later. The rewards of an episode add up to the run's `utility`,
    which `sunset.bench` reports for the same decisions. Episodes are truncated, not terminated: the measurement ends,
    and the mission goes on.

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
        render_mode: str | None = None,
        extensions: Extensions = (),
        **options: Any,
    ) -> None:
        _check_forms(observation, render_mode)
        with extended(extensions):
            self._context: Context = copy_context()
            make_space, self._observe = FORMS[observation]
            self.observation_space = make_space()
            self.action_names = action_names()
            self.scenarios = (
                _named(scenarios) if scenarios else _drawn(split, count, split_seed, flights=flights)
            )
        self.action_space = gymnasium.spaces.Discrete(len(self.action_names))
        self.render_mode = render_mode
        self._seeds, self._options, self._cure_reward = tuple(seeds), options, cure_reward
        self._prepared: dict[object, Resources] = {}
        self._running: _Episode | None = None
        self._is_over = True

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
        self._running = _Episode(spec, replace(self._prepared[key], scenario=known))
        self._is_over = False

    def step(self, action: SupportsInt) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Do an action, and go on to the next decision that is due.

        Raises:
            ResetNeeded: the episode is over, or none has begun.
            InvalidInputError: there is no such action.
        """
        if self._is_over:
            raise ResetNeeded("The episode is over: reset the environment before the next step.")
        if not 0 <= int(action) < len(self.action_names):
            raise InvalidInputError(
                f"An action must be a whole number from 0 to {len(self.action_names) - 1}, got {shown(action)}."
            )
        self._episode.begin(int(action))
        self._is_over = self._episode.advance()
        reward = self._episode.gain(self._cure_reward)
        observation, info = self._context.run(self._observed)
        return observation, reward, False, self._is_over, info

    def action_masks(self) -> npt.NDArray[np.bool_]:
        """Return which actions can have an effect, (number of actions,)."""
        allowed = self._context.run(self._episode.seat.actions.allowed, self._episode.seat.symptoms)
        return np.array(allowed, np.bool_)

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
        while not self._is_over:
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
        pictures = self._episode.referee.pictures
        colour, labels = (pictures.get(topic) for topic in PICTURES[:2])
        if colour is None or labels is None:
            raise ResetNeeded("There is no frame yet.")
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
        if self._is_over:
            info["utility"] = episode.utility
        else:
            info["action_mask"] = np.array(episode.seat.actions.allowed(episode.seat.symptoms), np.int8)
        return self._observe(episode.seat.sight, episode.seat.symptoms), info


def _named(scenarios: Scenarios) -> tuple[Scenario, ...]:
    if isinstance(scenarios, str | Path):
        return load_suite(scenarios)
    return tuple(each if isinstance(each, Scenario) else load_scenario(each) for each in scenarios)


def _drawn(split: str, count: int, seed: int, *, flights: bool) -> tuple[Scenario, ...]:
    return draw_split(SplitSpec(split=split, count=count, seed=seed, flights=flights))


def _check_forms(observation: str, render_mode: str | None) -> None:
    if observation not in FORMS:
        raise InvalidInputError(
            f"There is no observation {shown(observation)}: {suggestion(observation, FORMS)}choose one of "
            f"{', '.join(FORMS)}."
        )
    if render_mode not in {None, *RepairEnv.metadata["render_modes"]}:
        raise InvalidInputError(f"The render mode must be rgb_array or None, got {shown(render_mode)}.")
