/// \file  `enfilade serve` as a process of its own, for tests that kill it or crowd it.
#pragma once
#include <httplib.h>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::testing {

/// Makes a team by a server with open registration; its headers.
inline httplib::Headers make_team(int port, const std::string& name) {
  httplib::Client client("127.0.0.1", port);
  const auto made =
      client.Post("/api/v1/teams", nlohmann::json{{"name", name}}.dump(), "application/json");
  const auto answer = nlohmann::json::parse(made->body);
  return {{"Authorization", "Bearer " + answer.at("token").get<std::string>()}};
}

/// Methods of all submissions that a team sees, and how often each is there.
inline std::map<std::string, int> count_methods(int port, const httplib::Headers& team) {
  httplib::Client client("127.0.0.1", port);
  std::map<std::string, int> found;
  for (std::string query;;) {  // a page of 500 at a time
    const auto answer = client.Get("/api/v1/submissions" + query, team);
    const auto list = nlohmann::json::parse(answer->body).at("submissions");
    if (list.empty()) return found;
    for (const auto& one : list) ++found[one.at("method").get<std::string>()];
    query = "?before=" + list.back().at("id").dump();
  }
}

class Program {
 public:
  /// Starts nothing. \param program the `enfilade` to run  \param words after `serve`
  Program(std::string program, const std::vector<std::string>& words)
      : words_{std::move(program), "serve", "--port", "0", "--log", "none"} {
    words_.insert(words_.end(), words.begin(), words.end());
  }
  /// As above, of a data set. \param words after `serve DATA`
  Program(std::string program, const std::filesystem::path& data, const std::string& database,
          const std::vector<std::string>& words = {})
      : Program(std::move(program), words) {
    words_.insert(words_.end(), {data, "--db", database});
  }

  /// More words, of what starts after this.
  void add(const std::vector<std::string>& words) {
    words_.insert(words_.end(), words.begin(), words.end());
  }
  /// Begins, and returns at once.
  void launch() {
    std::filesystem::remove(said_);  // what the server before said
    process_.emplace(words_, said_);
  }
  /// Returns when it listens. \throws std::runtime_error if it does not in time
  void start(std::chrono::seconds patience = std::chrono::seconds(60)) {
    launch();
    port_ = wait_for_port(patience);
  }
  void kill() { process_.reset(); }  ///< SIGKILL
  int port() const { return port_; }
  pid_t pid() const { return process_->pid(); }  ///< \pre it was started
  /// All that it has printed, once that text is there, or after ten seconds.
  std::string said_until(const std::string& text) const {
    std::string said;
    for (int k = 0; k < 1000 && said.find(text) == std::string::npos; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      said = read_file(said_);
    }
    return said;
  }

 private:
  int wait_for_port(std::chrono::seconds patience) const {
    const auto end = std::chrono::steady_clock::now() + patience;
    for (; std::chrono::steady_clock::now() < end;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (!std::filesystem::exists(said_)) continue;
      const std::string said = read_file(said_);
      const std::size_t colon = said.find("127.0.0.1:");
      if (colon != std::string::npos && said.back() == '\n') return std::atoi(&said[colon + 10]);
    }
    throw std::runtime_error("the server did not start");
  }

  std::vector<std::string> words_;
  tests::TemporaryFolder folder_{"program"};
  std::filesystem::path said_ = folder_.path() / "said";
  std::optional<tests::Process> process_;
  int port_ = 0;
};

}  // namespace enfilade::service::testing
