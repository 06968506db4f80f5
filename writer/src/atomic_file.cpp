#include <vcd/writer/atomic_file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <random>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vcd {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrefix = ".vcd-tmp-";

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

std::string fresh_name(const fs::path& folder) {
  return (folder / (kPrefix + std::to_string(std::random_device()()))).string();
}

std::string path_of(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

bool begins_with(const fs::path& path, std::string_view kind) {
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return false;
  struct stat status {};
  std::string begin(kind.size(), '\0');
  const bool same = fstat(file, &status) == 0 && S_ISREG(status.st_mode) &&
                    pread(file, begin.data(), begin.size(), 0) == static_cast<ssize_t>(kind.size()) && begin == kind;
  close(file);
  return same;
}

}  // namespace

AtomicFile::AtomicFile(fs::path path, std::string_view kind) : path_(std::move(path)) {
  struct stat status {};
  if (lstat(path_.c_str(), &status) == 0) {
    if (S_ISLNK(status.st_mode)) follow_link(kind);
    else if (!S_ISREG(status.st_mode)) failure_ = path_.string() + ": cannot be replaced: not a regular file";
  } else if (errno != ENOENT) {
    fail("cannot be written");
  }
  if (!failure_.empty()) return;
  open_without_name(folder_of(path_));
  if (descriptor_ < 0) open_temporary(folder_of(path_));
}

void AtomicFile::follow_link(std::string_view kind) {
  std::error_code error;
  const fs::path target = fs::canonical(path_, error);
  if (!error && !kind.empty() && begins_with(target, kind)) {
    path_ = target;
    return;
  }
  const fs::path named = fs::read_symlink(path_, error);
  failure_ = path_.string() + ": is a link to " + named.string() + "; nothing is written through it" +
             (kind.empty() ? "" : ", because no file of the kind to be written is there");
}

void AtomicFile::open_without_name(const fs::path& folder) {
  descriptor_ = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (descriptor_ < 0) return;
  flock(descriptor_, LOCK_EX);  // for the moment in which it has a temporary name
  if (access(path_of(descriptor_).c_str(), F_OK) == 0) return;
  close(descriptor_);  // without /proc it could not be given a name
  descriptor_ = -1;
}

void AtomicFile::open_temporary(const fs::path& folder) {
  for (;;) {
    temporary_ = fresh_name(folder);
    // open() rather than mkstemp(), so that the file gets the permissions that the user's umask asks for.
    descriptor_ = open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno == EEXIST) continue;
    if (descriptor_ < 0) {
      temporary_.clear();
      return fail("cannot create a temporary file beside it");
    }
    flock(descriptor_, LOCK_EX);  // waits for one who takes it for stale
    struct stat status {};
    if (fstat(descriptor_, &status) != 0 || status.st_nlink > 0) return;
    close(descriptor_);  // it was taken for stale, and removed
  }
}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) unlink(temporary_.c_str());
  if (descriptor_ >= 0) close(descriptor_);
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

void AtomicFile::verify_with(const Verify& verify) {
  posix_fadvise(descriptor_, 0, 0,
                POSIX_FADV_DONTNEED);  // so that they come from the disk, not from the memory that we filled
  void* const data = size_ == 0 ? nullptr : mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor_, 0);
  if (data == MAP_FAILED) return fail("cannot be read back");
  const std::string fault = verify(Bytes(static_cast<const std::byte*>(data), size_));
  if (data) munmap(data, size_);
  if (!fault.empty()) failure_ = path_.string() + ": what was written does not read back: " + fault;
}

void AtomicFile::give_name() {
  if (temporary_.empty()) {
    const std::string unnamed = path_of(descriptor_);
    if (linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, path_.c_str(), AT_SYMLINK_FOLLOW) == 0) return;
    if (errno != EEXIST) return fail("cannot be given its name");
    do {  // no system call puts a file without a name in the place of another
      temporary_ = fresh_name(folder_of(path_));
    } while (linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0 &&
             errno == EEXIST);
  }
  if (rename(temporary_.c_str(), path_.c_str()) != 0) return fail("cannot rename the temporary file to it");
  temporary_.clear();
}

std::optional<Error> AtomicFile::fault() const {
  if (failure_.empty()) return std::nullopt;
  return Error{ErrorCode::io, failure_};
}

Result<uint64_t> AtomicFile::commit(const Verify& verify) {
  if (failure_.empty() && fsync(descriptor_) != 0) fail("cannot flush to disk");
  if (failure_.empty() && verify) verify_with(verify);
  if (failure_.empty()) give_name();
  if (!failure_.empty()) return Error{ErrorCode::io, failure_};
  // The new name is durable only once the folder is; a folder that cannot be flushed is no reason to fail.
  if (const int d = open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); d >= 0) {
    fsync(d);
    close(d);
  }
  return size_;
}

size_t remove_stale_temporaries(const fs::path& folder) {
  size_t removed = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const fs::path& path = entry->path();
    if (!path.filename().string().starts_with(kPrefix)) continue;
    const int file = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0 && unlink(path.c_str()) == 0) ++removed;
    close(file);
  }
  return removed;
}

}  // namespace vcd
