#include "enfilade/features/formats/hdf5_datasets.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <ranges>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/features/formats/feature_rows.h"
#include "enfilade/features/formats/hdf5_filters.h"

namespace enfilade::features::formats {
namespace {

// More numbers than any viewpoint has; a small file must not make us allocate more.
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 24;

bool locking_is_off() {
  constexpr std::array<std::string_view, 2> kOff{"FALSE", "0"};
  const char* const set = std::getenv("HDF5_USE_FILE_LOCKING");
  return set != nullptr && std::ranges::find(kOff, std::string_view(set)) != kOff.end();
}

// A file that a program writes is locked by its HDF5 library, with flock(). A file system without
// locks has none, and its files are read.
void check_not_locked(const std::filesystem::path& path, const std::string& name) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 || locking_is_off()) {
    if (descriptor >= 0) close(descriptor);
    return;  // what cannot be opened has a reason of its own
  }
  const bool locked = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  if (locked) {
    refuse(name, "", "locked",
           "another program has the file open for writing. Wait for it, or set "
           "HDF5_USE_FILE_LOCKING=FALSE to read the file as it is now");
  }
}

// Without a lock of our own: a reader needs none beside other readers, and some network file
// systems refuse it.
Hdf5Handle open_file(const std::filesystem::path& path, const std::string& name) {
  check_not_locked(path, name);
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access.id(), false, true);
  Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (!file.good()) {
    const std::string reason = Hdf5Library::reason();
    if (reason.find("already open for") != std::string::npos) {
      refuse(name, "", "locked",
             "a program that wrote the file has not closed it. If none has it open now, mark it "
             "as closed: h5clear -s FILE");
    }
    refuse(name, "", "bad-hdf5", "not an HDF5 file, or a damaged one: " + reason);
  }
  return file;
}

}  // namespace

bool is_plain_float(hid_t type) {
  const Hdf5Handle half = half_type();
  const std::array<hid_t, 5> plain{half.id(), H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE,
                                   H5T_IEEE_F64BE};
  return std::ranges::any_of(plain, [&](hid_t one) { return H5Tequal(type, one) > 0; });
}

bool is_plain_number(hid_t type) {
  const std::array<hid_t, 6> plain{H5T_STD_I32LE, H5T_STD_I64LE, H5T_STD_I16LE,
                                   H5T_STD_U32LE, H5T_STD_U64LE, H5T_STD_U16LE};
  return is_plain_float(type) ||
         std::ranges::any_of(plain, [&](hid_t one) { return H5Tequal(type, one) > 0; });
}

Hdf5Source::Hdf5Source(const std::filesystem::path& path, std::string name)
    : name_(std::move(name)), file_(open_file(path, name_)) {}

void Hdf5Source::fail(const std::string& dataset, const char* code, std::string message) const {
  refuse(name_, in_quotes(dataset), code, std::move(message));
}

void Hdf5Source::fail_damaged(const std::string& dataset) const {
  fail(dataset, "bad-hdf5", "cannot be read: " + Hdf5Library::reason());
}

void Hdf5Source::fail_unread(const std::string& dataset, const Hdf5Handle& opened) const {
  const std::string reason = Hdf5Library::reason();
  const Hdf5Handle made(H5Dget_create_plist(opened.id()), H5Pclose);
  if (const auto filter = missing_filter(made.id())) {
    fail(dataset, "missing-filter",
         fmt::format("packed with the filter {}, which this HDF5 library lacks. Where the filter "
                     "is installed (pip install hdf5plugin), pack the file anew: h5repack -f "
                     "GZIP=4 FILE NEW",
                     *filter));
  }
  fail(dataset, "bad-hdf5", "cannot be read: " + reason);
}

