// A file that appears whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>

namespace vcd {

// Writes beside `path`, into a file without a name where the system has such (O_TMPFILE), so that not even SIGKILL
// leaves one behind; else, and for the moment in which it replaces another, under the name .vcd-tmp-NUMBER. commit()
// flushes, has the bytes verified and gives the file its name, in place of what had it; who mapped that keeps it.
// Without commit, or on an error, the destructor removes it. One thread at a time; any number of writers of one path:
// the last wins.
//
// Links: an output is never written through a symbolic link, because whoever may place a link in a folder could have
// any file overwritten that this user may write. The one exception are links to files that begin with `kind`, the first
// bytes of what is written: then the file behind the link is replaced, and the link stays.
class AtomicFile {
 public:
  // What is wrong with the bytes as they lie on the disk; empty if nothing is.
  using Verify = std::function<std::string(Bytes)>;

  // Finds out at once what keeps the file from being written, as far as that can be known beforehand: a folder that is
  // missing or cannot be written, a name that is too long, a folder or device in its place, a link.
  // kind  by default no link is followed
  explicit AtomicFile(std::filesystem::path path, std::string_view kind = {});
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  // What has gone wrong so far (code io); nothing if nothing has.
  std::optional<Error> fault() const;

  // After the first failure further calls do nothing; commit() reports it.
  void append(Bytes bytes);
  Result<uint64_t> commit(const Verify& verify = {});  // the file's size

 private:
  void fail(const char* what);
  void follow_link(std::string_view kind);
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
