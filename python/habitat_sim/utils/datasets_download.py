"""Downloads: not there. habitat-lab 0.2 imports the module."""

from __future__ import annotations

from habitat_sim._missing import refused

main = refused(
    "habitat_sim.utils.datasets_download.main",
    "Enfilade downloads no data sets; `enfilade homes --parts habitat` makes one",
)

__all__ = ["main"]
