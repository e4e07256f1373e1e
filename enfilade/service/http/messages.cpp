#include "enfilade/service/http/messages.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <ranges>

#include "enfilade/core/check.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/rng.h"
#include "enfilade/net/hosts.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::http {
namespace {

using detail::Reason;
using nlohmann::ordered_json;

constexpr std::size_t kMostDiagnostics = 200;
constexpr const char* kRetrySeconds = "5";  // large bodies are checked within one

/// A status and the word for it, which scripts match.
struct Answer {
  int status = 0;
  std::string_view code;
};

constexpr std::array<Answer, 15> kAnswers{{{400, "invalid-request"},
                                           {401, "unauthenticated"},
                                           {403, "forbidden"},
                                           {404, "not-found"},
                                           {405, "method-not-allowed"},
                                           {408, "request-timeout"},
                                           {409, "conflict"},
                                           {413, "payload-too-large"},
                                           {414, "uri-too-long"},
                                           {415, "unsupported-media-type"},
                                           {421, "misdirected-request"},
                                           {422, "invalid-input"},
                                           {429, "rate-limited"},
                                           {500, "internal-error"},
                                           {503, "unavailable"}}};

/// By Reason. Codes of their own where a client goes on differently.
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
static_assert(kRefusals.size() == static_cast<std::size_t>(Reason::kRateLimited) + 1);

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
  response.problem = message;
  return response;
}

Response try_later(std::string_view message) {
  Response response = error_response(503, message);
  response.add_header("Retry-After", kRetrySeconds);
  return response;
}

/// A part of a query: + is a blank, too.
std::string decode(std::string_view text) {
  std::string blanks(text);
  std::ranges::replace(blanks, '+', ' ');
  return decode_percent(blanks);
}

constexpr std::size_t kWorthCompressing = 1024;  // bytes; of less, the headers are the larger part

// Pictures are compressed already.
bool is_worth_compressing(std::string_view type) {
  return type.starts_with("text/") || type.starts_with("application/json") ||
         type.starts_with("image/svg") || type == "application/octet-stream";
}

}  // namespace

Texts parse_query(std::string_view target) {
  Texts query;
  const std::size_t begin = target.find('?');
  if (begin == std::string_view::npos) return query;
  for (const auto part : std::views::split(target.substr(begin + 1), '&')) {
    const std::string_view pair(part.begin(), part.end());
    const std::size_t equals = std::min(pair.find('='), pair.size());
    if (pair.empty()) continue;
    query.emplace(decode(pair.substr(0, equals)),
                  decode(pair.substr(std::min(equals + 1, pair.size()))));
  }
  return query;
}

const std::string& Request::parameter(std::string_view name) const {
  const auto found = parameters.find(name);
  EN_CHECK(found != parameters.end());
  return found->second;
}

std::int64_t Request::id(std::string_view name, const char* missing) const {
  const auto value = parse_number<std::int64_t>(parameter(name));
  if (!value) throw HttpError(404, missing);
  return *value;
}

std::string Request::text(std::string_view name) const {
  const auto found = query.find(name);
  return found == query.end() ? std::string{} : found->second;
}

std::int64_t Request::number(std::string_view name, std::int64_t otherwise, std::int64_t least,
                             std::int64_t most) const {
  const auto found = query.find(name);
  if (found == query.end()) return otherwise;
  const std::string& text = found->second;
  const auto value = parse_number<std::int64_t>(text);
  if (!value || *value < least || *value > most) {
    throw HttpError(400, fmt::format("{}: {:?}, not a whole number from {} to {}", name,
                                     text.substr(0, 40), least, most));
  }
  return *value;
}

const accounts::Principal& Request::known_principal() const {
  if (!principal) {
    throw HttpError(401, "this needs a token: Authorization: Bearer enfilade_...");
  }
  return *principal;
}

Response shared_response(std::string type, std::shared_ptr<const std::string> body) {
  Response response;
  response.type = std::move(type);
  response.body = std::move(body);
  return response;
}

Response text_response(std::string type, std::string text) {
  return shared_response(std::move(type), std::make_shared<const std::string>(std::move(text)));
}

Response json_response(const ordered_json& json, int status) {
  Response response = text_response("application/json", json.dump());
  response.status = status;
  return response;
}

Response csv_response(std::string csv) {
  return text_response("text/csv; charset=utf-8", std::move(csv));
}

Response file_response(std::string type, std::string content, const std::string& name) {
  Response response = text_response(std::move(type), std::move(content));
  response.add_header("Content-Disposition", fmt::format("attachment; filename=\"{}\"", name));
  return response;
}

Response error_response(int status, std::string_view message,
                        const std::vector<Diagnostic>& diagnostics) {
  const auto* found = std::ranges::find(kAnswers, status, &Answer::status);
  // The others are faults of a message's form, as 400 is.
  const auto code = found == kAnswers.end() ? "invalid-request" : found->code;
  return respond({status, code}, message, diagnostics);
}

Response error_response(int status, std::string_view code, std::string_view message) {
  return respond({status, code}, message, {});
}

