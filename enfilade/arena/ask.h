/// \file  Running a language model over episodes: sessions, answers, transcripts, what it cost.
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

#include "enfilade/arena/answer_cache.h"
#include "enfilade/arena/chat.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/pictures.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/progress.h"

namespace enfilade::arena {

/// How a model is asked.
struct AskConfig {
  ChatConfig chat;
  /// None: as the folder's run has it; in a new folder as the prompt has it, or, where the server
  /// refuses tools, JSON by a schema, or, where it refuses that, text.
  std::optional<Answers> answers = {};
  Limits limits;
  std::uint32_t picture_size = 512;  ///< pixels
  std::string words = "none";        ///< what makes the world's words: what a run is, in run.json
  std::size_t parallel = 1;          ///< episodes at once, 1 to 256; changes nothing in results
  int attempts = 6;                  ///< requests for one answer before an episode is given up
  double first_wait = 1;             ///< seconds after the first that failed; doubled each time
  /// Tokens, in and out, after which no new answer is asked for; none: no limit.
  std::optional<std::int64_t> most_tokens = {};
};

/// What answers cost. Of those that a run has, each counted once, whoever asked for them when.
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

/// How a run went.
struct AskReport {
  std::size_t episodes = 0;           ///< that were to be walked
  std::size_t done = 0;               ///< of these, also in earlier runs
  Answers answers = Answers::kTools;  ///< the form that was asked for
  std::size_t mistakes = 0;           ///< calls that could not be carried out, in all done
  std::map<Ending, std::size_t> endings;
  std::vector<std::string> given_up;  ///< a sentence an episode
  Ledger ledger;
};

/// Asks a model for every step of some episodes, and writes into a folder:
/// `transcripts/<id>.jsonl` (a line for the episode, one a step, one for the end), `results.json`
/// as the benchmark has it, of all episodes that are done, and `run.json`, what the run is. Nothing
/// in them depends on time, machine or other runs. A folder that has some of it is continued:
/// episodes with a transcript are left as they are, and answers in the cache are not asked again.
/// \param sights for pictures; may be empty if the prompt has none
/// \param which indices of episodes, each once
/// \param endpoint null: nothing is asked, and an answer that is not in the cache is an error
/// \throws ArgumentError for values out of range; InvalidInput for a folder of another run, naming
/// what differs, and for a refusal that waiting does not change; FileError, also if another process
/// works in the folder
AskReport ask(const World& world, const Sights& sights, const std::vector<std::size_t>& which,
              const Prompt& prompt, const AskConfig& config, Endpoint* endpoint, AnswerCache& cache,
              const std::filesystem::path& folder, const Progress& progress = {});

}  // namespace enfilade::arena
