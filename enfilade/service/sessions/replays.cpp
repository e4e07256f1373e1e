#include "enfilade/service/sessions/replays.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/sessions/outcome.h"
#include "enfilade/service/sessions/transcripts.h"
#include "enfilade/service/sessions/walk_again.h"

namespace enfilade::service::sessions {
namespace {

using detail::Reason;
using detail::Refusal;
using nlohmann::ordered_json;

constexpr std::size_t kMostDrawnBytes = 64U << 20U;

/// An episode's transcript, which may be shown. \throws Refusal
Transcript open_transcript(const Run& run, std::string_view episode) {
  Transcript transcript = read_transcript(run.transcript_of(episode).path);
  if (run.shows_text(episode, transcript.instruction)) return transcript;
  throw Refusal(Reason::kNotFound,
                "its instruction is not that of this server's split, whose goals are hidden");
}

}  // namespace

Replays::Replays(std::shared_ptr<const Site> site, const std::filesystem::path& folder,
                 std::shared_ptr<Painters> painters)
    : site_(std::move(site)),
      painters_(std::move(painters)),
      known_(site_),
      drawn_(kMostDrawnBytes,
             [](const std::shared_ptr<const std::string>& jpeg) { return jpeg->size(); }) {
  if (folder.empty()) return;
  std::error_code error;
  folder_ = std::filesystem::canonical(folder, error);
  if (error || !std::filesystem::is_directory(folder_, error)) {
    throw FileError(fmt::format("{}: not a folder; runs of `enfilade ask` are looked for there",
                                folder.string()));
  }
}

Run Replays::find(std::string_view name) {
  for (NamedPath& one : run_folders(folder_)) {
    if (one.name == name) return open_run(std::move(one), *site_, indices_);
  }
  throw Refusal(Reason::kNotFound, fmt::format("there is no run {:.80?}", name));
}

ordered_json Replays::runs(std::string_view episode) {
  ordered_json list = ordered_json::array();
  for (NamedPath& one : run_folders(folder_)) {
    if (list.size() == kMostRuns) break;
    const Run run = open_run(std::move(one), *site_, indices_);
    const auto& all = run.transcripts;
    const bool wanted =
        episode.empty() || std::ranges::find(all, episode, &NamedPath::name) != all.end();
    if (wanted) list.push_back(run.to_json());
  }
  return {{"runs", std::move(list)}};
}

ordered_json Replays::run(std::string_view name, const EpisodeQuery& query) {
  const Run run = find(name);
  ordered_json out = run.to_json();
  out.update(episode_list(run, known_, query));
  return out;
}

ordered_json Replays::measures(std::string_view name) {
  const Run run = find(name);
  ordered_json out = run.to_json();
  out.update(measures_json(run, known_));
  return out;
}

ordered_json Replays::compare(std::string_view name, std::string_view other, std::size_t offset,
                              std::size_t limit) {
  const Run first = find(name), second = find(other);
  ordered_json out{{"runs", {first.to_json(), second.to_json()}}};
  out.update(compare_json(first, second, known_, offset, limit));
  return out;
}

ordered_json Replays::episode(std::string_view name, std::string_view episode) {
  const Run run = find(name);
  const NamedPath& file = run.transcript_of(episode);
  Transcript transcript = open_transcript(run, episode);
  ordered_json out = run.to_json();
  out.erase("episodes");
  out["episode"] = file.name;
  out["instruction"] = transcript.instruction;
  out["scan"] = nullptr;
  const std::string problem = add_places(site_, run, file.name, transcript, out);
  ordered_json& steps = out["steps"] = ordered_json::array();
  for (TranscriptStep& step : transcript.steps) steps.push_back(std::move(step.shown));
  out["end"] = std::move(transcript.end);
  const EpisodePlace* place = run.has_outcomes() ? run.find(file.name) : nullptr;
  if (place != nullptr && place->text() == transcript.instruction && !transcript.result.empty()) {
    if (const auto walk = read_walk(site_, *place, transcript.result)) {
      ordered_json& outcome = out["outcome"] = outcome_json(walk->episodes, walk->trajectory);
      // As the lists have it, by the benchmark's scorer.
      const ShortScore score = score_of(run, *known_.of(run, file));
      if (score.success) outcome["success"] = *score.success;
      if (score.spl) outcome["spl"] = *score.spl;
    }
  }
  if (!problem.empty()) out["place_problem"] = problem;
  return out;
}

std::shared_ptr<const std::string> Replays::picture(std::string_view name, std::string_view episode,
                                                    std::size_t step, std::size_t number) {
  const Run run = find(name);
  const Transcript transcript = open_transcript(run, episode);
  const EpisodePlace* place = run.is_continuous() ? nullptr : run.find(episode);
  std::optional<arena::PictureOrder> order;
  if (place != nullptr && step >= 1 && step <= transcript.steps.size()) {
    const auto at_step = [&](std::size_t k, const arena::GraphSession& session,
                             const graph::NavGraph& /*graph*/) {
      if (k + 1 < step) return true;
      const auto sent = pictures_sent(*site_, transcript.steps[k], session, run.picture_size);
      if (number < sent.size()) order = sent[number];
      return false;
    };
    try {
      walk_again(site_, *place, transcript, at_step);
    } catch (const Error&) {  // what it says may name files of this machine
      order.reset();
    }
  }
  if (!order) {
    throw Refusal(Reason::kNotFound,
                  fmt::format("step {} has no picture {}, or this server would draw another one",
                              step, number));
  }
  return drawn_.get(order->key(),
                    [&] { return std::make_shared<const std::string>(painters_->draw(*order)); });
}

}  // namespace enfilade::service::sessions
