"""The drop-in MatterSim by the name of the old simulator's repository, as GridMM imports it."""

import MatterSim
from MatterSim import Mat, SimState, Simulator, ViewPoint, cbf

__all__ = ["Mat", "SimState", "Simulator", "ViewPoint", "cbf", "MatterSim"]
