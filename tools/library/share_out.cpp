#include <vcd/library/share_out.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace vcd::library {
namespace {

struct Portion {
  double worth;
  size_t object;
  uint64_t bytes;
};

// An object's bytes in the order in which it fills them. What is worth more than what comes before it is worth as much:
// it cannot be had without.
void add_portions(size_t object, const std::vector<baker::WorthOfBytes>& worth, std::vector<Portion>& portions) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i + 1 < worth.size(); ++i) {
    least = std::min(least, worth[i].asked_a_byte);
    if (worth[i + 1].bytes > worth[i].bytes) portions.push_back({least, object, worth[i + 1].bytes - worth[i].bytes});
  }
}

}  // namespace

std::optional<std::vector<uint64_t>> share_out(uint64_t total, std::span<const WantedBytes> wanted) {
  std::vector<uint64_t> shares;
  std::vector<Portion> portions;
  for (const WantedBytes& w : wanted) {
    if (w.least > total) return std::nullopt;
    total -= w.least;
    shares.push_back(w.least);
    add_portions(shares.size() - 1, w.worth, portions);
  }
  std::ranges::stable_sort(portions, std::greater(), &Portion::worth);
  for (const Portion& portion : portions) {
    const uint64_t given = std::min(portion.bytes, total);
    shares[portion.object] += given, total -= given;
  }
  return shares;
}

}  // namespace vcd::library
