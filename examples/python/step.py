"""Step: two agents walk through a building; each goes forward if something is ahead, else turns."""

import math

import enfilade
import numpy as np

sim = enfilade.Dataset("homes").simulator(batch_size=2)  # homes: made as in render.py
sim.new_random_episodes(["home0001", "home0002"])
for _ in range(12):
    ahead = np.minimum(1, sim.state.navigable_count - 1)
    sim.step(ahead, heading_changes=np.where(ahead, 0, math.radians(30)))
print(sim.viewpoint_ids(), np.degrees(sim.state.heading).round())
