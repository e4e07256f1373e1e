#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cstring>
#include <filesystem>

#include "enfilade/core/file.h"
#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {

const std::filesystem::path kDocs = std::filesystem::path(EN_SOURCE_DIR) / "docs/bad_input.md";

namespace EN_UNIT {

class BadInput : public ::testing::TestWithParam<std::size_t> {};

TEST_P(BadInput, GetsWhatTheTableSays) {
  const Case one = all_cases()[GetParam()];
  if (one.learns && EN_LEARNS == 0) GTEST_SKIP() << "the program is built without networks";
  if (one.asks && EN_ASKS == 0) GTEST_SKIP() << "the program is built without HTTP";
  const Outcome outcome = run(one);
  EXPECT_EQ(outcome.exit_code, one.exit_code) << one.input << "\n" << outcome.output;
  EXPECT_THAT(outcome.output, ::testing::HasSubstr(one.says)) << one.input;
  // What any malformed file may take at most, on any machine that runs the program.
  EXPECT_LT(outcome.most_memory, std::size_t{1} << 30U) << one.input;
  EXPECT_LT(outcome.work, 10) << one.input;
}

INSTANTIATE_TEST_SUITE_P(Case, BadInput, ::testing::Range(std::size_t{0}, all_cases().size()));

// A case that damages nothing would pass for the wrong reason.
TEST(BadInputHarness, GoodFilesAreAccepted) {
  for (const char* command :
       {"graph check {}/connectivity", "stats --data {} --split made",
        "score {}/results.json --data {} --split made", "run --data {} --split hidden"}) {
    const Outcome outcome = run({"", "", command, 0, "", {}});
    EXPECT_EQ(outcome.exit_code, 0) << command << "\n" << outcome.output;
  }
}

TEST(BadInputHarness, CasesEditWhatIsThere) {
  Files files;
  EXPECT_THROW(files.edit(kGraph, "not there", ""), std::logic_error);
}

TEST(BadInputDocs, PageIsWhatTheCasesMake) {
  EXPECT_GE(all_cases().size(), 40U);
  EXPECT_EQ(read_file(kDocs), docs_page()) << "run: bad_input_test --write-docs";
}

}  // namespace EN_UNIT

// Prints what each case really gets, to look at while writing one.
void show_outcomes() {
  for (const Case& one : all_cases()) {
    const Outcome outcome = run(one);
    fmt::print("--- {}: {}\n$ enfilade {}\nexit {} (wanted {}), wanted: {}\n{}\n", one.group,
               one.input, one.command, outcome.exit_code, one.exit_code, one.says, outcome.output);
  }
}

}  // namespace enfilade::bad_input

int main(int argc, char** argv) {
  using namespace enfilade;
  if (argc == 2 && std::strcmp(argv[1], "--write-docs") == 0) {
    write_file_atomically(bad_input::kDocs, bad_input::docs_page());
    return 0;
  }
  if (argc == 2 && std::strcmp(argv[1], "--show") == 0) {
    bad_input::show_outcomes();
    return 0;
  }
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
