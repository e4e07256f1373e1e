/// \file  Conversations with language models, in the form of OpenAI's chat completions, which most
/// servers support (vLLM, Ollama, llama.cpp, SGLang, OpenAI and others).
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/errors.h"

namespace enfilade::arena {

/// Fields of each request.
struct ChatConfig {
  std::string model;                             ///< as the server names it; not empty
  double temperature = 0;                        ///< 0 to 2
  std::optional<std::int64_t> seed = 1;          ///< none: not sent
  std::optional<std::int64_t> most_tokens = {};  ///< of an answer (`max_tokens`); none: not sent
};

/// A model's response.
struct ChatAnswer {
  Reading reading;
  std::string text;                ///< `content`; may be empty
  std::int64_t prompt_tokens = 0;  ///< by the server's count; 0: not reported
  std::int64_t answer_tokens = 0;  ///< likewise
};

/// The message of any chat completion: text and tokens, no reading.
/// \throws InvalidInput if `body` is not a chat completion
ChatAnswer read_completion(std::string_view body);

/// One conversation about one episode. A plain object: one thread at a time.
class Chat {
 public:
  /// \param prompt outlives it \throws ArgumentError for no model, or a temperature out of range
  Chat(const Prompt& prompt, ChatConfig config, Answers answers, Limits limits);
  ~Chat();
  Chat(const Chat&) = delete;
  Chat& operator=(const Chat&) = delete;

  /// The request for the present step, JSON, in which a picture's address is
  /// "enfilade-picture:<its key>": the same on each computer, with any renderer. Begins the
  /// step. \param pictures  of the observation, with their keys beside
  std::string ask(const Observation& seen, const std::vector<PictureOrder>& pictures,
                  const std::vector<std::string>& keys);
  /// Reads the response to the last request.
  /// \throws InvalidInput if `body` is not a chat completion with a message
  ChatAnswer read(std::string_view body) const;
  /// Ends the step: the answer and its feedback become part of the conversation.
  void close(std::string_view body, const ChatAnswer& answer, const Observation& after);

  /// The pictures of the last request, by key.
  const PictureOrder* find_picture(std::string_view key) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A request with one question about one picture, whose address is "enfilade-picture:<key>" as in
/// those of Chat.
std::string picture_request(const ChatConfig& config, std::string question, std::string_view key);
/// A request with its pictures in it, as data URLs. \param picture  the bytes of a JPEG by
/// its key
std::string with_pictures(std::string_view request,
                          const std::function<std::string(std::string_view key)>& picture);

}  // namespace enfilade::arena
