/// \file  A data set of synthetic homes: buildings, graphs, panoramas, Room-to-Room.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/capture/scan_files.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/progress.h"
#include "enfilade/draw/plan_underlay.h"
#include "enfilade/homes/plan.h"
#include "enfilade/mesh/lighting.h"

namespace enfilade::homes {

/// How finely the light of pictures is computed.
enum class HomeLight : std::uint8_t {
  kFine,    ///< points 0.3 m apart, nearer at shadows: pictures for people
  kCoarse,  ///< points 1 m apart, few rays: a quarter of the time, for pictures to learn from
};
/// Their names: core/enum_names.h.
constexpr std::array<std::string_view, 2> names_of(HomeLight /*enum*/) {
  return {"fine", "coarse"};
}
HomeLight parse_home_light(std::string_view name);  ///< \throws ArgumentError

/// How the light of a home is computed so finely. \param threads 0: all cores; changes no light
mesh::BakeOptions bake_options(HomeLight light, int threads);

/// Which homes are made, and which files of them.
struct HomeSetOptions {
  std::size_t homes = 16;
  std::uint64_t seed = 1;
  std::optional<HomeKind> kind;          ///< no value: a mixture, most of them houses
  double least_area = 0, most_area = 0;  ///< m2, drawn between; 0: as usual for the kind.
  /// One home in this many is a house or an office of two storeys and 170 m2, for any areas, unless
  /// `kind` has no stairs. 0: storeys as usual for kind and area.
  std::size_t stairs_every = 0;
  std::uint32_t face_size = 256;  ///< texels of a panorama's faces; 0: no pictures
  std::uint32_t samples = 4;      ///< colour rays per texel
  int jpeg_quality = 92;
  HomeLight light = HomeLight::kFine;  ///< of panoramas; those of `parts` have the finest.
  /// Number of homes rendered at display quality, whatever the options above: fine light, faces of
  /// kPrettyFaceSize texels, kPrettySamples rays per texel; see pretty_homes(). None if face_size
  /// is 0. At most `homes`
  std::size_t pretty = 0;

