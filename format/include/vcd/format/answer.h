// The answer: what the class of a line's cell and the place of a segment on that line say together. This is the one
// place that decides it. Scalar code calls an AnswerTable, SIMD code selects its rows; the bakers' proofs and the
// runtime's look-ups mean the same classes by it. Normative text: spec/vcd-format.md, "The answer".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <vcd/format/layout.h>
#include <vcd/format/line_cell.h>
#include <vcd/format/segment.h>

namespace vcd {

// What is known of all lines of a cell. The numbers are those in the file, two bits a cell.
enum class CellClass : uint8_t {
  clear = 0,                 // proven, or sampled: no line of the cell meets the object
  blocked = 1,               // proven, or sampled: every line of the cell meets the object
  unclassified = 2,          // nothing is known
  statistically_blocked = 3  // samples say blocked, no proof does
};
inline constexpr uint32_t kClasses = 4;

// A set of classes: bit c stands for class c.
using ClassSet = uint32_t;
constexpr ClassSet just(CellClass c) { return 1u << static_cast<uint32_t>(c); }
inline constexpr ClassSet kAllClasses = (1u << kClasses) - 1;

// Where a segment stands to the object's box.
enum class Place : uint8_t {
  doubtful = 0,     // the line is not valid (LineCell::valid)
  outside = 1,      // the segment has no point inside the box
  ends_inside = 2,  // it begins or ends inside, at or behind the surface for all that is known
  pierces = 3,      // it contains all of its line's way through the box, but perhaps ends that meet no triangle
};
inline constexpr uint32_t kPlaces = 4;

// Whether statistics count as an answer.
enum class Trust : uint8_t { proofs, statistics };

// The rule. Everything else in this file, and every kernel, is derived from it.
constexpr Visibility answer(Place place, CellClass cell, Trust trust) {
  if (place == Place::doubtful) return Visibility::unclassified;
  if (place == Place::outside || cell == CellClass::clear) return Visibility::clear;
  const bool counts =
      cell == CellClass::blocked || (cell == CellClass::statistically_blocked && trust == Trust::statistics);
  return place == Place::pierces && counts ? Visibility::blocked : Visibility::unclassified;
}

// The rule as a table, for one tree.
struct AnswerTable {
  // rows[place] holds the answers to the four classes, two bits each, class 0 lowest.
  std::array<uint32_t, kPlaces> rows;

  // Rows whose answer does not depend on the cell: the cell need not be read.
  static constexpr uint32_t kAllClear = 0b00'00'00'00u, kAllUnclassified = 0b10'10'10'10u;
  static constexpr bool is_constant(uint32_t row) { return row == kAllClear || row == kAllUnclassified; }

  constexpr uint32_t row(Place place) const { return rows[static_cast<size_t>(place)]; }
  static constexpr Visibility of_row(uint32_t row, CellClass cell) {
    return static_cast<Visibility>(row >> (2 * static_cast<uint32_t>(cell)) & 3u);
  }
  constexpr Visibility operator()(Place place, CellClass cell) const { return of_row(row(place), cell); }

  bool operator==(const AnswerTable&) const = default;
};

// The table of a tree whose cells have no other classes than `present`. A row in which none of these would be answered
// is all unclassified.
constexpr AnswerTable answer_table(Trust trust, ClassSet present = kAllClasses) {
  AnswerTable table{};
  for (uint32_t p = 0; p < kPlaces; ++p) {
    bool answers = p == static_cast<uint32_t>(Place::outside);
    for (uint32_t c = 0; c < kClasses; ++c) {
      const Visibility a = answer(static_cast<Place>(p), static_cast<CellClass>(c), trust);
      table.rows[p] |= static_cast<uint32_t>(a) << (2 * c);
      answers |= a != Visibility::unclassified && (present >> c & 1);
    }
    if (!answers) table.rows[p] = AnswerTable::kAllUnclassified;
  }
  return table;
}

// Where a segment of this line stands to the box, its ends taken as they are.
constexpr Place place_of(const LineCell& line, float t_min, float t_max) {
  const uint32_t outside = !line.hits | (t_min >= line.t_exit) | (t_max <= line.t_entry);
  const uint32_t pierces = (t_min <= line.t_entry) & (t_max >= line.t_exit);
  const uint32_t of_valid = ((2 + pierces) & (outside - 1)) | outside;  // masks: this is asked of every segment
  return static_cast<Place>(of_valid & (0 - uint32_t{line.valid}));
}

// The square of a point on a face; first and second are its coordinates there, 0 … 255.
constexpr uint32_t clearance_square(uint32_t face, uint32_t first, uint32_t second) {
  return face * kClearanceSquares * kClearanceSquares + (first >> 4) * kClearanceSquares + (second >> 4);
}

// Whether a segment leaves out no more of its line's way through the box than the clearances at both ends allow. A line
// crosses at most kGrid units of each coordinate on its way, so c / kGrid of the way stays within a clearance of c.
// False for an empty segment, even where a file claims that clearances overlap, which no mesh allows. clearances:
// kClearanceBytes bytes (<vcd/format/layout.h>). The line hits the box.
constexpr bool within_clearances(const uint8_t* clearances, const LineCell& line, float t_min, float t_max) {
  const auto [low, high] = kFacePair[line.pair];
  const float at_low = static_cast<float>(clearances[clearance_square(low, line.s, line.t)]) * (1 / kGrid);
  const float at_high = static_cast<float>(clearances[clearance_square(high, line.u, line.v)]) * (1 / kGrid);
  const float way = line.t_exit - line.t_entry;
  return (t_min < t_max) & (t_min - line.t_entry <= (line.swapped ? at_high : at_low) * way) &
         (line.t_exit - t_max <= (line.swapped ? at_low : at_high) * way);
}

// `place`, but a segment that ends within the clearances pierces. clearances: null where none are known.
constexpr Place widened(Place place, const uint8_t* clearances, const LineCell& line, float t_min, float t_max) {
  if (place != Place::ends_inside || !clearances) return place;
  return within_clearances(clearances, line, t_min, t_max) ? Place::pierces : Place::ends_inside;
}

}  // namespace vcd
