#include "enfilade/service/http/errors.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "enfilade/service/detail/errors.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostDiagnostics = 200;

/// A status and the word for it, which scripts match.
struct Answer {
  int status = 0;
  std::string_view code;
};

constexpr std::array<Answer, 14> kAnswers{{{400, "invalid-request"},
                                           {401, "unauthenticated"},
                                           {403, "forbidden"},
                                           {404, "not-found"},
                                           {405, "method-not-allowed"},
                                           {408, "request-timeout"},
                                           {409, "conflict"},
                                           {413, "payload-too-large"},
                                           {414, "uri-too-long"},
                                           {415, "unsupported-media-type"},
                                           {422, "invalid-input"},
                                           {429, "rate-limited"},
                                           {500, "internal-error"},
                                           {503, "unavailable"}}};

Answer answer_of(int status) {
  const auto* found = std::ranges::find(kAnswers, status, &Answer::status);
  // cpp-httplib has some more for messages that it cannot read.
  return {status, found == kAnswers.end() ? "invalid-request" : found->code};
}

/// In the order of ErrorCode. Codes of their own where a client goes on differently.
constexpr std::array<Answer, 10> kRefusals{{{422, "invalid-input"},
                                            {403, "forbidden"},
                                            {403, "consent-required"},
                                            {403, "collection-closed"},
                                            {404, "not-found"},
                                            {409, "conflict"},
                                            {409, "already-submitted"},
                                            {409, "already-returned"},
                                            {409, "lease-expired"},
                                            {429, "rate-limited"}}};
static_assert(kRefusals.size() == static_cast<std::size_t>(detail::ErrorCode::kRateLimited) + 1);

Response respond(const Answer& answer, std::string_view message,
                 const std::vector<Diagnostic>& diagnostics) {
  ordered_json error{{"code", answer.code}, {"message", message}};
  if (!diagnostics.empty()) {
    auto& list = error["diagnostics"] = ordered_json::array();
    for (const Diagnostic& d : diagnostics) {
      if (list.size() == kMostDiagnostics) break;
      list.push_back({{"severity", to_string(d.severity)},
                      {"where", d.where},
                      {"code", d.code},
                      {"message", d.message}});
    }
    error["diagnostic_count"] = diagnostics.size();
  }
  // A message may quote bytes of the request, which need not be UTF-8.
  Response response = text_response(
      "application/json",
      ordered_json{{"error", error}}.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
  response.status = answer.status;
  return response;
}

}  // namespace

Response error_response(int status, std::string_view message,
                        const std::vector<Diagnostic>& diagnostics) {
  return respond(answer_of(status), message, diagnostics);
}

Response error_response(const std::exception_ptr& thrown, std::string& fault) {
  try {
    std::rethrow_exception(thrown);
  } catch (const HttpError& error) {
    return error_response(error.status(), error.what());
  } catch (const detail::ServiceError& error) {
    return respond(kRefusals[static_cast<std::size_t>(error.code())], error.what(), {});
  } catch (const InvalidInput& error) {
    return error_response(422, "what was sent has faults", error.diagnostics());
  } catch (const std::exception& error) {
    fault = error.what();
  } catch (...) {
    fault = "an exception of no known type";
  }
  return error_response(500, "the server failed; its log says why");
}

}  // namespace enfilade::service::http
