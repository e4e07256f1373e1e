#include "enfilade/render/devices.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/render/cuda/compiler.h"
#include "enfilade/render/cuda/driver.h"

namespace enfilade::render {
namespace {

constexpr std::uint8_t kGrey = 200;

}  // namespace

std::shared_ptr<FaceCache> sample_faces() {
  scan::Connectivity connectivity{"sample", "<memory>", {}};
  scan::ConnectivityEntry entry;
  entry.id = "here";
  entry.pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  connectivity.entries.push_back(entry);
  scan::Panorama panorama;
  for (image::Image8& face : panorama.colour) {
    face = image::Image8(16, 16, 3);
    std::ranges::fill(face.pixels, kGrey);
  }
  return std::make_shared<FaceCache>(scan::PanoramaSet::of(
      {std::make_shared<scan::MemoryPanoramas>(connectivity, std::vector{std::move(panorama)})}));
}

void check_sample(Renderer& renderer) {
  const Camera camera{64, 48, degrees(60)};
  const View view{ScanIndex(0), ViewpointIndex(0), Radians(1), Radians(0.5)};
  std::vector<std::uint8_t> pixels(std::size_t{3} * camera.width * camera.height);
  Outputs outputs;
  outputs.colour = ColourOutput{ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(pixels))};
  renderer.render(camera, {&view, 1}, outputs);
  if (std::ranges::count(pixels, kGrey) != std::ssize(pixels)) {
    throw Error(renderer.description() + " draws a plain picture wrong");
  }
}

CudaReport cuda_report() {
  CudaReport report;
  try {
    const cuda::Api& api = cuda::api();
    int version = 0, count = 0;
    cuda::check(api.DriverGetVersion(&version), "asking the driver's version");
    report.driver = fmt::format("{}.{}", version / 1000, version % 1000 / 10);
    cuda::check(api.DeviceGetCount(&count), "counting cards");
    for (int k = 0; k < count; ++k) {
      const cuda::Device device(k);
      const cuda::CurrentDevice current(device);
      CudaDevice& found = report.devices.emplace_back();
      found.name = device.name();
      found.capability = fmt::format("{}.{}", device.capability() / 10, device.capability() % 10);
      cuda::check(api.MemGetInfo(&found.free_bytes, &found.bytes), "asking for free memory");
    }
  } catch (const Error& error) {
    report.error = error.what();
  }
  try {
    report.compiler = cuda::Compiler().version();
  } catch (const Error& error) {
    report.compiler_error = error.what();
  }
  return report;
}

}  // namespace enfilade::render
