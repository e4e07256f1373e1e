// Requests of a model's endpoint as they arrive: headers, queries, proxies, responses in parts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <poll.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/arena/endpoint.h"
#include "enfilade/service/client.h"
#include "tests/arena/evil_server.h"
#include "tests/arena/listener.h"
#include "tests/support/raw_socket.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

/// A proxy that leads every CONNECT to a port of this machine, one connection after another.
class Tunnel {
 public:
  explicit Tunnel(int to) : to_(to), listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(listener_, any, size) + ::listen(listener_, 4), 0);
    EXPECT_EQ(::getsockname(listener_, any, &size), 0);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (int client = 0; (client = ::accept(listener_, nullptr, nullptr)) >= 0;) pass(client);
    });
  }
  ~Tunnel() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  Tunnel(const Tunnel&) = delete;
  Tunnel& operator=(const Tunnel&) = delete;

  int port = 0;
  std::vector<std::string> heads;  // of the requests to the proxy

 private:
  void pass(int client) {
    std::string& head = heads.emplace_back();
    for (char c = 0; !head.ends_with("\r\n\r\n") && ::recv(client, &c, 1, 0) == 1;) head += c;
    constexpr std::string_view kOpen = "HTTP/1.1 200 OK\r\n\r\n";
    ::send(client, kOpen.data(), kOpen.size(), MSG_NOSIGNAL);
    std::array<pollfd, 2> ends{{{client, POLLIN, 0}, {tests::connect_to(to_), POLLIN, 0}}};
    for (bool open = true; open && ::poll(ends.data(), ends.size(), -1) > 0;) {
      for (std::size_t k = 0; k < 2; ++k) {
        if (ends[k].revents == 0) continue;
        std::array<char, 4096> data{};
        const ssize_t n = ::recv(ends[k].fd, data.data(), data.size(), 0);
        open = n > 0 &&
               ::send(ends[1 - k].fd, data.data(), static_cast<std::size_t>(n), MSG_NOSIGNAL) == n;
        if (!open) break;
      }
    }
    for (const pollfd& one : ends) ::close(one.fd);
  }

  int to_, listener_;
  std::thread thread_;
};

/// A certificate of its own for a host's name, and its key.
struct Certificate {
  explicit Certificate(const std::string& host) : key(EVP_EC_gen("P-256")), x509(X509_new()) {
    ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509), -3600);
    X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
    X509_NAME* const name = X509_get_subject_name(x509);
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>(host.c_str()), -1, -1, 0);
    X509_set_issuer_name(x509, name);
    X509_set_pubkey(x509, key);
    EXPECT_GT(X509_sign(x509, key, EVP_sha256()), 0);
  }
  ~Certificate() {
    X509_free(x509);
    EVP_PKEY_free(key);
  }
  Certificate(const Certificate&) = delete;
  Certificate& operator=(const Certificate&) = delete;

  void write(const std::string& file) const {
    std::FILE* const out = std::fopen(file.c_str(), "w");
    ASSERT_NE(out, nullptr);
    EXPECT_EQ(PEM_write_X509(out, x509), 1);
    std::fclose(out);
  }

  EVP_PKEY* key;
  X509* x509;
};

