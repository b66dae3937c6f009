"""Environments of Gymnasium over a batch of worlds: `pip install atoll[gym]`.

    envs = atoll.gym.make("cart-pole", num_envs=256)
    observations, _ = envs.reset(seed=1)
    observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())

What an environment comes to depends on its seed and its actions alone: not on its place among the others, nor on how
many there are, nor on threads. That of number i is seeded with `seed + i`.
"""

from __future__ import annotations

from gymnasium.vector import AutoresetMode as AutoresetMode

from . import _core
from ._tasks.built_in import CartPole as CartPole
from ._tasks.built_in import PushCrate as PushCrate
from ._tasks.built_in import StackBoxes as StackBoxes
from ._tasks.environments import Array as Array
from ._tasks.environments import BatchEnv as BatchEnv
from ._tasks.environments import Bools as Bools
from ._tasks.environments import Seen as Seen
from ._tasks.environments import SingleEnv as SingleEnv
from ._tasks.environments import Task as Task

TASKS: dict[str, type[Task]] = {
    "cart-pole": CartPole,
    "push-crate": PushCrate,
    "stack-boxes": StackBoxes,
}


def make(
    name: str, num_envs: int, autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP, threads: int = 0
) -> BatchEnv:
    """A task by its name in TASKS in so many worlds. `threads`: 0 for as many as the machine has."""
    return BatchEnv(_task(name), num_envs, autoreset_mode, threads)


def _task(name: str) -> Task:
    if name not in TASKS:
        raise _core.Error(f"there is no task named {name!r}; expected one of {', '.join(TASKS)}")
    return TASKS[name]()
