/// \file  Pictures of a session: described first, rendered on request only.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/arena/session.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::arena {

/// Which pictures go with an observation.
enum class PictureKind : std::uint8_t {
  kNone,
  kStrip,   ///< one: left, ahead, right and behind side by side, with the places' names in it
  kPlaces,  ///< one a place, looking there, 60 degrees wide; in continuous space one ahead, of 90
};
constexpr std::array<std::string_view, 3> names_of(PictureKind /*enum*/) {
  return {"none", "strip", "places"};
}

/// A direction with a name, as drawn into a strip.
struct NamedDirection {
  std::string name;
  Radians heading, elevation;  ///< world frame
};

/// A picture before it is drawn. Two that are equal show the same, to the bit.
struct PictureOrder {
  std::string caption;  ///< "B": the place in its direction; "ahead"; empty for a strip
  Standpoint from;      ///< heading of a strip: that of its second quarter
  bool strip = false;
  std::uint32_t size = 512;           ///< pixels: height, of a strip a quarter of the width
  std::vector<NamedDirection> marks;  ///< in a strip

  /// Names what it shows, by place, angles, size and marks: equal on all computers that have the
  /// same data set, and known without drawing it.
  std::string key() const;
};

/// The pictures of an observation, in the order of its places. \param size pixels, 64 to 2048
/// \throws ArgumentError for another size
std::vector<PictureOrder> order_pictures(const Session& session, PictureKind pictures,
                                         std::uint32_t size = 512);

/// Source of pictures.
struct ViewSources {
  std::shared_ptr<const dataset::Dataset> data = {};  ///< its panoramas, for graphs
  continuous::SceneSource scene_of = {};              ///< for continuous space; from any thread
};

/// Draws pictures of a data set. One thread at a time.
class PictureMaker {
 public:
  /// \throws as dataset::Dataset::faces()
  explicit PictureMaker(const ViewSources& sights);
  ~PictureMaker();
  PictureMaker(const PictureMaker&) = delete;
  PictureMaker& operator=(const PictureMaker&) = delete;

  /// JPEG, quality 85. \throws ArgumentError if there is nothing to draw it from; as
  /// render::Renderer::render(), continuous::SceneSource, Eyes::render()
  std::string draw(const PictureOrder& order);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena
