/// \file  The rule that includes point down only, as docs/README.md draws it, and a checker for it.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"  // Diagnostic

namespace enfilade::tests {

/// One source as the checker sees it; made-up ones test the checker itself.
struct SourceFile {
  std::string path;  ///< from the root of the tree, with '/': "enfilade/graph/nav_graph.h"
  std::string text;
};

using Arrows = std::map<std::string, std::set<std::string, std::less<>>, std::less<>>;

inline constexpr std::size_t kMaxLines = 600;

/// The folders of enfilade/ and those that each may include directly.
const Arrows& direct_arrows();

/// The rooms of a library: its sub-folders beside detail/, and those that each may include, closed
/// over chains. Headers in rooms are private to the library, as those in detail/: neither is
/// installed.
const std::map<std::string, Arrows, std::less<>>& rooms();

/// A folder may also include what those that it includes may include.
/// \throws ArgumentError naming the folder if the arrows make a ring or lead to an unknown one.
Arrows transitive_closure(const Arrows& direct);

/// The name between quotes or angle brackets of an `#include` line; empty for any other line.
std::string_view included_name(std::string_view line);

/// Everything about the sources that is against the rules, in the order of the files and lines:
///   unknown-folder  a folder of enfilade/ that the table of arrows does not have, or a room that
///                   its library's table does not have
///   upward          an include that no chain of arrows allows, between folders or between rooms
///   detail          a header of another folder's detail/ (core's excepted) or rooms
///   private-header  a public header includes one of detail/ or of a room: these are not installed
///   third-party     a library that is not allowed there (public headers may use none), or one of
///                   our own files that is not named from the root of the tree
///   namespace       a header whose namespace is not its folder's
///   too-long        more than kMaxLines lines
std::vector<Diagnostic> check_includes(const std::vector<SourceFile>& files);

/// All .h and .cpp files of enfilade/, apps/, bench/, tests/ and examples/ in `root`, by path.
/// \throws FileError if one cannot be read.
std::vector<SourceFile> read_sources(const std::filesystem::path& root);

}  // namespace enfilade::tests
