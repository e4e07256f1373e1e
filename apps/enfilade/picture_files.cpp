#include "apps/enfilade/picture_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/numbers.h"
#include "enfilade/image/codecs.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;
using scan::Layer;

// By index(Layer), as options call them.
constexpr std::array<std::string_view, scan::kLayers> kLayerNames{"rgb", "depth", "class",
                                                                  "instance"};

std::string_view name_of(Layer layer) { return kLayerNames.at(index(layer)); }

// The folder of --data or of the environment; empty: neither names one.
fs::path data_folder(const SceneOptions& options) {
  if (!options.data.empty()) return options.data;
  const auto named = dataset::Dataset::from_environment();
  return named ? named->folder() : fs::path();
}

std::vector<Layer> parse_layers(const std::string& text) {
  std::vector<Layer> layers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string name = text.substr(begin, end - begin);
    const auto found = std::ranges::find(kLayerNames, name);
    if (found == kLayerNames.end()) {
      throw UsageError(fmt::format("--outputs {}: {:?} is none of {}", text, name,
                                   fmt::join(kLayerNames, ", ")));
    }
    const auto layer = static_cast<Layer>(found - kLayerNames.begin());
    if (std::ranges::find(layers, layer) != layers.end()) {
      throw UsageError(fmt::format("--outputs {}: {:?} stands there twice", text, name));
    }
    layers.push_back(layer);
    begin = end + 1;
  }
  return layers;
}

bool is_jpeg(const fs::path& path) {
  return path.extension() == ".jpg" || path.extension() == ".jpeg";
}

draw::IdNames class_names(const SceneOptions& options) {
  const fs::path file = find_text_file(data_folder(options) / "labels/mpcat40.tsv");
  return fs::exists(file) ? draw::load_class_names(file) : draw::IdNames();
}

std::string as_text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

void add_viewpoint_arguments(CLI::App& verb, std::string& scan, std::string& viewpoint) {
  add_value(verb, "scan", scan, "SCAN", "Scan id")->required();
  add_value(verb, "viewpoint", viewpoint, "VIEWPOINT",
            "Index, id, or the unique beginning of an id")
      ->required();
}

void add_place_options(CLI::App& verb, SceneOptions& options) {
  add_value(verb, "--images", options.images, "DIR",
            "Folder of stores or Matterport3D's scans (folders, zips); may be repeated (default: "
            "those of the data set)")
      ->allow_extra_args(false);
  add_value(verb, "--connectivity", options.connectivity, "DIR",
            "Folder of SCAN_connectivity.json, for loose files (default: that of the data set)");
  add_data_option(verb, options.data);
}

void add_angle_option(CLI::App& verb, const char* name, double& degrees, const char* help) {
  add_setting(verb, name, degrees, "DEG", help, finite_number(-1e6));
}

void add_field_of_view_option(CLI::App& verb, double& degrees) {
  add_setting(verb, "--vfov", degrees, "DEG", "Vertical field of view, degrees", finite_number());
}

void validate_field_of_view(double degrees) {
  if (degrees > 0 && degrees < 180) return;
  throw UsageError(
      fmt::format("--vfov {}: more than 0 and less than 180 degrees are allowed", degrees));
}

void add_renderer_options(CLI::App& verb, SceneOptions& options) {
  add_setting(verb, "--backend", options.backend, "NAME",
              "Back end: cpu, cpu-scalar (slow reference), gl or cuda (NVIDIA)",
              CLI::IsMember({"cpu", "cpu-scalar", "gl", "cuda"}));
  add_value(verb, "--gl-device", options.gl_device, "NAME",
            "Index or UUID of an EGL device, as enfilade doctor lists them (default: the "
            "first that works)");
  add_value(verb, "--cuda-device", options.cuda_device, "N",
            "Number of a card, as enfilade doctor lists them (default: 0)");
  add_setting(verb, "--cache", options.cache, "NAME",
              "Cache of decoded pictures: the process's, or shared in /dev/shm",
              CLI::IsMember({"private", "shared"}));
  add_whole_number(verb, "--cache-mib", options.cache_mib,
                   "Size of a shared cache, MiB; equal for all its processes");
  verb.add_flag("--legacy", options.legacy,
                "Draw as MatterSim: seams between faces, depth in steps of 64 mm");
}

