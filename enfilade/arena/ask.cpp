#include "enfilade/arena/ask.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <ranges>
#include <set>
#include <stop_token>
#include <thread>
#include <utility>

#include "enfilade/arena/detail/limits.h"
#include "enfilade/arena/detail/run_file.h"
#include "enfilade/arena/detail/tokens.h"
#include "enfilade/arena/detail/transcript.h"
#include "enfilade/arena/dialect.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/check.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/part_file.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostParallel = 256;
// Episodes in a row without a response after which a run ends, if fewer are in flight.
constexpr std::size_t kMostSilent = 3;
constexpr double kMostWait = 86'400;  // a day
constexpr const char* kLeftFile = "left.json";

void check(const AskConfig& config, const Prompt& prompt, const ViewSources& sights) {
  validate(config.limits);
  validate(config.chat);
  if (config.parallel < 1 || config.parallel > kMostParallel) {
    throw ArgumentError(fmt::format("parallel: {}, 1 to {}", config.parallel, kMostParallel));
  }
  if (config.attempts < 1) throw ArgumentError(fmt::format("attempts: {}, >= 1", config.attempts));
  if (!(config.first_wait >= 0 && config.first_wait <= kLongestWait)) {
    throw ArgumentError(fmt::format("first_wait: {} s, 0 to {}", config.first_wait, kLongestWait));
  }
  if (!(config.longest_wait >= 0 && config.longest_wait <= kMostWait)) {
    throw ArgumentError(fmt::format("longest_wait: {} s, 0 to {}", config.longest_wait, kMostWait));
  }
  if (prompt.pictures() != PictureKind::kNone && !sights.data && !sights.scene_of) {
    throw ArgumentError(fmt::format(
        "prompt {} shows pictures, and there is nothing to draw them from", prompt.name()));
  }
}

/// An episode that is left for the next run, for a reason of its own.
class EpisodeLeft : public GivenUp {
 public:
  using GivenUp::GivenUp;
};

class Run {
 public:
  Run(const World& world, const ViewSources& sights, const Prompt& prompt, const AskConfig& config,
      const Dialect& dialect, Endpoint* endpoint, AnswerCache& cache, const fs::path& folder,
      const std::vector<std::size_t>& which)
      : world_(world),
        sights_(sights),
        prompt_(prompt),
        config_(config),
        dialect_(dialect),
        endpoint_(endpoint),
        cache_(cache),
        folder_(folder),
        which_(which),
        left_(read_left(folder)) {
    for (const std::size_t episode : which) {
      if (!file_exists(file_of(episode))) open_.push_back(episode);
    }
    done_ = which.size() - open_.size();
    // Those that were left come last: they may be left again.
    std::ranges::stable_partition(open_, [this](std::size_t episode) {
      return !left_.contains(world_.episodes().id(episode));
    });
  }

  const Dialect& dialect() const { return dialect_; }

  /// Finds what the server accepts, by the first step of the first open episode, or of the next if
  /// there is no response. Responses are cached, and so are refusals that have a remedy.
  /// \returns false if the server gives no response at all
  /// \throws RequestRefused if it refuses them all, even if as too long or by a filter: the
  /// settings may be at fault
  bool find_dialect() {
    if (open_.empty()) return true;
    std::exception_ptr refused;
    std::size_t tries = 0;
    // A run that is replayed began with one of them.
    for (auto episode = open_.begin(); episode != open_.end();) {
      if (endpoint_ != nullptr && tries++ == kMostSilent) break;
      try {
        probe(*episode);
        return true;
      } catch (const RequestRefused& error) {
        if (kind_of(error.refusal()) == RefusalKind::kOther) throw;
        if (!refused) refused = std::current_exception();
        ++episode;
      } catch (const EpisodeLeft& error) {
        leave(*episode, error.what());
        episode = open_.erase(episode);
      } catch (const GivenUp&) {
        if (endpoint_ != nullptr) return true;  // no token is left: each episode says so
        ++episode;
      }
    }
    if (endpoint_ != nullptr && refused) std::rethrow_exception(refused);
    return endpoint_ == nullptr;
  }

