#include "enfilade/capture/scan_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <system_error>
#include <type_traits>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/capture.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/segmentation.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/matterport_images.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::capture {
namespace {

namespace fs = std::filesystem;
using scan::Layer;
using scan::PanoramaPose;
using scan::RigCamera;

constexpr const char* kManifest = "enfilade_scan.json";
// Must change whenever the same mesh and options give other pictures.
constexpr int kGeneration = 1;

void validate(const scan::Connectivity& connectivity, const ScanFilesOptions& o) {
  const auto check = [](bool good, const std::string& message) {
    if (!good) throw ArgumentError(message);
  };
  check(is_id(connectivity.scan), fmt::format("scan {}", fault_of_id(connectivity.scan)));
  for (const scan::ConnectivityEntry& entry : connectivity.entries) {
    check(is_id(entry.id),
          fmt::format("scan {}: viewpoint {}", connectivity.scan, fault_of_id(entry.id)));
  }
  check_range("face_size", o.face_size, 1, 8192);
  check_range("image_width", o.image_width, 10, 8192);
  check(o.samples == 1 || o.samples == 4 || o.samples == 9 || o.samples == 16,
        fmt::format("samples: {}, not 1, 4, 9 or 16", o.samples));
  check_range("jpeg_quality", o.jpeg_quality, 1, 100);
}

// --- what pictures were made of -------------------------------------------------------------

/// A checksum of everything that pictures depend on.
class State {
 public:
  template <class T>
  void add(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    mix(values.size());
    mix(stream_of(reinterpret_cast<const char*>(values.data()), values.size_bytes()));
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::span<const T>(values));
  }
  template <class T>
  void add_value(const T& value) {
    add(std::span<const T>(&value, 1));
  }
  void add(const mesh::LitMesh& lit) {
    add(lit.mesh());
    const mesh::Lights& lights = lit.lights();
    add_value(lights.sky);
    add_value(lights.sun);
    add(lights.lamps);
    add(lights.portals);
  }
  std::string text() const { return fmt::format("{:016x}", value_); }

 private:
  void add(const mesh::Mesh& mesh) {
    add(mesh.positions);
    add(mesh.triangles);
    add(mesh.triangle_material);
    add(mesh.triangle_object);
    add(mesh.texture_points);
    add(mesh.normals);
    add(mesh.colours);
    for (const mesh::Material& m : mesh.materials) {
      add_value(m.colour);
      add_value(m.emission);
      add_value(m.mirror);
      add_value(m.cutout);
      add_value(m.texture.width);
      add(m.texture.pixels);
    }
    for (const mesh::Object& object : mesh.objects) add_value(object.category);
  }
  void mix(std::uint64_t value) { value_ = Rng(value_, value).next(); }

  std::uint64_t value_ = kGeneration;
};

std::string state_of(const mesh::LitMesh& mesh, const ScanFilesOptions& o) {
  State state;
  state.add(mesh);
  if (o.label_mesh != nullptr) state.add(*o.label_mesh);
  state.add_value(o.face_size);
  state.add_value(o.image_width);
  state.add_value(o.samples);
  state.add_value(o.exposure);
  state.add_value(o.jpeg_quality);
  return state.text();
}

std::string state_of(const PanoramaPose& pose) {
  State state;
  // Numbers that are written to a file and read back are the same.
  state.add_value(pose.world_from_panorama.m);
  state.add_value(pose.position);
  return state.text();
}

/// The kind of a file: "matterport_skybox_images/skybox0_sami.jpg" for that face of any viewpoint,
/// else its folder.
std::string kind_of(const fs::path& file) {
  const std::string folder = file.parent_path().filename().string();
  const std::string name = file.filename().string();
  const std::size_t skybox = name.rfind("_skybox");
  return skybox == std::string::npos ? folder : folder + "/" + name.substr(skybox + 1);
}

/// Records what a folder's files were made from.
struct Manifest {
  std::string state;
  std::set<std::string> kinds;                    ///< kind_of(each file)
  std::map<std::string, std::string> viewpoints;  ///< id -> state_of(pose)
};

