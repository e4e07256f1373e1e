# %% [markdown]
"""
# Reinforcement learning on a cluster, with RLlib's PPO

As a program: `python rl_cluster.py DATA [ITERATIONS] [ADDRESS]`, where DATA is a data folder with
graphs and annotations, for example of model homes, which all machines see, and ADDRESS that of a Ray
cluster (`auto`: the one that this machine is part of; none: this machine alone). Each runner of the
cluster steps 32 agents at once in C++. The agent is told where the goal lies, as in point-goal
navigation, so that a few thousand steps show that it learns.
"""

# %%
import sys

import gymnasium
import numpy as np
import ray
from enfilade.gym import EnvConfig, VlnVectorEnv
from ray.rllib.algorithms.ppo import PPOConfig
from ray.tune.registry import register_env


# %%
class PointGoals(gymnasium.vector.VectorObservationWrapper):
    """For each agent one row of numbers: for each candidate its direction, length, and how much
    nearer to the goal it leads as the crow flies; and how far the goal is."""

    def __init__(self, envs: VlnVectorEnv) -> None:
        super().__init__(envs)
        self.rows = envs.single_observation_space["candidates"].shape[0]
        single = gymnasium.spaces.Box(-10, 10, (self.rows * 5 + 1,), np.float32)
        self.single_observation_space = single
        self.observation_space = gymnasium.vector.utils.batch_space(single, self.num_envs)

    def observations(self, seen: dict) -> np.ndarray:
        arrays, episodes = self.unwrapped.arrays, self.unwrapped.episodes
        mask = seen["candidate_mask"].astype(bool)
        far = np.zeros(mask.shape, np.float32)
        for agent, number in enumerate(arrays["episode"]):
            episode = episodes[int(number)]
            graph = episodes.graphs[episode.scan]
            listed = arrays["candidate_viewpoint"][agent][mask[agent]]
            goal = graph.positions[graph.index(episode.path[-1])]
            far[agent, mask[agent]] = np.linalg.norm(graph.positions[listed] - goal, axis=1)
        right, _, metres = np.moveaxis(seen["candidates"], 2, 0)
        nearer = np.where(mask, far[:, :1] - far, -2)
        table = np.stack([np.sin(right), np.cos(right), metres / 5, nearer / 2, mask], axis=2)
        numbers = np.concatenate([table.reshape(self.num_envs, -1), far[:, :1] / 5], axis=1)
        return numbers.clip(-10, 10).astype(np.float32)


def make(config: dict) -> PointGoals:
    """Called by RLlib in each of its runners."""
    return PointGoals(
        VlnVectorEnv(EnvConfig(config["data"], "train", max_steps=15), config["num_envs"])
    )


# %%
def main(data: str, iterations: int = 8, address: str = "", runners: int = 2) -> None:
    ray.init(address=address or None, log_to_driver=False)
    register_env("point-goals", make)
    config = (
        PPOConfig()
        .environment("point-goals", env_config={"data": data})
        .env_runners(
            num_env_runners=runners,
            num_envs_per_env_runner=32,
            gym_env_vectorize_mode=gymnasium.VectorizeMode.VECTOR_ENTRY_POINT,
        )
        .training(train_batch_size_per_learner=2048, minibatch_size=256, num_epochs=8, lr=1e-3)
        .debugging(seed=1)
    )
    algorithm = config.build_algo()
    rewards = []
    for _ in range(iterations):
        result = algorithm.train()
        rewards.append(result["env_runners"]["episode_return_mean"])
        print(f"mean reward {rewards[-1]:.2f}", flush=True)
    nodes = len([node for node in ray.nodes() if node["Alive"]])
    algorithm.stop()
    ray.shutdown()
    print(
        f"mean reward {rewards[0]:.2f} at first, {rewards[-1]:.2f} after {iterations} iterations, "
        f"{runners} runners on {nodes} machines"
    )
    assert rewards[-1] > rewards[0], "it has not learnt"


# %% tags=["active-py"]
if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 8, *sys.argv[3:4])

# %% tags=["active-ipynb"]
# from enfilade import synth
#
# synth.write_homes("homes", homes=3, face_size=64)  # synthetic
# main("homes")
