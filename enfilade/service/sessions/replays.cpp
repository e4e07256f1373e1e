#include "enfilade/service/sessions/sessions.h"

#include <fmt/format.h>
#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <istream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "enfilade/arena/wire.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::sessions {
namespace {

namespace fs = std::filesystem;
using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

constexpr std::size_t kLongestName = 200;                  // characters
constexpr std::uintmax_t kMostRunBytes = 1ULL << 20ULL;    // of run.json
constexpr std::uintmax_t kMostEndBytes = 256ULL << 10ULL;  // of a transcript's last line
constexpr std::string_view kSuffix = ".jsonl";
/// Limits of all files: runs may come from any source, and deep values are copied by recursion.
constexpr json::Limits kLimits{1'000'000, detail::kMostLevels};

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

std::string first_bytes(std::istream& stream, std::uintmax_t most) {
  std::string text(most, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

/// The folder of a run, or the transcript of an episode, whose id is its name.
struct NamedPath {
  std::string name;
  fs::path path;
};

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

/// In the order of their ids: by length, then by letters, so that 2_0 is before 10_0.
std::vector<NamedPath> transcripts_in(const fs::path& run) {
  auto found = named_paths(run / "transcripts", [](const fs::path& file) {
    // The inverse of what arena::detail::transcript_file() makes of an id.
    return file.extension() == kSuffix && is_file(file)
               ? decode_percent(file.stem().string())
               : std::string();
  });
  std::ranges::sort(found, {}, [](const NamedPath& file) {
    return std::pair(file.name.size(), std::string_view(file.name));
  });
  return found;
}

/// The text that an object has under a name, if it has one.
std::optional<std::string> text_in(const ordered_json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

bool is_count(const ordered_json& object, const char* name) {
  return object.contains(name) && object[name].is_number_unsigned();
}

bool is_ending(const ordered_json& line) {
  const auto ending = line.is_object() ? text_in(line, "ending") : std::nullopt;
  return ending && find_enum<arena::Ending>(*ending) && is_count(line, "steps") &&
         is_count(line, "mistakes");
}

/// The last line of a transcript, of which no more is read than that; discarded if it is none.
ordered_json last_line(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uintmax_t>(std::max<std::streamoff>(0, stream.tellg()));
  std::string text(std::min(size, kMostEndBytes), '\0');
  stream.seekg(static_cast<std::streamoff>(size - text.size()));
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  const std::size_t before = text.find_last_not_of('\n');
  const std::size_t begin = before == std::string::npos ? 0 : text.rfind('\n', before) + 1;
  return parse(std::string_view(text).substr(begin));
}

struct Step {
  ordered_json shown;  // the served part of the line
  std::optional<arena::Call> call;
};

struct Transcript {
  std::string instruction;
  std::vector<Step> steps;
  ordered_json end;
};

/// Copies those of the names that an object has.
ordered_json parts_of(const ordered_json& object, std::initializer_list<const char*> names) {
  ordered_json parts = ordered_json::object();
  for (const char* name : names) {
    if (object.contains(name)) parts[name] = object[name];
  }
  return parts;
}

ordered_json end_of(const ordered_json& line) {
  return parts_of(line, {"ending", "steps", "mistakes"});
}

class TranscriptReader {
 public:
  explicit TranscriptReader(const fs::path& path)
      : name_(fmt::format("transcripts/{}", path.filename().string())) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (!error && size > Replays::kMostBytes) {
      throw Refusal(Reason::kInvalidInput,
                    fmt::format("{}: {} bytes, {} at most", name_, size, Replays::kMostBytes));
    }
    try {
      text_ = read_file(path);
    } catch (const FileError&) {  // what it says names folders of this machine
      throw Refusal(Reason::kInvalidInput, fmt::format("{}: cannot be read", name_));
    }
    constexpr json::Limits kWhole{kLimits.values, std::numeric_limits<std::size_t>::max()};
    const std::string excess = json::excess(text_, kWhole);
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
    if (++line_ > Replays::kMostLines) {
      refuse(fmt::format("more than {} lines", Replays::kMostLines));
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

  Step step_of(const ordered_json& line) const {
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
    Step step;
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
    return step;
  }

  std::string name_, text_;
  std::size_t at_ = 0, line_ = 0;
};

/// Whether what a session sees is what a transcript says that it saw, as far as that tells the
/// place: later versions may put it in other words.
bool is_same_place(const ordered_json& told, const ordered_json& seen) {
  for (const char* name : {"step", "here", "heading", "elevation"}) {
    if (!told.contains(name) || told[name] != seen.at(name)) return false;
  }
  const ordered_json& places = seen.at("places");
  if (!told.contains("places") || told["places"].size() != places.size()) return false;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ordered_json& place = told["places"][k];
    if (!place.is_object()) return false;
    for (const char* name : {"name", "turn", "elevation", "distance"}) {
      if (!place.contains(name) || place[name] != places[k].at(name)) return false;
    }
  }
  return true;
}

/// Where a session stands and looks, degrees, how it came there, and which viewpoints the places
/// are. \param walked points of its trajectory that were told before; then all that there are
ordered_json place_of(const arena::GraphSession& session, const graph::NavGraph& graph,
                      std::size_t& walked) {
  const arena::GraphPose pose = session.pose();
  ordered_json at{{"viewpoint", graph.id(pose.location.viewpoint)},
                  {"heading", to_degrees(pose.heading)},
                  {"elevation", to_degrees(pose.elevation)}};
  ordered_json& path = at["path"] = ordered_json::array();
  const auto trajectory = std::get<tasks::Trajectory>(session.walked());
  for (; walked < trajectory.points.size(); ++walked) {
    path.push_back(graph.id(trajectory.points[walked].viewpoint));
  }
  ordered_json& places = at["places"] = ordered_json::object();
  for (const arena::Neighbour& one : session.observation().places) {
    places[one.name] = graph.id(session.viewpoint_of(one.name));
  }
  return at;
}

/// One path of a split with the number of one of its instructions.
struct Found {
  const PublicSplit* split = nullptr;
  const tasks::PathAnnotation* path = nullptr;
  std::size_t number = 0;
};

std::optional<Found> find_in(const PublicSplit& split, std::string_view id) {
  for (const tasks::PathAnnotation& path : split.annotations.paths) {
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      if (tasks::instruction_id(path, k) == id) return Found{&split, &path, k};
    }
  }
  return std::nullopt;
}

/// Walks a transcript's calls again. Adds to the steps where they stood, and to `out` the scan.
/// \returns the first step, from 1, at which it came out differently; 0: none
std::size_t walk_again(const std::shared_ptr<const Site>& site, const Found& found,
                       Transcript& transcript, ordered_json& out) {
  const tasks::Annotations& all = found.split->annotations;
  // Only one path of the split: the replay needs no other.
  const auto world =
      graph_world(site, {all.split, all.file, {*found.path}, all.task}, tasks::Instructions::kAll);
  const tasks::EpisodeSet& set = *world->episodes().on_graph();
  const graph::NavGraph& graph = set.graph_of(set.episodes.at(found.number));
  out["scan"] = graph.scan();
  std::vector<Step>& steps = transcript.steps;
  // Its end is the transcript's: no limit of another run ends it before.
  const auto most = static_cast<std::uint32_t>(steps.size() + 1);
  const auto session = world->start_on_graph(found.number, {most, most});
  std::size_t walked = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const auto seen = ordered_json::parse(to_json(session->observation()));
    const bool same = !session->ending() && is_same_place(steps[k].shown.at("observation"), seen);
    if (!same) return k + 1;
    steps[k].shown["at"] = place_of(*session, graph, walked);
    if (steps[k].call) {
      session->call(*steps[k].call);
    } else {
      session->misread("no call");
    }
  }
  transcript.end["at"] = place_of(*session, graph, walked);
  return 0;
}

/// By name. A folder with transcripts/ is a run itself.
std::vector<NamedPath> run_folders(const fs::path& folder) {
  if (folder.empty()) return {};
  if (is_folder(folder / "transcripts")) return {{folder.filename().string(), folder}};
  auto found = named_paths(folder, [](const fs::path& run) {
    return is_folder(run / "transcripts") ? run.filename().string() : std::string();
  });
  std::ranges::sort(found, {}, &NamedPath::name);
  return found;
}

}  // namespace

// A folder of a run, and what is known of it.
struct Replays::Run {
  std::string name;
  fs::path folder;
  std::optional<std::string> task = {}, split = {}, model = {}, prompt = {};
  std::string problem = {};
  std::vector<NamedPath> transcripts = {};  // those that everybody may see

