"""Noise models by name: Habitat's, and what programs add."""

from __future__ import annotations

from typing import Any, Callable, Optional, Union

from habitat_sim._missing import RefusedAttribute

__all__ = ["registry"]


class _Registry:
    _models: dict[str, Any] = {}

    register_move_fn = RefusedAttribute("Enfilade has Habitat's own motions only; use them")
    get_move_fn = RefusedAttribute("Enfilade has Habitat's own motions only; use them")

    def register_noise_model(
        self, noise_model: Optional[type] = None, *, name: Optional[str] = None
    ) -> Union[type, Callable[[type], type]]:
        """Adds a class of noise; without one, a decorator that adds it. Its name is the class's, or `name`."""
        from habitat_sim.sensors.noise_models import SensorNoiseModel

        def add(model: type) -> type:
            if not (isinstance(model, type) and issubclass(model, SensorNoiseModel)):
                raise TypeError(f"noise_model {model!r}: a subclass of SensorNoiseModel is wanted")
            self._models[model.__name__ if name is None else name] = model
            return model

        return add if noise_model is None else add(noise_model)

    def get_noise_model(self, name: str) -> Any:
        """The class of that name; None for an unknown one."""
        return self._models.get(name)

    def _names(self) -> list[str]:
        return sorted(self._models)


registry = _Registry()
