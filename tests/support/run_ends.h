/// \file  How the episodes of a model's run ended, as its files have it, against its report.
#pragma once
#include <gtest/gtest.h>
#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "enfilade/arena/ask.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"

namespace enfilade::arena::testing {

/// Each episode of a run on R2R ends by the model's own stop, or has calls, or the report names it:
/// no trajectory has length 0 that the model did not ask for.
inline void expect_explained(const std::filesystem::path& run, const AskReport& report) {
  using nlohmann::json;
  if (report.done == 0) return;
  std::map<std::string, json> results;
  for (const json& one : json::parse(read_file(run / "results.json"))) {
    results[one.at("instr_id").get<std::string>()] = one;
  }
  EXPECT_EQ(results.size(), report.done) << run;
  std::map<Ending, std::size_t> endings;
  for (const auto& file : std::filesystem::directory_iterator(run / "transcripts")) {
    std::vector<json> lines;
    std::istringstream text(read_file(file.path()));
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    ASSERT_GE(lines.size(), 2U) << file.path();
    const auto id = lines.front().at("episode").get<std::string>();
    const json& end = lines.back();
    EXPECT_EQ(results[id], end.at("result")) << id;
    const Ending ending = find_enum<Ending>(end.at("ending").get<std::string>()).value();
    ++endings[ending];
    const bool named = std::ranges::any_of(
        report.refused, [&id](const std::string& one) { return one.starts_with(id + ": "); });
    EXPECT_EQ(named, ending == Ending::kRefused) << id;
    if (ending == Ending::kStopped) {
      const json& last = lines[lines.size() - 2].at("call");
      ASSERT_TRUE(last.is_object()) << id;
      EXPECT_EQ(last.at("tool"), "stop") << id;
    } else {
      EXPECT_TRUE(named || ending == Ending::kMistakes || end.at("steps").get<int>() > 0) << id;
    }
  }
  EXPECT_EQ(endings, report.endings) << run;
}

}  // namespace enfilade::arena::testing
