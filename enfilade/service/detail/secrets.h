/// \file  Random secrets and their hashes.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::service::detail {

/// `prefix` and 256 bits of the system's randomness in hexadecimal digits.
std::string new_secret(std::string_view prefix);

/// SHA-256 in hexadecimal digits. Enough for secrets of 256 random bits, which cannot be guessed
/// however fast the hash is; passwords would need a slow hash.
std::string sha256(std::string_view text);

/// HMAC-SHA-256 in hexadecimal digits. Only holders of the key can compute this hash, so it suits
/// values that are few enough to be tried one by one.
std::string keyed_hash(std::string_view key, std::string_view text);

}  // namespace enfilade::service::detail