  AskReport walk(const Progress& progress) {
    walking_ = true;
    if (progress) progress(done_, which_.size());
    {
      std::vector<std::jthread> workers;
      const std::size_t count = std::min(config_.parallel, open_.size());
      for (std::size_t k = 0; k < count; ++k) {
        workers.emplace_back([&] { work(progress); });
      }
    }
    if (fault_) std::rethrow_exception(fault_);
    if (progress && done_ < which_.size()) progress(which_.size(), which_.size());
    return report();
  }

  /// What there is of the run.
  AskReport report() {
    report_.episodes = which_.size();
    report_.answers = dialect_.answers;
    report_.adjusted = differences(dialect_);
    std::ranges::sort(report_.given_up);
    sum_up();
    return report_;
  }

 private:
  fs::path file_of(std::size_t episode) const {
    return detail::transcript_file(folder_, world_, episode);
  }

  /// Episodes that earlier runs left, and why.
  static std::map<std::string, std::string> read_left(const fs::path& folder) {
    std::map<std::string, std::string> left;
    if (!file_exists(folder / kLeftFile)) return left;
    const Json kept = Json::parse(read_file(folder / kLeftFile), nullptr, false);
    if (!kept.is_object()) return left;
    for (const auto& [id, why] : kept.items()) {
      if (why.is_string()) left[id] = why.get<std::string>();
    }
    return left;
  }

