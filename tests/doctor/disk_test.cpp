// What `enfilade doctor` says of a disk that is really small: one in memory, which it alone sees.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "enfilade/core/file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;

TEST(Doctor, TellsWhichDiskHasTooLittleRoomAndWhatToDo) {
  const tests::TemporaryFolder folder("small_disk");
  const std::string disk = folder.path() / "disk", said = folder.path() / "said";
  std::filesystem::create_directory(disk);
  const auto on_small_disk = [&](const std::string& command) {
    return std::vector<std::string>{
        "/bin/sh", "-c",
        "exec unshare --user --map-root-user --mount /bin/sh -c 'mount -t tmpfs -o size=8m none " +
            disk + " && cd " + disk + " && " + command + "'"};
  };
  if (tests::Process(on_small_disk("true")).wait() != 0) {
    GTEST_SKIP() << "this machine lets us mount nothing (unshare --user --mount)";
  }
  tests::Process process(on_small_disk("exec env TMPDIR=. " EN_PROGRAM " doctor --json"), said);
  ASSERT_EQ(process.wait(), 0);
  const nlohmann::json disks = nlohmann::json::parse(read_file(said))["disk"];
  const nlohmann::json& here = disks["working folder"];
  EXPECT_FALSE(here["works"]);
  EXPECT_EQ(here["text"], disk + ": 8 MiB free of 8 MiB");
  EXPECT_EQ(here["advice"],
            "model homes, features and models take up to 1.0 GiB: make room on that disk, or start "
            "in a folder on another disk, or give -o one");
  EXPECT_FALSE(disks["temporary folder"]["works"]);
  EXPECT_THAT(disks["temporary folder"]["advice"], HasSubstr("environment variable TMPDIR"));
  EXPECT_TRUE(disks["shared memory"].is_null() || disks["shared memory"].contains("works"));
}

}  // namespace EN_UNIT
}  // namespace enfilade