Response error_response(const std::exception_ptr& thrown, std::string& fault) {
  try {
    std::rethrow_exception(thrown);
  } catch (const HttpError& error) {
    return error.status() == 503 ? try_later(error.what())
                                 : error_response(error.status(), error.what());
  } catch (const detail::Refusal& refusal) {
    return respond(kRefusals[static_cast<std::size_t>(refusal.reason())], refusal.what(), {});
  } catch (const InvalidInput& error) {
    return error_response(422, "what was sent has faults", error.diagnostics());
  } catch (const store::DatabaseError& error) {
    if (error.cause() == store::DatabaseError::Cause::kNoText) {
      return error_response(400, "a text has an invalid character");
    }
    fault = error.what();
    if (const auto trouble = store::trouble_of(error)) {
      return try_later(*trouble == store::Trouble::kDiskFull
                           ? "the server's disk is full"
                           : "the server does not reach its database");
    }
  } catch (const std::exception& error) {
    fault = error.what();
  } catch (...) {
    fault = "an exception of no known type";
  }
  return error_response(500, "the server failed; its log says why");
}

ordered_json parse_object(const std::string& body) {
  const std::string found = json::excess(body, detail::kFormLimits);
  if (!found.empty()) throw HttpError(400, "the body has " + found);
  ordered_json object = ordered_json::parse(body, nullptr, false);
  if (!object.is_object()) throw HttpError(400, "the body is not a JSON object");
  return object;
}

const ordered_json& form_field(const ordered_json& object, const char* name,
                               bool (ordered_json::*is)() const noexcept, const char* what) {
  const auto found = object.find(name);
  if (found == object.end() || !((*found).*is)()) {
    throw HttpError(400, fmt::format("{}: must be there, and {}", name, what));
  }
  return *found;
}

std::string text_field(const ordered_json& object, const char* name, Presence presence) {
  if (presence == Presence::kOptional && !object.contains(name)) return {};
  return form_field(object, name, &ordered_json::is_string, "a text").get<std::string>();
}

Form::Form(const std::string& body) : object_(std::make_unique<ordered_json>(parse_object(body))) {}

Form::~Form() = default;

bool Form::has(const char* name) const { return object_->contains(name); }

std::string Form::text(const char* name, Presence presence) {
  try {
    return text_field(*object_, name, presence);
  } catch (const HttpError& error) {
    add_fault(error.what());
    return {};
  }
}

std::int64_t Form::whole(const char* name, std::int64_t otherwise, std::int64_t least,
                         std::int64_t most) {
  const auto found = object_->find(name);
  if (found == object_->end() || found->is_null()) return otherwise;
  if (found->is_number_integer() && *found >= least && *found <= most) {
    return found->get<std::int64_t>();
  }
  add_fault(fmt::format("{}: not a whole number from {} to {}", name, least, most));
  return otherwise;
}

void Form::add_fault(std::string_view fault) {
  faults_.append(faults_.empty() ? "" : "; ").append(fault);
}

void Form::check() const {
  if (!faults_.empty()) throw HttpError(400, faults_);
}

bool accepts_gzip(const Request& request) {
  const std::string_view accepted = request.header("accept-encoding");
  return accepted.find("gzip") != std::string_view::npos &&
         accepted.find("gzip;q=0") == std::string_view::npos;
}

void compress(const Request& request, Response& response) {
  if (!is_worth_compressing(response.type) || response.body->size() < kWorthCompressing) return;
  if (response.header("Content-Encoding")) return;
  response.add_header("Vary", "Accept-Encoding");
  if (!accepts_gzip(request)) return;
  response.body = std::make_shared<const std::string>(gzip(*response.body, 5));
  response.add_header("Content-Encoding", "gzip");
}

void add_digest(Response& response) {
  const std::string& body = *response.body;
  response.add_header("ETag", fmt::format("\"{:016x}\"", stream_of(body.data(), body.size())));
  response.add_header("Cache-Control", "no-cache");
}

void compare_with_cached(const Request& request, Response& response) {
  const std::string_view known = request.header("if-none-match");
  const auto tag = response.header("ETag");
  if (response.status != 200 || !tag || known.find(*tag) == std::string_view::npos) return;
  response.status = 304;
  response.body = std::make_shared<const std::string>();
}

bool is_encrypted(const Request& request, const ServerConfig& config) {
  return config.behind_proxy && request.header("x-forwarded-proto") == "https";
}

std::string session_cookie(const Request& request, const ServerConfig& config) {
  const auto host = net::parse_host(request.header("host"));
  const bool with_port = host && !host->port.empty();
  return fmt::format("{}{}{}{}", is_encrypted(request, config) ? "__Host-" : "",
                     accounts::kSessionCookie, with_port ? "_" : "", with_port ? host->port : "");
}

std::string content_policy(std::string_view form_action, std::string_view frame_ancestors) {
  return fmt::format(
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
      "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action {}; frame-ancestors {}",
      form_action, frame_ancestors);
}

void add_security_headers(Response& response) {
  const auto add = [&response](const char* name, std::string_view value) {
    if (!response.header(name)) response.add_header(name, std::string(value));
  };
  static const std::string kContentPolicy = content_policy("'self'", "'none'");
  add("Content-Security-Policy", kContentPolicy);
  add("X-Content-Type-Options", "nosniff");
  if (!response.frameable) add("X-Frame-Options", "DENY");
  add("Referrer-Policy", "no-referrer");
  add("Cross-Origin-Opener-Policy", "same-origin");
  add("Cross-Origin-Resource-Policy", "same-origin");
  add("Permissions-Policy", "camera=(), microphone=(), geolocation=(), payment=()");
  // Responses may depend on the client: none is cached unless its route says so.
  add("Cache-Control", "no-store");
}

}  // namespace enfilade::service::http
