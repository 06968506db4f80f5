// Arrays of Python as the libraries take them, and errors of the libraries as Python raises them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vcd/format/error.h>
#include <vcd/format/segment.h>

namespace vcd::python {

namespace py = pybind11;

// Throws the exception of vcd/records.py that belongs to the error's code.
[[noreturn]] void raise(const Error& error);

template <class T>
T value_or_raise(Result<T>&& result) {
  if (!result) raise(result.error());
  return std::move(result.value());
}

// "float64 array of shape (5, 8)", for messages.
std::string shape_text(const py::array& array);

// Throws TypeError unless the array is C-contiguous and of T; ValueError unless it has these sizes. -1: any.
template <class T>
void require(const py::array& array, std::initializer_list<py::ssize_t> shape, const char* name, const char* expected) {
  const auto refuse = [&] { return std::string(name) + ": " + expected + "; got " + shape_text(array); };
  if (!py::isinstance<py::array_t<T>>(array)) throw py::type_error(refuse());
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  for (size_t i = 0; fits && i < shape.size(); ++i)
    fits = shape.begin()[i] == -1 || shape.begin()[i] == array.shape(static_cast<py::ssize_t>(i));
  if (!fits) throw py::value_error(refuse());
  constexpr int kInPlace = int{py::array::c_style} | int{py::detail::npy_api::NPY_ARRAY_ALIGNED_};
  if ((array.flags() & kInPlace) != kInPlace)
    throw py::value_error(refuse() + " that is not C-contiguous or not aligned: see numpy.require");
}

// The array's own memory.
template <class T>
std::span<const T> values_of(const py::array& array, std::initializer_list<py::ssize_t> shape, const char* name,
                             const char* expected) {
  require<T>(array, shape, name, expected);
  return {static_cast<const T*>(array.data()), static_cast<size_t>(array.size())};
}

std::span<const Segment> segments_of(const py::array& array);
// Whatever NumPy makes floats of: for what is small.
using Numbers = py::array_t<float, py::array::c_style | py::array::forcecast>;
std::array<float, 3> vector_of(const Numbers& array, const char* name);  // shape (3,)

// One byte for each of count bits.
py::array_t<bool> bools_of(std::span<const uint64_t> bits, size_t count);

py::bytes bytes_of_hash(const std::array<uint8_t, 16>& hash);
std::array<uint8_t, 16> hash_of(const py::bytes& bytes);

}  // namespace vcd::python
