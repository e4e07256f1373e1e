#include "tests/includes/include_arrows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A file of one include; the directive is put together here, so that this file itself has none of
/// the bad ones.
SourceFile including(std::string path, std::string_view name) {
  const bool ours = name.find("enfilade/") == 0 || name.find("tests/") == 0;
  std::string text = "// made up\n#include ";
  text += ours ? '"' : '<';
  text += name;
  text += ours ? '"' : '>';
  return {std::move(path), text + "\n"};
}

std::vector<std::string> codes(const std::vector<SourceFile>& files) {
  std::vector<std::string> found;
  for (const Diagnostic& diagnostic : check_includes(files)) found.push_back(diagnostic.code);
  return found;
}

std::vector<std::string> codes(std::string path, std::string_view name) {
  return codes({including(std::move(path), name)});
}

TEST(IncludeArrows, PointDownInThisTree) {
  const std::vector<SourceFile> files = read_sources(EN_SOURCE_DIR);
  // A wrong EN_SOURCE_DIR would find nothing to complain about.
  ASSERT_TRUE(std::ranges::count(files, "enfilade/core/errors.h", &SourceFile::path) == 1);
  for (const Diagnostic& diagnostic : check_includes(files)) ADD_FAILURE() << to_string(diagnostic);
}

TEST(IncludeArrows, FailOnUpwardInclude) {
  EXPECT_THAT(codes("enfilade/core/rng.cpp", "enfilade/geometry/vec.h"), ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/graph/nav_graph.h", "enfilade/sim/simulator.h"),
              ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/sim/simulator.h", "enfilade/tasks/metrics.h"), ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/tasks/metrics.h", "enfilade/render/renderer.h"),
              ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/sim/simulator_test.cpp", "enfilade/agents/agent.h"),
              ElementsAre("upward"));
}

TEST(IncludeArrows, NoFolderIncludesTheHeaderOfAllNames) {
  EXPECT_THAT(codes("enfilade/enfilade.h", "enfilade/agents/run.h"), IsEmpty());
  EXPECT_THAT(codes("examples/render.cpp", "enfilade/enfilade.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/report/report.cpp", "enfilade/enfilade.h"), ElementsAre("upward"));
}

TEST(IncludeArrows, SayWhichFileLineAndInclude) {
  const std::vector<Diagnostic> found =
      check_includes({including("enfilade/core/rng.cpp", "enfilade/geometry/vec.h")});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(to_string(found[0]),
            "error: enfilade/core/rng.cpp: line 2: core/ may not include "
            "\"enfilade/geometry/vec.h\" [upward]");
}

TEST(IncludeArrows, AllowWhatAChainOfArrowsAllows) {
  EXPECT_THAT(codes("enfilade/sim/simulator.h", "enfilade/graph/nav_graph.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/sim/simulator.h", "enfilade/core/ids.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/agents/agent.h", "enfilade/scan/connectivity.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/core/rng.cpp", "enfilade/core/rng.h"), IsEmpty());
  EXPECT_THAT(codes("apps/enfilade/main.cpp", "enfilade/service/server.h"), IsEmpty());
}

TEST(IncludeArrows, KeepTheLibraryFromWhatIsBuiltOnIt) {
  EXPECT_THAT(codes("enfilade/draw/plan.cpp", "apps/table.h"), ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/draw/plan.cpp", "tests/support/temporary_folder.h"),
              ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/draw/plan_test.cpp", "tests/support/temporary_folder.h"), IsEmpty());
  EXPECT_THAT(codes("examples/walk.cpp", "apps/table.h"), ElementsAre("upward"));
  EXPECT_THAT(codes("tests/cli/score_test.cpp", "apps/table.h"), IsEmpty());
  EXPECT_THAT(codes("bench/bench_render.cpp", "apps/common/program.h"), IsEmpty());
}

TEST(IncludeArrows, FailOnAFolderThatIsNotInTheTable) {
  EXPECT_THAT(codes("enfilade/util/strings.h", "string"), ElementsAre("unknown-folder"));
  EXPECT_THAT(codes("enfilade/everything.h", "string"), ElementsAre("unknown-folder"));
  EXPECT_THAT(codes("enfilade/graph/nav_graph.h", "enfilade/util/strings.h"),
              ElementsAre("upward"));
}

TEST(IncludeArrows, KeepDetailHeadersInTheirFolder) {
  EXPECT_THAT(codes("enfilade/graph/nav_graph.cpp", "enfilade/graph/detail/grid.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/scan/regions.cpp", "enfilade/core/detail/json.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/sim/simulator.cpp", "enfilade/graph/detail/grid.h"),
              ElementsAre("detail"));
  EXPECT_THAT(codes("apps/enfilade/main.cpp", "enfilade/tasks/detail/reader.h"),
              ElementsAre("detail"));
}

TEST(IncludeArrows, KeepRoomsInTheirLibraryAndInTheirOrder) {
  EXPECT_THAT(codes("enfilade/service/server.cpp", "enfilade/service/http/routes.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/service/http/routes.h", "enfilade/service/store/database.h"),
              IsEmpty());
  EXPECT_THAT(codes("enfilade/service/client.cpp", "httplib.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/service/http/routes.h", "httplib.h"), ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/service/store/rows.h", "enfilade/service/detail/text.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/service/store/rows.h", "enfilade/service/http/routes.h"),
              ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/service/detail/text.h", "enfilade/service/store/rows.h"),
              ElementsAre("upward"));
  EXPECT_THAT(codes("enfilade/service/server.h", "enfilade/service/http/routes.h"),
              ElementsAre("private-header"));
  EXPECT_THAT(codes("apps/enfilade/serve.cpp", "enfilade/service/http/routes.h"),
              ElementsAre("detail"));
  EXPECT_THAT(codes("enfilade/service/cellar/wine.h", "string"), ElementsAre("unknown-folder"));
}

TEST(IncludeArrows, KeepPublicHeadersToWhatIsInstalled) {
  EXPECT_THAT(codes("enfilade/scan/regions.h", "enfilade/core/detail/json.h"),
              ElementsAre("private-header"));
  EXPECT_THAT(codes("enfilade/core/threads.h", "tbb/parallel_for.h"), ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/core/file.h", "unistd.h"), ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/core/errors.h", "fmt/format.h"), ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/core/errors.h", "string_view"), IsEmpty());
  EXPECT_THAT(codes("enfilade/core/detail/json.h", "simdjson.h"), IsEmpty());
}

TEST(IncludeArrows, KeepLibrariesWhereTheyBelong) {
  EXPECT_THAT(codes("enfilade/core/threads.cpp", "tbb/parallel_for.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/tasks/metrics.cpp", "tbb/parallel_for.h"),
              ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/tasks/metrics.cpp", "CLI/CLI.hpp"), ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/tasks/metrics.cpp", "gtest/gtest.h"), ElementsAre("third-party"));
  EXPECT_THAT(codes("enfilade/tasks/metrics_test.cpp", "gtest/gtest.h"), IsEmpty());
  EXPECT_THAT(codes("enfilade/image/png.cpp", "opencv2/core.hpp"), ElementsAre("third-party"));
}

