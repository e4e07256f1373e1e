#include "enfilade/service/detail/secrets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <array>

#include "enfilade/core/check.h"

namespace enfilade::service::detail {

std::string new_secret(std::string_view prefix) {
  std::array<unsigned char, 32> bytes{};
  EN_CHECK_EQ(RAND_bytes(bytes.data(), static_cast<int>(bytes.size())), 1);
  return fmt::format("{}{:02x}", prefix, fmt::join(bytes, ""));
}

std::string sha256(std::string_view text) {
  std::array<unsigned char, 32> digest{};
  unsigned length = 0;
  EN_CHECK_EQ(EVP_Digest(text.data(), text.size(), digest.data(), &length, EVP_sha256(), nullptr),
              1);
  EN_CHECK_EQ(length, digest.size());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string keyed_hash(std::string_view key, std::string_view text) {
  std::array<unsigned char, 32> digest{};
  unsigned length = 0;
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  EN_CHECK(HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), bytes, text.size(),
                digest.data(), &length) != nullptr);
  EN_CHECK_EQ(length, digest.size());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

}  // namespace enfilade::service::detail
