"""Scenes of a simulator, without agents."""

from __future__ import annotations

import os
from typing import Any, Optional

from enfilade._eyes import habitat as native

from habitat_sim._draw import Drawer
from habitat_sim._fields import Field, Structure, boolean, maybe, one_of, text, whole
from habitat_sim._house import read_house
from habitat_sim._missing import DRAWING, PHYSICS, RECORDS, NotThere, RefusedAttribute
from habitat_sim._scene_files import SceneFile, find_scene
from habitat_sim.agent.agent import Ground
from habitat_sim.gfx import NO_LIGHT_KEY
from habitat_sim.logging import logger
from habitat_sim.metadata import AttributesManager
from habitat_sim.nav import NavMeshSettings, PathFinder
from habitat_sim.scene import SemanticScene

__all__ = ["SimulatorBackend", "SimulatorConfiguration"]


class SimulatorConfiguration(Structure):
    """A scene, and how agents move there.

    `scene_id` is the path of a .glb file, z up, or the name of a stage of `scene_dataset_config_file`; "" or
    "NONE" is an empty scene. `navmesh_settings`: a navigation mesh with others, or none, is made anew. Fields
    of the GPU, of textures and of labels have no effect.
    """

    scene_id = Field(text, "")
    scene_dataset_config_file = Field(text, "default")
    allow_sliding = Field(boolean, True)
    random_seed = Field(whole, 0)
    navmesh_settings: Field[Optional[native.NavMeshSettings]] = Field(
        maybe(one_of(NavMeshSettings)), None
    )
    default_agent_id = Field(whole, 0)
    create_renderer = Field(boolean, True)
    enable_gfx_replay_save = Field(boolean, False)
    enable_hbao = Field(boolean, False)
    enable_physics = Field(boolean, False)
    force_separate_semantic_scene_graph = Field(boolean, False)
    frustum_culling = Field(boolean, True)
    gpu_device_id = Field(whole, 0)
    leave_context_with_background_renderer = Field(boolean, False)
    load_semantic_mesh = Field(boolean, True)
    override_scene_light_defaults = Field(boolean, False)
    physics_config_file = Field(text, "./data/default.physics_config.json")
    requires_textures = Field(boolean, True)
    scene_light_setup = Field(text, NO_LIGHT_KEY)
    use_semantic_textures = Field(boolean, True)


def _check(config: SimulatorConfiguration) -> None:
    if config.enable_physics:
        raise NotThere(f"enable_physics: {PHYSICS}, and False")
    if config.enable_gfx_replay_save:
        raise NotThere(f"enable_gfx_replay_save: {RECORDS}, and False")
    if config.enable_hbao:
        raise NotThere("enable_hbao: Enfilade has no shading; use False")
    if config.scene_light_setup != NO_LIGHT_KEY:
        raise NotThere(
            f"scene_light_setup '{config.scene_light_setup}': Enfilade has '{NO_LIGHT_KEY}' only"
        )


def _meaning(scene: Optional[SceneFile]) -> SemanticScene:
    """Habitat opens a scene whose labels it cannot read, too, and says in its log what is wrong with them."""
    if scene is not None and os.path.exists(scene.house):
        try:
            house, odd, bad = read_house(scene.house)
            for what in odd:
                logger.warning("%s", what)
            if bad:
                logger.error("semantic_scene ends there: %s", bad)
            return SemanticScene(house)
        except ValueError as error:
            logger.error("semantic_scene is empty: %s", error)
        except OSError as error:
            logger.error("semantic_scene is empty: %s: %s", scene.house, error.strerror)
    return SemanticScene()


