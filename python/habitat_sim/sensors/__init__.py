"""Noise of sensors."""

from __future__ import annotations

from habitat_sim.sensors import noise_models

__all__ = ["noise_models"]
