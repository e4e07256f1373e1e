"""A drop-in for the module of Matterport3DSimulator: the API of v0.2 and of v0.1, headless.

Differences: docs/python_mattersim.md, also for the environment variable ENFILADE_MATTERSIM, which restores
old defects for results that depend on them.
"""

from enfilade._core.mattersim import Mat, SimState, Simulator, ViewPoint, cbf

__all__ = ["Mat", "SimState", "Simulator", "ViewPoint", "cbf"]
