/// \file  The most that a response may have. They bound the time and memory that any server can
/// take, and are far from what a model writes. The table is in docs/arena.md.
#pragma once
#include <cstddef>
#include <cstdint>

#include "enfilade/core/detail/json.h"

namespace enfilade::arena::detail {

/// Bytes of a response, before and after it is unpacked; of an answer in the cache too.
inline constexpr std::size_t kMostAnswer = 16U << 20U;
/// A response, or one event of it, has no more.
inline constexpr json::Limits kAnswerLimits{.values = 250'000, .depth = 64, .keys = 1'000};
inline constexpr std::size_t kMostChoices = 16;
inline constexpr std::size_t kMostCalls = 64;        ///< of tools, in a message
inline constexpr std::size_t kMostText = 1U << 20U;  ///< bytes of all texts of a message
/// Tokens of a response, by the server's count: sums of them stay numbers.
inline constexpr std::uint64_t kMostTokens = 1'000'000'000;
/// Bytes of a request, without its pictures.
inline constexpr std::size_t kMostConversation = 16U << 20U;

}  // namespace enfilade::arena::detail
