// How vcd reports what went wrong: a code that is also the process exit code, and a message that names the
// file, the place and the reason. Apart from std::bad_alloc where a comment says so,
// no exception leaves format or runtime.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace vcd {

// The numeric value is the exit code of the command line programs.
enum class ErrorCode : int {
  usage = 1,         // the caller asked for something that makes no sense
  io = 2,            // a file could not be opened, read, written or renamed
  invalid_file = 3,  // the bytes break their format
  runtime = 4,       // out of memory, a crashed or timed-out child process, a bug
  unsupported = 5,   // a valid file that uses something this version does not handle
  difference = 7,    // two things that must agree do not
  stale = 8,         // a sidecar made from another mesh
};

struct Error {
  ErrorCode code = ErrorCode::runtime;
  std::string message;
};

// Either a value or an Error. Test it before use; taking the wrong side is a programming error
// (an assertion fails).
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() { return assert(ok()), *std::get_if<0>(&state_); }
  const T& value() const { return assert(ok()), *std::get_if<0>(&state_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  Error& error() { return assert(!ok()), *std::get_if<1>(&state_); }
  const Error& error() const { return assert(!ok()), *std::get_if<1>(&state_); }

 private:
  std::variant<T, Error> state_;
};

}  // namespace vcd
