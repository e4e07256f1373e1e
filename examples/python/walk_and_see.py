"""Ten lines to walk and see: python walk_and_see.py DATA OUT.npy

DATA: a data folder with pictures (for example what enfilade.synth.write_homes() makes).
"""

import sys

import enfilade
import numpy as np

graphs = enfilade.Graphs(f"{sys.argv[1]}/connectivity")
renderer = enfilade.Renderer(graphs, enfilade.open_panoramas(sys.argv[1], graphs))
sim = enfilade.Simulator(graphs, 4, restricted=False)
sim.new_random_episodes(graphs.scans[:1] * 4)
for _ in range(3):
    sim.step(np.minimum(1, sim.state.navigable_count - 1), heading_changes=[1, 1, -1, -1])
    seen = renderer.render_agents(sim, layers=("depth",))
print(sim.viewpoint_ids(), seen["colour"].shape, f"{seen['depth'].max():.1f} m deep")
np.save(sys.argv[2], seen["colour"])
