#include "enfilade/tasks/formats/rxr.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

using json::Element;
using json::Faults;
using json::Path;

constexpr std::array<std::string_view, 4> kLanguages{"en-IN", "en-US", "hi-IN", "te-IN"};

enum Wanted : std::size_t {
  kPathId,
  kScan,
  kHeading,
  kPath,
  kInstructionId,
  kLanguage,
  kInstruction,
  kWords,
  kTokens,
  kFields
};
constexpr std::array<json::Field, kFields> kWanted{{{"path_id", false},
                                                    {"scan"},
                                                    {"heading"},
                                                    {"path"},
                                                    {"instruction_id"},
                                                    {"language"},
                                                    {"instruction"},
                                                    {"timed_instruction", false},
                                                    {"instr_encoding", false}}};

enum OfWalk : std::size_t { kDemonstration, kFollowed, kAnnotator, kWalk, kMetrics, kWalkFields };
constexpr std::array<json::Field, kWalkFields> kOfWalk{
    {{"demonstration_id"}, {"instruction_id"}, {"annotator_id"}, {"path"}, {"metrics"}}};

enum OfMetrics : std::size_t { kNe, kSr, kSpl, kDtw, kNdtw, kSdtw, kMetricFields };
constexpr std::array<json::Field, kMetricFields> kOfMetrics{
    {{"ne"}, {"sr"}, {"spl"}, {"dtw"}, {"ndtw"}, {"sdtw"}}};

std::int64_t read_id(Element element, const Path& path, Faults& faults) {
  const auto number = json::integer(element, path, faults);
  if (number && *number < 0) {
    faults.error(path, "negative-id", fmt::format("{} is no id; 0 and more are", *number));
  }
  return number.value_or(0);
}

std::string read_language(Element element, const Path& path, Faults& faults) {
  const auto text = json::string(element, path, faults);
  if (!text) return {};
  if (std::ranges::find(kLanguages, *text) == kLanguages.end()) {
    faults.error(
        path, "unknown-language",
        fmt::format("{:?} is no language of RxR; {} are", *text, fmt::join(kLanguages, ", ")));
  }
  return std::string(*text);
}

// Gives the instruction's id. Test lines go by it alone, as HAMT names them.
std::int64_t read_ids(const std::array<std::optional<Element>, kFields>& found, const Path& path,
                      Faults& faults, PathAnnotation& entry, InstructionDetails& details) {
  const std::int64_t instruction =
      read_id(*found[kInstructionId], Path(path, "instruction_id"), faults);
  if (found[kPathId]) {
    entry.path_id = read_id(*found[kPathId], Path(path, "path_id"), faults);
    entry.group = entry.path_id;
    details.id = fmt::format("{}_{}", entry.path_id, instruction);
  } else {
    entry.path_id = instruction;
    details.id = fmt::to_string(instruction);
    if (entry.path.size() > 1) {
      faults.error(Path(path, "path"), "open-path",
                   fmt::format("{} viewpoints, not the start alone, as there is no \"path_id\"",
                               entry.path.size()));
    }
  }
  entry.id = fmt::to_string(entry.path_id);
  return instruction;
}

// What a line has, and its instruction's id if all of it could be read.
struct Line {
  PathAnnotation entry;
  std::optional<std::int64_t> instruction;
};

Line read_line(Element element, const Path& path, Faults& faults) {
  Line line;
  PathAnnotation& entry = line.entry;
  std::array<std::optional<Element>, kFields> found;
  if (!json::fields(element, kWanted, found, path, faults)) return line;
  const std::size_t errors = faults.errors();
  entry.scan = json::string(*found[kScan], Path(path, "scan"), faults).value_or("");
  entry.heading = read_angle(*found[kHeading], Path(path, "heading"), faults);
  entry.path = read_path(*found[kPath], Path(path, "path"), faults);
  const Path text(path, "instruction");
  entry.instructions.emplace_back(json::string(*found[kInstruction], text, faults).value_or(""));
  InstructionDetails& details = entry.details.emplace_back();
  const std::int64_t id = read_ids(found, path, faults, entry, details);
  details.language = read_language(*found[kLanguage], Path(path, "language"), faults);
  if (found[kWords]) {
    details.words = read_timed_words(*found[kWords], Path(path, "timed_instruction"), faults);
  }
  if (found[kTokens]) {
    details.tokens = read_tokens(*found[kTokens], Path(path, "instr_encoding"), faults);
  }
  if (faults.errors() == errors) line.instruction = id;
  return line;
}

void read_metrics(Element element, const Path& path, Faults& faults, Demonstration& walk) {
  std::array<std::optional<Element>, kMetricFields> found;
  if (!json::fields(element, kOfMetrics, found, path, faults)) return;
  const std::array<double*, kMetricFields> values{&walk.ne,  &walk.sr,   &walk.spl,
                                                  &walk.dtw, &walk.ndtw, &walk.sdtw};
  for (std::size_t k = 0; k < kMetricFields; ++k) {
    *values[k] = json::number(*found[k], Path(path, kOfMetrics[k].name), faults).value_or(0);
  }
}

Demonstration read_walk(Element element, const Path& path, Faults& faults) {
  Demonstration walk;
  std::array<std::optional<Element>, kWalkFields> found;
  if (!json::fields(element, kOfWalk, found, path, faults)) return walk;
  walk.demonstration_id = read_id(*found[kDemonstration], Path(path, "demonstration_id"), faults);
  walk.instruction_id = read_id(*found[kFollowed], Path(path, "instruction_id"), faults);
  walk.annotator_id = read_id(*found[kAnnotator], Path(path, "annotator_id"), faults);
  walk.path = read_path(*found[kWalk], Path(path, "path"), faults);
  read_metrics(*found[kMetrics], Path(path, "metrics"), faults, walk);
  return walk;
}

