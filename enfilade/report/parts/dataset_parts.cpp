#include "enfilade/report/parts/dataset_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/tasks/statistics.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::report::parts {
namespace {

constexpr double kMetresABin = 2;
constexpr double kWordsABin = 5;
constexpr std::size_t kFirstWords = 4;
constexpr double kThinnest = 0.003;  // of the circle: about a degree

Json summary_json(std::vector<double> values) {
  const tasks::Summary s = tasks::summarise(std::move(values));
  return {{"mean", s.mean}, {"median", s.median}, {"min", s.min}, {"max", s.max}};
}

Json lengths_of(const tasks::Annotations& split, const graph::GraphSet& graphs) {
  Histogram paths{kMetresABin, {}, 0}, words{kWordsABin, {}, 0};
  std::vector<double> metres, tokens;
  for (const tasks::ReferencePath& path : look_up_paths(split, graphs)) {
    if (path.viewpoints.size() < 2) continue;  // the goal is hidden
    metres.push_back(length_of(path, graphs.graph(path.scan)));
    paths.add(metres.back());
  }
  for (const tasks::PathAnnotation& path : split.paths) {
    for (const std::string& text : path.instructions) {
      tokens.push_back(static_cast<double>(tasks::tokenize(text).size()));
      words.add(tokens.back());
    }
  }
  Json json{{"split", split.split}, {"words", to_json(words)}};
  json["wordsSummary"] = tokens.empty() ? Json(nullptr) : summary_json(std::move(tokens));
  if (metres.empty()) return json;
  json["paths"] = to_json(paths);
  json["pathsSummary"] = summary_json(std::move(metres));
  return json;
}

// Instructions by the words that they begin with.
struct Branch {
  std::size_t count = 0;
  std::map<std::string, Branch> next;
};

Json branch_json(const std::string& word, const Branch& branch, double least) {
  Json json{{"word", word}, {"count", branch.count}};
  std::vector<std::pair<std::string, const Branch*>> thick;
  for (const auto& [text, child] : branch.next) {
    if (static_cast<double>(child.count) >= least) thick.emplace_back(text, &child);
  }
  std::ranges::stable_sort(thick, std::ranges::greater{},
                           [](const auto& pair) { return pair.second->count; });
  if (!thick.empty()) json["next"] = Json::array();
  for (const auto& [text, child] : thick) {
    json["next"].push_back(branch_json(text, *child, least));
  }
  return json;
}

}  // namespace

Json missing(const std::string& why) { return {{"missing", why}}; }

void Histogram::add(double value) {
  EN_CHECK(std::isfinite(value) && value >= 0);
  const auto bin = static_cast<std::size_t>(value / width);
  if (bin >= counts.size()) counts.resize(bin + 1);
  ++counts[bin];
  ++total;
}

Json to_json(const Histogram& histogram) {
  return {{"width", histogram.width}, {"total", histogram.total}, {"counts", histogram.counts}};
}

Json lengths_part(const std::vector<tasks::Annotations>& splits,
                  const std::shared_ptr<const graph::GraphSet>& graphs) {
  if (splits.empty()) return missing("There are no annotations in the data set.");
  Json all = Json::array();
  for (const tasks::Annotations& split : splits) all.push_back(lengths_of(split, *graphs));
  return {{"splits", all}};
}

Json words_part(const std::vector<tasks::Annotations>& splits) {
  Branch root;
  for (const tasks::Annotations& split : splits) {
    for (const tasks::PathAnnotation& path : split.paths) {
      for (const std::string& text : path.instructions) {
        const std::vector<std::string> words = tasks::tokenize(text);
        Branch* branch = &root;
        ++branch->count;
        for (std::size_t i = 0; i < std::min(words.size(), kFirstWords); ++i) {
          branch = &branch->next[words[i]];
          ++branch->count;
        }
      }
    }
  }
  if (root.count == 0) return missing("There are no instructions in the data set.");
  return branch_json("", root, kThinnest * static_cast<double>(root.count));
}

}  // namespace enfilade::report::parts
