"""habitat_sim, the drop-in: agents, the follower, the simulator and pictures, in a small room."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")
pytest.importorskip("quaternion", reason="numpy-quaternion is not installed: no habitat_sim")

pytest.register_assert_rewrite("habitat_rooms")

import habitat_sim  # noqa: E402
import magnum as mn  # noqa: E402
from habitat_rooms import camera, configuration, put, settings  # noqa: E402
from habitat_sim.utils.common import (  # noqa: E402
    angle_between_quats,
    quat_from_angle_axis,
    quat_from_coeffs,
    quat_rotate_vector,
    quat_to_coeffs,
)

pytest_plugins = ["habitat_rooms"]


# --- agents ---------------------------------------------------------------------------------------


def test_agents_have_the_numbers_of_older_versions() -> None:
    body = habitat_sim.AgentConfiguration()
    wanted = {"mass": 32.0, "linear_acceleration": 20.0, "linear_friction": 0.5, "angular_friction": 1.0}
    assert {name: getattr(body, name) for name in wanted} == wanted
    assert body.angular_acceleration == pytest.approx(12.566371) and body.coefficient_of_restitution == 0


def test_states_are_habitats(sim: Any) -> None:
    agent = sim.get_agent(0)
    fresh = habitat_sim.AgentState()
    assert (
        repr(fresh)
        == "AgentState(position=array([0., 0., 0.]), rotation=quaternion(1, 0, 0, 0), sensor_states={})"
    )
    state = agent.get_state()
    state.position, state.rotation, state.sensor_states = [1.0, 2.0, 3.0], [0, 0.6, 0, 0.8], {}
    agent.set_state(state, True)
    got = agent.state
    assert got.position.dtype == np.float32 and got.position.tolist() == [1, 2, 3]  # off the floor
    assert quat_to_coeffs(got.rotation).tolist() == [0, np.float32(0.6), 0, np.float32(0.8)]
    assert got.sensor_states["rgb"].position.tolist() == [1, 3.25, 3]
    assert np.allclose(quat_to_coeffs(got.sensor_states["rgb"].rotation), [0, 0.6, 0, 0.8])
    node = agent.scene_node
    assert node.translation == mn.Vector3(1, 2, 3) and node.parent is None
    assert node.type == habitat_sim.SceneNodeType.AGENT and agent.sensors["rgb"].node.parent is node
    with pytest.raises(TypeError, match="type 2: a SceneNodeType is wanted"):
        node.type = 2
    agent.state = got
    assert agent.state.position.tolist() == [1, 2, 3]
    for position in ([math.nan, 0, 0], [0, math.inf, 0]):
        with pytest.raises(ValueError, match="position .*finite"):
            agent.set_state(habitat_sim.AgentState(position))
    for rotation in ([0, 0, 0, 0.9], quat_from_coeffs([0, 1, 0, 1]), [math.nan, 0, 0, 1]):
        with pytest.raises(ValueError, match="rotation"):
            agent.set_state(habitat_sim.AgentState([0, 0, 0], rotation))
    for state in (habitat_sim.AgentState((0, 0, 0)), habitat_sim.AgentState([0, 0, 0], (0, 0, 0, 1))):
        with pytest.raises(TypeError):
            agent.set_state(state)
    assert agent.state.position.tolist() == [1, 2, 3]


def test_actions_move_bodies_and_turn_sensors(sim: Any) -> None:
    agent = sim.get_agent(0)
    put(sim, [0, 0.3, 2])
    assert not agent.act(4) and agent.state.position[1] == np.float32(
        0.3
    )  # a camera's turn moves no body
    tilted = agent.state.sensor_states["rgb"].rotation
    assert quat_rotate_vector(tilted, [0, 0, -1])[1] == pytest.approx(0.5, abs=1e-6)
    assert not agent.act(2) and agent.state.position[1] < 0.2  # a body's turn does, onto the floor
    assert angle_between_quats(agent.state.rotation, quat_from_coeffs([0, 0, 0, 1])) == pytest.approx(
        math.radians(15)
    )
    agent.act(3)
    seen = sim.step(1)
    assert seen["collided"] is False and agent.state.position[2] == pytest.approx(1.75, abs=1e-4)
    put(sim, [0, 0, -1.8])
    assert sim.step(1)["collided"] is True and agent.state.position[2] > -2
    put(sim, [0, 0, 2])
    agent.act(5)
    agent.set_state(agent.state, reset_sensors=False)
    assert quat_rotate_vector(agent.state.sensor_states["rgb"].rotation, [0, 0, -1])[1] < -0.4
    agent.set_state(agent.state)
    assert quat_rotate_vector(agent.state.sensor_states["rgb"].rotation, [0, 0, -1])[1] == 0
    state = agent.state
    state.sensor_states = {"rgb": habitat_sim.SixDOFPose([3, 2, 1], quat_from_angle_axis(1, [0, 1, 0]))}
    agent.set_state(state, infer_sensor_states=False)
    assert np.allclose(agent.state.sensor_states["rgb"].position, [3, 2, 1], atol=1e-6)
    assert (
        angle_between_quats(
            agent.state.sensor_states["rgb"].rotation, quat_from_angle_axis(1, [0, 1, 0])
        )
        < 1e-3
    )


def test_wrong_actions_are_named(sim: Any) -> None:
    agent, by = sim.get_agent(0), habitat_sim.ActuationSpec
    for key, spec, error, words in (
        (7, None, ValueError, "action 7: one of 0, 1, 2"),
        (0, None, ValueError, "'stop' has no actuation"),
        (8, habitat_sim.ActionSpec("fly", by(1.0)), ValueError, "'fly': one of move_forward"),
        (8, habitat_sim.ActionSpec("look_up", by(1.0, 10.0)), NotImplementedError, "no constraints"),
        (
            8,
            habitat_sim.ActionSpec("pyrobot_noisy_turn_left", by(1.0)),
            NotImplementedError,
            "use turn_left",
        ),
        (8, habitat_sim.ActionSpec("turn_left", 15), TypeError, "not an ActuationSpec"),
    ):
        if spec is not None:
            agent.agent_config.action_space[key] = spec
        with pytest.raises(error, match=words):
            agent.act(key)
    with pytest.raises(IndexError, match="agent_id 1: the simulator has 1 agents"):
        sim.get_agent(1)


def test_the_first_state_is_random_by_the_seed_and_reset_goes_back(rooms: Path) -> None:
    def first(seed: int) -> list[float]:
        with habitat_sim.Simulator(
            configuration(rooms / "room.glb", settings(), random_seed=seed)
        ) as sim:
            begun = sim.get_agent(0).state
            assert sim.pathfinder.is_navigable(begun.position)
            for action in (1, 2, 1):
                sim.step(action)
            sim.reset()
            again = sim.last_state()
            assert np.array_equal(again.position, begun.position) and again.rotation == begun.rotation
            return [*begun.position.tolist(), *quat_to_coeffs(begun.rotation)]

    assert first(5) == first(5) != first(6)
    assert first(0)[:3] == first(1)[:3]  # as of the C library


def test_turns_are_radians_in_double_and_then_float(sim: Any) -> None:
    """7.2 and 8.6 degrees are no float32: as one they would turn by another angle."""
    agent = sim.get_agent(0)

    def sine_of(degrees: Any) -> float:
        turn = habitat_sim.ActionSpec("turn_left", habitat_sim.ActuationSpec(degrees))
        agent.agent_config.action_space["turn"] = turn
        put(sim, [0.0, 0.0, 0.0])
        agent.act("turn")
        return float(agent.state.rotation.y)

    for degrees in (10, 12.5, 22.5, 7.7, 7.2, np.float64(8.6)):
        half = float(np.float32(degrees * math.pi / 180)) / 2
        assert abs(sine_of(degrees) - math.sin(half)) < 2e-8
    for degrees in (7.2, 8.6):
        assert sine_of(degrees) != sine_of(float(np.float32(degrees)))


def test_the_follower_leads_to_its_goal(sim: Any) -> None:
    goal = sim.pathfinder.snap_point([0.0, 0.0, -3.5])
    put(sim, sim.pathfinder.snap_point([0.0, 0.0, 0.0]))
    follower = sim.make_greedy_follower(0, 0.3, stop_key=0, forward_key=1, left_key=2, right_key=3)
    planned = follower.find_path(goal)
    assert planned[-1] == 0 and set(planned) == {0, 1, 2, 3}
    for _ in range(200):
        action = follower.next_action_along(goal)
        if action == 0:
            break
        sim.step(action)
    path = habitat_sim.ShortestPath()
    path.requested_start, path.requested_end = sim.get_agent(0).state.position, goal
    assert sim.pathfinder.find_path(path) and path.geodesic_distance < 0.3
    follower.reset()
    for ask in (follower.next_action_along, follower.find_path):
        with pytest.raises(habitat_sim.errors.GreedyFollowerError, match="no path leads there"):
            ask([22.0, 0.0, 2.0])
    plain = sim.make_greedy_follower()
    assert (
        plain.goal_radius == 0.1875 and plain.next_action_along(sim.get_agent(0).state.position) is None
    )
    assert plain.find_path(sim.pathfinder.snap_point([2.0, 0.0, 3.0]))[-1] is None
    del sim.get_agent(0).agent_config.action_space[3]
    with pytest.raises(ValueError, match="no action 'turn_right'"):
        sim.make_greedy_follower()


# --- the simulator --------------------------------------------------------------------------------


def test_another_pathfinder_can_be_given(sim: Any) -> None:
    walked = []
    for finder in (sim.pathfinder, habitat_sim.PathFinder()):
        sim.pathfinder = finder
        assert sim.pathfinder is finder
        put(sim, [0.0, 0.0, -1.9])  # before the wall
        walked.append(sim.step(1)["collided"])
    assert walked == [True, False]  # without a mesh there are no walls
    with pytest.raises(TypeError, match="pathfinder None: a PathFinder is wanted"):
        sim.pathfinder = None


def test_simulators_can_be_inherited_beside_another_class(rooms: Path) -> None:
    class Other:
        def reset(self) -> Any:
            raise AssertionError("not this one")

    class Both(habitat_sim.Simulator, Other):
        def __init__(self, config: Any) -> None:
            super().__init__(config)

        def reset(self) -> Any:
            return super().reset()

    config = configuration(rooms / "room.glb", settings(), [camera()])
    sim = Both(config)
    assert "Both" in repr(sim) and sim.config is config and sim.reset().keys() == {"rgb"}
    first = sim.get_agent(0)
    sim.reconfigure(configuration(rooms / "room.glb", settings(), [camera()]))
    assert sim.get_agent(0) is first  # an equal configuration
    sim.reconfigure(configuration(rooms / "room.glb", None, [camera()]))
    assert sim.get_agent(0) is not first and sim.pathfinder.nav_mesh_settings == settings()
    finder = sim.pathfinder
    sim.reconfigure(configuration(rooms / "room.glb", settings(0.4), [camera("other")]))
    assert sim.sensors.keys() == {"other"} and sim.pathfinder is finder
    assert finder.nav_mesh_settings == settings(0.4)
    sim.close(destroy=False)
    with pytest.raises(IndexError):
        sim.get_agent(0)
    sim.reconfigure(configuration("", None, [camera()]))
    assert not sim.pathfinder.is_loaded and sim.pathfinder is not finder
    sim.close()
    assert sim.step_physics(0.1) is None and sim.step_world() == 0


def test_several_agents_act_at_once(rooms: Path) -> None:
    config = configuration(rooms / "room.glb", settings(), [camera()])
    config.agents.append(configuration("").agents[0])
    with habitat_sim.Simulator(config) as sim:
        seen = sim.step({0: 1, 1: 2})
        assert seen[0].keys() == {"rgb", "collided"} and seen[1].keys() == {"collided"}
        assert sim.get_sensor_observations([1, 0])[0].keys() == {"rgb"}


# --- pictures -------------------------------------------------------------------------------------


def test_cameras_see_the_room(sim: Any) -> None:
    put(sim, [0, 0, 1])
    seen = sim.get_sensor_observations()
    rgb, depth = seen["rgb"], seen["depth"]
    assert rgb.shape == (24, 32, 4) and rgb.dtype == np.uint8 and (rgb[..., 3] == 255).all()
    assert depth.shape == (24, 32) and depth.dtype == np.float32
    assert depth[12, 16] == pytest.approx(3, abs=1e-3) and rgb[12, 16, 0] > 50 and rgb[12, 16, 1] < 20
    assert (
        depth[0].max() == 0 and depth[-1, 16] < 2
    )  # above the wall there is nothing; below is the floor
    put(sim, [0, 0, 1], 180)
    assert sim.get_sensor_observations()["depth"][12].max() == 0
    put(sim, [0, 0, 1], 90)
    left = sim.get_sensor_observations()["depth"]
    assert left[12, 30] == pytest.approx(3, rel=0.2) and left[12, 2] == 0  # the wall is on the right
    for _ in range(3):
        sim.get_agent(0).act(5)
    assert sim.get_sensor_observations()["depth"][12, 16] == pytest.approx(
        1.25, abs=1e-3
    )  # straight down


def test_other_sensors(rooms: Path) -> None:
    old = habitat_sim.SensorSpec()  # of habitat-lab 0.1.7
    old.uuid, old.sensor_type, old.resolution = "old", habitat_sim.SensorType.DEPTH, [16, 16]
    old.position = [0, 1.25, 0]
    old.parameters["hfov"] = "60"
    around = []
    for uuid, kind in (("around", habitat_sim.SensorType.COLOR), ("far", habitat_sim.SensorType.DEPTH)):
        spec = habitat_sim.EquirectangularSensorSpec()
        spec.uuid, spec.sensor_type, spec.resolution, spec.position = uuid, kind, [32, 64], [0, 1.25, 0]
        around.append(spec)
    back = camera("back", "DEPTH", orientation=[0, math.pi, 0])
    sensors = [old, *around, back, camera("semantic", "SEMANTIC")]
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=sensors)) as sim:
        assert isinstance(sim.sensors["old"].specification(), habitat_sim.CameraSensorSpec)
        assert sim.sensors["old"].specification().hfov == mn.Deg(60)
        put(sim, [0, 0, 1])
        seen = sim.get_sensor_observations()
        assert seen["old"].shape == (16, 16) and seen["old"][8, 8] == pytest.approx(3, abs=1e-3)
        assert seen["semantic"].dtype == np.uint32 and not seen["semantic"].any()
        assert not seen["back"][12].any()
        assert seen["around"].shape == (32, 64, 4) and (seen["around"][..., 3] == 255).all()
        # In the middle is the front; the depth is along the axis of the cube's face.
        assert seen["far"][15, 32] == pytest.approx(3, abs=1e-3) == seen["far"][15, 26]
        assert seen["far"][15, 0] == 0 and seen["far"][31].tolist() == pytest.approx(
            [1.25] * 64, abs=1e-3
        )


@pytest.mark.parametrize(
    ("change", "words"),
    [({"clear_color": [1, 1, 1, 1]}, "clear_color of 'rgb'"), ({"gpu2gpu_transfer": True}, "use False"),
     ({"sensor_subtype": habitat_sim.SensorSubType.ORTHOGRAPHIC}, "use PINHOLE"),
     ({"sensor_type": habitat_sim.SensorType.AUDIO}, "use COLOR or DEPTH")],
)  # fmt: skip
def test_sensors_that_are_not_there_are_refused(
    rooms: Path, change: dict[str, Any], words: str
) -> None:
    with pytest.raises(NotImplementedError, match=words):
        habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=[camera(**change)]))


def test_sensors_that_cannot_be_added(sim: Any) -> None:
    with pytest.raises(ValueError, match="uuid 'rgb': another sensor"):
        sim.add_sensor(camera())
    with pytest.raises(ValueError, match=r"'fisheye': sensor.double_sphere.focal: \(0, 0\) pixels"):
        sim.add_sensor(habitat_sim.FisheyeSensorDoubleSphereSpec())
    with pytest.raises(ValueError, match="'wide': sensor.horizontal_field_of_view"):
        sim.add_sensor(camera("wide", hfov=180))


def test_a_rolled_camera_turns_its_picture(rooms: Path) -> None:
    kinds = [("rgb", [0, 0, 0]), ("rolled", [0, 0, math.pi / 2])]
    sensors = [camera(uuid, orientation=turn, resolution=[24, 24]) for uuid, turn in kinds]
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=sensors)) as sim:
        put(sim, [0, 0, 1])
        seen = sim.get_sensor_observations()
    assert len(np.unique(seen["rgb"].reshape(-1, 4), axis=0)) > 1
    turned = np.rot90(seen["rolled"])  # it leans to the left, so the picture leans to the right
    assert (turned == seen["rgb"]).all(axis=-1).mean() > 0.9  # but for pixels at edges


def test_a_fisheye_sees_what_a_camera_sees_in_the_middle(rooms: Path) -> None:
    fisheye = habitat_sim.FisheyeSensorDoubleSphereSpec()
    fisheye.uuid, fisheye.sensor_type = "fisheye", habitat_sim.SensorType.DEPTH
    fisheye.resolution, fisheye.focal_length, fisheye.position = [64, 64], [20, 20], [0, 1.25, 0]
    sensors = [fisheye, camera("depth", "DEPTH")]
    with habitat_sim.Simulator(configuration(rooms / "room.glb", sensors=sensors)) as sim:
        put(sim, [0, 0, 1])
        seen = sim.get_sensor_observations()
    assert seen["fisheye"].shape == (64, 64) and seen["fisheye"].dtype == np.float32
    middle = seen["depth"][seen["depth"].shape[0] // 2, seen["depth"].shape[1] // 2]
    assert seen["fisheye"][32, 32] == pytest.approx(middle, abs=1e-3)
