#include <vcd/baker/source.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <xxhash.h>

#include "ingest/check.h"

namespace vcd::baker {
namespace {

// A regular file that is open for reading.
class InputFile {
 public:
  static Result<InputFile> open(const std::filesystem::path& path) {
    const auto fault = [&](const char* what) {
      return file_error(path, ErrorCode::io, std::string(what) + std::strerror(errno));
    };
    InputFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (file.descriptor_ < 0) return fault("cannot be opened: ");
    struct stat status {};
    if (::fstat(file.descriptor_, &status) != 0) return fault("cannot be measured: ");
    if (!S_ISREG(status.st_mode)) return file_error(path, ErrorCode::io, "is not a regular file");
    file.size_ = static_cast<size_t>(status.st_size);
    return file;
  }
  InputFile(InputFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}
  ~InputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  size_t size() const { return size_; }

  // Fills the buffer or comes to the end of the file; how much was read, or -1.
  ssize_t read(char* to, size_t size) {
    size_t done = 0;
    while (done < size) {
      const ssize_t got = ::read(descriptor_, to + done, std::min(size - done, size_t{1} << 30));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return -1;
      if (got == 0) break;
      done += static_cast<size_t>(got);
    }
    return static_cast<ssize_t>(done);
  }

 private:
  explicit InputFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
  size_t size_ = 0;
};

ContentHash canonical(XXH128_hash_t hash) {
  XXH128_canonical_t digest;
  XXH128_canonicalFromHash(&digest, hash);
  return std::to_array(digest.digest);
}

}  // namespace

ContentHash content_hash(std::string_view bytes) { return canonical(XXH3_128bits(bytes.data(), bytes.size())); }

Result<std::string> read_file(const std::filesystem::path& path) {
  Result<InputFile> file = InputFile::open(path);
  if (!file) return file.error();
  std::string bytes(file->size(), '\0');
  const ssize_t got = file->read(bytes.data(), bytes.size());
  if (got < 0) return file_error(path, ErrorCode::io, std::string("cannot be read: ") + std::strerror(errno));
  if (static_cast<size_t>(got) != bytes.size()) return file_error(path, ErrorCode::io, "shrank while it was read");
  return bytes;
}

Result<ContentHash> hash_file(const std::filesystem::path& path) {
  Result<InputFile> file = InputFile::open(path);
  if (!file) return file.error();
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<char> chunk(std::clamp<size_t>(file->size(), 1, size_t{1} << 20));
  for (;;) {
    const ssize_t got = file->read(chunk.data(), chunk.size());
    if (got < 0) return file_error(path, ErrorCode::io, std::string("cannot be read: ") + std::strerror(errno));
    if (got == 0) return canonical(XXH3_128bits_digest(state.get()));
    XXH3_128bits_update(state.get(), chunk.data(), static_cast<size_t>(got));
  }
}

}  // namespace vcd::baker