class SimulatorBackend:
    """An open scene: its pathfinder and its pictures."""

    def __init__(self, configuration: SimulatorConfiguration) -> None:
        self.__key: Any = None
        self._open_scene(configuration)

    def _open_scene(self, config: SimulatorConfiguration) -> None:
        """Opens a scene, unless it is open, and gives it the navigation mesh that is wanted."""
        _check(config)
        key = (config.scene_id, config.scene_dataset_config_file)
        if key != self.__key:
            scene = find_scene(*key)
            self.__meaning = _meaning(scene)
            self.__scene, self.__key = scene, key
            self.__drawer = Drawer(self.__scene)
            self._ground = Ground(PathFinder())
            self.__load_navmesh()
        self.__config = config
        self._ground.slide = config.allow_sliding
        settings, loaded = config.navmesh_settings, self.pathfinder.nav_mesh_settings
        if settings is not None and self.__scene is not None and (loaded is None or loaded != settings):
            self.recompute_navmesh(self.pathfinder, settings)

    @property
    def pathfinder(self) -> PathFinder:
        """The pathfinder with the scene's navigation mesh, on which agents move. It can be set."""
        found: PathFinder = self._ground.pathfinder
        return found

    @pathfinder.setter
    def pathfinder(self, pathfinder: PathFinder) -> None:
        self._ground.pathfinder = one_of(PathFinder)("pathfinder", pathfinder)

    def __load_navmesh(self) -> None:
        if self.__scene is not None and os.path.exists(self.__scene.navmesh):
            self.pathfinder.load_nav_mesh(self.__scene.navmesh)

    def _close_scene(self) -> None:
        self.__key = None

    def _drawer(self) -> Drawer:
        return self.__drawer

    def recompute_navmesh(
        self, pathfinder: PathFinder, navmesh_settings: native.NavMeshSettings
    ) -> bool:
        """Makes the scene's navigation mesh, for a pathfinder. Returns False, and logs why, without floor."""
        if self.__scene is None:
            logger.error("recompute_navmesh(): the scene is empty")
            return False
        return pathfinder._make(self.__scene.path, self.__scene.up, navmesh_settings)

    def step_filter(self, start_pos: Any, end_pos: Any) -> Any:
        """Where a body ends that goes from start to end; the end without a navigation mesh."""
        if not self.pathfinder.is_loaded:
            return end_pos
        return self.pathfinder._step(start_pos, end_pos, self.__config.allow_sliding)

    @property
    def semantic_scene(self) -> SemanticScene:
        """What the scene means: what the `.house` file beside it has."""
        return self.__meaning

    @property
    def curr_scene_name(self) -> str:
        """The `scene_id`."""
        return self.__config.scene_id

    @property
    def active_dataset(self) -> str:
        """The `scene_dataset_config_file`."""
        return self.__config.scene_dataset_config_file

    @property
    def gpu_device(self) -> int:
        """The `gpu_device_id`; pictures are drawn on the CPU."""
        return self.__config.gpu_device_id

    @property
    def frustum_culling(self) -> bool:
        """The configuration's, without effect."""
        return self.__config.frustum_culling

    @frustum_culling.setter
    def frustum_culling(self, value: bool) -> None:
        self.__config.frustum_culling = value

    def step_physics(self, dt: float, scene_id: int = 0) -> None:
        """Without effect: there is no physics."""

    def step_world(self, dt: float = 1.0 / 60.0) -> float:
        """Without effect: there is no physics. Returns 0."""
        return 0.0

    def get_object_template_manager(self) -> Any:
        """An object whose load_configs() raises NotImplementedError: there are no objects."""
        return AttributesManager

    _sensors_words = (
        "Enfilade makes the sensors of AgentConfiguration.sensor_specifications; add them there"
    )
    _async = "Enfilade draws at once; use get_sensor_observations()"
    add_gradient_trajectory_object = RefusedAttribute(PHYSICS)
    add_trajectory_object = RefusedAttribute(PHYSICS)
    build_semantic_CC_objects = RefusedAttribute(DRAWING)
    build_vertex_color_map_report = RefusedAttribute(DRAWING)
    cast_ray = RefusedAttribute(PHYSICS)
    create_rigid_constraint = RefusedAttribute(PHYSICS)
    create_sensor = RefusedAttribute(_sensors_words)
    get_active_scene_graph = RefusedAttribute(DRAWING)
    get_active_semantic_scene_graph = RefusedAttribute(DRAWING)
    get_articulated_object_manager = RefusedAttribute(PHYSICS)
    get_asset_template_manager = RefusedAttribute(PHYSICS)
    get_current_light_setup = RefusedAttribute(DRAWING)
    get_debug_line_render = RefusedAttribute(DRAWING)
    get_gravity = RefusedAttribute(PHYSICS)
    get_light_setup = RefusedAttribute(DRAWING)
    get_lighting_template_manager = RefusedAttribute(DRAWING)
    get_physics_contact_points = RefusedAttribute(PHYSICS)
    get_physics_num_active_contact_points = RefusedAttribute(PHYSICS)
    get_physics_num_active_overlapping_pairs = RefusedAttribute(PHYSICS)
    get_physics_simulation_library = RefusedAttribute(PHYSICS)
    get_physics_step_collision_summary = RefusedAttribute(PHYSICS)
    get_physics_template_manager = RefusedAttribute(PHYSICS)
    get_physics_time_step = RefusedAttribute(PHYSICS)
    get_rigid_constraint_settings = RefusedAttribute(PHYSICS)
    get_rigid_object_manager = RefusedAttribute(PHYSICS)
    get_runtime_perf_stat_names = RefusedAttribute(DRAWING)
    get_runtime_perf_stat_values = RefusedAttribute(DRAWING)
    get_sensor = RefusedAttribute(_sensors_words)
    get_sensor_observations_async_finish = RefusedAttribute(_async)
    get_stage_initialization_template = RefusedAttribute(PHYSICS)
    get_stage_is_collidable = RefusedAttribute(PHYSICS)
    get_stage_template_manager = RefusedAttribute(PHYSICS)
    get_world_time = RefusedAttribute(PHYSICS)
    gfx_replay_manager = RefusedAttribute(RECORDS)
    metadata_mediator = RefusedAttribute(PHYSICS)
    navmesh_visualization = RefusedAttribute(DRAWING)
    perform_discrete_collision_detection = RefusedAttribute(PHYSICS)
    physics_debug_draw = RefusedAttribute(PHYSICS)
    random = RefusedAttribute("use a generator of numpy")
    remove_rigid_constraint = RefusedAttribute(PHYSICS)
    remove_sensor = RefusedAttribute(_sensors_words)
    render_sensors = RefusedAttribute(DRAWING)
    renderer = RefusedAttribute(DRAWING)
    save_current_scene_config = RefusedAttribute(PHYSICS)
    scene_aabb = RefusedAttribute("use pathfinder.get_bounds()")
    semantic_color_map = RefusedAttribute(DRAWING)
    set_gravity = RefusedAttribute(PHYSICS)
    set_light_setup = RefusedAttribute(DRAWING)
    set_stage_is_collidable = RefusedAttribute(PHYSICS)
    start_async_render = RefusedAttribute(_async)
    start_async_render_and_step_physics = RefusedAttribute(_async)
    update_rigid_constraint = RefusedAttribute(PHYSICS)
