#include "enfilade/tasks/files.h"
#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/threads.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks {
namespace formats {
namespace {

constexpr std::array<std::string_view, 4> kLanguages{"en-IN", "en-US", "hi-IN", "te-IN"};

// Results of a part of a file.
template <class Value>
struct PartRead {
  explicit PartRead(const std::string& file) : faults(file) {}
  std::vector<Value> values;
  Faults faults;
  std::exception_ptr failure;
  bool any = false;
};

// Reads part k, or a list whole.
template <class Value, class Read>
void read_part(std::string_view text, const json::Parts& split, std::size_t k,
               PartRead<Value>& part, const Read& read) {
  const std::string& file = part.faults.file();
  std::optional<json::Records> records;
  if (split.is_lines) {
    records.emplace(split.texts[k], file, kMostRecordBytes, split.begins[k]);
  } else {
    records.emplace(text, file, kMostRecordBytes);
  }
  go_through(*records, part.faults, part.any, [&](const Element* element, const Path& path) {
    if (element != nullptr) {
      part.values.push_back(read(*element, path, part.faults));
    } else {
      part.values.emplace_back();
    }
  });
}

// In their order, up to where one thread would have stopped.
template <class Value>
std::vector<Value> join_parts(const json::Parts& split, std::vector<PartRead<Value>>& parts,
                              Faults& faults) {
  std::vector<Value> values;
  bool any = !split.is_lines;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    PartRead<Value>& part = parts[k];
    if (faults.full()) {
      faults.stop(Path(Path(), split.begins[k].record));
      break;
    }
    if (part.failure) std::rethrow_exception(part.failure);
    faults.append(std::move(part.faults));
    any = any || part.any;
    if (values.empty()) {
      values = std::move(part.values);
    } else {
      std::move(part.values.begin(), part.values.end(), std::back_inserter(values));
    }
  }
  if (!any) refuse_empty(faults);
  return values;
}

// for_each_record() on all threads, for files of hundreds of megabytes. `read(element, path,
// faults)` is called for several records at the same time, with a Faults shared by some of them,
// and returns a value for each. Values and faults are in the order of the file, and do not depend
// on the number of threads. A too large record gives Value(). A list is read by one thread.
template <class Value, class Read>
std::vector<Value> read_in_parallel(std::string_view text, Faults& faults, const Read& read) {
  constexpr std::size_t kPartBytes = std::size_t{1} << 22U;
  const json::Parts split = json::split_records(text, kPartBytes);
  std::vector<PartRead<Value>> parts(split.texts.size(), PartRead<Value>(faults.file()));
  parallel_for(parts.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      try {
        read_part(text, split, k, parts[k], read);
      } catch (...) {  // of several, the first in the file counts
        parts[k].failure = std::current_exception();
      }
    }
  });
  return join_parts(split, parts, faults);
}

constexpr std::array<std::pair<std::string_view, double Demonstration::*>, 6> kMetrics{
    {{"ne", &Demonstration::ne},
     {"sr", &Demonstration::sr},
     {"spl", &Demonstration::spl},
     {"dtw", &Demonstration::dtw},
     {"ndtw", &Demonstration::ndtw},
     {"sdtw", &Demonstration::sdtw}}};
constexpr auto kMetricNames = [] {
  std::array<json::Field, kMetrics.size()> fields{};
  for (std::size_t k = 0; k < fields.size(); ++k) fields[k].name = kMetrics[k].first;
  return fields;
}();

std::string read_language(Element element, const Path& path, Faults& faults) {
  const auto text = json::string(element, path, faults);
  if (!text) return {};
  if (std::ranges::find(kLanguages, *text) == kLanguages.end()) {
    faults.error(
        path, "unknown-language",
        fmt::format("{} is no language of RxR; {} are", quote(*text), fmt::join(kLanguages, ", ")));
  }
  return std::string(*text);
}

