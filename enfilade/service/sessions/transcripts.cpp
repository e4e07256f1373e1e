#include "enfilade/service/sessions/transcripts.h"

#include <fmt/format.h>
#include <simdjson.h>
#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <istream>
#include <limits>
#include <utility>

#include "enfilade/arena/chat.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/core/texts.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::sessions {
namespace {

namespace fs = std::filesystem;
using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

constexpr std::size_t kLongestName = 200;                  // characters
constexpr std::uintmax_t kMostRunBytes = 1ULL << 20ULL;    // of run.json
constexpr std::uintmax_t kMostEndBytes = 256ULL << 10ULL;  // of a transcript's last line
constexpr std::size_t kMostReasonBytes = 500;
constexpr std::uint64_t kMostCount = 1'000'000'000;  // of a line: sums of them stay numbers
constexpr std::string_view kSuffix = ".jsonl";
/// Limits of all files: runs may come from any source, and deep values are copied by recursion.
constexpr json::Limits kLimits{1'000'000, detail::kMostLevels};
constexpr json::Limits kWholeFile{kLimits.values, std::numeric_limits<std::size_t>::max()};

/// Discarded if it is no JSON, or beyond the limits.
ordered_json parse(std::string_view text) {
  if (!json::excess(text, kLimits).empty()) return {ordered_json::value_t::discarded};
  return ordered_json::parse(text, nullptr, false);
}

bool is_folder(const fs::path& path) {
  std::error_code none;
  return fs::is_directory(fs::symlink_status(path, none));
}

bool is_file(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(fs::symlink_status(path, none));
}

std::string first_bytes(const fs::path& file, std::uintmax_t most) {
  std::ifstream stream(file, std::ios::binary);
  std::string text(most, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

std::string last_bytes(const fs::path& file, std::uintmax_t most) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uintmax_t>(std::max<std::streamoff>(0, stream.tellg()));
  std::string text(std::min(size, most), '\0');
  stream.seekg(static_cast<std::streamoff>(size - text.size()));
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  return text;
}

/// What is in a folder and has a name. \param name_of empty for what is left out
template <class NameOf>
std::vector<NamedPath> named_paths(const fs::path& folder, const NameOf& name_of) {
  std::vector<NamedPath> found;
  std::error_code error;
  for (fs::directory_iterator one(folder, error), end; !error && one != end; one.increment(error)) {
    std::string name = name_of(one->path());
    if (detail::is_label(name, kLongestName)) found.push_back({std::move(name), one->path()});
  }
  return found;
}

bool is_count(const ordered_json& object, const char* name) {
  return object.contains(name) && object[name].is_number_unsigned();
}

bool is_ending(const ordered_json& line) {
  const auto ending = line.is_object() ? text_in(line, "ending") : std::nullopt;
  return ending && find_enum<arena::Ending>(*ending) && is_count(line, "steps") &&
         is_count(line, "mistakes");
}

/// The last line of a text, discarded if it is no JSON.
ordered_json last_line(std::string_view text) {
  const std::size_t before = text.find_last_not_of('\n');
  const std::size_t begin = before == std::string_view::npos ? 0 : text.rfind('\n', before) + 1;
  return parse(text.substr(begin));
}

std::string result_in(const ordered_json& end) {
  const auto found = end.find("result");
  return found == end.end() ? std::string() : found->dump();
}

/// Copies those of the names that an object has.
ordered_json parts_of(const ordered_json& object, std::initializer_list<const char*> names) {
  ordered_json parts = ordered_json::object();
  for (const char* name : names) {
    if (object.contains(name)) parts[name] = object[name];
  }
  return parts;
}

ordered_json end_of(const ordered_json& line) {
  ordered_json end = parts_of(line, {"ending", "steps", "mistakes"});
  if (auto reason = text_in(line, "reason")) {
    end["reason"] = beginning(std::move(*reason), kMostReasonBytes);
  }
  return end;
}

class TranscriptReader {
 public:
  explicit TranscriptReader(const fs::path& path)
      : name_(fmt::format("transcripts/{}", path.filename().string())) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (!error && size > kMostTranscriptBytes) {
      throw Refusal(Reason::kInvalidInput,
                    fmt::format("{}: {} bytes, {} at most", name_, size, kMostTranscriptBytes));
    }
    try {
      text_ = read_file(path);
    } catch (const FileError&) {  // what it says names folders of this machine
      throw Refusal(Reason::kInvalidInput, fmt::format("{}: cannot be read", name_));
    }
    const std::string excess = json::excess(text_, kWholeFile);
    if (!excess.empty()) {
      throw Refusal(Reason::kInvalidInput, fmt::format("{}: {}", name_, excess));
    }
  }

  Transcript read() {
    Transcript read;
    const ordered_json head = next();
    const auto instruction = text_in(head, "instruction");
    if (!instruction) refuse("no instruction; the first line is of the episode");
    read.instruction = *instruction;
    for (;;) {
      if (at_ == text_.size()) {
        ++line_;
        refuse("the end is missing; the transcript was not written to its end");
      }
      const ordered_json line = next();
      if (is_ending(line)) {
        read.end = end_of(line);
        read.result = result_in(line);
        return read;
      }
      read.steps.push_back(step_of(line));
    }
  }

 private:
  [[noreturn]] void refuse(std::string_view what) const {
    throw Refusal(Reason::kInvalidInput, fmt::format("{}, line {}: {}", name_, line_, what));
  }

  ordered_json next() {
    if (++line_ > kMostTranscriptLines) {
      refuse(fmt::format("more than {} lines", kMostTranscriptLines));
    }
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    ordered_json line = parse(std::string_view(text_).substr(at_, end - at_));
    at_ = std::min(end + 1, text_.size());
    if (!line.is_object()) {
      refuse(fmt::format("no JSON object of at most {} levels", detail::kMostLevels));
    }
    return line;
  }

  using Names = std::initializer_list<const char*>;

  /// What pages reckon with. \param where the object's name and a dot
  void check(const ordered_json& object, std::string_view where, Names numbers, Names texts) const {
    for (const char* name : numbers) {
      if (!object.contains(name) || !object[name].is_number()) {
        refuse(fmt::format("{}{}: not a number", where, name));
      }
    }
    for (const char* name : texts) {
      if (!text_in(object, name)) refuse(fmt::format("{}{}: not a text", where, name));
    }
  }

  void check_list(const ordered_json& seen, const char* name, Names numbers, Names texts) const {
    const auto list = seen.find(name);
    if (list == seen.end()) return;
    if (!list->is_array()) refuse(fmt::format("observation.{}: not a list", name));
    for (std::size_t k = 0; k < list->size(); ++k) {
      const std::string where = fmt::format("observation.{}[{}]", name, k);
      if (!(*list)[k].is_object()) refuse(where + ": not an object");
      check((*list)[k], where + ".", numbers, texts);
    }
  }

  TranscriptStep step_of(const ordered_json& line) const {
    if (!line.contains("observation") || !line["observation"].is_object()) {
      refuse("neither a step nor an end: no observation");
    }
    const ordered_json& seen = line["observation"];
    check(seen, "observation.", {"heading", "elevation", "step"}, {"told"});
    check_list(seen, "places", {"turn", "elevation", "distance"}, {"name"});
    check_list(seen, "things", {"turn", "elevation"}, {"name", "category"});
    check_list(seen, "map", {}, {"name"});
    check_list(seen, "tools", {}, {"tool"});
    if (seen.contains("here")) check(seen, "observation.", {}, {"here"});
    TranscriptStep step;
    step.shown["observation"] = parts_of(seen, {"step", "heading", "elevation", "what", "here",
                                                "places", "things", "map", "told", "tools"});
    step.shown["call"] = nullptr;
    if (line.contains("call") && !line["call"].is_null()) {
      const ordered_json& call = line["call"];
      const auto tool = call.is_object() ? text_in(call, "tool") : std::nullopt;
      const auto argument = call.is_object() ? text_in(call, "argument") : std::nullopt;
      if (!tool || !argument) refuse("call: neither null nor an object of tool and argument");
      step.call = arena::Call{*tool, *argument};
      step.shown["call"] = {{"tool", *tool}, {"argument", *argument}};
    }
    const auto told = text_in(line, "told");
    if (!told) refuse("told: not a text");
    step.shown["told"] = *told;
    if (const auto text = text_in(line, "text")) step.shown["text"] = *text;
    for (const char* name : {"prompt_tokens", "answer_tokens"}) {
      if (is_count(line, name)) step.shown[name] = line[name];
    }
    if (const auto flaw = text_in(line, "flaw"); flaw && find_enum<arena::AnswerFlaw>(*flaw)) {
      step.shown["flaw"] = *flaw;
    }
    const auto pictures = line.find("pictures");
    if (pictures == line.end() || !pictures->is_array()) return step;
    for (const ordered_json& key : *pictures) {
      step.pictures.push_back(key.is_string() ? key.get<std::string>() : std::string());
    }
    return step;
  }

  std::string name_, text_;
  std::size_t at_ = 0, line_ = 0;
};

std::uint64_t count_in(const ordered_json& object, const char* name) {
  return std::min(object[name].get<std::uint64_t>(), kMostCount);
}

std::uint64_t count_in(simdjson::dom::element line, const char* name) {
  std::uint64_t count = 0;
  return line[name].get(count) == simdjson::SUCCESS ? std::min(count, kMostCount) : 0;
}

/// Adds what the lines of a whole transcript say of answers.
void add_answers(std::string& text, TranscriptSummary& summary) {
  text.reserve(text.size() + simdjson::SIMDJSON_PADDING);  // so that no line is copied
  simdjson::dom::parser parser;
  std::size_t lines = 0;
  for (std::size_t at = 0; at < text.size() && lines < kMostTranscriptLines; ++lines) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    simdjson::dom::element line;
    if (parser.parse(text.data() + at, end - at, false).get(line) == simdjson::SUCCESS) {
      summary.prompt_tokens += count_in(line, "prompt_tokens");
      summary.answer_tokens += count_in(line, "answer_tokens");
      std::string_view flaw;
      const bool flawed = line["flaw"].get(flaw) == simdjson::SUCCESS;
      summary.unanswered += flawed && find_enum<arena::AnswerFlaw>(flaw) ? 1 : 0;
    }
    at = end + 1;
  }
}

}  // namespace

