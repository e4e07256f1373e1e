# %% [markdown]
"""
# A panoramic imitation agent

It sees all 36 views of a viewpoint and chooses one of its neighbours, or to stop: attention over the
views, then a score for each candidate (Fried et al. 2018). It learns what the teacher does. As a
program: `python panoramic_imitation.py DATA [STEPS [FEATURES]]`

DATA is a data folder with graphs and annotations. FEATURES is a file with a row for each view, as
`enfilade features` or `extract_features.py` write it; without one, a view is its direction alone.
"""

# %%
import functools
import sys
import time
from typing import Optional

import numpy as np
import torch
from enfilade.features import open_features
from enfilade.gym import EnvConfig, VlnVectorEnv
from torch import nn

BATCH, WORDS, SIZE, MOST_ACTIONS = 64, 400, 64, 12
START = (torch.zeros(BATCH, SIZE), torch.zeros(BATCH, SIZE))  # of the memory


@functools.lru_cache(maxsize=None)
def bag_of_words(text: str) -> torch.Tensor:
    """Hashed counts of an instruction's words, (WORDS,)."""
    places = [sum(map(ord, word)) % WORDS for word in text.lower().split()]
    return torch.as_tensor(np.bincount(places, minlength=WORDS), dtype=torch.float32)


def directions(right: torch.Tensor, up: torch.Tensor) -> torch.Tensor:
    return torch.stack([right.sin(), right.cos(), up.sin(), up.cos()], -1)


class Eyes:
    """What a batch of agents sees: the 36 views, and the candidates by the views that have them."""

    def __init__(self, envs: VlnVectorEnv, features: Optional[str]) -> None:
        self.arrays, self.graphs = envs.arrays, envs.episodes.graphs
        self.features = open_features(features) if features else None
        self.size = 4 + (self.features.dimensions if self.features else 0)
        view = torch.arange(36)
        self.headings = torch.deg2rad(view % 12 * 30.0)
        self.elevations = torch.deg2rad((view // 12 - 1) * 30.0)

    def pictures(self, scan: int, viewpoint: int) -> torch.Tensor:
        name = self.graphs.scans[scan]
        rows = self.features[name, self.graphs[name].viewpoints[viewpoint]]
        return torch.as_tensor(rows)

    def look(self) -> tuple:
        """Views (n, 36, size), candidates (n, m, size), which of them there are (n, m)."""
        heading, elevation, candidates, mask, view = (
            torch.as_tensor(self.arrays[name].astype(np.float32))
            for name in ("heading", "elevation", "candidates", "candidate_mask", "candidate_view")
        )
        right = self.headings - heading[:, None]
        views = directions(right, (self.elevations - elevation[:, None]).expand_as(right))
        ways = directions(candidates[..., 0], candidates[..., 1])
        if self.features:
            where = zip(self.arrays["scan"].tolist(), self.arrays["viewpoint"].tolist())
            pictures = torch.stack([self.pictures(*place) for place in where])
            of = view.long()[..., None].expand(-1, -1, pictures.shape[-1])
            views = torch.cat([views, pictures], -1)
            ways = torch.cat([ways, pictures.gather(1, of)], -1)
        return views, ways, mask.bool()


class Agent(nn.Module):
    """Scores of the actions, (n, m): row 0 is to stop."""

    def __init__(self, size: int) -> None:
        super().__init__()
        self.text = nn.Sequential(nn.Linear(WORDS, SIZE), nn.Tanh())
        self.query = nn.Linear(SIZE, size, bias=False)
        self.memory = nn.LSTMCell(size + SIZE, SIZE)
        self.way = nn.Sequential(nn.Linear(size, SIZE), nn.Tanh())
        self.stop = nn.Parameter(torch.zeros(SIZE))
        self.choice = nn.Sequential(nn.Linear(2 * SIZE + 1, SIZE), nn.ReLU(), nn.Linear(SIZE, SIZE))

    def forward(self, texts: tuple, seen: tuple, memory: tuple, step: int) -> tuple:
        views, ways, there = seen
        text = self.text(torch.stack([bag_of_words(text) for text in texts]))
        weights = torch.einsum("nvd,nd->nv", views, self.query(memory[0])).softmax(-1)
        attended = torch.einsum("nv,nvd->nd", weights, views)
        memory = self.memory(torch.cat([attended, text], -1), memory)
        keys = self.way(ways)
        keys = torch.cat([self.stop.expand(len(keys), 1, -1), keys[:, 1:]], 1)
        clock = torch.full((len(keys), 1), step / 10)
        wanted = self.choice(torch.cat([memory[0], text, clock], -1))
        return torch.einsum("nmd,nd->nm", keys, wanted).masked_fill(~there, -1e9), memory


# %%
def train(agent: Agent, envs: VlnVectorEnv, eyes: Eyes, steps: int) -> None:
    """Teacher forcing: one update a batch of episodes."""
    best = torch.optim.Adam(agent.parameters(), 2e-3)
    for update in range(steps):
        seen, _ = envs.reset()
        memory, losses, running = START, [], np.ones(BATCH, bool)
        for step in range(8):
            scores, memory = agent(seen["instruction"], eyes.look(), memory, step)
            right = torch.tensor([envs.expert(k) or 0 for k in range(BATCH)])
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


def evaluate(agent: Agent, envs: VlnVectorEnv, eyes: Eyes) -> float:
    """Share of successes, each agent on its own from start to stop."""
    seen, _ = envs.reset(seed=100)
    memory, success, done = START, np.zeros(BATCH), np.zeros(BATCH, bool)
    with torch.no_grad():
        for step in range(MOST_ACTIONS):
            scores, memory = agent(seen["instruction"], eyes.look(), memory, step)
            seen, _, stopped, cut, info = envs.step(scores.argmax(-1).numpy())
            ended = (stopped | cut) & ~done
            success[ended] = info["success"][ended] if ended.any() else 0
            done |= ended
    return float(success.mean())


# %%
def main(data: str, steps: int = 300, features: Optional[str] = None) -> None:
    torch.manual_seed(1)
    torch.set_num_threads(1)  # the network is small
    config = EnvConfig(data, "train", actions="panoramic", reward="none", max_steps=MOST_ACTIONS)
    envs = VlnVectorEnv(config, BATCH)
    eyes = Eyes(envs, features)
    agent = Agent(eyes.size)
    begin, before = time.time(), evaluate(agent, envs, eyes)
    train(agent, envs, eyes, steps)
    after = evaluate(agent, envs, eyes)
    print(f"success on train: {before:.2f} before, {after:.2f} after, {time.time() - begin:.0f} s")
    assert after > before, "it has not learnt"


# %% tags=["active-py"]
if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:3]), *sys.argv[3:4])

# %% tags=["active-ipynb"]
# import enfilade
#
# enfilade.write_small_dataset("small")  # synthetic homes without pictures
# main("small")
