/// \file  Recorded passes and rollouts of published agents, compared with ours.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/features/tensor_file.h"

namespace enfilade::tests {

/// A folder of recordings, and the data set whose graphs and texts they speak of.
class AgentsFolder {
 public:
  /// \param device where networks compute, as neural::train() takes it
  AgentsFolder(std::filesystem::path path, dataset::Dataset data, std::string device = "cpu")
      : path_(std::move(path)), data_(std::move(data)), device_(std::move(device)) {}

  const dataset::Dataset& data() const noexcept { return data_; }
  const std::string& device() const noexcept { return device_; }
  bool has(const std::string& name) const;
  std::filesystem::path file(const std::string& name) const { return path_ / name; }
  /// A file of JSON, packed or not. \throws FileError, InvalidInput
  nlohmann::json json(const std::string& name) const;
  /// A file of a JSON value a line, packed or not. \throws FileError, InvalidInput
  std::vector<nlohmann::json> json_lines(const std::string& name) const;
  features::TensorFile tensors(const std::string& name) const;  ///< \throws as TensorFile
  std::vector<std::string> names() const;                       ///< of its files, sorted

 private:
  std::filesystem::path path_;
  dataset::Dataset data_;
  std::string device_;
};

/// Counts values and mismatches, a file at a time; keeps the first few mismatches of each.
class AgentsTally {
 public:
  static constexpr double kTolerance = 1e-4;  ///< generous for sums in float32

  struct File {
    std::string name;
    std::size_t values = 0, mismatches = 0;
    std::vector<std::string> examples;  ///< the first few, a line each
  };

  /// What follows is of this file, which may have been begun before.
  void begin(const std::string& file);
  void equal(std::string_view name, const nlohmann::json& recorded, const nlohmann::json& ours);
  /// Numbers that may differ by `tolerance`, or by that share of the recorded one if it is above 1.
  void near(std::string_view name, double recorded, double ours, double tolerance = kTolerance);
  /// All elements; another count is a mismatch.
  void near_all(std::string_view name, std::span<const double> recorded,
                std::span<const double> ours, double tolerance = kTolerance);
  /// Numbers of JSON, where null is minus infinity.
  void near_json(std::string_view name, const nlohmann::json& recorded,
                 std::span<const double> ours, double tolerance = kTolerance);

  const std::vector<File>& files() const noexcept { return files_; }

 private:
  void wrong(std::string line);
  std::vector<File> files_;
};

/// A JSON number; null is minus infinity. \throws Error for anything else
double golden_number(const nlohmann::json& value);
/// The numbers of an array of any type. \throws Error for a name that the file has not
std::vector<double> golden_array(const features::TensorFile& file, const std::string& name);

/// Checks of one agent: does nothing where its files are not there.
/// EnvDrop's listener: `envdrop*`.
void check_envdrop(const AgentsFolder& folder, AgentsTally& tally);
/// DUET with R2R's and REVERIE's heads: `duet_*`.
void check_duet(const AgentsFolder& folder, AgentsTally& tally);

}  // namespace enfilade::tests