dataset::Dataset open_scene(const SceneOptions& options, const std::string& scan) {
  const fs::path folder = data_folder(options);
  if (folder.empty() && options.images.empty()) {
    throw UsageError(
        "no panoramas: give --images DIR (a folder of stores, or of Matterport3D's scans), or "
        "--data DIR or ENFILADE_DATA with a data set that has some");
  }
  dataset::DatasetConfig config{
      folder, options.connectivity, {options.images.begin(), options.images.end()}, {scan}};
  if (options.cache == "shared") {
    config.shared_cache.emplace().bytes = options.cache_mib << 20U;
  }
  dataset::Dataset data(std::move(config));
  try {
    (void)source_of(data);
  } catch (const FileError& error) {
    if (!data.panorama_places().connectivity.empty()) throw;
    throw FileError(
        fmt::format("{}; loose files need --connectivity DIR, or a data set that has "
                    "it, for their poses",
                    error.what()));
  }
  return data;
}

const scan::PanoramaSource& source_of(const dataset::Dataset& scene) {
  return scene.panoramas()->source(ScanIndex());
}

std::unique_ptr<render::Renderer> make_renderer(const dataset::Dataset& scene,
                                                const SceneOptions& options) {
  const std::optional<render::Backend> backend = find_enum<render::Backend>(options.backend);
  if (!backend) throw UsageError(fmt::format("--backend {}: there is none", options.backend));
  return render::make_renderer(scene.faces(), {.backend = *backend,
                                               .legacy = {options.legacy, options.legacy},
                                               .gl_device = options.gl_device,
                                               .cuda_device = options.cuda_device});
}

ViewpointIndex find_viewpoint(const scan::PanoramaSource& source, const std::string& text) {
  if (const auto v = source.find(text)) return *v;
  if (const auto number = parse_number<std::uint32_t>(text); number && *number < source.size()) {
    return ViewpointIndex(*number);
  }
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < source.size() && !text.empty(); ++i) {
    if (source.poses()[i].viewpoint.starts_with(text)) found.push_back(i);
  }
  if (found.size() == 1) return ViewpointIndex(found[0]);
  if (found.empty()) {
    throw LookupError(fmt::format(
        "viewpoint {:?}: scan {} has none whose id begins so; an id, the beginning of one, or an "
        "index below {} is expected",
        text, source.scan(), source.size()));
  }
  throw LookupError(fmt::format("viewpoint {:?}: {} of scan {} begin so: {}, {}{}", text,
                                found.size(), source.scan(), source.poses()[found[0]].viewpoint,
                                source.poses()[found[1]].viewpoint,
                                found.size() > 2 ? ", ..." : ""));
}

Size parse_size(const std::string& option, const std::string& text) {
  const std::size_t x = std::min(text.find('x'), text.size());
  const std::string_view all = text;
  const auto width = parse_number<std::uint32_t>(all.substr(0, x));
  const auto height = parse_number<std::uint32_t>(all.substr(std::min(x + 1, all.size())));
  constexpr std::uint32_t kMost = 16384;  // a gigabyte of colour and depth
  if (!width || !height || *width == 0 || *height == 0 || *width > kMost || *height > kMost) {
    throw UsageError(
        fmt::format("{} {:?}: WIDTHxHEIGHT in pixels is expected, such as 640x480, "
                    "each from 1 to {}",
                    option, text, kMost));
  }
  return {*width, *height};
}

void add_output_options(CLI::App& verb, OutputOptions& options, const std::string& default_file) {
  options.file = default_file;
  add_setting(verb, "--outputs", options.outputs, "LIST",
              "Layers, comma-separated: rgb, depth, class, instance");
  add_setting(verb, "-o,--output", options.file, "FILE",
              "PNG or JPEG; further layers as NAME-depth.png; - for standard output");
  verb.add_flag("--raw", options.raw,
                "Write PNGs of values instead of colours (docs/command_line.md)");
}