/// An environment variable for a time.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    const char* const before = std::getenv(name);
    if (before != nullptr) before_ = before;
    had_ = before != nullptr;
    setenv(name, value.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
  ~Variable() {
    if (had_) {
      setenv(name_, before_.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    } else {
      unsetenv(name_);  // NOLINT(concurrency-mt-unsafe)
    }
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::string before_;
  bool had_ = false;
};

TEST(HttpEndpoint, SendsKeyHeadersAndQuery) {
  Listener listener;
  const auto plain = arena::make_http_endpoint({.url = listener.url() + "/", .key = "sk-secret1"});
  EXPECT_EQ(plain->post("{}", {"r2r/made/1_0", {{"go_to", "B"}, {"stop", ""}}}), "{}");
  EXPECT_EQ(listener.requests()[0].target, "/v1/chat/completions");
  EXPECT_EQ(listener.requests()[0].get_header_value("Authorization"), "Bearer sk-secret1");
  EXPECT_EQ(listener.requests()[0].get_header_value("X-Enfilade-Calls"), "go_to B;stop");
  const std::string deployment = listener.url() + "/deployments/gpt";
  const auto azure = arena::make_http_endpoint({.url = deployment + "?api-version=2024-10-21",
                                                .key = "sk-secret1",
                                                .key_header = "api-key",
                                                .headers = {{"X-Team", "vln lab"}}});
  azure->post("{}", {});
  const httplib::Request asked = listener.requests()[1];
  EXPECT_EQ(asked.target, "/v1/deployments/gpt/chat/completions?api-version=2024-10-21");
  EXPECT_EQ(asked.get_header_value("api-key"), "sk-secret1");
  EXPECT_EQ(asked.get_header_value("X-Team"), "vln lab");
  EXPECT_FALSE(asked.has_header("Authorization"));
  arena::make_http_endpoint({.url = deployment + "/chat/completions"})->post("{}", {});
  EXPECT_EQ(listener.requests()[2].target, "/v1/deployments/gpt/chat/completions");
}

TEST(HttpEndpoint, ShowsNoSecretThatTheServerRepeats) {
  Listener listener;
  listener.status = 401;
  listener.body = R"({"error": {"message": "wrong: sk-secret1, Bearer other-secret"}})";
  const auto endpoint = arena::make_http_endpoint(
      {.url = listener.url(), .key = "sk-secret1", .headers = {{"X-Key", "Bearer other-secret"}}});
  try {
    endpoint->post("{}", {});
    FAIL();
  } catch (const arena::EndpointError& error) {
    EXPECT_THAT(error.what(), HasSubstr("status 401: wrong: (key), "));
    EXPECT_THAT(error.what(), Not(HasSubstr("secret")));
    EXPECT_THAT(error.refusal().body, Not(HasSubstr("secret")));
  }
}

TEST(HttpEndpoint, SendsOneHeaderOfTheKeysName) {
  Listener listener;
  arena::make_http_endpoint({.url = listener.url(),
                             .key = "sk-secret1",
                             .headers = {{"authorization", "Basic b3RoZXI="}}})
      ->post("{}", {});
  EXPECT_EQ(listener.requests()[0].get_header_value_count("Authorization"), 1U);
  EXPECT_EQ(listener.requests()[0].get_header_value("Authorization"), "Basic b3RoZXI=");
}

TEST(HttpEndpoint, SendsNoControlCharacterInAHeader) {
  Listener listener;
  const auto endpoint = arena::make_http_endpoint({.url = listener.url()});
  for (const char* argument : {"B\r\nX: y", "B\n", "\x7f", "\u00e9"}) {
    EXPECT_THAT(refusal<ArgumentError>([&] {
                  endpoint->post("{}", {"e", {{"go_to", argument}}});
                }),
                HasSubstr("X-Enfilade-Calls: \"go_to "));
  }
  EXPECT_TRUE(listener.requests().empty());
}

TEST(HttpEndpoint, HidesSecretsInWhatAServerSays) {
  struct Row {
    std::string key, body, shown;
    int status;
  };
  const std::string far(4090, ' ');
  const Row rows[] = {
      // Keys of servers that need none, as "x", are in every text.
      {"x", R"({"error": "max_tokens"})", R"({"error": "max_tokens"})", 400},
      {"sk-secret1", far + "sk-secret1", far + "(key)", 400},
      {"sk-secret1", R"({"error": "sk-secret1"})", R"-({"error":"(key)"})-", 200},
      {"sk-secret1", "data: {\"error\": \"sk-secret1\"}\n\n", R"-({"error":"(key)"})-", 200},
      {"sk-secret1", R"({"choices": ["sk-secret1"]})", R"-({"choices":["(key)"]})-", 200},
      {"x", R"({"choices": ["x is x_x"]})", R"-({"choices":["(key) is x_x"]})-", 200},
  };
  for (const Row& row : rows) {
    Listener listener;
    listener.status = row.status;
    listener.body = row.body;
    std::string shown;
    try {
      shown = arena::make_http_endpoint({.url = listener.url(), .key = row.key})->post("{}", {});
    } catch (const arena::EndpointError& error) {
      shown = error.refusal().body;
    }
    EXPECT_EQ(shown, row.shown) << row.key;
  }
}

// Such as `X-Trial: 1`, where every 1 of an answer would be lost.
TEST(HttpEndpoint, AShortHeaderIsASecretIfItsNameSaysSo) {
  struct Row {
    const char *name, *shown;
  };
  const Row rows[] = {{"X-Trial", R"({"object": 1})"},
                      {"X-Api-Key", R"-({"object":"(key)"})-"},
                      {"authorization", R"-({"object":"(key)"})-"},
                      {"X-Mine", R"-({"object":"(key)"})-"}};
  for (const Row& row : rows) {
    Listener listener;
    listener.body = R"({"object": 1})";
    const auto endpoint = arena::make_http_endpoint(
        {.url = listener.url(), .key_header = "x-mine", .headers = {{row.name, "1"}}});
    EXPECT_EQ(endpoint->post("{}", {}), row.shown) << row.name;
  }
}

TEST(HttpEndpoint, AnswersHaveAnEnd) {
  const auto fault = [](const Listener& listener) {
    const auto endpoint = arena::make_http_endpoint({.url = listener.url(), .timeout = 0.4});
    return refusal<arena::EndpointError>([&] { endpoint->post("{}", {}); });
  };
  Listener large;
  large.body = std::string((1 << 24) + 1, ' ');
  EXPECT_THAT(fault(large), ::testing::AnyOf(HasSubstr("more than 16 MiB"), HasSubstr("in 0.4 s")));
  Listener deep;
  deep.body = R"({"choices":)" + std::string(100'000, '[') + std::string(100'000, ']') + "}";
  EXPECT_THAT(fault(deep), HasSubstr("an answer of more than 64 levels"));
  Listener slow;
  slow.drips = true;
  EXPECT_THAT(fault(slow), HasSubstr("no whole answer in 0.4 s"));
}

TEST(HttpEndpoint, AnAddressHasAHostAndAPort) {
  for (const char* url : {"http://127.0.0.1:0/v1", "http://127.0.0.1:70000/v1", "http://[::1/v1",
                          "http://:80/v1", "https://host:x"}) {
    EXPECT_THAT(refusal<ArgumentError>([&] { arena::make_http_endpoint({.url = url}); }),
                HasSubstr("not a host and a port from 1 to 65535"))
        << url;
  }
  EXPECT_NO_THROW(arena::make_http_endpoint({.url = "http://[::1]:8000/v1"}));
}

TEST(HttpEndpoint, JoinsResponsesInParts) {
  Listener listener;
  listener.type = "text/event-stream";
  listener.body =
      "data: {\"choices\":[{\"delta\":{\"content\":\"Act\"}}]}\n\n"
      "data: {\"choices\":[{\"delta\":{\"content\":\"ion: stop\"},\"finish_reason\":\"stop\"}]}\n\n"
      "data: [DONE]\n\n";
  const auto endpoint = arena::make_http_endpoint({.url = listener.url()});
  EXPECT_THAT(endpoint->post("{}", {}), HasSubstr(R"("content":"Action: stop")"));
}

// Case 13: a lab behind a proxy. The host does not exist; the proxy would know it.
TEST(HttpEndpoint, GoesThroughTheProxyOfTheEnvironment) {
  Listener proxy;
  const Variable lower("http_proxy", "");
  const Variable none("no_proxy", "");
  const Variable upper_none("NO_PROXY", "");
  const Variable upper("HTTP_PROXY", "http://me:p%40ss@127.0.0.1:" + std::to_string(proxy.port));
  const auto endpoint = arena::make_http_endpoint({.url = "http://model.invalid/v1"});
  EXPECT_EQ(endpoint->post("{}", {}), "{}");
  proxy.body = R"({"id": 7})";
  EXPECT_EQ(service::Client("http://model.invalid", "t").submit("test", "mine", "[]").id, 7);
  ASSERT_EQ(proxy.requests().size(), 2U);
  for (const httplib::Request& one : proxy.requests()) {
    EXPECT_THAT(one.target, HasSubstr("http://model.invalid"));
    EXPECT_EQ(one.get_header_value("Proxy-Authorization"), "Basic bWU6cEBzcw==");
  }
  // This machine is reached without it.
  Listener near;
  arena::make_http_endpoint({.url = near.url()})->post("{}", {});
  EXPECT_EQ(near.requests().size(), 1U);
  EXPECT_EQ(proxy.requests().size(), 2U);
  const Variable other("http_proxy", "socks5://me:secret@p:1");
  const std::string fault =
      refusal<ArgumentError>([] { arena::make_http_endpoint({.url = "http://model.invalid/v1"}); });
  EXPECT_THAT(fault, HasSubstr("http_proxy: a proxy of another kind than HTTP"));
}

TEST(HttpEndpoint, TheServerDoesNotGetTheProxysLogin) {
  const Certificate certificate("model.invalid");
  const TemporaryFolder folder("certificate");
  certificate.write(folder.path() / "host.pem");
  const Variable trusted("SSL_CERT_FILE", folder.path() / "host.pem");
  Listener server(std::make_unique<httplib::SSLServer>(certificate.x509, certificate.key));
  server.body = R"({"id": 7})";
  Tunnel tunnel(server.port);
  const Variable lower("https_proxy", "");
  const Variable none("no_proxy", "");
  const Variable upper_none("NO_PROXY", "");
  const Variable upper("HTTPS_PROXY", "http://me:p%40ss@127.0.0.1:" + std::to_string(tunnel.port));
  EXPECT_EQ(arena::make_http_endpoint({.url = "https://model.invalid/v1"})->post("{}", {}),
            server.body);
  EXPECT_EQ(service::Client("https://model.invalid", "t").submit("test", "mine", "[]").id, 7);
  ASSERT_EQ(tunnel.heads.size(), 2U);
  EXPECT_THAT(tunnel.heads, Each(AllOf(HasSubstr("CONNECT model.invalid:443 "),
                                       HasSubstr("Proxy-Authorization: Basic bWU6cEBzcw=="))));
  ASSERT_EQ(server.requests().size(), 2U);
  for (const httplib::Request& one : server.requests()) {
    EXPECT_EQ(one.get_header_value("Proxy-Authorization"), "");
  }
}

TEST(HttpEndpoint, HidesSecretsInWhatAProxySays) {
  EvilServer proxy([](const Connection& to) {
    to.send("HTTP/1.1 407 not me:pass-word1, nor bWU6cGFzcy13b3JkMQ==\r\n\r\n");
  });
  const std::string url = proxy.url();
  const Variable lower("https_proxy", "");
  const Variable none("no_proxy", "");
  const Variable upper_none("NO_PROXY", "");
  const Variable upper("HTTPS_PROXY", "http://me:pass-word1@" + url.substr(7, url.rfind('/') - 7));
  const std::string why = refusal<arena::EndpointError>(
      [] { arena::make_http_endpoint({.url = "https://model.invalid/v1"})->post("{}", {}); });
  EXPECT_THAT(why, HasSubstr("the proxy: HTTP/1.1 407 not (key), nor "));
  EXPECT_THAT(why, Not(HasSubstr("word1")));
  EXPECT_THAT(why, Not(HasSubstr("bWU6cGFzcy")));
}

// Its connection looks alive: the end of TLS can be read from it.
TEST(HttpEndpoint, AsksAgainWhereAnIdleConnectionWasEnded) {
  const Certificate certificate("localhost");
  const TemporaryFolder folder("certificate");
  certificate.write(folder.path() / "host.pem");
  const Variable trusted("SSL_CERT_FILE", folder.path() / "host.pem");
  const Variable none("no_proxy", "*");
  auto made = std::make_unique<httplib::SSLServer>(certificate.x509, certificate.key);
  made->set_keep_alive_timeout(1);
  Listener server(std::move(made));
  const auto endpoint =
      arena::make_http_endpoint({.url = "https://localhost:" + std::to_string(server.port)});
  EXPECT_EQ(endpoint->post("{}", {}), "{}");
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_EQ(endpoint->post("{}", {}), "{}");
  EXPECT_EQ(server.requests().size(), 2U);
}

TEST(HttpEndpoint, AServerIsTheOneOfItsCertificate) {
  const Certificate certificate("model.invalid");
  const TemporaryFolder folder("certificate");
  certificate.write(folder.path() / "host.pem");
  Listener server(std::make_unique<httplib::SSLServer>(certificate.x509, certificate.key));
  const Variable none("no_proxy", "*");
  const auto why = [&server](const std::string& host) {
    const std::string url = "https://" + host + ":" + std::to_string(server.port) + "/v1";
    return refusal<arena::EndpointError>(
        [&] { arena::make_http_endpoint({.url = url, .key = "secret"})->post("{}", {}); });
  };
  EXPECT_THAT(why("localhost"), HasSubstr("self-signed certificate"));
  const Variable trusted("SSL_CERT_FILE", folder.path() / "host.pem");
  EXPECT_THAT(why("localhost"), HasSubstr("hostname mismatch"));
  EXPECT_THAT(why("127.0.0.1"), HasSubstr("IP address mismatch"));
  EXPECT_TRUE(server.requests().empty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
