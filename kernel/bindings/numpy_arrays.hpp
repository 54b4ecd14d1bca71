// NumPy arrays in and out of the kernel.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <vector>

#include "bindings/checks.hpp"

namespace rcac {

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

inline std::vector<double> copied(const Array& array, std::size_t size, const char* name) {
    require(array.size(), size, name);
    return std::vector<double>(array.data(), array.data() + size);
}

inline nb::ndarray<nb::numpy, double> to_numpy(std::vector<double> values,
                                               const std::vector<std::size_t>& shape) {
    auto* data = new std::vector<double>(std::move(values));
    nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    return nb::ndarray<nb::numpy, double>(data->data(), shape.size(), shape.data(), owner);
}

inline nb::ndarray<nb::numpy, double> to_numpy(const double* values, std::size_t size) {
    return to_numpy(std::vector<double>(values, values + size), {size});
}

}  // namespace rcac
