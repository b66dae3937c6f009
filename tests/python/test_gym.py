"""Environments: Gymnasium's own checks, physics, modes of starting over, and the same bits wherever a world is."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

import atoll
import atoll.gym
from atoll.gym import TASKS, AutoresetMode, SingleEnv, make

Floats = NDArray[np.float64]


def actions_of(name: str, numbers: list[int], steps: int) -> Floats:
    """Those of an environment follow from its number."""
    shape = TASKS[name]().action_space.shape
    assert shape is not None
    return np.stack([np.random.default_rng(number).uniform(-1, 1, (steps, *shape)) for number in numbers], axis=1)


@pytest.mark.parametrize("name", TASKS)
def test_gymnasium_finds_nothing_wrong(name: str) -> None:
    with pytest.warns(UserWarning):  # of bounds that are infinite
        check_env(SingleEnv(TASKS[name]()), skip_render_check=True)


@pytest.mark.parametrize("name", TASKS)
def test_place_number_and_threads_do_not_show(name: str) -> None:
    steps = 60 if TASKS[name].horizon < 1000 else 20  # robots take long

    def run(numbers: list[int], threads: int, mode: AutoresetMode) -> dict[int, list[Any]]:
        envs = make(name, len(numbers), mode, threads)
        seen: dict[int, list[Any]] = {number: [] for number in numbers}
        observations, _ = envs.reset(seed=numbers)
        actions = actions_of(name, numbers, steps)
        for step in range(steps):
            for i, number in enumerate(numbers):
                seen[number].append((observations[i].tobytes(), int(envs.batch.hashes()[i])))
            observations, rewards, ended, truncated, _ = envs.step(actions[step])
            for i, number in enumerate(numbers):
                seen[number].append((rewards[i], ended[i], truncated[i]))
        return seen

    for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
        expected = run(list(range(7)), 1, mode)
        for numbers, threads in (([3], 1), ([6, 2, 0, 5, 1, 4, 3], 2), ([2, 4], 3), (list(range(20)), 2)):
            found = run(numbers, threads, mode)
            for number in set(numbers) & set(expected):
                assert found[number] == expected[number]


def test_the_pole_falls_as_the_equations_say() -> None:
    envs = make("cart-pole", 4, AutoresetMode.DISABLED)
    observations, _ = envs.reset(seed=5)
    force = np.array([-3.0, -1, 0, 2])
    # Barto, Sutton and Anderson (1983), without friction; the pole is a rod of half its length.
    total, pole, half, g = 1.1, 0.1, 0.5, 9.81
    x, speed, angle, rate = observations.astype(np.float64).T
    fine = 200
    for _ in range(12):
        observations, *_ = envs.step((force / 10)[:, None])
        for _ in range(fine):
            h = 0.02 / fine
            push = (force + pole * half * rate**2 * np.sin(angle)) / total
            turns = (g * np.sin(angle) - np.cos(angle) * push) / (half * (4 / 3 - pole * np.cos(angle) ** 2 / total))
            moves = push - pole * half * turns * np.cos(angle) / total
            speed, rate = speed + h * moves, rate + h * turns
            x, angle = x + h * speed, angle + h * rate
        assert observations == pytest.approx(np.stack([x, speed, angle, rate], axis=-1), abs=4e-3)


def test_a_controller_balances_until_the_end() -> None:
    envs = make("cart-pole", 16, AutoresetMode.SAME_STEP)
    observations, _ = envs.reset(seed=0)
    for step in range(500):
        push = observations @ np.array([0.2, 0.35, 3.5, 0.8])
        observations, rewards, ended, truncated, infos = envs.step(np.tanh(push)[:, None])
        assert not ended.any() and np.all(rewards == 1)
        assert truncated.all() == (step == 499)
    assert infos["_final_obs"].all() and np.abs(observations).max() <= 0.05


def test_a_crate_is_pushed_to_its_mark() -> None:
    envs = make("push-crate", 32, AutoresetMode.DISABLED)
    observations, _ = envs.reset(seed=3)
    worth = np.zeros(32)
    there = np.zeros(32, dtype=bool)
    for _ in range(200):
        to_crate, to_mark = observations[:, :2], observations[:, 2:4]
        along = to_mark / np.linalg.norm(to_mark, axis=1, keepdims=True)
        behind = to_crate - 0.42 * along
        side = along[:, ::-1] * [-1, 1] * np.sign(np.cross(along, to_crate))[:, None]
        ready = np.linalg.norm(behind, axis=1) < 0.12
        ahead = np.sum(along * to_crate, axis=1) < 0.1  # it stands on the wrong side
        wanted = np.where(ahead[:, None], behind - 0.8 * side, behind)
        wanted = np.where(ready[:, None] | (np.sum(along * to_crate, axis=1) > 0.3)[:, None], along + 2 * behind, wanted)
        observations, rewards, ended, truncated, _ = envs.step(np.clip(3 * wanted, -1, 1))
        worth += rewards
        there |= ended
        if (ended | truncated).any():
            envs.reset(options={"reset_mask": ended | truncated})
    assert there.mean() > 0.3 and worth.mean() > 0.3


def test_boxes_are_stacked_by_a_script() -> None:
    envs = make("stack-boxes", 16, AutoresetMode.DISABLED)
    observations, _ = envs.reset(seed=7)
    # Over the box, down, grip, up, over its place, down, let go and rise.
    phase, waited, done = np.zeros(16, dtype=int), np.zeros(16, dtype=int), np.zeros(16, dtype=bool)
    for _ in range(envs.task.horizon):
        height, to_box, to_place = observations[:, 1], observations[:, 3:5], observations[:, 5:7]
        still = 0 * height
        across = [to_box[:, 0], to_box[:, 0], still, still, to_place[:, 0], to_place[:, 0]]
        along_z = [0.3 - height, to_box[:, 1], still, 0.3 - height, still, to_place[:, 1] + 0.002]
        wanted = np.stack(
            [
                np.select([phase == i for i in range(6)], across, 0),
                np.select([phase == i for i in range(6)], along_z, 0.3 - height),
            ],
            axis=1,
        )
        grip = np.where((phase >= 2) & (phase <= 5), -1, 1)
        waited = np.where(np.abs(wanted).max(axis=1) < 0.01, waited + 1, 0)
        phase = np.where((waited > 6) & (phase < 6), phase + 1, phase)
        waited[waited > 6] = 0
        actions = np.column_stack([np.clip(12 * wanted, -1, 1), grip])
        observations, _, ended, truncated, _ = envs.step(actions)
        done |= ended
        if done.all():
            break
        if (ended | truncated).any():
            envs.reset(options={"reset_mask": ended | truncated})
    assert done.mean() > 0.8


def test_modes_start_over_when_they_say() -> None:
    push = np.ones((3, 1))
    runs = {mode: make("cart-pole", 3, mode) for mode in AutoresetMode}
    first = {mode: envs.reset(seed=[1, 2, 3])[0] for mode, envs in runs.items()}
    ends = 0
    last: dict[AutoresetMode, Any] = {}
    while not ends:
        last = {mode: envs.step(push) for mode, envs in runs.items()}
        ends = int(last[AutoresetMode.DISABLED][2].sum())
        for mode in AutoresetMode:
            assert np.array_equal(last[mode][2], last[AutoresetMode.DISABLED][2])
            assert np.array_equal(last[mode][1], last[AutoresetMode.DISABLED][1])
    ended = last[AutoresetMode.DISABLED][2]
    at_end = last[AutoresetMode.DISABLED][0]
    assert np.array_equal(last[AutoresetMode.NEXT_STEP][0], at_end)
    same, infos = last[AutoresetMode.SAME_STEP][0], last[AutoresetMode.SAME_STEP][4]
    assert np.array_equal(np.stack(infos["final_obs"][ended]), at_end[ended])
    assert np.abs(same[ended]).max() <= 0.05 and np.array_equal(same[~ended], at_end[~ended])

    with pytest.raises(atoll.Error, match="has ended; expected a reset"):
        runs[AutoresetMode.DISABLED].step(push)
    observations, rewards, again, _, _ = runs[AutoresetMode.NEXT_STEP].step(push)
    assert np.array_equal(observations[ended], same[ended]) and np.all(rewards[ended] == 0) and not again[ended].any()
    observations, _ = runs[AutoresetMode.DISABLED].reset(options={"reset_mask": ended})
    assert np.array_equal(observations[ended], same[ended]) and np.array_equal(observations[~ended], at_end[~ended])
    assert np.array_equal(runs[AutoresetMode.DISABLED].reset(seed=[1, 2, 3])[0], first[AutoresetMode.DISABLED])


def test_gymnasium_makes_tasks_by_name() -> None:
    actions = actions_of("cart-pole", [0, 1, 2], 20)
    alone = gymnasium.make("atoll/cart-pole")
    together, ours = gymnasium.make_vec("atoll/cart-pole", num_envs=3), make("cart-pole", 3)
    assert np.array_equal(alone.reset(seed=4)[0], ours.reset(seed=4)[0][0])
    assert np.array_equal(together.reset(seed=4)[0], ours.reset(seed=4)[0])
    for action in actions:
        expected = ours.step(action)[0]
        assert np.array_equal(together.step(action)[0], expected)
        assert np.array_equal(alone.step(action[0])[0], expected[0])


def test_what_is_wrong_is_told() -> None:
    with pytest.raises(atoll.Error, match="no task named 'juggle'; expected one of cart-pole, push-crate, stack-boxes"):
        make("juggle", 2)
    envs = make("cart-pole", 2, AutoresetMode.DISABLED)
    with pytest.raises(atoll.Error, match="expected a reset"):
        envs.step(np.zeros((2, 1)))
    with pytest.raises(atoll.Error, match="found 3 seeds; expected 2"):
        envs.reset(seed=[1, 2, 3])
    with pytest.raises(atoll.Error, match="reset_mask has the shape"):
        envs.reset(options={"reset_mask": [True]})
