/// \file  Computes the light at the points of a light mesh, in steps.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "enfilade/core/threads.h"
#include "enfilade/mesh/light/scene.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade::mesh::light {

struct BakedLight {
  LightMesh mesh;
  /// Irradiance over pi by light point, without sunlight, for which rays are traced when drawing.
  std::vector<Vec3f> light;
  float key = 1;  ///< LitMesh::key()
};

/// Reports progress of steps with known shares.
class BakeSteps {
 public:
  BakeSteps(const Progress& progress, int threads) : progress_(progress), threads_(threads) {}

  /// parallel_for(), and `share` of 1000 is done.
  template <class Body>
  void run(std::size_t count, std::size_t grain, std::size_t share, const Body& body) {
    constexpr std::size_t kReports = 8;
    const std::size_t from = done_;
    for (std::size_t k = 0; k < kReports; ++k) {
      const std::size_t first = count * k / kReports, last = count * (k + 1) / kReports;
      parallel_for(last - first, grain, threads_,
                   [&](std::size_t a, std::size_t b) { body(first + a, first + b); });
      report(from + share * (k + 1) / kReports);
    }
  }
  void report(std::size_t done) {
    done_ = std::min<std::size_t>(done, kTotal);
    if (progress_) progress_(done_, kTotal);
  }
  static constexpr std::size_t kTotal = 1000;

 private:
  const Progress& progress_;
  int threads_;
  std::size_t done_ = 0;
};

/// The sky, in the place of a light point.
inline constexpr LightPoint kNowhere = 0x7fffffffU;

class Baker {
 public:
  /// \pre options are in range
  Baker(const RayTracer& tracer, const LitSurfaces& surfaces, const Lights& lights,
        const BakeOptions& options, const Progress& progress);

  BakedLight run();

 private:
  struct PointState {
    bool live = false;    ///< receives light
    bool backs = false;   ///< sees mostly back sides
    bool buried = false;  ///< and is dark: inside a solid
  };
  /// Result of one ray.
  struct RayEnd {
    Vec3f radiance;      ///< of lights that are not sampled explicitly
    LightPoint surface;  ///< the nearest point; kNowhere: the sky
    bool back;           ///< of that surface
    bool near;           ///< it is within kNear spacings
  };
  /// Neighbours on one surface.
  using Link = std::array<LightPoint, 2>;
  /// Directions about a normal; the first coordinate is rotated about it, the last along it.
  using Directions = std::vector<Vec3f>;

  void cut_to_spacing();
  void make_sources();
  void make_glowing_sources();
  void make_directions();
  void measure();  ///< areas, colours, and where rays start
  void measure_room();
  void grow();  ///< arrays to the light mesh's size
  Receiver receiver(LightPoint p) const;

  void aim_at_sources(std::size_t first, std::size_t last, std::size_t share);
  void shine_sun();
  void probe();
  void find_buried();
  bool is_dark(LightPoint p) const;
  float median_irradiance() const;
  const Directions& directions(LightPoint p) const;
  template <class Use>
  void cast(LightPoint p, const Directions& directions, const Use& use) const;
  Ray along(LightPoint a, LightPoint b) const;
  std::vector<std::uint8_t> sees_ends(std::size_t known) const;
  std::vector<Link> make_links() const;
  std::vector<Link> seams(const std::vector<std::uint8_t>& rim) const;
  std::vector<Link> open_links(const std::vector<Link>& fronts) const;
  void part_near_from_far();
  void join_near_and_far(LightPoint p);
  RayEnd find(const Receiver& from, Vec3f direction, const Hit& hit) const;
  void gather_base();
  void bounce();
  void send_on();
  void smooth(std::size_t rounds);
  void refine();
  bool uneven(LightPoint a, LightPoint b, float distance) const;
  void gather_new(std::size_t known);
  void fill_buried();
  void find_key();

  const RayTracer& tracer_;
  const LitSurfaces& surfaces_;
  const Lights& lights_;
  const BakeOptions& options_;
  BakeSteps steps_;
  Surroundings surroundings_;
  LightMesh mesh_, base_mesh_;  ///< the latter: before refinement
  float spacing_ = 0;           ///< options' or more, where points would be too many
  float typical_ = 0;           ///< median luminance of irradiance
  std::vector<LightSource> sources_;
  std::vector<std::int32_t> source_of_;  ///< of a glowing triangle; -1: none; may be empty
  std::array<Directions, 4> directions_;

  // By place, that is, half a light point.
  std::vector<Vec3f> start_;  ///< origin of its rays, without the step off the surface
  std::vector<float> area_;
  std::vector<Vec3f> colour_;
  std::vector<std::uint8_t> outside_;  ///< 1: only of surfaces that are in no room
  std::vector<float> room_;  ///< harmonic mean of distances to surfaces, on the tighter side
  // By light point.
  std::vector<PointState> state_;
  std::vector<Vec3f> direct_, indirect_, sun_;  ///< irradiance
  std::vector<Vec3f> found_;                    ///< the part of indirect_ that surfaces do not send
  // Indirect light in two parts. Light from near surfaces (the shade below a table) is taken from a
  // point's own rays. Light from far surfaces changes little from point to point, but few rays find
  // it (a patch of sun). So it is averaged over neighbours.
  std::vector<Vec3f> near_;       ///< irradiance
  std::vector<Vec3f> far_;        ///< mean radiance
  std::vector<float> far_share_;  ///< of rays
  std::vector<float> open_;       ///< share of rays that meet the sky
  std::vector<Vec3f> sends_;      ///< radiance that it sends on
  // Where the rays of the base's points end: those of p from first_ray_[p] on.
  class SeenPoint {
   public:
    SeenPoint() = default;  ///< the sky
    SeenPoint(LightPoint surface, bool near) : bits_(surface << 1U | (near ? 1U : 0U)) {}
    LightPoint surface() const { return bits_ >> 1U; }  ///< kNowhere: the sky
    bool near() const { return (bits_ & 1U) != 0; }

   private:
    std::uint32_t bits_ = kNowhere << 1U;
  };
  std::vector<std::size_t> first_ray_;
  std::vector<SeenPoint> seen_;
  float key_ = 1;
};

}  // namespace enfilade::mesh::light