std::optional<Manifest> read_manifest(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(read_file(file));
    return Manifest{json.at("state").get<std::string>(),
                    json.at("kinds").get<std::set<std::string>>(),
                    json.at("viewpoints").get<std::map<std::string, std::string>>()};
  } catch (const nlohmann::json::exception& error) {
    refuse(file.string(), "", "bad-manifest",
           fmt::format("not a list that Enfilade wrote ({}); remove the folder if nothing in it is "
                       "wanted",
                       error.what()));
  }
}

std::string text_of(const Manifest& manifest) {
  const nlohmann::ordered_json json{
      {"made_by",
       "Enfilade, from a mesh: pictures here are of this state and are kept by another run"},
      {"state", manifest.state},
      {"kinds", manifest.kinds},
      {"viewpoints", manifest.viewpoints}};
  return json.dump(1) + "\n";
}

// --- pictures -------------------------------------------------------------------------------

/// Pictures that are taken together: all of their files, and how to make them.
struct Task {
  std::vector<std::string> files;                  ///< below the root of all scans
  std::size_t weight = 0;                          ///< for progress
  std::function<std::vector<std::string>()> make;  ///< what goes into the files
};

/// Files below the root, and what they hold.
using Texts = std::vector<std::pair<std::string, std::string>>;

std::string text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

std::string jpeg(const image::Image8& picture, int quality) {
  return text(image::encode_jpeg(picture, quality, quality >= image::kFullChromaQuality));
}

/// Of a scan, below the root.
std::string folder_of(const std::string& scan) { return "v1/scans/" + scan; }

/// Makes a scan's tasks, and the texts beside its pictures.
class ScanWriter {
 public:
  ScanWriter(const mesh::LitMesh& mesh, const scan::Connectivity& connectivity,
             const ScanFilesOptions& options)
      : mesh_(mesh),
        connectivity_(connectivity),
        folder_(folder_of(connectivity.scan) + "/"),
        o_(options) {
    for (PanoramaPose& pose : poses_of(connectivity)) {
      if (pose.included) poses_.push_back(std::move(pose));
    }
    capture_.samples = options.samples;
    capture_.exposure = options.exposure;
    capture_.threads = 1;
  }

  const std::vector<PanoramaPose>& poses() const { return poses_; }

  std::vector<Task> tasks() const {
    std::vector<Task> tasks;
    for (const PanoramaPose& pose : poses_) {
      if (o_.parts.faces || o_.parts.colour_strip) tasks.push_back(colour_task(pose));
      if (o_.parts.depth_strip) tasks.push_back(depth_task(pose));
      if (o_.parts.label_strips) tasks.push_back(label_task(pose));
      if (!o_.parts.undistorted) continue;
      for (const RigCamera& camera : scan::rig_cameras(pose, o_.image_width)) {
        tasks.push_back(camera_task(camera));
      }
    }
    return tasks;
  }

  /// Files that are small or quickly made, and their contents.
  Texts texts() const {
    Texts texts;
    if (o_.parts.undistorted) add_cameras(texts);
    if (o_.parts.house) add_house(texts);
    return texts;
  }

 private:
  std::string skybox() const { return folder_ + "matterport_skybox_images/"; }

  mesh::CubeCapture capture(const mesh::LitMesh& mesh, const PanoramaPose& pose,
                            Layer layer) const {
    mesh::CaptureOptions options = capture_;
    options.colour = layer == Layer::kColour;
    options.depth = layer == Layer::kDepth;
    options.labels = layer == Layer::kClass;
    return capture_cube(mesh, pose.world_from_panorama, pose.position, o_.face_size, options);
  }

