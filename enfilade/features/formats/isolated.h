/// \file  Running code that may crash in a forked copy of the process.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace enfilade::features::formats {

/// Memory that a process shares with its forked copies.
class SharedMemory {
 public:
  /// 0 bytes. \param file whose content it will hold, for messages \throws FileError
  explicit SharedMemory(std::string file);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);  ///< \throws FileError
  std::string path() const;  ///< to map it by, while this object exists

 private:
  std::string file_;
  int descriptor_;
};

/// Runs `work` in a forked copy of this process. The copy has the calling thread only, so `work`
/// must not wait for another. Only its output to SharedMemory is kept; its other changes of memory
/// and its output are lost.
/// \param file that it reads, for messages
/// \throws the InvalidInput or FileError that `work` throws
/// \throws InvalidInput with `code` if the copy crashes, is killed, or throws another error
void run_isolated(const std::string& file, const std::string& code,
                  const std::function<void()>& work);

}  // namespace enfilade::features::formats