Hdf5Links links_of(hid_t file) {
  Hdf5Links links;
  const herr_t result = H5Literate(
      file, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t* info, void* into) -> herr_t {
        auto& found = *static_cast<Hdf5Links*>(into);
        try {
          found.names.emplace_back(name);
        } catch (const std::exception&) {
          return -1;  // nothing may be thrown through the library
        }
        found.hard = info->type == H5L_TYPE_HARD;
        return found.hard ? 0 : 1;
      },
      &links);
  links.read = result >= 0;
  return links;
}

std::vector<std::string> Hdf5Source::datasets() const {
  Hdf5Links links = links_of(file_.id());
  if (!links.hard) {
    fail(links.names.back(), "foreign-link", "a soft or external link; only datasets are read");
  }
  if (!links.read) {
    refuse(name_, "", "bad-hdf5", "its list of datasets cannot be read: " + Hdf5Library::reason());
  }
  return std::move(links.names);
}

Hdf5Handle Hdf5Source::open_dataset(const std::string& dataset) const {
  Hdf5Handle opened(H5Dopen2(file_.id(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!opened.good()) fail_damaged(dataset);
  return opened;
}

void Hdf5Source::check_size(const std::string& dataset, const std::array<hsize_t, 2>& size) const {
  if (size[0] == 0 || size[1] == 0 || size[0] > kMostElements ||
      size[1] > kMostElements / size[0]) {
    fail(dataset, "bad-shape",
         fmt::format("{} x {} numbers, not 1 to {}", size[0], size[1], kMostElements));
  }
}

std::array<hsize_t, 2> Hdf5Source::size_of(const std::string& dataset,
                                           const Hdf5Handle& opened) const {
  const Hdf5Handle space(H5Dget_space(opened.id()), H5Sclose);
  if (!space.good()) fail_damaged(dataset);
  std::array<hsize_t, 2> size{};
  if (H5Sget_simple_extent_ndims(space.id()) != 2 ||
      H5Sget_simple_extent_dims(space.id(), size.data(), nullptr) != 2) {
    fail(dataset, "bad-shape", "not an array of views and dimensions");
  }
  check_size(dataset, size);
  return size;
}

void Hdf5Source::check_layout(const std::string& dataset, const Hdf5Handle& opened) const {
  if (H5Dget_storage_size(opened.id()) == 0) fail(dataset, "no-data", "a dataset without data");
  const Hdf5Handle made(H5Dget_create_plist(opened.id()), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(made.id());
  if (layout == H5D_VIRTUAL || H5Pget_external_count(made.id()) != 0) {
    fail(dataset, "foreign-link", "its data is in other files; only data in this file is read");
  }
  if (layout != H5D_CHUNKED) return;
  expect_chunks_of(made.id());
  std::array<hsize_t, 2> chunk{};
  if (H5Pget_chunk(made.id(), 2, chunk.data()) != 2) fail_damaged(dataset);
  check_size(dataset, chunk);
}

std::shared_ptr<const MappedFile> read_isolated(const std::filesystem::path& file,
                                                const std::function<void(SharedMemory&)>& copy) {
  const MappedFile readable(file);  // throws the system's reason, which the library does not give
  // A small file of zeros must not fill all memory.
  SharedMemory memory(file.string(), std::max<std::uint64_t>(
                                         kAlwaysUnpacked, kMostPacking * readable.bytes().size()));
  {
    const Hdf5Library library;
    run_isolated(file.string(), "bad-hdf5", [&] { copy(memory); });
  }
  return std::make_shared<const MappedFile>(memory.path());
}

bool Hdf5Library::prepare() {
  // A file that could not be closed, as the disk was full, stays open in the library. It would try
  // again when the program ends, and crash. All others are closed by Hdf5Handle.
  const bool done = H5dont_atexit() >= 0;
  register_lzf();
  return done;
}

std::mutex& Hdf5Library::mutex() {
  static std::mutex one;
  return one;
}

std::string Hdf5Library::reason() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned level, const H5E_error2_t* error, void* into) -> herr_t {
        // The innermost call gives the most exact reason.
        if (level == 0 && error->desc != nullptr) *static_cast<std::string*>(into) = error->desc;
        return 0;
      },
      &text);
  return text.empty() ? "the HDF5 library gives no reason" : text.substr(0, 300);
}

