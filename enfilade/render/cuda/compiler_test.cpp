// NVRTC needs no card: where it is installed, the kernels are compiled for all cards.
#include "enfilade/render/cuda/compiler.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <regex>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/render/cuda/job.h"
#include "enfilade/render/devices.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::render::cuda {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Why there is none, in `reason`.
std::optional<Compiler> compiler(std::string& reason) {
#ifdef EN_TEST_NVRTC  // where the tests' Python has it
  setenv("ENFILADE_NVRTC", EN_TEST_NVRTC, 0);
#endif
  try {
    return Compiler();
  } catch (const Error& error) {
    reason = error.what();
    return {};
  }
}

std::vector<Kinds> kinds_that_are_hot(bool every) {
  if (!every) return {{kRgb}, {kPlanar16, kMetres}, {kRgb, kLegacyUnits, kClass8, true, true}};
  std::vector<Kinds> all;
  for (const ColourKind colour : {kNoColour, kRgb, kBgr, kRgba, kPlanar16, kPlanar32}) {
    for (const DepthKind depth : {kNoDepth, kMetres, kUnits}) {
      if (colour != kNoColour || depth != kNoDepth)
        all.push_back({.colour = colour, .depth = depth});
    }
  }
  all.push_back({kRgb, kMetres, kClass16, true, false});
  all.push_back({kRgb, kLegacyUnits, kClass8, true, true});
  all.push_back({kNoColour, kLegacyMetres, kNoClasses, false, false});
  return all;
}

// Of all numbers in a text that the expression finds; -1 for none.
int largest(const std::string& text, const std::string& expression) {
  const std::regex number(expression);
  int most = -1;
  for (std::sregex_iterator at(text.begin(), text.end(), number), end; at != end; ++at) {
    most = std::max(most, std::stoi((*at)[1]));
  }
  return most;
}

TEST(CudaCompiler, CompilesForAllCards) {
  std::string reason;
  const auto nvrtc = compiler(reason);
  if (!nvrtc) GTEST_SKIP() << reason;
  int tried = 0;
  for (const int capability : {70, 75, 80, 86, 90, 100}) {
    if (std::ranges::find(nvrtc->capabilities(), capability) == nvrtc->capabilities().end())
      continue;
    // All of one card's; of the others the first, to keep the test short.
    for (const Kinds& kinds : kinds_that_are_hot(capability == 90)) {
      const Compiler::Compiled compiled = nvrtc->compile({kinds.definitions()}, capability);
      EXPECT_EQ(compiled.image.substr(1, 3), "ELF");
      ++tried;
      // ptxas tells of each kernel: "N bytes spill stores", "Used N registers". Few registers are
      // asked for, so that many warps are there (Variant::kBlocks). What finds no room is of the
      // plan of a row, which is made once for hundreds of pixels; more than this would be theirs.
      EXPECT_LE(largest(compiled.log, "([0-9]+) bytes spill stores"), 256) << compiled.log;
      const int registers = largest(compiled.log, "Used ([0-9]+) registers");
      EXPECT_GT(registers, 0) << compiled.log;
      EXPECT_LE(registers, 64) << capability << '\n' << compiled.log;
    }
  }
  EXPECT_GT(tried, 0);
}

TEST(CudaCompiler, TellsWhatItDoesNotCompile) {
  std::string reason;
  const auto nvrtc = compiler(reason);
  if (!nvrtc) GTEST_SKIP() << reason;
  EXPECT_THAT([&] { nvrtc->compile({{"EN_COLOUR=1"}}, 90); },
              ThrowsMessage<Error>(HasSubstr("EN_DEPTH")));
  EXPECT_THAT([&] { nvrtc->compile({Kinds{kRgb}.definitions()}, 12); },
              ThrowsMessage<Error>(HasSubstr("compute capability 1.2")));
}

TEST(CudaImages, AreFoundAgainWithoutACompiler) {
  std::string reason;
  const auto nvrtc = compiler(reason);
  if (!nvrtc) GTEST_SKIP() << reason;
  const tests::TemporaryFolder folder("images");
  const Images images(folder.path() / "made" / "cuda");
  const KernelSource source{Kinds{kRgb}.definitions()};
  const int capability = nvrtc->capabilities().back();
  const std::string first = images.find_or_compile(source, capability);
  const auto files = std::filesystem::directory_iterator(folder.path() / "made" / "cuda");
  ASSERT_EQ(std::distance(begin(files), end(files)), 1);
  // A marked file shows that it is what comes back.
  const auto file = std::filesystem::directory_iterator(folder.path() / "made" / "cuda")->path();
  write_file_atomically(file, first + "mark");
  EXPECT_EQ(images.find_or_compile(source, capability), first + "mark");
}

TEST(CudaReport, TellsWhatIsMissing) {
  const CudaReport report = cuda_report();
  if (report.devices.empty()) {
    EXPECT_THAT(report.error, HasSubstr("CUDA: ")) << "neither a card nor a reason";
  }
  if (report.compiler.empty()) {
    EXPECT_THAT(report.compiler_error, HasSubstr("NVRTC"));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::render::cuda
