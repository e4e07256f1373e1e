#include "enfilade/service/evaluation/near_copies.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/service/store/database.h"

namespace enfilade::service::evaluation {
namespace {

constexpr std::size_t kBytes = 4;  // of an episode
// Rows read at a time: 16 of R2R's largest split are 270 kB.
constexpr int kRowsAtOnce = 16;

/// FNV-1a, of 32 bits: two answers that differ are taken for one in 2^-32 of cases.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes)
      value_ = (value_ ^ static_cast<unsigned char>(byte)) * 0x01000193U;
  }
  std::uint32_t value() const { return value_; }

 private:
  std::uint32_t value_ = 0x811C9DC5U;
};

/// Of what is said of the goal; 0 where nothing is.
std::uint32_t answer_of(const tasks::Trajectory& trajectory) {
  std::string said = trajectory.object;
  if (trajectory.turning_point) said += fmt::format("@{}", trajectory.turning_point->value);
  if (trajectory.point) {
    said += fmt::format("({},{})", trajectory.point->heading, trajectory.point->elevation);
  }
  if (said.empty()) return 0;
  Hash hash;
  hash.add(said);
  return hash.value();
}

std::uint32_t end_of(const tasks::Trajectory& trajectory) {
  return trajectory.points.back().viewpoint.value ^ answer_of(trajectory);
}

std::uint32_t end_of(const tasks::ContinuousResult& walk) {
  constexpr double kCell = 0.25;  // metres
  const Vec3f place = walk.positions.back();
  const auto cell = [](float x) { return std::floor(double{x} / kCell); };
  Hash hash;
  hash.add(fmt::format("{} {} {} {}", cell(place.x), cell(place.y), cell(place.z), walk.stopped()));
  return hash.value();
}

template <typename Walk>
std::string ends_of(const std::vector<Walk>& walks) {
  std::string bytes;
  bytes.reserve(kBytes * walks.size());
  for (const Walk& walk : walks) {
    std::uint32_t end = end_of(walk);
    for (std::size_t k = 0; k < kBytes; ++k, end >>= 8U) {
      bytes.push_back(static_cast<char>(end & 0xFFU));
    }
  }
  return bytes;
}

}  // namespace

std::string trajectory_ends(const std::vector<tasks::Trajectory>& trajectories) {
  return ends_of(trajectories);
}

std::string trajectory_ends(const std::vector<tasks::ContinuousResult>& walks) {
  return ends_of(walks);
}

std::optional<std::size_t> count_differing(std::string_view ends, std::string_view other) {
  if (ends.size() != other.size()) return std::nullopt;
  std::size_t count = 0;
  for (std::size_t at = 0; at < ends.size(); at += kBytes) {
    if (ends.substr(at, kBytes) != other.substr(at, kBytes)) ++count;
  }
  return count;
}

std::size_t most_differing(std::size_t episodes) noexcept {
  return std::min(std::max<std::size_t>(5, episodes / 50), episodes / 4);
}

std::optional<NearCopy> find_near_copy(store::Database& db, const std::vector<std::string>& phases,
                                       std::int64_t id, std::string_view ends) {
  const std::size_t most = most_differing(ends.size() / kBytes);
  std::optional<NearCopy> nearest;
  for (const std::string& phase : phases) {
    for (std::int64_t after = 0;;) {
      const auto rows = db.select<std::tuple<std::int64_t, std::string>>(
          "SELECT id, ends FROM submission WHERE phase = ? AND id > ? AND id < ? AND ends IS NOT "
          "NULL ORDER BY id LIMIT ?",
          phase, after, id, kRowsAtOnce);
      for (const auto& [other, its_ends] : rows) {
        after = other;
        const auto differing = count_differing(ends, its_ends);
        if (!differing || *differing > most) continue;
        const NearCopy copy{other, static_cast<std::int64_t>(*differing)};
        if (!nearest ||
            std::tie(copy.differing, copy.of) < std::tie(nearest->differing, nearest->of)) {
          nearest = copy;
        }
      }
      if (rows.size() < static_cast<std::size_t>(kRowsAtOnce)) break;
    }
  }
  return nearest;
}

}  // namespace enfilade::service::evaluation
