#include "enfilade/models/detail/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace enfilade::models::detail {

std::string hash_of(std::string_view bytes) {
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

}  // namespace enfilade::models::detail
