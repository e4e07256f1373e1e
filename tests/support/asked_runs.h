/// \file  Runs of scripted models in the data set of served_data.h, and a server that shows them.
#pragma once
#include <gtest/gtest.h>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/arena/ask.h"
#include "enfilade/core/file.h"
#include "enfilade/dataset/dataset.h"
#include "tests/support/served_data.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::testing {

/// A model that says the same in each episode, step by step, and keeps the pictures that it got.
class Script : public arena::Endpoint {
 public:
  explicit Script(std::vector<std::string> lines) : lines_(std::move(lines)) {}
  std::string post(std::string_view body, const arena::RequestOrigin& origin) override {
    const std::size_t step = origin.calls.size();
    std::vector<std::string>& urls = pictures_[{origin.episode, step}];
    urls.clear();
    const auto request = nlohmann::json::parse(body);
    const auto& content = request.at("messages").back().at("content");
    for (const auto& part : content.is_array() ? content : nlohmann::json::array()) {
      if (part.at("type") == "image_url") {
        urls.push_back(part.at("image_url").at("url").get<std::string>());
      }
    }
    const std::string& line = lines_.at(std::min(step, lines_.size() - 1));
    return nlohmann::json{{"choices", {{{"message", {{"role", "assistant"}, {"content", line}}}}}},
                          {"usage", {{"prompt_tokens", 100}, {"completion_tokens", 7}}}}
        .dump();
  }
  /// Addresses of data, in the order in which they were sent. \param step accepted calls before
  const std::vector<std::string>& pictures(const std::string& episode, std::size_t step) const {
    return pictures_.at({episode, step});
  }

 private:
  std::vector<std::string> lines_;
  std::map<std::pair<std::string, std::size_t>, std::vector<std::string>> pictures_;
};

inline const std::vector<std::string> kScript{
    "I look first. <script>alert(1)</script> <img src=x onerror=alert(2)>\nAction: look left",
    "On along the hall.\nAction: go_to B", "Action: go_to C", "Here it is.\nAction: stop"};

/// A server of the runs in runs_.
class AskedRuns : public ::testing::Test {
 protected:
  AskedRuns() : runs_("runs"), served_(showing(runs_.path())) {}
  static ServerConfig showing(const std::filesystem::path& runs) {
    ServerConfig config;
    config.runs = runs;
    return config;
  }

  std::shared_ptr<const tasks::EpisodeSet> episodes(const std::string& split,
                                                    tasks::Task task = tasks::Task::kR2r) {
    return std::make_shared<const tasks::EpisodeSet>(
        dataset::Dataset(served_.root() / "data").episodes(task, split));
  }
  /// All episodes of a split. \returns the run's folder
  std::filesystem::path ask(const std::string& name, std::vector<std::string> lines = kScript,
                            const std::string& split = "val_seen",
                            tasks::Task task = tasks::Task::kR2r) {
    Script script(std::move(lines));
    return ask_model(script, name, "text", split, task);
  }
  std::filesystem::path ask_model(arena::Endpoint& model, const std::string& name,
                                  const std::string& prompt, const std::string& split = "val_seen",
                                  tasks::Task task = tasks::Task::kR2r) {
    const auto set = episodes(split, task);
    std::vector<std::size_t> all(set->episodes.size());
    std::iota(all.begin(), all.end(), 0U);
    arena::AskConfig config;
    config.chat.model = "scripted";
    config.answers = arena::Answers::kText;
    config.limits.mistakes = 3;
    config.picture_size = 64;
    arena::AnswerCache cache(served_.root() / ("cache-" + name));
    std::filesystem::path folder = runs_.path() / name;
    const arena::ViewSources sights{
        .data = std::make_shared<const dataset::Dataset>(served_.root() / "data")};
    arena::ask(arena::GraphWorld(set), sights, all, arena::Prompt::named(prompt), config, &model,
               cache, folder);
    return folder;
  }
  nlohmann::json get(const std::string& path) { return served_.json("/api/v1/runs" + path); }
  /// The status, and what the answer says is wrong.
  std::pair<int, std::string> refused(const std::string& path) {
    const auto answer = served_.get("/api/v1/runs" + path);
    const auto body = nlohmann::json::parse(answer->body, nullptr, false);
    return {answer->status, body.contains("error") ? body["error"].value("message", "") : ""};
  }
  static void change(const std::filesystem::path& file, const std::string& from,
                     const std::string& to) {
    std::string text = read_file(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write_file_atomically(file, text.replace(at, from.size(), to));
  }

  tests::TemporaryFolder runs_;
  Served served_;
};

}  // namespace enfilade::service::testing
