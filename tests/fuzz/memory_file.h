// A file that takes no disk, under a path with the extension that ingest() goes by.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "fuzz/fuzz.h"

namespace vcd::fuzz {

// The path is a symbolic link, in a folder of its own that goes with the object, to a memory file.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& name) : file_(::memfd_create("vcd-fuzz", MFD_CLOEXEC)) {
    std::string folder = (std::filesystem::temp_directory_path() / "vcd-fuzz-XXXXXX").string();
    require(file_ >= 0 && ::mkdtemp(folder.data()) != nullptr, "the system gives a memory file and a folder");
    path_ = std::filesystem::path(folder) / name;
    std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(file_), path_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    std::error_code ignored;
    std::filesystem::remove_all(path_.parent_path(), ignored);
    ::close(file_);
  }

  // Leaves the descriptor at the file's start.
  void fill(const uint8_t* data, size_t size) const {
    require(::ftruncate(file_, 0) == 0 && ::pwrite(file_, data, size, 0) == static_cast<ssize_t>(size) &&
                ::lseek(file_, 0, SEEK_SET) == 0,
            "the system writes to a memory file");
  }
  std::string content() const {
    std::string bytes(static_cast<size_t>(::lseek(file_, 0, SEEK_END)), '\0');
    require(::pread(file_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
            "the system reads a memory file");
    return bytes;
  }
  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return file_; }

 private:
  int file_;
  std::filesystem::path path_;
};

}  // namespace vcd::fuzz
