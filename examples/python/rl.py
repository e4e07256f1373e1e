# %% [markdown]
"""
# Reinforcement learning in homes, with Stable-Baselines3's PPO

As a program: `python rl.py DATA [STEPS]`, where DATA is a data folder with graphs and annotations, for
example of model homes. The agent is told where the goal lies, as in point-goal navigation, so that a
few thousand steps show that it learns.
"""

# %%
import sys

import gymnasium
import numpy as np
from enfilade.gym import EnvConfig, VlnEnv
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor


# %%
class PointGoal(gymnasium.ObservationWrapper):
    """One row of numbers: for each candidate its direction, length, and how much nearer to the goal
    it leads as the crow flies; and how far the goal is."""

    def __init__(self, env: VlnEnv) -> None:
        super().__init__(env)
        self.rows = env.observation_space["candidates"].shape[0]
        self.observation_space = gymnasium.spaces.Box(-10, 10, (self.rows * 5 + 1,), np.float32)

    def observation(self, seen: dict) -> np.ndarray:
        arrays, episodes = self.unwrapped.arrays, self.unwrapped.episodes
        episode = episodes[int(arrays["episode"][0])]
        graph = episodes.graphs[episode.scan]
        positions = graph.positions
        goal = positions[graph.index(episode.path[-1])]
        mask = seen["candidate_mask"].astype(bool)
        right, _, metres = seen["candidates"].T
        listed = arrays["candidate_viewpoint"][0][mask]
        far = np.zeros(self.rows, np.float32)
        far[mask] = np.linalg.norm(positions[listed] - goal, axis=1)
        nearer = np.where(mask, far[0] - far, -2)
        table = np.stack([np.sin(right), np.cos(right), metres / 5, nearer / 2, mask])
        return np.append(table.ravel(), far[0] / 5).clip(-10, 10).astype(np.float32)


# %%
def main(data: str, steps: int = 12_000) -> None:
    config = EnvConfig(data, "train", max_steps=15)

    def make() -> gymnasium.Env:
        return Monitor(PointGoal(VlnEnv(config)))

    model = PPO("MlpPolicy", make(), n_steps=512, batch_size=128, learning_rate=1e-3, seed=1)
    before, _ = evaluate_policy(model, make(), n_eval_episodes=60)
    model.learn(steps)
    after, _ = evaluate_policy(model, make(), n_eval_episodes=60)
    print(f"mean reward {before:.2f} before, {after:.2f} after {steps} steps")
    assert after > before, "it has not learnt"


# %% tags=["active-py"]
if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))

# %% tags=["active-ipynb"]
# from enfilade import synth
#
# synth.write_homes("homes", homes=3, face_size=64)  # synthetic
# main("homes")
