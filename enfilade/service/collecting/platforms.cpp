#include "enfilade/service/collecting/platforms.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/service/detail/refusal.h"
#include "enfilade/service/detail/secrets.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::collecting {
namespace {

using detail::Reason;
using detail::Refusal;

constexpr std::size_t kLongestWorker = 100;
constexpr std::size_t kLongestOrigin = 200;
// What MTurk sends as assignment before the worker has accepted it.
constexpr std::string_view kNoAssignment = "ASSIGNMENT_ID_NOT_AVAILABLE";

std::string parameter(const Parameters& parameters, std::string_view name) {
  const auto found = parameters.find(name);
  return found == parameters.end() ? std::string() : found->second;
}

std::string external_id(const Parameters& parameters, std::string_view name) {
  std::string value = parameter(parameters, name);
  if (!detail::is_external_id(value)) {
    throw Refusal(
        Reason::kInvalidInput,
        fmt::format("{}: {:?}, not 1 to 100 of A-Z, a-z, 0-9, - and _", name, value.substr(0, 40)));
  }
  return value;
}

Arrival by_link(const Parameters& parameters) {
  constexpr std::size_t kNameSize = 34;  // "w-" and 128 bits
  const auto named = parameters.find("worker");
  if (named == parameters.end())
    return {false, detail::new_secret("w-").substr(0, kNameSize), "", "", ""};
  if (!detail::is_label(named->second, kLongestWorker)) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("worker: not 1 to {} printable characters", kLongestWorker));
  }
  return {false, named->second, "", "", ""};
}

Arrival by_mturk(const Platform& platform, const Parameters& parameters) {
  const std::string assignment = parameter(parameters, "assignmentId");
  if (assignment.empty() || assignment == kNoAssignment) return {true, "", "", "", ""};
  std::string submit_to = parameter(parameters, "turkSubmitTo");
  while (submit_to.ends_with('/')) submit_to.pop_back();
  // The origin is part of the page's address, which anybody can write: an unknown one could send
  // the form, and the worker, anywhere.
  if (std::ranges::find(platform.origins, submit_to) == platform.origins.end()) {
    throw Refusal(Reason::kInvalidInput,
                  fmt::format("turkSubmitTo: {:?}, not one of the collection's origins",
                              submit_to.substr(0, 80)));
  }
  return {false, external_id(parameters, "workerId"), external_id(parameters, "assignmentId"),
          external_id(parameters, "hitId"), std::move(submit_to)};
}

Arrival by_prolific(const Parameters& parameters) {
  return {false, external_id(parameters, "PROLIFIC_PID"), external_id(parameters, "SESSION_ID"),
          external_id(parameters, "STUDY_ID"), ""};
}

}  // namespace

std::vector<std::string> mturk_origins() {
  return {"https://www.mturk.com", "https://worker.mturk.com", "https://workersandbox.mturk.com"};
}

bool is_origin(std::string_view text) {
  if (text.size() > kLongestOrigin) return false;
  std::string_view host = text;
  if (host.starts_with("https://")) {
    host.remove_prefix(8);
  } else if (host.starts_with("http://127.0.0.1") || host.starts_with("http://localhost")) {
    host.remove_prefix(7);
  } else {
    return false;
  }
  return !host.empty() && host.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-.:") ==
                              std::string_view::npos;
}

Arrival read_arrival(const Platform& platform, const Parameters& parameters) {
  if (platform.kind == PlatformKind::kMturk) return by_mturk(platform, parameters);
  if (platform.kind == PlatformKind::kProlific) return by_prolific(parameters);
  return by_link(parameters);
}

}  // namespace enfilade::service::collecting
