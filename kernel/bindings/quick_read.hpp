// Signals as Python hands them over, read without a detour through NumPy where that is possible.
#pragma once

#include <cstdint>
#include <vector>

#include "bindings/numpy_arrays.hpp"
#include "updates/update.hpp"

namespace rcac {

// A float or an int of Python; false for anything else, a bool and an int beyond float64 too.
inline bool quick_number(PyObject* object, double& out) {
    if (!PyFloat_Check(object) && !PyLong_CheckExact(object)) return false;
    out = PyFloat_AsDouble(object);
    if (out == -1.0 && PyErr_Occurred()) {
        PyErr_Clear();
        return false;
    }
    return true;
}

// Numbers of another type than float64; integers only where float64 holds them exactly.
template <class Number>
bool quick_convert(const Number* from, std::vector<double>& out) {
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = static_cast<double>(from[i]);
        if (!(out[i] >= -9007199254740992.0 && out[i] <= 9007199254740992.0)) return false;
    }
    return true;
}

// Whatever gives its memory away as an array of real numbers, NumPy's scalars included.
inline bool quick_array(nb::handle value, std::vector<double>& out) {
    nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu> array;
    if (!nb::try_cast(value, array, false) || array.size() != out.size()) return false;
    const nb::dlpack::dtype type = array.dtype();
    const void* data = array.data();
    if (type == nb::dtype<double>()) {
        std::copy_n(static_cast<const double*>(data), out.size(), out.begin());
        return true;
    }
    if (type == nb::dtype<float>()) return quick_convert(static_cast<const float*>(data), out);
    if (type == nb::dtype<std::int64_t>())
        return quick_convert(static_cast<const std::int64_t*>(data), out);
    if (type == nb::dtype<std::int32_t>())
        return quick_convert(static_cast<const std::int32_t*>(data), out);
    if (type == nb::dtype<std::int16_t>())
        return quick_convert(static_cast<const std::int16_t*>(data), out);
    if (type == nb::dtype<std::uint16_t>())
        return quick_convert(static_cast<const std::uint16_t*>(data), out);
    if (type == nb::dtype<std::uint8_t>())
        return quick_convert(static_cast<const std::uint8_t*>(data), out);
    return false;
}

// `value` as `out.size()` finite numbers: a float, an int, a flat list or tuple of them, or an
// array of real numbers; with `gaps` some may be no finite numbers. False for anything else; the caller then reads it with care and says what
// is wrong. None is no number at all.
inline bool quick_read(nb::handle value, std::vector<double>& out, bool gaps = false) {
    if (value.is_none()) return out.empty();
    PyObject* object = value.ptr();
    if (PyList_CheckExact(object) || PyTuple_CheckExact(object)) {
        const bool is_list = PyList_CheckExact(object);
        const Py_ssize_t size = is_list ? PyList_Size(object) : PyTuple_Size(object);
        if (static_cast<std::size_t>(size) != out.size()) return false;
        for (Py_ssize_t i = 0; i < size; ++i) {
            PyObject* item = is_list ? PyList_GetItem(object, i) : PyTuple_GetItem(object, i);
            if (!quick_number(item, out[static_cast<std::size_t>(i)])) return false;
        }
    } else if (PyFloat_Check(object) || PyLong_CheckExact(object)) {
        if (out.size() != 1 || !quick_number(object, out[0])) return false;
    } else if (!nb::ndarray_check(value) || !quick_array(value, out)) {
        return false;
    }
    return gaps || finite(out.data(), out.size());
}

}  // namespace rcac
