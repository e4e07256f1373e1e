/// \file  PanoramaSource: the panoramas of one scan, from files, a store or memory.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/ids.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/image/image.h"
#include "enfilade/image/jpeg_rows.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::scan {

/// Kinds of pixel data in a panorama.
enum class Layer : std::uint8_t {
  kColour,    ///< RGB, 8 bit
  kDepth,     ///< distance from the eye (along the ray), quarter millimetres, 16 bit; 0: unknown
  kClass,     ///< object class, 16 bit; 0: none
  kInstance,  ///< object instance, 32 bit; 0: none
};
/// How many layers there are.
inline constexpr std::size_t kLayers = 4;
/// Index of a layer, from 0 in the order above.
constexpr std::size_t index(Layer layer) { return static_cast<std::size_t>(layer); }
std::string_view to_string(Layer layer);  ///< "colour", "depth", "class", "instance"

/// Bytes of a face of a layer in cells (image/face_cells.h). \param size texels along an edge
std::size_t cells_bytes(Layer layer, std::uint32_t size) noexcept;

/// Units of Layer::kDepth per metre: 4000.
using image::kDepthUnitsPerMetre;

/// Edge lengths of a panorama's faces in texels, by index(Layer); 0: it lacks the layer.
using FaceSizes = std::array<std::uint32_t, kLayers>;

/// Layers as bits 1 << index(Layer).
using LayerMask = std::uint8_t;
inline constexpr LayerMask kAllLayers = 15;
constexpr LayerMask mask_of(Layer layer) { return static_cast<LayerMask>(1U << index(layer)); }

/// Faces as bits 1 << index(CubeFace).
using FaceMask = std::uint8_t;
inline constexpr FaceMask kAllFaces = 63;

/// Where faces are written, by index(CubeFace): colour with its border, the others as n x n values
/// in rows.
using ColourFaces = std::array<image::ColourCells, kCubeFaces>;
using Faces16 = std::array<std::uint16_t*, kCubeFaces>;
using Faces32 = std::array<std::uint32_t*, kCubeFaces>;
using FaceBuffers = std::variant<ColourFaces, Faces16, Faces32>;

/// Pose of the panorama of a viewpoint.
struct PanoramaPose {
  std::string viewpoint;      ///< id
  Mat3d world_from_panorama;  ///< a rotation
  Vec3d position;             ///< metres, world frame
  bool included = true;       ///< part of the navigation graph; if not, it may have no pictures
};

/// The panoramas of one scan. Implementations: files as downloaded (open_matterport_images()),
/// Store (one packed file), MemoryPanoramas. All functions may be called from any thread at once.
class PanoramaSource {
 public:
  virtual ~PanoramaSource() = default;
  PanoramaSource(const PanoramaSource&) = delete;
  PanoramaSource& operator=(const PanoramaSource&) = delete;

  const std::string& scan() const noexcept { return scan_; }
  /// Where the pictures come from (a folder, a file, "<memory>"), for messages.
  const std::string& origin() const noexcept { return origin_; }
  std::size_t size() const noexcept { return poses_.size(); }  ///< viewpoints, excluded ones too
  const std::vector<PanoramaPose>& poses() const noexcept { return poses_; }  ///< by ViewpointIndex
  /// By id; no value if the scan has no such viewpoint.
  std::optional<ViewpointIndex> find(std::string_view viewpoint) const;
  /// As find(). \throws LookupError naming scan, viewpoint and origin
  ViewpointIndex at(std::string_view viewpoint) const;

  /// The scan's navigation graph as in its connectivity file. \throws FileError, InvalidInput
  virtual Connectivity connectivity() const = 0;

  /// Size of each layer of the panorama; all 0 if it has no pictures. Reads headers only.
  /// \pre viewpoint < size() (here and below)
  /// \throws FileError, InvalidInput
  virtual FaceSizes face_sizes(ViewpointIndex viewpoint) const = 0;

  /// True if reading one face takes as long as reading all six, as from a strip: callers then ask
  /// for all at once.
  virtual bool reads_whole_panoramas() const noexcept { return false; }

  /// Decodes the faces in `wanted` into buffers[index(face)], borders included; the others are not
  /// touched. \pre buffers have the size of face_sizes()
  /// \throws LookupError if the panorama lacks the layer: lacks(); FileError; InvalidInput naming
  /// file, scan and viewpoint for broken ones
  void read_colour(ViewpointIndex viewpoint, FaceMask wanted, const ColourFaces& buffers) const {
    read(Layer::kColour, viewpoint, wanted, buffers);
  }
  /// Whether rows of a colour face can be decoded in about their share of the face's time.
  virtual bool reads_rows(ViewpointIndex /*viewpoint*/, CubeFace /*face*/) const { return false; }
  /// Decodes rows of a colour face and the border that image::write_border_rows() gives them; the
  /// rest is not touched. Threads may decode different rows of a face at the same time.
  /// \pre reads_rows(); rows.begin < rows.end <= size; the buffer has the size of face_sizes()
  /// \throws as read_colour()
  virtual void read_colour_rows(ViewpointIndex viewpoint, CubeFace face, image::RowRange rows,
                                const image::ColourCells& buffer) const;
  /// Depth or class: n x n values per face, row-major, no border. \throws as read_colour()
  void read_16(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
               const Faces16& buffers) const;
  /// Instances, likewise.
  void read_instances(ViewpointIndex viewpoint, FaceMask wanted, const Faces32& buffers) const {
    read(Layer::kInstance, viewpoint, wanted, buffers);
  }

