#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "enfilade/core/check.h"
#include "enfilade/report/results_table.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/published.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kAny = -std::numeric_limits<double>::infinity();

constexpr auto kR2r = std::to_array<TableColumn>({
    {"trajectory_length", "TL (m)"},
    {"nav_error", "NE (m)"},
    {"success", "SR (%)", 100, 1},
    {"oracle_success", "OSR (%)", 100, 1},
    {"spl", "SPL (%)", 100, 1},
});
// SPL against the length of the reference path, as HAMT has it.
constexpr auto kR2rLast = std::to_array<TableColumn>({
    {"trajectory_length", "TL (m)", 1, 2, "lengths"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
    {"success", "SR (%)", 100, 1, "sr"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle_sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
});
constexpr auto kR2rBack = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
    {"trajectory_length", "TL (m)", 1, 2, "lengths"},
});
// The star: turns on the spot are taken once (docs/design/dtw-of-turns.md).
constexpr auto kR4r = std::to_array<TableColumn>({
    {"ndtw_collapsed", "nDTW* (%)", 100, 1},
    {"sdtw_collapsed", "SDTW* (%)", 100, 1},
    {"cls", "CLS (%)", 100, 1, "CLS"},
    {"ndtw", "nDTW (%)", 100, 1, "nDTW"},
    {"success", "SR (%)", 100, 1, "sr"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
});
constexpr auto kRxr = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "sr"},
    {"nav_error", "NE (m)", 1, 2, "nav_error"},
    {"ndtw_collapsed", "nDTW* (%)", 100, 1},
    {"sdtw_collapsed", "SDTW* (%)", 100, 1},
    {"ndtw", "nDTW (%)", 100, 1, "nDTW"},
    {"sdtw", "SDTW (%)", 100, 1, "SDTW"},
});
constexpr auto kReverie = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "success_rate"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle success_rate"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"rgs", "RGS (%)", 100, 1, "rgs"},
    {"rgspl", "RGSPL (%)", 100, 1, "rgspl"},
});
constexpr auto kCvdn = std::to_array<TableColumn>({
    {"goal_progress", "GP (m)", 1, 2, "gp", kAny},
    {"success", "SR (%)", 100, 1, "sr"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle_sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"trajectory_length", "TL (m)", 1, 2, "lengths"},
});
constexpr auto kSoon = std::to_array<TableColumn>({
    {"success", "SR (%)", 100, 1, "sr"},
    {"spl", "SPL (%)", 100, 1, "spl"},
    {"oracle_success", "OSR (%)", 100, 1, "oracle_sr"},
    {"detection_spl", "FSPL (%)", 100, 1, "det_spl"},
    {"detection", "found (%)", 100, 1, "det_sr"},
});

constexpr auto kContinuous = std::to_array<TableColumn>({
    {"path_length", "TL (m)"},
    {"distance_to_goal", "NE (m)"},
    {"success", "SR (%)", 100, 1},
    {"oracle_success", "OSR (%)", 100, 1},
    {"spl", "SPL (%)", 100, 1},
    {"ndtw", "nDTW (%)", 100, 1},
    {"sdtw", "SDTW (%)", 100, 1},
});

// What a benchmark's table has. Scorer and source: those of Benchmark::table_scorer where empty.
struct Table {
  std::span<const TableColumn> columns;
  std::string_view scorer = {}, source = {};
};
constexpr Table kOnFloor{kContinuous, "vln-ce",
                         "the measures of jacobkrantz/VLN-CE; nDTW and SDTW exact"};
// In the order of tasks::benchmarks().
constexpr auto kTables = std::to_array<Table>({{kR2r},
                                               {kR2rLast},
                                               {kR2rBack},
                                               {kR4r},
                                               {kRxr},
                                               {kReverie},
                                               {kCvdn},
                                               {kSoon},
                                               kOnFloor,
                                               kOnFloor});

const Table& table_of(const tasks::Benchmark& benchmark) noexcept {
  const auto row = static_cast<std::size_t>(&benchmark - tasks::benchmarks().data());
  EN_CHECK(row < kTables.size());
  return kTables[row];
}

// Figures that stand in notes, by their columns, and their names in JSON.
constexpr auto kFigures =
    std::to_array<std::pair<std::string_view, const char*>>({{"SR", "success"},
                                                             {"SPL", "spl"},
                                                             {"OSR", "oracle_success"},
                                                             {"NE", "nav_error"},
                                                             {"nDTW", "ndtw"},
                                                             {"GP", "goal_progress"}});

constexpr const char* kSynthetic =
    "SYNTHETIC: model homes made by Enfilade. Not to be compared with any published figure.";
constexpr const char* kStar =
    "* Turns on the spot are taken once; without the star every entry of a trajectory counts.";
constexpr const char* kIntervals =
    "Intervals are of 95 %: of one run, bootstrap over paths; of several, Student's over runs.";

// Widths of the columns of splits and agents.
struct Widths {
  std::size_t split = 5, agent = 9;
};

