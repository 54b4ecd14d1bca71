// Signals as Python hands them over, read without a detour through NumPy where that is possible.
#pragma once

#include <vector>

#include "bindings/numpy_arrays.hpp"
#include "updates/update.hpp"

namespace rcac {

// `value` as `out.size()` finite numbers: a float, an int, or a float64 array. False for anything
// else; the caller then reads it with care and says what is wrong. None is no number at all.
inline bool quick_read(nb::handle value, std::vector<double>& out) {
    if (value.is_none()) return out.empty();
    PyObject* object = value.ptr();
    if (PyFloat_Check(object) || PyLong_CheckExact(object)) {
        if (out.size() != 1) return false;
        out[0] = PyFloat_AsDouble(object);
        if (PyErr_Occurred()) {  // an integer beyond float64
            PyErr_Clear();
            return false;
        }
    } else {
        Array array;
        if (!nb::ndarray_check(value) || !nb::try_cast(value, array, false) ||
            array.size() != out.size())
            return false;
        std::copy_n(array.data(), out.size(), out.begin());
    }
    return finite(out.data(), out.size());
}

}  // namespace rcac