  Task colour_task(const PanoramaPose& pose) const {
    std::vector<std::string> files;
    if (o_.parts.colour_strip) {
      files.push_back(skybox() + scan::skybox_strip_name(pose.viewpoint, Layer::kColour));
    }
    for (std::size_t k = 0; o_.parts.faces && k < kCubeFaces; ++k) {
      files.push_back(skybox() + scan::skybox_face_name(pose.viewpoint, k));
    }
    const auto make = [this, &pose] {
      std::vector<std::string> contents;
      const auto pictures = capture(mesh_, pose, Layer::kColour).colour;
      if (o_.parts.colour_strip) {
        contents.push_back(jpeg(image::join_strip(pictures), o_.jpeg_quality));
      }
      for (std::size_t k = 0; o_.parts.faces && k < kCubeFaces; ++k) {
        contents.push_back(jpeg(pictures[k], o_.jpeg_quality));
      }
      return contents;
    };
    return {std::move(files), kCubeFaces * o_.face_size * o_.face_size / 100 * o_.samples + 1,
            make};
  }

  Task depth_task(const PanoramaPose& pose) const {
    const auto make = [this, &pose] {
      const auto pictures = capture(mesh_, pose, Layer::kDepth).depth;
      return std::vector{text(image::encode_png(image::join_strip(pictures)))};
    };
    return {{skybox() + scan::skybox_strip_name(pose.viewpoint, Layer::kDepth)},
            kCubeFaces * o_.face_size * o_.face_size / 200 + 1,
            make};
  }

  Task label_task(const PanoramaPose& pose) const {
    const auto make = [this, &pose] {
      const mesh::LitMesh& mesh = o_.label_mesh != nullptr ? *o_.label_mesh : mesh_;
      const mesh::CubeCapture pictures = capture(mesh, pose, Layer::kClass);
      return std::vector{text(image::encode_png(image::join_strip(pictures.classes))),
                         text(image::encode_ids(image::join_strip(pictures.instances)))};
    };
    return {{skybox() + scan::skybox_strip_name(pose.viewpoint, Layer::kClass),
             skybox() + scan::skybox_strip_name(pose.viewpoint, Layer::kInstance)},
            kCubeFaces * o_.face_size * o_.face_size / 200 + 1,
            make};
  }

  Task camera_task(const RigCamera& c) const {
    const mesh::Pinhole pinhole{c.width,   c.height, c.fx, c.fy, c.cx, c.cy, c.world_from_camera,
                                c.position};
    const auto make = [this, pinhole] {
      mesh::CaptureOptions options = capture_;
      options.labels = false;
      const mesh::PinholeCapture pictures = capture_pinhole(mesh_, pinhole, options);
      return std::vector{jpeg(pictures.colour, o_.jpeg_quality),
                         text(image::encode_png(pictures.depth))};
    };
    return {{folder_ + "undistorted_color_images/" +
                 scan::colour_image_name(c.viewpoint, c.camera, c.yaw),
             folder_ + "undistorted_depth_images/" +
                 scan::depth_image_name(c.viewpoint, c.camera, c.yaw)},
            std::size_t{c.width} * c.height / 100 * o_.samples + 1,
            make};
  }

  void add_cameras(Texts& texts) const {
    std::vector<RigCamera> all;
    for (const PanoramaPose& pose : poses_) {
      const auto cameras = scan::rig_cameras(pose, o_.image_width);
      all.insert(all.end(), cameras.begin(), cameras.end());
      for (const RigCamera& c : cameras) {
        texts.emplace_back(folder_ + "matterport_camera_poses/" +
                               scan::camera_pose_name(c.viewpoint, c.camera, c.yaw),
                           scan::camera_pose_text(c));
        if (c.yaw != 0) continue;
        texts.emplace_back(folder_ + "matterport_camera_intrinsics/" +
                               scan::camera_intrinsics_name(c.viewpoint, c.camera),
                           scan::camera_intrinsics_text(c));
      }
    }
    texts.emplace_back(folder_ + "undistorted_camera_parameters/" + connectivity_.scan + ".conf",
                       scan::undistorted_cameras_text(all));
  }

