# %% [markdown]
"""
# Ten lines to walk and see

As a program: `python walk_and_see.py DATA OUT.npy`, where DATA is a data folder with pictures.
"""

# %%
import enfilade
import numpy as np

# %% tags=["active-py"]
import sys

data = sys.argv[1]

# %% tags=["active-ipynb"]
# from enfilade import synth
#
# data = "homes"  # synthetic: three model homes, made here in less than a minute
# synth.write_homes(data, homes=3, face_size=64)

# %%
d = enfilade.Dataset(data)
renderer = d.renderer()
sim = d.simulator(4, restricted=False)
sim.new_random_episodes(d.graphs.scans[:1] * 4)
for _ in range(3):
    sim.step(np.minimum(1, sim.state.navigable_count - 1), heading_changes=[1, 1, -1, -1])
    seen = renderer.render_agents(sim, layers=("depth",))
print(sim.viewpoint_ids(), seen["rgb"].shape, f"{seen['depth'].max():.1f} m deep")

# %% tags=["active-py"]
np.save(sys.argv[2], seen["rgb"])

# %% tags=["active-ipynb"]
# from PIL import Image
#
# Image.fromarray(np.hstack(seen["rgb"])).resize((1280, 240))
