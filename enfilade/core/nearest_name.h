/// \file  Which of several names a misspelled one is meant to be, for messages.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade {

/// The names that need the fewest changes to become `text`, in their order. A change adds, removes
/// or replaces a byte, or swaps two neighbours. None if each needs more changes than a third of its
/// bytes.
std::vector<std::string_view> nearest_names(std::string_view text,
                                            std::span<const std::string_view> names);

/// The end of a message about an unknown name: "the nearest is \"per_team\"", or the allowed names
/// if none is near: "allowed are name, split".
std::string advice_on_name(std::string_view text, std::span<const std::string_view> names);

}  // namespace enfilade