  Run(NamedPath found, const Site& site)
      : name(std::move(found.name)),
        folder(std::move(found.path)),
        transcripts(transcripts_in(folder)) {
    read_description();
    if (!transcripts.empty()) find_split(site, transcripts.front());
    keep_secrets(site);
  }

  ordered_json to_json() const {
    ordered_json out{{"run", name}};
    for (const auto& [key, value] :
         {std::pair{"task", &task}, {"split", &split}, {"model", &model}, {"prompt", &prompt}}) {
      out[key] = *value ? ordered_json(**value) : ordered_json();
    }
    if (!problem.empty()) out["problem"] = problem;
    out["episodes"] = transcripts.size();
    return out;
  }

  /// What run.json says; MCP and Python write none.
  void read_description() {
    const fs::path file = folder / "run.json";
    if (!is_file(file)) return;
    std::ifstream stream(file, std::ios::binary);
    const ordered_json run = parse(first_bytes(stream, kMostRunBytes));
    if (!run.is_object()) {
      problem = "run.json: no JSON object";
      return;
    }
    task = text_in(run, "task");
    split = text_in(run, "split");
    model = text_in(run, "model");
    prompt = text_in(run, "prompt");
  }

  /// By an episode of it, where no file says it.
  void find_split(const Site& site, const NamedPath& transcript) {
    if (task && split) return;
    std::ifstream stream(transcript.path, std::ios::binary);
    const std::string text = first_bytes(stream, kMostEndBytes);
    const ordered_json head = parse(std::string_view(text).substr(0, text.find('\n')));
    const auto instruction = head.is_object() ? text_in(head, "instruction") : std::nullopt;
    if (!instruction) return;
    for (const PublicSplit& one : site.splits()) {
      const auto found = find_in(one, transcript.name);
      if (!found || found->path->instructions[found->number] != *instruction) continue;
      task = tasks::benchmark(one.annotations.task).name;
      split = one.annotations.split;
      return;
    }
  }