  void add_house(Texts& texts) const {
    const HouseFiles files =
        make_house_files(mesh_.mesh(), connectivity_, o_.rooms, o_.image_width);
    const std::string folder = folder_ + "house_segmentations/";
    const std::string& scan = connectivity_.scan;
    texts.emplace_back(folder + scan + ".house", mesh::to_text(files.house));
    texts.emplace_back(folder + scan + ".ply", mesh::to_labelled_ply(files.labels));
    texts.emplace_back(folder + scan + ".fsegs.json",
                       mesh::face_segments_json(files.segments, scan));
    texts.emplace_back(folder + scan + ".semseg.json",
                       mesh::segment_groups_json(files.groups, scan));
    std::string regions;
    for (std::size_t k = 0; k < files.house.panoramas.size(); ++k) {
      const mesh::HousePanorama& p = files.house.panoramas[k];
      const char label =
          p.region < 0 ? '-' : files.house.regions[static_cast<std::size_t>(p.region)].label;
      regions += fmt::format("{} {} {} {}\n", k, p.name, p.region, label);
    }
    texts.emplace_back(folder + "panorama_to_region.txt", std::move(regions));
  }

  const mesh::LitMesh& mesh_;
  const scan::Connectivity& connectivity_;
  const std::string folder_;
  const ScanFilesOptions& o_;
  std::vector<PanoramaPose> poses_;
  mesh::CaptureOptions capture_;
};

// --- files ----------------------------------------------------------------------------------

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

[[noreturn]] void refuse_file(const fs::path& file, const std::string& why) {
  throw FileError(fmt::format(
      "{}: is in the way: {}; remove it or choose another folder or scan id", file.string(), why));
}

/// The folder's manifest, with the new files. \throws FileError if files there were made from
/// something else: a download must not be mixed with pictures of a mesh, or overwritten
Manifest joined(std::optional<Manifest> old, const fs::path& root, const fs::path& folder,
                const std::string& state, const std::vector<PanoramaPose>& poses,
                const std::vector<std::string>& files) {
  Manifest manifest = old ? *old : Manifest{state, {}, {}};
  if (manifest.state != state) {
    refuse_file(folder, "a scan made of another mesh or with other options");
  }
  for (const PanoramaPose& pose : poses) {
    const auto [place, is_new] = manifest.viewpoints.emplace(pose.viewpoint, state_of(pose));
    if (!is_new && place->second != state_of(pose)) {
      refuse_file(folder, fmt::format("its viewpoint {} stands elsewhere", pose.viewpoint));
    }
  }
  for (const std::string& file : files) {
    const bool is_new = !old || !old->kinds.contains(kind_of(file));
    if (is_new && is_there(root / file))
      refuse_file(root / file, "not made by Enfilade from a mesh");
    manifest.kinds.insert(kind_of(file));
  }
  return manifest;
}

/// Whole or not at all, as the folder is renamed when it is complete.
void write_mesh(const mesh::Mesh& mesh, const OutputFolder& out, const std::string& target,
                const std::string& name) {
  if (is_there(out.path() / target)) return;
  const std::string part = target + ".part";
  out.remove_all(part);
  mesh::write_obj(mesh, out.folder(part), name);
  mesh::write_glb(mesh, out.file(part + "/" + name + ".glb"));
  out.rename(part, target);
}

/// Runs tasks whose files are not all there.
void run(const std::vector<Task>& tasks, const OutputFolder& out, int threads,
         const Progress& progress, ScanFilesReport& report) {
  std::size_t total = 0, done = 0;
  for (const Task& task : tasks) total += task.weight;
  std::mutex mutex;
  parallel_for(tasks.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Task& task = tasks[i];
      const bool keep = std::ranges::all_of(
          task.files, [&](const std::string& file) { return is_there(out.path() / file); });
      std::uintmax_t bytes = 0;
      if (!keep) {
        const std::vector<std::string> contents = task.make();
        for (std::size_t k = 0; k < contents.size(); ++k) {
          out.write(task.files[k], contents[k]);
          bytes += contents[k].size();
        }
      }
      const std::lock_guard lock(mutex);
      (keep ? report.kept : report.written) += task.files.size();
      report.bytes += bytes;
      done += task.weight;
      if (progress) progress(done, total);
    }
  });
}

