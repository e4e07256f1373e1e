#include "enfilade/arena/detail/run_file.h"

#include <fmt/format.h>
#include <string>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"

namespace enfilade::arena::detail {
namespace {

namespace fs = std::filesystem;

constexpr int kVersion = 1;

/// A value, or null.
template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

/// Of a run of an earlier version, what it did not write.
void add_usual_settings(Json& run) {
  const Json usual{{"words", "none"},
                   {"window", "auto"},
                   {"extra", nullptr},
                   {"limit_field", enum_name(LimitField::kMaxTokens)},
                   {"tool_choice", enum_name(ToolChoice::kRequired)},
                   {"response_format", enum_name(JsonForm::kSchema)},
                   {"system", true},
                   {"stream", false},
                   {"stream_usage", true},
                   {"asked", Json::object()}};
  for (const auto& [name, value] : usual.items()) {
    if (!run.contains(name)) run[name] = value;
  }
}

template <class Enum>
void read_enum(const Json& run, const char* name, Enum& value) {
  if (run.contains(name) && run[name].is_string()) {
    value = find_enum<Enum>(run[name].get<std::string>()).value_or(value);
  }
}

bool has_transcripts(const fs::path& folder) {
  return fs::directory_iterator(folder / "transcripts") != fs::directory_iterator();
}

}  // namespace

Json asked_json(const World& world, const Prompt& prompt, const AskConfig& config) {
  Json run{{"format", "enfilade-ask"},
           {"version", kVersion},
           {"task", world.task()},
           {"split", world.split()},
           {"model", config.chat.model},
           {"prompt", prompt.name()},
           {"prompt_hash", AnswerCache::key_of(prompt.text())},
           {"answers", config.answers ? Json(enum_name(*config.answers)) : Json()},
           {"temperature", or_null(config.chat.temperature)},
           {"seed", or_null(config.chat.seed)},
           {"most_tokens", or_null(config.chat.most_tokens)},
           {"steps", config.limits.steps},
           {"mistakes", config.limits.mistakes},
           {"picture_size", config.picture_size},
           {"words", config.words}};
  run["window"] =
      config.chat.window ? Json(*config.chat.window) : Json(config.shorten ? "auto" : "all");
  run["extra"] = config.chat.extra.empty() ? Json() : Json::parse(config.chat.extra);
  run["limit_field"] = config.limit_field ? Json(enum_name(*config.limit_field)) : Json();
  return run;
}

Json sent_json(Json run, const Dialect& dialect) {
  Json asked = Json::object();
  const auto leave_out = [&](const char* name, bool sent) {
    if (!sent && !run[name].is_null()) asked[name] = std::exchange(run[name], Json());
  };
  leave_out("temperature", dialect.temperature);
  leave_out("seed", dialect.seed);
  leave_out("most_tokens", dialect.limit != LimitField::kNone);
  run["answers"] = enum_name(dialect.answers);
  run["limit_field"] = enum_name(dialect.limit);
  run["tool_choice"] = enum_name(dialect.tool_choice);
  run["response_format"] = enum_name(dialect.json);
  run["system"] = dialect.system;
  run["stream"] = dialect.stream;
  run["stream_usage"] = dialect.stream_usage;
  run["asked"] = std::move(asked);
  return run;
}

Dialect dialect_of(const Json& run) {
  Dialect dialect;
  read_enum(run, "answers", dialect.answers);
  read_enum(run, "limit_field", dialect.limit);
  read_enum(run, "tool_choice", dialect.tool_choice);
  read_enum(run, "response_format", dialect.json);
  const auto flag = [&run](const char* name, bool& value) {
    if (run.contains(name) && run[name].is_boolean()) value = run[name].get<bool>();
  };
  flag("system", dialect.system);
  flag("stream", dialect.stream);
  flag("stream_usage", dialect.stream_usage);
  const bool has_asked = run.contains("asked") && run["asked"].is_object();
  dialect.temperature = !has_asked || !run["asked"].contains("temperature");
  dialect.seed = !has_asked || !run["asked"].contains("seed");
  return dialect;
}

std::optional<Json> run_of(const fs::path& folder, const Json& asked) {
  const OutputFolder out(folder);
  const OutputFolder transcripts = out.folder("transcripts");
  out.remove_unfinished();
  transcripts.remove_unfinished();
  const fs::path file = folder / "run.json";
  if (!file_exists(file)) return std::nullopt;
  Json there = Json::parse(read_file(file), nullptr, false);
  if (!there.is_object()) {
    throw InvalidInput(
        {{Severity::kError, file.string(), "$", "not-a-run", "no JSON object; is it a run?"}});
  }
  if (!has_transcripts(folder)) return std::nullopt;
  add_usual_settings(there);
  for (const auto& [name, value] : asked.items()) {
    const bool any = value.is_null() && (name == "answers" || name == "limit_field");
    const Json& first =
        there["asked"].is_object() && there["asked"].contains(name) ? there["asked"] : there;
    if (any || (first.contains(name) && first[name] == value)) continue;
    throw InvalidInput(
        {{Severity::kError, file.string(), "$." + name, "other-run",
          fmt::format("{}, and {} is asked for; name another folder, or the same settings",
                      first.contains(name) ? first[name].dump() : "nothing", value.dump())}});
  }
  return there;
}

}  // namespace enfilade::arena::detail
