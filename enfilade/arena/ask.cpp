#include "enfilade/arena/ask.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>
#include <utility>

#include "enfilade/arena/detail/patience.h"
#include "enfilade/arena/detail/transcript.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/check.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/folder_lock.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kVersion = 1;
constexpr double kLongestWait = 60;  // seconds
constexpr std::size_t kMostParallel = 256;

using detail::GivenUp;

void check(const AskConfig& config, const Prompt& prompt, const Sights& sights) {
  validate(config.limits);
  if (config.parallel < 1 || config.parallel > kMostParallel) {
    throw ArgumentError(fmt::format("parallel: {}, 1 to {}", config.parallel, kMostParallel));
  }
  if (config.attempts < 1) throw ArgumentError(fmt::format("attempts: {}, >= 1", config.attempts));
  if (!(config.first_wait >= 0 && config.first_wait <= kLongestWait)) {
    throw ArgumentError(fmt::format("first_wait: {} s, 0 to {}", config.first_wait, kLongestWait));
  }
  if (prompt.pictures() != Pictures::kNone && !sights.data && !sights.scene_of) {
    throw ArgumentError(fmt::format(
        "prompt {} shows pictures, and there is nothing to draw them from", prompt.name()));
  }
}

/// What a run is: what its transcripts depend on.
Json run_json(const World& world, const Prompt& prompt, const AskConfig& config, Answers answers) {
  Json run{{"format", "enfilade-ask"},
           {"version", kVersion},
           {"task", world.task()},
           {"split", world.split()},
           {"model", config.chat.model},
           {"prompt", prompt.name()},
           {"prompt_hash", AnswerCache::key_of(prompt.text())},
           {"answers", enum_name(answers)},
           {"temperature", config.chat.temperature},
           {"seed", nullptr},
           {"most_tokens", nullptr},
           {"steps", config.limits.steps},
           {"mistakes", config.limits.mistakes},
           {"picture_size", config.picture_size},
           {"words", config.words}};
  if (config.chat.seed) run["seed"] = *config.chat.seed;
  if (config.chat.most_tokens) run["most_tokens"] = *config.chat.most_tokens;
  return run;
}

/// The form of answers of the run that the folder has; none: there is no run yet.
std::optional<Answers> answers_of_run(const fs::path& folder) {
  if (!file_exists(folder / "run.json")) return std::nullopt;
  const Json there = Json::parse(read_file(folder / "run.json"), nullptr, false);
  if (!there.is_object() || !there.contains("answers") || !there["answers"].is_string()) {
    return std::nullopt;  // claim_folder() says what is wrong
  }
  return find_enum<Answers>(there["answers"].get<std::string>());
}

/// Writes run.json, or checks that the folder's is the same.
/// \pre this process has it alone
void claim_folder(const fs::path& folder, const Json& run) {
  make_folder(folder / "transcripts");
  remove_unfinished(folder);
  remove_unfinished(folder / "transcripts");
  const fs::path file = folder / "run.json";
  if (!file_exists(file)) {
    write_file_atomically(file, run.dump(1) + "\n");
    return;
  }
  Json there = Json::parse(read_file(file), nullptr, false);
  if (!there.is_object()) {
    throw InvalidInput(
        {{Severity::kError, file.string(), "$", "not-a-run", "no JSON object; is it a run?"}});
  }
  there.emplace("words", "none");  // of runs that were made before there were any
  for (const auto& [name, value] : run.items()) {
    if (there.contains(name) && there[name] == value) continue;
    throw InvalidInput(
        {{Severity::kError, file.string(), "$." + name, "other-run",
          fmt::format("{}, and {} is asked for; name another folder, or the same settings",
                      there.contains(name) ? there[name].dump() : "nothing", value.dump())}});
  }
}

