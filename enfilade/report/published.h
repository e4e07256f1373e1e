/// \file  What the paper printed: Anderson et al., CVPR 2018, table 1.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace enfilade::report {

/// A row of the table. The paper has no SPL, which its authors proposed afterwards.
struct PublishedRow {
  std::string_view agent;        ///< "shortest", "random", "teacher", "student", "human"
  std::string_view split;        ///< "val_seen", "val_unseen", "test"
  double trajectory_length = 0;  ///< TL, metres
  double nav_error = 0;          ///< NE, metres
  double success = 0;            ///< SR, [0, 1]
  double oracle_success = 0;     ///< OSR, [0, 1]
};
std::span<const PublishedRow> published_rows() noexcept;

/// The row of an agent by the name that it has here; "student-forcing" is "student", "-1" at the
/// end (a seed) is not part of the name. An ablation ("student-language") has no row.
std::optional<PublishedRow> published_row(std::string_view agent, std::string_view split) noexcept;

/// How many instructions the paper's split has; 0 for one that it does not have. Figures of another
/// number of episodes are of another data set, and no published row belongs beside them.
std::size_t published_episodes(std::string_view split) noexcept;

}  // namespace enfilade::report
