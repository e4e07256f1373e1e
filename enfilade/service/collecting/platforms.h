/// \file  Where workers come from and how they are let go: a link of one's own, Amazon Mechanical
/// Turk (an ExternalQuestion), Prolific.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace enfilade::service::collecting {

enum class PlatformKind : std::uint8_t { kSelf, kMturk, kProlific };
std::string_view to_string(PlatformKind kind);  ///< "self", "mturk", "prolific"
/// \pre the text is one of those
PlatformKind platform_kind(std::string_view text);

struct Platform {
  PlatformKind kind = PlatformKind::kSelf;
  /// Mechanical Turk: who may frame the pages and take their form, each as is_origin() has it.
  std::vector<std::string> origins;
  std::string completion_code;  ///< Prolific: of the study
};

/// Those of Mechanical Turk and its sandbox.
std::vector<std::string> mturk_origins();
/// "https://www.mturk.com"; http for this machine only, where stand-ins run. Nothing in it can end
/// a directive of a Content-Security-Policy.
bool is_origin(std::string_view text);

/// Query of the page's address, decoded.
using Parameters = std::map<std::string, std::string, std::less<>>;

/// Somebody at the door.
struct Arrival {
  bool preview = false;    ///< looks at the task before taking it; the rest is empty then
  std::string worker;      ///< the platform's id of who it is
  std::string assignment;  ///< what is paid for: assignmentId, SESSION_ID; "" if self-hosted
  std::string group;       ///< hitId, STUDY_ID
  std::string submit_to;   ///< Mechanical Turk: the origin to post to when done
};

/// What the platform's query says. A self-hosted worker without a name gets one that nobody can
/// guess. \throws HttpError 422 naming the parameter
Arrival read_arrival(const Platform& platform, const Parameters& parameters);

/// How a worker leaves.
struct Completion {
  PlatformKind kind = PlatformKind::kSelf;
  std::string action;                                       ///< Mechanical Turk: of the form
  std::vector<std::pair<std::string, std::string>> fields;  ///< of the form
  std::string url, code;                                    ///< Prolific
};
Completion completion(const Platform& platform, const std::string& assignment,
                      const std::string& submit_to, std::int64_t visit, std::int64_t tasks);

/// What has to be added to a link's query for the platform to fill in; "" if nothing.
std::string_view placeholders(PlatformKind kind);

}  // namespace enfilade::service::collecting