ArgumentError not_rxr(const PathAnnotation& entry, std::string_view why) {
  return ArgumentError(fmt::format("path {}: {}", entry.path_id, why));
}

void check_finite(const PathAnnotation& entry, double number, std::string_view name) {
  if (std::isfinite(number)) return;
  throw not_rxr(entry, fmt::format("{} {}, not a finite number", name, number));
}

// The number in the id of the instruction.
std::int64_t number_of(const PathAnnotation& entry) {
  const std::string& id = entry.details[0].id;
  const std::string before = entry.group ? fmt::format("{}_", entry.path_id) : "";
  const auto number = id.starts_with(before)
                          ? parse_number<std::int64_t>(std::string_view(id).substr(before.size()))
                          : std::nullopt;
  if (number) return *number;
  throw not_rxr(entry, fmt::format("instruction id {:?}, not {:?} and a number", id, before));
}

std::string line_of(const PathAnnotation& entry, const std::string& split) {
  if (entry.instructions.size() != 1 || entry.details.size() != 1) {
    throw not_rxr(entry, fmt::format("{} instructions with details of {}, not one with its details",
                                     entry.instructions.size(), entry.details.size()));
  }
  check_finite(entry, entry.heading.value, "heading");
  const InstructionDetails& details = entry.details[0];
  nlohmann::ordered_json fields;
  if (entry.group) fields["path_id"] = entry.path_id;
  fields["split"] = split;
  fields["scan"] = entry.scan;
  fields["heading"] = entry.heading.value;
  fields["path"] = entry.path;
  fields["instruction_id"] = number_of(entry);
  fields["language"] = details.language;
  fields["instruction"] = entry.instructions[0];
  fields["timed_instruction"] =
      timed_words_json(details.words, fmt::format("path {}", entry.path_id));
  if (!details.tokens.empty()) fields["instr_encoding"] = details.tokens;
  try {
    return fields.dump();
  } catch (const nlohmann::json::type_error&) {
    throw not_rxr(entry, "holds text that is not UTF-8");
  }
}

ArgumentError no_follower(const Demonstration& walk, std::string_view why) {
  return ArgumentError(fmt::format("demonstration {}: {}", walk.demonstration_id, why));
}

std::string line_of(const Demonstration& walk) {
  if (std::min({walk.demonstration_id, walk.instruction_id, walk.annotator_id}) < 0) {
    throw no_follower(walk, "a negative id");
  }
  if (walk.path.empty()) throw no_follower(walk, "its path has no viewpoint");
  const std::array<double, kMetricFields> values{walk.ne,  walk.sr,   walk.spl,
                                                 walk.dtw, walk.ndtw, walk.sdtw};
  nlohmann::ordered_json metrics;
  for (std::size_t k = 0; k < kMetricFields; ++k) {
    if (!std::isfinite(values[k])) {
      throw no_follower(walk,
                        fmt::format("{} {}, not a finite number", kOfMetrics[k].name, values[k]));
    }
    metrics[std::string(kOfMetrics[k].name)] = values[k];
  }
  const nlohmann::ordered_json fields{{"demonstration_id", walk.demonstration_id},
                                      {"instruction_id", walk.instruction_id},
                                      {"annotator_id", walk.annotator_id},
                                      {"path", walk.path},
                                      {"metrics", std::move(metrics)}};
  try {
    return fields.dump();
  } catch (const nlohmann::json::type_error&) {
    throw no_follower(walk, "holds text that is not UTF-8");
  }
}

}  // namespace

std::string to_rxr_followers(std::span<const Demonstration> walks) {
  std::string lines;
  for (const Demonstration& walk : walks) lines += line_of(walk) + '\n';
  return lines;
}

Annotations parse_rxr_guide(std::string_view lines, const std::string& file, std::string split) {
  Annotations result{std::move(split), file, {}, Task::kRxr};
  Faults faults(file);
  std::vector<Line> read = read_in_parallel<Line>(lines, faults, read_line);
  Once once("repeated-id");
  const Path root;
  result.paths.reserve(read.size());
  for (Line& line : read) {
    const std::size_t record = result.paths.size();
    result.paths.push_back(std::move(line.entry));
    if (!line.instruction || faults.full()) continue;
    once.check(fmt::to_string(*line.instruction), record,
               Path(Path(root, record), "instruction_id"), faults);
  }
  faults.throw_if_errors();
  return result;
}

std::vector<Demonstration> parse_rxr_followers(std::string_view lines, const std::string& file) {
  std::vector<Demonstration> walks;
  Faults faults(file);
  Once once("repeated-id");
  for_each_record(lines, faults, [&](Element element, const Path& path) {
    const std::size_t errors = faults.errors();
    const std::size_t record = walks.size();
    const Demonstration& walk = walks.emplace_back(read_walk(element, path, faults));
    if (faults.errors() != errors) return;  // it may have no id
    once.check(fmt::to_string(walk.demonstration_id), record, Path(path, "demonstration_id"),
               faults);
  });
  faults.throw_if_errors();
  return walks;
}

std::string to_rxr_guide(const Annotations& annotations) {
  std::string lines;
  for (const PathAnnotation& entry : annotations.paths) {
    lines += line_of(entry, annotations.split);
    lines += '\n';
  }
  return lines;
}

}  // namespace enfilade::tasks::formats
