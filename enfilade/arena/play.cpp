#include "enfilade/arena/play.h"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "enfilade/arena/detail/transcript.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/folder_lock.h"

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
  const auto answer = nlohmann::json::parse(text, nullptr, false);
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

struct Play::Impl {
  PlayConfig config;
  Prompt prompt;
  Answers answers;
  Pictures pictures;
  std::unique_ptr<World> world;
  std::unique_ptr<Painter> painter;
  std::unique_ptr<FolderLock> lock;
  std::unique_ptr<Session> session;
  std::optional<detail::Transcript> transcript;
  std::vector<PastStep> past;
  std::map<std::size_t, std::string> walked_here;  // what results files have of it, by episode

  Impl(std::unique_ptr<World> walked, Sights sights, Prompt text, PlayConfig settings)
      : config(std::move(settings)),
        prompt(std::move(text)),
        answers(config.answers.value_or(prompt.answers())),
        pictures(config.pictures.value_or(prompt.pictures())),
        world(checked(std::move(walked), config)) {
    if (pictures != Pictures::kNone) {
      if (!sights.data && !sights.scene_of) {
        throw ArgumentError("pictures: there is no data set for them");
      }
      painter = std::make_unique<Painter>(std::move(sights));
    }
    if (config.folder.empty()) return;
    make_folder(config.folder / "transcripts");
    lock = std::make_unique<FolderLock>(config.folder / "ask.lock");
  }

  std::filesystem::path file_of(std::size_t episode) const {
    return detail::transcript_file(config.folder, *world, episode);
  }
  bool is_done(std::size_t episode) const {
    return walked_here.contains(episode) ||
           (!config.folder.empty() && file_exists(file_of(episode)));
  }

  void keep() {
    const std::size_t episode = session->episode();
    if (!config.folder.empty()) {
      write_file_atomically(file_of(episode), std::move(*transcript).finish(*session, *world));
      detail::write_results(config.folder, *world, config.episodes);
    }
    walked_here[episode] = world->result(session->walked());
  }

  void start(std::size_t episode) {
    session = world->start(episode, config.limits);
    transcript.emplace(*session);
    past.clear();
  }
};

Play::Play(std::unique_ptr<World> world, Sights sights, Prompt prompt, PlayConfig config)
    : impl_(std::make_unique<Impl>(std::move(world), std::move(sights), std::move(prompt),
                                   std::move(config))) {}
Play::~Play() = default;

bool Play::begin() {
  impl_->session.reset();
  const auto& all = impl_->config.episodes;
  const auto next =
      std::ranges::find_if_not(all, [this](std::size_t e) { return impl_->is_done(e); });
  if (next == all.end()) return false;
  impl_->start(*next);
  return true;
}

void Play::begin_at(std::size_t episode) {
  const auto& all = impl_->config.episodes;
  if (std::ranges::find(all, episode) == all.end()) {
    throw ArgumentError(fmt::format("episode: {} is not one of those that are walked", episode));
  }
  impl_->session.reset();
  impl_->start(episode);
}

const Session* Play::session() const noexcept { return impl_->session.get(); }

std::string Play::start_text() const {
  EN_CHECK(impl_->session != nullptr);
  return impl_->prompt.start(impl_->session->observation(), impl_->answers, impl_->config.limits);
}

std::string Play::step_text() const {
  EN_CHECK(impl_->session != nullptr);
  return impl_->prompt.step(impl_->session->observation(), impl_->answers, impl_->config.limits,
                            impl_->past);
}

std::vector<std::string> Play::draw() {
  EN_CHECK(impl_->session != nullptr);
  std::vector<std::string> drawn;
  for (const PictureOrder& order :
       order_pictures(*impl_->session, impl_->pictures, impl_->config.picture_size)) {
    drawn.push_back(impl_->painter->draw(order));
  }
  return drawn;
}

Reading Play::read(std::string_view answer) const {
  switch (impl_->answers) {
    case Answers::kTools:
      return read_tool_call(answer);
    case Answers::kJson:
      return read_answer_json(answer);
    case Answers::kText:
      break;
  }
  return read_answer_text(answer);
}

Outcome Play::call(const Reading& reading) {
  EN_CHECK(impl_->session != nullptr);
  Session& session = *impl_->session;
  const Observation before = session.observation();
  Outcome outcome;
  if (reading.call) {
    outcome.carried_out = session.call(*reading.call);
  } else {
    session.misread(reading.fault);
  }
  impl_->transcript->add(before, reading.call ? &*reading.call : nullptr, session);
  outcome.told = session.observation().told;
  outcome.ending = session.ending();
  impl_->past.push_back(past_step(reading, outcome.told));
  if (outcome.ending) {
    impl_->keep();
    impl_->session.reset();
  }
  return outcome;
}

Answers Play::answers() const noexcept { return impl_->answers; }
std::size_t Play::done() const noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(
      impl_->config.episodes, [this](std::size_t e) { return impl_->is_done(e); }));
}
std::size_t Play::size() const noexcept { return impl_->config.episodes.size(); }
const std::vector<std::size_t>& Play::episodes() const noexcept { return impl_->config.episodes; }

std::string Play::result(std::size_t episode) const {
  const auto found = impl_->walked_here.find(episode);
  if (found == impl_->walked_here.end()) {
    throw ArgumentError(fmt::format("episode: {} has not been walked here", episode));
  }
  return impl_->world->results(std::span(&found->second, 1));
}

std::string Play::results() const {
  if (impl_->config.folder.empty()) {
    std::vector<std::string> entries;
    for (const std::size_t one : impl_->config.episodes) {
      const auto found = impl_->walked_here.find(one);
      if (found != impl_->walked_here.end()) entries.push_back(found->second);
    }
    return impl_->world->results(entries);
  }
  const auto file = impl_->config.folder / "results.json";
  return file_exists(file) ? read_file(file) : impl_->world->results({});
}

}  // namespace enfilade::arena
