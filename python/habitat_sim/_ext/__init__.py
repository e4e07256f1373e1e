"""Where Habitat has its extension module."""

from __future__ import annotations

from habitat_sim._ext import habitat_sim_bindings

__all__ = ["habitat_sim_bindings"]
