"""Environments of Gymnasium over a batch of worlds: `pip install atoll[gym]`.

    envs = atoll.gym.make("cart-pole", num_envs=256)
    observations, _ = envs.reset(seed=1)
    observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())

What an environment comes to depends on its seed and its actions alone: not on its place among the others, nor on how
many there are, nor on threads. That of number i is seeded with `seed + i`.

Importing this registers each task with Gymnasium, for its make() and make_vec(), by its name, such as
"atoll/cart-pole". Gymnasium's own are also "atoll/HalfCheetah-v0", "atoll/Hopper-v0", "atoll/Walker2d-v0",
"atoll/Ant-v0" and "atoll/Humanoid-v0".
"""

from __future__ import annotations

import gymnasium
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
from ._tasks.locomotion import Ant as Ant
from ._tasks.locomotion import HalfCheetah as HalfCheetah
from ._tasks.locomotion import Hopper as Hopper
from ._tasks.locomotion import Humanoid as Humanoid
from ._tasks.locomotion import Locomotion as Locomotion
from ._tasks.locomotion import Walker2d as Walker2d

TASKS: dict[str, type[Task]] = {
    "cart-pole": CartPole,
    "push-crate": PushCrate,
    "stack-boxes": StackBoxes,
    "half-cheetah": HalfCheetah,
    "hopper": Hopper,
    "walker-2d": Walker2d,
    "ant": Ant,
    "humanoid": Humanoid,
}


def make(
    name: str,
    num_envs: int,
    autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
    threads: int = 0,
    render_mode: str | None = None,
) -> BatchEnv:
    """A task by its name in TASKS in so many worlds. `threads`: 0 for as many as the machine has.

    With the render_mode "rgb_array", render() gives pictures: `pip install atoll[gym,render]`.

    Tasks from "half-cheetah" on read Gymnasium's own models, which takes `pip install atoll[gym,robots]`.
    """
    return BatchEnv(_task(name), num_envs, autoreset_mode, threads, render_mode)


def make_single(name: str, render_mode: str | None = None) -> SingleEnv:
    """A task by its name in TASKS, as a plain environment of one world."""
    return SingleEnv(_task(name), render_mode)


def _task(name: str) -> Task:
    if name not in TASKS:
        raise _core.Error(f"there is no task named {name!r}; expected one of {', '.join(TASKS)}")
    return TASKS[name]()


def _register(as_name: str, name: str) -> None:
    gymnasium.register(
        id=f"atoll/{as_name}",
        entry_point="atoll.gym:make_single",
        vector_entry_point="atoll.gym:make",
        kwargs={"name": name},
    )


for _name, _kind in TASKS.items():
    _register(_name, _name)
    if issubclass(_kind, Locomotion):
        _register(f"{_kind.__name__}-v0", _name)
