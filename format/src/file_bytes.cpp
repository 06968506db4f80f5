#include <vcd/format/file_bytes.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace vcd {
namespace {

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
};

Error system_error(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::io, path.string() + ": " + what + ": " + std::strerror(errno)};
}

constexpr std::align_val_t kAlignment{4096};

}  // namespace

FileBytes& FileBytes::operator=(FileBytes&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

FileBytes::~FileBytes() {
  if (mapped_) {
    munmap(const_cast<std::byte*>(data_), size_);
  } else if (data_) {
    ::operator delete[](const_cast<std::byte*>(data_), kAlignment);
  }
}

Result<FileBytes> FileBytes::map(const std::filesystem::path& path) {
  const Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.fd < 0) return system_error(path, "cannot open");
  struct stat status {};
  if (fstat(file.fd, &status) != 0) return system_error(path, "cannot read its size");
  if (!S_ISREG(status.st_mode)) return Error{ErrorCode::io, path.string() + ": cannot map: not a regular file"};
  FileBytes result;
  if (status.st_size == 0) return result;
  void* data = mmap(nullptr, static_cast<size_t>(status.st_size), PROT_READ, MAP_PRIVATE, file.fd, 0);
  if (data == MAP_FAILED) return system_error(path, "cannot map");
  result.data_ = static_cast<const std::byte*>(data);
  result.size_ = static_cast<size_t>(status.st_size);
  result.mapped_ = true;
  return result;
}

Result<FileBytes> FileBytes::copy(const std::filesystem::path& path) {
  const Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.fd < 0) return system_error(path, "cannot open");
  struct stat status {};
  if (fstat(file.fd, &status) != 0) return system_error(path, "cannot read its size");
  if (!S_ISREG(status.st_mode)) return Error{ErrorCode::io, path.string() + ": cannot read: not a regular file"};
  const size_t size = static_cast<size_t>(status.st_size);
  auto* data = new (kAlignment, std::nothrow) std::byte[std::max<size_t>(size, 1)];
  if (!data) return Error{ErrorCode::runtime, path.string() + ": out of memory for " + std::to_string(size) + " bytes"};
  FileBytes result;
  result.data_ = data;
  while (result.size_ < size) {
    const ssize_t got = ::read(file.fd, data + result.size_, size - result.size_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_error(path, "cannot read");
    if (got == 0) break;  // it shrank while we read: the header's size will not match
    result.size_ += static_cast<size_t>(got);
  }
  return result;
}

}  // namespace vcd
