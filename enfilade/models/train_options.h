/// \file  The options of a training: fields of TrainConfig, by their names in config.json and on
/// the command line.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enfilade/models/train_config.h"

namespace enfilade::models {

/// A field whose values have names, of any type.
struct NamedField {
  void* value;
  std::string_view (*name)(const void* value);
  /// \param what for messages \throws ArgumentError listing the allowed names
  void (*parse)(void* value, std::string_view what, std::string_view name);
  std::vector<std::string> (*names)();  ///< as the command line lists them
};

/// A field of one configuration.
using OptionField =
    std::variant<bool*, std::size_t*, std::int64_t*, double*, std::optional<std::size_t>*,
                 std::optional<std::string>*, std::vector<std::string>*, NamedField>;

/// Kinds of agents: bit 1 << AgentKind of each.
using AgentKinds = std::uint32_t;

/// One row of the table of options. An option whose field differs by the kind of agent has a row
/// for each; these share a flag.
struct TrainOption {
  std::string_view json;  ///< name in config.json
  AgentKinds kinds;       ///< that have it there
  OptionField (*field)(TrainConfig& config);

  /// On the command line.
  struct Flag {
    std::string_view name = {};  ///< empty: none
    std::string_view help = {};
    AgentKinds kinds = ~AgentKinds{0};  ///< of the row's
    std::uint64_t least = 1;            ///< of a whole number
  } flag = {};

  /// What is checked, and what older files do not have.
  struct Rules {
    std::size_t least = 0;  ///< of whole numbers, and of the number of names
    double most = 0;        ///< of numbers from 0; 0: not checked, or with the network's sizes
    bool needed = true;     ///< in a file
    bool (*applies)(const TrainConfig& config) = nullptr;  ///< by fields above it; null: always
  } rules = {};

  std::string words() const;  ///< its name for messages: "sampled loss"
  /// Whether a kind of agent has the option.
  bool of(AgentKind kind) const noexcept {
    return (kinds >> static_cast<unsigned>(kind) & 1U) != 0;
  }
  /// Whether the command line of that kind has its flag.
  bool has_flag(AgentKind kind) const noexcept {
    return of(kind) && (flag.kinds >> static_cast<unsigned>(kind) & 1U) != 0;
  }
};

/// The options of two objects of config.json, in their order there.
std::span<const TrainOption> network_options();
std::span<const TrainOption> training_options();  ///< likewise

/// Checks the ranges in the table. \throws ArgumentError naming the first field out of range, its
/// value and the range
void check_ranges(const TrainConfig& config);

}  // namespace enfilade::models
