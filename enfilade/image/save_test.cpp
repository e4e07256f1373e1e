#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/image/codecs.h"
#include "enfilade/image/photo.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::image {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Save, WritesWhatLoadPhotoReads) {
  const tests::TemporaryFolder folder("save");
  Image8 picture(3, 2, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = static_cast<std::uint8_t>(10 * i);
  }
  const std::string png = (folder.path() / "saved.png").string();
  const std::string jpg = (folder.path() / "saved.jpg").string();
  save(png, picture);
  EXPECT_EQ(load_photo(png).picture, picture);
  save(jpg, Image8(8, 8, 3), 95);
  EXPECT_EQ(load_photo(jpg).picture, Image8(8, 8, 3));
  EXPECT_THAT([&] { save("picture.gif", picture); },
              ThrowsMessage<ArgumentError>(HasSubstr(".png, .jpg or .jpeg")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