  // Options of one run: a later run of the same set may have others.
  /// Folder of `<scan>_corrections.json` (graph/corrections.h), applied on top of the graphs, also
  /// of homes that are there already; empty: none, and none stay applied.
  std::filesystem::path corrections;
  /// Matterport3D's files of each home too, below `v1/scans/<scan>`, also of homes that are there.
  capture::ScanParts parts{.connectivity = false};
  std::uint32_t image_width = 1280;  ///< of undistorted images among them, pixels
  Shard shard;
  int threads = 0;  ///< 0: all cores; the files are the same for any number
};

/// Texels along a face, and colour rays per texel, of HomeSetOptions::pretty.
inline constexpr std::uint32_t kPrettyFaceSize = 256;
inline constexpr std::uint32_t kPrettySamples = 4;  ///< see kPrettyFaceSize.
/// The scans that HomeSetOptions::pretty renders at display quality, ascending. First those that
/// write_home_paths() with the set's seed puts into val_unseen, as reports show these, then
/// train's, then test's.
std::vector<std::string> pretty_homes(const HomeSetOptions& options);

/// Options by name.
/// - "small": 2 homes of a few viewpoints, for tests
/// - "pretty": 16 homes of 25 to 50 viewpoints, three of them with two storeys, all at display
///   quality
/// - "demo": 60 homes of 25 to 50 viewpoints, every eighth with two storeys, as in "training"
///   except three at display quality
/// - "full": 90 homes of 117 viewpoints on average, faces of 512 texels
/// - "graphs": 6 homes like those of "pretty" but without pictures, made in a second or two
/// - "training": 96 homes for training only: faces of 64 texels, one ray per texel, coarse light
///
/// \throws ArgumentError for another name
HomeSetOptions home_set_preset(std::string_view name);
std::vector<std::string> home_set_presets();

/// A room of a home in a list.
struct RoomEntry {
  char type = '-';  ///< Matterport3D's region letter
  std::string name;
  unsigned storey = 0;
  /// Inner faces of its walls; world, metres. Empty where the list has none, see completed().
  Rect floor;
  double elevation = 0;                 ///< z of its floor; world, metres
  std::vector<std::string> viewpoints;  ///< ids of those in the room
};

/// One home as the folder's list has it.
struct HomeEntry {
  std::string scan;  ///< "home0001", ...
  PlanOptions plan;  ///< gives make_home() the same home again
  std::string kind;
  std::size_t viewpoints = 0, edges = 0;  ///< of its graph
  std::size_t triangles = 0;              ///< of its mesh
  std::vector<RoomEntry> rooms;           ///< in the plan's order: a room's index is its region.
  /// Walls, doors, windows, stairs and furniture of each storey of its graph; world, metres, to the
  /// millimetre; z is 0, and there are no texts. No storeys: the list has none, see completed().
  draw::PlanUnderlay lines;
  std::string corrections;  ///< checksum of the corrections in its graph; empty: none
};

/// Result of write_homes().
struct HomeSetReport {
  std::vector<HomeEntry> homes;   ///< of the shard, in their order
  std::vector<Diagnostic> notes;  ///< warnings: corrections that change nothing
};

/// Called with the current work, and how many steps of all are done.
using SetProgress =
    std::function<void(const std::string& what, std::size_t done, std::size_t total)>;

/// Makes a data set of homes, or completes one: `connectivity/`, `regions/region_to_panorama.json`,
/// `store/<scan>.enfilade` (packed panoramas), `homes.json` (the list) and a README.md that calls
/// it synthetic. Homes that are complete and have the same options are kept, so a killed run can be
/// continued. The same options and corrections give the same bytes. Paths and instructions are
/// written by write_home_paths().
///
/// Runs of different shards may write to the folder at the same time. Afterwards one run of the
/// whole set makes the missing homes, and the list. Homes that were made before an error are kept.
/// \throws FileError if the folder holds other files, or homes of other options (naming the first
/// that differs)
/// \throws ArgumentError for options out of range
/// \throws NoPlan naming the home (choose another seed or area for the set)
/// \throws InvalidInput for a broken list or broken corrections
HomeSetReport write_homes(const std::filesystem::path& folder, const HomeSetOptions& options,
                          const SetProgress& progress = {});

/// The scans that enlarge_pictures() would work on, in the list's order. Reads no picture.
/// \throws FileError; InvalidInput for a broken list or store
std::vector<std::string> scans_to_enlarge(const std::filesystem::path& folder,
                                          std::uint32_t face_size);
/// Makes the pictures of a folder's homes again with larger faces, home by home. In a set with
/// pretty homes it makes theirs alone, as the others are for training. Light and rays per texel are
/// those of the folder's options, which stay in its list: a store says its own size. Each store is
/// replaced by a rename, so that readers find the old one or the new, and those that have it open
/// keep it. A killed call is continued by the next. Stores of such faces or larger ones stay, and
/// homes without pictures are left without.
/// \param threads 0: all cores; the files are the same for any number
/// \returns the scans whose stores were replaced
/// \throws ArgumentError for a face size not from 1 to 4096
/// \throws FileError also if this version makes another home of the options, or another process is
/// at the same work
/// \throws InvalidInput for a broken list or store
std::vector<std::string> enlarge_pictures(const std::filesystem::path& folder,
                                          std::uint32_t face_size, int threads,
                                          const SetProgress& progress = {});

/// The options that the homes of a folder were made with. \throws FileError, InvalidInput
HomeSetOptions read_home_options(const std::filesystem::path& folder);

/// The list of a folder. \throws FileError, InvalidInput
std::vector<HomeEntry> read_home_list(const std::filesystem::path& folder);

/// An entry of the folder's list with its lines and its rooms' floors. Lists of earlier versions
/// lack them; then the home is made again, in less than a second.
/// \throws FileError if the home made now has another number of triangles than in the list: its
/// lines would not fit the graph
/// \throws as make_home(), scan::load_connectivity()
HomeEntry completed(HomeEntry home, const std::filesystem::path& folder);

/// Fewer cannot be split by building into train, val_unseen and test.
inline constexpr std::size_t kLeastHomes = 3;

/// Benchmarks that a set of homes can have beside Room-to-Room, by the names of their folders:
/// "r2r-last", "r2r-back", "r4r", "fgr2r", "rxr", "reverie", "cvdn", "soon".
std::vector<std::string> home_tasks();

/// How many paths are drawn, and how they are split.
struct HomePathOptions {
  std::size_t per_home = 60;  ///< paths, at most
  std::uint64_t seed = 1;
  double val_seen_share = 0.15;
  /// Without a test split, whose goals are hidden, two homes are enough: one for train and
  /// val_seen, one for val_unseen.
  bool test_split = true;
  /// Written beside Room-to-Room, of home_tasks(); "r2r" may be named, too.
  std::vector<std::string> tasks = home_tasks();
  int threads = 0;
};
/// Counts of the written files.
struct HomePathReport {
  std::size_t paths = 0, instructions = 0;
};
/// Writes annotations for a folder of homes. Graphs are read from the folder, so corrections made
/// there count.
/// - `r2r/R2R_<split>.json`: Room-to-Room's train, val_seen, val_unseen and test, split by building
///   in the paper's proportions. Each path has three instructions, one by each speaker.
/// - `hidden/R2R_test.json`: the test paths with their goals.
/// - The other benchmarks' annotations of the same paths, in the forms and under the names that
///   tasks::episode_places() lists. Each folder has a README.md that calls it synthetic.
/// - `hidden/<task>/`: the whole test splits of those benchmarks.
/// - `annotations.txt`: the files that were written. Files that an earlier call listed and this one
///   does not write are removed.
/// \throws ArgumentError for an unknown task
/// \throws FileError if there are fewer homes than the splits need or the splits cannot be written
/// \throws as read_home_list(), graph::GraphSet
HomePathReport write_home_paths(const std::filesystem::path& folder, const HomePathOptions& options,
                                const SetProgress& progress = {});

}  // namespace enfilade::homes