std::vector<NamedPath> run_folders(const fs::path& folder) {
  if (folder.empty()) return {};
  if (is_folder(folder / "transcripts")) return {{folder.filename().string(), folder}};
  auto found = named_paths(folder, [](const fs::path& run) {
    return is_folder(run / "transcripts") ? run.filename().string() : std::string();
  });
  std::ranges::sort(found, {}, &NamedPath::name);
  return found;
}

std::vector<NamedPath> transcripts_in(const fs::path& run) {
  auto found = named_paths(run / "transcripts", [](const fs::path& file) {
    // The inverse of what arena::detail::transcript_file() makes of an id.
    return file.extension() == kSuffix && is_file(file) ? decode_percent(file.stem().string())
                                                        : std::string();
  });
  std::ranges::sort(found, {}, [](const NamedPath& file) {
    return std::pair(file.name.size(), std::string_view(file.name));
  });
  return found;
}

std::optional<ordered_json> read_run_file(const fs::path& file) {
  if (!is_file(file)) return std::nullopt;
  ordered_json read = parse(first_bytes(file, kMostRunBytes));
  return read.is_object() ? std::move(read) : ordered_json(ordered_json::value_t::discarded);
}

std::optional<std::string> instruction_in(const fs::path& transcript) {
  const std::string text = first_bytes(transcript, kMostEndBytes);
  const ordered_json head = parse(std::string_view(text).substr(0, text.find('\n')));
  return head.is_object() ? text_in(head, "instruction") : std::nullopt;
}

std::optional<std::string> text_in(const ordered_json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

std::string beginning(std::string text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto continues = [&text](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  while (most > 0 && continues(most)) --most;
  text.resize(most);
  return text + "…";
}

Transcript read_transcript(const fs::path& file) { return TranscriptReader(file).read(); }

TranscriptSummary summarise_transcript(const fs::path& file) {
  TranscriptSummary summary;
  std::error_code error;
  const bool whole = fs::file_size(file, error) <= kMostTranscriptBytes && !error;
  const ordered_json end = last_line(last_bytes(file, kMostEndBytes));
  if (is_ending(end)) {
    summary.ending = find_enum<arena::Ending>(*text_in(end, "ending"));
    summary.reason = beginning(text_in(end, "reason").value_or(""), kMostReasonBytes);
    summary.steps = count_in(end, "steps");
    summary.mistakes = count_in(end, "mistakes");
    summary.result = result_in(end);
  }
  summary.instruction = instruction_in(file).value_or("");
  if (!whole) return summary;
  try {
    std::string text = read_file(file);
    if (json::excess(text, kWholeFile).empty()) add_answers(text, summary);
  } catch (const FileError&) {
    // gone meanwhile
  }
  return summary;
}

}  // namespace enfilade::service::sessions