  bool is_continuous() const {
    const tasks::Benchmark* known = task ? tasks::find_benchmark(*task) : nullptr;
    return known != nullptr && known->continuous();
  }

  const PublicSplit* served_split(const Site& site) const {
    const auto found = std::ranges::find_if(site.splits(), [this](const PublicSplit& one) {
      return one.annotations.split == split && tasks::benchmark(one.annotations.task).name == task;
    });
    return found == site.splits().end() ? nullptr : &*found;
  }

  /// Ids and texts may tell goals: REVERIE's name objects, R4R's texts are of two paths. Of a split
  /// with hidden goals only what the site shows of it is shown, and where there are secret goals
  /// nothing of a split that the site does not know or has left out.
  void keep_secrets(const Site& site) {
    if (is_continuous()) return;
    const PublicSplit* served = served_split(site);
    if (served == nullptr) {
      if (std::ranges::none_of(site.phases(), &Phase::goals_secret)) return;
      transcripts.clear();
      problem = "not shown: this server has secret goals, and no such split to compare with";
    } else if (served->goals_hidden) {
      std::set<std::string, std::less<>> ids;
      for (const tasks::PathAnnotation& path : served->annotations.paths) {
        for (std::size_t k = 0; k < path.instructions.size(); ++k) {
          ids.insert(tasks::instruction_id(path, k));
        }
      }
      std::erase_if(transcripts, [&](const NamedPath& one) { return !ids.contains(one.name); });
    }
  }
  /// The same of an episode's text. \throws Refusal
  void check_text(const Site& site, std::string_view id, const std::string& instruction) const {
    const PublicSplit* served = served_split(site);
    if (served == nullptr || !served->goals_hidden) return;
    const auto found = find_in(*served, id);
    if (found && found->path->instructions[found->number] == instruction) return;
    throw Refusal(Reason::kNotFound,
                  "its instruction is not that of this server's split, whose goals are hidden");
  }

