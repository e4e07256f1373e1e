/// \file  A mock server that answers like a language model, by a rule: for tests, and for trying
/// out clients. Only in builds with EN_WITH_WEB.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/arena/world.h"

namespace enfilade::arena {

/// Faults of a response.
enum class StandInFault : std::uint8_t {
  kServerError,   ///< status 500, the first time
  kRateLimit,     ///< status 429 with Retry-After: 0, the first time
  kCutOff,        ///< half of the body, the first time
  kNotJson,       ///< a body that is no JSON, the first time
  kNoChoice,      ///< a completion without an answer, the first time
  kSilence,       ///< no answer within StandInConfig::silence, the first time
  kUnknownPlace,  ///< a call with a value that is not offered: the model's mistake
  kNoCall,        ///< words alone: the model's mistake
};

/// How it answers.
struct StandInConfig {
  Rule rule = Rule::kOracle;
  std::uint64_t seed = 1;  ///< for Rule::kRandom.
  /// One request in this many has a fault, in the order of this list; empty: none.
  std::vector<StandInFault> faults = {};
  std::uint32_t one_in = 3;
  double silence = 1;  ///< seconds
  /// Answers before it refuses every request with status 503; 0: no limit.
  std::size_t most_answers = 0;
  std::string key = {};    ///< required as `Authorization: Bearer`; empty: no key
  bool with_tools = true;  ///< false: requests with `tools` are refused with status 400
};

/// POST /v1/chat/completions on a free port of 127.0.0.1. Reads the episode and its calls from the
/// headers that make_http_endpoint() sends. So it keeps nothing between requests, and gives equal
/// responses to equal requests. The bytes of a request alone decide whether it has a fault.
class StandIn {
 public:
  /// Listens when this returns. \throws ArgumentError if no port is free
  StandIn(std::unique_ptr<const World> world, const StandInConfig& config);
  ~StandIn();
  StandIn(const StandIn&) = delete;
  StandIn& operator=(const StandIn&) = delete;

  std::string url() const;       ///< "http://127.0.0.1:4321/v1"
  std::size_t requests() const;  ///< so far
  std::size_t answers() const;   ///< of these, those with a whole answer
  std::size_t repeats() const;   ///< of these, those to a request that had had one before
  std::size_t most_at_once() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena
