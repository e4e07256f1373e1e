/// \file  Running a language model over episodes: sessions, answers, transcripts, costs.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/arena/chat.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/pictures.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/progress.h"

namespace enfilade::arena {

/// Settings of the requests to a model.
struct AskConfig {
  ChatConfig chat;
  /// No value: as in the folder's run. In a new folder as the prompt has it; JSON by a schema if
  /// the server refuses tools; text if it refuses that, too.
  std::optional<Answers> answers = {};
  /// The field of ChatConfig::most_tokens; no value: what the server accepts.
  std::optional<LimitField> limit_field = {};
  /// A conversation that is too long for the model goes on without its older steps, if
  /// ChatConfig::window has no value. False: the episode ends.
  bool shorten = true;
  SessionLimits limits;
  std::uint32_t picture_size = 512;  ///< pixels
  std::string words = "none";        ///< source of the world's words; in run.json
  std::size_t parallel = 1;          ///< episodes at once, 1 to 256; changes nothing in results
  int attempts = 6;                  ///< requests for one response before an episode is given up
  double first_wait = 1;             ///< seconds after the first failure; doubled each time
  double longest_wait = kLongestAskedWait;  ///< seconds between two attempts, 0 to 86,400
  std::function<void(const std::string& sentence)> say = {};  ///< as Patience::say
  /// Tokens, in and out, after which no new request is sent; no value: no limit.
  std::optional<std::int64_t> most_tokens = {};
};

/// Cost of responses. Each response of a run counts once, also if it was cached.
struct Ledger {
  std::size_t answers = 0, pictures = 0;
  std::int64_t prompt_tokens = 0, answer_tokens = 0;
  double seconds = 0;  ///< that answers took, one after another
  int attempts = 0;    ///< requests, those that failed too
};
/// Prices of a model, in money for a million tokens: {"gpt-4o": {"prompt": 2.5, "answer": 10}}.
struct Price {
  double prompt = 0, answer = 0;
};
/// \throws FileError; InvalidInput naming a wrong field
std::map<std::string, Price> load_prices(const std::filesystem::path& file);
double money_of(const Ledger& ledger, const Price& price);
/// The text of usage.json, what a run cost: {"answers", "pictures", "prompt_tokens",
/// "answer_tokens", "requests"?, "seconds"?, "money"?}. Requests and seconds are left out if no
/// answer's cache entry was found. \param price no value: there is no "money"
std::string usage_json(const Ledger& ledger, const std::optional<Price>& price);

/// How a run went.
struct AskReport {
  std::size_t episodes = 0;           ///< requested episodes
  std::size_t done = 0;               ///< of these, also in earlier runs
  Answers answers = Answers::kTools;  ///< the form of the answers
  /// How requests differ from the usual ones, by AskConfig or since the server refuses those.
  std::vector<std::string> adjusted;
  std::size_t mistakes = 0;  ///< invalid calls in all finished episodes, without `unanswered`
  /// Responses without a call in all finished episodes, by the reason.
  std::map<AnswerFlaw, std::size_t> unanswered;
  std::map<Ending, std::size_t> endings;
  std::size_t shortened = 0;          ///< finished episodes whose older steps were left out
  std::vector<std::string> refused;   ///< one sentence per episode of Ending::kRefused
  std::vector<std::string> given_up;  ///< one sentence per episode that is left for the next run
  Ledger ledger;
};

/// Evaluates a model on some episodes, step by step, and writes into a folder:
/// - `transcripts/<id>.jsonl`: a line for the episode, one per step, one for the end
/// - `results.json`: all finished episodes, in the benchmark's form
/// - `run.json`: the run's settings, as they are sent, and what was asked for where that differs
///
/// The first step finds the Dialect of the server, if the folder has no transcript. A request that
/// the server refuses is changed by remedy_for(), and sent again. A conversation that is too long,
/// or that a filter refuses, ends its episode (Ending::kRefused), and others go on. So do responses
/// without an answer (AnswerFlaw), SessionLimits::mistakes of them one after another. An episode
/// without a response after all attempts is left; the next run begins with others (`left.json`).
///
/// Their content does not depend on time, computer or other runs. A folder with some of it is
/// continued: episodes with a transcript are skipped, and cached responses are not requested again.
/// \param sights for pictures; may be empty if the prompt has none
/// \param which indices of episodes, each once
/// \param endpoint null: nothing is sent, and a response that is not in the cache is an error
/// \throws ArgumentError for values out of range
/// \throws InvalidInput for a folder of another run, naming the differences
/// \throws RequestRefused for a refusal of something that has no remedy, in the server's words
/// \throws FileError, also if another process works in the folder
AskReport ask(const World& world, const ViewSources& sights, const std::vector<std::size_t>& which,
              const Prompt& prompt, const AskConfig& config, Endpoint* endpoint, AnswerCache& cache,
              const std::filesystem::path& folder, const Progress& progress = {});

}  // namespace enfilade::arena
