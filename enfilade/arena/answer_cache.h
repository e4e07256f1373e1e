/// \file  Cache of models' responses by request, so that a run can be continued, and replayed at no
/// cost.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace enfilade::arena {

/// A response, and its cost.
struct KeptAnswer {
  std::string answer;  ///< the body as it came: a chat completion of OpenAI's form, JSON
  double seconds = 0;  ///< from the request that was answered to its answer
  int attempts = 1;    ///< requests that were made for it
};

/// A folder of responses, one file each. A file has the request too, with its pictures by their
/// keys. Any number of threads and processes may use one; its files are complete, also after a
/// process was killed.
class AnswerCache {
 public:
  /// Makes the folder. \throws FileError
  explicit AnswerCache(std::filesystem::path folder);
  ~AnswerCache();
  AnswerCache(const AnswerCache&) = delete;
  AnswerCache& operator=(const AnswerCache&) = delete;

  /// 32 hex digits of a request (XXH3, 128 bits).
  static std::string key_of(std::string_view request);

  /// \throws FileError; InvalidInput for a file that is damaged or of another request
  std::optional<KeptAnswer> find(std::string_view request) const;
  /// The same by key_of() a request.
  std::optional<KeptAnswer> find_key(const std::string& key) const;
  /// The answer that is kept, or the one that `ask` gives, which is kept before this returns. Two
  /// threads that ask the same at once ask once. \throws what find() and `ask` throw; FileError
  KeptAnswer get(std::string_view request, const std::function<KeptAnswer()>& ask);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena
