#include "enfilade/core/detail/json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace enfilade::json {
namespace EN_UNIT {

using ::testing::HasSubstr;

std::string fault_of(const std::string& text) {
  try {
    Document::parse(text, "f.json");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "parsed";
}

TEST(JsonPath, ReadsAsOneWouldWriteIt) {
  const Path root;
  const Path item(root, 3);
  const Path field(item, "trajectory");
  const Path odd(field, "two words");
  EXPECT_EQ(Path(odd, 0).text(), "$[3].trajectory[\"two words\"][0]");
  EXPECT_EQ(root.text(), "$");
  // Keys are foreign texts.
  EXPECT_EQ(Path(root, "a\"\x1b").text(), R"($["a\"\x1b"])");
  const std::string long_key(5000, 'k');
  EXPECT_EQ(Path(root, long_key).text(),
            "$[\"" + std::string(kLongestInstructionId, 'k') + "\"... (5000 bytes)]");
}

TEST(JsonDocument, SaysWhereItIsBroken) {
  EXPECT_THAT(fault_of(""), HasSubstr("the file is empty"));
  EXPECT_THROW(Document::parse({}, "f.json"), InvalidInput) << "a view that points nowhere";
  EXPECT_THAT(fault_of("[1, 2"), HasSubstr("ends too early"));
  EXPECT_THAT(fault_of("[{\"a\": [1,\n 2, ?]}]"),
              HasSubstr("$[0].a[2]: line 2, column 5: not JSON"));
  EXPECT_THAT(fault_of("[{\"a\": NaN}]"), HasSubstr("$[0].a: line 1, column 8: NaN and Infinity"));
  EXPECT_THAT(fault_of("[-Infinity]"), HasSubstr("NaN and Infinity"));
  EXPECT_THAT(fault_of("[1e999]"), HasSubstr("f.json: $[0]"));
  EXPECT_THAT(fault_of("[1] 2"), HasSubstr("not JSON"));
  EXPECT_THAT(fault_of("[\"\xff\"]"), HasSubstr("f.json"));
  EXPECT_THAT(fault_of(std::string(5000, '[')), HasSubstr("f.json"));
  EXPECT_EQ(fault_of("\xEF\xBB\xBF[1]"), "parsed") << "a byte-order mark is harmless";
}

TEST(JsonValues, AnglesAreBounded) {
  const Document document = Document::parse(R"([1e4, -1e4, 10001, -1e308, "north"])", "f");
  Faults faults("f");
  const Path root;
  std::vector<double> read;
  std::size_t i = 0;
  for (const Element element : document.root().get_array()) {
    if (const auto radians = angle(element, Path(root, i++), faults)) read.push_back(*radians);
  }
  EXPECT_EQ(read, (std::vector<double>{1e4, -1e4}));
  const std::vector<Diagnostic> found = faults.take();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(to_string(found[0]),
            "error: f: $[2]: 10001 radians, not from -10000 to 10000 [bad-angle]");
  EXPECT_EQ(found[1].code, "bad-angle");
  EXPECT_EQ(found[2].code, "not-a-number");
}

TEST(JsonValues, ListsOfIdsKeepTheirPlaces) {
  Faults faults("f");
  const Document document = Document::parse(R"(["v0", "../x", "v2"])", "f");
  EXPECT_EQ(ids(document.root(), Path(), faults), (std::vector<std::string>{"v0", "", "v2"}));
  const std::vector<Diagnostic> found = faults.take();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].where + found[0].code, "$[1]bad-id");
}

TEST(JsonValues, SayWhatWasFoundAndWhatWasAllowed) {
  const Document document = Document::parse(R"(["x", 1.5, [1, 2], null])", "f");
  Faults faults("f");
  const Path root;
  std::size_t i = 0;
  for (const Element element : document.root().get_array()) {
    const Path here(root, i++);
    EXPECT_FALSE(boolean(element, here, faults));
    EXPECT_FALSE(integer(element, here, faults));
  }
  const std::vector<Diagnostic> found = faults.take();
  ASSERT_EQ(found.size(), 8U);
  EXPECT_EQ(to_string(found[0]), "error: f: $[0]: string \"x\", not true or false [not-a-boolean]");
  EXPECT_EQ(found[3].message, "number 1.5, not a whole number");
  EXPECT_EQ(found[4].message, "array of 2, not true or false");
  EXPECT_EQ(found[6].message, "null, not true or false");
}

TEST(JsonFields, ReportsMissingAndRepeated) {
  const Document document = Document::parse(R"({"a": 1, "b": 2, "b": 3, "other": 0})", "f");
  constexpr std::array<Field, 3> kWanted{{{"a"}, {"b"}, {"c", false}}};
  std::array<std::optional<Element>, 3> found;
  Faults faults("f");
  EXPECT_FALSE(fields(document.root(), kWanted, found, Path(), faults));
  EXPECT_EQ(faults.take().at(0).code, "repeated-field");
  EXPECT_FALSE(found[2]);

  constexpr std::array<Field, 1> kAbsent{{{"d"}}};
  std::array<std::optional<Element>, 1> none;
  EXPECT_FALSE(fields(document.root(), kAbsent, none, Path(), faults));
  EXPECT_EQ(faults.take().at(0).message, "has no field \"d\"");
}

