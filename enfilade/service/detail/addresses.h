/// \file  Addresses of clients as limits count them.
#pragma once
#include <string>
#include <string_view>

namespace enfilade::service::detail {

/// The address that limits count by. An IPv4 address, also one written as IPv6 (::ffff:1.2.3.4).
/// The first 64 bits of an IPv6 address, as a home or a lab has all addresses that begin with them.
/// Any other text is returned unchanged. Any thread.
std::string address_group(std::string_view address);

}  // namespace enfilade::service::detail
