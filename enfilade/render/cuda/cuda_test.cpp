// The CUDA back end on a card. Without one these tests are skipped, but for what is said then.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/render/cuda/driver.h"
#include "enfilade/render/devices.h"
#include "tests/support/drawn_formats.h"
#include "tests/support/made_panoramas.h"

namespace enfilade::render::cuda {
namespace EN_UNIT {

using testing::cache_of;
using testing::Drawn;
using testing::Formats;
using ::testing::HasSubstr;
using testing::made_panorama;
using testing::outputs_of;
using testing::random_view;
using ::testing::ThrowsMessage;

class OnACard : public ::testing::Test {
 protected:
  void SetUp() override {
    const CudaReport report = cuda_report();
    if (report.devices.empty()) GTEST_SKIP() << report.error;
    if (report.compiler.empty()) GTEST_SKIP() << report.compiler_error;
  }
};

std::unique_ptr<Renderer> make(const std::shared_ptr<FaceCache>& faces, Backend backend,
                               Legacy legacy = {}, std::size_t bytes = 0) {
  return make_renderer(faces,
                       {.backend = backend, .threads = 1, .legacy = legacy, .cuda_bytes = bytes});
}

Formats random_formats(Rng& rng) {
  Formats formats;
  if (rng.below(6) > 0) formats.colour = static_cast<ColourFormat>(rng.below(5));
  if (rng.below(2) > 0) formats.depth = static_cast<DepthFormat>(rng.below(2));
  if (rng.below(3) == 0) formats.classes = static_cast<ClassFormat>(rng.below(2));
  formats.instances = rng.below(3) == 0;
  formats.measure = static_cast<DepthMeasure>(rng.below(2));
  return formats;
}

std::vector<View> random_views(Rng& rng, std::size_t most, std::size_t viewpoints) {
  std::vector<View> views;
  const std::size_t count = 1 + rng.below(most);
  for (std::size_t k = 0; k < count; ++k) views.push_back(random_view(rng, viewpoints));
  return views;
}

// Draws the same with both and compares all bytes.
void expect_same(Renderer& card, Renderer& cpu, const Camera& camera,
                 const std::vector<View>& views, const Formats& formats) {
  const std::size_t pixels = views.size() * camera.width * camera.height;
  Drawn drawn, wanted;
  card.render(camera, views, outputs_of(formats, pixels, drawn));
  cpu.render(camera, views, outputs_of(formats, pixels, wanted));
  const auto differing = [](const auto& a, const auto& b) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < a.size(); ++k) count += a[k] != b[k] ? 1 : 0;
    return count;
  };
  EXPECT_EQ(differing(drawn.colour, wanted.colour), 0U);
  EXPECT_EQ(differing(drawn.depth, wanted.depth), 0U);
  EXPECT_EQ(differing(drawn.classes, wanted.classes), 0U);
  EXPECT_EQ(differing(drawn.instances, wanted.instances), 0U);
}

TEST_F(OnACard, DrawsTheCpusBytes) {
  const auto faces = cache_of({made_panorama(45), made_panorama(64)});
  Rng rng(23, 0);
  for (const Legacy legacy : {Legacy{}, Legacy{true, true}}) {
    const auto card = make(faces, Backend::kCuda, legacy);
    const auto cpu = make(faces, Backend::kCpu, legacy);
    for (int round = 0; round < 150 && !HasFailure(); ++round) {
      // As large as what people draw, now and then.
      const std::uint32_t most = round % 10 == 0 ? 900 : 300;
      const Camera camera{1 + static_cast<std::uint32_t>(rng.below(most)),
                          1 + static_cast<std::uint32_t>(rng.below(most)),
                          degrees(5 + 165 * rng.uniform())};
      SCOPED_TRACE(fmt::format("round {}, {} x {}", round, camera.width, camera.height));
      expect_same(*card, *cpu, camera, random_views(rng, 5, 2), random_formats(rng));
    }
  }
}

