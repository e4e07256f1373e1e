/// \file  A measure as a column of a table.
#pragma once
#include <nlohmann/json.hpp>

#include "enfilade/tasks/scorer.h"

namespace enfilade::service::detail {

/// {"name", "short", "title", "unit": "m" or "share", "better"?: "higher" or "lower"}
inline nlohmann::ordered_json column_json(const tasks::Measure& measure) {
  nlohmann::ordered_json column{{"name", measure.name},
                                {"short", measure.column},
                                {"title", measure.title},
                                {"unit", measure.unit == tasks::Unit::kMetres ? "m" : "share"}};
  if (measure.better != tasks::Better::kNeither) {
    column["better"] = measure.better == tasks::Better::kHigher ? "higher" : "lower";
  }
  return column;
}

}  // namespace enfilade::service::detail
