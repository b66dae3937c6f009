"""Learns to hop: augmented random search (Mania, Guy and Recht, 2018) over linear policies, 128 worlds at once."""

import numpy as np

import atoll.gym

DIRECTIONS, BEST, HORIZON, NOISE, RATE = 64, 16, 300, 0.05, 0.03
envs = atoll.gym.make("hopper", 2 * DIRECTIONS, atoll.gym.AutoresetMode.DISABLED)
random = np.random.default_rng(0)
policy = np.zeros((3, 11))
centre, spread = np.zeros(11), np.ones(11)  # of what was seen so far


def returns_of(policies: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Of one episode each, and all that was seen in them."""
    observations, _ = envs.reset(seed=[seed + number % DIRECTIONS for number in range(2 * DIRECTIONS)])
    total, alive, seen = np.zeros(2 * DIRECTIONS), np.ones(2 * DIRECTIONS, dtype=bool), []
    for _ in range(HORIZON):
        seen.append(observations[alive])
        actions = np.einsum("nij,nj->ni", policies, (observations - centre) / spread)
        observations, rewards, ended, _, _ = envs.step(np.clip(actions, -1, 1))
        total += rewards * alive
        alive &= ~ended
        if not alive.any():
            break
        envs.reset(options={"reset_mask": ended})  # they wait for the others
    return total, np.concatenate(seen)


for generation in range(30):
    directions = random.normal(size=(DIRECTIONS, 3, 11))
    total, seen = returns_of(policy + NOISE * np.concatenate([directions, -directions]), 1000 * generation)
    up, down = total[:DIRECTIONS], total[DIRECTIONS:]
    best = np.argsort(-np.maximum(up, down), kind="stable")[:BEST]
    step = np.einsum("n,nij->ij", up[best] - down[best], directions[best])
    policy += RATE / (BEST * np.concatenate([up[best], down[best]]).std() + 1e-9) * step
    centre, spread = 0.9 * centre + 0.1 * seen.mean(axis=0), 0.9 * spread + 0.1 * seen.std(axis=0)
    print(f"generation {generation:2}: a return of {total.mean():3.0f} in the mean, {total.max():3.0f} at best")
    if total.mean() > 250:
        break
print("it hops" if total.mean() > 250 else "it didn't learn")
