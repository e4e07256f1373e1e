# %% [markdown]
"""
# From the old simulator to the new API

As a program: `python port.py DATA`

The same walk from every viewpoint of a scan, as old code has it (under the drop-in `MatterSim`), and
natively, with three agents at once.
"""

# %%
import math
import sys

import enfilade
import MatterSim

WALK = [(1, 0.0), (0, 1.0), (0, 1.0), (1, 0.0), (0, -1.0)]  # (wish, turn)


# %%
def old(connectivity: str, scan: str, start: str) -> list[str]:
    sim = MatterSim.Simulator()
    sim.setRenderingEnabled(False)
    sim.setDiscretizedViewingAngles(True)
    sim.setCameraResolution(640, 480)
    sim.setCameraVFOV(math.radians(60))
    sim.setNavGraphPath(connectivity)
    sim.initialize()
    sim.newEpisode([scan], [start], [0], [0])
    places = []
    for wish, turn in WALK:
        state = sim.getState()[0]
        index = min(wish, len(state.navigableLocations) - 1)
        sim.makeAction([index], [turn], [0])
        places.append(sim.getState()[0].location.viewpointId)
    return places


# %%
def new(connectivity: str, scan: str, start: str, agents: int) -> list[list[str]]:
    sim = enfilade.Simulator(enfilade.Graphs(connectivity), agents)  # Room-to-Room's camera
    state = sim.new_episodes([scan] * agents, [start] * agents)
    places = []
    for wish, turn in WALK:
        sim.step((state.navigable_count - 1).clip(0, wish), [turn] * agents)
        places.append(sim.viewpoint_ids())
    return places


# %%
def main(data: str) -> None:
    connectivity = f"{data}/connectivity"
    graphs = enfilade.Graphs(connectivity)
    scan = graphs.scans[0]
    graph = graphs[scan]
    for start in filter(graph.included, graph.viewpoints):
        before, after = old(connectivity, scan, start), new(connectivity, scan, start, 3)
        assert all(place == [name] * 3 for name, place in zip(before, after))
    print(f"the same places from every viewpoint of {scan}")


# %% tags=["active-py"]
if __name__ == "__main__":
    main(sys.argv[1])

# %% tags=["active-ipynb"]
# enfilade.write_small_dataset("small")  # synthetic homes without pictures
# main("small")