Hdf5Handle half_type() {
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  H5Tset_fields(type.id(), 15, 10, 5, 0, 10);
  H5Tset_size(type.id(), 2);
  H5Tset_ebias(type.id(), 15);
  return type;
}

// --- a forked copy ----------------------------------------------------------------------------

namespace {

[[noreturn]] void fail(const std::string& what, int reason) {
  throw FileError(fmt::format("{}: {}", what, std::generic_category().message(reason)));
}

// What the copy tells the first process: one of these letters, then texts, each followed by a 0.
constexpr char kDone = 'd', kInvalid = 'i', kUnreadable = 'u';

std::string outcome_of(const std::function<void()>& work) {
  std::string outcome;
  try {
    work();
    return {kDone};
  } catch (const InvalidInput& error) {
    outcome = kInvalid;
    for (const Diagnostic& d : error.diagnostics()) {
      for (const std::string& text : {d.file, d.where, d.code, d.message}) {
        outcome += text;
        outcome += '\0';
      }
    }
  } catch (const FileError& error) {
    outcome = kUnreadable;
    outcome += error.what();
    outcome += '\0';
  }
  return outcome;
}

[[noreturn]] void be_the_copy(SharedMemory& outcome, const std::function<void()>& work) {
  // A crash only tells that the file is damaged: handlers of the first process must not run, and no
  // core dump and no message should appear.
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) std::signal(signal, SIG_DFL);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  try {
    const std::string told = outcome_of(work);
    outcome.write_at(0, std::as_bytes(std::span(told)));
  } catch (...) {  // the outcome stays empty, as after a crash
  }
  _exit(0);  // without the first process's atexit handlers and static destructors
}

void rethrow(std::string_view outcome) {
  std::vector<std::string> texts;
  for (const auto text : std::views::split(outcome.substr(1), '\0')) {
    texts.emplace_back(text.begin(), text.end());
  }
  if (outcome[0] == kUnreadable && !texts.empty()) throw FileError(texts[0]);
  std::vector<Diagnostic> diagnostics;
  for (std::size_t i = 0; i + 4 <= texts.size(); i += 4) {
    diagnostics.push_back({Severity::kError, texts[i], texts[i + 1], texts[i + 2], texts[i + 3]});
  }
  throw InvalidInput(std::move(diagnostics));
}

}  // namespace

SharedMemory::SharedMemory(std::string file, std::uint64_t most)
    : file_(std::move(file)), most_(most), descriptor_(memfd_create("enfilade", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail(file_ + ": shared memory for its content cannot be made", errno);
}

SharedMemory::~SharedMemory() { close(descriptor_); }

void SharedMemory::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (bytes.size() > most_ || offset > most_ - bytes.size()) {
    throw FileError(fmt::format("{}: more than {} bytes of content, {} times the file's own", file_,
                                most_, kMostPacking));
  }
  while (!bytes.empty()) {
    const ssize_t written =
        pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno != EINTR) {
      fail(file_ + ": shared memory for its content cannot be written", errno);
    }
    if (written <= 0) continue;
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

std::string SharedMemory::path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

void run_isolated(const std::string& file, const std::string& code,
                  const std::function<void()>& work) {
  SharedMemory outcome(file);
  const pid_t copy = fork();
  if (copy < 0) fail(file + ": no process can be started to read it", errno);
  if (copy == 0) be_the_copy(outcome, work);
  while (waitpid(copy, nullptr, 0) < 0 && errno == EINTR) {
  }
  const std::string told = read_file(outcome.path());
  if (told == std::string(1, kDone)) return;
  if (!told.empty()) rethrow(told);
  refuse(file, "", code, "damaged: the process that read it crashed or was killed");
}

}  // namespace enfilade::features::formats
