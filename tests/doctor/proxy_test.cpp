// What `enfilade doctor` says of the proxies that `ask` and `submit` use.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "enfilade/core/file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Doctor, TellsWhichProxiesAreUsedAndNoPassword) {
  const tests::TemporaryFolder folder("proxies");
  const std::string said = folder.path() / "said";
  tests::Process process({EN_PROGRAM, "doctor", "--json"}, said,
                         {{"__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null"},  // no driver takes time
                          {"http_proxy", "socks5://me:secret@proxy.lab:1"},
                          {"https_proxy", ""},
                          {"HTTPS_PROXY", "http://me:secret@proxy.lab:3128"},
                          {"no_proxy", ""},
                          {"NO_PROXY", "10.0.0.0/8"}});
  ASSERT_EQ(process.wait(), 0);
  const std::string text = read_file(said);
  EXPECT_THAT(text, Not(HasSubstr("secret")));
  const nlohmann::json network = nlohmann::json::parse(text)["network"];
  EXPECT_EQ(network["proxy for https"]["text"], "proxy.lab:3128 (HTTPS_PROXY, a user)");
  EXPECT_EQ(network["without a proxy"]["text"], "this machine, 10.0.0.0/8 (NO_PROXY)");
  const nlohmann::json& refused = network["proxy for http"];
  EXPECT_FALSE(refused["works"]);
  EXPECT_THAT(refused["text"], HasSubstr("http_proxy: a proxy of another kind than HTTP"));
  EXPECT_EQ(refused["advice"], "set the variable to http://HOST:PORT, or unset it");
}

}  // namespace EN_UNIT
}  // namespace enfilade
