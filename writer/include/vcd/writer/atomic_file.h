// A file that appears whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>

namespace vcd {

// Writes beside `path`, into a file without a name where the system has such (O_TMPFILE), so that not even SIGKILL
// leaves one behind; else, and for the moment in which it replaces another, under the name .vcd-tmp-NUMBER. commit()
// flushes, has the bytes verified and gives the file its name, in place of what had it; who mapped that keeps it.
// Without commit, or on an error, the destructor removes it. One thread at a time; any number of writers of one path:
// the last wins.
class AtomicFile {
 public:
  // What is wrong with the bytes as they lie on the disk; empty if nothing is.
  using Verify = std::function<std::string(Bytes)>;

  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  // After the first failure further calls do nothing; commit() reports it.
  void append(Bytes bytes);
  Result<uint64_t> commit(const Verify& verify = {});  // the file's size

 private:
  void fail(const char* what);
  void open_without_name(const std::filesystem::path& folder);
  void open_temporary(const std::filesystem::path& folder);
  void verify_with(const Verify& verify);
  void give_name();

  std::filesystem::path path_;
  std::string temporary_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
  std::string failure_;
};

// Removes the temporary files of writers that were killed. Those of living writers are locked and stay. Returns how
// many it removed.
size_t remove_stale_temporaries(const std::filesystem::path& folder);

}  // namespace vcd