TEST(JsonFields, OthersAreRefusedWithTheNearestName) {
  const Document document = Document::parse(R"({"teams": 1, "taems": 2, "\n": 3})", "f");
  constexpr std::array<Field, 2> kAllowed{{{"teams"}, {"step", false}}};
  Faults faults("f");
  EXPECT_FALSE(refuse_others(document.root(), kAllowed, Path(), faults));
  const auto found = faults.take();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(to_string(found[0]),
            "error: f: $: unknown field \"taems\"; the nearest is \"teams\" [unknown-field]");
  EXPECT_EQ(found[1].message, "unknown field \"\\n\"; allowed are teams, step");
  constexpr std::array<Field, 3> kAll{{{"teams"}, {"taems"}, {"\n"}}};
  EXPECT_TRUE(refuse_others(document.root(), kAll, Path(), faults));
}

TEST(JsonDocument, TooDeepIsNamedWithoutMuchMemory) {
  for (const std::size_t levels : {1025UL, 3'000'000UL}) {
    EXPECT_THAT(fault_of(std::string(levels, '[')), HasSubstr("too deep"));
    EXPECT_THAT(fault_of(std::string(levels, '[') + std::string(levels, ']')),
                HasSubstr("too deep"));
  }
  EXPECT_THROW(check_syntax(std::string(3'000'000, '['), "f"), InvalidInput);
  check_syntax(R"({"a": [1, "]"]})", "f");
}

TEST(JsonFaults, KeepsTheFirstThousandAndCountsTheRest) {
  Faults faults("f");
  const Path root;
  for (std::size_t k = 0; k < kMostFaultsKept; ++k) faults.error(Path(root, k), "bad", "x");
  EXPECT_TRUE(faults.full());
  faults.add(Severity::kWarning, root, "odd", "y");  // errors take no room from warnings
  EXPECT_EQ(faults.take().size(), kMostFaultsKept + 1);

  EXPECT_FALSE(faults.full());
  for (std::size_t k = 0; k < 1'000'000; ++k) faults.error(Path(root, k), "bad", "x");
  for (std::size_t k = 0; k < 1500; ++k) faults.add({Severity::kNote, "g", "$", "odd", "y"});
  EXPECT_EQ(faults.errors(), 1'000'000U);
  const auto found = faults.take();
  ASSERT_EQ(found.size(), 2 * kMostFaultsKept + 2);
  EXPECT_EQ(to_string(found[2 * kMostFaultsKept]),
            "error: f: $: 999000 more errors; the first 1000 are listed [more-faults]");
  EXPECT_EQ(to_string(found.back()),
            "warning: f: $: 500 more warnings and notes; the first 1000 are listed [more-faults]");
}

TEST(JsonFaults, SayWhereReadingStopped) {
  Faults faults("f");
  const Path root;
  for (std::size_t k = 0; k < kMostFaultsKept; ++k) faults.error(Path(root, k), "bad", "x");
  faults.stop(Path(root, kMostFaultsKept));
  faults.stop(root);
  try {
    faults.throw_if_errors();
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().size(), kMostFaultsKept + 1);
    EXPECT_EQ(error.diagnostics().back().where, "$[1000]");
    EXPECT_THAT(error.what(), HasSubstr("... and 990 more\nerror: f: $[1000]: not read from here "
                                        "on, after 1000 errors; there may be more"));
  }
}

TEST(JsonLimits, CountWhatTakesMemory) {
  EXPECT_EQ(excess(R"({"a": [1, "[,{:\", x", {}]})", {7, 3}), "");
  EXPECT_EQ(excess(R"({"a": [1, "[,{:\", x", {}]})", {6, 3}), "more than 6 values and keys");
  EXPECT_EQ(excess(R"({"a": [1, "[,{:\", x", {}]})", {7, 2}), "more than 2 levels");
  EXPECT_EQ(excess("[[],[],[[]]]", {20, 3}), "");
  EXPECT_EQ(excess("]]]]}}", {1, 1}), "") << "no JSON, and within limits";
  EXPECT_EQ(excess("", {1, 1}), "");
  EXPECT_EQ(excess(R"(["\\", [ [)", {20, 2}), "more than 2 levels");
  EXPECT_EQ(excess(R"({"a": {"b": 1, "c": 2}, "d": [{"e": 1}, {"f": 1}]})", {99, 9, 2}), "");
  EXPECT_EQ(excess(R"({"a": {"b": 1}, "c": 2, "d": 3})", {99, 9, 2}),
            "an object of more than 2 keys");
}

}  // namespace EN_UNIT
}  // namespace enfilade::json
