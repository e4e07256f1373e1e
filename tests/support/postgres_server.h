/// \file  A PostgreSQL server for tests: made anew in a folder of its own, gone with its object.
#pragma once
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {

/// Listens on a socket in its folder alone. Not for several threads.
class PostgresServer {
 public:
  /// The folder with the programs of the newest server that is installed as Debian does it.
  static std::optional<std::filesystem::path> programs() {
    namespace fs = std::filesystem;
    std::vector<std::pair<int, fs::path>> found;
    std::error_code error;
    for (const auto& one : fs::directory_iterator("/usr/lib/postgresql", error)) {
      const fs::path bin = one.path() / "bin";
      if (fs::exists(bin / "initdb")) {
        found.emplace_back(std::atoi(one.path().filename().c_str()), bin);
      }
    }
    if (found.empty()) return std::nullopt;
    return std::ranges::max(found).second;
  }

  /// \throws std::runtime_error if it cannot be made  \pre programs()
  PostgresServer() : programs_(programs().value()) {
    if (::geteuid() == 0 && ::chown(folder_.path().c_str(), kNobody, kNobody) != 0) {
      throw std::runtime_error("chown");
    }
    run("initdb", {"-D", data(), "-U", "postgres", "-A", "trust", "-E", "UTF8", "--locale=C.UTF-8",
                   "--no-sync"});
    start();
  }
  ~PostgresServer() { crash(); }
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  /// Returns when it answers.
  void start() {
    // Tests end processes, not machines: without fsync nothing is lost, and after a crash in the
    // middle of thousands of tables nobody waits for a minute.
    server_.emplace(
        words("postgres", {"-D", data(), "-k", folder_.path(), "-c", "listen_addresses=", "-c",
                           "max_connections=200", "-c", "fsync=off"}));
    for (int k = 0; k < 600; ++k) {
      Process asks(words("pg_isready", {"-q", "-h", folder_.path()}));
      if (asks.wait() == 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    throw std::runtime_error("the PostgreSQL server does not start");
  }
  /// Ends it at once, in the middle of all: what it has not written is lost.
  void crash() {
    ::kill(server_->pid(), SIGQUIT);
    server_->wait();
  }
  /// Makes an empty database. \param options of createdb  \returns its URL
  std::string make_database(std::vector<std::string> options = {}) {
    const std::string name = "test_" + std::to_string(++made_);
    options.insert(options.end(), {"-h", folder_.path(), "-U", "postgres", name});
    run("createdb", options);
    return url_of(name);
  }
  /// Makes an empty schema, which is to its users as a database of their own, in a tenth of the
  /// time and of the room. \returns its URL
  std::string make_schema() {
    const std::string name = "test_" + std::to_string(++made_);
    run_sql(url_of("postgres"), "CREATE SCHEMA " + name);
    return url_of("postgres") + "&options=-csearch_path%3D" + name;
  }
  /// \param url  of a database or a schema
  void run_sql(const std::string& url, const std::string& sql) const {
    run("psql", {"-q", "-v", "ON_ERROR_STOP=1", "-c", sql, url});
  }
  /// All that a database holds, with all schemas, as SQL. \param url  of it
  std::filesystem::path dump(const std::string& url) {
    std::filesystem::path file = folder_.path() / "dump.sql";
    run("pg_dump", {"-f", file, url});
    return file;
  }

 private:
  static constexpr int kNobody = 65534;  // no server runs for root

  std::string url_of(const std::string& database) const {
    return "postgresql://postgres@/" + database + "?host=" + folder_.path().string();
  }
  std::string data() const { return folder_.path() / "data"; }
  std::vector<std::string> words(const std::string& program,
                                 const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"/usr/bin/setpriv", "--pdeathsig", "QUIT"};
    if (::geteuid() == 0) {
      const std::string nobody = std::to_string(kNobody);
      all.insert(all.end(), {"--reuid", nobody, "--regid", nobody, "--clear-groups"});
    }
    all.insert(all.end(), {"--", programs_ / program});
    all.insert(all.end(), arguments.begin(), arguments.end());
    return all;
  }
  void run(const std::string& program, const std::vector<std::string>& arguments) const {
    Process process(words(program, arguments));
    if (process.wait() != 0) throw std::runtime_error(program + " has failed");
  }

  std::filesystem::path programs_;
  TemporaryFolder folder_{"postgres"};
  std::optional<Process> server_;
  int made_ = 0;
};

}  // namespace enfilade::tests
