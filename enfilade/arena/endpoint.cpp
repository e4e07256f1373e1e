#include "enfilade/arena/endpoint.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <new>
#include <stdexcept>
#include <utility>

#include "enfilade/arena/dialect.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kKeyDigits = 32;
constexpr const char* kNoMemory = "an answer that takes more memory than there is";

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& file, const char* code, const char* text) {
  throw InvalidInput({{Severity::kError, file.string(), "$", code, text}});
}

/// \param request none: whatever it is
KeptAnswer read(const fs::path& file, std::optional<std::string_view> request) {
  const Json kept = Json::parse(read_file(file), nullptr, false);
  if (kept.is_discarded() || !kept.is_object()) {
    refuse(file, "damaged", "no JSON object; remove the file, and the model is asked again");
  }
  const bool other = request && (!kept.contains("request") ||
                                 kept["request"] != Json::parse(*request, nullptr, false));
  if (other) refuse(file, "other-request", "the file holds another request than its name says");
  try {
    return {kept.at("answer").dump(), kept.at("seconds").get<double>(),
            kept.at("attempts").get<int>()};
  } catch (const Json::exception&) {
    refuse(file, "damaged", "no answer in it; remove the file, and the model is asked again");
  }
}

/// Who asks: others that want the same wait until this is gone.
class Claim {
 public:
  Claim(std::mutex& mutex, std::condition_variable& changed,
        std::set<std::string, std::less<>>& asking, std::string key)
      : mutex_(mutex), changed_(changed), asking_(asking), key_(std::move(key)) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !asking_.contains(key_); });
    asking_.insert(key_);
  }
  ~Claim() {
    {
      const std::scoped_lock lock(mutex_);
      asking_.erase(key_);
    }
    changed_.notify_all();
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

 private:
  std::mutex& mutex_;
  std::condition_variable& changed_;
  std::set<std::string, std::less<>>& asking_;
  std::string key_;
};

}  // namespace

bool EndpointError::passes() const {
  constexpr int kNotImplemented = 501;
  const int status = refusal_.status;
  if (status == 500)
    return !says_invalid(refusal_.body) && kind_of(refusal_) == RefusalKind::kOther;
  return status == 0 || status == 408 || status == 409 || status == 425 || status == 429 ||
         (status > 500 && status != kNotImplemented);
}

RequestRefused::RequestRefused(const std::string& episode, const EndpointError& error)
    : InvalidInput({{Severity::kError, "endpoint", episode, "refused", error.what()}}),
      refusal_(error.refusal()) {}

KeptAnswer post_patiently(Endpoint& endpoint, std::string_view body, const RequestOrigin& origin,
                          const Patience& patience,
                          const std::function<void(std::string_view answer)>& read) {
  double wait = patience.first_wait;
  for (int attempt = 1;; ++attempt) {
    const auto begin = Clock::now();
    std::string failed;
    double asked_wait = 0;
    try {
      std::string answer = endpoint.post(body, origin);
      read(answer);
      const std::chrono::duration<double> seconds = Clock::now() - begin;
      return {std::move(answer), seconds.count(), attempt};
    } catch (const EndpointError& error) {
      if (!error.passes()) throw RequestRefused(origin.episode, error);
      failed = error.what();
      asked_wait = error.wait().value_or(0);
    } catch (const InvalidInput& error) {
      failed = error.what();
    } catch (const std::bad_alloc&) {
      failed = kNoMemory;
    } catch (const std::length_error&) {
      failed = kNoMemory;
    }
    const double seconds = std::min(std::max(wait, asked_wait), patience.longest_wait);
    const bool again = attempt < patience.attempts;
    if (again && asked_wait > wait && patience.say) {
      patience.say(
          fmt::format("{}: the server asks for a wait of {} s; the next attempt is in {} s",
                      origin.episode, asked_wait, seconds));
    }
    if (!again || !patience.pause(seconds)) {
      throw GivenUp(fmt::format("no answer in {} attempts; the last: {}", attempt, failed));
    }
    wait = std::min(2 * wait, kLongestWait);
  }
}

std::vector<std::pair<std::string, std::string>> load_headers(const fs::path& file) {
  std::vector<std::pair<std::string, std::string>> headers;
  const std::string text = read_plain_text(file);
  for (const auto& [number, line] : list_lines(text)) {
    const std::size_t colon = line.find(':');
    const std::string_view name = trimmed(line.substr(0, colon));
    if (colon == std::string_view::npos || name.empty() ||
        name.find(' ') != std::string_view::npos) {
      throw InvalidInput({{Severity::kError, file.string(), fmt::format("line {}", number),
                           "bad-header", "not \"Name: value\""}});
    }
    headers.emplace_back(name, trimmed(line.substr(colon + 1)));
  }
  return headers;
}

std::string AnswerCache::name_of(const std::string& key) {
  return key.substr(0, 2) + "/" + key + ".json";
}

std::string AnswerCache::key_of(std::string_view request) {
  const XXH128_hash_t hash = XXH3_128bits(request.data(), request.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::optional<KeptAnswer> AnswerCache::find(std::string_view request) const {
  const fs::path file = folder_.path() / name_of(key_of(request));
  if (!file_exists(file)) return std::nullopt;
  return read(file, request);
}

std::optional<KeptAnswer> AnswerCache::find_key(const std::string& key) const {
  // Transcripts, which keys come from, may be anybody's.
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (key.size() != kKeyDigits || !std::ranges::all_of(key, is_digit)) return std::nullopt;
  const fs::path file = folder_.path() / name_of(key);
  if (!file_exists(file)) return std::nullopt;
  return read(file, std::nullopt);
}

KeptAnswer AnswerCache::get(std::string_view request, const std::function<KeptAnswer()>& ask) {
  const std::string key = key_of(request);
  const Claim claim(mutex_, changed_, asking_, key);
  if (auto kept = find(request)) return *kept;
  KeptAnswer answer = ask();
  const Json content{{"request", Json::parse(request)},
                     {"answer", Json::parse(answer.answer)},
                     {"seconds", answer.seconds},
                     {"attempts", answer.attempts}};
  folder_.write(name_of(key), content.dump(1) + "\n");
  return answer;
}

}  // namespace enfilade::arena
