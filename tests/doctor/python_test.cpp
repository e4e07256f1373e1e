// What `enfilade doctor` says of Python: which habitat_sim it imports, if it starts at all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cstdlib>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "enfilade/core/file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string text_of(const nlohmann::json& section, const char* name, const char* field = "text") {
  return section.contains(name) ? section[name].value(field, std::string()) : std::string();
}

/// Its section on Python, with this folder before others on PATH and PYTHONPATH.
nlohmann::json doctor_on_python(const std::filesystem::path& folder) {
  const char* path = std::getenv("PATH");
  tests::Process process({EN_PROGRAM, "doctor", "--json"}, folder / "said",
                         {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null"},  // no driver takes time
                          {"PATH", folder.string() + ":" + (path == nullptr ? "" : path)},
                          {"PYTHONPATH", folder.string()},
                          {"PYTHONDONTWRITEBYTECODE", "1"}});
  EXPECT_EQ(process.wait(), 0);
  return nlohmann::json::parse(read_file(folder / "said"))["Python"];
}

TEST(Doctor, TellsWhichHabitatSimIsImported) {
  if (tests::Process({"/bin/sh", "-c", "exec python3 -c ''"}).wait() != 0) {
    GTEST_SKIP() << "needs python3";
  }
  const tests::TemporaryFolder folder("doctor_python");
  const std::filesystem::path module = folder.path() / "habitat_sim";
  std::filesystem::create_directory(module);
  write_file_atomically(module / "__init__.py", "__version__ = '0.3.3'\n");
  nlohmann::json said = doctor_on_python(folder.path());
  EXPECT_THAT(text_of(said, "interpreter"), StartsWith("python3 3."));
  EXPECT_THAT(text_of(said, "habitat_sim"), StartsWith("Habitat-Sim itself, 0.3.3: /"));
  EXPECT_FALSE(said["habitat_sim"].contains("works"));
  write_file_atomically(module / "_missing.py", "");
  said = doctor_on_python(folder.path());
  EXPECT_THAT(text_of(said, "habitat_sim"), StartsWith("Enfilade's drop-in, as 0.3.3: /"));
  write_file_atomically(module / "__init__.py", "import quaternion_of_nobody\n");
  said = doctor_on_python(folder.path());
  EXPECT_FALSE(said["habitat_sim"]["works"]);
  EXPECT_THAT(text_of(said, "habitat_sim"), HasSubstr("No module named 'quaternion_of_nobody'"));
  EXPECT_THAT(text_of(said, "habitat_sim", "advice"), HasSubstr("install what it lacks"));
}

TEST(Doctor, ReportsTheRestBesideABrokenPython) {
  const tests::TemporaryFolder folder("broken_python");
  const std::filesystem::path python = folder.path() / "python3";
  write_file_atomically(python, "#!/bin/sh\necho no libpython >&2\nexit 1\n");
  std::filesystem::permissions(python, std::filesystem::perms::owner_all);
  const nlohmann::json said = doctor_on_python(folder.path());
  EXPECT_FALSE(said["interpreter"]["works"]);
  EXPECT_EQ(text_of(said, "interpreter"), "python3: it ended with exit status 1: no libpython");
  EXPECT_FALSE(said.contains("habitat_sim"));
}

}  // namespace EN_UNIT
}  // namespace enfilade
