"""python3 packaging_test.py: what packaging/ says twice, or of others, is still so. Builds nothing."""

import re
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packaging"))
import release  # noqa: E402


def text(file):
    return (ROOT / file).read_text()


def first(pattern, file):
    return re.search(pattern, text(file), re.M)[1]


# CMake's packages that no wheel has: torch, and what is for developers.
NOT_IN_WHEELS = {"libtbb-dev", "libtorch-dev", "libgtest-dev", "libgmock-dev", "libbenchmark-dev"}
# Debian's names of what packaging/libraries.sh builds from source.
BUILT = {"libhwy-dev": "highway", "libcpp-httplib-dev": "httplib", "librecast-dev": "recast", "libzip-dev": "libzip",
         "libturbojpeg0-dev": "turbojpeg", "libjpeg-dev": "turbojpeg"}  # fmt: skip


def libraries_of_cmake():
    """The -dev packages that cmake/EnfiladeDependencies.cmake names, but for those no wheel has."""
    calls = re.findall(r"^ *enfilade_require(?:_pc)?\((.*)\)$", text("cmake/EnfiladeDependencies.cmake"), re.M)
    packages = {name for call in calls for name in re.findall(r"\b[-\w]+-dev\b", call)}
    return packages - NOT_IN_WHEELS


class Packaging(unittest.TestCase):
    def test_one_version(self):
        version = first(r'^version = "(.*)"', "pyproject.toml")
        self.assertEqual(version, first(r"^  VERSION (\S+)", "CMakeLists.txt"))
        self.assertEqual(version, first(r'^version = "(.*)"', "packaging/learn/pyproject.toml"))
        self.assertEqual(version, first(r'"enfilade==(.*?)"', "packaging/learn/pyproject.toml"))
        self.assertEqual(version, first(r'^  version: "(.*)"', "packaging/conda/recipe.yaml"))
        self.assertEqual(version, first(r'^version = "(.*)"', "packaging/habitat/pyproject.toml"))
        self.assertEqual(version, first(r'"enfilade==(.*?)"', "packaging/habitat/pyproject.toml"))

    def test_wheels_have_a_static_library_for_each_that_cmake_wants(self):
        script = text("packaging/libraries.sh")
        downloaded = set(re.findall(r"\b[-\w]+-dev\b", script))
        built = re.findall(r"^(\w+) +\w+/\S+ +[0-9a-f]{64}$", script, re.M)
        self.assertGreater(len(built), 5)
        for name in built:
            self.assertIn(f"build_{name}()", script)
        wanted = libraries_of_cmake()
        self.assertGreater(len(wanted), 15)
        for package in sorted(wanted - downloaded):
            self.assertIn(BUILT.get(package, package[3:-4]), built, package)

    def test_the_page_names_what_a_source_distribution_needs(self):
        named = set(release.source_packages(text("docs/installing.md")))
        self.assertLessEqual({"g++", "pkg-config", "python3-dev", "python3-venv"}, named)
        self.assertEqual(libraries_of_cmake() - named, set())
        ours = set(re.findall(r"^\w+ +(\S+) +(?:command|header|package) ", text("tools/packages.sh"), re.M))
        self.assertEqual(named - ours - {"python3-dev"}, set())

    def test_pip_builds_of_a_clone_what_a_wheel_has(self):
        settings, release_only = text("pyproject.toml").split("[[tool.scikit-build.overrides]]")
        self.assertIn('build.targets = ["enfilade_python", "enfilade"]', settings)
        self.assertIn('EN_WITH_WEB = "ON"', settings)
        self.assertNotRegex(settings, 'EN_(BUILD_APPS|WITH_D3) = "OFF"')
        # A release differs in where the pages come from, and in nothing that is built.
        overridden = re.findall(r"^(\S+) = ", release_only.split("\n[")[0], re.M)
        self.assertEqual(set(overridden), {"if.env.ENFILADE_WHEEL", "sdist.include", "sdist.exclude"})

    def test_of_pythons_that_share_the_stable_abi_the_oldest_builds(self):
        pythons = [release.Interpreter(str(v), v, t) for v, t in
                   (((3, 14), True), ((3, 14), False), ((3, 12), False), ((3, 9), False))]  # fmt: skip
        made = release.builders(sorted(pythons, key=lambda p: (p.version, p.free_threaded)))
        self.assertEqual([p.name for p in made], ["3.9", "3.12", "3.14t"])

    def test_the_drop_in_habitat_sim_is_in_its_own_wheel_alone(self):
        whole, own = "enfilade-0.1.0-cp312-abi3-linux_x86_64.whl", "enfilade_habitat-0.1.0-py3-none-any.whl"
        described = ["enfilade-0.1.0.dist-info/METADATA", "enfilade-0.1.0.data/scripts/enfilade"]
        release.check_packages(whole, ["enfilade/__init__.py", "MatterSim/__init__.py", *described])
        dropped = [f"{name}/__init__.py" for name in ("corrade", "habitat_sim", "magnum")]
        release.check_packages(own, [*dropped, "habitat_sim/nav/__init__.py", "enfilade_habitat-0.1.0.dist-info/WHEEL"])
        for wheel, files in ((whole, ["enfilade/__init__.py", "magnum/__init__.py"]), (own, dropped[:2]),
                             (own, [*dropped, "enfilade/__init__.py"]), (own, [])):  # fmt: skip
            with self.subTest(wheel=wheel, files=files), self.assertRaisesRegex(SystemExit, wheel):
                release.check_packages(wheel, files)

    def test_its_wheel_is_built_with_the_release_s_tools(self):
        (wanted,) = re.findall(r'^requires = \["(.*)"\]$', text("packaging/habitat/pyproject.toml"), re.M)
        self.assertIn(wanted, release.TOOLS)
        packages = re.findall(r'^"\.\./\.\./python/(\w+)" = "(\w+)"$', text("packaging/habitat/pyproject.toml"), re.M)
        self.assertEqual({a for a, b in packages if a == b}, release.HABITAT)

    def test_what_builds_is_read_from_pyproject(self):
        wanted = release.build_requirements(text("pyproject.toml"))
        self.assertEqual([re.match(r"[-\w]+", w)[0] for w in wanted], ["scikit-build-core"] + 3 * ["nanobind"])

    def test_the_changelog_s_part_is_its_newest_section(self):
        self.assertEqual(release.changes("# C\n\n## [2]\n\n## [1]\n\n- a\n\n## [0]\n\n- b\n"), "## [1]\n\n- a\n")
        self.assertIn("- ", release.changes(text("CHANGELOG.md")))


if __name__ == "__main__":
    unittest.main()