// Gives the instruction's id. Test lines go by it alone, as HAMT names them.
std::int64_t read_ids(const Fields& found, Faults& faults, PathAnnotation& entry,
                      InstructionDetails& details) {
  const std::int64_t instruction = found.get("instruction_id", read_number).value_or(0);
  if (found.has("path_id")) {
    entry.path_id = found.get("path_id", read_number).value_or(0);
    entry.group = entry.path_id;
    details.id = fmt::format("{}_{}", entry.path_id, instruction);
  } else {
    entry.path_id = instruction;
    details.id = fmt::to_string(instruction);
    if (entry.path.size() > 1) {
      faults.error(found.place("path"), "open-path",
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

Line read_guide_line(Element element, const Path& path, Faults& faults) {
  Line line;
  PathAnnotation& entry = line.entry;
  const Fields found(element,
                     {"scan", "heading", "path", "instruction_id", "language", "instruction"},
                     {"path_id", "timed_instruction", "instr_encoding"}, path, faults);
  if (!found) return line;
  const std::size_t errors = faults.errors();
  entry.scan = found.id("scan");
  entry.heading = found.get("heading", read_angle);
  entry.path = found.get("path", read_path);
  entry.instructions.push_back(found.text("instruction"));
  InstructionDetails& details = entry.details.emplace_back();
  const std::int64_t id = read_ids(found, faults, entry, details);
  details.language = found.get("language", read_language);
  details.words = found.get("timed_instruction", read_timed_words);
  details.tokens = found.get("instr_encoding", read_tokens);
  if (faults.errors() == errors) line.instruction = id;
  return line;
}

Demonstration read_walk(Element element, const Path& path, Faults& faults) {
  Demonstration walk;
  const Fields found(element,
                     {"demonstration_id", "instruction_id", "annotator_id", "path", "metrics"}, {},
                     path, faults);
  if (!found) return walk;
  walk.demonstration_id = found.get("demonstration_id", read_number).value_or(0);
  walk.instruction_id = found.get("instruction_id", read_number).value_or(0);
  walk.annotator_id = found.get("annotator_id", read_number).value_or(0);
  walk.path = found.get("path", read_path);
  const Path place = found.place("metrics");
  const Fields metrics(*found["metrics"], kMetricNames, place, faults);
  if (!metrics) return walk;
  for (const auto& [name, value] : kMetrics) {
    walk.*value = metrics.get(name, json::number).value_or(0);
  }
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
  throw not_rxr(entry,
                fmt::format("instruction id {}, not {} and a number", quote(id), quote(before)));
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
  return dump(fields, fmt::format("path {}", entry.path_id));
}

ArgumentError no_follower(const Demonstration& walk, std::string_view why) {
  return ArgumentError(fmt::format("demonstration {}: {}", walk.demonstration_id, why));
}

std::string line_of(const Demonstration& walk) {
  if (std::min({walk.demonstration_id, walk.instruction_id, walk.annotator_id}) < 0) {
    throw no_follower(walk, "a negative id");
  }
  if (walk.path.empty()) throw no_follower(walk, "its path has no viewpoint");
  nlohmann::ordered_json metrics;
  for (const auto& [name, value] : kMetrics) {
    if (!std::isfinite(walk.*value)) {
      throw no_follower(walk, fmt::format("{} {}, not a finite number", name, walk.*value));
    }
    metrics[std::string(name)] = walk.*value;
  }
  const nlohmann::ordered_json fields{{"demonstration_id", walk.demonstration_id},
                                      {"instruction_id", walk.instruction_id},
                                      {"annotator_id", walk.annotator_id},
                                      {"path", walk.path},
                                      {"metrics", std::move(metrics)}};
  return dump(fields, fmt::format("demonstration {}", walk.demonstration_id));
}

}  // namespace

Annotations parse_rxr_guide(std::string_view lines, const std::string& file, std::string split) {
  Annotations result{std::move(split), file, {}, Task::kRxr};
  Faults faults(file);
  std::vector<Line> read = read_in_parallel<Line>(lines, faults, read_guide_line);
  Once once;
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

std::string to_rxr_guide(const Annotations& annotations) {
  std::string lines;
  for (const PathAnnotation& entry : annotations.paths) {
    lines += line_of(entry, annotations.split);
    lines += '\n';
  }
  return lines;
}

}  // namespace formats

std::vector<Demonstration> load_demonstrations(const std::filesystem::path& file) {
  const TextFile content(file);
  return parse_demonstrations(content.text(), file.string());
}

std::vector<Demonstration> parse_demonstrations(std::string_view lines, const std::string& file) {
  std::vector<Demonstration> walks;
  json::Faults faults(file);
  formats::Once once;
  formats::for_each_record(lines, faults, [&](json::Element element, const json::Path& path) {
    const std::size_t errors = faults.errors();
    const std::size_t record = walks.size();
    const Demonstration& walk = walks.emplace_back(formats::read_walk(element, path, faults));
    if (faults.errors() != errors) return;  // it may have no id
    once.check(fmt::to_string(walk.demonstration_id), record, json::Path(path, "demonstration_id"),
               faults);
  });
  faults.throw_if_errors();
  return walks;
}

std::string to_text(std::span<const Demonstration> walks) {
  std::string lines;
  for (const Demonstration& walk : walks) lines += formats::line_of(walk) + '\n';
  return lines;
}

}  // namespace enfilade::tasks
