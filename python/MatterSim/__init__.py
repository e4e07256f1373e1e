"""A drop-in for the module of Matterport3DSimulator: the API of v0.2 and of v0.1, headless.

See docs/python_mattersim.md for what differs, and for ENFILADE_MATTERSIM, the environment variable
that brings old defects back where results depend on them.
"""

from enfilade._core.mattersim import Mat, SimState, Simulator, ViewPoint, cbf

__all__ = ["Mat", "SimState", "Simulator", "ViewPoint", "cbf"]
