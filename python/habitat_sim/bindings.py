"""All that is C++ in Habitat, under one name."""

from __future__ import annotations

from habitat_sim._ext.habitat_sim_bindings import *  # noqa: F403
