// Changes the JSON or the binary chunk of a GLB and makes the lengths fit again; other bytes as libFuzzer likes.
#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "fuzz/fuzz.h"

namespace vcd::fuzz {
namespace {

constexpr size_t kHeader = 12, kChunkHeader = 8;
constexpr uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;

uint32_t word_at(const uint8_t* data, size_t offset) {
  uint32_t word;
  std::memcpy(&word, data + offset, sizeof word);
  return word;
}

using Chunk = std::vector<uint8_t>;

// JSON and binary chunk, if there are two at most and all lengths are right.
bool split(const uint8_t* data, size_t size, Chunk (&chunks)[2]) {
  if (size < kHeader || std::memcmp(data, "glTF", 4) != 0) return false;
  size_t offset = kHeader;
  for (Chunk& chunk : chunks) {
    if (offset == size) return true;
    if (size - offset < kChunkHeader) return false;
    const size_t length = word_at(data, offset);
    offset += kChunkHeader;
    if (length > size - offset) return false;
    chunk.assign(data + offset, data + offset + length);
    offset += length;
  }
  return offset == size;
}

void append_word(Chunk& file, uint32_t word) {
  const auto* bytes = reinterpret_cast<const uint8_t*>(&word);
  file.insert(file.end(), bytes, bytes + sizeof word);
}

Chunk join(const Chunk (&chunks)[2]) {
  Chunk file = {'g', 'l', 'T', 'F'};
  append_word(file, 2);
  append_word(file, static_cast<uint32_t>(kHeader + 2 * kChunkHeader + chunks[0].size() + chunks[1].size()));
  for (size_t i = 0; i < 2; ++i) {
    append_word(file, static_cast<uint32_t>(chunks[i].size()));
    append_word(file, i == 0 ? kJson : kBinary);
    file.insert(file.end(), chunks[i].begin(), chunks[i].end());
  }
  return file;
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned int seed) {
  using namespace vcd::fuzz;
  Chunk chunks[2];
  if (seed % 16 == 0 || !split(data, size, chunks)) return LLVMFuzzerMutate(data, size, max_size);
  Chunk& chunk = chunks[seed / 16 % 4 == 0];
  const size_t before = chunk.size(), room = max_size - std::min(max_size, size) + before;
  chunk.resize(std::max<size_t>(room, 1));
  chunk.resize(LLVMFuzzerMutate(chunk.data(), before, chunk.size()));
  const Chunk file = join(chunks);
  if (file.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, file.data(), file.size());
  return file.size();
}
