#include "enfilade/arena/play.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/arena/detail/transcript.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"

namespace enfilade::arena {
namespace {

std::unique_ptr<World> checked(std::unique_ptr<World> world, const PlayConfig& config) {
  validate(config.limits);
  if (!world) throw ArgumentError("world: null");
  if (config.episodes.empty()) throw ArgumentError("episodes: none");
  detail::check_episodes(*world, config.episodes);
  return world;
}

/// {"name": "go_to", "arguments": {"place": "B"}}; servers write the arguments as a text of JSON.
Reading read_tool_call(std::string_view text) {
  Reading unread;
  unread.fault = R"(the answer is no JSON object with "name" and "arguments")";
  const auto answer = nlohmann::json::parse(after_reasoning(text), nullptr, false);
  if (!answer.is_object()) return unread;
  const auto name = answer.find("name");
  if (name == answer.end() || !name->is_string()) return unread;
  const auto given = answer.find("arguments");
  std::string arguments;
  if (given != answer.end() && !given->is_null()) {
    arguments = given->is_string() ? given->get<std::string>() : given->dump();
  }
  return read_call(name->get<std::string>(), arguments);
}

}  // namespace

Play::Play(std::unique_ptr<World> world, const ViewSources& sights, Prompt prompt,
           PlayConfig config)
    : config_(std::move(config)),
      prompt_(std::move(prompt)),
      answers_(config_.answers.value_or(prompt_.answers())),
      pictures_(config_.pictures.value_or(prompt_.pictures())),
      world_(checked(std::move(world), config_)) {
  if (pictures_ != PictureKind::kNone) {
    if (!sights.data && !sights.scene_of) {
      throw ArgumentError("pictures: there is no data set for them");
    }
    painter_ = std::make_unique<PictureMaker>(sights);
  }
  if (config_.folder.empty()) return;
  OutputFolder(config_.folder).folder("transcripts");
  lock_ = std::make_unique<FolderLock>(config_.folder / "ask.lock");
}

std::filesystem::path Play::file_of(std::size_t episode) const {
  return detail::transcript_file(config_.folder, *world_, episode);
}

bool Play::is_done(std::size_t episode) const {
  return walked_here_.contains(episode) ||
         (!config_.folder.empty() && file_exists(file_of(episode)));
}

void Play::keep() {
  const std::size_t episode = session_->episode();
  if (!config_.folder.empty()) {
    detail::write_transcript(config_.folder, *world_, episode,
                             transcript_ + detail::end_line(*session_, *world_));
    detail::write_results(config_.folder, *world_, config_.episodes);
  }
  walked_here_[episode] = world_->result(session_->walked());
}

void Play::start(std::size_t episode) {
  session_.reset();
  session_ = world_->start(episode, config_.limits);
  transcript_ = detail::first_line(*session_);
  past_.clear();
}

bool Play::begin() {
  session_.reset();
  const auto& all = config_.episodes;
  const auto next = std::ranges::find_if_not(all, [this](std::size_t e) { return is_done(e); });
  if (next == all.end()) return false;
  start(*next);
  return true;
}

void Play::begin_at(std::size_t episode) {
  const auto& all = config_.episodes;
  if (std::ranges::find(all, episode) == all.end()) {
    throw ArgumentError(fmt::format("episode: {} is not one of those that are walked", episode));
  }
  start(episode);
}

std::string Play::start_text() const {
  EN_CHECK(session_ != nullptr);
  return prompt_.start(session_->observation(), answers_, config_.limits);
}

std::string Play::step_text() const {
  EN_CHECK(session_ != nullptr);
  return prompt_.step(session_->observation(), answers_, config_.limits, past_);
}

std::vector<std::string> Play::draw() {
  EN_CHECK(session_ != nullptr);
  std::vector<std::string> drawn;
  for (const PictureOrder& order : order_pictures(*session_, pictures_, config_.picture_size)) {
    drawn.push_back(painter_->draw(order));
  }
  return drawn;
}

Reading Play::read(std::string_view answer) const {
  switch (answers_) {
    case Answers::kTools:
      return read_tool_call(answer);
    case Answers::kJson:
      return read_answer_json(answer);
    case Answers::kText:
      break;
  }
  return read_answer_text(answer);
}

PlayOutcome Play::call(const Reading& reading) {
  EN_CHECK(session_ != nullptr);
  Session& session = *session_;
  const SessionObservation before = session.observation();
  PlayOutcome outcome;
  if (reading.call) {
    outcome.carried_out = session.call(*reading.call);
  } else {
    session.misread(reading.fault);
  }
  transcript_ += detail::call_line(before, reading.call, session);
  outcome.told = session.observation().told;
  outcome.ending = session.ending();
  past_.push_back(past_step(reading, outcome.told));
  if (outcome.ending) {
    keep();
    session_.reset();
  }
  return outcome;
}

std::size_t Play::done() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(config_.episodes, [this](std::size_t e) { return is_done(e); }));
}

std::string Play::result(std::size_t episode) const {
  const auto found = walked_here_.find(episode);
  if (found == walked_here_.end()) {
    throw ArgumentError(fmt::format("episode: {} has not been walked here", episode));
  }
  return world_->results(std::span(&found->second, 1));
}

std::string Play::results() const {
  if (config_.folder.empty()) {
    std::vector<std::string> entries;
    for (const std::size_t one : config_.episodes) {
      const auto found = walked_here_.find(one);
      if (found != walked_here_.end()) entries.push_back(found->second);
    }
    return world_->results(entries);
  }
  const auto file = config_.folder / "results.json";
  return file_exists(file) ? read_file(file) : world_->results({});
}

}  // namespace enfilade::arena