  /// Where the steps were. \returns why that is not known of some; empty: of all it is
  std::string find_places(const std::shared_ptr<const Site>& site, std::string_view id,
                          Transcript& transcript, ordered_json& out) const {
    if (is_continuous()) {
      return "the steps of a walk in continuous space have no viewpoints";
    }
    const PublicSplit* served = served_split(*site);
    const auto found = served == nullptr ? std::nullopt : find_in(*served, id);
    if (!found) return "this server has no such episode, so where the steps were is not known";
    try {
      const std::size_t different = walk_again(site, *found, transcript, out);
      if (different == 0) return {};
      return fmt::format(
          "walked again, step {} comes out differently from the transcript: the data set here is "
          "another one, or the file was changed. From there on the places are not known",
          different);
    } catch (const Error&) {  // what it says may name files of this machine
      return "the episode cannot be walked again here, so where the steps were is not known";
    }
  }
};

Replays::Replays(std::shared_ptr<const Site> site, const fs::path& folder)
    : site_(std::move(site)) {
  if (folder.empty()) return;
  std::error_code error;
  folder_ = fs::canonical(folder, error);
  if (error || !fs::is_directory(folder_, error)) {
    throw FileError(fmt::format("{}: not a folder; runs of `enfilade ask` are looked for there",
                                folder.string()));
  }
}

Replays::Run Replays::find(std::string_view name) const {
  for (NamedPath& one : run_folders(folder_)) {
    if (one.name == name) return {std::move(one), *site_};
  }
  throw Refusal(Reason::kNotFound, fmt::format("there is no run {:.80?}", name));
}

ordered_json Replays::runs(std::string_view episode) const {
  ordered_json list = ordered_json::array();
  for (NamedPath& one : run_folders(folder_)) {
    if (list.size() == kMostRuns) break;
    const Run run(std::move(one), *site_);
    const auto& all = run.transcripts;
    const bool wanted =
        episode.empty() || std::ranges::find(all, episode, &NamedPath::name) != all.end();
    if (wanted) list.push_back(run.to_json());
  }
  return {{"runs", std::move(list)}};
}

ordered_json Replays::run(std::string_view name, std::size_t offset, std::size_t limit) const {
  const Run run = find(name);
  const auto& transcripts = run.transcripts;
  ordered_json out = run.to_json();
  ordered_json& list = out["list"] = ordered_json::array();
  for (std::size_t k = offset; k < transcripts.size() && list.size() < limit; ++k) {
    ordered_json& one = list.emplace_back(ordered_json{{"episode", transcripts[k].name}});
    const ordered_json end = last_line(transcripts[k].path);
    if (is_ending(end)) {
      one.update(end_of(end));
    } else {
      one["problem"] = "the last line is no end of an episode";
    }
  }
  return out;
}

ordered_json Replays::episode(std::string_view name, std::string_view episode) const {
  const Run run = find(name);
  const auto file = std::ranges::find(run.transcripts, episode, &NamedPath::name);
  if (file == run.transcripts.end()) {
    throw Refusal(Reason::kNotFound,
                  fmt::format("run {} has no episode {:.80?}", run.name, episode));
  }
  Transcript transcript = TranscriptReader(file->path).read();
  run.check_text(*site_, file->name, transcript.instruction);
  ordered_json out = run.to_json();
  out.erase("episodes");
  out["episode"] = file->name;
  out["instruction"] = transcript.instruction;
  out["scan"] = nullptr;
  const std::string problem = run.find_places(site_, file->name, transcript, out);
  ordered_json& steps = out["steps"] = ordered_json::array();
  for (Step& step : transcript.steps) steps.push_back(std::move(step.shown));
  out["end"] = std::move(transcript.end);
  if (!problem.empty()) out["place_problem"] = problem;
  return out;
}

}  // namespace enfilade::service::sessions
