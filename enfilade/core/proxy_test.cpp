#include "enfilade/core/proxy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "enfilade/core/errors.h"
#include "tests/support/refusal.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using Variables = std::map<std::string, std::string>;

std::optional<Proxy> proxy_in(const Variables& variables, const std::string& url) {
  return proxy_for(url, [&variables](const char* name) -> const char* {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}

/// "HOST:PORT of the variable"; "" without a proxy.
std::string found(const Variables& variables, const std::string& url) {
  const auto proxy = proxy_in(variables, url);
  return proxy ? proxy->address() + " " + proxy->variable : "";
}

TEST(Proxies, BelongToTheSchemeInBothCasesOfLetters) {
  const Variables both{{"HTTPS_PROXY", "http://s.lab:3128"}, {"http_proxy", "p.lab:8080/"}};
  EXPECT_EQ(found(both, "https://api.example.org/v1"), "s.lab:3128 HTTPS_PROXY");
  EXPECT_EQ(found(both, "http://model.example.org:8000/v1"), "p.lab:8080 http_proxy");
  EXPECT_EQ(found({{"HTTP_PROXY", "a"}, {"http_proxy", "b"}}, "http://x/"), "b:1080 http_proxy");
  EXPECT_EQ(found({{"http_proxy", ""}, {"HTTP_PROXY", "a:1"}}, "http://x"), "a:1 HTTP_PROXY");
  EXPECT_EQ(found({{"ALL_PROXY", "a:1"}}, "https://x"), "a:1 ALL_PROXY");
  EXPECT_EQ(found({{"HTTP_PROXY", "a:1"}}, "https://x"), "");
  EXPECT_EQ(found({{"HTTP_PROXY", "[fe80::1]:3128"}}, "http://x"), "[fe80::1]:3128 HTTP_PROXY");
  EXPECT_EQ(found({}, "http://x"), "");
}

TEST(Proxies, HaveUserAndPassword) {
  const auto proxy = proxy_in({{"https_proxy", "http://me%40lab:p%3a%2F@p.lab:3128"}}, "https://x");
  ASSERT_TRUE(proxy);
  EXPECT_EQ(proxy->user, "me@lab");
  EXPECT_EQ(proxy->password, "p:/");
  EXPECT_EQ(proxy->address(), "p.lab:3128");
}

TEST(Proxies, AreNotForTheHostsOfNoProxy) {
  struct Row {
    const char *list, *url;
    bool excepted;
  };
  constexpr Row kRows[] = {
      {"*", "http://a.org", true},
      {"a.org", "http://a.org", true},
      {"a.org", "http://A.ORG:8000/v1", true},
      {"a.org", "http://m.a.org", true},
      {".a.org", "http://m.a.org", true},
      {"*.a.org", "http://m.a.org", true},
      {"a.org", "http://aa.org", false},
      {"b.org, a.org", "http://a.org", true},
      {"a.org:8000", "http://a.org:8000", true},
      {"a.org:8000", "http://a.org:8001", false},
      {"10.0.0.0/8", "http://10.20.30.40:8000", true},
      {"10.0.0.0/8", "http://11.0.0.1", false},
      {"192.168.1.5", "http://192.168.1.5", true},
      {"", "http://a.org", false},
  };
  for (const Row& row : kRows) {
    for (const char* name : {"NO_PROXY", "no_proxy"}) {
      EXPECT_EQ(found({{"http_proxy", "p:1"}, {name, row.list}}, row.url).empty(), row.excepted)
          << name << "=" << row.list << " " << row.url;
    }
  }
}

TEST(Proxies, AreNotForThisMachine) {
  for (const char* url : {"http://127.0.0.1:8000/v1", "http://localhost", "http://[::1]:8000"}) {
    EXPECT_EQ(found({{"http_proxy", "p:1"}}, url), "") << url;
  }
}

TEST(Proxies, OfAnotherKindAreNamed) {
  const auto fault = [](const std::string& value) {
    return tests::refusal<ArgumentError>([&] { proxy_in({{"http_proxy", value}}, "http://x"); });
  };
  EXPECT_THAT(fault("socks5://me:secret@p:1"), HasSubstr("http_proxy: a proxy of another kind"));
  EXPECT_THAT(fault("socks5://me:secret@p:1"), Not(HasSubstr("secret")));
  EXPECT_THAT(fault("http://p:99999"), HasSubstr("the port is not 1 to 65535"));
  EXPECT_THAT(fault("http://"), HasSubstr("no host"));
}

}  // namespace EN_UNIT
}  // namespace enfilade
