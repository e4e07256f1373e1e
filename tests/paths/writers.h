/// \file  The rule that files with computed names are written through OutputFolder, and a checker.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"           // Diagnostic
#include "tests/includes/include_arrows.h"  // SourceFile

namespace enfilade::tests {

/// A source that may call functions which write.
struct DirectWriter {
  std::string_view path;  ///< of the source, from the root of the tree
  std::string_view reason;
};

/// Those of this tree.
const std::vector<DirectWriter>& direct_writers();

/// C++ without comments and without what is between quotes; lines stay.
std::string without_texts(std::string_view cpp);

/// What is against the rule, in the order of the files. C++ of enfilade/, apps/ and python/src/ and
/// Python of python/enfilade/ are read, core/ and tests are not.
///   writes-directly  a function of the system or of core/ that writes, renames or removes files,
///   in
///                    a source without a row, and fmt::print() in a verb: say() is for terminals
///   joined-path      such a function, or one of ours that takes a path, whose first argument joins
///                    a path and anything but a text in quotes: a computed name. No row allows it.
///   stale-row        a row of a source that uses none
/// A call is fine if its path is OutputFolder's: `.file(name)` or `.folder(name)` stands among its
/// arguments. An OutputFolder of a parent_path() writes directly, as its root may be a link.
std::vector<Diagnostic> check_writers(const std::vector<SourceFile>& files,
                                      const std::vector<DirectWriter>& rows);

/// The sources that check_writers() reads. \throws FileError if one cannot be read
std::vector<SourceFile> read_writers(const std::filesystem::path& root);

}  // namespace enfilade::tests
