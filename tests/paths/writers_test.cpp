#include "tests/paths/writers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> codes(std::string path, std::string text, bool has_row = false) {
  const std::string name = path;
  std::vector<DirectWriter> rows;
  if (has_row) rows.push_back({name, "made up"});
  std::vector<std::string> found;
  for (const Diagnostic& one : check_writers({{std::move(path), std::move(text)}}, rows)) {
    found.push_back(one.code);
  }
  return found;
}
std::vector<std::string> library(std::string text, bool has_row = false) {
  return codes("enfilade/homes/x.cpp", std::move(text), has_row);
}

TEST(Writers, OfThisTreeGoThroughOutputFolder) {
  const std::vector<SourceFile> files = read_writers(EN_SOURCE_DIR);
  for (const char* path : {"enfilade/capture/scan_files.cpp", "python/enfilade/_output.py"}) {
    ASSERT_EQ(std::ranges::count(files, path, &SourceFile::path), 1) << path;
  }
  for (const Diagnostic& one : check_writers(files, direct_writers())) {
    ADD_FAILURE() << to_string(one);
  }
}

TEST(Writers, ThatWriteDirectlyNeedARow) {
  for (const char* text :
       {"std::ofstream out(file);", "f = std::fopen(name, \"wb\");", "::open(p, O_CREAT | O_RDWR);",
        "write_file_atomically(file, text);", "PartFile part(file);", "H5Fcreate(file, 0);",
        "fs::remove(file);", "std::filesystem::remove_all(file);", "fs::rename(a, b);",
        "fs::copy(a, b);", "std::fstream both(file);", "::open(p, O_WRONLY | O_TRUNC);",
        "const OutputFolder out(file.parent_path());",
        "OutputFolder(file.parent_path()).write(name, text);", "return unlink(file);",
        "torch::save(tensor, file);", "fs::create_directories(folder);"}) {
    EXPECT_THAT(library(text), ElementsAre("writes-directly")) << text;
    EXPECT_THAT(library(text, true), IsEmpty()) << text;
    EXPECT_THAT(codes("apps/enfilade/x.cpp", text), ElementsAre("writes-directly")) << text;
  }
  for (const char* text : {"file.write_text(x)", "with open(file, \"w\") as out:",
                           "shutil.rmtree(a)", "os.replace(a, b)", "file.open(\"ab\")",
                           "open(file, 'w')", "os.remove(a)", "shutil.move(a, b)"}) {
    EXPECT_THAT(codes("python/enfilade/x.py", text), ElementsAre("writes-directly")) << text;
  }
  EXPECT_THAT(codes("apps/enfilade/x.cpp", "fmt::print(\"{}\", name);"),
              ElementsAre("writes-directly"));
}

// The first one is how an id led files of scan-mesh anywhere.
TEST(Writers, NeverJoinAComputedName) {
  for (const char* text :
       {"write_file_atomically(folder / (id + \".jpg\"), jpeg);",
        "write_file_atomically(\n    folder / name,\n    jpeg);", "PartFile part(folder / name);",
        "scene->save(folder / name);", "write_output((folder / name).string(), text);",
        "Hdf5Writer writer(folder / name);", "make_folder(folder / \"a\" / scan);",
        "write_file_atomically(data.folder() / id, text);"}) {
    EXPECT_THAT(library(text, true), ::testing::Contains("joined-path")) << text;
  }
}

TEST(Writers, MayUseOutputFolderAndNamesInQuotes) {
  for (const char* text :
       {"out.write(name, text);", "out.remove(name); out.rename(a, b); out.remove_all(c);",
        "PartFile part(out.file(folder + \"/\" + name));", "scene->save(out.file(name));",
        "write_glb(mesh, out.file(name));", "save_connectivity(out.folder(\"connectivity\"));",
        "void f(const OutputFolder& out) { g(file.parent_path()); }",
        "const OutputFolder out(folder);", "std::ranges::copy(a, b); #include <fstream>",
        "make_folder(folder / \"logs\");", "void write_file_atomically(const fs::path& file);",
        "// fs::remove(file)", "say(\"unlink(file)\");", "text.remove_prefix(1);",
        "a.erase(std::ranges::remove_if(a, b));", "R\"(fs::remove(x))\"",
        "#include \"ofstream\""}) {
    EXPECT_THAT(library(text), IsEmpty()) << text;
  }
  EXPECT_THAT(codes("python/enfilade/x.py", "open(file, \"rb\")  # os.replace(a, b)"), IsEmpty());
  EXPECT_THAT(codes("enfilade/core/x.cpp", "fmt::print(\"{}\", name);"), IsEmpty());
}

TEST(Writers, RowsOfSourcesThatWriteNothingAreStale) {
  EXPECT_THAT(library("int x;", true), ElementsAre("stale-row"));
}

TEST(Writers, AreNamedWithTheirLine) {
  const auto found = check_writers({{"enfilade/homes/x.cpp", "/* a\n b */\nfs::remove(x);\n"}}, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].where, "line 3");
}

TEST(WithoutTexts, KeepsCodeAndLines) {
  EXPECT_EQ(without_texts("a(\"x\\\"y\", 'b', 10'000); // c\n/* d\n*/e"),
            "a(\"\", ' ', 10'000); \n\ne");
  EXPECT_EQ(without_texts("R\"p(a\n\"b)p\" + c"), "R\"\"\n + c");
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
