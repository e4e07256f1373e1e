/// \file  Work that may crash, done where that harms nobody.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace enfilade::features::formats {

/// Bytes in memory that a process shares with its copies.
class SharedMemory {
 public:
  SharedMemory();  ///< empty. \throws FileError
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);  ///< \throws FileError
  std::string path() const;  ///< to map it by, as long as this object is there

 private:
  int descriptor_;
};

/// Runs `work` in a copy of this process, which has the calling thread only, so `work` may wait for
/// no other. What it does to memory is lost, but for SharedMemory; what it prints is, too.
/// \param file that it reads, for messages
/// \throws the InvalidInput or FileError that `work` throws; InvalidInput `code` if the copy does
/// not come to its end, whatever becomes of it
void run_isolated(const std::string& file, const std::string& code,
                  const std::function<void()>& work);

}  // namespace enfilade::features::formats