// As people read it: "random", "  hi-IN" below it.
std::string name_of(const TableRow& row) {
  return row.language.empty() ? row.agent : "  " + row.language;
}

Widths widths_of(const ResultsTable& table) {
  Widths widths;
  for (const TableRow& row : table.rows) {
    widths.split = std::max(widths.split, row.split.size());
    widths.agent = std::max(widths.agent, name_of(row).size());
  }
  return widths;
}

std::string shown(double value, const TableColumn& column) {
  return fmt::format("{:.{}f}", column.scale * value, column.digits);
}

std::string shown_interval(const tasks::MeanInterval& value, const TableColumn& column) {
  if (value.low == value.high) return {};
  return fmt::format(" [{}, {}]", shown(value.low, column), shown(value.high, column));
}

std::string shown_published(const TableRow& row, const TableColumn& column) {
  const auto value = published_value(*row.published, column.metric);
  return value ? shown(*value, column) : "-";
}

bool any_published(const ResultsTable& table) {
  return std::ranges::any_of(table.rows, [](const TableRow& r) { return r.published.has_value(); });
}

// "NaviLLM: SR 67, SPL 59 (README of zd11024/NaviLLM)"
std::string shown(const tasks::PublishedResult& result) {
  std::vector<std::string> values;
  for (const auto& [column, name] : kFigures) {
    const auto value = result.value(column);
    if (!value) continue;
    const bool metres = column == "NE" || column == "GP";
    values.push_back(metres ? fmt::format("{} {:.2f} m", column, *value)
                            : fmt::format("{} {:.4g}", column, 100 * *value));
  }
  return fmt::format("Published, val unseen: {}: {} ({}).", result.agent, fmt::join(values, ", "),
                     result.source);
}

// Those that belong beside the table: nothing beside model homes, or other splits.
std::vector<tasks::PublishedResult> published_beside(const ResultsTable& table) {
  const bool unseen = std::ranges::any_of(
      table.rows, [](const TableRow& row) { return row.split.starts_with("val_unseen"); });
  std::vector<tasks::PublishedResult> beside;
  if (table.synthetic || !unseen) return beside;
  if (table.benchmark->in_paper && !any_published(table)) return beside;
  for (const tasks::PublishedResult& one : tasks::published_results()) {
    if (one.benchmark == table.benchmark->name && one.source != tasks::kFirstPaper) {
      beside.push_back(one);
    }
  }
  return beside;
}

// The scorer behind the columns, and its repository; empty for our own.
std::string_view scorer_of(const ResultsTable& table) {
  const std::string_view own = table_of(*table.benchmark).scorer;
  return own.empty() ? table.benchmark->table_scorer : own;
}
std::string_view source_of(const ResultsTable& table) {
  const std::string_view own = table_of(*table.benchmark).source;
  return own.empty() ? table.benchmark->scorer(table.benchmark->table_scorer).source : own;
}

bool has_stars(const ResultsTable& table) {
  return std::ranges::any_of(table.columns, [](const TableColumn& column) {
    return column.label.find('*') != std::string_view::npos;
  });
}

std::vector<std::string> notes_of(const ResultsTable& table) {
  std::vector<std::string> notes;
  if (table.synthetic) notes.emplace_back(kSynthetic);
  if (const auto scorer = scorer_of(table); !scorer.empty()) {
    notes.push_back(
        fmt::format("{}, scored as {} ({}).", table.benchmark->title, scorer, source_of(table)));
  }
  if (has_stars(table)) notes.emplace_back(kStar);
  notes.emplace_back(kIntervals);
  for (const tasks::PublishedResult& one : published_beside(table)) notes.push_back(shown(one));
  if (any_published(table)) notes.push_back(fmt::format("paper: {}.", tasks::kFirstPaper));
  for (const std::string& one : table.left_out) notes.push_back("Left out: " + one + ".");
  return notes;
}

Json value_json(const TableRow& row, std::size_t k, const TableColumn& column) {
  const tasks::MeanInterval& value = row.values.at(k);
  // Infinities become null.
  Json json{{"mean", value.mean}, {"low", value.low}, {"high", value.high}};
  if (!row.published) return json;
  const auto published = published_value(*row.published, column.metric);
  json["published"] = published ? Json(*published) : Json(nullptr);
  return json;
}

Json columns_json(std::span<const TableColumn> columns) {
  Json all = Json::array();
  for (const TableColumn& column : columns) {
    all.push_back({{"metric", column.metric},
                   {"label", column.label},
                   {"scale", column.scale},
                   {"digits", column.digits}});
  }
  return all;
}

Json published_json(const ResultsTable& table) {
  Json all = Json::array();
  for (const tasks::PublishedResult& one : published_beside(table)) {
    Json& json = all.emplace_back(Json{{"agent", one.agent}, {"source", one.source}});
    for (const auto& [column, name] : kFigures) {
      if (const auto value = one.value(column)) json[name] = *value;
    }
  }
  return all;
}

// Quoted if it has to be (RFC 4180).
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string csv_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

