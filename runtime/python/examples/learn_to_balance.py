"""Learns to balance a pole on a cart: the cross-entropy method over linear policies, 256 worlds at once."""

import numpy as np

import atoll.gym

ENVS, ELITE, HORIZON = 256, 32, 200
envs = atoll.gym.make("cart-pole", ENVS, atoll.gym.AutoresetMode.DISABLED)
random = np.random.default_rng(0)
mean, spread = np.zeros(4), np.full(4, 2.0)

for generation in range(12):
    policies = random.normal(mean, spread, (ENVS, 4))
    observations, infos = envs.reset(seed=1000 * generation)
    lengths = np.zeros(ENVS)
    alive = np.ones(ENVS, dtype=bool)
    for step in range(HORIZON):
        actions = np.tanh((policies * observations).sum(axis=1, keepdims=True))
        observations, rewards, ended, truncated, infos = envs.step(actions)
        lengths += rewards * alive
        alive &= ~ended
        if ended.any():  # they wait, anew, until all others are through
            envs.reset(options={"reset_mask": ended})
        if not alive.any():
            break
    best = policies[np.argsort(-lengths, kind="stable")[:ELITE]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
    print(f"generation {generation:2}: {lengths.mean():5.1f} steps in the mean, {lengths.max():3.0f} at best")
    if lengths.mean() > 0.95 * HORIZON:
        break
print(f"learned: {mean.round(2)}" if lengths.mean() > 0.9 * HORIZON else "it didn't learn")
