// Linked into each test program: what would begin after the end of a run's time is skipped, with
// that reason. A run that is killed says nothing, of no test. `.ci/run` sets the times; without
// them nothing is skipped.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

namespace {

class Until : public ::testing::Environment {
 public:
  void SetUp() override {
    const bool slow = std::getenv("ENFILADE_TEST_IS_SLOW") != nullptr;  // ctest's label
    const char* until = std::getenv(slow ? "ENFILADE_SLOW_UNTIL" : "ENFILADE_TESTS_UNTIL");
    if (until == nullptr || std::time(nullptr) <= std::atoll(until)) return;
    // GoogleTest prints neither line for a skipped environment; ctest and the summary look for
    // them.
    std::puts("tests/support/until.cpp: Skipped\nthe time of this run is over\n[  SKIPPED ] all");
    GTEST_SKIP() << "the time of this run is over";
  }
};

[[maybe_unused]] const ::testing::Environment* const kUntil =
    ::testing::AddGlobalTestEnvironment(new Until);

}  // namespace