TEST(IncludeArrows, WantOurHeadersNamedFromTheRoot) {
  EXPECT_THAT(codes({{"enfilade/graph/nav_graph.cpp", "#include \"nav_graph.h\"\n"}}),
              ElementsAre("third-party"));
}

TEST(IncludeArrows, WantEachFoldersNamespace) {
  const auto found = [](std::string path, const char* text) {
    return codes({{std::move(path), text}});
  };
  EXPECT_THAT(found("enfilade/graph/detail/x.h", "\nnamespace enfilade::graph::detail {"),
              IsEmpty());
  EXPECT_THAT(found("enfilade/graph/detail/x.h", "\nnamespace enfilade::graph {"),
              ElementsAre("namespace"));
  EXPECT_THAT(found("enfilade/mesh/light/x.h", "\nnamespace enfilade::mesh::light {"), IsEmpty());
  EXPECT_THAT(found("enfilade/mesh/x.h", "\nnamespace enfilade::graph {"),
              ElementsAre("namespace"));
  EXPECT_THAT(found("enfilade/core/ids.h", "\nnamespace enfilade {"), IsEmpty());
  EXPECT_THAT(found("enfilade/core/detail/json.h", "\nnamespace enfilade::json {"), IsEmpty());
}

TEST(IncludeArrows, FailOnAFileThatIsTooLong) {
  const std::string_view line = "int x;\n";
  std::string text;
  for (std::size_t i = 0; i < kMaxLines; ++i) text += line;
  EXPECT_THAT(codes({{"tests/long_test.cpp", text}}), IsEmpty());
  EXPECT_THAT(codes({{"tests/long_test.cpp", text + "int y;"}}), ElementsAre("too-long"));
}

TEST(IncludeArrows, FindEveryFormOfInclude) {
  EXPECT_EQ(included_name("#include <vector>"), "vector");
  EXPECT_EQ(included_name("  #  include\t\"enfilade/core/ids.h\"  // ids"), "enfilade/core/ids.h");
  EXPECT_EQ(included_name("#include<vector>\r"), "vector");
  EXPECT_EQ(included_name("// #include <vector>"), "");
  EXPECT_EQ(included_name("#include EN_HEADER"), "");
  EXPECT_EQ(included_name("#include \"cut"), "");
  EXPECT_EQ(included_name("#if 0"), "");
  EXPECT_EQ(included_name(""), "");
}

TEST(IncludeArrows, CloseOverChainsAndRefuseRings) {
  const Arrows closed = transitive_closure({{"a", {}}, {"b", {"a"}}, {"c", {"b"}}});
  EXPECT_THAT(closed.at("c"), ElementsAre("a", "b"));
  EXPECT_THAT(closed.at("a"), IsEmpty());
  EXPECT_THROW(transitive_closure({{"a", {"b"}}, {"b", {"a"}}}), ArgumentError);
  EXPECT_THROW(transitive_closure({{"a", {"a"}}}), ArgumentError);
  EXPECT_THROW(transitive_closure({{"a", {"z"}}}), ArgumentError);
}

TEST(IncludeArrows, OfTheTableReachCoreFromEverywhere) {
  for (const auto& [folder, below] : transitive_closure(direct_arrows())) {
    EXPECT_EQ(below.contains("core"), folder != "core") << folder;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
