"""Noise of sensors: models by name, whose parameters are `noise_model_kwargs`.

Random numbers are those of numpy's global generator: numpy.random.seed() repeats them.
"""

from __future__ import annotations

import abc
import inspect
import math
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from habitat_sim._missing import refused
from habitat_sim.registry import registry
from habitat_sim.sensor import SensorSpec, SensorType

__all__ = [
    "GaussianNoiseModel", "NoSensorNoiseModel", "PoissonNoiseModel", "RedwoodDepthNoiseModel",
    "SaltAndPepperNoiseModel", "SensorNoiseModel", "SpeckleNoiseModel", "make_sensor_noise_model",
]  # fmt: skip


class SensorNoiseModel(abc.ABC):
    """The base of noise models. registry.register_noise_model() makes a subclass known by its name."""

    gpu_device_id: Optional[int] = None

    @staticmethod
    @abc.abstractmethod
    def is_valid_sensor_type(sensor_type: SensorType) -> bool:
        """Whether the model is for sensors of this type."""

    @abc.abstractmethod
    def apply(self, sensor_observation: Any) -> Any:
        """The picture with noise. What is given stays as it is."""

    def __call__(self, sensor_observation: Any) -> Any:
        return self.apply(sensor_observation)


def _number(name: str, value: Any, low: float = -math.inf, high: float = math.inf) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} {value!r}: a number is wanted")
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"{name} {value!r}: a finite number in [{low}, {high}] is wanted")
    return float(value)


class NoSensorNoiseModel(SensorNoiseModel):
    """No noise: pictures are copied. Its name is "None"."""

    def __init__(self, *, gpu_device_id: Optional[int] = None) -> None:
        self.gpu_device_id = gpu_device_id

    @staticmethod
    def is_valid_sensor_type(sensor_type: SensorType) -> bool:
        return True

    def apply(self, sensor_observation: Any) -> Any:
        return sensor_observation.copy()


class _ColourNoise(SensorNoiseModel):
    """Noise of all four channels, alpha too, as in Habitat."""

    @staticmethod
    def is_valid_sensor_type(sensor_type: SensorType) -> bool:
        return sensor_type == SensorType.COLOR

    @abc.abstractmethod
    def simulate(self, image: NDArray[Any]) -> NDArray[Any]:
        """The picture, uint8, with noise."""

    def apply(self, sensor_observation: Any) -> Any:
        return self.simulate(sensor_observation)


def _bytes(shares: NDArray[Any]) -> NDArray[Any]:
    """Shares of full light as bytes, rounded down."""
    made: NDArray[Any] = (np.clip(shares, 0, 1) * 255).astype(np.uint8)
    return made


class GaussianNoiseModel(_ColourNoise):
    """Adds normal noise, times the constant, to each value as a share of full light."""

    def __init__(
        self, *, intensity_constant: float = 0.2, mean: float = 0, sigma: float = 1,
        gpu_device_id: Optional[int] = None,
    ) -> None:  # fmt: skip
        self.gpu_device_id = gpu_device_id
        self.intensity_constant = _number("intensity_constant", intensity_constant)
        self.mean, self.sigma = _number("mean", mean), _number("sigma", sigma, 0)

    def simulate(self, image: NDArray[Any]) -> NDArray[Any]:
        noise = np.random.normal(self.mean, self.sigma, image.shape)
        return _bytes(image / 255 + noise * self.intensity_constant)


class SpeckleNoiseModel(GaussianNoiseModel):
    """Adds normal noise, times the constant, as a share of each value."""

    def simulate(self, image: NDArray[Any]) -> NDArray[Any]:
        shares = image / 255
        noise = np.random.normal(self.mean, self.sigma, image.shape)
        return _bytes(shares + shares * noise * self.intensity_constant)


class PoissonNoiseModel(_ColourNoise):
    """Counts photons: as many for full light as the picture has values, rounded up to a power of 2."""

    def __init__(self, *, gpu_device_id: Optional[int] = None) -> None:
        self.gpu_device_id = gpu_device_id

    def simulate(self, image: NDArray[Any]) -> NDArray[Any]:
        most = 2 ** math.ceil(math.log2(len(np.unique(image))))
        return _bytes(np.random.poisson(image / 255 * most) / most)


class SaltAndPepperNoiseModel(_ColourNoise):
    """Sets values at random to 1 (a share `s_vs_p` of them) or to 0; `amount` is their share of all values.

    As in Habitat, salt is the byte 1, not 255, and the last row, column and channel keep their values.
    """

    def __init__(
        self, *, s_vs_p: float = 0.5, amount: float = 0.05, gpu_device_id: Optional[int] = None
    ) -> None:
        self.gpu_device_id = gpu_device_id
        self.s_vs_p, self.amount = _number("s_vs_p", s_vs_p, 0, 1), _number("amount", amount, 0, 1)

    def simulate(self, image: NDArray[Any]) -> NDArray[Any]:
        noisy = image.copy()
        for value, share in ((1, self.s_vs_p), (0, 1 - self.s_vs_p)):
            count = math.ceil(self.amount * image.size * share)
            noisy[tuple(np.random.randint(0, max(size - 1, 1), count) for size in image.shape)] = value
        return noisy


RedwoodDepthNoiseModel = refused(
    "habitat_sim.sensors.noise_models.RedwoodDepthNoiseModel",
    "Enfilade does not have the model's table of a depth camera; use noise_model 'None'",
)

for _model in (GaussianNoiseModel, PoissonNoiseModel, SaltAndPepperNoiseModel, SpeckleNoiseModel):
    registry.register_noise_model(_model)
registry.register_noise_model(NoSensorNoiseModel, name="None")


def make_sensor_noise_model(name: str, kwargs: dict[str, Any]) -> Any:
    """A noise model by its name, with these parameters.

    Raises NotImplementedError for what Enfilade does not have, ValueError for an unknown name.
    """
    if name == "RedwoodDepthNoiseModel":
        RedwoodDepthNoiseModel()
    model = registry.get_noise_model(name)
    if model is None:
        raise ValueError(f"noise_model '{name}': one of {', '.join(registry._names())} is wanted")
    return model(**kwargs)


def noise_of(spec: SensorSpec) -> Any:
    """The noise model of a sensor; None for a sensor without noise."""
    kwargs = dict(spec.noise_model_kwargs)
    if spec.noise_model == "None" and not kwargs:
        return None
    model = registry.get_noise_model(spec.noise_model)
    if model is not None and "gpu_device_id" in inspect.signature(model).parameters:
        kwargs.setdefault("gpu_device_id", -1)  # Habitat gives it to all
    try:
        made = make_sensor_noise_model(spec.noise_model, kwargs)
    except (TypeError, ValueError) as error:
        raise type(error)(f"noise of sensor '{spec.uuid}': {error}") from None
    if not made.is_valid_sensor_type(spec.sensor_type):
        raise ValueError(
            f"noise_model of '{spec.uuid}': {spec.noise_model} is not for {spec.sensor_type}"
        )
    return made
