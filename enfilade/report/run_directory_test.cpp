#include "enfilade/report/run_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/report/results_table.h"
#include "tests/support/made_run.h"

namespace enfilade::report {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class RunDirectoryTest : public ::testing::Test {
 protected:
  RunDirectory find(const std::vector<fs::path>& named) const {
    return find_runs(named, dataset::Dataset(made_.data()));
  }
  void model(const std::string& name) const {
    make_folder(made_.run() / "models" / name);
    write_file_atomically(made_.run() / "models" / name / "config.json", "{}");
    made_.write_results(made_.run() / "models" / name / "results/val_seen.json", 2);
  }
  static std::vector<std::string> names(const RunDirectory& found) {
    std::vector<std::string> names;
    for (const ResultsFile& one : found.results) names.push_back(one.agent + "@" + one.split);
    return names;
  }
  testing::MadeRun made_;
};

TEST(WithoutSeed, TakesANumberAtTheEndOnly) {
  EXPECT_EQ(without_seed("student-2"), "student");
  EXPECT_EQ(without_seed("student-12"), "student");
  EXPECT_EQ(without_seed("student"), "student");
  EXPECT_EQ(without_seed("student-language-3"), "student-language");
  EXPECT_EQ(without_seed("resnet50"), "resnet50") << "no '-' before the number";
  EXPECT_EQ(without_seed("-1"), "-1") << "nothing would be left";
  EXPECT_EQ(without_seed("student-"), "student-");
}

TEST_F(RunDirectoryTest, FindsResultsAndModelsInThePapersOrder) {
  for (const char* name : {"student-10", "student-2", "teacher", "ablation"}) model(name);
  made_.write_results(made_.run() / "results/random_val_seen.json", 1);
  made_.write_results(made_.run() / "results/shortest_val_seen.json", 1);
  write_file_atomically(made_.run() / "results/notes.json", "{}");
  write_file_atomically(made_.run() / "models/teacher/results/val_seen.attention.json", "{}");
  EXPECT_THAT(names(find({made_.run()})),
              ElementsAre("shortest@val_seen", "random@val_seen", "teacher@val_seen",
                          "student-2@val_seen", "student-10@val_seen", "ablation@val_seen"));
  EXPECT_EQ(find({made_.run()}).models.size(), 4U);
}

TEST_F(RunDirectoryTest, FindsPackedResultsAndThoseWithAByteOrderMark) {
  const fs::path plain = made_.run() / "results/random_val_seen.json";
  made_.write_results(plain, 1);
  const std::string text = read_file(plain);
  write_file_atomically(made_.run() / "results/other_val_seen.json.gz", gzip(text, 6));
  write_file_atomically(made_.run() / "results/marked_val_seen.json", "\xEF\xBB\xBF" + text);
  EXPECT_THAT(names(find({made_.run()})),
              ElementsAre("random@val_seen", "marked@val_seen", "other@val_seen"));
}

TEST_F(RunDirectoryTest, TakesThePlainFileOfTwoAndThePackedOneInItsPlace) {
  const fs::path plain = made_.run() / "results/random_val_seen.json";
  made_.write_results(plain, 1);
  const fs::path packed = plain.string() + ".gz";
  write_file_atomically(packed, gzip(read_file(plain), 6));
  const auto files = [this](const fs::path& named) {
    std::vector<fs::path> found;
    for (const ResultsFile& one : find({named}).results) found.push_back(one.file);
    return found;
  };
  EXPECT_THAT(files(made_.run()), ElementsAre(plain));
  fs::remove(plain);
  EXPECT_THAT(files(made_.run()), ElementsAre(packed));
  EXPECT_THAT(files(plain), ElementsAre(packed)) << "by the name that it had";
  write_file_atomically(packed, gzip(R"([{"instruction_id": 1, "path": []}])", 6));
  const tasks::Benchmark* found = find_benchmark_of_runs(std::vector{plain});
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->name, "rxr");
}

TEST_F(RunDirectoryTest, TakesFilesAndModelsByName) {
  model("student");
  made_.write_results(made_.run() / "my_agent_val_unseen.json", 1);
  EXPECT_THAT(names(find({made_.run() / "my_agent_val_unseen.json"})),
              ElementsAre("my_agent@val_unseen"));
  EXPECT_THAT(names(find({made_.run() / "models/student/"})), ElementsAre("student@val_seen"));
  EXPECT_THAT(names(find({made_.run() / "models/student/results/val_seen.json"})),
              ElementsAre("student@val_seen"));
  EXPECT_THAT(names(find({made_.run() / "models/student", made_.run()})),
              ElementsAre("student@val_seen", "my_agent@val_unseen"))
      << "the same one twice is one";
}

TEST_F(RunDirectoryTest, SaysWhatItCannotPlace) {
  made_.write_results(made_.run() / "random_val_other.json", 1);
  EXPECT_THAT([this] { find({made_.run() / "random_val_other.json"}); },
              ThrowsMessage<LookupError>(HasSubstr("AGENT_SPLIT.json")));
  EXPECT_THAT([this] { find({made_.run()}); },
              ThrowsMessage<LookupError>(HasSubstr("no results file")));
  EXPECT_THAT([this] { find({made_.run() / "nothing"}); },
              ThrowsMessage<FileError>(HasSubstr("there is none")));
}

TEST_F(RunDirectoryTest, RefusesTwoFilesOfOneAgentAndSplit) {
  made_.write_results(made_.run() / "random_val_seen.json", 1);
  made_.write_results(made_.run() / "results/random_val_seen.json", 1);
  EXPECT_THAT([this] { find({made_.run()}); },
              ThrowsMessage<LookupError>(HasSubstr("both of agent random on val_seen")));
}

TEST(Published, IsFoundByTheAgentsNameAndNotForAblations) {
  EXPECT_EQ(published_row("student-forcing", "val_unseen")->success, 0.218);
  EXPECT_EQ(published_row("teacher-2", "val_seen")->nav_error, 8.01);
  EXPECT_FALSE(published_row("student-language", "val_seen"));
  EXPECT_FALSE(published_row("random", "train"));
}

TEST_F(RunDirectoryTest, MadeUpDataSaySo) {
  EXPECT_FALSE(dataset::Dataset(made_.data()).synthetic());
  write_file_atomically(made_.data() / "README.md", "# Real\nNot SYNTHETIC.\n");
  EXPECT_FALSE(dataset::Dataset(made_.data()).synthetic());
  write_file_atomically(made_.data() / "README.md", "# A small SYNTHETIC data set\n");
  EXPECT_TRUE(dataset::Dataset(made_.data()).synthetic());
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
