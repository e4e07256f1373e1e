/// \file  A small data set on disk with pictures and a secret, and a server of it on a free port.
#pragma once
#include <gtest/gtest.h>
#include <httplib.h>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/scan/store.h"
#include "enfilade/service/server.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/databases.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::testing {

/// Paths along a row of viewpoints v0 ... v5, two instructions each. Those of "test" are in scan
/// "wing" and all others in "row", so that no open goal is a secret one.
inline tasks::Annotations row_annotations(const std::string& split, bool with_goals) {
  tasks::Annotations annotations{split, "", {}};
  for (std::int64_t id = 1; id <= 3; ++id) {
    tasks::PathAnnotation path{id, split == "test" ? "wing" : "row", Radians(1.5), {}, std::nullopt,
                               {}};
    const auto first = static_cast<std::size_t>(id - 1);
    for (std::size_t v = first; v < first + 4; ++v) path.path.push_back("v" + std::to_string(v));
    path.distance = 3.0;
    if (!with_goals) {
      path.path.resize(1);
      path.distance.reset();
    }
    path.instructions = {"Walk to the end of the hall, path " + std::to_string(id) + ".",
                         "Go past the <b>table</b>."};
    annotations.paths.push_back(path);
  }
  return annotations;
}

/// connectivity/, r2r/ (val_seen with goals, test without), store/, and beside it the secret goals
/// of test and a file of phases.
inline void write_served_data(const std::filesystem::path& root) {
  const auto data = root / "data";
  for (const char* folder : {"connectivity", "r2r", "store"}) make_folder(data / folder);
  const scan::Connectivity row = scan::testing::row_of_viewpoints("row", 6);
  write_file_atomically(data / "connectivity/scans.txt", "row wing\n");
  write_file_atomically(data / "connectivity/row_connectivity.json", scan::to_json(row));
  write_file_atomically(data / "connectivity/wing_connectivity.json",
                        scan::to_json(scan::testing::row_of_viewpoints("wing", 6)));
  std::vector<scan::Panorama> panoramas;
  for (std::uint64_t v = 0; v < 6; ++v) panoramas.push_back(scan::testing::panorama(32, v));
  scan::pack(scan::MemoryPanoramas(row, std::move(panoramas)), data / "store", {});
  write_file_atomically(data / "r2r/R2R_val_seen.json", to_json(row_annotations("val_seen", true)));
  write_file_atomically(data / "r2r/R2R_test.json", to_json(row_annotations("test", false)));
  write_file_atomically(root / "secret.json", to_json(row_annotations("test", true)));
  write_file_atomically(root / "phases.json", R"({"phases": [
    {"name": "open", "split": "val_seen", "per_day": 5},
    {"name": "test", "title": "Test", "split": "test", "annotations": "secret.json"},
    {"name": "final", "split": "test", "annotations": "secret.json", "scores": "hidden"}]})");
}

/// Results for the row's annotations: `moves` steps along the path of each episode.
inline std::string row_results(std::size_t moves) {
  auto results = nlohmann::json::array();
  for (std::size_t id = 1; id <= 3; ++id) {
    for (std::size_t k = 0; k < 2; ++k) {
      auto trajectory = nlohmann::json::array();
      for (std::size_t v = id - 1; v <= id - 1 + moves; ++v) {
        trajectory.push_back({"v" + std::to_string(v), 1.5, 0.0});
      }
      results.push_back(
          {{"instr_id", std::to_string(id) + "_" + std::to_string(k)}, {"trajectory", trajectory}});
    }
  }
  return results.dump();
}

/// The data set, and a server of it until the end of the test.
class Served {
 public:
  explicit Served(ServerConfig config = {}, int threads = 8)
      : folder_("served"), config_(std::move(config)) {
    write_served_data(folder_.path());
    config_.database = new_database(folder_.path() / "service.sqlite");
    config_.port = 0;
    config_.threads = threads;
    config_.open_registration = true;
    config_.accept_leak = true;  // three paths have few bits
    start();
  }

  void start() {
    server_ = std::make_unique<Server>(
        Site::open(folder_.path() / "data", load_phases(folder_.path() / "phases.json")), config_);
    client_ = std::make_unique<httplib::Client>("127.0.0.1", server_->port());
  }
  void stop() { server_.reset(); }
  /// Goes on with other phases. \param list entries of "phases", in JSON
  void restart_with(const std::string& list) {
    stop();
    write_file_atomically(folder_.path() / "phases.json", R"({"phases": [)" + list + "]}");
    start();
  }

  httplib::Client& client() { return *client_; }
  int port() const { return server_->port(); }
  const std::filesystem::path& root() const { return folder_.path(); }
  const ServerConfig& config() const { return config_; }

  httplib::Result get(const std::string& target, const httplib::Headers& headers = {}) {
    return client_->Get(target, headers);
  }
  nlohmann::json json(const std::string& target, const httplib::Headers& headers = {}) {
    const auto result = get(target, headers);
    return result ? nlohmann::json::parse(result->body, nullptr, false) : nlohmann::json();
  }
  /// Makes a team that is approved, as organisers do; its headers.
  httplib::Headers team(const std::string& name) {
    return {{"Authorization", "Bearer " + create_team(config_.database, name)}};
  }
  /// Makes a team as strangers do, which nobody has approved; its headers.
  httplib::Headers stranger(const std::string& name) {
    const auto made =
        client_->Post("/api/v1/teams", nlohmann::json{{"name", name}}.dump(), "application/json");
    const auto answer = nlohmann::json::parse(made->body);
    return {{"Authorization", "Bearer " + answer.at("token").get<std::string>()}};
  }
  httplib::Headers organiser() { return staff(TokenRole::kOrganiser); }
  httplib::Headers staff(TokenRole role) {
    const char* label = role == TokenRole::kOrganiser ? "organiser" : "reviewer";
    return {
        {"Authorization", "Bearer " + create_token(config_.database, role, label, std::nullopt)}};
  }
  httplib::Result submit(const httplib::Headers& team, const std::string& phase,
                         const std::string& results, const std::string& method = "method") {
    return client_->Post("/api/v1/submissions?phase=" + phase + "&method=" + method, team, results,
                         "application/json");
  }
  /// Asks until it is no longer queued. Whoever may not know whether it is scored is told at once
  /// that it was received.
  nlohmann::json scored(const httplib::Headers& team, std::int64_t id) {
    nlohmann::json status;
    for (int k = 0; k < 1000; ++k) {
      status = json("/api/v1/submissions/" + std::to_string(id), team);
      if (status.value("state", "") != "queued") break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return status;
  }

 private:
  tests::TemporaryFolder folder_;
  ServerConfig config_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<httplib::Client> client_;
};

/// A server with a clock of the test's own, and its organiser. The clock begins at 1,000,000.
class ServedByAClock : public ::testing::Test {
 protected:
  std::atomic<std::int64_t> now_{1'000'000};
  Served served_{config()};
  httplib::Headers organiser_ = served_.organiser();

 private:
  ServerConfig config() {
    ServerConfig config;
    config.clock = [this] { return now_.load(); };
    return config;
  }
};

}  // namespace enfilade::service::testing
