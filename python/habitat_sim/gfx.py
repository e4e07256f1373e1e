"""Drawing: keys of lights; the rest is not there."""

from __future__ import annotations

from habitat_sim._missing import DRAWING, RECORDS, refused

DEFAULT_LIGHTING_KEY = ""
NO_LIGHT_KEY = "no_lights"

Camera = refused("habitat_sim.gfx.Camera", DRAWING)
DebugLineRender = refused("habitat_sim.gfx.DebugLineRender", DRAWING)
LightInfo = refused("habitat_sim.gfx.LightInfo", DRAWING)
LightPositionModel = refused("habitat_sim.gfx.LightPositionModel", DRAWING)
RenderTarget = refused("habitat_sim.gfx.RenderTarget", DRAWING)
Renderer = refused("habitat_sim.gfx.Renderer", DRAWING)
ReplayRenderer = refused("habitat_sim.ReplayRenderer", RECORDS)
ReplayRendererConfiguration = refused("habitat_sim.ReplayRendererConfiguration", RECORDS)

__all__ = [
    "Camera", "DEFAULT_LIGHTING_KEY", "DebugLineRender", "LightInfo", "LightPositionModel", "NO_LIGHT_KEY",
    "RenderTarget", "Renderer", "ReplayRenderer", "ReplayRendererConfiguration",
]  # fmt: skip
