/// \file  Prompts: a model's messages at the start and at each step, from template files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/wire.h"

namespace enfilade::arena {

/// The form of a model's answer.
enum class Answers : std::uint8_t {
  kTools,  ///< by a tool call of the chat's protocol
  kJson,   ///< by JSON that fits answer_schema()
  kText,   ///< by a line "Action: go_to B"
};
constexpr std::array<std::string_view, 3> names_of(Answers /*enum*/) {
  return {"tools", "json", "text"};
}

/// The part of earlier steps that is sent again at each step.
enum class PromptMemory : std::uint8_t {
  kAll,   ///< the whole conversation
  kLast,  ///< nothing: the template itself must include it (`history`, `map`)
};
constexpr std::array<std::string_view, 2> names_of(PromptMemory /*enum*/) {
  return {"all", "last"};
}

/// A step that is past.
struct PastStep {
  std::string thought;  ///< the model's text beside the call; may be empty
  std::string call;     ///< "go_to B"; empty where none could be read
  std::string told;     ///< its feedback
};

/// The step of `reading`. \param told its feedback
PastStep past_step(const Reading& reading, std::string told);

/// What is read of a template's file.
struct PromptParts {
  PictureKind pictures = PictureKind::kNone;
  Answers answers = Answers::kTools;
  PromptMemory memory = PromptMemory::kAll;
  std::uint32_t kept_pictures = 1;
  std::string start = {}, step = {};
};

/// A template: a head of lines "name: value", then two texts in Mustache (docs/arena.md lists the
/// names). Each follows a line "---": the text of the start, and that of a step.
///
/// \code{.txt}
///     pictures: strip          none, strip or places
///     answers: tools           tools, json or text
///     memory: all              all or last
///     kept_pictures: 2         of all: how many observations back pictures are sent again
///     ---
///     You are in a building. Follow this instruction: {{instruction}}
///     ---
///     {{#places}}{{name}}: {{turn_words}}, {{distance}} m{{/places}}
/// \endcode
///
/// Immutable: any thread.
class Prompt {
 public:
  /// One that is built in: "text", "marks", "navgpt", "mapgpt". \throws LookupError listing them
  static Prompt named(std::string_view name);
  static std::vector<std::string> names();
  /// Opens a user's choice: a file if it has an extension, else a name.
  /// \throws as load(), named()
  static Prompt open(const std::string& name_or_file);
  /// \throws FileError
  /// \throws InvalidInput naming file and line: an unknown name or an invalid value in the head,
  /// other than two texts, a tag that is not closed
  static Prompt load(const std::filesystem::path& file);
  /// \param file  for messages
  static Prompt parse(std::string_view text, const std::string& file, std::string name);

  const std::string& name() const noexcept { return name_; }
  const std::string& text() const noexcept { return text_; }  ///< of the whole file
  PictureKind pictures() const noexcept { return parts_.pictures; }
  Answers answers() const noexcept { return parts_.answers; }
  PromptMemory memory() const noexcept { return parts_.memory; }
  std::uint32_t kept_pictures() const noexcept { return parts_.kept_pictures; }

  /// The message at the start. \param answers  the form of the model's answers
  std::string start(const SessionObservation& seen, Answers answers,
                    const SessionLimits& limits) const;
  /// The message of a step.
  std::string step(const SessionObservation& seen, Answers answers, const SessionLimits& limits,
                   std::span<const PastStep> past) const;

 private:
  Prompt(std::string name, std::string text, PromptParts parts)
      : name_(std::move(name)), text_(std::move(text)), parts_(std::move(parts)) {}

  std::string name_, text_;
  PromptParts parts_;
};

/// "30 degrees to the right", "straight on", "behind you".
std::string turn_words(Radians turn);

}  // namespace enfilade::arena
