"""Checks an installed wheel: run by the Python of the environment, which needs nothing else.

    python packaging/check_wheel.py [unittest's options]

What it needs of the machine is what a user's has: no compiler, no libtorch, no GPU, no display. Where the wheel
enfilade-habitat is installed too, `Habitat` checks it.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
import unittest
import urllib.request
from pathlib import Path

PROGRAM = Path(sysconfig.get_path("scripts"), "enfilade")
# Those of the C library and the compiler, which every Linux has; manylinux allows them.
SYSTEM_LIBRARIES = re.compile(r"(linux-vdso|ld-linux|lib(c|m|dl|rt|pthread|gcc_s))[-.\w]*$")
LEARNING = ("evaluate", "features", "import-weights", "pretrain", "speak", "train")
HOMES_SECONDS = 60  # from the start of the server to a page; `serve` with nothing makes two homes
IMPORT_MILLISECONDS = 50


def is_emulated() -> bool:
    """On another kind of processor, by qemu-user: the machine's own is what /proc tells of."""
    return platform.machine() == "aarch64" and "vendor_id" in Path("/proc/cpuinfo").read_text()


# Where something is waited for; a limit of speed is not asked of emulation at all.
SLOWNESS = 10 if is_emulated() else 1


def assert_within(test: unittest.TestCase, taken: float, most: float) -> None:
    """Emulation is slow, and shows nothing of speed."""
    if not is_emulated():
        test.assertLessEqual(taken, most)


def run(*words: str, **options) -> subprocess.CompletedProcess:
    environment = {k: v for k, v in os.environ.items() if k not in ("ENFILADE_DATA", "PYTHONPATH")}
    return subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, env=environment, check=False, **options
    )


def fetch(address: str) -> bytes:
    with urllib.request.urlopen(address, timeout=30) as answer:
        return answer.read()


class Program(unittest.TestCase):
    def test_it_is_of_the_package_s_version(self):
        version = importlib.metadata.version("enfilade")
        self.assertEqual(run(PROGRAM, "--version").stdout.strip(), version)
        self.assertEqual(run(sys.executable, "-m", "enfilade", "--version").stdout.strip(), version)
        code = "import enfilade; print(enfilade.__version__)"
        self.assertEqual(run(sys.executable, "-c", code).stdout.strip(), version)

    def test_each_verb_has_help(self):
        listed = run(PROGRAM, "--help").stdout
        verbs = re.findall(r"^  ([a-z][a-z0-9-]+) ", listed[listed.index("\nLook:") :], re.M)
        self.assertGreaterEqual(
            set(verbs),
            {"convert", "demo", "doctor", "export", "graph", "homes", "import", "pack", "render", "report", "run", "scan-mesh",
             "score", "serve", "stats", "submit", "table"},
        )  # fmt: skip
        for verb in verbs:
            if verb in LEARNING and shutil.which("enfilade-learn", path=str(PROGRAM.parent)) is None:
                continue
            with self.subTest(verb=verb):
                told = run(PROGRAM, verb, "--help")
                self.assertEqual(told.returncode, 0, told.stderr)
                self.assertIn("Usage", told.stdout)
                self.assertNotIn("not in this build", told.stdout)

    def test_it_needs_no_library_but_the_system_s(self):
        if "manylinux" not in importlib.metadata.distribution("enfilade").read_text("WHEEL"):
            self.skipTest("built on this machine, with its libraries")
        files = [PROGRAM, *Path(sysconfig.get_path("platlib"), "enfilade").glob("*.so")]
        self.assertEqual(len(files), 3)
        for file in files:
            with self.subTest(file=file.name):
                for line in run("ldd", file).stdout.splitlines():
                    self.assertRegex(Path(line.split()[0]).name, SYSTEM_LIBRARIES)

    def test_train_says_what_it_lacks(self):
        if shutil.which("enfilade-learn", path=str(PROGRAM.parent)):
            self.skipTest("enfilade-learn is installed")
        for verb in LEARNING:
            with self.subTest(verb=verb):
                told = run(PROGRAM, verb, "--help")
                self.assertEqual(told.returncode, 2, told.stdout)
                self.assertIn("enfilade-learn", told.stderr)
                self.assertIn("PyTorch", told.stderr)
                self.assertIn("pip install", told.stderr)

    def test_doctor_looks_at_this_machine(self):
        told = run(PROGRAM, "doctor", timeout=120 * SLOWNESS)
        self.assertIn(told.returncode, (0, 1), told.stderr)
        self.assertIn("render", told.stdout.lower())


class Module(unittest.TestCase):
    def test_walks_draws_and_scores(self):
        code = """if True:
            import sys, enfilade
            from enfilade.synth import write_homes
            folder = sys.argv[1]
            write_homes(folder, homes=1, face_size=128)
            d = enfilade.Dataset(folder)
            scan = d.graphs.scans[0]
            viewpoint = d.graphs[scan].viewpoints[0]
            picture = d.render(scan, viewpoint, heading=1.0)
            assert picture.shape == (480, 640, 3) and picture.std() > 5, picture.shape
            sim = d.simulator(batch_size=2)
            sim.new_random_episodes([scan, scan])
            sim.step([0, 0], heading_changes=[0.5, -0.5])
            assert 'torch' not in sys.modules
            print(len(d.graphs), 'scans')
        """
        with tempfile.TemporaryDirectory() as folder:
            done = run(sys.executable, "-c", code, f"{folder}/data")
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_old_code_imports_the_drop_in(self):
        for statement in ("import MatterSim", "from Matterport3DSimulator import MatterSim"):
            code = f"{statement}; s = MatterSim.Simulator(); s.setCameraResolution(640, 480); print(s)"
            with self.subTest(statement=statement):
                done = run(sys.executable, "-c", code)
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_import_takes_milliseconds(self):
        taken = []
        for _ in range(5):
            told = run(sys.executable, "-X", "importtime", "-c", "import enfilade").stderr
            whole = re.search(r"\|\s*(\d+) \| enfilade$", told, re.M)
            self.assertIsNotNone(whole, told)
            taken.append(int(whole[1]) / 1000)
        print(f"import enfilade: {min(taken):.1f} ms (best of {len(taken)})", file=sys.stderr)
        assert_within(self, min(taken), IMPORT_MILLISECONDS)


