// A file that appears whole or not at all.
#pragma once

#include <filesystem>
#include <string>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>

namespace vcd {

// Opens a temporary file beside `path`; commit() flushes and renames it over `path`; without commit, or on an error,
// the destructor removes it. One thread at a time.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  // After the first failure further calls do nothing; commit() reports it.
  void append(Bytes bytes);
  Result<uint64_t> commit();  // the file's size

 private:
  void fail(const char* what);

  std::filesystem::path path_;
  std::string temporary_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
  std::string failure_;
};

}  // namespace vcd
