// The words and columns of a data set's statistics.
#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "enfilade/tasks/statistics.h"

namespace enfilade::tasks {
namespace {

using Json = nlohmann::ordered_json;

std::string thousands(std::size_t n) {
  if (n < 1000) return fmt::format("{}", n);
  return fmt::format("{},{:03}", thousands(n / 1000), n % 1000);
}

std::string share(std::size_t n, std::size_t of) {
  if (of == 0) return "-";
  return fmt::format("{:.1f} %", 100 * static_cast<double>(n) / static_cast<double>(of));
}

std::string cell(const Summary& summary, double Summary::*field, int digits) {
  return summary.count == 0 ? "-" : fmt::format("{:.{}f}", summary.*field, digits);
}

struct Row {
  std::string label;
  std::function<std::string(const SplitStatistics&)> value;
};

void add_summary(std::vector<Row>& rows, const char* label, Summary SplitStatistics::*member,
                 int digits) {
  const auto number = [member, digits](const char* what, double Summary::*field) {
    return Row{what, [=](const SplitStatistics& s) { return cell(s.*member, field, digits); }};
  };
  rows.push_back(number(label, &Summary::mean));
  rows.push_back(number("  standard deviation", &Summary::deviation));
  rows.push_back(number("  least", &Summary::min));
  rows.push_back(number("  median", &Summary::median));
  rows.push_back(number("  most", &Summary::max));
}

// What the benchmark has beside paths and words: rows only for what any split has.
void add_task_rows(std::vector<Row>& rows, const TaskFacts& all) {
  const auto count = [&](const char* label, std::size_t TaskFacts::*member) {
    if (all.*member == 0) return;
    rows.push_back({label, [=](const SplitStatistics& s) { return thousands(s.task.*member); }});
  };
  const auto mean = [&](const char* label, Summary TaskFacts::*member) {
    if ((all.*member).count == 0) return;
    const auto number = [member](double Summary::*field, int digits) {
      return [=](const SplitStatistics& s) { return cell(s.task.*member, field, digits); };
    };
    rows.push_back({label, number(&Summary::mean, 2)});
    rows.push_back({"  most", number(&Summary::max, 0)});
  };
  count("hidden goals", &TaskFacts::hidden_goals);
  count("goal objects", &TaskFacts::objects);
  count("names of goals", &TaskFacts::targets);
  count("boxes of goals", &TaskFacts::boxes);
  mean("viewpoints of a goal", &TaskFacts::goal_viewpoints);
  for (const auto& [language, instructions] : all.languages) {
    rows.push_back({"in " + language, [language = language](const SplitStatistics& s) {
                      const auto found = s.task.languages.find(language);
                      return thousands(found == s.task.languages.end() ? 0 : found->second);
                    }});
  }
  mean("turns of a dialogue", &TaskFacts::turns);
  mean("timed words", &TaskFacts::timed_words);
  mean("sub-instructions", &TaskFacts::parts);
  mean("token ids", &TaskFacts::tokens);
}

std::vector<Row> split_rows(const SplitStatistics& all) {
  const auto count = [](const char* label, std::size_t SplitStatistics::*member) {
    return Row{label, [=](const SplitStatistics& s) { return thousands(s.*member); }};
  };
  std::vector<Row> rows{count("buildings", &SplitStatistics::scans),
                        count("paths", &SplitStatistics::paths),
                        count("instructions", &SplitStatistics::instructions),
                        count("  scored", &SplitStatistics::scored_instructions)};
  add_summary(rows, "path length (m)", &SplitStatistics::path_length, 2);
  for (const auto& [edges, paths] : all.path_edges) {
    rows.push_back({fmt::format("  of {} edge{}", edges, edges == 1 ? "" : "s"),
                    [edges = edges](const SplitStatistics& s) {
                      const auto found = s.path_edges.find(edges);
                      return share(found == s.path_edges.end() ? 0 : found->second,
                                   s.path_length.count);
                    }});
  }
  add_summary(rows, "words an instruction", &SplitStatistics::instruction_length, 1);
  rows.push_back(count("vocabulary", &SplitStatistics::vocabulary));
  rows.push_back(count("  of 5 or more uses", &SplitStatistics::vocabulary_5));
  add_task_rows(rows, all.task);
  return rows;
}

std::string split_table(const DatasetStatistics& statistics) {
  std::vector<const SplitStatistics*> columns;
  for (const SplitStatistics& split : statistics.splits) columns.push_back(&split);
  columns.push_back(&statistics.all);
  std::string text = fmt::format("{:<22}", "");
  const auto width = [](const SplitStatistics& s) {
    return std::max<std::size_t>(s.split.size(), 8);
  };
  for (const SplitStatistics* s : columns) text += fmt::format("  {:>{}}", s->split, width(*s));
  text += '\n';
  for (const Row& row : split_rows(statistics.all)) {
    text += fmt::format("{:<22}", row.label);
    for (const SplitStatistics* s : columns) {
      text += fmt::format("  {:>{}}", row.value(*s), width(*s));
    }
    text += '\n';
  }
  return text;
}

std::string graph_table(const GraphStatistics& g) {
  return fmt::format(
      "{:<22}  {:>8}\n{:<22}  {:>8}\n{:<22}  {:>8.1f}\n{:<22}  {:>8.2f}\n{:<22}  {:>8.2f}\n"
      "{:<22}  {:>8.2f}\n",
      "graphs", thousands(g.graphs), "viewpoints", thousands(g.viewpoints), "viewpoints a graph",
      g.viewpoints_per_graph, "degree of a viewpoint", g.degree, "edge length (m)",
      g.edge_length.mean, "  most", g.edge_length.max);
}

Json summary_json(const Summary& s) {
  return {{"count", s.count}, {"mean", s.mean},     {"standard_deviation", s.deviation},
          {"min", s.min},     {"median", s.median}, {"max", s.max}};
}

// Only what there is.
Json task_json(const TaskFacts& facts) {
  Json json = Json::object();
  const auto count = [&json](const char* name, std::size_t n) {
    if (n > 0) json[name] = n;
  };
  const auto summary = [&json](const char* name, const Summary& s) {
    if (s.count > 0) json[name] = summary_json(s);
  };
  count("hidden_goals", facts.hidden_goals);
  count("goal_objects", facts.objects);
  count("goal_names", facts.targets);
  count("goal_boxes", facts.boxes);
  summary("goal_viewpoints", facts.goal_viewpoints);
  if (!facts.languages.empty()) json["languages"] = facts.languages;
  summary("turns", facts.turns);
  summary("timed_words", facts.timed_words);
  summary("sub_instructions", facts.parts);
  summary("token_ids", facts.tokens);
  return json;
}

Json split_json(const SplitStatistics& s) {
  Json edges = Json::object();
  for (const auto& [n, paths] : s.path_edges) edges[std::to_string(n)] = paths;
  return {{"split", s.split},
          {"scans", s.scans},
          {"paths", s.paths},
          {"instructions", s.instructions},
          {"scored_instructions", s.scored_instructions},
          {"path_length", summary_json(s.path_length)},
          {"path_edges", edges},
          {"instruction_length", summary_json(s.instruction_length)},
          {"vocabulary", s.vocabulary},
          {"vocabulary_5", s.vocabulary_5},
          {"task", task_json(s.task)}};
}

}  // namespace

std::string to_table(const DatasetStatistics& statistics) {
  std::string text = split_table(statistics);
  text += '\n';
  text += graph_table(statistics.graphs);
  if (statistics.first_words.empty()) return text;
  text += "\nMost frequent first four words\n";
  for (const auto& [words, n] : statistics.first_words) {
    text += fmt::format("{:>8}  {}\n", thousands(n), words);
  }
  return text;
}

std::string to_json(const DatasetStatistics& statistics) {
  const GraphStatistics& g = statistics.graphs;
  Json splits = Json::array();
  for (const SplitStatistics& split : statistics.splits) splits.push_back(split_json(split));
  Json first_words = Json::array();
  for (const auto& [words, n] : statistics.first_words) {
    first_words.push_back({{"words", words}, {"count", n}});
  }
  const Json json{{"splits", splits},
                  {"all", split_json(statistics.all)},
                  {"graphs",
                   {{"graphs", g.graphs},
                    {"viewpoints", g.viewpoints},
                    {"viewpoints_per_graph", g.viewpoints_per_graph},
                    {"degree", g.degree},
                    {"edge_length", summary_json(g.edge_length)}}},
                  {"first_words", first_words}};
  // Words come from files that are UTF-8; of annotations made in memory, broken bytes show as
  // U+FFFD.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace enfilade::tasks
