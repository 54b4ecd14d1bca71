// Numbers and objects from Python, checked before anything is computed with them.
//
// The packages above check what their users give and say it in their users' words. Whoever calls
// this module directly gets a sentence too: no argument may lead beyond an array, into a division
// by zero or to a null pointer.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "memory/archive.hpp"

namespace nb = nanobind;

namespace rcac {

constexpr std::size_t most_signals = std::size_t{1} << 20;   // of u, y, z, r, w or x
constexpr std::size_t most_numbers = std::size_t{1} << 28;   // in one array: 2 GB
constexpr std::size_t most_steps = std::size_t{1} << 36;     // of one run

inline void refuse_unless(bool fine, const std::string& sentence) {
    if (!fine) throw std::invalid_argument(sentence);
}

inline void require(std::size_t found, std::size_t wanted, const char* name) {
    refuse_unless(found == wanted, std::string(name) + ": " + std::to_string(found) +
                                       " numbers where " + std::to_string(wanted) + " belong");
}

template <class Number>
void require_range(Number value, Number least, Number most, const char* name) {
    refuse_unless(value >= least && value <= most,  // false for NaN
                  std::string(name) + " is " + std::to_string(value) + "; a number from " +
                      std::to_string(least) + " to " + std::to_string(most) + " is needed");
}

inline void require_width(std::size_t width, std::size_t least, const char* name) {
    require_range(width, least, most_signals, name);
}
inline void require_step(std::int64_t step, const char* name) {
    require_range<std::int64_t>(step, 0, Archive::longest, name);
}
inline void require_forgetting(double lambda, const char* name) {
    refuse_unless(lambda > 0.0 && lambda <= 1.0, std::string(name) + " lies outside (0, 1]");
}

// The product, where an array of that length may be made.
inline std::size_t length_of(std::initializer_list<std::size_t> factors, const char* name) {
    std::size_t length = 1;
    for (std::size_t factor : factors) {
        refuse_unless(factor == 0 || length <= most_numbers / factor,
                      std::string(name) + " would need more than " +
                          std::to_string(most_numbers) + " numbers");
        length *= factor;
    }
    return length;
}

template <class T>
T read(nb::handle value, const char* name, const char* wanted) {
    T result;
    if (!nb::try_cast<T>(value, result))
        throw nb::type_error((std::string(name) + " is not " + wanted).c_str());
    return result;
}

// One of this module's own objects; None is none.
template <class T>
T& object_of(nb::handle value, const char* name) {
    T* pointer = nullptr;
    if (!nb::try_cast<T*>(value, pointer) || !pointer)
        throw nb::type_error((std::string("this is not a ") + name).c_str());
    return *pointer;
}

}  // namespace rcac
