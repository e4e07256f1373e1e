"""Steps of the drop-in habitat_sim and of habitat-lab on it, beside Enfilade's own eyes, in one run.

    enfilade homes -o homes --homes 3 --seed 2 --size 0 --tasks r2r --parts habitat
    python bench_habitat.py homes [--steps 1000]

Each figure is of RGB-D images: an agent goes forward, and turns at random and at walls. The eyes draw the
same poses, one at a time. Processor time is of all threads. habitat-lab's row needs habitat-lab.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import random
import resource
import time
from pathlib import Path
from typing import Any, Callable, Iterator

SIZES = ((256, 256, 90), (640, 480, 79))  # width, height, horizontal field of view in degrees
EYE = 1.25  # metres above the body's point


def line(what: str, steps: int, work: Callable[[], Any]) -> float:
    """Does the work, prints steps a second, and returns the processor's seconds of a step."""
    wall, busy = time.perf_counter(), time.process_time()
    work()
    wall, busy = time.perf_counter() - wall, time.process_time() - busy
    print(f"{what:<44}{steps / wall:>9.0f} steps/s{steps / busy:>9.0f} of processor time", flush=True)
    return busy / steps


def simulator(scene: Path, size: tuple[int, int, int]) -> Any:
    import habitat_sim

    width, height, hfov = size
    sensors = []
    for kind in (habitat_sim.SensorType.COLOR, habitat_sim.SensorType.DEPTH):
        camera = habitat_sim.CameraSensorSpec()
        camera.uuid, camera.sensor_type = str(kind), kind
        camera.resolution, camera.hfov, camera.position = [height, width], hfov, [0.0, EYE, 0.0]
        sensors.append(camera)
    config = habitat_sim.SimulatorConfiguration()
    config.scene_id, config.gpu_device_id = str(scene), -1
    body = habitat_sim.agent.AgentConfiguration(sensor_specifications=sensors)
    sim = habitat_sim.Simulator(habitat_sim.Configuration(config, [body]))
    state = habitat_sim.AgentState()
    state.position = sim.pathfinder.get_random_navigable_point(island_index=home_island(sim.pathfinder))
    sim.get_agent(0).set_state(state)
    return sim


def home_island(finder: Any) -> int:
    """The largest island but the ground around the home, which is larger."""
    by_area = sorted(range(finder.num_islands), key=finder.island_area)
    return by_area[-2] if len(by_area) > 1 else 0


def walk(sim: Any, steps: int) -> Iterator[Any]:
    """Observations of a random walk."""
    draw, stopped = random.Random(7), False
    for _ in range(steps):
        turns = stopped or draw.random() < 0.3
        seen = sim.step(draw.choice(["turn_left", "turn_right"]) if turns else "move_forward")
        stopped = seen["collided"]
        yield seen


def heading_of(rotation: Any) -> float:
    """Clockwise from +y of our world frame, of a body that only turns about the vertical."""
    return -2 * math.atan2(rotation.y, rotation.w)


def of_simulator(scene: Path, size: tuple[int, int, int], steps: int) -> None:
    import enfilade
    import numpy as np
    from enfilade.eyes import Eyes

    width, height, hfov = size
    begin = time.perf_counter()
    sim = simulator(scene, size)
    sim.get_sensor_observations()
    print(f"{width} x {height}: opened in {time.perf_counter() - begin:.2f} s")
    poses = []
    for _ in walk(sim, steps):  # warm, and where the agent comes
        state = sim.get_agent(0).state
        eye = enfilade.from_habitat(state.position + np.array([0, EYE, 0]))
        poses.append((eye, heading_of(state.rotation)))
    ours = line("  habitat_sim: sim.step()", steps, lambda: [0 for _ in walk(sim, steps)])
    eyes = Eyes(meshes={"scene": scene}, up="z")
    vfov = 2 * math.atan(math.tan(math.radians(hfov) / 2) * height / width)
    views = [(["scene"], at[None], np.array([heading])) for at, heading in poses]

    def draw() -> None:
        for view in views:
            eyes.render(*view, size=(width, height), vfov=vfov)

    draw()
    native = line("  the eyes: Eyes.render(), the same poses", steps, draw)
    print(f"  a step takes {ours / native:.2f} of the eyes' processor time")


def of_lab(data: Path, size: tuple[int, int, int], steps: int) -> None:
    import habitat

    width, height, hfov = size
    sensors = "habitat.simulator.agents.main_agent.sim_sensors"
    options = [f"{sensors}.{name}_sensor.{field}={value}" for name in ("rgb", "depth")
               for field, value in (("width", width), ("height", height), ("hfov", hfov))]  # fmt: skip
    config = habitat.get_config(
        "benchmark/nav/vln_r2r.yaml",
        [
            *options, "habitat.simulator.habitat_sim_v0.gpu_device_id=-1", "habitat.dataset.split=train",
            f"habitat.dataset.data_path={data}/datasets/vln/mp3d/r2r/v1/train/train.json.gz",
            f"habitat.dataset.scenes_dir={data}/scene_datasets", "habitat.simulator.scene_dataset=default",
            "habitat.environment.iterator_options.max_scene_repeat_steps=-1",
        ],
    )  # fmt: skip
    with habitat.Env(config=config) as env:
        draw = random.Random(7)
        env.reset()

        def go() -> None:
            for _ in range(steps):
                if env.episode_over:
                    env.reset()
                env.step(draw.choice(["move_forward", "move_forward", "turn_left", "turn_right"]))

        go()
        line("  habitat-lab: Env.step(), VLN-v0", steps, go)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("homes", type=Path, help="what `enfilade homes --parts habitat` wrote")
    parser.add_argument("--steps", type=int, default=1000)
    options = parser.parse_args()
    data = options.homes.absolute() / "habitat"
    scene = min(data.glob("scene_datasets/mp3d/*/*.glb"), default=None)
    if scene is None:
        parser.error(f"{data}: no scene_datasets/mp3d/SCAN/SCAN.glb; write homes with --parts habitat")
    print(f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}: SYNTHETIC homes")
    for size in SIZES:
        of_simulator(scene, size, options.steps)
        try:
            of_lab(data, size, options.steps)
        except ImportError as error:
            print(f"  habitat-lab is left out: {error}")
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"memory, at most: {most / 1024:.0f} MB")


if __name__ == "__main__":
    main()
