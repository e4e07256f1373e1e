#include "apps/enfilade/python_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cstdlib>

#include <filesystem>
#include <string>

#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::apps {
namespace EN_UNIT {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Module = PythonReport::Module;

/// A folder that Python imports from, alone.
class PythonReports : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("PYTHONPATH", folder_.path().c_str(), 1);
    setenv("PYTHONNOUSERSITE", "1", 1);
    setenv("PYTHONDONTWRITEBYTECODE", "1", 1);  // two texts of one second may be one size
  }
  void TearDown() override {
    unsetenv("PYTHONPATH");
    unsetenv("PYTHONNOUSERSITE");
    unsetenv("PYTHONDONTWRITEBYTECODE");
  }

  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = folder_.path() / name;
    std::filesystem::create_directories(file.parent_path());
    write_file_atomically(file, text);
    return file.string();
  }
  std::string script(const std::string& text) const {
    const std::string file = write("python", "#!/bin/sh\n" + text + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file;
  }

  /// What the machine's python3 tells, with this text in its habitat_sim.
  PythonReport with_module(const std::string& text) const {
    write("habitat_sim/__init__.py", text);
    return report_of_python("python3");
  }

 private:
  tests::TemporaryFolder folder_{"python_report"};
};

bool has_python() { return report_of_python("python3").error.empty(); }

TEST_F(PythonReports, TellTheDropInFromHabitatSim) {
  if (!has_python()) GTEST_SKIP() << "needs python3";
  const PythonReport real = with_module("print('loading')\n__version__ = '0.2.4'\n");
  EXPECT_EQ(real.error, "");
  EXPECT_THAT(real.version, StartsWith("3."));
  EXPECT_EQ(real.module, Module::kHabitats);
  EXPECT_THAT(real.path, HasSubstr("python_report"));
  EXPECT_THAT(real.path, HasSubstr("habitat_sim/__init__.py"));
  EXPECT_EQ(real.module_version, "0.2.4");
  write("habitat_sim/_missing.py", "");
  const PythonReport ours = with_module("__version__ = '0.3.3'\n");
  EXPECT_EQ(ours.module, Module::kOurs);
  EXPECT_EQ(ours.module_version, "0.3.3");
}

TEST_F(PythonReports, SayWhyAModuleCannotBeImported) {
  if (!has_python()) GTEST_SKIP() << "needs python3";
  const PythonReport lacking = with_module("import numpy_of_nobody\n");
  EXPECT_EQ(lacking.error, "");
  EXPECT_EQ(lacking.module, Module::kBroken);
  EXPECT_THAT(lacking.path, HasSubstr("habitat_sim/__init__.py"));
  EXPECT_EQ(lacking.fault, "ModuleNotFoundError: No module named 'numpy_of_nobody'");
  const PythonReport crashing = with_module("import os\nprint('libEGL', flush=True)\nos.abort()\n");
  EXPECT_EQ(crashing.module, Module::kBroken);
  EXPECT_EQ(crashing.fault, "it crashed (signal 6): libEGL");
  const PythonReport leaving = with_module("import sys\nsys.exit('no display')\n");
  EXPECT_EQ(leaving.fault, "SystemExit: no display");
  const PythonReport ending = with_module("import os\nos._exit(9)\n");
  EXPECT_EQ(ending.fault, "it ended with exit status 9");
}

TEST_F(PythonReports, SayWhyAnInterpreterTellsNothing) {
  EXPECT_EQ(report_of_python("/nowhere/python3").error, "No such file or directory");
  EXPECT_EQ(report_of_python(write("text", "no program")).error, "Permission denied");
  EXPECT_EQ(report_of_python(script("echo libpython is missing >&2; exit 3")).error,
            "it ended with exit status 3: libpython is missing");
  EXPECT_EQ(report_of_python(script("kill -SEGV $$")).error, "it crashed (signal 11)");
  EXPECT_EQ(report_of_python(script("exit 0")).error, "it ended with exit status 0");
  EXPECT_EQ(report_of_python(script("echo 'enfilade-doctor {\"version\"'")).error,
            "it ended with exit status 0");
  EXPECT_EQ(report_of_python(script("echo 'enfilade-doctor {\"version\": 3}'")).error,
            "it ended with exit status 0");
  EXPECT_EQ(report_of_python(script("printf '\\033[31mred'")).error,
            "it ended with exit status 0: \\x1b[31mred");
  // More than is kept: whole lines of it count.
  EXPECT_EQ(report_of_python(script("yes more | head -c 2000000; exit 3")).error,
            "it ended with exit status 3: more");
}

TEST_F(PythonReports, EndAPythonThatHangsWithAllThatItStarted) {
  EXPECT_EQ(report_of_python(script("sleep 100 & sleep 100"), 0.2).error, "no answer for 0.2 s");
  // The last line may be cut: the program is ended while it prints.
  EXPECT_THAT(report_of_python(script("while :; do echo more; done"), 0.2).error,
              AnyOf("no answer for 0.2 s: more", "no answer for 0.2 s: mor",
                    "no answer for 0.2 s: mo", "no answer for 0.2 s: m"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::apps