  /// The paths that are tried for the layer of a panorama, in the form that follows "no colour" in
  /// messages. That is " in <origin>", or "; tried:" and the files, one per line, existing or not.
  virtual std::string tried(Layer layer, ViewpointIndex viewpoint) const;
  /// The error that the read functions throw if the panorama lacks the layer: names scan,
  /// viewpoint, layer and tried().
  LookupError lacks(Layer layer, ViewpointIndex viewpoint) const;

  /// The colour faces as JPEG files, by index(CubeFace). No value if the source would have to
  /// encode them. \throws as read_colour()
  virtual std::optional<std::array<std::string, kCubeFaces>> colour_jpegs(
      ViewpointIndex viewpoint) const;

  /// Whether the source has the faces of a layer in memory in the renderer's layout. Then cells()
  /// needs no decoding.
  virtual bool has_cells(Layer /*layer*/, ViewpointIndex /*viewpoint*/) const { return false; }
  /// A face in cells (image/face_cells.h), aligned to 64 bytes; the 16 bytes after it can be read,
  /// too. Valid as long as the source. \pre has_cells()  \throws as read_colour()
  virtual const std::uint8_t* cells(Layer layer, ViewpointIndex viewpoint, CubeFace face) const;

  /// Hints that this viewpoint's pictures will not be read again soon. A source that maps its file
  /// gives their memory back to the system; others do nothing. The content stays the same, also for
  /// threads that are reading. Without it, all that was ever read may stay resident.
  virtual void release(ViewpointIndex /*viewpoint*/) const {}

  /// A text that changes when the pictures do, as far as can be found out quickly: for instance
  /// names, sizes and times of files. Empty if unknown; pack() then starts again instead of
  /// continuing an earlier run or keeping a complete store. \throws FileError
  virtual std::string state() const;

 protected:
  PanoramaSource(std::string scan, std::string origin, std::vector<PanoramaPose> poses);

 private:
  /// Reads one layer; `buffers` holds the kind that the layer needs. \throws as read_colour()
  virtual void read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
                    const FaceBuffers& buffers) const = 0;

  std::string scan_, origin_;
  std::vector<PanoramaPose> poses_;
  std::unordered_map<std::string_view, ViewpointIndex> by_id_;
};

/// The poses in a connectivity file. \throws InvalidInput, naming the JSON path, if a pose's 3 x 3
/// part is not a rotation. The tolerance is 1e-3, as files round numbers to 6 digits.
std::vector<PanoramaPose> poses_of(const Connectivity& connectivity);

/// A whole panorama in memory. Missing layers are empty pictures.
struct Panorama {
  image::CubeMap<std::uint8_t> colour;      ///< 3 channels
  image::CubeMap<std::uint16_t> depth;      ///< 1 channel; as Layer::kDepth (here and below)
  image::CubeMap<std::uint16_t> classes;    ///< 1 channel
  image::CubeMap<std::uint32_t> instances;  ///< 1 channel

  FaceSizes sizes() const noexcept;
  /// Copies faces of a layer, as PanoramaSource's read functions do. \pre it has the layer; buffers
  /// have its size and type
  void copy_to(Layer layer, FaceMask wanted, const FaceBuffers& buffers) const;
};

/// A panorama with all four layers, size x size texels a face, all values 0.
Panorama make_panorama(std::uint32_t size);

/// Reads the layers in `layers` that the panorama has. \throws as the read functions
Panorama read_panorama(const PanoramaSource& source, ViewpointIndex viewpoint,
                       LayerMask layers = kAllLayers);

/// Panoramas in memory, for instance generated ones. Immutable.
class MemoryPanoramas final : public PanoramaSource {
 public:
  /// \param panoramas by ViewpointIndex, as connectivity.entries
  /// \throws ArgumentError unless each entry has a panorama; for faces of a layer that are not
  /// square, differ in size, or have other channels than Panorama
  /// \throws InvalidInput as poses_of()
  MemoryPanoramas(Connectivity connectivity, std::vector<Panorama> panoramas);
  Connectivity connectivity() const override { return connectivity_; }
  FaceSizes face_sizes(ViewpointIndex viewpoint) const override;
  std::string state() const override;  ///< a checksum of all pixels

 private:
  void read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
            const FaceBuffers& buffers) const override;

  Connectivity connectivity_;
  std::vector<Panorama> panoramas_;
};

}  // namespace enfilade::scan
