// A panorama's files, whatever is in them: strips and faces of every layer.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <string>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/scan/matterport_images.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace enfilade;
namespace fs = std::filesystem;

/// A scan with a viewpoint for each kind of picture; all their files are links to one.
class OneFile {
 public:
  OneFile() {
    fs::create_directory(folder_ / "matterport_skybox_images");
    add("colour", {"small.jpg"});
    add("depth", {"depth_small.png"});
    add("class", {"class_small.png"});
    add("instance", {"instance_small.png"});
    add("faces",
        {"0_sami.jpg", "1_sami.jpg", "2_sami.jpg", "3_sami.jpg", "4_sami.jpg", "5_sami.jpg"});
    write_file_atomically(folder_ / "s_connectivity.json", to_json(graph_));
  }

  std::shared_ptr<const scan::PanoramaSource> open(const std::uint8_t* data,
                                                   std::size_t size) const {
    std::ofstream file(folder_ / "file", std::ios::binary);
    file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    file.close();
    EN_CHECK(file.good());
    return scan::open_matterport_images(folder_, folder_, "s");
  }

 private:
  void add(const std::string& viewpoint, std::initializer_list<std::string> files) {
    auto& entry = graph_.entries.emplace_back();
    entry.id = viewpoint;
    entry.pose = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};
    for (const std::string& file : files) {
      const bool face = file.ends_with("_sami.jpg");
      fs::create_symlink(folder_ / "file",
                         folder_ / "matterport_skybox_images" /
                             (viewpoint + (face ? "_skybox" : "_skybox_") + file));
    }
  }

  const tests::TemporaryFolder made_{"fuzz_strip"};
  const fs::path& folder_ = made_.path();
  scan::Connectivity graph_{"s", "<fuzz>", {}};
};

// A small file may be a large picture; readers take it, but not in a fuzzer's time.
constexpr std::uint32_t kLargest = 1024;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const OneFile kFile;
  const auto source = kFile.open(data, size);
  for (std::size_t i = 0; i < source->size(); ++i) {
    const ViewpointIndex viewpoint(i);
    try {
      const scan::FaceSizes sizes = source->face_sizes(viewpoint);
      if (std::ranges::max(sizes) > kLargest) continue;
      if (sizes[index(scan::Layer::kColour)] != 0) source->colour_jpegs(viewpoint);
      EN_CHECK(scan::read_panorama(*source, viewpoint).sizes() == sizes);
    } catch (const InvalidInput&) {  // no other error: every file is there
    }
  }
  return 0;
}