/// Waits between attempts, until the run is stopped.
class Pause {
 public:
  /// \returns false if it is stopped
  bool wait(double seconds) {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                              [this] { return stopped_; });
  }
  void stop() {
    {
      const std::scoped_lock lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopped_ = false;
};

class Run {
 public:
  Run(const World& world, const Sights& sights, const Prompt& prompt, const AskConfig& config,
      Answers answers, Endpoint* endpoint, AnswerCache& cache, const fs::path& folder)
      : world_(world),
        sights_(sights),
        prompt_(prompt),
        config_(config),
        answers_(answers),
        endpoint_(endpoint),
        cache_(cache),
        folder_(folder) {}

  /// Requests the first step of the first unfinished episode, so that a refusal shows. The response
  /// is cached, and not requested again.
  /// \returns false if the server refuses the request; true also if it is busy, or if nothing is
  /// left to do
  bool try_first_step(const std::vector<std::size_t>& which) {
    const auto open = std::ranges::find_if_not(
        which, [this](std::size_t episode) { return file_exists(file_of(episode)); });
    if (endpoint_ == nullptr || open == which.end()) return true;
    const auto own = world_.another();
    const auto walked = own->start(*open, config_.limits);
    Chat chat(prompt_, config_.chat, answers_, config_.limits);
    const Request step = next_request(*walked, chat);
    std::unique_ptr<Painter> painter;
    try {
      cache_.get(step.request, [&] {
        const auto begin = Clock::now();
        std::string answer =
            endpoint_->post(body_of(step.request, chat, painter), origin_of(*walked));
        chat.read(answer);
        const std::chrono::duration<double> seconds = Clock::now() - begin;
        return KeptAnswer{std::move(answer), seconds.count(), 1};
      });
    } catch (const EndpointError& error) {
      constexpr std::array kRefusals{400, 422, 501};
      return std::ranges::find(kRefusals, error.status()) == kRefusals.end();
    } catch (const InvalidInput&) {  // half an answer: the run asks again
    }
    return true;
  }

  AskReport walk(const std::vector<std::size_t>& which, const Progress& progress) {
    report_.episodes = which.size();
    report_.answers = answers_;
    std::vector<std::size_t> open;
    for (const std::size_t episode : which) {
      if (!file_exists(file_of(episode))) open.push_back(episode);
    }
    done_ = which.size() - open.size();
    if (progress) progress(done_, which.size());
    {
      std::vector<std::jthread> workers;
      const std::size_t count = std::min(config_.parallel, open.size());
      for (std::size_t k = 0; k < count; ++k) {
        workers.emplace_back([&] { work(open, which.size(), progress); });
      }
    }
    if (fault_) std::rethrow_exception(fault_);
    if (progress && done_ < which.size()) progress(which.size(), which.size());
    std::ranges::sort(report_.given_up);
    sum_up(which);
    return report_;
  }

 private:
  fs::path file_of(std::size_t episode) const {
    return detail::transcript_file(folder_, world_, episode);
  }

  void work(const std::vector<std::size_t>& open, std::size_t all, const Progress& progress) {
    try {
      const std::unique_ptr<World> world = world_.another();  // one a thread
      std::unique_ptr<Painter> painter;
      for (std::size_t k = next_++; k < open.size() && !stop_; k = next_++) {
        try {
          write_file_atomically(file_of(open[k]), walk_episode(*world, open[k], painter));
          const std::scoped_lock lock(mutex_);
          ++done_;
          if (progress) progress(done_, all);
        } catch (const GivenUp& error) {
          const std::scoped_lock lock(mutex_);
          report_.given_up.push_back(
              fmt::format("{}: {}", world_.episode_id(open[k]), error.what()));
        }
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!fault_) fault_ = std::current_exception();
      stop();
    }
  }

  void stop() {
    stop_ = true;
    pause_.stop();
  }

  RequestOrigin origin_of(const Session& session) const {
    return {fmt::format("{}/{}/{}", world_.task(), world_.split(), session.episode_id()), {}};
  }

  struct Request {
    std::string request;
    std::vector<std::string> keys;  // of its pictures
  };
  Request next_request(const Session& session, Chat& chat) const {
    const auto pictures = order_pictures(session, prompt_.pictures(), config_.picture_size);
    Request next;
    for (const PictureOrder& one : pictures) next.keys.push_back(one.key());
    next.request = chat.ask(session.observation(), pictures, next.keys);
    return next;
  }

  /// The request with its pictures in it.
  std::string body_of(const std::string& request, const Chat& chat,
                      std::unique_ptr<Painter>& painter) const {
    return with_pictures(request, [&](std::string_view key) {
      if (!painter) painter = std::make_unique<Painter>(sights_);
      const PictureOrder* order = chat.find_picture(key);
      EN_CHECK(order != nullptr);
      return painter->draw(*order);
    });
  }

  /// \returns the transcript
  std::string walk_episode(World& world, std::size_t episode, std::unique_ptr<Painter>& painter) {
    const auto session = world.start(episode, config_.limits);
    Chat chat(prompt_, config_.chat, answers_, config_.limits);
    RequestOrigin origin = origin_of(*session);
    detail::Transcript transcript(*session);
    while (!session->ending()) {
      const Observation before = session->observation();
      const auto [request, keys] = next_request(*session, chat);
      const KeptAnswer kept =
          cache_.get(request, [&] { return ask_endpoint(request, origin, chat, painter); });
      const ChatAnswer answer = chat.read(kept.answer);
      if (answer.reading.call) {
        if (session->call(*answer.reading.call)) origin.calls.push_back(*answer.reading.call);
      } else {
        session->misread(answer.reading.fault);
      }
      chat.close(kept.answer, answer, session->observation());
      const auto& call = answer.reading.call;
      Json more{{"answer", AnswerCache::key_of(request)},
                {"text", answer.text},
                {"prompt_tokens", answer.prompt_tokens},
                {"answer_tokens", answer.answer_tokens}};
      if (!keys.empty()) more["pictures"] = keys;
      transcript.add(before, call ? &*call : nullptr, *session, more);
    }
    return std::move(transcript).finish(*session, world_);
  }

  KeptAnswer ask_endpoint(const std::string& request, const RequestOrigin& origin, const Chat& chat,
                          std::unique_ptr<Painter>& painter) {
    if (endpoint_ == nullptr) {
      throw GivenUp(fmt::format("the answer {} is not in the cache", AnswerCache::key_of(request)));
    }
    if (config_.most_tokens && tokens_ >= *config_.most_tokens) {
      throw GivenUp(fmt::format("{} tokens were used, the most that may be", tokens_.load()));
    }
    const std::string body = body_of(request, chat, painter);
    const detail::Patience patience{config_.attempts, config_.first_wait,
                                    [this](double seconds) { return pause_.wait(seconds); }};
    try {
      KeptAnswer kept =
          post_patiently(*endpoint_, body, origin, patience, [&](std::string_view answer) {
            const ChatAnswer read = chat.read(answer);  // what is no completion is asked again
            tokens_ += read.prompt_tokens + read.answer_tokens;
          });
      silent_ = 0;
      return kept;
    } catch (const GivenUp&) {
      // Nobody there: the episodes that are left need not find that out one after another.
      if (++silent_ >= config_.parallel) stop();
      throw;
    }
  }

  void sum_up(const std::vector<std::size_t>& which) {
    for (const Json& end : detail::write_results(folder_, world_, which)) {
      ++report_.done;
      report_.mistakes += end["mistakes"].get<std::size_t>();
      ++report_.endings[find_enum<Ending>(end["ending"].get<std::string>()).value()];
    }
    std::set<std::string> counted;
    for (const std::size_t episode : which) {
      if (file_exists(file_of(episode))) count_answers(file_of(episode), counted);
    }
  }

  /// Adds the answers of a transcript that no other has.
  void count_answers(const fs::path& file, std::set<std::string>& counted) {
    const std::string text = read_file(file);
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const Json line =
          Json::parse(text.begin() + static_cast<std::ptrdiff_t>(at),
                      text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
      at = end + 1;
      if (!line.is_object() || !line.contains("answer")) continue;
      if (!counted.insert(line["answer"].get<std::string>()).second) continue;
      Ledger& ledger = report_.ledger;
      ++ledger.answers;
      ledger.pictures += line.contains("pictures") ? line["pictures"].size() : 0;
      ledger.prompt_tokens += line["prompt_tokens"].get<std::int64_t>();
      ledger.answer_tokens += line["answer_tokens"].get<std::int64_t>();
      // A folder may have come without its cache.
      const auto kept = cache_.find_key(line["answer"].get<std::string>());
      if (!kept) continue;
      ledger.seconds += kept->seconds;
      ledger.attempts += kept->attempts;
    }
  }

  const World& world_;
  const Sights& sights_;
  const Prompt& prompt_;
  const AskConfig& config_;
  Answers answers_;
  Endpoint* endpoint_;
  AnswerCache& cache_;
  fs::path folder_;

  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> stop_ = false;
  std::atomic<std::int64_t> tokens_ = 0;
  std::atomic<std::size_t> silent_ = 0;  // episodes that were given up since the last answer
  Pause pause_;
  std::mutex mutex_;  // of what follows
  std::size_t done_ = 0;
  AskReport report_;
  std::exception_ptr fault_;
};

}  // namespace

