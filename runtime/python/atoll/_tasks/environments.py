"""A task in the worlds of a batch, as environments of Gymnasium."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from .. import _core

Array = NDArray[np.float64]
Seen = NDArray[np.floating[Any]]
Bools = NDArray[np.bool_]


class Task(ABC):
    """What is to be done in each world: a scene, how an episode begins, what is seen, what is done, and what it is worth.

    A task is of one batch: it may keep arrays with a row a world, such as marks to get to.
    """

    scene: _core.Scene
    observation_space: gymnasium.spaces.Box  #: of one world
    action_space: gymnasium.spaces.Box  #: of one world
    steps_an_action: int = 1  #: of the scene's dt
    horizon: int = 500  #: actions, after which an episode is truncated

    @abstractmethod
    def draw(self, random: np.random.Generator) -> Array:
        """The numbers that an episode of one world begins with, shape (k,)."""

    @abstractmethod
    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        """Puts worlds, which are as the scene has them, to where drawn numbers say, shape (places, k)."""

    @abstractmethod
    def act(self, batch: _core.Batch, actions: Array) -> None:
        """Takes actions, shape (worlds, ...), to the next steps."""

    def advance(self, batch: _core.Batch, actions: Array, worlds: Bools | None) -> None:
        """Takes actions, and steps these worlds, or all: what act() and Batch.step() do, in one call where that is faster."""
        self.act(batch, actions)
        batch.step(count=self.steps_an_action, worlds=worlds)

    @abstractmethod
    def observe(self, batch: _core.Batch) -> Seen:
        """A new array, shape (worlds, ...)."""

    @abstractmethod
    def judge(self, batch: _core.Batch, actions: Array) -> tuple[Array, Bools]:
        """Rewards of what was done, and which episodes have ended by it, shape (worlds,)."""


class BatchEnv(VectorEnv[Seen, Array, Any]):
    """A task in `num_envs` worlds of one batch, with any of Gymnasium's three modes of starting over.

    A world that loses a body to quarantine has ended its episode, with no reward for its last action.

    With render_mode "rgb_array", which takes `pip install atoll[render]`, render() takes pictures.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}

    def __init__(
        self,
        task: Task,
        num_envs: int,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int = 0,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise _core.Error(f"found the render_mode {render_mode!r}; expected 'rgb_array' or None")
        self.task = task
        self.render_mode = render_mode
        self.num_envs = num_envs
        self.batch = _core.Batch(task.scene, num_envs, threads=threads)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        frames = 1 / (task.scene.dt * task.steps_an_action)
        self.metadata = self.metadata | {"autoreset_mode": self.autoreset_mode, "render_fps": round(frames)}
        self.single_observation_space = task.observation_space
        self.single_action_space = task.action_space
        self.observation_space = gymnasium.vector.utils.batch_space(task.observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(task.action_space, num_envs)
        self._randoms = [np.random.default_rng() for _ in range(num_envs)]
        self._done = np.ones(num_envs, dtype=bool)  # who can't go on without a reset
        self._age = np.zeros(num_envs, dtype=np.int64)  # actions of the episode
        self._renderers: list[Any] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Seen, dict[str, Any]]:
        """`seed`: one for all, of which number i gets `seed + i`, or one each. `options["reset_mask"]`: a bool each."""
        chosen = np.ones(self.num_envs, dtype=bool)
        if options is not None and "reset_mask" in options:
            chosen = np.asarray(options["reset_mask"], dtype=bool)
            if chosen.shape != (self.num_envs,):
                raise _core.Error(f"reset_mask has the shape {chosen.shape}; expected ({self.num_envs},)")
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else list(seed)
            if len(seeds) != self.num_envs:
                raise _core.Error(f"found {len(seeds)} seeds; expected {self.num_envs}, one an environment")
            for i, number in enumerate(seeds):
                if number is not None and chosen[i]:
                    self._randoms[i] = np.random.default_rng(number)
        self._begin(chosen)
        return self.task.observe(self.batch), {}

    def step(self, actions: Array) -> tuple[Seen, Array, Bools, Bools, dict[str, Any]]:
        """Of an episode that has ended: with NEXT_STEP the next one begins, whatever the action; with SAME_STEP it has
        begun already, and `infos["final_obs"]` has what was seen last; with DISABLED it must be reset first, else Error.
        """
        given = np.array(actions, dtype=np.float64).reshape(self.action_space.shape)
        begins = self._done.copy()
        if begins.any() and self.autoreset_mode != AutoresetMode.NEXT_STEP:
            raise _core.Error(f"environment {int(np.argmax(begins))} has ended; expected a reset ahead of the next step")
        goes_on = ~begins
        given[begins] = 0  # what is set now would act in their first step
        self._begin(begins)
        self.task.advance(self.batch, given, None if goes_on.all() else goes_on)
        self._age[goes_on] += 1

        rewards, terminated = self.task.judge(self.batch, given)
        broken = np.asarray(self.batch.quarantined()) > 0
        rewards = np.where(goes_on & ~broken, rewards, 0.0)
        terminated = goes_on & (terminated | broken)
        truncated = goes_on & ~terminated & (self._age >= self.task.horizon)
        self._done = terminated | truncated
        infos: dict[str, Any] = {}
        observations = self.task.observe(self.batch)
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._done.any():
            final = np.full(self.num_envs, None, dtype=object)
            for i in np.flatnonzero(self._done):
                final[i] = observations[i]
            infos = {"final_obs": final, "_final_obs": self._done.copy(), "final_info": {}, "_final_info": self._done.copy()}
            self._begin(self._done)
            observations = self.task.observe(self.batch)
        return observations, rewards, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A picture of each world as it is, as render.Renderer takes it by itself; None without a render_mode."""
        if self.render_mode is None:
            return None
        if not self._renderers:
            from ..render import Renderer

            self._renderers = [Renderer(self.batch[place]) for place in range(self.num_envs)]
        return tuple(renderer.render().colour for renderer in self._renderers)

    def _begin(self, chosen: Bools) -> None:
        places = np.flatnonzero(chosen)
        if places.size == 0:
            return
        self.batch.reset(places)
        drawn = np.stack([self.task.draw(self._randoms[i]) for i in places])
        self.task.begin(self.batch, places, drawn)
        self._done[places] = False
        self._age[places] = 0


class SingleEnv(gymnasium.Env[Seen, Array]):
    """One world of a task, as a plain environment."""

    def __init__(self, task: Task, render_mode: str | None = None) -> None:
        self.envs = BatchEnv(task, 1, AutoresetMode.DISABLED, threads=1, render_mode=render_mode)
        self.metadata, self.render_mode = self.envs.metadata, render_mode
        self.observation_space = cast("gymnasium.Space[Seen]", task.observation_space)
        self.action_space = cast("gymnasium.Space[Array]", task.action_space)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Seen, dict[str, Any]]:
        super().reset(seed=seed)
        observations, infos = self.envs.reset(seed=seed)
        return observations[0], infos

    def step(self, action: Array) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        observations, rewards, terminated, truncated, infos = self.envs.step(np.asarray(action)[None])
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), infos

    def render(self) -> NDArray[np.uint8] | None:
        pictures = self.envs.render()
        return None if pictures is None else pictures[0]
