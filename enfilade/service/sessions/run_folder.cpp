#include "enfilade/service/sessions/run_folder.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/service/detail/refusal.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::service::sessions {
namespace {

using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

constexpr std::size_t kMostIndexBytes = 64U << 20U;
constexpr std::size_t kEntryBytes = 128;  // of an index, about
constexpr std::uint32_t kLeastPicture = 64, kMostPicture = 2048;

bool has_goal_secrets(const Site& site) {
  return std::ranges::any_of(site.phases(), &Phase::goals_secret);
}

const PublicSplit* find_served(const Run& run, const Site& site) {
  const auto found = std::ranges::find_if(site.splits(), [&run](const PublicSplit& one) {
    return one.annotations.split == run.split &&
           tasks::benchmark(one.annotations.task).name == run.task;
  });
  return found == site.splits().end() ? nullptr : &*found;
}

/// What run.json says; MCP and Python write none.
void read_description(Run& run) {
  const auto said = read_run_file(run.folder / "run.json");
  if (!said) return;
  if (!said->is_object()) {
    run.problem = "run.json: no JSON object";
    return;
  }
  run.task = text_in(*said, "task");
  run.split = text_in(*said, "split");
  run.model = text_in(*said, "model");
  run.prompt = text_in(*said, "prompt");
  const auto size = said->find("picture_size");
  if (size != said->end() && size->is_number_unsigned()) {
    const auto pixels = size->get<std::uint64_t>();
    if (pixels >= kLeastPicture && pixels <= kMostPicture) {
      run.picture_size = static_cast<std::uint32_t>(pixels);
    }
  }
}

bool has_episode(const PublicSplit& split, std::string_view id, const std::string& instruction) {
  for (const tasks::PathAnnotation& path : split.annotations.paths) {
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      if (path.instructions[k] == instruction && tasks::instruction_id(path, k) == id) return true;
    }
  }
  return false;
}

/// By an episode of it, where no file says it. No index is made for that: those of all splits, with
/// R4R's large ones, would not fit into SplitIndices.
void find_split(Run& run, const Site& site) {
  if ((run.task && run.split) || run.transcripts.empty()) return;
  const NamedPath& transcript = run.transcripts.front();
  const auto instruction = instruction_in(transcript.path);
  if (!instruction) return;
  for (const PublicSplit& one : site.splits()) {
    if (!has_episode(one, transcript.name, *instruction)) continue;
    run.task = tasks::benchmark(one.annotations.task).name;
    run.split = one.annotations.split;
    return;
  }
}

void keep_secrets(Run& run, const Site& site) {
  if (run.is_continuous()) return;
  if (run.served == nullptr) {
    if (!has_goal_secrets(site)) return;
    run.transcripts.clear();
    run.problem = "not shown: this server has secret goals, and no such split to compare with";
  } else if (run.served->goals_hidden) {
    std::erase_if(run.transcripts,
                  [&run](const NamedPath& one) { return run.find(one.name) == nullptr; });
  }
}

}  // namespace

const EpisodePlace* find_place(const SplitIndex* index, std::string_view id) {
  if (index == nullptr) return nullptr;
  const auto found = index->find(id);
  return found == index->end() ? nullptr : &found->second;
}

SplitIndices::SplitIndices()
    : made_(kMostIndexBytes, [](const std::shared_ptr<const SplitIndex>& index) {
        return std::max<std::size_t>(1, index->size() * kEntryBytes);
      }) {}

std::shared_ptr<const SplitIndex> SplitIndices::of(const PublicSplit& split) {
  return made_.get(&split, [&split] {
    auto index = std::make_shared<SplitIndex>();
    for (const tasks::PathAnnotation& path : split.annotations.paths) {
      for (std::size_t k = 0; k < path.instructions.size(); ++k) {
        index->try_emplace(tasks::instruction_id(path, k), EpisodePlace{&split, &path, k});
      }
    }
    return std::shared_ptr<const SplitIndex>(std::move(index));
  });
}

ordered_json Run::to_json() const {
  ordered_json out{{"run", name}};
  for (const auto& [key, value] :
       {std::pair{"task", &task}, {"split", &split}, {"model", &model}, {"prompt", &prompt}}) {
    out[key] = *value ? ordered_json(**value) : ordered_json();
  }
  if (!problem.empty()) out["problem"] = problem;
  out["outcomes"] = has_outcomes();
  out["episodes"] = transcripts.size();
  return out;
}

bool Run::is_continuous() const {
  const tasks::Benchmark* known = task ? tasks::find_benchmark(*task) : nullptr;
  return known != nullptr && known->continuous();
}

bool Run::shows_text(std::string_view id, std::string_view instruction) const {
  if (!goals_hidden()) return true;
  const EpisodePlace* found = find(id);
  return found != nullptr && found->text() == instruction;
}

const NamedPath& Run::transcript_of(std::string_view episode) const {
  const auto file = std::ranges::find(transcripts, episode, &NamedPath::name);
  if (file != transcripts.end()) return *file;
  throw Refusal(Reason::kNotFound, fmt::format("run {} has no episode {:.80?}", name, episode));
}

Run open_run(NamedPath found, const Site& site, SplitIndices& indices) {
  Run run{.name = std::move(found.name), .folder = std::move(found.path)};
  run.transcripts = transcripts_in(run.folder);
  read_description(run);
  find_split(run, site);
  run.served = find_served(run, site);
  if (run.served != nullptr) run.index = indices.of(*run.served);
  keep_secrets(run, site);
  return run;
}

}  // namespace enfilade::service::sessions