TEST_F(OnACard, KeepsWithinItsBytesAndDrawsTheSame) {
  std::vector<scan::Panorama> panoramas;
  for (const std::uint32_t size : {32U, 64U, 48U, 64U, 32U, 64U}) {
    panoramas.push_back(made_panorama(size));
  }
  const auto faces = cache_of(std::move(panoramas));
  // Two of the larger panoramas' colour, or fewer than one of all layers.
  for (const std::size_t bytes : {std::size_t{250'000}, std::size_t{1}}) {
    const auto card = make(faces, Backend::kCuda, {}, bytes);
    const auto cpu = make(faces, Backend::kCpu);
    Rng rng(24, 0);
    for (int round = 0; round < 40 && !HasFailure(); ++round) {
      expect_same(*card, *cpu, {40, 30, degrees(70)}, random_views(rng, 12, 6),
                  random_formats(rng));
    }
  }
}

TEST_F(OnACard, DrawsLayersOfDifferentSizes) {
  scan::Panorama mixed = made_panorama(64);
  const scan::Panorama small = made_panorama(40);
  mixed.depth = small.depth;
  const auto faces = cache_of({mixed});
  const auto card = make(faces, Backend::kCuda), cpu = make(faces, Backend::kCpu);
  Rng rng(25, 0);
  for (int round = 0; round < 20 && !HasFailure(); ++round) {
    expect_same(*card, *cpu, {60, 45, degrees(80)}, random_views(rng, 4, 1),
                {ColourFormat::kRgb8, DepthFormat::kMetresFloat32, ClassFormat::kUint16, true});
  }
}

TEST_F(OnACard, DrawsIntoItsOwnMemoryInTheOrderOfAStream) {
  const auto faces = cache_of({made_panorama(64), made_panorama(45)});
  const auto card = make(faces, Backend::kCuda), cpu = make(faces, Backend::kCpu);
  const Device device(0);
  const CurrentDevice current(device);
  const Stream first = make_stream(), second = make_stream();
  const Camera camera{64, 48, degrees(60)};
  Rng rng(26, 0);
  const std::vector<View> views = random_views(rng, 30, 2);
  const std::size_t bytes = 3 * views.size() * camera.width * camera.height, guard = 256;
  const Memory memory = allocate(bytes + 2 * guard);
  for (const Stream* stream : {&first, &second, &first}) {
    // Poisoned in the same stream: drawing comes behind it, reading behind that.
    check(api().MemsetD32Async(memory.get(), 0xA5A5A5A5U, (bytes + 2 * guard) / 4, stream->get()),
          "filling");
    Outputs outputs;
    auto* pixels = reinterpret_cast<std::byte*>(memory.get() + guard);
    outputs.colour = ColourOutput{ColourFormat::kRgb8, {}, {pixels, bytes}};
    outputs.stream = CudaStream{stream->get()};
    card->render(camera, views, outputs);
    std::vector<std::byte> all(bytes + 2 * guard);
    check(api().MemcpyDtoHAsync(all.data(), memory.get(), all.size(), stream->get()), "reading");
    check(api().StreamSynchronize(stream->get()), "reading");
    std::vector<std::byte> wanted(bytes);
    Outputs on_host;
    on_host.colour = ColourOutput{ColourFormat::kRgb8, {}, wanted};
    cpu->render(camera, views, on_host);
    EXPECT_TRUE(std::equal(wanted.begin(), wanted.end(), all.begin() + guard));
    for (std::size_t k = 0; k < guard; ++k) {
      ASSERT_EQ(all[k], std::byte{0xA5});
      ASSERT_EQ(all[guard + bytes + k], std::byte{0xA5});
    }
  }
}

TEST_F(OnACard, GoesOnBehindAFailure) {
  scan::Panorama bare = made_panorama(32);
  bare.depth = {};
  const auto faces = cache_of({made_panorama(32), bare});
  const auto card = make(faces, Backend::kCuda), cpu = make(faces, Backend::kCpu);
  const Camera camera{30, 20, degrees(60)};
  const View whole{ScanIndex(0), ViewpointIndex(0), {}, {}};
  const View lacking{ScanIndex(0), ViewpointIndex(1), {}, {}};
  const Formats depth{{}, DepthFormat::kMetresFloat32, {}, false};
  Drawn drawn;
  const std::vector<View> views{whole, lacking};
  EXPECT_THROW(card->render(camera, views, outputs_of(depth, 2 * 600, drawn)), LookupError);
  expect_same(*card, *cpu, camera, {whole}, depth);
  expect_same(*card, *cpu, camera, {whole, lacking}, {ColourFormat::kRgb8, {}, {}, false});
}

TEST_F(OnACard, RefusesACardThatIsNotThere) {
  const auto faces = cache_of({made_panorama(8)});
  EXPECT_THAT([&] { make_renderer(faces, {.backend = Backend::kCuda, .cuda_device = "99"}); },
              ThrowsMessage<ArgumentError>(HasSubstr("config.cuda_device: 99")));
  EXPECT_THAT([&] { make_renderer(faces, {.backend = Backend::kCuda, .cuda_device = "first"}); },
              ThrowsMessage<ArgumentError>(HasSubstr("not a card's number")));
  EXPECT_THAT(make(faces, Backend::kCuda)->description(), HasSubstr("compute capability"));
}

TEST(WithoutACard, TheBackEndSaysWhatIsMissing) {
  const CudaReport report = cuda_report();
  if (!report.devices.empty()) GTEST_SKIP() << "there is a card: " << report.devices[0].name;
  EXPECT_THAT([&] { make(cache_of({made_panorama(8)}), Backend::kCuda); },
              ThrowsMessage<Error>(HasSubstr(report.error)));
}

TEST(OtherBackEnds, RefuseAStream) {
  const auto cpu = make(cache_of({made_panorama(8)}), Backend::kCpu);
  Drawn drawn;
  Outputs outputs = outputs_of({ColourFormat::kRgb8, {}, {}, false}, 600, drawn);
  outputs.stream = CudaStream{};
  const View view{ScanIndex(0), ViewpointIndex(0), {}, {}};
  EXPECT_THAT(
      [&] {
        cpu->render({30, 20, degrees(60)}, {&view, 1}, outputs);
      },
      ThrowsMessage<ArgumentError>(HasSubstr("outputs.stream")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::render::cuda
