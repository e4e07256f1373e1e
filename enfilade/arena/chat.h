/// \file  Conversations with language models, in the form of OpenAI's chat completions, which most
/// servers support (vLLM, Ollama, llama.cpp, SGLang, OpenAI and others).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/dialect.h"
#include "enfilade/arena/pictures.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena {

/// Fields of each request.
struct ChatConfig {
  std::string model;                             ///< as the server names it; not empty
  std::optional<double> temperature = 0;         ///< 0 to 2; none: not sent
  std::optional<std::int64_t> seed = 1;          ///< none: not sent
  std::optional<std::int64_t> most_tokens = {};  ///< of an answer (`max_tokens`); none: not sent
  /// Further fields, a JSON object: {"reasoning_effort": "low"}. They replace those of the same
  /// name; null leaves one out. Empty: none.
  std::string extra = {};
  /// Steps of the conversation that are sent again; none: all. For PromptMemory::kAll.
  std::optional<std::uint32_t> window = {};
};

/// \throws ArgumentError naming the field: no model, a temperature out of range, or `extra` that is
/// no JSON object or has the messages or the model
void validate(const ChatConfig& config);

/// Why a response has no call, if that is not the model's choice of words.
enum class AnswerFlaw : std::uint8_t {
  kNone,
  kEmpty,    ///< no text, and no call
  kLength,   ///< cut off at the limit of tokens
  kRefusal,  ///< the model refuses
  kFilter,   ///< a content filter took it away
};
constexpr std::array<std::string_view, 5> names_of(AnswerFlaw /*enum*/) {
  return {"none", "empty", "length", "refusal", "filter"};
}

/// A model's response.
struct ChatAnswer {
  Reading reading;
  AnswerFlaw flaw = AnswerFlaw::kNone;  ///< kNone also where a call was read
  std::string text;                     ///< `content`, the texts of its parts; may be empty
  std::int64_t prompt_tokens = 0;       ///< by the server's count; 0: not reported
  std::int64_t answer_tokens = 0;       ///< likewise
};

/// The message of any chat completion: text and tokens, no reading.
/// \throws InvalidInput if `body` is not a chat completion
ChatAnswer read_completion(std::string_view body);

/// One conversation about one episode. A plain object: one thread at a time.
class Chat {
 public:
  /// \param prompt outlives it \throws as validate()
  Chat(const Prompt& prompt, ChatConfig config, const Dialect& dialect, SessionLimits limits);
  ~Chat();
  Chat(const Chat&) = delete;
  Chat& operator=(const Chat&) = delete;

  /// The request for the present step, JSON, in which a picture's address is
  /// "enfilade-picture:<its key>": the same on each computer, with any renderer. Begins the
  /// step. \param pictures  of the observation, with their keys beside
  std::string ask(const SessionObservation& seen, const std::vector<PictureOrder>& pictures,
                  const std::vector<std::string>& keys);
  /// Leaves out the older half of the conversation's steps, for a model whose context is full.
  /// Then request() differs. \returns false if there is no step
  bool shorten();
  /// Leaves out the model's reasoning of earlier steps, if the refusal names one of its fields.
  /// Then request() differs. \returns false if it does not
  bool leave_out_reasoning(const Refusal& refusal);
  /// The request for the present step, again. \pre ask() was called
  std::string request() const;
  /// Steps that shorten() or ChatConfig::window left out so far.
  std::size_t left_out() const;
  /// Reads the response to the last request.
  /// \throws InvalidInput if `body` is not a chat completion with a message
  ChatAnswer read(std::string_view body) const;
  /// Ends the step: the answer and its feedback become part of the conversation.
  void close(std::string_view body, const ChatAnswer& answer, const SessionObservation& after);

  /// The pictures of the last request, by key.
  const PictureOrder* find_picture(std::string_view key) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A request with one question about one picture, whose address is "enfilade-picture:<key>" as in
/// those of Chat.
std::string picture_request(const ChatConfig& config, const Dialect& dialect, std::string question,
                            std::string_view key);
/// A request with its pictures in it, as data URLs. \param picture  the bytes of a JPEG by
/// its key
std::string with_pictures(std::string_view request,
                          const std::function<std::string(std::string_view key)>& picture);

}  // namespace enfilade::arena
