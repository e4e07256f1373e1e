# %% [markdown]
"""
# An imitation agent

At each step it scores the candidates by their direction and by what the instruction says, and learns
to choose what the shortest path takes. As a program: `python imitation.py DATA [STEPS]`

DATA is a data folder with graphs and annotations. On a small synthetic data set it learns what can be
learnt there without pictures: which way instructions point, and when to stop.
"""

# %%
import functools
import sys
import time
from typing import Optional

import numpy as np
import torch
from enfilade.gym import EnvConfig, VlnVectorEnv
from torch import nn

BATCH, WORDS, SIZE = 64, 400, 64


@functools.lru_cache(maxsize=None)
def bag_of_words(text: str) -> torch.Tensor:
    """Hashed counts of an instruction's words, (WORDS,)."""
    places = [sum(map(ord, word)) % WORDS for word in text.lower().split()]
    return torch.as_tensor(np.bincount(places, minlength=WORDS), dtype=torch.float32)


class Agent(nn.Module):
    """Scores of the candidates, (n, m); entry 0 stands for stopping."""

    def __init__(self) -> None:
        super().__init__()
        self.text = nn.Sequential(nn.Linear(WORDS, SIZE), nn.Tanh())
        self.way = nn.Sequential(nn.Linear(6, SIZE), nn.Tanh())
        self.score = nn.Sequential(nn.Linear(3 * SIZE + 1, SIZE), nn.ReLU(), nn.Linear(SIZE, 1))
        self.memory = nn.GRUCell(2 * SIZE, SIZE)

    def forward(self, seen: dict, memory: torch.Tensor, step: int) -> tuple:
        ways = torch.as_tensor(seen["candidates"])
        right, up, metres = ways.unbind(-1)
        described = torch.stack(
            [right.sin(), right.cos(), up.sin(), up.cos(), metres / 5, (metres == 0).float()], -1
        )
        ways = self.way(described)
        text = self.text(torch.stack([bag_of_words(text) for text in seen["instruction"]]))
        mask = torch.as_tensor(seen["candidate_mask"]).bool()
        around = (ways * mask[..., None]).sum(1) / mask.sum(1, keepdim=True)
        memory = self.memory(torch.cat([text, around], -1), memory)
        context = torch.cat([text, memory], -1)[:, None].expand(-1, ways.shape[1], -1)
        clock = torch.full_like(metres[..., None], step / 10)
        scores = self.score(torch.cat([ways, context, clock], -1))[..., 0]
        return scores.masked_fill(~mask, -1e9), memory


class Teacher:
    """Which candidate the shortest path to the goal takes."""

    def __init__(self, envs: VlnVectorEnv) -> None:
        self.arrays, self.graphs = envs.arrays, envs.episodes.graphs
        self.goals = [(e.scan, e.path[-1]) for e in envs.episodes]

    @functools.lru_cache(maxsize=None)
    def next_step(self, scan: str, here: int, goal: str) -> Optional[int]:
        graph = self.graphs[scan]
        way = graph.path(graph.viewpoints[here], goal)
        return graph.index(way[1]) if way and len(way) > 1 else None

    def choose(self) -> np.ndarray:
        arrays, chosen = self.arrays, []
        for agent, episode in enumerate(arrays["episode"]):
            scan, goal = self.goals[episode]
            target = self.next_step(scan, int(arrays["viewpoint"][agent]), goal)
            count = int(arrays["candidate_mask"][agent].sum())
            listed = arrays["candidate_viewpoint"][agent][:count].tolist()
            chosen.append(listed.index(target) if target is not None else 0)
        return np.array(chosen)


# %%
def train(agent: Agent, envs: VlnVectorEnv, steps: int) -> None:
    """Teacher forcing: one update a batch of episodes."""
    teacher, best = Teacher(envs), torch.optim.Adam(agent.parameters(), 2e-3)
    for update in range(steps):
        seen, _ = envs.reset()
        memory, losses = torch.zeros(BATCH, SIZE), []
        running = np.ones(BATCH, bool)
        for step in range(8):
            scores, memory = agent(seen, memory, step)
            right = torch.as_tensor(teacher.choose())
            loss = nn.functional.cross_entropy(scores, right, reduction="none")
            losses.append(loss[torch.tensor(running)].mean())
            seen, _, stopped, cut, _ = envs.step(right.numpy())
            running &= ~(stopped | cut)
            if not running.any():
                break
        total = torch.stack(losses).mean()
        best.zero_grad()
        total.backward()
        best.step()
        if update % 50 == 0:
            print(f"update {update}: loss {total.item():.3f}")


def evaluate(agent: Agent, config: EnvConfig) -> float:
    """Share of successes, each agent on its own from start to stop."""
    envs = VlnVectorEnv(config, BATCH, autoreset_mode="SameStep")
    seen, _ = envs.reset(seed=100)
    memory, success, done = torch.zeros(BATCH, SIZE), np.zeros(BATCH), np.zeros(BATCH, bool)
    with torch.no_grad():
        for step in range(config.max_steps):
            scores, memory = agent(seen, memory, step)
            seen, _, stopped, cut, info = envs.step(scores.argmax(-1).numpy())
            ended = (stopped | cut) & ~done
            if ended.any():
                success[ended] = info["final_info"]["success"][ended]
            done |= ended
            if done.all():
                break
    return float(success.mean())


# %%
def main(data: str, steps: int = 300) -> None:
    torch.manual_seed(1)
    torch.set_num_threads(1)  # the network is small
    config = EnvConfig(data, "train", reward="none", max_steps=12)
    envs = VlnVectorEnv(config, BATCH)
    agent = Agent()
    begin, before = time.time(), evaluate(agent, config)
    envs.reset(seed=1)
    train(agent, envs, steps)
    after = evaluate(agent, config)
    print(f"success on train: {before:.2f} before, {after:.2f} after, {time.time() - begin:.0f} s")
    assert after > before, "it has not learnt"


# %% tags=["active-py"]
if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))

# %% tags=["active-ipynb"]
# import enfilade
#
# enfilade.write_small_dataset("small")  # synthetic homes without pictures
# main("small")
