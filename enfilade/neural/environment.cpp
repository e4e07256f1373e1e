#include "enfilade/neural/environment.h"

#include <array>

namespace enfilade::neural {

std::string_view to_string(ModelAction action) noexcept {
  constexpr std::array<std::string_view, kModelActions> kNames{"left", "right",   "up",
                                                               "down", "forward", "end"};
  return kNames[static_cast<std::size_t>(action)];
}

}  // namespace enfilade::neural