  /// \pre the mutex is held, or there are no workers
  void write_left() {
    const OutputFolder folder(folder_);
    if (left_.empty()) {
      folder.remove(kLeftFile);
    } else {
      folder.write(kLeftFile,
                   Json(left_).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
  }

  void leave(std::size_t episode, const std::string& why) {
    const std::scoped_lock lock(mutex_);
    const std::string id = world_.episodes().id(episode);
    report_.given_up.push_back(fmt::format("{}: {}", id, why));
    left_[id] = why;
    write_left();
  }

  /// Requests the first step of an episode until the server accepts the form.
  void probe(std::size_t episode) {
    const auto own = world_.another();
    const auto walked = own->start(episode, config_.limits);
    std::unique_ptr<PictureMaker> painter;
    const SetByHand by_hand{config_.answers.has_value(), config_.limit_field.has_value()};
    const auto remedy = [&](const Refusal& refusal, const std::string& request) {
      return kind_of(refusal) == RefusalKind::kOther
                 ? remedy_for(refusal, request, dialect_, by_hand)
                 : std::nullopt;
    };
    for (;;) {
      Chat chat(prompt_, config_.chat, dialect_, config_.limits);
      const auto [request, keys] = next_request(*walked, chat);
      const KeptAnswer kept = cache_.get(request, [&] {
        return ask_endpoint(request, origin_of(*walked), chat, painter,
                            [&](const auto&... of) { return remedy(of...).has_value(); });
      });
      const auto refusal = find_refusal(kept.answer);
      if (!refusal) return;
      const auto changed = remedy(*refusal, request);
      if (!changed) {
        const std::string origin = origin_of(*walked).episode;
        throw RequestRefused(
            origin, EndpointError(refusal->status, words_in(refusal->body), {}, refusal->body));
      }
      dialect_ = *changed;
    }
  }

  void work(const Progress& progress) {
    try {
      const std::unique_ptr<World> world = world_.another();  // one a thread
      std::unique_ptr<PictureMaker> painter;
      for (std::size_t k = next_++; k < open_.size() && !stop_.stop_requested(); k = next_++) {
        const std::string id = world_.episodes().id(open_[k]);
        try {
          detail::write_transcript(folder_, world_, open_[k],
                                   walk_episode(*world, open_[k], painter));
          const std::scoped_lock lock(mutex_);
          ++done_;
          if (left_.erase(id) > 0) write_left();
          if (progress) progress(done_, which_.size());
        } catch (const EpisodeLeft& error) {
          leave(open_[k], error.what());
        } catch (const GivenUp& error) {
          const std::scoped_lock lock(mutex_);
          report_.given_up.push_back(fmt::format("{}: {}", id, error.what()));
        }
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!fault_) fault_ = std::current_exception();
      stop_.request_stop();
    }
  }

  /// Waits between attempts. \returns false if the run is stopped meanwhile
  bool pause(double seconds) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any().wait_for(
        lock, stop_.get_token(), std::chrono::duration<double>(seconds), [] { return false; });
    return !stop_.stop_requested();
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
                      std::unique_ptr<PictureMaker>& painter) const {
    return with_pictures(request, [&](std::string_view key) {
      if (!painter) painter = std::make_unique<PictureMaker>(sights_);
      const PictureOrder* order = chat.find_picture(key);
      EN_CHECK(order != nullptr);
      return painter->draw(*order);
    });
  }

  /// The response to a step, or the refusal that ends the episode. The request is shortened as far
  /// as the server asks for.
  KeptAnswer answer_to(std::string& request, const RequestOrigin& origin, Chat& chat,
                       std::unique_ptr<PictureMaker>& painter) {
    const bool may_shorten = config_.shorten && !config_.chat.window;
    for (;;) {
      bool changes = false;
      const auto helps = [&](const Refusal& refusal, const std::string&) {
        changes = chat.leave_out_reasoning(refusal);
        return changes;
      };
      KeptAnswer kept =
          request.size() > detail::kMostConversation
              ? KeptAnswer{kept_refusal({413, "the conversation has more than 16 MiB"})}
              : cache_.get(request,
                           [&] { return ask_endpoint(request, origin, chat, painter, helps); });
      const auto refusal = find_refusal(kept.answer);
      if (!refusal) return kept;
      const RefusalKind kind = kind_of(*refusal);
      changes = changes || (kind == RefusalKind::kTooLong && may_shorten && chat.shorten()) ||
                (kind == RefusalKind::kOther && chat.leave_out_reasoning(*refusal));
      if (!changes && kind == RefusalKind::kOther) throw EpisodeLeft(words_in(refusal->body));
      if (!changes) return kept;
      request = chat.request();
    }
  }

  /// \returns the transcript
  std::string walk_episode(World& world, std::size_t episode,
                           std::unique_ptr<PictureMaker>& painter) {
    const auto session = world.start(episode, config_.limits);
    Chat chat(prompt_, config_.chat, dialect_, config_.limits);
    RequestOrigin origin = origin_of(*session);
    std::string transcript = detail::first_line(*session), reason;
    std::uint32_t unanswered = 0;  // one after another
    while (!session->ending()) {
      const SessionObservation before = session->observation();
      auto [request, keys] = next_request(*session, chat);
      const KeptAnswer kept = answer_to(request, origin, chat, painter);
      if (const auto refusal = find_refusal(kept.answer)) {
        reason = fmt::format("{}: {}", enum_name(kind_of(*refusal)), words_in(refusal->body));
        session->break_off();
        break;
      }
      const ChatAnswer answer = chat.read(kept.answer);
      if (answer.reading.call) {
        if (session->call(*answer.reading.call)) origin.calls.push_back(session->last_call());
      } else {
        session->misread(answer.reading.fault);
      }
      unanswered = answer.flaw == AnswerFlaw::kNone ? 0 : unanswered + 1;
      if (unanswered >= config_.limits.mistakes) {
        reason = fmt::format("no-answer: {}", enum_name(answer.flaw));
        session->break_off();
      }
      Json more{{"answer", AnswerCache::key_of(request)},
                {"text", answer.text},
                {"prompt_tokens", answer.prompt_tokens},
                {"answer_tokens", answer.answer_tokens}};
      if (answer.flaw != AnswerFlaw::kNone) more["flaw"] = enum_name(answer.flaw);
      if (chat.left_out() > 0) more["left_out"] = chat.left_out();
      if (!keys.empty()) more["pictures"] = keys;
      transcript += detail::call_line(before, answer.reading.call, *session, more);
      chat.close(kept.answer, answer, session->observation());
    }
    return transcript + detail::end_line(*session, world_, reason);
  }

  /// \param helps whether a refusal leads to another request; it is cached then, as are those that
  /// end an episode
  KeptAnswer ask_endpoint(
      const std::string& request, const RequestOrigin& origin, const Chat& chat,
      std::unique_ptr<PictureMaker>& painter,
      const std::function<bool(const Refusal& refusal, const std::string& request)>& helps) {
    if (endpoint_ == nullptr) {
      throw GivenUp(fmt::format("the answer {} is not in the cache", AnswerCache::key_of(request)));
    }
    if (config_.most_tokens && tokens_ >= *config_.most_tokens) {
      throw GivenUp(fmt::format("{} tokens were used, the most that may be", tokens_.load()));
    }
    const std::string body = body_of(request, chat, painter);
    const Patience patience{config_.attempts, config_.first_wait,
                            [this](double seconds) { return pause(seconds); }, config_.longest_wait,
                            config_.say};
    try {
      KeptAnswer kept =
          post_patiently(*endpoint_, body, origin, patience, [&](std::string_view answer) {
            const ChatAnswer read = chat.read(answer);  // what is no completion is asked again
            tokens_ += read.prompt_tokens + read.answer_tokens;
          });
      silent_ = 0;
      return kept;
    } catch (const RequestRefused& error) {
      const Refusal& refusal = error.refusal();
      if ((walking_ && kind_of(refusal) != RefusalKind::kOther) || helps(refusal, request)) {
        silent_ = 0;
        return {kept_refusal(refusal)};
      }
      // A server that accepts the form of requests refuses what is in this one.
      constexpr std::array kOfRequest{400, 413, 422, 500};
      if (!walking_ || std::ranges::find(kOfRequest, refusal.status) == kOfRequest.end()) throw;
      leave_after(error.what());
    } catch (const GivenUp& error) {
      if (stop_.stop_requested()) throw;  // its wait was cut short
      leave_after(error.what());
    }
  }

  /// Leaves the present episode. If no server is there, the others need not find that out one after
  /// another: the run ends.
  [[noreturn]] void leave_after(const std::string& why) {
    if (++silent_ >= std::max(config_.parallel, kMostSilent)) stop_.request_stop();
    throw EpisodeLeft(why);
  }

  void sum_up() {
    std::size_t k = 0;
    std::set<std::string> counted;
    const std::vector<Json> ends = detail::write_results(folder_, world_, which_);
    for (const std::size_t episode : which_) {
      if (!file_exists(file_of(episode))) continue;
      const Json& end = ends[k++];
      ++report_.done;
      report_.mistakes += end["mistakes"].get<std::size_t>();
      const Ending ending = find_enum<Ending>(end["ending"].get<std::string>()).value();
      ++report_.endings[ending];
      if (ending == Ending::kRefused) {
        report_.refused.push_back(fmt::format("{}: {}", world_.episodes().id(episode),
                                              end.value("reason", std::string("refused"))));
      }
      count_answers(file_of(episode), counted);
    }
  }

  /// Adds the answers of a transcript that no other has.
  void count_answers(const fs::path& file, std::set<std::string>& counted) {
    const std::string text = read_file(file);
    bool shortened = false;
    for (const auto part : std::views::split(text, '\n')) {
      const Json line = Json::parse(part.begin(), part.end(), nullptr, false);
      if (!line.is_object() || !line.contains("answer") || !line["answer"].is_string()) continue;
      shortened = shortened || line.contains("left_out");
      const auto flaw = line.contains("flaw") && line["flaw"].is_string()
                            ? find_enum<AnswerFlaw>(line["flaw"].get<std::string>())
                            : std::nullopt;
      if (flaw) {
        ++report_.unanswered[*flaw];
        report_.mistakes -= std::min<std::size_t>(report_.mistakes, 1);
      }
      if (!counted.insert(line["answer"].get<std::string>()).second) continue;
      Ledger& ledger = report_.ledger;
      ++ledger.answers;
      ledger.pictures += line.contains("pictures") ? line["pictures"].size() : 0;
      ledger.prompt_tokens += detail::tokens_in(line, "prompt_tokens");
      ledger.answer_tokens += detail::tokens_in(line, "answer_tokens");
      // A folder may have come without its cache.
      const auto kept = cache_.find_key(line["answer"].get<std::string>());
      if (!kept) continue;
      ledger.seconds += kept->seconds;
      ledger.attempts += kept->attempts;
    }
    report_.shortened += shortened ? 1 : 0;
  }

  const World& world_;
  const ViewSources& sights_;
  const Prompt& prompt_;
  const AskConfig& config_;
  Dialect dialect_;
  Endpoint* endpoint_;
  AnswerCache& cache_;
  fs::path folder_;
  const std::vector<std::size_t>& which_;
  std::vector<std::size_t> open_;  // in the order of requests
  bool walking_ = false;           // the form of requests is known

  std::atomic<std::size_t> next_ = 0;
  std::stop_source stop_;
  std::atomic<std::int64_t> tokens_ = 0;
  std::atomic<std::size_t> silent_ = 0;      // episodes that were given up since the last answer
  std::mutex mutex_;                         // of what follows
  std::map<std::string, std::string> left_;  // episodes that were left, and why
  std::size_t done_ = 0;
  AskReport report_;
  std::exception_ptr fault_;
};

}  // namespace

