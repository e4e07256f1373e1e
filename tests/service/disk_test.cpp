// A disk that is really full: a file system of 96 MiB in memory, which the server alone sees.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>
#include <cerrno>

#include "tests/service/program.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::Program;

class FullDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    EN_SKIP_ON_POSTGRES("its disk is another program's");
    if (tests::Process({"/bin/sh", "-c", on_small_disk("true")}).wait() != 0) {
      GTEST_SKIP() << "this machine lets us mount nothing (unshare --user --mount)";
    }
    testing::write_served_data(root_);
    write_file_atomically(
        root_ / "phases.json",
        R"({"phases": [{"name": "open", "split": "val_seen", "per_day": 1000}]})");
  }

  /// A command of the shell, on the disk.
  std::string on_small_disk(const std::string& command) {
    fs::create_directories(disk_);
    return "exec unshare --user --map-root-user --mount /bin/sh -c 'mount -t tmpfs -o size=96m "
           "none " +
           disk_.string() + " && " + command + "' sh \"$@\"";
  }
  /// A script that runs the server on the disk. \param before  a command, done first
  std::string server(const std::string& before = "true") {
    const fs::path script = root_ / "server.sh";
    write_file_atomically(script,
                          "#!/bin/sh\n" + on_small_disk(before + " && exec " EN_PROGRAM " \"$@\""));
    fs::permissions(script, fs::perms::owner_all);
    return script;
  }

  tests::TemporaryFolder folder_{"disk"};
  fs::path root_ = folder_.path(), disk_ = root_ / "disk";
};

/// What is left of a disk, taken until there is nothing.
class Filler {
 public:
  explicit Filler(fs::path file) : file_(std::move(file)) {
    const int descriptor = ::open(file_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
    EXPECT_GE(descriptor, 0) << file_;
    for (const std::size_t size : {std::size_t{1} << 20U, std::size_t{1} << 12U}) {
      const std::string block(size, 'x');
      while (::write(descriptor, block.data(), size) > 0) {
      }
    }
    EXPECT_EQ(errno, ENOSPC);
    ::close(descriptor);
  }
  ~Filler() { fs::remove(file_); }
  Filler(const Filler&) = delete;
  Filler& operator=(const Filler&) = delete;

 private:
  fs::path file_;
};

int submit(int port, const httplib::Headers& team, const std::string& method) {
  httplib::Client client("127.0.0.1", port);
  const auto answer = client.Post("/api/v1/submissions?phase=open&method=" + method, team,
                                  testing::row_results(2), "application/json");
  return answer ? answer->status : 0;
}

std::string health(int port, int wanted) {
  httplib::Client client("127.0.0.1", port);
  std::string said;
  for (int k = 0; k < 100; ++k) {
    const auto answer = client.Get("/healthz");
    said = std::to_string(answer->status) + " " + answer->body;
    if (answer->status == wanted) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return said;
}

TEST_F(FullDisk, WhatWasAcknowledgedStaysTheRestIsRefusedAndRoomMakesItGoOn) {
  Program program(server(), root_ / "data", disk_ / "service.sqlite",
                  {"--phases", root_ / "phases.json", "--open-registration"});
  program.start();
  const int port = program.port();
  const httplib::Headers team = testing::make_team(port, "A");
  EXPECT_THAT(health(port, 200), HasSubstr("200 "));
  std::vector<std::string> acknowledged{"before"};
  ASSERT_EQ(submit(port, team, "before"), 202);
  {
    const fs::path seen = "/proc/" + std::to_string(program.pid()) + "/root" + disk_.string();
    const Filler filler(seen / "filler");
    int refused = 0;
    for (int k = 0; k < 40; ++k) {
      const std::string method = "full-" + std::to_string(k);
      const int status = submit(port, team, method);
      if (status == 202) {
        acknowledged.push_back(method);  // SQLite had room in its files
      } else {
        EXPECT_EQ(status, 503);
        ++refused;
      }
    }
    EXPECT_GT(refused, 0);
    EXPECT_THAT(health(port, 503), HasSubstr("\"disk-full\""));
    httplib::Client client("127.0.0.1", port);
    EXPECT_EQ(client.Get("/api/v1/scans/row/viewpoints/v0/faces/0.jpg")->status, 200);
    EXPECT_EQ(client.Get("/api/v1/submissions", team)->status, 200);
  }
  EXPECT_THAT(health(port, 200), HasSubstr("200 "));
  EXPECT_EQ(submit(port, team, "after"), 202);
  acknowledged.emplace_back("after");
  const std::map<std::string, int> found = testing::count_methods(port, team);
  EXPECT_EQ(found.size(), acknowledged.size());
  for (const std::string& method : acknowledged) {
    const auto at = found.find(method);
    EXPECT_TRUE(at != found.end() && at->second == 1) << method;
  }
}

TEST_F(FullDisk, NoServerStartsOnOne) {
  const std::string fill = "! dd if=/dev/zero of=" + (disk_ / "filler").string() + " bs=4096";
  tests::Process process(
      {server(fill), "serve", root_ / "data", "--db", disk_ / "service.sqlite", "--port", "0"});
  EXPECT_EQ(process.wait(), 3);  // a file that cannot be written
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
