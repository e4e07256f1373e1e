"""All that is C++ in Habitat."""

from __future__ import annotations

from habitat_sim.geo import *  # noqa: F403
from habitat_sim.gfx import *  # noqa: F403
from habitat_sim.metadata import Configuration as Configuration
from habitat_sim.metadata import MetadataMediator as MetadataMediator
from habitat_sim.nav import *  # noqa: F403
from habitat_sim.physics import *  # noqa: F403
from habitat_sim.scene import *  # noqa: F403
from habitat_sim.sensor import *  # noqa: F403
from habitat_sim.sim import *  # noqa: F403

# Parts that Habitat may be built with.
audio_enabled = built_with_bullet = cuda_enabled = False
