/// \file  The parts of the page about the data only.
#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::report::parts {

using Json = nlohmann::ordered_json;

/// {"missing": why}: what stands in the place of a part.
Json missing(const std::string& why);

/// Counts in bins of one width.
struct Histogram {
  double width = 1;
  std::vector<std::size_t>
      counts;  ///< [0, width), [width, 2 width), ...; none beyond the last value
  std::size_t total = 0;

  void add(double value);  ///< \pre value is finite and >= 0
};
/// {"width", "total", "counts"}
Json to_json(const Histogram& histogram);

/// Lengths of paths (metres) and instructions (words) of each split, and their means.
Json lengths_part(const std::vector<tasks::Annotations>& splits,
                  const std::shared_ptr<const graph::GraphSet>& graphs);

/// The tree of the first four words of all instructions; what would be too thin to see is left out.
Json words_part(const std::vector<tasks::Annotations>& splits);

}  // namespace enfilade::report::parts
