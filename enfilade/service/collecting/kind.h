/// \file  Kinds of work in a collection.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

namespace enfilade::service::collecting {

enum class Kind : std::uint8_t {
  kWrite,     ///< a path is shown, an instruction is written (Room-to-Room)
  kWalk,      ///< an instruction is shown, the worker follows it: the Human agent
  kDescribe,  ///< a path to an object is shown, the worker writes how to find it (REVERIE)
  kFind,      ///< such a text is shown: the worker follows it, and points at the object
  kGuide,     ///< the worker moves along a path, and speaks or writes, with times (RxR)
  kDialogue,  ///< two workers: one moves and asks, one sees the path and answers (CVDN)
};
constexpr std::array<std::string_view, 6> names_of(Kind /*enum*/) {
  return {"write", "walk", "describe", "find", "guide", "dialogue"};
}

/// Whether a task's content is one text, which reviewers may correct.
constexpr bool is_written(Kind kind) { return kind == Kind::kWrite || kind == Kind::kDescribe; }
/// Whether the worker follows a text to an unknown goal.
constexpr bool is_followed(Kind kind) { return kind == Kind::kWalk || kind == Kind::kFind; }
/// Whether items have an object, or a region, as their goal.
constexpr bool has_target(Kind kind) {
  return kind == Kind::kDescribe || kind == Kind::kFind || kind == Kind::kDialogue;
}
/// Whether the item is a whole path, and not one of its instructions.
constexpr bool shows_path(Kind kind) { return is_written(kind) || kind == Kind::kGuide; }

}  // namespace enfilade::service::collecting
