"""Data sets of objects: not there."""

from __future__ import annotations

from habitat_sim._missing import refused

_words = "Enfilade has no library of objects; use SimulatorConfiguration to open scenes"

MetadataMediator = refused("habitat_sim.metadata.MetadataMediator", _words)
AttributesManager = refused("habitat_sim.metadata.AttributesManager", _words)
Configuration = refused("habitat_sim._ext.habitat_sim_bindings.Configuration", _words)

__all__ = ["MetadataMediator"]