bool EndpointError::passes() const noexcept {
  return status_ == 0 || status_ == 408 || status_ == 409 || status_ == 425 || status_ == 429 ||
         status_ >= 500;
}

AskReport ask(const World& world, const Sights& sights, const std::vector<std::size_t>& which,
              const Prompt& prompt, const AskConfig& config, Endpoint* endpoint, AnswerCache& cache,
              const fs::path& folder, const Progress& progress) {
  check(config, prompt, sights);
  detail::check_episodes(world, which);
  make_folder(folder);
  const FolderLock lock(folder / "ask.lock");
  Answers answers = config.answers.value_or(prompt.answers());
  const auto run_with = [&](Answers form) {
    return std::make_unique<Run>(world, sights, prompt, config, form, endpoint, cache, folder);
  };
  if (!config.answers) {
    if (const auto kept = answers_of_run(folder)) {
      answers = *kept;
    } else {
      while (answers != Answers::kText && !run_with(answers)->try_first_step(which)) {
        answers = static_cast<Answers>(std::size_t(answers) + 1);
      }
    }
  }
  claim_folder(folder, run_json(world, prompt, config, answers));
  return run_with(answers)->walk(which, progress);
}

std::map<std::string, Price> load_prices(const fs::path& file) {
  const auto refuse = [&file](const std::string& where, const char* text) {
    throw InvalidInput({{Severity::kError, file.string(), where, "bad-price", text}});
  };
  const Json all = Json::parse(read_file(file), nullptr, false);
  if (!all.is_object()) refuse("$", R"(not {"model": {"prompt": 2.5, "answer": 10}})");
  std::map<std::string, Price> prices;
  for (const auto& [model, one] : all.items()) {
    for (const char* name : {"prompt", "answer"}) {
      const bool good = one.is_object() && one.contains(name) && one[name].is_number() &&
                        one[name].get<double>() >= 0;
      if (!good) refuse(fmt::format("$.{}.{}", model, name), "not a number of 0 or more");
    }
    prices[model] = {one["prompt"].get<double>(), one["answer"].get<double>()};
  }
  return prices;
}

double money_of(const Ledger& ledger, const Price& price) {
  constexpr double kTokens = 1e6;  // that a price is for
  return (static_cast<double>(ledger.prompt_tokens) * price.prompt +
          static_cast<double>(ledger.answer_tokens) * price.answer) /
         kTokens;
}

}  // namespace enfilade::arena
