#include "enfilade/image/detail/libjpeg.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>  // before jpeglib.h, which needs FILE

#include <jpeglib.h>
// After it.
#include <jerror.h>

#include "enfilade/image/detail/check_size.h"
#include "enfilade/image/detail/row_shrinker.h"

namespace enfilade::image::detail {
namespace {

bool is_harmless(int code) {
  switch (code) {
    case JWRN_EXTRANEOUS_DATA:
    case JWRN_NOT_SEQUENTIAL:
    case JWRN_JFIF_MAJOR:
    case JWRN_ADOBE_XFORM:
    case JWRN_BOGUS_ICC:
      return true;
    default:
      return false;
  }
}

// A hostile progressive file may have thousands of scans; TurboJPEG's limit is the same.
constexpr int kMostScans = 500;

// `base` first: libjpeg hands over its address.
struct Messages {
  jpeg_error_mgr base{};
  std::jmp_buf jump{};
  std::array<char, JMSG_LENGTH_MAX> words{};  // of the error, else of the first harmless warning
  std::uint64_t harmless = 0;
  bool damaged = false;
};

Messages& messages_of(j_common_ptr info) { return *reinterpret_cast<Messages*>(info->err); }

// libjpeg is C: an exception must not pass through it.
[[noreturn]] void leave(j_common_ptr info) {
  std::longjmp(messages_of(info).jump, 1);  // NOLINT(cert-err52-cpp)
}

[[noreturn]] void on_error(j_common_ptr info) {
  Messages& messages = messages_of(info);
  messages.base.format_message(info, messages.words.data());
  messages.damaged = false;
  leave(info);
}

void on_message(j_common_ptr info, int level) {
  if (level >= 0) return;  // traces
  Messages& messages = messages_of(info);
  const bool harmless = is_harmless(messages.base.msg_code);
  if (!harmless || messages.harmless == 0) {
    messages.base.format_message(info, messages.words.data());
  }
  if (harmless) {
    ++messages.harmless;
    return;
  }
  messages.damaged = true;
  leave(info);
}

void on_progress(j_common_ptr info) {
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMostScans) return;
  Messages& messages = messages_of(info);
  *fmt::format_to_n(messages.words.data(), messages.words.size() - 1, "more than {} scans",
                    kMostScans)
       .out = '\0';
  messages.damaged = false;
  leave(info);
}

std::uint8_t times(unsigned a, unsigned b) {
  return static_cast<std::uint8_t>((a * b + 127) / 255);
}

void take_ink_off(const std::uint8_t* cmyk, std::size_t width, bool inverted, std::uint8_t* rgb) {
  const unsigned flip = inverted ? 0 : 255;
  for (std::size_t x = 0; x < width; ++x, cmyk += 4, rgb += 3) {
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = times(cmyk[c] ^ flip, cmyk[3] ^ flip);
  }
}

}  // namespace

struct LibJpeg::Impl {
  explicit Impl(const std::string& name) : file(name) {
    info.err = jpeg_std_error(&messages.base);
    messages.base.error_exit = on_error;
    messages.base.emit_message = on_message;
    progress.progress_monitor = on_progress;
  }
  ~Impl() { jpeg_destroy_decompress(&info); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Runs a step of libjpeg. It must not hold what has a destructor: errors jump out of it. Not
  // inlined, so that only this function's own variables are at stake.
  template <class Step>
  [[gnu::noinline]] void run(const Step& step) {
    if (setjmp(messages.jump) == 0) {  // NOLINT(cert-err52-cpp)
      step();
      return;
    }
    refuse(
        file, "", messages.damaged ? "damaged-jpeg" : "bad-jpeg",
        fmt::format("{}: {}", messages.damaged ? "the JPEG is damaged" : "no JPEG that can be read",
                    messages.words.data()));
  }

  bool is_cmyk() const {
    return info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK;
  }

  const std::string& file;
  jpeg_decompress_struct info{};
  Messages messages;
  jpeg_progress_mgr progress{};
};

LibJpeg::LibJpeg(Bytes jpeg, const std::string& file) : impl_(std::make_unique<Impl>(file)) {
  Impl& my = *impl_;
  my.run([&my, jpeg] {
    jpeg_create_decompress(&my.info);
    my.info.progress = &my.progress;
    jpeg_mem_src(&my.info, jpeg.data(),
                 static_cast<unsigned long>(jpeg.size()));  // NOLINT(google-runtime-int)
    jpeg_read_header(&my.info, TRUE);
  });
  check_size(my.info.image_width, my.info.image_height, file);
}

LibJpeg::~LibJpeg() = default;

std::uint32_t LibJpeg::width() const { return impl_->info.image_width; }
std::uint32_t LibJpeg::height() const { return impl_->info.image_height; }
std::uint32_t LibJpeg::channels() const {
  if (impl_->is_cmyk()) return 4;
  return impl_->info.jpeg_color_space == JCS_GRAYSCALE ? 1 : 3;
}

bool LibJpeg::has_several_scans() const { return jpeg_has_multiple_scans(&impl_->info) != FALSE; }

void LibJpeg::decode(std::uint8_t* rgb, unsigned halvings) {
  Impl& my = *impl_;
  jpeg_decompress_struct& info = my.info;
  const bool cmyk = my.is_cmyk();
  my.run([&info, cmyk, halvings] {
    constexpr unsigned kMostHalvings = 3;  // libjpeg's; of each block of 8 x 8 pixels
    info.out_color_space = cmyk ? JCS_CMYK : JCS_RGB;
    info.scale_num = 1;
    info.scale_denom = 1U << std::min(halvings, kMostHalvings);
    jpeg_start_decompress(&info);
  });
  std::vector<std::uint8_t> inks(cmyk ? std::size_t{4} * info.output_width : 0);
  RowShrinker rows({info.output_width, info.output_height},
                   {halved(width(), halvings), halved(height(), halvings)}, 3, rgb);
  my.run([&info, &inks, &rows, cmyk] {
    while (info.output_scanline < info.output_height) {
      std::uint8_t* const to = rows.row();
      JSAMPROW line = cmyk ? inks.data() : to;
      if (jpeg_read_scanlines(&info, &line, 1) != 1) continue;
      if (cmyk) take_ink_off(line, info.output_width, info.saw_Adobe_marker != 0, to);
      rows.add(to);
    }
    jpeg_finish_decompress(&info);  // reads on to the end marker
  });
}

void LibJpeg::check() {
  Impl& my = *impl_;
  my.run([&my] {
    jpeg_read_coefficients(&my.info);
    jpeg_finish_decompress(&my.info);
  });
}

std::vector<Diagnostic> LibJpeg::findings() const {
  std::vector<Diagnostic> found;
  if (impl_->messages.harmless > 0) {
    found.push_back({Severity::kWarning, impl_->file, "", "odd-jpeg",
                     fmt::format("harmless oddities: {}; the first: {}", impl_->messages.harmless,
                                 impl_->messages.words.data())});
  }
  if (impl_->is_cmyk()) {
    found.push_back({Severity::kNote, impl_->file, "", "printing-colours",
                     "CMYK, converted without its colour profile"});
  }
  return found;
}

}  // namespace enfilade::image::detail
