// enfilade study, on three homes and two updates: what is done is not done again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using tests::Process;

class StudyTest : public ::testing::Test {
 protected:
  int run(std::vector<std::string> words) const {
    words.insert(words.begin(), EN_PROGRAM);
    return Process(words).wait();
  }
  int study(const std::string& seeds) const {
    return run({"study", "-o", folder_.path(), "--homes", "3,2", "--seeds", seeds, "--iterations",
                "2", "--batch", "2", "--hidden", "8"});
  }
  fs::path model(const std::string& name) const { return folder_.path() / "models" / name; }

  tests::TemporaryFolder folder_{"study"};
};

TEST_F(StudyTest, MakesAPageAndKeepsWhatIsDone) {
  // An encoder that has learnt little, so that the study's own does not have to be waited for.
  const std::string homes = folder_.path() / "homes";
  ASSERT_EQ(run({"homes", "-o", homes, "--preset", "training", "--homes", "6", "--tasks", "r2r"}),
            0);
  ASSERT_EQ(run({"pretrain", "--data", homes, "-o", folder_.path() / "encoder.safetensors",
                 "--pictures", "40", "--epochs", "1"}),
            0);
  ASSERT_EQ(study("1"), 0);
  const std::string page = read_file(folder_.path() / "study.html");
  EXPECT_THAT(page, HasSubstr("SYNTHETIC"));
  EXPECT_THAT(page, HasSubstr("<tr><td>2</td><td>1</td>"));
  EXPECT_THAT(page, HasSubstr("<tr><td>3</td><td>1</td>"));
  const fs::path weights = model("homes2_seed1") / "weights.safetensors";
  const auto made = fs::last_write_time(weights);
  // The homes have a few dozen viewpoints, enough for what a linear probe does.
  EXPECT_EQ(run({"pretrain", "--data", homes, "--probe", folder_.path() / "features.safetensors"}),
            0);
  ASSERT_EQ(study("2"), 0);
  EXPECT_EQ(fs::last_write_time(weights), made);
  EXPECT_THAT(read_file(folder_.path() / "study.html"), HasSubstr("<tr><td>2</td><td>2</td>"));
  // A larger point needs more homes than the folder has been made with.
  EXPECT_EQ(run({"study", "-o", folder_.path(), "--homes", "30"}), 3);
}

}  // namespace EN_UNIT
}  // namespace enfilade
