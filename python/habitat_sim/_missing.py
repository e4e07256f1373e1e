"""What is not there, in words."""

from __future__ import annotations

from magnum._refused import NotThere, RefusedAttribute, refused

__all__ = ["AUDIO", "DRAWING", "NotThere", "PHYSICS", "RECORDS", "RefusedAttribute", "refused"]

PHYSICS = "Enfilade has no physics and no objects; use the actions and the pathfinder"
AUDIO = "Enfilade has no audio; use camera sensors"
DRAWING = "Enfilade has no scene graph to draw; use camera sensors and get_sensor_observations()"
RECORDS = "Enfilade has no recorder of scenes; keep the agent's states instead"