std::vector<PictureFile> picture_files(const OutputOptions& options) {
  const std::vector<Layer> layers = parse_layers(options.outputs);
  const fs::path path = options.file;
  if (options.file == "-") {
    if (layers.size() > 1) throw UsageError("-o -: standard output takes one of the --outputs");
    return {{layers[0], "-"}};
  }
  if (path.extension() != ".png" && !is_jpeg(path)) {
    throw UsageError(
        fmt::format("-o {}: a name that ends in .png, .jpg or .jpeg is expected", options.file));
  }
  const bool values = std::ranges::any_of(layers, [](Layer l) { return l != Layer::kColour; });
  if (options.raw && values && is_jpeg(path)) {
    throw UsageError(
        fmt::format("-o {}: --raw needs a .png: JPEG cannot keep values", options.file));
  }
  std::vector<PictureFile> files;
  for (const Layer layer : layers) {
    fs::path own = path;
    if (layers.size() > 1 && layer != Layer::kColour) {
      own.replace_filename(
          fmt::format("{}-{}{}", path.stem().string(), name_of(layer), path.extension().string()));
    }
    files.push_back({layer, own.string()});
  }
  return files;
}

void require_layers(const scan::PanoramaSource& source, ViewpointIndex viewpoint,
                    const std::vector<PictureFile>& files) {
  const scan::FaceSizes sizes = source.face_sizes(viewpoint);
  std::vector<std::string_view> known;
  for (std::size_t i = 0; i < scan::kLayers; ++i) {
    if (sizes[i] > 0) known.push_back(kLayerNames[i]);
  }
  for (const PictureFile& file : files) {
    if (sizes[index(file.layer)] > 0) continue;
    throw LookupError(
        fmt::format("--outputs {}: {}\nthis panorama has {}", name_of(file.layer),
                    source.lacks(file.layer, viewpoint).what(),
                    known.empty() ? "no pictures" : fmt::format("{}", fmt::join(known, ", "))));
  }
}

render::Outputs outputs_into(Drawn& drawn, const std::vector<PictureFile>& files, Size size,
                             std::size_t views) {
  scan::LayerMask layers = 0;
  for (const PictureFile& file : files) layers |= scan::mask_of(file.layer);
  return render::outputs_into(drawn, layers, size.width, size.height, views);
}

draw::LayerColours colours_of(const Drawn& drawn, const SceneOptions& options) {
  return draw::LayerColours(drawn,
                            drawn.classes.pixels.empty() ? draw::IdNames() : class_names(options));
}

std::string encode(const image::Image8& picture, const std::string& path) {
  // At this quality a picture and its JPEG look the same side by side.
  constexpr int kQuality = 92;
  return as_text(is_jpeg(path) ? image::encode_jpeg(picture, kQuality, true)
                               : image::encode_png(picture));
}

std::string encode_raw(const Drawn& drawn, Layer layer) {
  switch (layer) {
    case Layer::kColour:
      return as_text(image::encode_png(drawn.colour));
    case Layer::kDepth:
      return as_text(image::encode_png(drawn.depth));
    case Layer::kClass:
      return as_text(image::encode_png(drawn.classes));
    case Layer::kInstance:
      return as_text(image::encode_ids(drawn.instances));
  }
  return {};
}

void write_picture(const std::string& path, const std::string& content) {
  write_output(path, content);
  if (path != "-") say("{}\n", path);
}

void write_pictures(const Drawn& drawn, const std::vector<PictureFile>& files,
                    const OutputOptions& output, const SceneOptions& scene) {
  const draw::LayerColours palette = colours_of(drawn, scene);
  for (const PictureFile& file : files) {
    const bool as_values = output.raw && !is_jpeg(file.path);
    write_picture(file.path,
                  as_values
                      ? encode_raw(drawn, file.layer)
                      : encode(palette.with_legend(palette.coloured(drawn, file.layer), file.layer),
                               file.path));
  }
}

}  // namespace enfilade::apps
