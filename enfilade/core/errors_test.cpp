#include "enfilade/core/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(CheckRange, LetsBothEndsPassAndNamesWhatIsOutside) {
  check_range("share", 0, 0, 1);
  check_range("share", 1, 0, 1);
  EXPECT_THAT([] { check_range("body.step", 2.5, 0.02, 2); },
              ThrowsMessage<ArgumentError>("body.step: 2.5, not from 0.02 to 2"));
  EXPECT_THROW(check_range("share", -1e-300, 0, 1), ArgumentError);
  EXPECT_THROW(check_range("share", std::numeric_limits<double>::quiet_NaN(), 0, 1), ArgumentError);
}

TEST(Diagnostic, NamesSeverityFilePlaceAndCode) {
  const Diagnostic d{Severity::kWarning, "a.json", "$[3].pose", "bad-pose", "9 numbers, not 16"};
  EXPECT_EQ(to_string(d), "warning: a.json: $[3].pose: 9 numbers, not 16 [bad-pose]");
}

TEST(Diagnostic, ShowsTheStartOfALongMessage) {
  // The 400th byte is within a character of two bytes.
  const std::string long_text = std::string(399, 'a') + "\xc3\xa4" + std::string(1000, 'b');
  const std::string start = std::string(399, 'a') + "... (1401 bytes)";
  const Diagnostic d{Severity::kError, "a.json", long_text, "bad-id", long_text};
  EXPECT_EQ(to_string(d), "error: a.json: " + start + ": " + start + " [bad-id]");
  EXPECT_EQ(InvalidInput({d}).what(), to_string(d));
  const Diagnostic whole{Severity::kError, "a.json", "", "", std::string(400, 'a')};
  EXPECT_EQ(to_string(whole), "error: a.json: " + whole.message);
}

TEST(InvalidInput, ListsErrorsOnlyAndCountsTheRest) {
  std::vector<Diagnostic> diagnostics{{Severity::kNote, "f", "", "", "a note"}};
  for (int i = 0; i < 12; ++i) {
    diagnostics.push_back({Severity::kError, "f", "", "", "fault " + std::to_string(i)});
  }
  const InvalidInput error(diagnostics);
  EXPECT_THAT(error.what(), HasSubstr("fault 9"));
  EXPECT_THAT(error.what(), HasSubstr("... and 2 more"));
  EXPECT_THAT(error.what(), Not(HasSubstr("fault 10")));
  EXPECT_THAT(error.what(), Not(HasSubstr("a note")));
  EXPECT_EQ(error.diagnostics().size(), 13U);
  EXPECT_EQ(count(error.diagnostics(), Severity::kError), 12U);
}

}  // namespace EN_UNIT
}  // namespace enfilade
