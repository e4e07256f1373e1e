/// \file  Platforms that send workers: the server's own link, Amazon Mechanical Turk (an
/// ExternalQuestion), Prolific.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::service::collecting {

enum class PlatformKind : std::uint8_t { kSelf, kMturk, kProlific };
constexpr std::array<std::string_view, 3> names_of(PlatformKind /*enum*/) {
  return {"self", "mturk", "prolific"};
}

struct Platform {
  PlatformKind kind = PlatformKind::kSelf;
  /// Mechanical Turk: sites that may frame the pages and receive their form; see is_origin().
  std::vector<std::string> origins;
  std::string completion_code;  ///< Prolific: of the study
  std::string screen_out_code;  ///< Prolific: for workers whom the screening sends away; or empty
};

/// Those of Mechanical Turk and its sandbox.
std::vector<std::string> mturk_origins();
/// "https://www.mturk.com"; http for this machine only, where tests run. It has no character that
/// ends a directive of a Content-Security-Policy.
bool is_origin(std::string_view text);

/// The query of the page's address, decoded.
using Parameters = std::map<std::string, std::string, std::less<>>;

/// A worker who opens the link, as the platform describes the worker.
struct Arrival {
  bool preview = false;    ///< the worker has not accepted the task yet; the rest is empty then
  std::string worker;      ///< the platform's id of the worker
  std::string assignment;  ///< the paid unit: assignmentId, SESSION_ID; "" if self-hosted
  std::string group;       ///< hitId, STUDY_ID
  std::string submit_to;   ///< Mechanical Turk: the origin to post to when done
};

/// Reads the platform's query. A self-hosted worker without a name gets a random one.
/// \throws Refusal kInvalidInput naming the parameter
Arrival read_arrival(const Platform& platform, const Parameters& parameters);

}  // namespace enfilade::service::collecting
