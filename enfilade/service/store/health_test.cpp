#include "enfilade/service/store/database.h"

#include <gmock/gmock.h>
#include <fstream>
#include <limits>

#include "tests/support/databases.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::store {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

/// A database with one team in it, whose log was written into its file.
class HealthTest : public ::testing::Test {
 protected:
  void SetUp() override {
    EN_SKIP_ON_POSTGRES("there is no file");
    Database made(file_);
    made.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
  }

  tests::TemporaryFolder folder_{"health"};
  fs::path file_ = folder_.path() / "a.sqlite";
};

TEST_F(HealthTest, NothingIsWrongWithADatabaseThatWorks) {
  Database db(file_);
  std::vector<std::string> said;
  Health health(db, 1, [&said](std::string_view fault) { said.emplace_back(fault); });
  EXPECT_EQ(health.trouble(), std::nullopt);
  EXPECT_TRUE(said.empty());
  EXPECT_EQ(db.find_number("SELECT count(*) FROM team"), 1);
}

TEST_F(HealthTest, ADiskWithLessRoomThanIsWantedIsFull) {
  Database db(file_);
  std::vector<std::string> said;
  Health health(db, std::numeric_limits<std::uint64_t>::max(),
                [&said](std::string_view fault) { said.emplace_back(fault); });
  EXPECT_EQ(health.trouble(), Trouble::kDiskFull);
  EXPECT_EQ(health.trouble(), Trouble::kDiskFull);  // told once
  EXPECT_THAT(said, ElementsAre(HasSubstr("bytes are free")));
}

TEST_F(HealthTest, AFileThatIsNoLongerThereIsNoticed) {
  Database db(file_);
  fs::rename(file_, folder_.path() / "elsewhere.sqlite");
  EXPECT_EQ(Health(db, 1).trouble(), Trouble::kDatabaseReplaced);
  { const Database another(file_); }
  EXPECT_EQ(Health(db, 1).trouble(), Trouble::kDatabaseReplaced);
}

TEST_F(HealthTest, AFileThatIsOverwrittenOrCutOffIsNoticed) {
  const auto overwrite = [this] {
    std::fstream(file_, std::ios::in | std::ios::out | std::ios::binary)
        << std::string(fs::file_size(file_), 'x');
  };
  const auto cut_off = [this] { fs::resize_file(file_, 100); };
  const std::string whole = (folder_.path() / "whole").string();
  fs::copy_file(file_, whole);
  for (const std::function<void()>& damage : {std::function<void()>(overwrite), {cut_off}}) {
    fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
    for (const char* log : {"-wal", "-shm"}) fs::remove(file_.string() + log);
    Database db(file_);
    ASSERT_EQ(Health(db, 1).trouble(), std::nullopt);
    damage();
    EXPECT_EQ(Health(db, 1).trouble(), Trouble::kDatabaseUnreadable);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::store
