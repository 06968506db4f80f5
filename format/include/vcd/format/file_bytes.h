// The bytes of a file: mapped, or copied into aligned memory.
#pragma once

#include <filesystem>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>

namespace vcd {

// Page-aligned. Errors: io, naming the file and the system's reason; runtime (out of memory).
class FileBytes {
 public:
  // A file that is truncated while it is mapped raises SIGBUS in whoever reads it.
  static Result<FileBytes> map(const std::filesystem::path& path);
  static Result<FileBytes> copy(const std::filesystem::path& path);

  FileBytes() = default;
  FileBytes(FileBytes&& other) noexcept { *this = std::move(other); }
  FileBytes& operator=(FileBytes&& other) noexcept;
  ~FileBytes();

  Bytes bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  size_t size_ = 0;
  bool mapped_ = false;
};

}  // namespace vcd
