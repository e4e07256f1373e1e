/// \file  `enfilade serve` as a process of its own, for tests that kill it or crowd it.
#pragma once
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/support/process.h"

namespace enfilade::service::testing {

class Program {
 public:
  /// Starts nothing. \param program the `enfilade` to run  \param words after `serve DATA`
  Program(std::string program, const std::filesystem::path& data,
          const std::filesystem::path& database, const std::vector<std::string>& words = {})
      : words_{std::move(program), "serve", data, "--db", database, "--port", "0", "--log", "none"},
        said_(database.string() + ".out") {
    words_.insert(words_.end(), words.begin(), words.end());
  }

  /// Returns when it listens. \throws std::runtime_error if it does not within a minute
  void start() {
    std::filesystem::remove(said_);  // what the server before said
    process_.emplace(words_, said_);
    port_ = wait_for_port();
  }
  void kill() { process_.reset(); }  ///< SIGKILL
  int port() const { return port_; }

 private:
  int wait_for_port() const {
    for (int k = 0; k < 12'000; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (!std::filesystem::exists(said_)) continue;
      const std::string said = read_file(said_);
      const std::size_t colon = said.find("127.0.0.1:");
      if (colon != std::string::npos && said.back() == '\n') return std::atoi(&said[colon + 10]);
    }
    throw std::runtime_error("the server did not start");
  }

  std::vector<std::string> words_;
  std::filesystem::path said_;
  std::optional<tests::Process> process_;
  int port_ = 0;
};

}  // namespace enfilade::service::testing
