#include <vcd/format/atomic_file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <random>

#include <fcntl.h>
#include <unistd.h>

namespace vcd {

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  // Where the path is a link, the file behind it is replaced, not the link.
  std::error_code ignored;
  if (std::filesystem::is_symlink(path_, ignored)) {
    const auto target = std::filesystem::weakly_canonical(path_, ignored);
    if (!ignored) path_ = target;
  }
  if (std::filesystem::exists(path_, ignored) && !std::filesystem::is_regular_file(path_, ignored)) {
    failure_ = path_.string() + ": cannot be replaced: not a regular file";
    return;
  }
  // open() rather than mkstemp(), so that the file gets the permissions that the user's umask asks for.
  std::random_device random;
  do {
    temporary_ = (path_.parent_path() / (".vcd-tmp-" + std::to_string(random()))).string();
    descriptor_ = open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) {
    fail("cannot create a temporary file beside it");
    temporary_.clear();
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

void AtomicFile::fail(const char* what) {
  if (failure_.empty()) failure_ = path_.string() + ": " + what + ": " + std::strerror(errno);
}

void AtomicFile::append(Bytes bytes) {
  while (failure_.empty() && !bytes.empty()) {
    const size_t piece = std::min<size_t>(bytes.size(), size_t{1} << 30);
    const ssize_t written = write(descriptor_, bytes.data(), piece);
    if (written < 0) {
      if (errno == EINTR) continue;
      return fail("cannot write");
    }
    size_ += static_cast<uint64_t>(written);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

Result<uint64_t> AtomicFile::commit() {
  if (failure_.empty() && fsync(descriptor_) != 0) fail("cannot flush to disk");
  if (failure_.empty() && rename(temporary_.c_str(), path_.c_str()) != 0) fail("cannot rename the temporary file to it");
  if (!failure_.empty()) return Error{ErrorCode::io, failure_};
  temporary_.clear();
  // The new name is durable only once the folder is; a folder that cannot be flushed is no reason to fail.
  const std::string folder = path_.has_parent_path() ? path_.parent_path().string() : ".";
  if (const int d = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); d >= 0) {
    fsync(d);
    close(d);
  }
  return size_;
}

}  // namespace vcd
