"""Noise of sensors: there is only "None", which changes nothing."""

from __future__ import annotations

from habitat_sim._missing import refused

_words = "Enfilade's sensors have no noise; use noise_model 'None'"

make_sensor_noise_model = refused("habitat_sim.sensors.noise_models.make_sensor_noise_model", _words)
SensorNoiseModel = refused("habitat_sim.sensors.noise_models.SensorNoiseModel", _words)

__all__ = ["SensorNoiseModel", "make_sensor_noise_model"]
