// What a driver of OpenGL that crashes or hangs does to the program and to the library: nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cstdlib>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/render/devices.h"
#include "tests/support/emulated.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::render {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;

/// Sets an environment variable, for this process and those that it starts.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

const std::string kMesa = "/usr/share/glvnd/egl_vendor.d/50_mesa.json";

/// The driver of bad_driver.cpp, behaving so, is the machine's only one, or the first of two.
class BadDriver {
 public:
  explicit BadDriver(const std::string& behaviour, const std::string& beside = "")
      : vendors_("__EGL_VENDOR_LIBRARY_FILENAMES", description_of(folder_) + beside),
        behaviour_("EN_BAD_DRIVER", behaviour),
        // Of those that end by themselves, a process on a busy machine may take its time.
        seconds_("ENFILADE_GL_SECONDS",
                 behaviour == "hang" || behaviour == "chatter" ? "5" : "100") {}

 private:
  static std::string description_of(const tests::TemporaryFolder& folder) {
    const std::filesystem::path file = folder.path() / "bad.json";
    write_file_atomically(
        file,
        R"({"file_format_version": "1.0.0", "ICD": {"library_path": ")" EN_BAD_DRIVER R"("}})");
    return file.string();
  }

  tests::TemporaryFolder folder_{"bad_driver"};
  Variable vendors_, behaviour_, seconds_;
};

/// What `enfilade doctor --json` says. \pre it exits with `status`
nlohmann::json doctor(int status = 0) {
  const tests::TemporaryFolder folder("doctor");
  tests::Process process({EN_PROGRAM, "doctor", "--json"}, folder.path() / "said");
  EXPECT_EQ(process.wait(), status);
  return nlohmann::json::parse(read_file(folder.path() / "said"));
}

constexpr const char* kSection = "OpenGL through EGL";

/// Skipped where EGL does not load drivers that a variable names (all of GLVND's does).
class Drivers : public ::testing::Test {
 protected:
  void SetUp() override {
    if (tests::is_emulated()) {
      GTEST_SKIP() << "the program cannot start itself to try a driver (qemu-user)";
    }
    const BadDriver driver("refuse");
    const nlohmann::json said = doctor();
    if (said[kSection].contains("EGL")) GTEST_SKIP() << said[kSection]["EGL"]["text"];
    if (said["rendering"]["gl"]["works"]) {
      GTEST_SKIP() << "this machine's EGL loads its own drivers in spite of "
                      "__EGL_VENDOR_LIBRARY_FILENAMES";
    }
  }
};

/// What doctor says of the one device there is.
std::string told_by_doctor(const std::string& behaviour) {
  const BadDriver driver(behaviour);
  const nlohmann::json said = doctor();
  EXPECT_TRUE(said["rendering"]["cpu"]["works"]);
  EXPECT_FALSE(said["rendering"]["gl"]["works"]);
  const nlohmann::json& device = said[kSection]["default"];
  EXPECT_FALSE(device["works"]);
  EXPECT_THAT(device["advice"], HasSubstr("cpu back end"));
  return device["text"].get<std::string>();
}

TEST_F(Drivers, DoctorSurvivesEveryBehaviour) {
  // With LLVM of a libtorch in the program, Mesa's was loaded before: keep_mesa_to_its_llvm().
  const auto fault = [](const std::string& what) {
    const std::string before =
        "EGL device default: the OpenGL driver " + what + "; drivers that were loaded: ";
    return ::testing::AnyOf(before + "libEGL_bad.so", before + "libEGL_mesa.so.0, libEGL_bad.so");
  };
  EXPECT_THAT(told_by_doctor("crash"), fault("crashed (SIGSEGV in libEGL_bad.so)"));
  EXPECT_THAT(told_by_doctor("abort"), fault("crashed (SIGABRT)"));
  EXPECT_THAT(told_by_doctor("exit"), fault("ended the process that tried it (exit status 7)"));
  EXPECT_THAT(told_by_doctor("hang"), fault("hung (no answer for 5 s)"));
  EXPECT_THAT(told_by_doctor("chatter"), fault("hung (no answer for 5 s)"));
}