// A folder's name may have characters that end a cell in Markdown.
std::string markdown_cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|' || c == '\\' || c == '<') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// A line of to_text(). \param cell makes the text of a column, as wide as the column
template <class Cell>
std::string text_line(const Widths& widths, std::span<const TableColumn> columns,
                      std::string_view split, std::string_view agent, std::string_view runs,
                      const Cell& cell) {
  std::string line =
      fmt::format("{:<{}}  {:<{}}  {:>4}", split, widths.split, agent, widths.agent, runs);
  for (std::size_t k = 0; k < columns.size(); ++k) line += "  " + cell(k, columns[k]);
  line.resize(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string to_text(const ResultsTable& table) {
  const Widths widths = widths_of(table);
  const auto columns = table.columns;
  std::string text = text_line(widths, columns, "split", "agent", "runs",
                               [](std::size_t, const TableColumn& column) {
                                 return fmt::format("{:>7}{:<14}", column.label, "");
                               });
  std::string_view split;
  for (const TableRow& row : table.rows) {
    text += text_line(widths, columns, row.split == split ? "" : row.split, name_of(row),
                      std::to_string(row.runs.size()),
                      [&row](std::size_t k, const TableColumn& column) {
                        return fmt::format("{:>6}{:<15}", shown(row.values.at(k).mean, column),
                                           shown_interval(row.values.at(k), column));
                      });
    split = row.split;
    if (!row.published) continue;
    text += text_line(widths, columns, "", "  paper", "",
                      [&row](std::size_t, const TableColumn& column) {
                        return fmt::format("{:>6}{:<15}", shown_published(row, column), "");
                      });
  }
  text += '\n';
  for (const std::string& note : notes_of(table)) text += note + "\n";
  return text;
}

std::string to_json(const ResultsTable& table) {
  const auto columns = table.columns;
  Json rows = Json::array();
  for (const TableRow& row : table.rows) {
    Json json{{"agent", row.agent},
              {"split", row.split},
              {"runs", row.runs},
              {"episodes", row.episodes},
              {"interval", row.runs.size() == 1 ? "bootstrap over paths" : "Student over runs"}};
    if (!row.language.empty()) json["language"] = row.language;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      json[columns[k].metric] = value_json(row, k, columns[k]);
    }
    rows.push_back(std::move(json));
  }
  const Json all{{"task", table.benchmark->name},
                 {"scorer", scorer_of(table)},
                 {"source", source_of(table)},
                 {"synthetic", table.synthetic},
                 {"columns", columns_json(columns)},
                 {"rows", rows},
                 {"published", published_json(table)},
                 {"notes", has_stars(table) ? Json{kStar} : Json::array()},
                 {"left_out", table.left_out}};
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_csv(const ResultsTable& table) {
  const bool languages = table.benchmark->languages && !table.benchmark->continuous();
  std::string text = languages ? "agent,split,language,runs,episodes,synthetic"
                               : "agent,split,runs,episodes,synthetic";
  const auto columns = table.columns;
  for (const TableColumn& column : columns) {
    text += fmt::format(",{0},{0}_low,{0}_high,{0}_published", column.metric);
  }
  text += "\r\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("{},{},", csv_cell(row.agent), csv_cell(row.split));
    if (languages) text += csv_cell(row.language) + ",";
    text += fmt::format("{},{},{}", row.runs.size(), row.episodes, table.synthetic ? "yes" : "no");
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const tasks::MeanInterval& value = row.values.at(k);
      const auto published =
          row.published ? published_value(*row.published, columns[k].metric) : std::nullopt;
      text += fmt::format(",{},{},{},{}", csv_number(value.mean), csv_number(value.low),
                          csv_number(value.high), published ? csv_number(*published) : "");
    }
    text += "\r\n";
  }
  return text;
}

std::string to_markdown(const ResultsTable& table) {
  std::string text = "| split | agent | runs |";
  std::string rule = "|---|---|---:|";
  const auto columns = table.columns;
  for (const TableColumn& column : columns) {
    text += fmt::format(" {} |", column.label);
    rule += "---:|";
  }
  text += "\n" + rule + "\n";
  for (const TableRow& row : table.rows) {
    const std::string name = row.language.empty() ? row.agent : row.agent + ", " + row.language;
    text += fmt::format("| {} | {} | {} |", markdown_cell(row.split), markdown_cell(name),
                        row.runs.size());
    for (std::size_t k = 0; k < columns.size(); ++k) {
      text += fmt::format(" {}{} |", shown(row.values.at(k).mean, columns[k]),
                          shown_interval(row.values.at(k), columns[k]));
    }
    text += '\n';
    if (!row.published) continue;
    text += "| | *paper* | |";
    for (const TableColumn& column : columns) {
      text += fmt::format(" *{}* |", shown_published(row, column));
    }
    text += '\n';
  }
  for (const std::string& note : notes_of(table)) text += "\n" + note + "\n";
  return text;
}

std::span<const TableColumn> table_columns(const tasks::Benchmark& benchmark) noexcept {
  return table_of(benchmark).columns;
}

}  // namespace enfilade::report
