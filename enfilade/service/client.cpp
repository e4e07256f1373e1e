#include "enfilade/service/client.h"

#include <fmt/format.h>
#include <httplib.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "enfilade/core/detail/no_broken_pipe.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/proxy.h"
#include "enfilade/service/detail/answer_limits.h"

namespace enfilade::service {
namespace {

constexpr double kBytesPerSecond = 32U << 10U;  // of a slow line, to send a file
constexpr int kMostTries = 12;                  // when the server has no room for a large file
constexpr int kLongestWait = 30;                // seconds, before another one
// A file with 1,000 faults is answered in a hundredth of that.
constexpr std::size_t kMostAnswer = std::size_t{16} << 20U;      // bytes, unpacked
constexpr std::uint64_t kMostBytes = kMostAnswer + (1U << 20U);  // with its head, as they come

std::string text_of(const nlohmann::json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

SubmissionStatus read_status(const nlohmann::json& answer) {
  SubmissionStatus status;
  status.id = answer.at("id").get<std::int64_t>();
  status.phase = text_of(answer, "phase");
  status.method = text_of(answer, "method");
  status.state = text_of(answer, "state");
  if (const auto means = answer.find("means"); means != answer.end()) {
    for (const auto& [name, value] : means->items()) {
      if (value.at("mean").is_number()) status.means[name] = value.at("mean").get<double>();
    }
  }
  if (answer.contains("withheld")) status.withheld = text_of(answer, "withheld");
  if (const auto warnings = answer.find("warnings"); warnings != answer.end()) {
    status.warnings = warnings->get<std::vector<std::string>>();
  }
  return status;
}

std::vector<Diagnostic> read_diagnostics(const nlohmann::json& error) {
  std::vector<Diagnostic> list;
  const auto found = error.find("diagnostics");
  if (found == error.end() || !found->is_array()) return list;
  for (const auto& one : *found) {
    const std::string severity = text_of(one, "severity");
    list.push_back({severity == "error"     ? Severity::kError
                    : severity == "warning" ? Severity::kWarning
                                            : Severity::kNote,
                    "submission", text_of(one, "where"), text_of(one, "code"),
                    text_of(one, "message")});
  }
  return list;
}

}  // namespace

struct Client::Impl {
  std::string server;
  std::string through;  // the proxy, for messages
  httplib::Client http;
  httplib::Headers headers;
  double seconds;
  detail::AnswerLimits* limits = nullptr;  // of the present request

  Impl(std::string its_server, const std::string& token, double its_seconds)
      : server(std::move(its_server)),
        http(server),
        headers{{"Authorization", "Bearer " + token}},
        seconds(its_seconds) {
    if (!http.is_valid()) {
      throw ArgumentError(
          fmt::format("server: {:?}, not an address like https://vln.example.org", server));
    }
    if (const auto proxy = proxy_for(server)) {
      through = fmt::format(" through the proxy {} ({})", proxy->address(), proxy->variable);
      http.set_proxy(proxy->host, proxy->port);
      if (!proxy->user.empty()) {
        http.set_proxy_basic_auth(proxy->user, proxy->password);
        // The library sends the proxy's login to the server, too, unless this header is there.
        if (server.starts_with("https://")) headers.emplace("Proxy-Authorization", "");
      }
    }
    const auto time = std::chrono::microseconds(std::llround(seconds * 1e6));
    http.set_connection_timeout(time);
    http.set_read_timeout(time);
    http.set_write_timeout(time);
    http.set_socket_options([this](socket_t socket) { limits->watch(socket); });
  }

  /// \throws Error for an answer beyond the limits
  httplib::Result send(const char* method, std::string path, std::string_view body = {}) {
    using Passed = detail::AnswerLimits::Passed;
    const double time = seconds + static_cast<double>(body.size()) / kBytesPerSecond;
    detail::AnswerLimits its_limits(std::chrono::duration<double>(time), kMostBytes);
    limits = &its_limits;
    std::string answer;
    httplib::Request request;
    request.method = method;
    request.path = std::move(path);
    request.headers = headers;
    if (!body.empty()) request.set_header("Content-Type", "application/json");
    request.body = body;
    request.content_receiver = [&](const char* data, std::size_t size, std::uint64_t,
                                   std::uint64_t) {
      answer.append(data, size);
      return answer.size() <= kMostAnswer;
    };
    const enfilade::detail::NoBrokenPipe no_broken_pipe;
    httplib::Result result = http.send(request);
    const Passed passed = its_limits.passed();
    if (passed == Passed::kBytes || answer.size() > kMostAnswer) {
      throw Error(fmt::format("{}: its answer has more than {} MiB", server, kMostAnswer >> 20U));
    }
    if (passed == Passed::kTime) {
      throw Error(fmt::format("{}: its answer took more than {:.0f} s", server, time));
    }
    if (result) result->body = std::move(answer);
    return result;
  }

  SubmissionStatus read(const httplib::Result& result) const {
    if (!result) {
      throw Error(
          fmt::format("{}: cannot be reached{}: {}", server, through, to_string(result.error())));
    }
    const nlohmann::json answer = nlohmann::json::parse(result->body, nullptr, false);
    if (result->status == 200 || result->status == 202) {
      try {
        return read_status(answer);
      } catch (const nlohmann::json::exception&) {
        throw Error(fmt::format("{}: its answer is not one of an Enfilade server", server));
      }
    }
    const auto error = answer.is_object() ? answer.value("error", nlohmann::json::object())
                                          : nlohmann::json::object();
    if (auto diagnostics = read_diagnostics(error); !diagnostics.empty()) {
      throw InvalidInput(std::move(diagnostics));
    }
    throw Error(fmt::format("{}: status {}: {}", server, result->status,
                            error.is_object() ? text_of(error, "message") : ""));
  }
};

Client::Client(std::string server, const std::string& token, double seconds)
    : impl_(std::make_unique<Impl>(std::move(server), token, seconds)) {}

Client::~Client() = default;

SubmissionStatus Client::submit(const std::string& phase, const std::string& method,
                                std::string_view results) {
  const std::string target =
      httplib::append_query_params("/api/v1/submissions", {{"phase", phase}, {"method", method}});
  for (int tries = 1;; ++tries) {
    const auto result = impl_->send("POST", target, results);
    if (!result || result->status != 503 || tries == kMostTries) return impl_->read(result);
    const std::string wait = result->get_header_value("Retry-After");
    std::this_thread::sleep_for(
        std::chrono::seconds(std::clamp(parse_number<int>(wait).value_or(5), 1, kLongestWait)));
  }
}

SubmissionStatus Client::status(std::int64_t submission) {
  return impl_->read(impl_->send("GET", fmt::format("/api/v1/submissions/{}", submission)));
}

}  // namespace enfilade::service
