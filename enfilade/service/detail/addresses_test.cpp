#include "enfilade/service/detail/addresses.h"

#include <gtest/gtest.h>

namespace enfilade::service::detail {
namespace EN_UNIT {

TEST(Addresses, AHomeOfIpv6IsOneAddress) {
  EXPECT_EQ(address_group("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(address_group("2001:DB8:1:2::1"), address_group("2001:db8:1:2:ffff::"));
  EXPECT_NE(address_group("2001:db8:1:3::1"), address_group("2001:db8:1:2::1"));
}

TEST(Addresses, AnIpv4AddressIsItselfHoweverItIsWritten) {
  EXPECT_EQ(address_group("192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(address_group("::ffff:192.0.2.7"), "192.0.2.7");
  EXPECT_EQ(address_group("::FFFF:c000:207"), "192.0.2.7");
}

TEST(Addresses, WhatIsNoAddressStaysAsItIs) {
  EXPECT_EQ(address_group("unknown"), "unknown");
  EXPECT_EQ(address_group(""), "");
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::detail
