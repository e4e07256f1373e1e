/// \file  Takes the user's secrets out of what a server said.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::arena::detail {

/// Replaces secrets by "(key)". A secret is found as it is, and with characters that are escaped as
/// in JSON or in addresses. It is found in base64 too, also within a longer encoded text. Those of
/// fewer than kLeastPart bytes are words of other texts, and count only where they are a word.
/// Immutable: any thread.
class Secrets {
 public:
  static constexpr std::size_t kLeastPart = 8;

  Secrets() = default;
  /// \param secrets empty ones do not count
  explicit Secrets(const std::vector<std::string>& secrets);

  /// One pass: at each position the longest secret counts, and what was replaced is not read again.
  std::string hide(std::string_view text) const;
  /// The same in the decoded names, texts and numbers of a body of JSON, and in a content that
  /// comes as a list of texts. Other bodies, and those without a secret, as hide().
  /// \pre a body of JSON is within kAnswerLimits
  std::string hide_in_body(std::string body) const;

 private:
  struct Pattern {
    std::string text;
    bool word;  // counts only as a whole word
  };
  void add(const std::string& secret);
  /// Past the longest secret that begins there; `at` for none.
  std::size_t end_at(std::string_view text, std::size_t at) const;
  bool hide_in(nlohmann::ordered_json& value, std::string_view name) const;

  std::vector<Pattern> patterns_;
};

}  // namespace enfilade::arena::detail
