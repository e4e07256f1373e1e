#include "tests/paths/writers.h"

namespace enfilade::tests {

const std::vector<DirectWriter>& direct_writers() {
  static constexpr const char* kUser = "the user names the file";
  static constexpr const char* kCaller = "the caller names the file";
  static constexpr const char* kFixed = "names that are fixed, in a folder that the user names";
  static const std::vector<DirectWriter> kRows{
      {"apps/common/program.cpp", kUser},
      {"apps/enfilade/export.cpp", kUser},
      {"apps/enfilade/learning/train.cpp", "lines that are drawn over; the name is printable()"},
      {"apps/enfilade/r4r.cpp", kUser},
      {"enfilade/arena/ask.cpp", kFixed},
      {"enfilade/arena/play.cpp", kFixed},
      {"enfilade/arena/play.h", kFixed},
      {"enfilade/continuous/navigation_file.cpp", kCaller},
      {"enfilade/continuous/scene.cpp", kCaller},
      {"enfilade/exports/detail/scan_parts.cpp", "removes the folder beside a file, and no link"},
      {"enfilade/features/formats/feature_rows.cpp", kCaller},
      {"enfilade/features/formats/feature_tsv.cpp", kCaller},
      {"enfilade/features/hdf5_writer.cpp", kCaller},
      {"enfilade/features/tensor_file.cpp", kCaller},
      {"enfilade/image/save.cpp", kCaller},
      {"enfilade/mesh/write_mesh.cpp", kCaller},
      {"enfilade/models/detail/event_file.cpp", "appends, and follows no link"},
      {"enfilade/models/model_directory.cpp", kFixed},
      {"enfilade/models/training_log.cpp", "removes what it finds in the folder itself"},
      {"enfilade/neural/released_weights.cpp", kFixed},
      {"enfilade/neural/train.cpp", kFixed},
      {"enfilade/render/detail/shared_file.cpp", "shared memory, in a folder of the user's own"},
      {"enfilade/scan/detail/store_format.h", kCaller},
      {"enfilade/scan/file_tree.cpp", "fopen() to read"},
      {"enfilade/service/store/sqlite.cpp", kUser},
      {"enfilade/tasks/tokenizer.cpp", kCaller},
      {"python/enfilade/_lerobot.py", "whole_file() gives the paths; removes parts of fixed names"},
      {"python/enfilade/_output.py", "OutputFolder of Python"},
      {"python/enfilade/cluster.py", "names are numbers, in a folder that the user names"},
      {"python/enfilade/exports.py", "removes a folder of a fixed name, and no link"},
      {"python/enfilade/features.py", kUser},
      {"python/enfilade/stores.py", "the store's side; whole_file() gives the path of ours"},
  };
  return kRows;
}

}  // namespace enfilade::tests
