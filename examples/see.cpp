// See: an agent turns on the spot in a made-up room, and its pictures are kept as PNGs.
#include <fmt/core.h>

#include <cmath>

#include "enfilade/core/file.h"
#include "enfilade/homes/small_building.h"
#include "enfilade/image/codecs.h"
#include "enfilade/render/renderer.h"

namespace {

using namespace enfilade;

// A striped wall between a floor and a ceiling, in every direction.
scan::Panorama striped_room(std::uint32_t size) {
  scan::Panorama room;
  for (std::size_t face = 0; face < kCubeFaces; ++face) {
    room.colour[face] = image::Image8(size, size, 3);
    for (std::uint32_t y = 0; y < size; ++y) {
      for (std::uint32_t x = 0; x < size; ++x) {
        const Vec3d d = cube_direction(cube_face(face), (x + 0.5) / size, (y + 0.5) / size);
        const double level = std::hypot(d.x, d.z), slope = d.y / level;  // y points down
        std::uint8_t* rgb = room.colour[face].at(x, y);
        const bool stripe = std::fmod(std::atan2(d.x, d.z) + 4 * kPi, kPi / 8) < kPi / 16;
        rgb[0] = static_cast<std::uint8_t>(slope > 0.7 ? 120 : slope < -0.5 ? 235 : 200);
        rgb[1] = static_cast<std::uint8_t>(slope > 0.7    ? 85
                                           : slope < -0.5 ? 235
                                           : stripe       ? 190
                                                          : 150);
        rgb[2] = static_cast<std::uint8_t>(slope > 0.7 ? 60 : slope < -0.5 ? 230 : 120);
      }
    }
  }
  return room;
}

}  // namespace

int main() {
  // Real ones: scan::PanoramaSet::open({{"store"}, "connectivity"}, graphs->scans()).
  scan::Connectivity building = homes::make_small_building(1, "synth").connectivity;
  std::vector<scan::Panorama> rooms(building.entries.size(), striped_room(64));
  const auto panoramas = scan::PanoramaSet::of(
      {std::make_shared<const scan::MemoryPanoramas>(std::move(building), std::move(rooms))});
  const auto renderer = render::make_renderer(std::make_shared<render::FaceCache>(panoramas));

  const Camera camera{160, 120, degrees(60)};
  std::vector<render::View> views(4);
  for (std::size_t k = 0; k < views.size(); ++k) {
    views[k] = {ScanIndex(0), ViewpointIndex(0), degrees(90.0 * static_cast<double>(k)),
                Radians(0)};
  }
  image::Image8 strip(camera.width, camera.height * 4, 3);  // a batch of pictures is a tall picture
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{
      render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(strip.pixels))};
  renderer->render(camera, views, outputs);
  const auto png = image::encode_png(strip);
  write_file_atomically("see.png", {reinterpret_cast<const char*>(png.data()), png.size()});
  fmt::print("see.png: {} views by {}\n", views.size(), renderer->description());
}