TEST_F(Drivers, DoctorSurvivesACrashWhileDevicesAreListed) {
  const BadDriver driver("crash-at-load");
  const nlohmann::json said = doctor();
  EXPECT_TRUE(said["rendering"]["cpu"]["works"]);
  EXPECT_FALSE(said["rendering"]["gl"]["works"]);
  EXPECT_THAT(said[kSection]["all"]["text"],
              HasSubstr("crashed (SIGSEGV in libEGL_bad.so) while the EGL devices were listed"));
}

TEST_F(Drivers, OneThatCrashesDoesNotHideAnotherThatWorks) {
  if (!std::filesystem::exists(kMesa)) GTEST_SKIP() << "no Mesa: " << kMesa << " is not there";
  const BadDriver driver("crash", ":" + kMesa);
  const nlohmann::json said = doctor();
  if (!said[kSection].contains("device 0") || !said[kSection]["device 0"]["works"]) {
    GTEST_SKIP() << "Mesa's own device does not work: " << said[kSection].dump();
  }
  EXPECT_TRUE(said["rendering"]["gl"]["works"]);
  EXPECT_THAT(said[kSection]["default"]["text"], HasSubstr("SIGSEGV in libEGL_bad.so"));
}

RendererConfig on_gl(const std::string& device = "") {
  RendererConfig config;
  config.backend = Backend::kGl;
  config.gl_device = device;
  return config;
}

std::string refusal_of(const RendererConfig& config) {
  return tests::refusal([&] { make_renderer(sample_faces(), config); });
}

void draw_on_cpu() {
  const auto renderer = make_renderer(sample_faces());
  check_sample(*renderer);
}

class Library : public Drivers {
 protected:
  void SetUp() override {
    Drivers::SetUp();
    set_gl_trial({EN_PROGRAM, "try-gl"});
  }
  void TearDown() override { set_gl_trial({}); }
};

TEST_F(Library, GetsAnErrorThatNamesDeviceDriverAndSignal) {
  const BadDriver driver("crash");
  const std::string text = refusal_of(on_gl());
  EXPECT_THAT(text, HasSubstr("EGL device default: the OpenGL driver crashed (SIGSEGV in "
                              "libEGL_bad.so)"));
  EXPECT_THAT(text, HasSubstr("the cpu back end needs no OpenGL"));
  draw_on_cpu();
  EXPECT_THAT(read_file("/proc/self/maps"), Not(HasSubstr("libEGL")))
      << "no driver may come into this process";
}

TEST_F(Library, TriesADeviceOnceInAProcess) {
  const BadDriver driver("hang");
  const std::string first = refusal_of(on_gl());
  EXPECT_THAT(first, HasSubstr("hung (no answer for 5 s)"));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(refusal_of(on_gl()), first);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST_F(Library, ThreadsGetTheSameAnswer) {
  const BadDriver driver("crash");
  std::vector<std::string> texts(4);
  {
    std::vector<std::jthread> threads;
    for (std::string& text : texts) {
      threads.emplace_back([&text] {
        text = refusal_of(on_gl());
        draw_on_cpu();
      });
    }
  }
  for (const std::string& text : texts) EXPECT_EQ(text, texts[0]);
  EXPECT_THAT(texts[0], HasSubstr("SIGSEGV"));
}

TEST_F(Library, StillRefusesADeviceThatIsNone) {
  const BadDriver driver("refuse");
  EXPECT_THAT(tests::refusal<ArgumentError>([] { make_renderer(sample_faces(), on_gl("seven")); }),
              HasSubstr("gl_device \"seven\": no index or UUID of an EGL device"));
}

TEST_F(Library, DrawsOnADeviceThatAnotherProcessFoundGood) {
  const auto devices = gl_devices();
  if (std::ranges::none_of(devices, &GlDevice::works)) GTEST_SKIP() << "no OpenGL device works";
  const auto renderer = make_renderer(sample_faces(), on_gl());
  check_sample(*renderer);
  EXPECT_THAT(renderer->description(), HasSubstr("gl ("));
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
