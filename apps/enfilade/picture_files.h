/// \file  Shared by the verbs that render panoramas: their sources, outputs and files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/draw/colour_maps.h"
#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::apps {

/// Options for the source of pictures and the back end.
struct SceneOptions {
  std::vector<std::string> images;
  std::string connectivity, data;
  std::string backend = "cpu", gl_device, cuda_device;
  std::string cache = "private";
  std::size_t cache_mib = render::SharedCacheConfig().bytes >> 20U;  ///< of a shared one
  bool legacy = false;
};
/// SCAN and VIEWPOINT
void add_viewpoint_arguments(CLI::App& verb, std::string& scan, std::string& viewpoint);
/// --images, --connectivity, --data
void add_place_options(CLI::App& verb, SceneOptions& options);
/// An option NAME of any finite number of degrees.
void add_angle_option(CLI::App& verb, const char* name, double& degrees, const char* help);
/// --vfov
void add_field_of_view_option(CLI::App& verb, double& degrees);
/// \throws UsageError unless it is in (0, 180)
void validate_field_of_view(double degrees);
/// --backend, --gl-device, --cuda-device, --legacy, --cache, --cache-mib
void add_renderer_options(CLI::App& verb, SceneOptions& options);

/// The data set of these options, with one scan: its index is ScanIndex().
/// \throws as scan::open_panoramas(); UsageError if no folder is known
dataset::Dataset open_scene(const SceneOptions& options, const std::string& scan);
const scan::PanoramaSource& source_of(const dataset::Dataset& scene);  ///< the scan's
std::unique_ptr<render::Renderer> make_renderer(const dataset::Dataset& scene,
                                                const SceneOptions& options);

/// A viewpoint by its index, id, or beginning of an id that no other one shares.
/// \throws LookupError
ViewpointIndex find_viewpoint(const scan::PanoramaSource& source, const std::string& text);

/// "640x480". \throws UsageError naming the option
struct Size {
  std::uint32_t width = 0, height = 0;
};
Size parse_size(const std::string& option, const std::string& text);

/// Layers of the output, and their files.
struct OutputOptions {
  std::string outputs = "rgb";  ///< "rgb,depth"
  std::string file;
  bool raw = false;  ///< values, not colours
};
/// --outputs, --output, --raw
void add_output_options(CLI::App& verb, OutputOptions& options, const std::string& default_file);

/// A layer and its file.
struct PictureFile {
  scan::Layer layer = scan::Layer::kColour;
  std::string path;
};
/// \throws UsageError for layers or file names that make no sense
std::vector<PictureFile> picture_files(const OutputOptions& options);
/// \throws LookupError naming the option and the layers that there are, if the panorama lacks one
void require_layers(const scan::PanoramaSource& source, ViewpointIndex viewpoint,
                    const std::vector<PictureFile>& files);

using Drawn = render::Pictures;
/// Makes room in `drawn` for the files' layers, for a renderer.
render::Outputs outputs_into(Drawn& drawn, const std::vector<PictureFile>& files, Size size,
                             std::size_t views = 1);
/// Colours of the layers; names of classes from the data set, if it has them.
draw::LayerColours colours_of(const Drawn& drawn, const SceneOptions& options);

/// A PNG, or a JPEG for such a name.
std::string encode(const image::Image8& picture, const std::string& path);
/// PNG: depth and classes of 16 bits; instances of 16 bits, or RGBA (id = R + 256 G + 65536 B +
/// 2^24 A) where an id is above 65535; colour of 8.
std::string encode_raw(const Drawn& drawn, scan::Layer layer);
/// Writes the layers as colours with a legend, or raw; then names the files on standard output.
void write_pictures(const Drawn& drawn, const std::vector<PictureFile>& files,
                    const OutputOptions& output, const SceneOptions& scene);
/// Writes one file and names it on standard output, unless that is the file.
void write_picture(const std::string& path, const std::string& content);

}  // namespace enfilade::apps