AskReport ask(const World& world, const ViewSources& sights, const std::vector<std::size_t>& which,
              const Prompt& prompt, const AskConfig& config, Endpoint* endpoint, AnswerCache& cache,
              const fs::path& folder, const Progress& progress) {
  check(config, prompt, sights);
  detail::check_episodes(world, which);
  make_folder(folder);
  const FolderLock lock(folder / "ask.lock");
  const Json asked = detail::asked_json(world, prompt, config);
  const std::optional<Json> there = detail::run_of(folder, asked);
  Dialect dialect;
  dialect.answers = config.answers.value_or(prompt.answers());
  dialect.limit = config.limit_field.value_or(LimitField::kMaxTokens);
  Run run(world, sights, prompt, config, there ? detail::dialect_of(*there) : dialect, endpoint,
          cache, folder, which);
  if (!there) {
    if (!run.find_dialect()) return run.report();
    OutputFolder(folder).write("run.json", detail::sent_json(asked, run.dialect()).dump(1) + "\n");
  }
  return run.walk(progress);
}

std::map<std::string, Price> load_prices(const fs::path& file) {
  const auto refuse = [&file](const std::string& where, const char* text) {
    throw InvalidInput({{Severity::kError, file.string(), where, "bad-price", text}});
  };
  const Json all = Json::parse(read_plain_text(file), nullptr, false);
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

std::string usage_json(const Ledger& ledger, const std::optional<Price>& price) {
  Json usage{{"answers", ledger.answers},
             {"pictures", ledger.pictures},
             {"prompt_tokens", ledger.prompt_tokens},
             {"answer_tokens", ledger.answer_tokens}};
  if (ledger.attempts > 0) {
    usage["requests"] = ledger.attempts;
    usage["seconds"] = ledger.seconds;
  }
  if (price) usage["money"] = money_of(ledger, *price);
  return usage.dump(1) + "\n";
}

}  // namespace enfilade::arena
