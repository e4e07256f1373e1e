#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/report/results_table.h"

namespace enfilade::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSynthetic =
    "SYNTHETIC: model homes made by Enfilade. Not to be compared with any published figure.";
constexpr const char* kPaper = "paper: Anderson et al., CVPR 2018, table 1.";
constexpr const char* kIntervals =
    "Intervals are of 95 %: of one run, bootstrap over paths; of several, Student's over runs.";

// Widths of the columns of splits and agents.
struct Widths {
  std::size_t split = 5, agent = 9;
};

Widths widths_of(const ResultsTable& table) {
  Widths widths;
  for (const TableRow& row : table.rows) {
    widths.split = std::max(widths.split, row.split.size());
    widths.agent = std::max(widths.agent, row.agent.size());
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

std::vector<std::string> notes_of(const ResultsTable& table) {
  std::vector<std::string> notes;
  if (table.synthetic) notes.emplace_back(kSynthetic);
  notes.emplace_back(kIntervals);
  if (any_published(table)) notes.emplace_back(kPaper);
  for (const std::string& one : table.left_out) notes.push_back("Left out: " + one + ".");
  return notes;
}

Json value_json(const TableRow& row, std::size_t k) {
  const tasks::MeanInterval& value = row.values.at(k);
  // Infinities become null.
  Json json{{"mean", value.mean}, {"low", value.low}, {"high", value.high}};
  if (!row.published) return json;
  const auto published = published_value(*row.published, table_columns()[k].metric);
  json["published"] = published ? Json(*published) : Json(nullptr);
  return json;
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
std::string text_line(const Widths& widths, std::string_view split, std::string_view agent,
                      std::string_view runs, const Cell& cell) {
  std::string line =
      fmt::format("{:<{}}  {:<{}}  {:>4}", split, widths.split, agent, widths.agent, runs);
  for (std::size_t k = 0; k < kTableColumns; ++k) line += "  " + cell(k, table_columns()[k]);
  line.resize(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string to_text(const ResultsTable& table) {
  const Widths widths = widths_of(table);
  std::string text =
      text_line(widths, "split", "agent", "runs", [](std::size_t, const TableColumn& column) {
        return fmt::format("{:>7}{:<14}", column.label, "");
      });
  std::string_view split;
  for (const TableRow& row : table.rows) {
    text += text_line(widths, row.split == split ? "" : row.split, row.agent,
                      std::to_string(row.runs.size()),
                      [&row](std::size_t k, const TableColumn& column) {
                        return fmt::format("{:>6}{:<15}", shown(row.values.at(k).mean, column),
                                           shown_interval(row.values.at(k), column));
                      });
    split = row.split;
    if (!row.published) continue;
    text += text_line(widths, "", "  paper", "", [&row](std::size_t, const TableColumn& column) {
      return fmt::format("{:>6}{:<15}", shown_published(row, column), "");
    });
  }
  text += '\n';
  for (const std::string& note : notes_of(table)) text += note + "\n";
  return text;
}

std::string to_json(const ResultsTable& table) {
  Json rows = Json::array();
  for (const TableRow& row : table.rows) {
    Json json{{"agent", row.agent},
              {"split", row.split},
              {"runs", row.runs},
              {"episodes", row.episodes},
              {"interval", row.runs.size() == 1 ? "bootstrap over paths" : "Student over runs"}};
    for (std::size_t k = 0; k < kTableColumns; ++k) {
      json[table_columns()[k].metric] = value_json(row, k);
    }
    rows.push_back(std::move(json));
  }
  const Json all{{"synthetic", table.synthetic}, {"rows", rows}, {"left_out", table.left_out}};
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_csv(const ResultsTable& table) {
  std::string text = "agent,split,runs,episodes,synthetic";
  for (const TableColumn& column : table_columns()) {
    text += fmt::format(",{0},{0}_low,{0}_high,{0}_published", column.metric);
  }
  text += "\r\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("{},{},{},{},{}", csv_cell(row.agent), csv_cell(row.split), row.runs.size(),
                        row.episodes, table.synthetic ? "yes" : "no");
    for (std::size_t k = 0; k < kTableColumns; ++k) {
      const tasks::MeanInterval& value = row.values.at(k);
      const auto published =
          row.published ? published_value(*row.published, table_columns()[k].metric) : std::nullopt;
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
  for (const TableColumn& column : table_columns()) {
    text += fmt::format(" {} |", column.label);
    rule += "---:|";
  }
  text += "\n" + rule + "\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("| {} | {} | {} |", markdown_cell(row.split), markdown_cell(row.agent),
                        row.runs.size());
    for (std::size_t k = 0; k < kTableColumns; ++k) {
      const TableColumn& column = table_columns()[k];
      text += fmt::format(" {}{} |", shown(row.values.at(k).mean, column),
                          shown_interval(row.values.at(k), column));
    }
    text += '\n';
    if (!row.published) continue;
    text += "| | *paper* | |";
    for (const TableColumn& column : table_columns()) {
      text += fmt::format(" *{}* |", shown_published(row, column));
    }
    text += '\n';
  }
  for (const std::string& note : notes_of(table)) text += "\n" + note + "\n";
  return text;
}

}  // namespace enfilade::report
