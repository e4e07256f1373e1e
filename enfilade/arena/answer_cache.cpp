#include "enfilade/arena/answer_cache.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::arena {
namespace {

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

}  // namespace

struct AnswerCache::Impl {
  fs::path folder;
  std::mutex mutex;
  std::condition_variable changed;
  std::set<std::string, std::less<>> asking;  // keys

  fs::path file_of(const std::string& key) const {
    return folder / key.substr(0, 2) / (key + ".json");
  }
};

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

AnswerCache::AnswerCache(fs::path folder) : impl_(std::make_unique<Impl>()) {
  impl_->folder = std::move(folder);
  make_folder(impl_->folder);
}
AnswerCache::~AnswerCache() = default;

std::string AnswerCache::key_of(std::string_view request) {
  const XXH128_hash_t hash = XXH3_128bits(request.data(), request.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::optional<KeptAnswer> AnswerCache::find(std::string_view request) const {
  const fs::path file = impl_->file_of(key_of(request));
  if (!file_exists(file)) return std::nullopt;
  return read(file, request);
}

std::optional<KeptAnswer> AnswerCache::find_key(const std::string& key) const {
  const fs::path file = impl_->file_of(key);
  if (!file_exists(file)) return std::nullopt;
  return read(file, std::nullopt);
}

KeptAnswer AnswerCache::get(std::string_view request, const std::function<KeptAnswer()>& ask) {
  const std::string key = key_of(request);
  const Claim claim(impl_->mutex, impl_->changed, impl_->asking, key);
  if (auto kept = find(request)) return *kept;
  KeptAnswer answer = ask();
  const fs::path file = impl_->file_of(key);
  make_folder(file.parent_path());
  const Json content{{"request", Json::parse(request)},
                     {"answer", Json::parse(answer.answer)},
                     {"seconds", answer.seconds},
                     {"attempts", answer.attempts}};
  write_file_atomically(file, content.dump(1) + "\n");
  return answer;
}

}  // namespace enfilade::arena