/// All files that are written, except for the mesh, whose folder's name depends on its content.
std::vector<std::string> all_files(const std::vector<Task>& tasks, const Texts& texts) {
  std::vector<std::string> files;
  for (const Task& task : tasks) files.insert(files.end(), task.files.begin(), task.files.end());
  for (const auto& [file, content] : texts) files.push_back(file);
  return files;
}

/// What killed runs left beside the files: of their kinds, as a user's own may be there.
void remove_left(const OutputFolder& out, const std::vector<std::string>& files) {
  std::set<std::pair<std::string, std::string>> kinds;
  for (const fs::path file : files) {
    kinds.emplace(file.parent_path().string(), file.extension().string());
  }
  for (const auto& [folder, ending] : kinds) out.remove_unfinished(folder, ending);
}

}  // namespace

std::vector<std::string> scan_part_names() {
  return {"skybox", "strips", "depth", "labels", "undistorted", "house", "mesh", "all"};
}

ScanParts scan_parts(const std::vector<std::string>& names) {
  const std::vector<std::string> known = scan_part_names();
  ScanParts parts;
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) == known.end()) {
      throw ArgumentError(fmt::format("part {:?}: none of {}", name, fmt::join(known, ", ")));
    }
    const bool all = name == "all", strips = all || name == "strips";
    parts.faces |= all || name == "skybox";
    parts.colour_strip |= strips;
    parts.depth_strip |= strips || name == "depth";
    parts.label_strips |= strips || name == "labels";
    parts.undistorted |= all || name == "undistorted";
    parts.house |= all || name == "house";
    parts.mesh |= all || name == "mesh";
  }
  return parts;
}

mesh::BakeOptions least_light() { return {.spacing = 100, .rays = 1, .bounces = 1}; }

std::unique_ptr<const mesh::LitMesh> read_label_mesh(const fs::path& house_segmentations,
                                                     const std::string& scan,
                                                     std::vector<Diagnostic>* warnings) {
  auto tracer = std::make_shared<const mesh::RayTracer>(std::make_shared<const mesh::Mesh>(
      mesh::read_house_mesh(house_segmentations, scan, warnings)));
  return std::make_unique<const mesh::LitMesh>(std::move(tracer), mesh::Lights{}, least_light());
}

ScanFilesReport write_scan(const mesh::LitMesh& mesh, const scan::Connectivity& connectivity,
                           const fs::path& root, const ScanFilesOptions& options,
                           const Progress& progress) {
  validate(connectivity, options);
  ScanFilesReport report;
  const std::string folder = folder_of(connectivity.scan);
  report.folder = root / folder;
  const ScanWriter writer(mesh, connectivity, options);
  const std::vector<Task> tasks = writer.tasks();
  const auto texts = writer.texts();
  const std::string state = state_of(mesh, options);
  const std::vector<std::string> files = all_files(tasks, texts);
  const fs::path manifest_file = report.folder / kManifest;
  std::vector<std::string> claimed = files;
  if (options.parts.connectivity) {
    claimed.push_back(scan::connectivity_file("connectivity", connectivity.scan).string());
  }
  const Manifest manifest =
      joined(read_manifest(manifest_file), root, report.folder, state, writer.poses(), claimed);
  if (options.parts.connectivity) scan::check_scan_list(root / "connectivity");
  const OutputFolder out(root);
  std::vector<std::string> written = claimed;
  written.push_back(folder + "/" + kManifest);
  if (options.parts.connectivity) written.emplace_back("connectivity/scans.txt");
  remove_left(out, written);
  out.write(folder + "/" + kManifest, text_of(manifest));
  if (options.parts.connectivity) save_connectivity(out.folder("connectivity"), connectivity);
  for (const auto& [file, content] : texts) {
    out.write(file, content);
    report.bytes += content.size();
  }
  if (options.parts.mesh) {
    // Matterport3D's are named by 32 digits.
    write_mesh(mesh.mesh(), out, folder + "/matterport_mesh/" + state + state, state + state);
  }
  report.viewpoints = writer.poses().size();
  run(tasks, out, options.threads, progress, report);
  return report;
}

}  // namespace enfilade::capture