class Habitat(unittest.TestCase):
    """The drop-in habitat_sim, a wheel of its own."""

    def setUp(self):
        names = {d.metadata["Name"] for d in importlib.metadata.distributions()}
        self.is_installed = "enfilade-habitat" in names

    def test_only_its_own_wheel_has_it(self):
        files = importlib.metadata.files("enfilade") or []
        self.assertEqual([f for f in files if f.parts[0] in ("corrade", "habitat_sim", "magnum")], [])

    def test_it_is_of_the_package_s_version(self):
        if not self.is_installed:
            self.skipTest("enfilade-habitat is not installed")
        versions = {importlib.metadata.version(name) for name in ("enfilade", "enfilade-habitat")}
        self.assertEqual(len(versions), 1, versions)

    def test_doctor_says_that_it_is_imported(self):
        if not self.is_installed:
            self.skipTest("enfilade-habitat is not installed")
        told = run(PROGRAM, "doctor", "--json", timeout=120 * SLOWNESS)
        self.assertIn("Enfilade's drop-in", json.loads(told.stdout)["Python"]["habitat_sim"]["text"])

    def test_it_walks_and_looks_in_a_home(self):
        if not self.is_installed:
            self.skipTest("enfilade-habitat is not installed")
        code = """if True:
            import glob, json, sys
            import habitat_sim, quaternion
            (home,) = glob.glob(sys.argv[1] + '/v1/scans/*/matterport_mesh/*/*.glb')
            stages = {'default_attributes': {'up': [0, 1, 0], 'front': [0, 0, -1]}}
            dataset = sys.argv[1] + '/y_up.scene_dataset_config.json'
            with open(dataset, 'w') as file:
                json.dump({'stages': stages}, file)
            config = habitat_sim.SimulatorConfiguration()
            config.scene_id, config.scene_dataset_config_file = home, dataset
            config.navmesh_settings = habitat_sim.NavMeshSettings()
            config.navmesh_settings.set_defaults()
            camera = habitat_sim.CameraSensorSpec()
            camera.uuid, camera.resolution = 'rgb', [64, 64]
            body = habitat_sim.agent.AgentConfiguration(sensor_specifications=[camera])
            with habitat_sim.Simulator(habitat_sim.Configuration(config, [body])) as sim:
                assert sim.pathfinder.is_loaded
                seen = sim.step('move_forward')
                assert seen['rgb'].shape == (64, 64, 4) and seen['rgb'][..., :3].std() > 0
                assert isinstance(sim.get_agent(0).state.rotation, quaternion.quaternion)
        """
        with tempfile.TemporaryDirectory() as folder:
            words = ("homes", "-o", f"{folder}/homes", "--homes", "1", "--size", "0", "--parts", "mesh")
            made = run(PROGRAM, *words)
            self.assertEqual(made.returncode, 0, made.stderr)
            done = run(sys.executable, "-c", code, f"{folder}/homes")
            self.assertEqual(done.returncode, 0, done.stderr)


class Server(unittest.TestCase):
    def test_with_nothing_it_serves_homes_and_their_pages(self):
        with tempfile.TemporaryDirectory() as folder:
            started = time.monotonic()
            environment = {k: v for k, v in os.environ.items() if k != "ENFILADE_DATA"}
            server = subprocess.Popen(
                [PROGRAM, "serve", "--port", "0"],
                cwd=folder, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            try:
                said, address = [], None
                for line in server.stdout:
                    said.append(line)
                    address = re.search(r" at (http://\S+/)$", line)
                    if address:
                        break
                self.assertTrue(address, "".join(said))
                self.look_at(address[1])
                taken = time.monotonic() - started
                print(f"serve: a home and its page after {taken:.1f} s", file=sys.stderr)
                assert_within(self, taken, HOMES_SECONDS)
                server.send_signal(signal.SIGTERM)
                self.assertEqual(server.wait(timeout=30 * SLOWNESS), 0)
            finally:
                server.kill()
                server.wait()
                server.stdout.close()

    def look_at(self, address: str):
        page = fetch(address).decode()
        self.assertIn("<script", page)
        script = re.search(r'src="/?(\S+?\.js)"', page)
        self.assertGreater(len(fetch(address + script[1])), 1000)
        scans = json.loads(fetch(address + "api/v1/scans"))
        self.assertTrue(scans["synthetic"])
        self.assertGreaterEqual(len(scans["scans"]), 2)
        picture = fetch(f"{address}api/v1/scans/{scans['scans'][0]['scan']}/picture.jpg")
        self.assertEqual(picture[:3], b"\xff\xd8\xff")  # a JPEG: what the first page shows of a home


if __name__ == "__main__":
    unittest.main()
