"""The drop-in MatterSim under the name of the old simulator's repository, which GridMM imports."""

import MatterSim
from MatterSim import Mat, SimState, Simulator, ViewPoint, cbf

__all__ = ["Mat", "SimState", "Simulator", "ViewPoint", "cbf", "MatterSim"]
